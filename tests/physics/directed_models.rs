//! The models that depend on directions, rendered: directional dipole, single scattering, the BRDF approximation and the
//! preview that is built on it.

use crate::lab::*;
use glam::{DVec3, Vec3};
use nephrite::optics::diffusion::{single::Connection, *};
use nephrite::optics::fresnel;
use nephrite::scene::*;
use nephrite::subsurface::{self, Registry};
use nephrite::transport::{RenderOptions, render_with};
use std::f64::consts::{PI, TAU};

const SIGMA_A: Vec3 = Vec3::new(20.0, 60.0, 200.0);
const SIGMA_S: Vec3 = Vec3::new(1000.0, 900.0, 800.0);
const ANISOTROPY: f32 = 0.4;
const ETA: f32 = 1.4;

fn coefficients(channel: usize) -> Coefficients {
    Coefficients {
        sigma_a: f64::from(SIGMA_A[channel]),
        sigma_s: f64::from(SIGMA_S[channel]),
        g: f64::from(ANISOTROPY),
        eta: f64::from(ETA),
    }
}

/// A block that is a half space for its medium, with its upper face at z = 0.
fn block(environment: EnvironmentDescription, lights: Vec<PunctualLight>) -> Scene {
    let material = subsurface(SIGMA_A, SIGMA_S, ANISOTROPY, ETA, 0.0);
    let mut description = single(cuboid(Vec3::splat(0.5)), material, environment);
    description.instances = vec![place(0, glam::Affine3A::from_translation(Vec3::new(0.0, 0.0, -0.25)))];
    description.lights = lights;
    Scene::build(description).expect("builds")
}

fn light(kind: PunctualKind, position: Vec3, intensity: f32) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(intensity),
        position,
        direction: Vec3::NEG_Z,
        range: None,
        kind,
    }
}

fn options_of(model: &str, direction: DVec3, pixels: u32, spp: u32) -> RenderOptions {
    let camera = ortho(-direction.as_vec3(), 0.5, 1e-6);
    options(camera, pixels, spp).with(|o| {
        o.settings.subsurface = model.to_owned();
        o.settings.seed = seed_of(model);
    })
}

fn transmitted(cos: f64) -> f64 {
    1.0 - f64::from(fresnel::dielectric(cos as f32, ETA))
}

fn white() -> EnvironmentDescription {
    EnvironmentDescription::Constant(Vec3::ONE)
}

fn dark() -> EnvironmentDescription {
    EnvironmentDescription::Constant(Vec3::ZERO)
}

/// ∫ f(ω) cos θ dω over the upper hemisphere, the integrand smooth in cos θ and the azimuth.
fn hemisphere(f: impl Fn(DVec3) -> f64) -> f64 {
    const STEPS: u32 = 160;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let cos = (f64::from(i) + 0.5) / f64::from(STEPS);
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..STEPS {
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(STEPS);
            sum += cos * f(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
        }
    }
    sum * TAU / f64::from(STEPS * STEPS)
}

/// Two views: along the normal, and 50° from it.
fn views() -> [DVec3; 2] {
    let (sin, cos) = 50f64.to_radians().sin_cos();
    [DVec3::Z, DVec3::new(sin, 0.0, cos)]
}

/// Uniform light: what the boundary reflects, and the integral of the BRDF.
#[test]
fn brdf_models_reflect_what_their_integrals_say() {
    let scene = block(white(), Vec::new());
    for (i, view) in views().into_iter().enumerate() {
        let reflected = 1.0 - transmitted(view.z);
        let brdf = |c: usize| BrdfApproximation::new(&coefficients(c));
        let integral = |f: &dyn Fn(DVec3) -> f64| reflected + hemisphere(f);
        let expected = [0, 1, 2].map(|c| integral(&|wi| brdf(c).eval(wi, view, DVec3::Z)));
        let estimate = measure(&scene, &options_of("brdf-approximation", view, 32, 128));
        // The quadrature is exact to 1e-4.
        estimate.assert_matches(expected, expected.map(|e| 1e-4 * e), &format!("view {i}, BRDF"));

        let unrefracted = |c: usize| brdf(c).with_cosines(Cosines::Unrefracted);
        let expected = [0, 1, 2].map(|c| integral(&|wi| unrefracted(c).eval(wi, view, DVec3::Z)));
        let mut models = Registry::standard();
        models.register(Box::new(subsurface::BrdfApproximation { cosines: Cosines::Unrefracted }));
        let rendered = render_with(&scene, &options_of("brdf-approximation", view, 32, 128), &(), &models);
        let pixels = rendered.expect("renders").picture.pixels;
        let values: Vec<_> = pixels.iter().map(|p| p.as_dvec3().to_array()).collect();
        let what = format!("view {i}, unrefracted cosines");
        Estimate::of(&values).assert_matches(expected, expected.map(|e| 3e-4 * e), &what);

        let expected = [0, 1, 2].map(|c| integral(&|wi| brdf(c).single(wi, view, DVec3::Z)));
        let estimate = measure(&scene, &options_of("single-scattering", view, 32, 256));
        estimate.assert_matches(expected, expected.map(|e| 1e-4 * e), &format!("view {i}, single"));

        // Both terms; that of diffusion is radial and does not care for the view.
        let diffuse = 1.0 - f64::from(fresnel::diffuse_reflectance(ETA));
        let expected = [0, 1, 2].map(|c| {
            expected[c] + transmitted(view.z) * ClassicalDipole::new(&coefficients(c)).total() * diffuse
        });
        let estimate = measure(&scene, &options_of("dipole", view, 32, 256));
        estimate.assert_matches(expected, expected.map(|e| 2e-4 * e), &format!("view {i}, dipole"));
    }
}

/// A point light off the normal, a few mean free paths away: the integral along the view ray.
#[test]
fn single_scattering_connects_to_a_point_light() {
    let at = DVec3::new(2e-3, 1e-3, 4e-3);
    let scene = block(dark(), vec![light(PunctualKind::Point, at.as_vec3(), 1e-4)]);
    let estimate = measure(&scene, &options_of("single-scattering", DVec3::Z, 48, 64));
    let expected = [0, 1, 2].map(|i| {
        let c = coefficients(i);
        const STEPS: u32 = 20_000;
        let step = 30.0 / c.sigma_t() / f64::from(STEPS);
        let along = |k: u32| {
            let s_o = (f64::from(k) + 0.5) * step;
            let to_light = at + DVec3::new(0.0, 0.0, s_o);
            let wi = to_light.normalize();
            let connection =
                Connection { n_i: DVec3::Z, n_o: DVec3::Z, wi, wo: DVec3::Z, s_i: s_o / wi.z, s_o };
            let term = connection.evaluate(&c).expect("both cross");
            term.integrand * term.physical_factor * 1e-4 / to_light.length_squared() * step
        };
        (0..STEPS).map(along).sum()
    });
    estimate.assert_matches(expected, [0.0; 3], "single scattering of a point light");
}

/// The directional dipole under a spot light's disk (its profile, near and far) and under uniform light (its integral
/// over all points and directions).
#[test]
fn the_directional_dipole_is_its_formula() {
    const ANGLE: f64 = 0.5;
    let exit = directional::Exit { x: DVec3::ZERO, n: DVec3::Z };
    let models = [0, 1, 2].map(|c| DirectionalDipole::new(&coefficients(c)));
    let crossed = |model: &DirectionalDipole, r: f64, w: DVec3| {
        let entry = directional::Entry { x: DVec3::new(r, 0.0, 0.0), n: DVec3::Z, w };
        transmitted(w.z) * model.s_d(&entry, &exit) * w.z
    };
    for (radius, spp) in [(3e-4f64, 256), (1e-3, 64), (3e-3, 48)] {
        let height = radius / ANGLE.tan();
        let kind = PunctualKind::Spot { inner: ANGLE as f32, outer: ANGLE as f32 };
        let position = Vec3::new(0.0, 0.0, height as f32);
        let scene = block(dark(), vec![light(kind, position, (height * height) as f32)]);
        let estimate = measure(&scene, &options_of("directional-dipole", DVec3::Z, 48, spp));
        let expected = [0, 1, 2].map(|i| {
            let ring = |r: f64| {
                let squared = height * height + r * r;
                let w = DVec3::new(-r, 0.0, height) / squared.sqrt();
                let ramp = ((w.z - ANGLE.cos()) / 0.001).clamp(0.0, 1.0);
                crossed(&models[i], r, w) * height * height * ramp * ramp / squared
            };
            transmitted(1.0) * radial_integral(radius, ring)
        });
        let what = format!("directional dipole, disk of {radius} m");
        estimate.assert_matches(expected, expected.map(|e| 1e-3 * e), &what);
    }
    let scene = block(white(), Vec::new());
    let estimate = measure(&scene, &options_of("directional-dipole", DVec3::Z, 48, 256));
    let expected = [0, 1, 2].map(|i| {
        let uniform = logarithmic_integral(|r| hemisphere_of_cosines(|w| crossed(&models[i], r, w) / w.z));
        1.0 - transmitted(1.0) + transmitted(1.0) * uniform
    });
    // The coarser quadrature.
    estimate.assert_matches(expected, expected.map(|e| 1e-3 * e), "directional dipole, uniform light");
}

/// ∫ f 2πr dr up to `edge`, radii crowding at 0.
fn radial_integral(edge: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 20_000;
    let at = |k: f64| edge * (k / f64::from(STEPS)).powi(3);
    (0..STEPS)
        .map(f64::from)
        .map(|k| {
            let r = at(k + 0.5);
            f(r) * TAU * r * (at(k + 1.0) - at(k))
        })
        .sum()
}

/// ∫ f 2πr dr over the plane.
fn logarithmic_integral(f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 220;
    let step = (1.0f64 / 1e-6).ln() / f64::from(STEPS);
    let term = |k: u32| {
        let r = 1e-6 * ((f64::from(k) + 0.5) * step).exp();
        f(r) * TAU * r * r * step
    };
    (0..STEPS).map(term).sum()
}

/// As [`hemisphere`], symmetric about y = 0 and coarser.
fn hemisphere_of_cosines(f: impl Fn(DVec3) -> f64) -> f64 {
    const STEPS: u32 = 48;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let cos = (f64::from(i) + 0.5) / f64::from(STEPS);
        let sin = (1.0 - cos * cos).sqrt();
        for j in 0..STEPS {
            let phi = PI * (f64::from(j) + 0.5) / f64::from(STEPS);
            sum += cos * f(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos));
        }
    }
    sum * TAU / f64::from(STEPS * STEPS)
}

/// The sun in the zenith: F_t² E (f_r + α/8π), since depth and way out are the same.
#[test]
fn the_preview_is_brdf_and_attenuated_light() {
    let scene = block(dark(), vec![light(PunctualKind::Directional, Vec3::Z, 2.0)]);
    let estimate = measure(&scene, &options_of("light-biased", DVec3::Z, 32, 128));
    let expected = [0, 1, 2].map(|c| {
        let c = coefficients(c);
        let shone = transmitted(1.0).powi(2) * c.albedo() / (8.0 * PI);
        2.0 * (BrdfApproximation::new(&c).eval(DVec3::Z, DVec3::Z, DVec3::Z) + shone)
    });
    estimate.assert_matches(expected, [0.0; 3], "light-biased");
}
