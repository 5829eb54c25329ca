//! What is in a file, for `inspect`: counts, names, media, and what becomes of each extension.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use serde::Serialize;
use serde_json::Value;

use super::animation::AnimationSummary;
use super::loader::Loader;
use crate::light::punctual;
use crate::scene::{
    AlphaMode, AreaLight, AreaShape, ImagePixels, Lens, MaterialDescription, Projection, PunctualKind,
    PunctualLight, SceneDescription,
};

/// What is in a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// `asset.generator`: the program that wrote the file.
    pub generator: Option<String>,
    /// `asset.copyright`.
    pub copyright: Option<String>,
    /// Names of all scenes of the file.
    pub scenes: Vec<String>,
    /// Lengths of the document's top-level arrays.
    pub counts: BTreeMap<String, usize>,
    /// Vertices of all meshes of the scene, each counted once.
    pub vertices: usize,
    /// Triangles of all meshes of the scene, each counted once.
    pub triangles: usize,
    /// Triangles of the scene with every instance counted.
    pub instanced_triangles: usize,
    /// Meshes that the scene shows.
    pub meshes: Vec<MeshSummary>,
    /// Names of the variants of the file (KHR_materials_variants).
    pub variants: Vec<String>,
    /// All materials of the file.
    pub materials: Vec<MaterialSummary>,
    /// Images in use.
    pub images: Vec<ImageSummary>,
    /// Cameras of the scene.
    pub cameras: Vec<CameraSummary>,
    /// Lights of the scene that are no meshes.
    pub lights: Vec<LightSummary>,
    /// All animations of the file.
    pub animations: Vec<AnimationSummary>,
    /// Extensions that the file uses, and what becomes of each.
    pub extensions: Vec<ExtensionSummary>,
}

/// A mesh of the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshSummary {
    /// Its name.
    pub name: String,
    /// JSON pointer.
    pub pointer: String,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of times the scene shows it.
    pub instances: usize,
    /// Attributes besides positions: `normals`, `tangents`, `colors`, `uv0`, …
    pub attributes: Vec<String>,
    /// Indices of the materials it uses.
    pub materials: Vec<u32>,
}

/// A material of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialSummary {
    /// Its name.
    pub name: String,
    /// JSON pointer.
    pub pointer: String,
    /// Linear base colour and alpha.
    pub base_color: [f32; 4],
    /// 0 dielectric, 1 metal.
    pub metallic: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Index of refraction of the boundary.
    pub ior: f32,
    /// Fraction of light that goes through.
    pub transmission: f32,
    /// Emitted radiance.
    pub emission: [f32; 3],
    /// `opaque`, `mask` or `blend`.
    pub alpha: &'static str,
    /// Visible from both sides.
    pub double_sided: bool,
    /// Not lit.
    pub unlit: bool,
    /// What lies on it or shapes its lobes: `clearcoat`, `sheen`, …
    pub layers: Vec<&'static str>,
    /// Number of textures it uses.
    pub textures: usize,
    /// What is inside.
    pub medium: Option<MediumSummary>,
}

/// The medium of a material, before textures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MediumSummary {
    /// Absorption coefficient, 1/m.
    pub sigma_a: [f32; 3],
    /// Scattering coefficient, 1/m.
    pub sigma_s: [f32; 3],
    /// Mean cosine of scattering.
    pub anisotropy: f32,
    /// Index of refraction.
    pub ior: f32,
    /// Priority where media overlap.
    pub priority: i32,
    /// 1 / (σa + σs), metres; `None` where light is never stopped.
    pub mean_free_path: [Option<f32>; 3],
    /// σs / (σa + σs); `None` where light is never stopped.
    pub single_scattering_albedo: [Option<f32>; 3],
    /// Whether textures vary the coefficients.
    pub textured: bool,
}

/// An image in use.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageSummary {
    /// Name or URI.
    pub name: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Bits a channel.
    pub bits: u32,
}

/// A camera of the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraSummary {
    /// Its name.
    pub name: String,
    /// `perspective` or `orthographic`.
    pub kind: &'static str,
    /// Full vertical angle in radians, or half the height of the view in metres.
    pub extent: f32,
    /// Width over height, if the file says so.
    pub aspect: Option<f32>,
    /// What it looks through, if the file says so.
    pub lens: Option<LensSummary>,
}

/// The lens of a camera (EXT_camera_physical).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensSummary {
    /// Metres.
    pub focal_length: f32,
    /// Width and height, metres.
    pub sensor: [f32; 2],
    /// Focal length over the diameter of the opening.
    pub f_stop: Option<f32>,
    /// Metres.
    pub focus_distance: Option<f32>,
}

/// A light of the scene that is no mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightSummary {
    /// Its name.
    pub name: String,
    /// `point`, `spot`, `directional`, `ies`, `rect` or `disk`.
    pub kind: &'static str,
    /// Colour × intensity, in `unit`; the largest of an IES light.
    pub intensity: [f32; 3],
    /// `cd` (point, spot, ies), `lx` (directional) or `cd/m²` (rect, disk).
    pub unit: &'static str,
    /// Luminous flux in lumens; `None` where it is directional. The range is not counted.
    pub power: Option<[f32; 3]>,
    /// World position, metres; `None` where it is directional.
    pub position: Option<[f64; 3]>,
    /// Unit world direction in which it shines; `None` where that is everywhere.
    pub direction: Option<[f32; 3]>,
    /// Inner and outer angle of a spot from its axis, radians.
    pub cone: Option<[f32; 2]>,
    /// Distance beyond which it has no effect, metres, if the file says so.
    pub range: Option<f32>,
    /// Width and height in the world, metres (rect, disk).
    pub size: Option<[f32; 2]>,
}

/// An extension and what becomes of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExtensionSummary {
    /// Its name.
    pub name: String,
    /// In `extensionsRequired`.
    pub required: bool,
    /// Number of objects that carry it.
    pub places: usize,
    /// Whether the loader has a plug-in for it.
    pub supported: bool,
    /// What is not honoured, and why; `None` if all of it is.
    pub ignored: Option<String>,
}

impl Summary {
    pub(crate) fn new(
        loader: &Loader<'_>,
        extensions: Vec<ExtensionSummary>,
        animations: Vec<AnimationSummary>,
    ) -> Self {
        let (document, scene) = (loader.document, &loader.scene);
        let text =
            |key: &str| document.pointer(&format!("/asset/{key}")).and_then(Value::as_str).map(str::to_owned);
        let arrays = document.as_object().into_iter().flatten();
        let counts = arrays.filter_map(|(k, v)| Some((k.clone(), v.as_array()?.len())));
        let meshes = meshes(scene);
        Self {
            generator: text("generator"),
            copyright: text("copyright"),
            scenes: names(document, "scenes", "scene"),
            counts: counts.filter(|(k, _)| !k.starts_with("extensions")).collect(),
            vertices: scene.meshes.iter().map(|m| m.positions.len()).sum(),
            triangles: scene.meshes.iter().map(|m| m.triangles.len()).sum(),
            instanced_triangles: meshes.iter().map(|m| m.triangles * m.instances).sum(),
            meshes,
            variants: variants(document),
            materials: scene.materials.iter().map(material).collect(),
            images: images(scene),
            cameras: cameras(scene),
            lights: lights(scene),
            animations,
            extensions,
        }
    }
}

fn names(document: &Value, array: &str, kind: &str) -> Vec<String> {
    let entries = document.get(array).and_then(Value::as_array).into_iter().flatten().enumerate();
    let name = |(i, v): (usize, &Value)| match v.get("name").and_then(Value::as_str) {
        Some(name) => name.to_owned(),
        None => format!("{kind} {i}"),
    };
    entries.map(name).collect()
}

fn variants(document: &Value) -> Vec<String> {
    let extension = document.pointer("/extensions/KHR_materials_variants");
    extension.map_or_else(Vec::new, |own| names(own, "variants", "variant"))
}

fn meshes(scene: &SceneDescription) -> Vec<MeshSummary> {
    let mut instances = vec![0; scene.meshes.len()];
    for instance in &scene.instances {
        instances[instance.mesh] += 1;
    }
    let summary = |(mesh, instances): (&crate::scene::MeshDescription, usize)| {
        let mut attributes = Vec::new();
        let parts = [
            (!mesh.normals.is_empty(), "normals"),
            (!mesh.tangents.is_empty(), "tangents"),
            (!mesh.colors.is_empty(), "colors"),
        ];
        attributes.extend(parts.iter().filter(|p| p.0).map(|p| p.1.to_owned()));
        attributes.extend((0..mesh.uvs.len()).map(|i| format!("uv{i}")));
        let mut materials = mesh.triangle_materials.clone();
        materials.sort_unstable();
        materials.dedup();
        materials.retain(|&m| m != crate::scene::NO_MATERIAL);
        MeshSummary {
            name: mesh.name.clone(),
            pointer: mesh.pointer.clone(),
            vertices: mesh.positions.len(),
            triangles: mesh.triangles.len(),
            instances,
            attributes,
            materials,
        }
    };
    scene.meshes.iter().zip(instances).map(summary).collect()
}

fn material(m: &MaterialDescription) -> MaterialSummary {
    let medium = m.medium.as_ref().map(|medium| {
        let sigma_t = medium.sigma_a + medium.sigma_s;
        let over = |numerator: [f32; 3]| {
            let t = sigma_t.to_array();
            std::array::from_fn(|i| (t[i] > 0.0).then(|| numerator[i] / t[i]))
        };
        MediumSummary {
            sigma_a: medium.sigma_a.to_array(),
            sigma_s: medium.sigma_s.to_array(),
            anisotropy: medium.anisotropy,
            ior: medium.ior,
            priority: medium.priority,
            mean_free_path: over([1.0; 3]),
            single_scattering_albedo: over(medium.sigma_s.to_array()),
            textured: medium.is_textured(),
        }
    });
    MaterialSummary {
        name: m.name.clone(),
        pointer: m.pointer.clone(),
        base_color: m.base_color.to_array(),
        metallic: m.metallic,
        roughness: m.roughness,
        ior: m.ior,
        transmission: m.transmission,
        emission: m.emission.to_array(),
        alpha: match m.alpha_mode {
            AlphaMode::Opaque => "opaque",
            AlphaMode::Mask(_) => "mask",
            AlphaMode::Blend => "blend",
        },
        double_sided: m.double_sided,
        unlit: m.unlit,
        layers: m.layers.as_ref().map_or_else(Vec::new, |l| l.names()),
        textures: m.textures().count(),
        medium,
    }
}

fn images(scene: &SceneDescription) -> Vec<ImageSummary> {
    let bits = |pixels: &ImagePixels| match pixels {
        ImagePixels::Rgba8(_) => 8,
        ImagePixels::Rgba16(_) => 16,
        ImagePixels::Rgba32F(_) => 32,
    };
    let images = scene.images.iter();
    images
        .map(|i| ImageSummary {
            name: i.name.clone(),
            width: i.width,
            height: i.height,
            bits: bits(&i.pixels),
        })
        .collect()
}

fn cameras(scene: &SceneDescription) -> Vec<CameraSummary> {
    let cameras = scene.cameras.iter();
    cameras
        .map(|c| {
            let (kind, extent, aspect) = match c.projection {
                Projection::Perspective { yfov, aspect } => ("perspective", yfov, aspect),
                Projection::Orthographic { ymag, aspect } => ("orthographic", ymag, aspect),
            };
            let lens = c.lens.map(|l| {
                let Lens { focal_length, sensor, f_stop, focus_distance } = l;
                LensSummary { focal_length, sensor, f_stop, focus_distance }
            });
            CameraSummary { name: c.name.clone(), kind, extent, aspect, lens }
        })
        .collect()
}

fn lights(scene: &SceneDescription) -> Vec<LightSummary> {
    let punctual = scene.lights.iter().map(|light| punctual_light(light, scene.origin));
    punctual.chain(scene.area_lights.iter().map(|light| area_light(light, scene.origin))).collect()
}

fn punctual_light(light: &PunctualLight, origin: DVec3) -> LightSummary {
    let (kind, cone) = match &light.kind {
        PunctualKind::Point => ("point", None),
        PunctualKind::Spot { inner, outer } => ("spot", Some([*inner, *outer])),
        PunctualKind::Directional => ("directional", None),
        PunctualKind::Web(_) => ("ies", None),
    };
    let solid_angle = punctual::solid_angle(&light.kind);
    let position = light.position.as_dvec3() + origin;
    let everywhere = matches!(light.kind, PunctualKind::Point);
    LightSummary {
        name: light.name.clone(),
        kind,
        intensity: light.intensity.to_array(),
        unit: if solid_angle.is_some() { "cd" } else { "lx" },
        power: solid_angle.map(|angle| (angle * light.intensity).to_array()),
        position: solid_angle.is_some().then(|| position.to_array()),
        direction: (!everywhere).then(|| light.direction.to_array()),
        cone,
        range: light.range,
        size: None,
    }
}

fn area_light(light: &AreaLight, origin: DVec3) -> LightSummary {
    let position = Vec3::from(light.transform.translation).as_dvec3() + origin;
    LightSummary {
        name: light.name.clone(),
        kind: match light.shape {
            AreaShape::Rectangle => "rect",
            AreaShape::Disk => "disk",
        },
        intensity: light.radiance.to_array(),
        unit: "cd/m²",
        power: Some(light.lumens().to_array()),
        position: Some(position.to_array()),
        direction: Some((-Vec3::from(light.transform.matrix3.z_axis)).to_array()),
        cone: None,
        range: None,
        size: Some(light.size.to_array()),
    }
}
