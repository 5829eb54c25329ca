//! A sphere of every preset, all of one size and lit alike.

use crate::cli::Failure;
use crate::cli::author_args::PresetsArgs;
use crate::cli::interrupt;
use crate::cli::job::{cannot_write, check_output};
use crate::cli::message::Reporter;
use crate::cli::pipeline::{self, Registry, RenderControl, RenderOptions};
use crate::cli::progress::Progress;
use crate::film::ToneMap;
use crate::film::figure::{Cell, Raster, Sheet};
use crate::light::studio::studio;
use crate::optics::presets::{Preset, Source};
use crate::plural::count;
use crate::scene::{
    CameraDescription, InstanceDescription, MaterialDescription, MediumDescription, MeshDescription,
    Projection, SceneDescription,
};
use glam::{Affine3A, Mat3, Vec3};

/// Columns of the sheet.
const COLUMNS: usize = 11;
/// Splits of an octahedron's edges: facets smaller than a pixel.
const SPLITS: u32 = 48;
/// The sphere fills that part of the picture.
const FILL: f32 = 0.86;
/// Perceptual roughness: a soft highlight.
const ROUGHNESS: f32 = 0.15;

/// Renders the sheet.
pub(super) fn run(args: &PresetsArgs, presets: &[&Preset]) -> Result<(), Failure> {
    let Some(path) = &args.output else { return Ok(()) };
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Err(Failure::Usage(format!("{}: the sheet is a .png", path.display())));
    }
    if args.radius <= 0.0 {
        return Err(Failure::Usage("--radius: a length above 0 is expected".to_owned()));
    }
    check_output(path)?;
    interrupt::finish_at_first();
    let reporter = Reporter::new(args.quiet);
    let progress = Progress::new(args.quiet);
    progress.rendering();
    let cells = cells(args, presets, &progress);
    progress.clear();
    let sheet = Sheet {
        title: "Presets".to_owned(),
        cells: cells?,
        columns: Some(COLUMNS.min(presets.len())),
        footer: footer(args, presets),
        ..Default::default()
    };
    let picture = sheet.draw().map_err(Failure::cannot)?;
    let attributes = [("nephrite:version".to_owned(), env!("CARGO_PKG_VERSION").to_owned())];
    picture.write_png(path, &attributes).map_err(|e| cannot_write(path, e))?;
    reporter.note(format!("wrote {}", path.display()));
    Ok(())
}

/// How it was made, and the sources of what is on it.
fn footer(args: &PresetsArgs, presets: &[&Preset]) -> String {
    let mut text = format!(
        "Spheres of {} mm radius in the built-in studio, {} a pixel, random walk, PBR Neutral.",
        args.radius,
        count(args.spp, "sample", "samples")
    );
    for source in Source::ALL.into_iter().filter(|source| presets.iter().any(|p| p.source == *source)) {
        text += &format!(" [{}] {}.", source.letter(), source.citation());
    }
    text
}

fn cells(args: &PresetsArgs, presets: &[&Preset], progress: &Progress) -> Result<Vec<Cell>, Failure> {
    let models = Registry::standard();
    let radius = 1e-3 * args.radius;
    let mesh = sphere(radius);
    let work = u64::from(args.side * args.side) * u64::from(args.spp);
    let mut cells = Vec::new();
    for (i, preset) in presets.iter().enumerate() {
        let part = progress.part(preset.name, i as u64 * work, presets.len() as u64 * work);
        let picture = render(args, preset, &mesh, radius, &models, &part)?;
        let name = preset.name.strip_prefix("openpbr-").unwrap_or(preset.name);
        let lines = vec![format!("{name} [{}]", preset.source.letter())];
        cells.push(Cell { picture, difference: None, name: String::new(), lines });
        if interrupt::requested() {
            return Err(Failure::Interrupted);
        }
    }
    Ok(cells)
}

fn render(
    args: &PresetsArgs,
    preset: &Preset,
    mesh: &MeshDescription,
    radius: f32,
    models: &Registry,
    control: &dyn RenderControl,
) -> Result<Raster, Failure> {
    let one = preset.with_one_anisotropy();
    let vector = |v: [f64; 3]| Vec3::from_array(v.map(|v| v as f32));
    let medium = MediumDescription {
        sigma_a: vector(one.sigma_a),
        sigma_s: vector(one.sigma_s),
        anisotropy: one.g as f32,
        ior: one.eta as f32,
        priority: 0,
        absorption_texture: None,
        scattering_texture: None,
        multi_scatter: None,
    };
    let material = MaterialDescription {
        metallic: 0.0,
        roughness: ROUGHNESS,
        ior: one.eta as f32,
        transmission: 1.0,
        medium: Some(medium),
        ..Default::default()
    };
    let instance = InstanceDescription {
        name: preset.name.to_owned(),
        pointer: String::new(),
        mesh: 0,
        transform: Affine3A::IDENTITY,
    };
    let scene = pipeline::build(SceneDescription {
        meshes: vec![mesh.clone()],
        materials: vec![material],
        instances: vec![instance],
        environment: studio(),
        ..Default::default()
    })?;
    let options = RenderOptions::new(camera(radius)).with(|o| {
        o.view.width = args.side;
        o.view.height = args.side;
        o.samples.count = args.spp;
        o.threads = args.threads.unwrap_or(0);
    });
    let rendered = pipeline::render(&scene, &options, models, control)?;
    let pixels: Vec<Vec3> = rendered.picture.pixels.clone();
    Raster::from_linear(args.side, args.side, &pixels, |p| ToneMap::default().apply(p))
        .map_err(Failure::cannot)
}

/// Looks at the sphere from a little above.
fn camera(radius: f32) -> CameraDescription {
    let z = Vec3::new(0.0, 0.35, 1.0).normalize();
    let x = Vec3::Y.cross(z).normalize();
    CameraDescription {
        name: String::new(),
        transform: Affine3A::from_mat3_translation(Mat3::from_cols(x, z.cross(x), z), z * 4.0 * radius),
        projection: Projection::Orthographic { ymag: radius / FILL, aspect: None },
        clip: crate::scene::Clip::NONE,
        lens: None,
    }
}

/// An octahedron whose faces are split and blown up to a sphere, with smooth normals.
fn sphere(radius: f32) -> MeshDescription {
    let mut mesh = MeshDescription::default();
    let n = SPLITS;
    for octant in 0..8u32 {
        let sign = |bit: u32| if octant & bit == 0 { 1.0 } else { -1.0f32 };
        let (x, y, z) = (Vec3::X * sign(1), Vec3::Y * sign(2), Vec3::Z * sign(4));
        let turned = sign(1) * sign(2) * sign(4) < 0.0;
        let first = mesh.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n - i {
                // Whole numbers until here, so that neighbouring octants agree to the bit; the sum has no negative zeros.
                let at = (Vec3::ZERO + x * i as f32 + y * j as f32 + z * (n - i - j) as f32).normalize();
                mesh.normals.push(at);
                mesh.positions.push(at * radius);
            }
        }
        let index = |i: u32, j: u32| first + i * (n + 1) - i * i.saturating_sub(1) / 2 + j;
        let mut push =
            |a: u32, b: u32, c: u32| mesh.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
        for i in 0..n {
            for j in 0..n - i {
                push(index(i, j), index(i + 1, j), index(i, j + 1));
                if j + 1 < n - i {
                    push(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
                }
            }
        }
    }
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{MeshGeometry, Topology};

    #[test]
    fn the_sphere_is_closed_and_faces_outwards() {
        let mesh = sphere(0.02);
        let topology = Topology::analyse(&MeshGeometry::build(&mesh.positions, &mesh.triangles));
        assert_eq!(topology.components.len(), 1);
        let part = &topology.components[0];
        assert!(part.closed && !part.inside_out);
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.02f64.powi(3);
        assert!((part.signed_volume / volume - 1.0).abs() < 2e-3, "{}", part.signed_volume);
    }
}
