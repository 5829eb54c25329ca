//! The node hierarchy (glTF 2.0 §3.5): which nodes the scene shows, and where they are in the world.
//!
//! The traversal keeps its own stack, so that a chain of any length does not end the program, and visits every node at
//! most once, so that a graph which is not a tree cannot multiply. A node below itself is an error; one with two
//! parents is kept below the first, with a warning. Transforms are accumulated in double precision.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Mat3, Vec3};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use crate::extension::Extension;

/// Quaternions whose length is off by more than this are worth a warning.
const QUATERNION_TOLERANCE: f64 = 1e-2;

/// A node of the scene.
#[derive(Clone, Debug)]
pub struct NodeContext {
    /// Index in the file.
    pub index: usize,
    /// Its name, or one made from the index.
    pub name: String,
    /// JSON pointer.
    pub pointer: String,
    /// Node space to world space.
    pub world: DAffine3,
}

#[derive(Clone, Copy, PartialEq)]
enum Visit {
    Unseen,
    Open,
    Done,
}

enum Step {
    Enter { node: usize, parent: DAffine3, hidden: bool, from: Option<(usize, usize)> },
    Leave(usize),
}

impl Loader<'_> {
    /// Reads the nodes below `roots` (with the pointers that name them) into the scene.
    pub(crate) fn nodes(&mut self, roots: Vec<(usize, String)>) -> Result<(), AssetError> {
        let nodes = self.traverse(roots)?;
        self.worlds = vec![None; self.count("nodes")];
        for (node, _) in &nodes {
            self.worlds[node.index] = Some(node.world);
        }
        for (node, hidden) in &nodes {
            if *hidden {
                // What is hidden may still be seen from.
                self.camera_of(&self.entry("nodes", node.index, &node.pointer)?, node)?;
            } else {
                self.contents(node)?;
            }
        }
        Ok(())
    }

    /// The nodes of the scene, parents before children, in the order of the file, and whether each is hidden.
    fn traverse(&mut self, roots: Vec<(usize, String)>) -> Result<Vec<(NodeContext, bool)>, AssetError> {
        let limit = self.options.limits.nodes;
        let count = self.count("nodes");
        Self::within(count as u64, limit, "/nodes", "the hierarchy, in nodes,", "nodes")?;
        let mut visits = vec![Visit::Unseen; count];
        let mut nodes = Vec::new();
        for (root, root_from) in roots {
            let mut stack =
                vec![Step::Enter { node: root, parent: DAffine3::IDENTITY, hidden: false, from: None }];
            while let Some(step) = stack.pop() {
                let (node, parent, hidden, from) = match step {
                    Step::Enter { node, parent, hidden, from } => (node, parent, hidden, from),
                    Step::Leave(node) => {
                        visits[node] = Visit::Done;
                        continue;
                    }
                };
                let from = || match from {
                    Some((parent, place)) => format!("/nodes/{parent}/children/{place}"),
                    None => root_from.clone(),
                };
                match visits.get(node) {
                    Some(Visit::Open) => {
                        return Err(AssetError::invalid(from(), format!("node {node} is below itself")));
                    }
                    Some(Visit::Done) => {
                        let message = format!("node {node} has another place already, and is left there");
                        self.invalid(&from(), message)?;
                        continue;
                    }
                    Some(Visit::Unseen) | None => {}
                }
                let json = self.entry("nodes", node, &from())?;
                visits[node] = Visit::Open;
                stack.push(Step::Leave(node));
                let hidden = hidden || !self.is_visible(&json)?;
                let world = parent * self.local(&json)?;
                let context = NodeContext {
                    index: node,
                    name: json.name_or(|| format!("node {node}")),
                    pointer: json.pointer().to_owned(),
                    world,
                };
                nodes.push((context, hidden));
                let first = stack.len();
                for (place, child) in json.array("children")?.into_iter().enumerate() {
                    let from = Some((node, place));
                    stack.push(Step::Enter { node: child.as_usize()?, parent: world, hidden, from });
                }
                stack[first..].reverse();
            }
        }
        Ok(nodes)
    }

    fn is_visible(&mut self, json: &Json<'_>) -> Result<bool, AssetError> {
        if json.get("extensions").is_none() {
            return Ok(true);
        }
        for extension in self.options.registry.iter() {
            if let Some(own) = json.extension(extension.name())
                && !extension.visible(self, &own)?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Reads the mesh, the camera and the extensions of a node.
    fn contents(&mut self, node: &NodeContext) -> Result<(), AssetError> {
        let json = self.entry("nodes", node.index, &node.pointer)?;
        let registry = &self.options.registry;
        let extended = json.get("extensions").is_some();
        let own = |e: &dyn Extension| json.extension(e.name()).filter(|_| extended);
        if let Some(mesh) = json.usize("mesh")? {
            let mut copies = None;
            for extension in registry.iter() {
                if let Some(own) = own(extension) {
                    copies = extension.instances(self, &own, node)?.or(copies);
                }
            }
            let copies = copies.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
            let pose = self.pose(&json, mesh, node)?;
            let world = if pose.is_skinned() { DAffine3::IDENTITY } else { node.world };
            if let Some(mesh) = self.mesh(mesh, &json.pointer_to("mesh"), &pose)? {
                for copy in copies {
                    self.place(mesh, node, &(world * copy))?;
                }
            }
        }
        self.camera_of(&json, node)?;
        for extension in registry.iter() {
            if let Some(own) = own(extension) {
                own.as_object()?;
                extension.node(self, &own, node)?;
            }
        }
        Ok(())
    }

    fn camera_of(&mut self, json: &Json<'_>, node: &NodeContext) -> Result<(), AssetError> {
        json.usize("camera")?.map_or(Ok(()), |camera| self.camera(camera, node))
    }

    /// The node's own transform.
    pub(crate) fn local(&mut self, json: &Json<'_>) -> Result<DAffine3, AssetError> {
        if let Some(m) = json.numbers::<16>("matrix")? {
            let matrix = DMat4::from_cols_array(&m);
            if matrix.row(3) != glam::DVec4::W {
                let message = "the last row is not (0, 0, 0, 1); it is taken to be";
                self.invalid(&json.pointer_to("matrix"), message)?;
            }
            return Ok(DAffine3::from_mat4(matrix));
        }
        let translation = DVec3::from(json.numbers::<3>("translation")?.unwrap_or([0.0; 3]));
        let scale = DVec3::from(json.numbers::<3>("scale")?.unwrap_or([1.0; 3]));
        let rotation = DQuat::from_array(json.numbers::<4>("rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]));
        let length = rotation.length();
        if (length - 1.0).abs() > QUATERNION_TOLERANCE || !length.is_finite() {
            let message = format!("a quaternion of length {length} instead of 1; it is normalised");
            self.invalid(&json.pointer_to("rotation"), message)?;
        }
        let rotation = if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY };
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    }
}

/// The axes of a light at a node and where it is, without scale: −Z is that of the node, +Y its as far as it is perpendicular,
/// and nothing is mirrored. `None` where the scale leaves no direction.
pub fn light_frame(world: &DAffine3) -> Option<(Mat3, Vec3)> {
    let m = &world.matrix3;
    let back = m.z_axis.try_normalize().or_else(|| m.x_axis.cross(m.y_axis).try_normalize())?;
    let upwards = [m.y_axis, back.cross(m.x_axis), back.any_orthonormal_vector()];
    let right = upwards.into_iter().find_map(|up| up.cross(back).try_normalize())?;
    let frame = DMat3::from_cols(right, back.cross(right), back).as_mat3();
    let position = world.translation.as_vec3();
    (frame.is_finite() && position.is_finite()).then_some((frame, position))
}
