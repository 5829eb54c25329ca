//! A half space of isotropic scattering and index 1 under parallel light, against Chandrasekhar's H functions.
//!
//! Source: Chandrasekhar, *Radiative Transfer* (1950), §§ 34 and 38: for a perpendicular irradiance E from the cosine µ₀,
//!
//! ```text
//! I(µ) = ϖ/4π · µ₀/(µ + µ₀) · H(µ) H(µ₀) E,   1/H(µ) = √(1 − ϖ) + ϖ/2 ∫₀¹ µ' H(µ')/(µ + µ') dµ'.
//! ```

use crate::lab::*;
use glam::Vec3;
use nephrite::scene::{EnvironmentDescription, PunctualKind, PunctualLight, Scene};

/// H of one albedo at the midpoints of an even rule.
struct H {
    albedo: f64,
    nodes: Vec<f64>,
}

impl H {
    const NODES: usize = 400;

    /// By iteration from H = 1; the error falls at least by a tenth a step for the albedos here.
    fn new(albedo: f64) -> Self {
        let mut h = Self { albedo, nodes: vec![1.0; Self::NODES] };
        for _ in 0..300 {
            h.nodes = (0..Self::NODES).map(|i| h.at(Self::node(i))).collect();
        }
        h
    }

    fn node(i: usize) -> f64 {
        (i as f64 + 0.5) / Self::NODES as f64
    }

    fn at(&self, mu: f64) -> f64 {
        let integrand = |(i, h): (usize, &f64)| Self::node(i) * h / (mu + Self::node(i));
        let integral = self.nodes.iter().enumerate().map(integrand).sum::<f64>() / Self::NODES as f64;
        1.0 / ((1.0 - self.albedo).sqrt() + 0.5 * self.albedo * integral)
    }
}

/// The same by another program, in forty digits.
#[test]
fn h_functions_are_those_of_another_program() {
    for (albedo, mu, expected) in [(0.9, 0.5, 1.556_033_8), (0.9, 1.0, 1.850_098_5), (0.99, 1.0, 2.472_792_8)]
    {
        let found = H::new(albedo).at(mu);
        // What the midpoint rule misses.
        assert!((found - expected).abs() < 1e-5, "{albedo}: {found} for {expected}");
    }
}

const ALBEDO: [f64; 3] = [0.5, 0.9, 0.99];
/// As deep as light comes, by dozens of its diffusion lengths, and as wide.
const DEPTH: f32 = 400.0;
const WIDTH: f32 = 6000.0;

/// Each pair of cosines both ways: what is asked for is the same number times µ₀.
#[test]
fn half_spaces_shine_as_chandrasekhar_says() {
    let h = ALBEDO.map(H::new);
    for (seen, lit) in [(1.0f32, 0.5f32), (0.5, 1.0), (0.8, 0.3), (0.3, 0.8)] {
        let albedo = Vec3::from_array(ALBEDO.map(|a| a as f32));
        let material = subsurface(Vec3::ONE - albedo, albedo, 0.0, 1.0, 0.0);
        let mesh = cuboid(Vec3::new(WIDTH, DEPTH, WIDTH));
        let mut scene = single(mesh, material, EnvironmentDescription::default());
        let slanted = |cosine: f32, x: f32, z: f32| {
            let sine = (1.0 - cosine * cosine).sqrt();
            Vec3::new(sine * x, -cosine, sine * z)
        };
        scene.lights = vec![PunctualLight {
            name: String::new(),
            intensity: Vec3::ONE,
            position: Vec3::ZERO,
            direction: slanted(lit, 0.6, 0.8),
            range: None,
            kind: PunctualKind::Directional,
        }];
        let scene = Scene::build(scene).expect("builds");
        let camera = ortho(slanted(seen, 1.0, 0.0), 2.0 * DEPTH, 1.0);
        let case = format!("half space seen at {seen}, lit at {lit}");
        let options = options(camera, 24, 0).with(|o| o.settings.seed = seed_of(&case));
        let (mu, mu0) = (f64::from(seen), f64::from(lit));
        let expected = [0, 1, 2].map(|c| {
            let both = h[c].at(mu) * h[c].at(mu0);
            ALBEDO[c] / (4.0 * std::f64::consts::PI) * mu0 / (mu + mu0) * both
        });
        let estimate = measure_to(&scene, &options, expected.map(|e| 0.004 * e));
        estimate.assert_matches(expected, expected.map(|e| 1e-5 * e), &case);
    }
}
