//! Skins (glTF 2.0 §3.7.3): a vertex goes where Σ wⱼ · world(jointⱼ) · inverseBindⱼ takes it.
//!
//! The transform of the node that wears the skin plays no part, so a skinned mesh is in world space. Any number of
//! influences is summed, and the sum divided by that of the weights. Normals go with the cofactor matrix, which also
//! holds for uneven, mirrored and flattened joints. Where the joints mirror a whole primitive its triangles and normals
//! are turned over, as those of a mirrored node are, so that outside stays outside.

use glam::{DAffine3, DMat3, DMat4, DVec3, Mat3, Mat4};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::pose::{Pose, SkinPose};
use super::primitive::{Influences, Primitive};

/// Sums of weights that are off by more than this are worth a warning; four weights in bytes may be off by 2/255.
const WEIGHT_TOLERANCE: f32 = 1e-2;

/// What the influences on a vertex add up to.
#[derive(Clone, Copy, Debug)]
struct Blend {
    sum: Mat4,
    weight: f32,
}

impl Loader<'_> {
    /// The joint matrices of a skin; `None`, with a warning, if it cannot be used.
    pub(crate) fn skin(&mut self, skin: usize, from: &str) -> Result<Option<Vec<Mat4>>, AssetError> {
        let json = self.entry("skins", skin, from)?;
        let joints = json.array("joints")?;
        if joints.is_empty() {
            self.invalid(json.pointer(), "has no joints; the skin is ignored")?;
            return Ok(None);
        }
        if let Some(root) = json.usize("skeleton")?
            && let Err(e) = self.entry("nodes", root, &json.pointer_to("skeleton"))
        {
            self.invalid(&json.pointer_to("skeleton"), e.message())?;
        }
        let inverse = match json.usize("inverseBindMatrices")? {
            Some(index) => {
                let pointer = json.pointer_to("inverseBindMatrices");
                let accessor = self.accessor(index, &pointer)?;
                if accessor.shape != (4, 4) || accessor.count < joints.len() {
                    self.invalid(&pointer, "there is not one MAT4 for each joint; the skin is ignored")?;
                    return Ok(None);
                }
                self.spend_pose(accessor.count, &pointer)?;
                accessor.floats::<16>()
            }
            None => Vec::new(),
        };
        let mut matrices = Vec::with_capacity(joints.len());
        for (i, joint) in joints.iter().enumerate() {
            let index = joint.as_usize()?;
            self.entry("nodes", index, joint.pointer())?;
            let world = self.joint_world(index, joint.pointer())?;
            let bind = inverse.get(i).map_or(Mat4::IDENTITY, Mat4::from_cols_array);
            let matrix = (DMat4::from(world) * bind.as_dmat4()).as_mat4();
            if !matrix.is_finite() {
                self.warn(joint.pointer(), "the joint has no place; the skin is ignored", None);
                return Ok(None);
            }
            matrices.push(matrix);
        }
        Ok(Some(matrices))
    }

    /// World transform of a node that may be outside of the scene; not finite for one that is below itself.
    fn joint_world(&mut self, joint: usize, from: &str) -> Result<DAffine3, AssetError> {
        if let Some(world) = self.worlds.get(joint).copied().flatten() {
            return Ok(world);
        }
        let message = "the joint is not shown by the scene; its place follows from the nodes above it";
        self.warn(from, message, None);
        let parents = match self.parents.take() {
            Some(parents) => parents,
            None => self.find_parents()?,
        };
        let mut chain = vec![joint];
        let mut world = DAffine3::IDENTITY;
        while let Some(parent) = chain.last().and_then(|&n| parents.get(n).copied().flatten()) {
            if let Some(known) = self.worlds.get(parent).copied().flatten() {
                world = known;
                break;
            }
            if chain.len() > parents.len() {
                self.invalid(from, "the joint is below itself")?;
                world = DAffine3::NAN;
                break;
            }
            chain.push(parent);
        }
        self.parents = Some(parents);
        for node in chain.into_iter().rev() {
            let json = self.entry("nodes", node, from)?;
            world *= self.local(&json)?;
            if let Some(slot) = self.worlds.get_mut(node) {
                *slot = Some(world);
            }
        }
        Ok(world)
    }

    /// The first parent of each node.
    fn find_parents(&self) -> Result<Vec<Option<usize>>, AssetError> {
        let mut parents = vec![None; self.count("nodes")];
        for index in 0..parents.len() {
            for child in self.entry("nodes", index, "/nodes")?.array("children")? {
                if let Some(parent) = parents.get_mut(child.as_usize()?) {
                    parent.get_or_insert(index);
                }
            }
        }
        Ok(parents)
    }

    /// Skins a primitive, whose JSON is `json`.
    pub(crate) fn skinned(
        &mut self,
        primitive: &mut Primitive,
        json: &Json<'_>,
        pose: &Pose,
    ) -> Result<(), AssetError> {
        let Some(skin) = &pose.skin else { return Ok(()) };
        let pointer = json.pointer_to("attributes");
        let influences = std::mem::take(&mut primitive.influences);
        self.spend_pose(influences.len().saturating_mul(primitive.positions.len()), &pointer)?;
        let blends = blend(&influences, primitive.positions.len(), skin, &pointer)?;
        let count = blends.len();
        let alone = blends.iter().filter(|b| b.weight == 0.0).count();
        if alone > 0 {
            let message = format!("{alone} of {count} vertices follow no joint; they stay at their node");
            self.invalid(&pointer, message)?;
        }
        let uneven = |b: &&Blend| b.weight != 0.0 && (b.weight - 1.0).abs() > WEIGHT_TOLERANCE;
        let uneven = blends.iter().filter(uneven).count();
        if uneven > 0 {
            let message =
                format!("the weights of {uneven} of {count} vertices do not sum to 1; they are normalised");
            self.invalid(&pointer, message)?;
        }
        transform(primitive, &blends, skin);
        Ok(())
    }
}

/// Sums up the influences on each vertex.
fn blend(
    influences: &[Influences],
    count: usize,
    skin: &SkinPose,
    pointer: &str,
) -> Result<Vec<Blend>, AssetError> {
    let mut blends = vec![Blend { sum: Mat4::ZERO, weight: 0.0 }; count];
    for (set, Influences { joints, weights }) in influences.iter().enumerate() {
        for ((blend, joints), weights) in blends.iter_mut().zip(joints).zip(weights) {
            for (&joint, &weight) in joints.iter().zip(weights).filter(|(_, w)| **w > 0.0 && w.is_finite()) {
                let Some(matrix) = skin.joints.get(joint as usize) else {
                    let message = format!("joint {joint} is beyond the {} of the skin", skin.joints.len());
                    return Err(AssetError::invalid(format!("{pointer}/JOINTS_{set}"), message));
                };
                blend.sum += *matrix * weight;
                blend.weight += weight;
            }
        }
    }
    Ok(blends)
}

/// Moves the vertices of a primitive.
fn transform(primitive: &mut Primitive, blends: &[Blend], skin: &SkinPose) {
    let mut mirrored = 0;
    for (i, blend) in blends.iter().enumerate() {
        let matrix = if blend.weight == 0.0 { skin.node } else { blend.sum * blend.weight.recip() };
        let linear = Mat3::from_mat4(matrix);
        mirrored += usize::from(linear.determinant() < 0.0);
        primitive.positions[i] = matrix.transform_point3(primitive.positions[i]);
        if let Some(n) = primitive.normals.get_mut(i) {
            *n = cofactor(linear) * *n;
        }
        if let Some(t) = primitive.tangents.get_mut(i) {
            *t = (linear * t.truncate()).extend(t.w);
        }
    }
    if mirrored > 0 && mirrored == blends.len() {
        primitive.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        primitive.normals.iter_mut().for_each(|n| *n = -*n);
        primitive.tangents.iter_mut().for_each(|t| t.w = -t.w);
    }
}

/// The cofactor matrix, scaled to a moderate size: it turns normals as the matrix turns surfaces.
fn cofactor(m: Mat3) -> Mat3 {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.as_dvec3());
    let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let size =
        [cofactor.x_axis, cofactor.y_axis, cofactor.z_axis].map(DVec3::length).into_iter().sum::<f64>();
    if size > 0.0 && size.is_finite() { (cofactor * size.recip()).as_mat3() } else { Mat3::IDENTITY }
}
