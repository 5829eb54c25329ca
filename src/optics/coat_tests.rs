use super::super::test_support::{Rng, direction};
use super::*;

fn tinted(ior: f32, color: Vec3, darkening: f32) -> Coat {
    Coat::with(&CoatParameters { weight: 1.0, alpha: Vec2::ZERO, ior, color, darkening })
}

/// The draft: the colour at normal incidence, and the power 1/cos θ_t of it where both ways have one angle.
#[test]
fn absorption_is_the_colour_to_the_power_of_the_path() {
    let color = Vec3::new(0.9, 0.3, 0.0);
    for ior in [1.0f32, 1.4, 2.0] {
        let coat = tinted(ior, color, 0.0);
        let up = Some(Vec3::Z);
        assert!((coat.passed([up; 2], Vec3::ONE, 1.0) - color).abs().max_element() < 1e-6);
        for mu in [0.9f32, 0.5, 0.2] {
            let (o, i) = (Some(direction(mu, 0.3)), Some(direction(mu, 4.0)));
            let sin2 = (1.0 - f64::from(mu) * f64::from(mu)) / f64::from(ior).powi(2);
            let path = 1.0 / (1.0 - sin2).sqrt();
            let found = coat.passed([o, i], Vec3::ONE, 1.0);
            for c in 0..3 {
                let expected = f64::from(color[c]).powf(path);
                assert!((f64::from(found[c]) - expected).abs() < 1e-4, "{ior} {mu}: {found} {expected}");
            }
            // One way is the square root of two.
            let once = coat.passed([o, None], Vec3::ONE, 1.0);
            assert!((once * once - found).abs().max_element() < 1e-5);
        }
    }
    // Half a coat tints half of the light.
    let half =
        Coat::with(&CoatParameters { weight: 0.5, alpha: Vec2::ZERO, ior: 1.5, color, darkening: 0.0 });
    let expected = 0.5 * (Vec3::ONE + color);
    assert!((half.passed([Some(Vec3::Z); 2], Vec3::ONE, 1.0) - expected).abs().max_element() < 1e-6);
}

/// OpenPBR's (1 − K)/(1 − ρ K) is the sum of the light that a diffuse base reflects, the coat throws back, and so on:
/// ρ (1 − K) Σ (ρ K)ⁿ of the ρ that the bare base reflects; K from a quadrature of Fresnel's equations from inside.
#[test]
fn darkening_is_the_sum_of_reflections_inside() {
    for ior in [1.2f64, 1.5, 2.4] {
        let steps = 200_000;
        let mut internal = 0.0;
        for k in 0..steps {
            let mu = (f64::from(k) + 0.5) / f64::from(steps);
            let sin2 = (1.0 - mu * mu) * ior * ior;
            let reflectance = if sin2 >= 1.0 {
                1.0
            } else {
                let t = (1.0 - sin2).sqrt();
                let (s, p) = ((ior * mu - t) / (ior * mu + t), (mu - ior * t) / (mu + ior * t));
                0.5 * (s * s + p * p)
            };
            internal += 2.0 * mu * reflectance / f64::from(steps);
        }
        for rho in [0.1f64, 0.5, 0.9, 1.0] {
            let sum: f64 = (0..2000).map(|n| (1.0 - internal) * (rho * internal).powi(n)).sum();
            for darkening in [1.0f64, 0.4] {
                let coat = tinted(ior as f32, Vec3::ONE, darkening as f32);
                let ways = [Some(direction(0.4, 0.0)), Some(direction(0.9, 1.0))];
                let found = f64::from(coat.passed(ways, Vec3::splat(rho as f32), 1.0).x);
                let expected = 1.0 + darkening * (sum - 1.0);
                assert!((found - expected).abs() < 2e-4, "{ior} {rho} {darkening}: {found} for {expected}");
            }
        }
    }
}

/// A mirror below the coat: what is reflected inside is what is reflected outside at that angle.
#[test]
fn a_mirror_is_darkened_by_the_reflectance_of_the_coat() {
    let coat = tinted(1.5, Vec3::ONE, 1.0);
    for mu in [1.0f32, 0.5, 0.2] {
        let way = Some(direction(mu, 1.0));
        let f = fresnel::dielectric(mu, 1.5);
        let expected = (1.0 - f) / (1.0 - 0.6 * f);
        let found = coat.passed([way; 2], Vec3::splat(0.6), 0.0).x;
        assert!((found - expected).abs() < 1e-6, "{mu}: {found} for {expected}");
    }
}

#[test]
fn a_coat_of_index_one_and_a_half_is_the_clear_coat() {
    let mut rng = Rng::new(6);
    for alpha in [0.04f32, 0.5] {
        let clear = Coat::new(0.7, alpha);
        let coat = Coat::with(&CoatParameters {
            weight: 0.7,
            alpha: Vec2::splat(alpha),
            ior: 1.5,
            color: Vec3::ONE,
            darkening: 0.0,
        });
        assert!(!coat.is_tinted());
        for _ in 0..50 {
            let (o, i) = (direction(rng.next(), 1.0), direction(rng.next(), 6.0 * rng.next()));
            assert_eq!(clear.eval_pdf(o, i), coat.eval_pdf(o, i));
            let spread = Spread { facets: Facets::isotropic(0.0), share: 1.0, diffuse: 1.0, grazing: 0.0 };
            assert_eq!(clear.residue(o, &spread), coat.residue(o, &spread));
        }
    }
}
