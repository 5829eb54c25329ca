//! Scenes for measurements: meshes built here, cameras that see them, and estimates with standard errors.

use glam::{Affine2, Affine3A, Mat3, Vec2, Vec3, Vec4};
use nephrite::scene::*;
use nephrite::transport::{RenderOptions, render};

/// An axis-aligned box of that size around the origin, 12 triangles.
pub fn cuboid(size: Vec3) -> MeshDescription {
    let h = 0.5 * size;
    let corner = |i: u32| {
        let pick = |bit, v: f32| if i & bit == 0 { -v } else { v };
        Vec3::new(pick(1, h.x), pick(2, h.y), pick(4, h.z))
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<_> = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    MeshDescription {
        positions: (0..8).map(corner).collect(),
        triangle_materials: vec![0; triangles.len()],
        triangles,
        ..Default::default()
    }
}

/// A sphere of that radius: an icosahedron, each triangle split in four `levels` times, with smooth normals on request.
pub fn icosphere(radius: f32, levels: u32, smooth: bool) -> MeshDescription {
    let phi = 0.5 * (1.0 + 5f32.sqrt());
    let mut positions: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        positions.extend([Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)]);
    }
    let mut directions: Vec<Vec3> = positions.iter().map(|p| p.normalize()).collect();
    // Neighbours are 1.05 apart on the unit sphere, everyone else at least 1.7.
    let edge = 1.2;
    let mut triangles = Vec::new();
    for a in 0..12u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|i| directions[i as usize]);
                let near = |x: Vec3, y: Vec3| x.distance(y) < edge;
                if near(p, q) && near(q, r) && near(r, p) {
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    assert_eq!(triangles.len(), 20);
    for _ in 0..levels {
        let mut midpoints = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                directions.push((directions[a as usize] + directions[b as usize]).normalize());
                directions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    MeshDescription {
        positions: directions.iter().map(|d| *d * radius).collect(),
        normals: if smooth { directions } else { Vec::new() },
        triangle_materials: vec![0; triangles.len()],
        triangles,
        ..Default::default()
    }
}

/// The same with its triangles wound the other way, and its normals turned.
pub fn flipped(mut mesh: MeshDescription) -> MeshDescription {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh.normals.iter_mut().for_each(|n| *n = -*n);
    mesh
}

/// The same elsewhere.
pub fn moved(mut mesh: MeshDescription, by: Vec3) -> MeshDescription {
    mesh.positions.iter_mut().for_each(|p| *p += by);
    mesh
}

/// Two meshes as one, with normals if both have them.
pub fn joined(mut a: MeshDescription, b: MeshDescription) -> MeshDescription {
    let first = a.positions.len() as u32;
    a.positions.extend(b.positions);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + first)));
    a.triangle_materials.extend(b.triangle_materials);
    if a.normals.len() == first as usize && !b.normals.is_empty() {
        a.normals.extend(b.normals);
    } else {
        a.normals.clear();
    }
    a
}

/// A material that only scatters diffusely, by as much in all channels.
pub fn matte(albedo: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Vec4::new(albedo, albedo, albedo, 1.0),
        metallic: 0.0,
        roughness: 1.0,
        specular: 0.0,
        ..Default::default()
    }
}

/// A material that is nothing but the boundary of a medium.
pub fn subsurface(sigma_a: Vec3, sigma_s: Vec3, g: f32, ior: f32, roughness: f32) -> MaterialDescription {
    MaterialDescription {
        base_color: Vec4::ONE,
        metallic: 0.0,
        roughness,
        transmission: 1.0,
        ior,
        medium: Some(MediumDescription {
            sigma_a,
            sigma_s,
            anisotropy: g,
            ior,
            priority: 0,
            absorption_texture: None,
            scattering_texture: None,
            multi_scatter: None,
        }),
        ..Default::default()
    }
}

/// One mesh with one material at the origin.
pub fn single(
    mesh: MeshDescription,
    material: MaterialDescription,
    environment: EnvironmentDescription,
) -> SceneDescription {
    SceneDescription {
        meshes: vec![mesh],
        materials: vec![material],
        instances: vec![place(0, Affine3A::IDENTITY)],
        environment,
        ..Default::default()
    }
}

/// A placed mesh.
pub fn place(mesh: usize, transform: Affine3A) -> InstanceDescription {
    InstanceDescription { name: String::new(), pointer: String::new(), mesh, transform }
}

/// A square of the given half width that faces `normal`.
pub fn add_panel(
    scene: &mut SceneDescription,
    center: Vec3,
    normal: Vec3,
    half: f32,
    material: MaterialDescription,
) {
    let (x, y) = normal.any_orthonormal_pair();
    let corner = |a: f32, b: f32| center + half * (a * x + b * y);
    scene.materials.push(material);
    scene.meshes.push(MeshDescription {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![scene.materials.len() as u32 - 1; 2],
        ..Default::default()
    });
    scene.instances.push(place(scene.meshes.len() - 1, Affine3A::IDENTITY));
}

/// Radiance `above` from the upper half of the sky, nothing from the lower one.
pub fn sky_above(above: f32) -> EnvironmentDescription {
    const ROWS: usize = 512;
    let pixels =
        (0..4 * ROWS).map(|i| if i / 4 < ROWS / 2 { Vec3::splat(above) } else { Vec3::ZERO }).collect();
    EnvironmentDescription::Map { width: 4, height: ROWS, pixels, scale: Vec3::ONE, rotation: 0.0 }
}

/// An orthographic camera that looks along `direction` at the origin from `distance` away; half height `ymag`.
pub fn ortho(direction: Vec3, distance: f32, ymag: f32) -> CameraDescription {
    let z = -direction.normalize();
    let helper = if z.y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    let x = helper.cross(z).normalize();
    CameraDescription {
        name: String::new(),
        transform: Affine3A::from_mat3_translation(Mat3::from_cols(x, z.cross(x), z), z * distance),
        projection: Projection::Orthographic { ymag, aspect: None },
        clip: nephrite::scene::Clip::NONE,
        lens: None,
    }
}

/// Options for a small square picture.
pub fn options(camera: CameraDescription, pixels: u32, spp: u32) -> RenderOptions {
    RenderOptions::new(camera).with(|o| {
        o.view.width = pixels;
        o.view.height = pixels;
        o.samples.count = spp;
        o.settings.seed = 1;
        o.settings.max_depth = 1_000_000;
    })
}

/// A mean with its standard error, for each channel.
#[derive(Clone, Copy)]
pub struct Estimate {
    pub mean: [f64; 3],
    pub se: [f64; 3],
}

/// Renders and takes each pixel for an independent estimate of the same number.
pub fn measure(scene: &Scene, options: &RenderOptions) -> Estimate {
    let rendered = render(scene, options, &()).expect("renders");
    assert_eq!(rendered.stats.invalid_samples, 0);
    let pixels: Vec<[f64; 3]> = rendered.picture.pixels.iter().map(|p| p.as_dvec3().to_array()).collect();
    Estimate::of(&pixels)
}

/// A seed for each case, so that the errors of different cases are independent and their signs mean something.
pub fn seed_of(case: &str) -> u32 {
    case.bytes().fold(17u32, |h, b| h.wrapping_mul(31).wrapping_add(u32::from(b))) << 5
}

/// Like [`measure`], with as many samples as bring the standard error below `target` (for each channel). The number
/// comes from a pilot picture with another seed, whose values are not used, so the estimate stays unbiased.
pub fn measure_to(scene: &Scene, options: &RenderOptions, target: [f64; 3]) -> Estimate {
    const PILOT_SPP: u32 = 64;
    const MAX_SPP: f64 = 65_536.0;
    let pilot = measure(
        scene,
        &options.clone().with(|o| {
            o.samples.count = PILOT_SPP;
            o.settings.seed = options.settings.seed ^ 0x5eed;
        }),
    );
    let need = (0..3).map(|c| (pilot.se[c] / target[c]).powi(2)).fold(0.0, f64::max);
    // The pilot's variance is itself uncertain, by some per cent for 576 pixels.
    let spp = (1.2 * need * f64::from(PILOT_SPP)).clamp(8.0, MAX_SPP) as u32;
    measure(scene, &options.clone().with(|o| o.samples.count = spp))
}

/// Means of independent pictures, for scenes whose pixels differ: of the whole picture, and of its four quarters.
pub fn measure_pictures(scene: &Scene, options: &RenderOptions, pictures: u32) -> [Estimate; 5] {
    let mut means = [const { Vec::new() }; 5];
    for seed in 0..pictures {
        let options = options.clone().with(|o| o.settings.seed = options.settings.seed + seed);
        let rendered = render(scene, &options, &()).expect("renders");
        assert_eq!(rendered.stats.invalid_samples, 0);
        let (w, h) = (options.view.width as usize, options.view.height as usize);
        let mut sums = [[0.0; 3]; 5];
        for (i, p) in rendered.picture.pixels.iter().enumerate() {
            let quarter = 1 + usize::from(i % w >= w / 2) + 2 * usize::from(i / w >= h / 2);
            for c in 0..3 {
                sums[0][c] += f64::from(p[c]) / (w * h) as f64;
                sums[quarter][c] += f64::from(p[c]) * 4.0 / (w * h) as f64;
            }
        }
        means.iter_mut().zip(sums).for_each(|(m, s)| m.push(s));
    }
    means.map(|m| Estimate::of(&m))
}

impl Estimate {
    /// The mean of independent values and its standard error.
    pub fn of(values: &[[f64; 3]]) -> Self {
        let n = values.len() as f64;
        let mean = [0, 1, 2].map(|c| values.iter().map(|v| v[c]).sum::<f64>() / n);
        let se = [0, 1, 2]
            .map(|c| (values.iter().map(|v| (v[c] - mean[c]).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt());
        Self { mean, se }
    }

    /// Asserts |z| < 4 in every channel and a standard error below 0.5 % of the value.
    pub fn assert_matches(&self, expected: [f64; 3], expected_se: [f64; 3], what: &str) {
        for c in 0..3 {
            assert!(
                self.se[c] <= 0.005 * expected[c],
                "{what} [{c}]: too noisy to tell: {} ± {}, expected {}",
                self.mean[c],
                self.se[c],
                expected[c]
            );
            self.assert_agrees(c, expected[c], expected_se[c], what);
        }
    }

    /// Asserts that two estimates are of one number: |z| < 4 in every channel, and standard errors below 2 %.
    pub fn assert_same(&self, other: &Self, what: &str) {
        self.assert_same_within(0.02, other, what);
    }

    /// The same, with standard errors below `most` of the value.
    pub fn assert_same_within(&self, most: f64, other: &Self, what: &str) {
        for c in 0..3 {
            let se = self.se[c].max(other.se[c]);
            assert!(
                se <= most * other.mean[c],
                "{what} [{c}]: too noisy to tell: ± {se} of {}",
                other.mean[c]
            );
            self.assert_agrees(c, other.mean[c], other.se[c], what);
        }
    }

    fn assert_agrees(&self, c: usize, expected: f64, expected_se: f64, what: &str) {
        let se = self.se[c].hypot(expected_se).max(1e-6);
        let z = (self.mean[c] - expected) / se;
        println!("{what} [{c}]: {:.6} ± {:.6}, expected {expected:.6}, z {z:+.2}", self.mean[c], self.se[c]);
        assert!(z.abs() < 4.0, "{what} [{c}]: {} ± {se} is not {expected} (z {z:+.2})", self.mean[c]);
    }
}

/// A texture of linear values, appended to a scene.
pub fn add_texture(scene: &mut SceneDescription, width: u32, texels: &[Vec3]) -> TextureRef {
    let image = ImageData {
        name: String::new(),
        width,
        height: texels.len() as u32 / width,
        pixels: ImagePixels::Rgba32F(texels.iter().flat_map(|t| t.extend(1.0).to_array()).collect()),
    };
    scene.images.push(image.into());
    scene.textures.push(TextureDescription {
        image: scene.images.len() - 1,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        linear_filter: true,
        minify: Minify::Footprint,
    });
    TextureRef {
        texture: scene.textures.len() - 1,
        uv_set: 0,
        transform: Affine2::IDENTITY,
        color_space: ColorSpace::Linear,
    }
}

/// Texture coordinates from the direction of each vertex.
pub fn with_uvs(mut mesh: MeshDescription) -> MeshDescription {
    mesh.uvs =
        vec![mesh.positions.iter().map(|p| p.normalize().truncate() * 0.5 + Vec2::splat(0.5)).collect()];
    mesh
}
