//! Whether the surface of a medium hides or tints it, judged by what it shows: factors, textures and vertex colours
//! together, at points of the triangles. A factor alone says little: metallic is 1 by default, and 0 where the blue of a
//! texture is; a base colour texture may be there for its alpha.

use glam::{Vec2, Vec3, Vec4};

use super::subsurface::NAME;
use crate::asset::Loader;
use crate::scene::texture::TextureSampler;
use crate::scene::{MeshDescription, SceneDescription, TextureRef};

/// Below this linear base colour a warning says that every crossing of the boundary is tinted.
const NEARLY_WHITE: f32 = 0.8;
/// Shares of the points that count: fewer are seams, and the noise of compressed pictures.
const TINTED: f64 = 0.005;
const METALLIC: f64 = 0.01;
/// Points on all triangles of a material, and on one triangle, at most.
const MOST_POINTS: usize = 1 << 14;
const MOST_OF_TRIANGLE: usize = 1 << 8;

const TINT: &str = "tints light at every crossing of the boundary, beside what the medium does";
const MEND: &str = "`nephrite edit --from-base-color` makes the medium of it, `--fix-surface` removes it";

/// What the surface of one material shows, as shares of its points.
#[derive(Default)]
struct Shown {
    points: usize,
    /// Mean of factor and texture.
    metallic: f64,
    /// Points at which the texture, without its factor, is darker than nearly white; and vertex colours are.
    textured: usize,
    painted: usize,
}

/// Warns of what hides or tints the medium of material `index`.
pub(super) fn warn(loader: &mut Loader<'_>, index: usize) {
    let Some(material) = loader.scene.materials.get(index) else { return };
    let surface = format!("{}/pbrMetallicRoughness", material.pointer);
    let (color, factor) = (material.base_color.truncate(), material.metallic);
    let shown = Shown::of(&loader.scene, index);
    let many = |count: usize| count as f64 > TINTED * shown.points as f64;
    if shown.metallic > METALLIC {
        let pointer = format!("{surface}/metallicFactor");
        let message = match material.metallic_roughness_texture {
            Some(_) => format!(
                "a metallic of {factor} by a texture, {:.2} in the mean, hides the medium of {NAME} (the default is 1)",
                shown.metallic
            ),
            None => format!("a metallic of {factor} hides the medium of {NAME} (the default is 1)"),
        };
        loader.warn(&pointer, message, Some("set metallicFactor to 0 (`nephrite edit --fix-surface`)"));
    }
    if color.min_element() < NEARLY_WHITE {
        let pointer = format!("{surface}/baseColorFactor");
        loader.warn(&pointer, format!("the base colour {TINT}"), Some(MEND));
    }
    if many(shown.textured) {
        let pointer = format!("{surface}/baseColorTexture");
        loader.warn(&pointer, format!("the base colour texture {TINT}"), Some(MEND));
    }
    if many(shown.painted) {
        for pointer in colored_primitives(loader, index) {
            loader.warn(
                &pointer,
                format!(
                    "the vertex colours of the surface of material {index} {}",
                    TINT.replacen("tints", "tint", 1)
                ),
                Some(MEND),
            );
        }
    }
}

/// The vertex colours of primitives that show a material.
fn colored_primitives(loader: &Loader<'_>, material: usize) -> Vec<String> {
    let mut found = Vec::new();
    for mesh in 0..loader.count("meshes") {
        let Ok(json) = loader.entry("meshes", mesh, "/meshes") else { continue };
        for primitive in json.array("primitives").unwrap_or_default() {
            let attributes = primitive.object("attributes").ok().flatten();
            let colors = attributes.filter(|a| a.get("COLOR_0").is_some()).map(|a| a.pointer_to("COLOR_0"));
            if crate::asset::painting::shown_with(primitive.value()).contains(&material) {
                found.extend(colors);
            }
        }
    }
    found
}

impl Shown {
    fn of(scene: &SceneDescription, index: usize) -> Self {
        let material = &scene.materials[index];
        let sampler = |texture: &Option<TextureRef>| {
            let reference = texture.as_ref()?;
            Some((TextureSampler::new(&scene.textures, &scene.images, reference)?, reference.uv_set))
        };
        let (base, metal) =
            (sampler(&material.base_color_texture), sampler(&material.metallic_roughness_texture));
        let dark = |color: Vec3| usize::from(color.min_element() < NEARLY_WHITE);
        let of = |mesh: &&MeshDescription| {
            mesh.triangle_materials.iter().filter(|m| **m as usize == index).count()
        };
        let triangles: usize = scene.meshes.iter().map(|mesh| of(&mesh)).sum();
        let mut shown = Self::default();
        if triangles == 0 {
            // Nothing in the scene shows it: its textures as a whole.
            let mean = |s: &Option<(TextureSampler<'_>, usize)>| s.map_or(Vec4::ONE, |(s, _)| s.mean());
            shown.points = 1;
            shown.metallic = f64::from(material.metallic * mean(&metal).z);
            shown.textured = dark(mean(&base).truncate());
            return shown;
        }
        let each = (MOST_POINTS / triangles).clamp(1, MOST_OF_TRIANGLE);
        let stride = triangles.div_ceil(MOST_POINTS);
        let mut metallic = 0.0;
        let mut count = 0;
        for mesh in &scene.meshes {
            let own =
                mesh.triangles.iter().zip(&mesh.triangle_materials).filter(|(_, m)| **m as usize == index);
            for (corners, _) in own {
                count += 1;
                if count % stride != 0 {
                    continue;
                }
                for i in 0..each {
                    let weights = point(i);
                    let uv = |set: usize| {
                        let of = |i: u32| mesh.uvs.get(set).and_then(|uvs| uvs.get(i as usize)).copied();
                        blend(corners.map(|i| of(i).unwrap_or(Vec2::ZERO).extend(0.0).extend(0.0)), weights)
                    };
                    let look_up = |s: &Option<(TextureSampler<'_>, usize)>| {
                        s.map_or(Vec4::ONE, |(s, set)| s.sample(uv(set).truncate().truncate()))
                    };
                    let vertex = |i: u32| mesh.colors.get(i as usize).copied().unwrap_or(Vec4::ONE);
                    shown.points += 1;
                    metallic += f64::from(material.metallic * look_up(&metal).z);
                    shown.textured += dark(look_up(&base).truncate());
                    shown.painted += dark(blend(corners.map(vertex), weights).truncate());
                }
            }
        }
        shown.metallic = metallic / shown.points.max(1) as f64;
        shown
    }
}

fn blend(values: [Vec4; 3], weights: [f32; 3]) -> Vec4 {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

/// Barycentric weights of point `i` on a triangle: the middle, then points of the R₂ sequence (Roberts 2018).
fn point(i: usize) -> [f32; 3] {
    if i == 0 {
        return [1.0 / 3.0; 3];
    }
    const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let [mut u, mut v] = STEP.map(|step| (step * i as f64).fract() as f32);
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    [1.0 - u - v, u, v]
}
