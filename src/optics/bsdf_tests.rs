use super::super::metallic_roughness::SurfaceParameters;
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::super::{DiffuseExit, HenyeyGreenstein, Microfacet};
use super::*;

fn mixed(roughness: f32) -> Bsdf {
    let boundary = DielectricBoundary::new(1.4, roughness * roughness, Microfacet::Multiple);
    let surface = Surface::new(&SurfaceParameters {
        metallic: 0.3,
        alpha: roughness * roughness,
        ..Default::default()
    });
    Bsdf::Mixed(Mixed::new(boundary, surface, 0.6))
}

#[test]
fn mixed_surfaces_conserve_energy_and_sample_what_they_evaluate() {
    let mut rng = Rng::new(8);
    for roughness in [0.0f32, 0.7, 1.0] {
        let b = mixed(roughness);
        for cos in [-0.7f32, -0.2, 0.3, 0.9] {
            let wo = direction(cos, 0.0);
            if roughness > 0.0 {
                let scale = if cos > 0.0 { 1.4f32.powi(2) } else { 1.4f32.powi(-2) };
                let e = hemisphere(cos.signum(), 300, |wi| b.eval(wo, wi).x)
                    + scale * hemisphere(-cos.signum(), 300, |wi| b.eval(wo, wi).x);
                assert!((e - 1.0).abs() < 2e-3, "roughness {roughness}, cos {cos}: {e}");
                let z = chi_square(3, 60_000, |wi| b.pdf(wo, wi), |rng| b.sample(wo, rng.next(), rng.vec2()));
                assert!(z < 4.0, "z = {z}");
            }
            let n = 20_000;
            let (mut sum, mut squares) = (0.0f64, 0.0f64);
            for _ in 0..n {
                let e = b.sample(wo, rng.next(), rng.vec2()).map_or(0.0, |s| {
                    if !s.delta {
                        let (f, pdf) = b.eval_pdf(wo, s.wi);
                        assert!((f / pdf - s.weight).abs().max_element() < 1e-4 && pdf == s.pdf);
                    }
                    let undo = if s.transmitted { 1.4f64.powf(2.0 * f64::from(cos.signum())) } else { 1.0 };
                    f64::from(s.weight.x) * undo
                });
                sum += e;
                squares += e * e;
            }
            let mean = sum / f64::from(n);
            let sd = ((squares / f64::from(n) - mean * mean) / f64::from(n)).max(0.0).sqrt();
            assert!((mean - 1.0).abs() < 4.0 * sd + 1e-3, "roughness {roughness}, cos {cos}: {mean} ± {sd}");
        }
    }
}

#[test]
fn division_keeps_the_shares_of_metal_and_boundary() {
    for (metallic, transmission) in [(0.0f32, 1.0f32), (0.3, 0.5), (1.0, 1.0), (0.0, 0.0)] {
        let (share, rest) = Mixed::division(metallic, transmission);
        assert!((share - (1.0 - metallic) * transmission).abs() < 1e-6);
        assert!(((1.0 - share) * rest - metallic).abs() < 1e-6);
    }
}

#[test]
fn exit_lobe_is_normalised_and_sampled() {
    for eta in [1.0f32, 1.3, 1.5, 2.4] {
        let b = Bsdf::Exit(Box::new(DiffuseExit::new(eta)));
        let wo = direction(-0.5, 0.0);
        let e = hemisphere(1.0, 200, |wi| b.eval(wo, wi).x);
        assert!((e - 1.0).abs() < 1e-3, "eta {eta}: {e}");
        assert_eq!(b.eval(wo, direction(-0.3, 0.0)), Vec3::ZERO);
        assert!(b.sample(wo, 0.5, Vec2::splat(0.5)).is_some_and(|s| s.transmitted));
        let z = chi_square(1, 60_000, |wi| b.pdf(wo, wi), |rng| b.sample(wo, rng.next(), rng.vec2()));
        assert!(z < 4.0, "z = {z}");
    }
}

/// A phase function is a density over the sphere like any other.
#[test]
fn phase_function_samples_follow_their_density() {
    for g in [-0.6f32, 0.0, 0.3, 0.8] {
        let p = HenyeyGreenstein { g };
        let before = direction(0.3, 2.0);
        let z = chi_square(
            2,
            60_000,
            |w| p.eval(w.dot(before)),
            |rng| {
                let (wi, pdf) = p.sample(before, rng.vec2());
                Some(BsdfSample { wi, weight: Vec3::ONE, pdf, delta: false, transmitted: false })
            },
        );
        assert!(z < 4.0, "g {g}: z = {z}");
    }
}
