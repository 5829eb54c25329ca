//! From [`SceneDescription`] to what the tracer runs on.

use super::description::*;
use super::emission::SceneEmission;
use super::footprint::Pyramids;
use super::mesh_facts::MeshFacts;
use super::object::Object;
use super::surface::Surface;
use super::texture;
use crate::geometry::{GeometryError, Hit, SceneGeometry, Topology};
use crate::light::beacon::{Beacon, beacons};
use crate::light::{EmissiveRadiance, EmissiveTriangle, Lights};
use crate::optics::Medium;
use glam::{Mat3, Vec2, Vec3, Vec4};
use rayon::prelude::*;
use std::sync::Arc;

/// Boundaries of a lower index hardly bend light.
const LEAST_AIMED_INDEX: f32 = 1.02;
/// Environments whose light comes from more than this solid angle are found well enough by chance.
const WIDEST_LIGHT: f32 = std::f32::consts::PI;

/// Why a description cannot be traced.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Geometry that has no meaning.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// An index of the description points nowhere.
    #[error("{pointer}: {what} {index} does not exist")]
    Index {
        /// Where.
        pointer: String,
        /// What was looked for.
        what: &'static str,
        /// The index.
        index: usize,
    },
    /// It would take more memory than the description allows.
    #[error("{what}, in bytes, needs {needed}, and the limit is {limit}")]
    Limit {
        /// What is counted.
        what: &'static str,
        /// How much it would take.
        needed: u64,
        /// How much is allowed.
        limit: u64,
        /// The field of [`DerivedLimits`](super::DerivedLimits) that can be raised.
        field: &'static str,
    },
    /// There is no memory for it.
    #[error("there is no memory for the scene, which takes {:.1} GB while it is built", *needed as f64 / 1e9)]
    Memory {
        /// How many bytes it takes.
        needed: u64,
    },
}

impl SceneError {
    /// What the user could do about it.
    pub fn advice(&self) -> Option<String> {
        match self {
            Self::Limit { field, .. } => Some(raise(field)),
            Self::Geometry(_) | Self::Index { .. } | Self::Memory { .. } => None,
        }
    }
}

/// What to do where a file asks for more than a limit.
pub(crate) fn raise(field: &str) -> String {
    let option = field.replace('_', "-");
    format!("if the file is to be trusted, raise the limit (`--limit {option}=N`)")
}

/// A compiled scene: immutable, shared by all threads.
pub struct Scene {
    /// The data it was made from, with inside-out media turned.
    pub description: Arc<SceneDescription>,
    /// Acceleration structures.
    pub geometry: SceneGeometry,
    /// One for each instance.
    pub objects: Vec<Object>,
    /// Medium of each material, where it has one.
    pub media: Vec<Option<Medium>>,
    /// Topology of each mesh that holds a medium.
    pub topologies: Vec<Option<Topology>>,
    /// Light sources.
    pub lights: Lights,
    /// Where most of their light comes from.
    pub beacons: Vec<Beacon>,
    /// Of images whose look-ups may be averaged.
    pub(super) pyramids: Pyramids,
    /// Whether any medium refracts wavelengths differently.
    pub has_dispersion: bool,
    /// Whether any surface lets shadow rays pass: alpha, a boundary without contrast, or an area light from behind.
    pub has_see_through: bool,
    /// Whether there are area lights, which are not there from behind.
    pub has_area_lights: bool,
    /// Of each mesh.
    pub(super) facts: Vec<MeshFacts>,
    pub(super) normal_matrices: Vec<Mat3>,
    pub(super) mirrored: Vec<bool>,
    default_material: MaterialDescription,
}

impl Scene {
    /// Builds acceleration structures and lights.
    ///
    /// # Errors
    /// Indices that point nowhere, transforms that cannot be inverted, and more memory than the limits allow.
    pub fn build(description: SceneDescription) -> Result<Self, SceneError> {
        // All of it on the threads that work: from elsewhere, each small step would wait for them to wake.
        rayon::scope(|_| Self::build_here(description))
    }

    fn build_here(mut description: SceneDescription) -> Result<Self, SceneError> {
        check_indices(&description)?;
        description.make_area_lights();
        description.check_needs()?;
        let media: Vec<_> = description.materials.iter().map(|m| m.medium.as_ref().map(medium)).collect();
        let holds_medium: Vec<bool> = description
            .meshes
            .iter()
            .map(|m| m.triangle_materials.iter().any(|&i| matches!(media.get(i as usize), Some(Some(_)))))
            .collect();
        let instances: Vec<_> = description.instances.iter().map(|i| (i.mesh, i.transform)).collect();
        let mut geometry = SceneGeometry::build(triangles_of(&description), &instances)?;
        let mut placed = vec![None; description.meshes.len()];
        for (instance, (mesh, _)) in (0..).zip(&instances) {
            placed[*mesh].get_or_insert(instance);
        }
        let analyse = |geometry: &SceneGeometry, mesh: &MeshDescription, index: usize| {
            Some(Topology::analyse_merged(geometry.mesh_of(placed[index]?), &mesh.merged))
        };
        let meshes = description.meshes.iter().enumerate();
        let topology = |(i, mesh)| if holds_medium[i] { analyse(&geometry, mesh, i) } else { None };
        let mut topologies: Vec<Option<Topology>> = meshes.map(topology).collect();
        let open = |t: &Option<Topology>| t.as_ref().is_some_and(Topology::has_open_edges);
        let mut torn: Vec<usize> = (0..topologies.len()).filter(|&mesh| open(&topologies[mesh])).collect();
        torn.retain(|&mesh| description.close_seams(mesh) > 0);
        if !torn.is_empty() {
            geometry = SceneGeometry::build(triangles_of(&description), &instances)?;
            for mesh in torn {
                topologies[mesh] = analyse(&geometry, &description.meshes[mesh], mesh);
            }
        }
        if turn_inside_out(&mut description, &topologies) {
            geometry = SceneGeometry::build(triangles_of(&description), &instances)?;
        }
        let normal_matrices = description
            .instances
            .iter()
            .map(|i| Mat3::from(i.transform.matrix3).inverse().transpose())
            .collect();
        let mirrored = description
            .instances
            .iter()
            .map(|i| Mat3::from(i.transform.matrix3).determinant() < 0.0)
            .collect();
        let mut scene = Self {
            has_see_through: false,
            has_area_lights: description.materials.iter().any(|m| m.area_light),
            has_dispersion: description.materials.iter().any(|m| m.dispersion() > 0.0),
            objects: vec![Object::default(); description.instances.len()],
            lights: Lights::build(Vec::new(), &[], &EnvironmentDescription::default()),
            default_material: MaterialDescription::default(),
            beacons: Vec::new(),
            facts: description.meshes.par_iter().map(MeshFacts::new).collect(),
            pyramids: Pyramids::new(&description),
            description: Arc::new(description),
            geometry,
            media,
            topologies,
            normal_matrices,
            mirrored,
        };
        let emitters = scene.emissive_triangles();
        scene.compile_objects(&holds_medium, &emitters);
        let see_through = scene.objects.iter().any(|o| o.has_medium && o.overlapped)
            || scene.description.materials.iter().any(|m| {
                m.alpha_mode != AlphaMode::Opaque
                    || m.medium.as_ref().is_some_and(|m| m.ior < LEAST_AIMED_INDEX)
            });
        scene.has_see_through = see_through || scene.has_area_lights;
        let punctual = &scene.description.lights;
        let environment = &scene.description.environment;
        scene.lights = Lights::build(emitters, punctual, environment);
        scene.beacons = beacons(&scene.lights, punctual);
        let concentrated = scene.lights.environment().effective_solid_angle() < WIDEST_LIGHT;
        let aimable = concentrated || !scene.beacons.is_empty();
        for i in 0..scene.objects.len() {
            let rough = scene.boundary_is_rough(i as u32) && scene.is_covered(i as u32);
            let bare = scene.has_bare_boundary(i as u32);
            let object = &mut scene.objects[i];
            let clear = rough || !see_through;
            object.aimable = aimable && clear && bare && object.distance.is_some() && !object.lit_inside;
        }
        Ok(scene)
    }

    /// The mesh of an instance.
    pub fn mesh(&self, instance: u32) -> &MeshDescription {
        &self.description.meshes[self.description.instances[instance as usize].mesh]
    }

    /// A material; the default one for [`NO_MATERIAL`].
    pub fn material(&self, index: u32) -> &MaterialDescription {
        self.description.materials.get(index as usize).unwrap_or(&self.default_material)
    }

    /// Whether the bodies of another scene are the same, wherever they are: the same media in meshes of the same extent,
    /// scale and materials, each with or without others in it.
    pub fn has_same_bodies(&self, other: &Self) -> bool {
        let same = |i: usize| {
            let [a, b] = [self, other].map(|scene| {
                let instance = i as u32;
                let geometry = scene.geometry.mesh_of(instance);
                let object = &scene.objects[i];
                let shape = (geometry.bounds().extent(), scene.geometry.transform(instance).scale);
                (shape, object.intruders.is_empty(), &scene.mesh(instance).triangle_materials)
            });
            a == b
        };
        self.objects.len() == other.objects.len()
            && self.media == other.media
            && (0..self.objects.len()).all(same)
    }

    /// The medium below the surface of a material.
    pub fn medium(&self, material: u32) -> Option<&Medium> {
        self.media.get(material as usize).and_then(Option::as_ref)
    }

    /// A texture at texture coordinates, decoded.
    pub fn texel(&self, texture: &TextureRef, uv: Vec2) -> Vec4 {
        texture::sample(&self.description, texture, uv)
    }

    fn emissive_triangles(&self) -> Vec<EmissiveTriangle> {
        let mut emitters = Vec::new();
        for instance in 0..self.description.instances.len() as u32 {
            let mesh = self.mesh(instance);
            for (triangle, &material) in mesh.triangle_materials.iter().enumerate() {
                let m = self.material(material);
                if m.emission.max_element() <= 0.0 || m.unlit {
                    continue;
                }
                emitters.extend(self.emissive_triangle(instance, triangle as u32, m));
            }
        }
        emitters
    }

    fn emissive_triangle(
        &self,
        instance: u32,
        triangle: u32,
        material: &MaterialDescription,
    ) -> Option<EmissiveTriangle> {
        let corner = |u, v| Surface::new(self, &Hit::at(instance, triangle, u, v));
        let surfaces = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        let vertices = surfaces.map(|s| s.position);
        let area = 0.5 * (vertices[1] - vertices[0]).cross(vertices[2] - vertices[0]).length();
        let sides = if material.double_sided { 2.0 } else { 1.0 };
        let (average, radiance) = if SceneEmission::varies(material) {
            let mut sum = Vec3::ZERO;
            const STEPS: usize = 8;
            for i in 0..STEPS {
                for j in 0..STEPS - i {
                    let (u, v) = ((i as f32 + 0.33) / STEPS as f32, (j as f32 + 0.33) / STEPS as f32);
                    let point = corner(u, v);
                    sum += self.emission(&point, point.geometric_normal);
                }
            }
            // A texture may be dark at every probe and bright between them: a floor keeps it reachable.
            let mean = sum / (STEPS * (STEPS + 1) / 2) as f32;
            let field = SceneEmission(self.description.clone());
            (mean.max(material.emission * 1e-3), EmissiveRadiance::Textured(Arc::new(field)))
        } else {
            (material.emission, EmissiveRadiance::Constant(material.emission))
        };
        (area > 0.0 && area.is_finite()).then(|| EmissiveTriangle {
            instance,
            triangle,
            vertices,
            geometric_normal: surfaces[0].geometric_normal,
            double_sided: material.double_sided,
            power: average * (area * sides * std::f32::consts::PI),
            radiance,
        })
    }
}

fn triangles_of(description: &SceneDescription) -> Vec<(Vec<Vec3>, Vec<[u32; 3]>)> {
    description.meshes.iter().map(|m| (m.positions.clone(), m.triangles.clone())).collect()
}

/// Turns the triangles of media that face inwards, and the vertex normals that face inwards with them; true if there
/// were any.
fn turn_inside_out(description: &mut SceneDescription, topologies: &[Option<Topology>]) -> bool {
    let mut turned = false;
    for (mesh, topology) in description.meshes.iter_mut().zip(topologies) {
        let Some(topology) = topology.as_ref().filter(|t| t.needs_flips()) else { continue };
        let mut touched = vec![false; mesh.positions.len()];
        for (triangle, _) in mesh.triangles.iter_mut().zip(&topology.flips).filter(|(_, flip)| **flip) {
            triangle.swap(1, 2);
            triangle.iter().for_each(|&i| touched[i as usize] = true);
            turned = true;
        }
        turn_normals(mesh, &touched);
    }
    turned
}

/// Turns the normals of `touched` vertices that point behind the triangles around them; bitangents stay.
fn turn_normals(mesh: &mut MeshDescription, touched: &[bool]) {
    if mesh.normals.is_empty() {
        return;
    }
    let mut fronts = vec![Vec3::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        triangle.iter().for_each(|&i| fronts[i as usize] += (b - a).cross(c - a));
    }
    for (i, front) in fronts.iter().enumerate() {
        if touched[i] && mesh.normals[i].dot(*front) < 0.0 {
            mesh.normals[i] = -mesh.normals[i];
            if let Some(tangent) = mesh.tangents.get_mut(i) {
                tangent.w = -tangent.w;
            }
        }
    }
}

/// A medium without its textures.
fn medium(m: &MediumDescription) -> Medium {
    Medium::new(m.sigma_a, m.sigma_s, m.anisotropy, m.ior, m.priority)
}

fn check_indices(d: &SceneDescription) -> Result<(), SceneError> {
    let bad = |pointer: &str, what, index| Err(SceneError::Index { pointer: pointer.into(), what, index });
    for i in &d.instances {
        if i.mesh >= d.meshes.len() {
            return bad(&i.pointer, "mesh", i.mesh);
        }
    }
    for m in &d.meshes {
        let n = m.positions.len();
        if let Some(t) = m.triangles.iter().flatten().find(|&&v| v as usize >= n) {
            return bad(&m.pointer, "vertex", *t as usize);
        }
        if m.triangle_materials.len() != m.triangles.len() {
            return bad(&m.pointer, "material of triangle", m.triangle_materials.len());
        }
        let attributes = [m.normals.len(), m.tangents.len(), m.colors.len()];
        let lengths = attributes.into_iter().chain(m.uvs.iter().map(Vec::len));
        if let Some(len) = lengths.into_iter().find(|&len| len != 0 && len != n) {
            return bad(&m.pointer, "attribute of vertex", len);
        }
        let bad_material = |&&i: &&u32| i != NO_MATERIAL && i as usize >= d.materials.len();
        if let Some(i) = m.triangle_materials.iter().find(bad_material) {
            return bad(&m.pointer, "material", *i as usize);
        }
    }
    for m in &d.materials {
        for t in m.textures() {
            if t.texture >= d.textures.len() {
                return bad(&m.pointer, "texture", t.texture);
            }
        }
    }
    for t in &d.textures {
        if t.image >= d.images.len() {
            return bad("/textures", "image", t.image);
        }
    }
    Ok(())
}
