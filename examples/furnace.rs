//! The white furnace of every material of glTF files: each is put on a sphere, in an environment of radiance 1.
//!
//!     cargo run --release --example furnace -- ../shared/assets/dev
//!
//! Nothing can be seen brighter than 1, whatever a material is: emission is taken out, and all else can only take away.
//! Then everything that absorbs is taken out, too (colours become white or grey, media lose their absorption), and
//! nothing may be seen darker than 1. Limits are those of `docs/materials.md`, and 4 standard errors; of the colours of
//! a picture, which darken what is below it, only the upper one holds. Ends with 1 if a material breaks them.

use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3, Vec4};
use nephrite::asset::{LoadOptions, load};
use nephrite::scene::*;
use nephrite::transport::{RenderOptions, render};
use std::collections::HashSet;
use std::f32::consts::{PI, TAU};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const PIXELS: u32 = 24;
const SPP: u32 = 64;
/// Radius of the sphere, metres.
const RADIUS: f32 = 0.02;
/// Events of a path. Light stays in dense glass longer, but the tail is small: what it misses shows as darkness.
const MAX_DEPTH: u32 = 20_000;

/// Mean of the strongest and of the weakest channel, each with its standard error.
type Extremes = [(f64, f64); 2];

fn main() -> ExitCode {
    let mut files = Vec::new();
    std::env::args().skip(1).for_each(|arg| collect(Path::new(&arg), &mut files));
    files.sort();
    let (mut seen, mut materials, mut broken) = (HashSet::new(), 0, 0);
    let (mut brightest, mut darkest) = (f64::MIN, f64::MAX);
    for file in &files {
        let Ok(loaded) = load(file, &LoadOptions::default()) else { continue };
        for material in &loaded.scene.materials {
            let key = MaterialDescription { name: String::new(), pointer: String::new(), ..material.clone() };
            let textures = material.textures().next().map(|_| file);
            if !seen.insert(format!("{key:?} {textures:?}")) {
                continue;
            }
            materials += 1;
            let [bright, dark] = limits(material);
            let as_it_is = measure(&loaded.scene, without_emission(material.clone()));
            let white = measure(&loaded.scene, whitened(material.clone()));
            brightest = brightest.max(as_it_is[0].0).max(white[0].0);
            if dark < 1.0 {
                darkest = darkest.min(white[1].0);
            }
            // What is no number is neither.
            let below = |(mean, error): (f64, f64)| mean <= 1.0 + bright + 4.0 * error;
            let above = |(mean, error): (f64, f64)| mean >= 1.0 - dark - 4.0 * error;
            if !(below(as_it_is[0]) && below(white[0]) && above(white[1])) {
                broken += 1;
                println!("{} {} {:?}", file.display(), material.pointer, material.name);
                println!("  as it is, brightest {:.4} ± {:.4}", as_it_is[0].0, as_it_is[0].1);
                println!("  white {:.4?} to {:.4?}, limits +{bright} −{dark}", white[1], white[0]);
            }
        }
    }
    println!(
        "{materials} materials of {} files, {broken} outside of the limits; brightest {brightest:.4}, darkest {darkest:.4}",
        files.len()
    );
    ExitCode::from(u8::from(broken > 0 || materials == 0))
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if let Ok(entries) = std::fs::read_dir(path) {
        entries.flatten().for_each(|entry| collect(&entry.path(), files));
    } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
        files.push(path.to_owned());
    }
}

fn without_emission(mut m: MaterialDescription) -> MaterialDescription {
    m.emission = Vec3::ZERO;
    m.emission_texture = None;
    m.alpha_mode = AlphaMode::Opaque;
    m
}

/// Without anything that absorbs.
fn whitened(m: MaterialDescription) -> MaterialDescription {
    let mut m = without_emission(m);
    m.base_color = Vec4::ONE;
    m.base_color_texture = None;
    m.specular_color = Vec3::splat(m.specular_color.max_element());
    m.specular_color_texture = None;
    if let Some(medium) = &mut m.medium {
        medium.sigma_a = Vec3::ZERO;
    }
    if let Some(layers) = &mut m.layers {
        if let Some(sheen) = &mut layers.sheen {
            sheen.color = Vec3::splat(sheen.color.max_element());
            sheen.color_texture = None;
        }
        if let Some(coat) = &mut layers.coat {
            coat.color = Vec3::ONE;
            coat.color_texture = None;
        }
        if let Some(fuzz) = &mut layers.fuzz {
            fuzz.color = Vec3::ONE;
            fuzz.color_texture = None;
        }
        if let Some(leaf) = &mut layers.diffuse_transmission {
            leaf.color = Vec3::ONE;
            leaf.color_texture = None;
        }
        if let Some(thin) = &mut layers.thin_scatter {
            thin.color = Vec3::ONE;
            thin.color_texture = None;
        }
    }
    m
}

/// How far above and below 1 a material may be.
fn limits(m: &MaterialDescription) -> [f64; 2] {
    let layers = m.layers.as_deref().cloned().unwrap_or_default();
    let treated = m.specular != 1.0 || m.specular_color != Vec3::ONE || layers.iridescence.is_some();
    let layered = layers.coat.is_some() || layers.fuzz.is_some() || layers.sheen.is_some();
    let mut error = 5e-3;
    if layered {
        error = 2e-2;
    }
    if layers.anisotropy.is_some() {
        error = 3e-2;
    }
    if treated && m.medium.is_some() {
        error = 4.5e-2;
    }
    // Maps bend normals away from the viewer, and light that would come from below the surface is lost.
    let bent = m.normal_texture.is_some() || layers.coat.is_some_and(|c| c.normal_texture.is_some());
    let dark = if m.unlit || layers.iridescence.is_some() || bent { 1.0 } else { error };
    [error, dark]
}

fn measure(scene: &SceneDescription, material: MaterialDescription) -> Extremes {
    let scene = SceneDescription {
        meshes: vec![sphere()],
        materials: vec![material],
        textures: scene.textures.clone(),
        images: scene.images.clone(),
        instances: vec![InstanceDescription {
            name: String::new(),
            pointer: String::new(),
            mesh: 0,
            transform: Affine3A::IDENTITY,
        }],
        environment: EnvironmentDescription::Constant(Vec3::ONE),
        ..SceneDescription::default()
    };
    let z = Vec3::new(0.4, 0.3, 0.9).normalize();
    let x = Vec3::Y.cross(z).normalize();
    let camera = CameraDescription {
        name: String::new(),
        transform: Affine3A::from_mat3_translation(Mat3::from_cols(x, z.cross(x), z), z * 10.0 * RADIUS),
        projection: Projection::Orthographic { ymag: 1.1 * RADIUS, aspect: None },
        clip: nephrite::scene::Clip::NONE,
        lens: None,
    };
    let options = RenderOptions::new(camera).with(|o| {
        o.view.width = PIXELS;
        o.view.height = PIXELS;
        o.samples.count = SPP;
        o.settings.max_depth = MAX_DEPTH;
    });
    let pixels = Scene::build(scene).ok().and_then(|s| render(&s, &options, &()).ok());
    let pixels = pixels.map(|r| r.picture.pixels).unwrap_or_default();
    let n = pixels.len() as f64;
    let channel = |c: usize| {
        let mean = pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / n;
        let squares = pixels.iter().map(|p| (f64::from(p[c]) - mean).powi(2)).sum::<f64>();
        (mean, (squares / (n * (n - 1.0))).sqrt())
    };
    let mut channels = [0, 1, 2].map(channel);
    channels.sort_by(|a, b| a.0.total_cmp(&b.0));
    [channels[2], channels[0]]
}

/// A sphere of 64 × 32 quadrilaterals with normals, tangents, and four sets of texture coordinates.
fn sphere() -> MeshDescription {
    const AROUND: u32 = 64;
    const DOWN: u32 = 32;
    let mut mesh = MeshDescription::default();
    let mut uvs = Vec::new();
    for row in 0..=DOWN {
        for column in 0..=AROUND {
            let uv = Vec2::new(column as f32 / AROUND as f32, row as f32 / DOWN as f32);
            let (st, ct) = (PI * uv.y).sin_cos();
            let (sp, cp) = (TAU * (column % AROUND) as f32 / AROUND as f32).sin_cos();
            let pole = row == 0 || row == DOWN;
            let normal = if pole { Vec3::Y * ct.signum() } else { Vec3::new(st * cp, ct, st * sp) };
            mesh.positions.push(RADIUS * normal);
            mesh.normals.push(normal);
            mesh.tangents.push(Vec4::new(-sp, 0.0, cp, -1.0));
            uvs.push(Affine2::from_scale(Vec2::new(2.0, 1.0)).transform_point2(uv));
        }
    }
    for row in 0..DOWN {
        for column in 0..AROUND {
            let at = |r: u32, c: u32| r * (AROUND + 1) + c;
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            if row > 0 {
                mesh.triangles.push([a, b, c]);
            }
            if row + 1 < DOWN {
                mesh.triangles.push([b, d, c]);
            }
        }
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    mesh.uvs = vec![uvs; 4];
    mesh
}
