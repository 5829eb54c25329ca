//! Poses: the morph targets (glTF 2.0 §3.7.2.2) and the skin (§3.7.3) of a mesh at a node, at rest.
//!
//! A posed mesh is a mesh of its own. Morphing adds weighted displacements; skinning replaces the transform of the
//! node by Σ wⱼ · world(jointⱼ) · inverseBindⱼ, so that a skinned mesh is in world space. Normals go with the cofactor
//! matrix, which also holds for mirrored and flattened joints.

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Mat3, Mat4, Vec3};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::primitive::Primitive;

/// More influences on a vertex than four sets of four are not looked for.
const MOST_INFLUENCE_SETS: usize = 4;

/// Morph targets beyond this many are not used.
const MOST_TARGETS: usize = 1024;

/// What is done to a mesh at a node.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Pose {
    /// Weight of each morph target; empty where all are zero.
    weights: Vec<f32>,
    /// Index of the skin and, for each of its joints, mesh space to world space; `None` without a skin.
    skin: Option<(usize, Arc<[Mat4]>)>,
}

impl Pose {
    /// Whether the posed mesh is in world space.
    pub fn is_skinned(&self) -> bool {
        self.skin.is_some()
    }

    /// What tells poses apart.
    pub fn key(&self) -> (Vec<u32>, Option<usize>) {
        (self.weights.iter().map(|w| w.to_bits()).collect(), self.skin.as_ref().map(|s| s.0))
    }
}

impl Loader<'_> {
    /// The pose of mesh `mesh` at a node.
    pub(crate) fn pose(&mut self, node: &Json<'_>, mesh: usize) -> Result<Pose, AssetError> {
        let mut weights = node.array("weights")?;
        if weights.is_empty() {
            weights = self.entry("meshes", mesh, &node.pointer_to("mesh"))?.array("weights")?;
        }
        let weights = weights.iter().take(MOST_TARGETS).map(|w| w.as_f64().map(|w| w as f32));
        let mut weights = weights.collect::<Result<Vec<_>, _>>()?;
        if weights.iter().all(|&w| w == 0.0) {
            weights.clear();
        }
        let Some(index) = node.usize("skin")? else { return Ok(Pose { weights, skin: None }) };
        let joints = match self.skins.get(&index) {
            Some(known) => known.clone(),
            None => {
                let joints = self.skin(index, &node.pointer_to("skin"))?.map(Arc::from);
                self.skins.insert(index, joints.clone());
                joints
            }
        };
        Ok(Pose { weights, skin: joints.map(|j| (index, j)) })
    }

    /// The joint matrices of a skin; `None`, with a warning, if it cannot be used.
    fn skin(&mut self, skin: usize, from: &str) -> Result<Option<Vec<Mat4>>, AssetError> {
        let json = self.entry("skins", skin, from)?;
        let joints = json.array("joints")?;
        let inverse = match json.usize("inverseBindMatrices")? {
            Some(index) => {
                let pointer = json.pointer_to("inverseBindMatrices");
                let accessor = self.accessor(index, &pointer)?;
                if accessor.shape != (4, 4) || accessor.count < joints.len() {
                    self.invalid(&pointer, "there is not one MAT4 for each joint; the skin is ignored")?;
                    return Ok(None);
                }
                accessor.floats::<16>()
            }
            None => Vec::new(),
        };
        let mut matrices = Vec::with_capacity(joints.len());
        for (i, joint) in joints.iter().enumerate() {
            let index = joint.as_usize()?;
            self.entry("nodes", index, joint.pointer())?;
            let Some(world) = self.worlds.get(index).copied().flatten() else {
                let message = "the joint is not in the scene; the skin is ignored";
                self.invalid(joint.pointer(), message)?;
                return Ok(None);
            };
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

    /// Morphs a primitive, whose JSON is `json`.
    pub(crate) fn morph(
        &mut self,
        primitive: &mut Primitive,
        json: &Json<'_>,
        pose: &Pose,
    ) -> Result<(), AssetError> {
        let count = primitive.positions.len();
        for (target, &weight) in json.array("targets")?.into_iter().zip(&pose.weights) {
            if weight == 0.0 {
                continue;
            }
            for key in ["POSITION", "NORMAL", "TANGENT"] {
                let Some(index) = target.usize(key)? else { continue };
                let pointer = target.pointer_to(key);
                let accessor = self.accessor(index, &pointer)?;
                if accessor.count != count || !accessor.is_vector(3) {
                    let message = format!("not {count} VEC3, as the primitive has vertices; it is ignored");
                    self.invalid(&pointer, message)?;
                    continue;
                }
                let moved = |v: Vec3, d: [f32; 3]| v + Vec3::from(d) * weight;
                let displacements = accessor.floats::<3>();
                match key {
                    "POSITION" => {
                        for (p, d) in primitive.positions.iter_mut().zip(displacements) {
                            *p = moved(*p, d);
                        }
                    }
                    "NORMAL" => {
                        for (n, d) in primitive.normals.iter_mut().zip(displacements) {
                            *n = moved(*n, d);
                        }
                    }
                    _ => {
                        for (t, d) in primitive.tangents.iter_mut().zip(displacements) {
                            *t = moved(t.truncate(), d).extend(t.w);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Skins a primitive, whose JSON is `json`.
    pub(crate) fn skinned(
        &mut self,
        primitive: &mut Primitive,
        json: &Json<'_>,
        pose: &Pose,
    ) -> Result<(), AssetError> {
        let Some((_, joints)) = &pose.skin else { return Ok(()) };
        let count = primitive.positions.len();
        let Some(attributes) = json.object("attributes")? else { return Ok(()) };
        let mut blended = vec![(Mat4::ZERO, 0.0_f32); count];
        for set in 0..MOST_INFLUENCE_SETS {
            let keys = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            let (Some(indices), Some(weights)) = (attributes.usize(&keys[0])?, attributes.usize(&keys[1])?)
            else {
                break;
            };
            let mut influences = [Vec::new(), Vec::new()];
            for ((read, index), key) in influences.iter_mut().zip([indices, weights]).zip(&keys) {
                let (width, elements) = match primitive.decoded.remove(key) {
                    Some(decoded) => decoded,
                    None => {
                        let accessor = self.accessor(index, &attributes.pointer_to(key))?;
                        let width = if accessor.is_vector(4) { 4 } else { 0 };
                        (width, accessor.floats::<4>())
                    }
                };
                if elements.len() != count || width != 4 {
                    let message = format!("not {count} VEC4, as the primitive has vertices; it is ignored");
                    self.invalid(&attributes.pointer_to(key), message)?;
                    return Ok(());
                }
                *read = elements;
            }
            let [indices, weights] = influences;
            for ((blend, index), weight) in blended.iter_mut().zip(indices).zip(weights) {
                for (j, w) in index.into_iter().zip(weight).filter(|(_, w)| *w > 0.0 && w.is_finite()) {
                    let Some(joint) = joints.get(j as usize) else {
                        let message = format!("joint {j} is beyond the {} of the skin", joints.len());
                        return Err(attributes.error_at(&keys[0], message));
                    };
                    blend.0 += *joint * w;
                    blend.1 += w;
                }
            }
        }
        let unweighted = blended.iter().filter(|b| b.1 == 0.0).count();
        if unweighted > 0 {
            let message =
                format!("{unweighted} of {count} vertices follow no joint; they stay where they are");
            self.invalid(attributes.pointer(), message)?;
        }
        for (i, (sum, total)) in blended.into_iter().enumerate().filter(|(_, b)| b.1 > 0.0) {
            let matrix = sum * total.recip();
            let linear = Mat3::from_mat4(matrix);
            primitive.positions[i] = matrix.transform_point3(primitive.positions[i]);
            if let Some(n) = primitive.normals.get_mut(i) {
                *n = cofactor(linear) * *n;
            }
            if let Some(t) = primitive.tangents.get_mut(i) {
                *t = (linear * t.truncate()).extend(t.w);
            }
        }
        Ok(())
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
