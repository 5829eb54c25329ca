//! Skins (glTF 2.0 §3.7.3): a vertex goes where Σ wⱼ · world(jointⱼ) · inverseBindⱼ takes it.
//!
//! The transform of the node that wears the skin plays no part, so a skinned mesh is in world space. Any number of
//! influences is summed, and the sum divided by that of the weights. Normals go with the cofactor matrix, which also
//! holds for uneven, mirrored and flattened joints. Matrices are in double precision until it is known from where positions
//! are counted, before and after. Where the joints mirror a whole primitive its triangles and normals
//! are turned over, as those of a mirrored node are, so that outside stays outside.

use glam::{DAffine3, DMat3, DMat4, DVec3, Mat3, Mat4};

use super::error::{self, AssetError};
use super::json::Json;
use super::loader::Loader;
use super::pose::Pose;
use super::primitive::{Influences, Primitive};
use super::rebase;

/// Sums of weights that are off by more than this are worth a warning; four weights in bytes may be off by 2/255.
const WEIGHT_TOLERANCE: f32 = 1e-2;

/// What the influences on a vertex add up to.
#[derive(Clone, Copy, Debug)]
struct Blend {
    sum: Mat4,
    weight: f32,
}

impl Blend {
    /// Where the vertex goes, given where those go that follow no joint.
    fn matrix(&self, node: &Mat4) -> Mat4 {
        if self.weight == 0.0 { *node } else { self.sum * self.weight.recip() }
    }
}

impl Loader<'_> {
    /// The joint matrices of a skin; `None`, with a warning, if it cannot be used.
    pub(crate) fn skin(&mut self, skin: usize, from: &str) -> Result<Option<Vec<DMat4>>, AssetError> {
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
            let matrix = DMat4::from(world) * bind.as_dmat4();
            if !matrix.as_mat4().is_finite() {
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

    /// Skins a primitive, whose JSON is `json`, and whose positions are counted from `center`. The world positions that
    /// come out are counted from the place that is returned: that of an earlier primitive of the mesh, if there is one.
    pub(crate) fn skinned(
        &mut self,
        primitive: &mut Primitive,
        json: &Json<'_>,
        pose: &Pose,
        center: DVec3,
        known: Option<DVec3>,
    ) -> Result<DVec3, AssetError> {
        let Some(skin) = &pose.skin else { return Ok(center) };
        let pointer = json.pointer_to("attributes");
        let influences = std::mem::take(&mut primitive.influences);
        self.spend_pose(influences.len().saturating_mul(primitive.positions.len()), &pointer)?;
        let count = primitive.positions.len();
        let used = used_vertices(primitive);
        let posed = |from: DVec3| {
            let [there, back] = [center, -from].map(DMat4::from_translation);
            let joints: Vec<Mat4> = skin.joints.iter().map(|j| (back * *j * there).as_mat4()).collect();
            let blends = blend(&influences, count, &joints, &pointer)?;
            Ok::<_, AssetError>((blends, (back * skin.node * there).as_mat4()))
        };
        let mut from = known.unwrap_or_default();
        let (mut blends, mut node) = posed(from)?;
        if known.is_none() {
            let place =
                |i: usize| blends[i].matrix(&node).transform_point3(primitive.positions[i]).as_dvec3();
            let used = (0..count).filter(|&i| used[i]);
            let places = used.map(place).filter(|p| p.is_finite());
            from = rebase::far_center(places);
            if from != DVec3::ZERO {
                (blends, node) = posed(from)?;
            }
        }
        let vertices = error::count(count, "vertex", "vertices");
        let alone = blends.iter().filter(|b| b.weight == 0.0).count();
        if alone > 0 {
            let message =
                format!("no joint moves {alone} of {vertices}; what is not moved stays at its node");
            self.invalid(&pointer, message)?;
        }
        let uneven = |b: &&Blend| b.weight != 0.0 && (b.weight - 1.0).abs() > WEIGHT_TOLERANCE;
        let uneven = blends.iter().filter(uneven).count();
        if uneven > 0 {
            let message =
                format!("the weights of {uneven} of {vertices} do not sum to 1; they are normalised");
            self.invalid(&pointer, message)?;
        }
        transform(primitive, &blends, &node, &used);
        Ok(from)
    }
}

/// Sums up the influences on each vertex.
fn blend(
    influences: &[Influences],
    count: usize,
    joints_of_skin: &[Mat4],
    pointer: &str,
) -> Result<Vec<Blend>, AssetError> {
    let mut blends = vec![Blend { sum: Mat4::ZERO, weight: 0.0 }; count];
    for (set, Influences { joints, weights }) in influences.iter().enumerate() {
        for ((blend, joints), weights) in blends.iter_mut().zip(joints).zip(weights) {
            for (&joint, &weight) in joints.iter().zip(weights).filter(|(_, w)| **w > 0.0 && w.is_finite()) {
                let Some(matrix) = joints_of_skin.get(joint as usize) else {
                    let message = format!("joint {joint} is beyond the {} of the skin", joints_of_skin.len());
                    return Err(AssetError::invalid(format!("{pointer}/JOINTS_{set}"), message));
                };
                blend.sum += *matrix * weight;
                blend.weight += weight;
            }
        }
    }
    Ok(blends)
}

/// Whether each vertex is a corner of something that is shown.
fn used_vertices(primitive: &Primitive) -> Vec<bool> {
    let mut used = vec![false; primitive.positions.len()];
    let marked = primitive.marks.iter().flat_map(|(_, indices)| indices);
    primitive.triangles.iter().flatten().chain(marked).for_each(|&i| used[i as usize] = true);
    used
}

/// Moves the vertices of a primitive.
fn transform(primitive: &mut Primitive, blends: &[Blend], node: &Mat4, used: &[bool]) {
    let (mut mirrored, mut straight) = (0, 0);
    for (i, blend) in blends.iter().enumerate() {
        let matrix = blend.matrix(node);
        let linear = Mat3::from_mat4(matrix);
        let mirrors = linear.determinant() < 0.0;
        mirrored += usize::from(used[i] && mirrors);
        straight += usize::from(used[i] && !mirrors);
        primitive.positions[i] = matrix.transform_point3(primitive.positions[i]);
        if let Some(n) = primitive.normals.get_mut(i) {
            *n = cofactor(linear) * *n;
        }
        if let Some(t) = primitive.tangents.get_mut(i) {
            *t = (linear * t.truncate()).extend(t.w);
        }
    }
    if mirrored > 0 && straight == 0 {
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
