//! Poses: what is done to a mesh at a node before it is placed, morphing (glTF 2.0 §3.7.2.2) and then skinning (§3.7.3).
//!
//! A posed mesh is a mesh of its own: other weights or another skin make another one. A skinned mesh is in world space.

use std::sync::Arc;

use glam::DMat4;

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use super::node::NodeContext;

/// What is done to a mesh at a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pose {
    /// Weight of each morph target; empty where all are zero.
    pub weights: Vec<f32>,
    /// The skin, if there is one that can be used.
    pub skin: Option<SkinPose>,
}

/// A skin, as one node wears it.
#[derive(Clone, Debug)]
pub(crate) struct SkinPose {
    /// For each joint, mesh space to world space.
    pub joints: Arc<[DMat4]>,
    /// The node itself: where vertices go that follow no joint.
    pub node: DMat4,
    /// Index of the node.
    pub node_index: usize,
}

impl Pose {
    /// Whether the posed mesh is in world space.
    pub fn is_skinned(&self) -> bool {
        self.skin.is_some()
    }

    /// What tells poses apart: the bits of the weights, and the node that wears a skin.
    pub fn key(&self) -> (Vec<u32>, Option<usize>) {
        (self.weights.iter().map(|w| w.to_bits()).collect(), self.skin.as_ref().map(|s| s.node_index))
    }
}

impl Loader<'_> {
    /// The pose of mesh `mesh` at a node.
    pub(crate) fn pose(
        &mut self,
        json: &Json<'_>,
        mesh: usize,
        node: &NodeContext,
    ) -> Result<Pose, AssetError> {
        let mut weights = json.array("weights")?;
        if weights.is_empty() {
            weights = self.entry("meshes", mesh, &json.pointer_to("mesh"))?.array("weights")?;
        }
        let weights = weights.iter().map(|w| w.as_f64().map(|w| w as f32));
        let mut weights = weights.collect::<Result<Vec<_>, _>>()?;
        if weights.iter().all(|&w| w == 0.0) {
            weights.clear();
        }
        let Some(index) = json.usize("skin")? else { return Ok(Pose { weights, skin: None }) };
        let joints = match self.skins.get(&index) {
            Some(known) => known.clone(),
            None => {
                let joints = self.skin(index, &json.pointer_to("skin"))?.map(Arc::from);
                self.skins.insert(index, joints.clone());
                joints
            }
        };
        let wear = |joints| SkinPose { joints, node: node.world.into(), node_index: node.index };
        Ok(Pose { weights, skin: joints.map(wear) })
    }

    /// Counts elements of morph targets, joint influences and keyframes that are read, within the limit.
    pub(crate) fn spend_pose(&mut self, elements: usize, pointer: &str) -> Result<(), AssetError> {
        self.totals.pose_elements += elements as u64;
        let what = "all poses so far, in elements of morph targets, influences and keyframes,";
        Self::within(
            self.totals.pose_elements,
            self.options.limits.pose_elements,
            pointer,
            what,
            "pose_elements",
        )
    }
}
