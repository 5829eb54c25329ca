//! The node hierarchy (glTF 2.0 §3.5): which nodes the scene shows, and where they are in the world.
//!
//! The traversal keeps its own stack, so that a chain of any length does not end the program, and visits every node at
//! most once, so that a graph which is not a tree cannot multiply. A node below itself is an error; one with two
//! parents is kept below the first, with a warning. Transforms are accumulated in double precision.

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3, Vec3};

use super::error::AssetError;
use super::json::Json;
use super::loader::Loader;
use crate::scene::{InstanceDescription, MeshDescription};

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
    Enter { node: usize, parent: DAffine3, from: Option<(usize, usize)> },
    Leave(usize),
}

impl Loader<'_> {
    /// Reads the nodes below `roots` (with the pointers that name them) into the scene.
    pub(crate) fn nodes(&mut self, roots: Vec<(usize, String)>) -> Result<(), AssetError> {
        let limit = self.options.limits.nodes;
        Self::within(self.count("nodes") as u64, limit, "/nodes", "the hierarchy, in nodes,", "nodes")?;
        let mut visits = vec![Visit::Unseen; self.count("nodes")];
        for (root, root_from) in roots {
            let mut stack = vec![Step::Enter { node: root, parent: DAffine3::IDENTITY, from: None }];
            while let Some(step) = stack.pop() {
                let (node, parent, from) = match step {
                    Step::Enter { node, parent, from } => (node, parent, from),
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
                        let message = format!("node {node} has another parent already; it is left there");
                        self.invalid(&from(), message)?;
                        continue;
                    }
                    Some(Visit::Unseen) | None => {}
                }
                let json = self.entry("nodes", node, &from())?;
                visits[node] = Visit::Open;
                stack.push(Step::Leave(node));
                let Some(world) = self.node(node, &json, &parent)? else { continue };
                if let Some(children) = json.get("children") {
                    let first = stack.len();
                    for (place, child) in children.items()?.enumerate() {
                        let from = Some((node, place));
                        stack.push(Step::Enter { node: child.as_usize()?, parent: world, from });
                    }
                    stack[first..].reverse();
                }
            }
        }
        Ok(())
    }

    /// Reads one node and returns its world transform; `None` if it is hidden, with all below it.
    fn node(
        &mut self,
        index: usize,
        json: &Json<'_>,
        parent: &DAffine3,
    ) -> Result<Option<DAffine3>, AssetError> {
        let registry = &self.options.registry;
        let extended = json.get("extensions").is_some();
        let own = |e: &dyn crate::extension::Extension| json.extension(e.name()).filter(|_| extended);
        for extension in registry.iter() {
            if let Some(own) = own(extension)
                && !extension.visible(self, &own)?
            {
                return Ok(None);
            }
        }
        let context = NodeContext {
            index,
            name: json.name_or(|| format!("node {index}")),
            pointer: json.pointer().to_owned(),
            world: *parent * self.local(json)?,
        };
        if let Some(mesh) = json.usize("mesh")? {
            let mut copies = None;
            for extension in registry.iter() {
                if let Some(own) = own(extension) {
                    copies = extension.instances(self, &own, &context)?.or(copies);
                }
            }
            let copies = copies.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
            if let Some(mesh) = self.mesh(mesh, &json.pointer_to("mesh"))? {
                for copy in copies {
                    self.place(mesh, &context, &(context.world * copy))?;
                }
            }
        }
        if let Some(camera) = json.usize("camera")? {
            self.camera(camera, &context)?;
        }
        for extension in registry.iter() {
            if let Some(own) = own(extension) {
                own.as_object()?;
                extension.node(self, &own, &context)?;
            }
        }
        Ok(Some(context.world))
    }

    /// The node's own transform.
    fn local(&mut self, json: &Json<'_>) -> Result<DAffine3, AssetError> {
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
        const TOLERANCE: f64 = 1e-2;
        let length = rotation.length();
        if (length - 1.0).abs() > TOLERANCE || !length.is_finite() {
            let message = format!("a quaternion of length {length} instead of 1; it is normalised");
            self.invalid(&json.pointer_to("rotation"), message)?;
        }
        let rotation = if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY };
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    }

    /// Adds an instance of a mesh of the scene.
    ///
    /// # Errors
    /// Where there are more instances than the limits allow.
    pub fn place(&mut self, mesh: usize, node: &NodeContext, world: &DAffine3) -> Result<(), AssetError> {
        let limit = self.options.limits.instances;
        let needed = self.scene.instances.len() as u64 + 1;
        Self::within(needed, limit, &node.pointer, "the scene, in instances,", "instances")?;
        let transform = Affine3A::from_mat3_translation(world.matrix3.as_mat3(), world.translation.as_vec3());
        let far = super::mesh::FARTHEST;
        let reach = |p: DVec3| world.transform_point3(p).abs().max_element();
        if !transform.is_finite() || !self.corners(mesh).into_iter().all(|c| reach(c) <= far) {
            let message = format!("the object is left out, since it reaches beyond {far:e} m");
            self.warn(&node.pointer, message, None);
            return Ok(());
        }
        let (mesh, transform) = if invertible(world) && transform.inverse().is_finite() {
            (mesh, transform)
        } else {
            let Some(flat) = self.flattened(mesh, &transform, &node.pointer)? else {
                self.warn(
                    &node.pointer,
                    "the object is left out, since its scale leaves nothing of it",
                    None,
                );
                return Ok(());
            };
            self.warn(&node.pointer, "the scale of the object flattens it", None);
            (flat, Affine3A::IDENTITY)
        };
        self.scene.instances.push(InstanceDescription {
            name: node.name.clone(),
            pointer: node.pointer.clone(),
            mesh,
            transform,
        });
        Ok(())
    }

    /// The corners of a mesh's bounding box.
    fn corners(&mut self, mesh: usize) -> [DVec3; 8] {
        let meshes = &self.scene.meshes;
        let bounds = || meshes.get(mesh).map_or([Vec3::ZERO; 2], MeshDescription::bounds);
        let [low, high] = self.bounds.entry(mesh).or_insert_with(bounds).map(|c| c.as_dvec3());
        std::array::from_fn(|i| {
            let bit = |k: usize| i >> k & 1 == 1;
            DVec3::select(glam::BVec3::new(bit(0), bit(1), bit(2)), high, low)
        })
    }

    /// A copy of a mesh under a transform that has no inverse; `None` if no area is left.
    fn flattened(
        &mut self,
        mesh: usize,
        transform: &Affine3A,
        pointer: &str,
    ) -> Result<Option<usize>, AssetError> {
        let Some(mesh) = self.scene.meshes.get(mesh) else { return Ok(None) };
        let mut flat = mesh.clone();
        self.spend(flat.positions.len(), flat.triangles.len(), pointer)?;
        for p in &mut flat.positions {
            *p = transform.transform_point3(*p);
        }
        flat.normals.clear();
        flat.tangents.clear();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| flat.positions[i as usize]);
            (b - a).cross(c - a).length_squared()
        };
        let solid: Vec<bool> = flat.triangles.iter().map(|t| area(t) > 0.0).collect();
        let mut keep = solid.iter();
        flat.triangles.retain(|_| keep.next().copied().unwrap_or(false));
        let mut keep = solid.iter();
        flat.triangle_materials.retain(|_| keep.next().copied().unwrap_or(false));
        if flat.triangles.is_empty() {
            return Ok(None);
        }
        self.scene.meshes.push(flat);
        Ok(Some(self.scene.meshes.len() - 1))
    }
}

/// Whether the columns of a transform span space, whatever their lengths.
fn invertible(world: &DAffine3) -> bool {
    const FLAT: f64 = 1e-9;
    let m = &world.matrix3;
    let lengths = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    m.determinant().abs() > FLAT * lengths
}
