use super::super::loss::Quadrature;
use super::super::microsurface_walk::walk;
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::*;

const SINGLE: Microfacet = Microfacet::Single;
const MULTIPLE: Microfacet = Microfacet::Multiple;

/// Cosines of `wo`, both sides, total internal reflection included.
const COSINES: [f32; 6] = [-0.95, -0.5, -0.1, 0.1, 0.5, 1.0];

/// Share of energy that `eval` sends back and through, with the radiance scaling undone.
fn albedo(b: &DielectricBoundary, wo: Vec3, steps: usize) -> f32 {
    let through = 1.0 / b.crossing_weight(wo).x;
    let same = hemisphere(wo.z.signum(), steps, |wi| b.eval(wo, wi).x);
    same + through * hemisphere(-wo.z.signum(), steps, |wi| b.eval(wo, wi).x)
}

#[test]
fn evaluated_energy_is_one_from_both_sides() {
    let mut worst = 0.0f32;
    for eta in [0.5f32, 0.75, 1.5, 2.4] {
        for alpha in [0.35f32, 0.65, 1.0] {
            let b = DielectricBoundary::new(eta, alpha, MULTIPLE);
            for cos in COSINES {
                let e = albedo(&b, direction(cos, 0.0), 600);
                worst = worst.max((e - 1.0).abs());
                assert!((e - 1.0).abs() < 1e-3, "eta {eta}, alpha {alpha}, cos {cos}: {e}");
            }
        }
    }
    println!("largest |albedo - 1| by quadrature of eval: {worst}");
}

/// Where lobes are too narrow for a grid: what the sampler passes through, plus what the tables say is lost, is 1.
#[test]
fn tables_hold_what_sampling_loses() {
    let mut rng = Rng::new(5);
    let mut worst = 0.0f64;
    for eta in [1.001f32, 1.01, 1.1, 1.5, 2.5] {
        for alpha in [1e-3f32, 4e-3, 0.02, 0.1, 0.45] {
            let b = DielectricBoundary::new(eta, alpha, MULTIPLE);
            let tables = BoundaryTables::get(eta);
            for cos in [-0.95f32, -0.6, -0.2, -0.03, 0.01, 0.1, 0.9] {
                let wo = direction(cos, 0.0);
                let side = b.side(wo);
                let n = 20_000;
                let (mut sum, mut squares) = (0.0f64, 0.0f64);
                for _ in 0..n {
                    let h = ggx::sample_visible(side.wo, alpha, rng.vec2());
                    let c = side.wo.dot(h).max(0.0);
                    let Interface { reflectance: f, g } = fresnel::interface(c, side.eta);
                    let mirrored = 2.0 * c * h - side.wo;
                    let bent = fresnel::refract_with(side.wo, h, c, g, side.eta);
                    let passed_r = if mirrored.z > 0.0 { b.passed(side.wo, mirrored) } else { 0.0 };
                    let passed_t = if bent.z < 0.0 && f < 1.0 { b.passed(side.wo, bent) } else { 0.0 };
                    let lost = f64::from(f * (1.0 - passed_r) + (1.0 - f) * (1.0 - passed_t));
                    sum += lost;
                    squares += lost * lost;
                }
                let mean = sum / f64::from(n);
                let sd = ((squares / f64::from(n) - mean * mean) / f64::from(n)).max(0.0).sqrt();
                let table = f64::from(tables.at(alpha).loss(usize::from(cos < 0.0), cos.abs()));
                worst = worst.max((table - mean).abs() - 4.0 * sd);
                assert!(
                    (table - mean).abs() < 4.0 * sd + 4e-4,
                    "{eta} {alpha} {cos}: {table} for {mean} ± {sd}"
                );
            }
        }
    }
    println!("largest excess over four standard errors: {worst}");
}

/// The quadrature behind the tables against one that is five times as fine, and the interpolation on top of it.
#[test]
fn tables_are_accurate_between_their_nodes() {
    let fine = Quadrature::<28, 28>::new();
    for (eta, tolerance) in [(1.02f32, 8e-4f32), (1.1, 4e-4), (1.5, 4e-4), (2.5, 4e-4)] {
        let tables = BoundaryTables::get(eta);
        let eta = tables.eta();
        let kappa = boundary_tables::correlation(eta);
        for side in 0..2 {
            let (mut worst, mut squares, mut n) = (0.0f32, 0.0, 0.0);
            for j in 0..17 {
                let alpha = MIN_ROUGH_ALPHA.powf(1.0 - (j as f32 + 0.37) / 17.0);
                for i in 0..40 {
                    let mu = ((i as f32 + 0.5) / 40.0).powi(2);
                    let lost = fine.lost(mu, alpha, if side == 0 { eta } else { 1.0 / eta }, kappa);
                    let error = (lost.reflected + lost.refracted - tables.at(alpha).loss(side, mu)).abs();
                    worst = worst.max(error);
                    squares += error * error;
                    n += 1.0;
                }
            }
            let rms = (squares / n).sqrt();
            println!("eta {eta} side {side}: worst {worst:.6}, rms {rms:.6}");
            assert!(worst < tolerance && rms < 1.5e-4, "eta {eta} side {side}: worst {worst}, rms {rms}");
        }
    }
}

/// 1 − loss against the integral of the single-scattering BSDF over directions, which shares nothing with the tables.
#[test]
fn single_scattering_albedo_matches_integration_over_directions() {
    let q = Quadrature::<28, 28>::new();
    for eta in [0.6f32, 1.33, 2.0] {
        for alpha in [0.35f32, 1.0] {
            let b = DielectricBoundary::new(eta, alpha, SINGLE);
            for cos in COSINES {
                let lost = q.lost(cos.abs(), alpha, if cos > 0.0 { eta } else { 1.0 / eta }, 0.0);
                let e = albedo(&b, direction(cos, 0.0), 600);
                let expected = 1.0 - lost.reflected - lost.refracted;
                assert!(
                    (e - expected).abs() < 1e-3,
                    "eta {eta}, alpha {alpha}, cos {cos}: {e} for {expected}"
                );
            }
        }
    }
}

#[test]
fn samples_follow_their_density() {
    let (mut worst, mut seed) = (0.0f64, 0);
    for eta in [0.7f32, 1.33, 1.5, 2.4] {
        for alpha in [0.3f32, 0.9] {
            let b = DielectricBoundary::new(eta, alpha, MULTIPLE);
            for cos in [-0.9f32, -0.5, -0.15, 0.1, 0.5, 0.95] {
                let wo = direction(cos, 0.4);
                seed += 1;
                let z =
                    chi_square(seed, 60_000, |wi| b.pdf(wo, wi), |rng| b.sample(wo, rng.next(), rng.vec2()));
                worst = worst.max(z);
                assert!(z < 4.0, "eta {eta}, alpha {alpha}, cos {cos}: z = {z}");
            }
        }
    }
    println!("largest z {worst}");
}

/// Multiple: the weight is known; Single: it is eval/pdf.
#[test]
fn weights_are_value_over_density() {
    let mut rng = Rng::new(9);
    for eta in [0.5f32, 0.999, 1.0001, 1.01, 1.5, 2.4] {
        for alpha in [0.002f32, 0.05, 0.5, 1.0] {
            for microfacet in [SINGLE, MULTIPLE] {
                let tint = Vec3::new(0.2, 0.5, 0.9);
                let b = DielectricBoundary::new(eta, alpha, microfacet).with_transmission_tint(tint);
                for _ in 0..300 {
                    let wo = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
                    let Some(s) = b.sample(wo, rng.next(), rng.vec2()) else {
                        assert!(microfacet == SINGLE, "light lost at eta {eta}, alpha {alpha}, wo {wo}");
                        continue;
                    };
                    let (f, pdf) = b.eval_pdf(wo, s.wi);
                    assert_eq!(pdf, s.pdf);
                    let ratio = f / pdf / s.weight;
                    assert!(
                        (ratio - Vec3::ONE).abs().max_element() < 1e-3,
                        "{eta} {alpha} {microfacet:?}: {ratio}"
                    );
                    assert_eq!(s.transmitted, s.wi.z * wo.z < 0.0);
                    assert!((s.wi.length() - 1.0).abs() < 1e-5);
                    let crossed = if s.transmitted { b.crossing_weight(wo) } else { Vec3::ONE };
                    if microfacet == MULTIPLE {
                        assert!((s.weight - crossed).abs().max_element() < 1e-6);
                    }
                }
            }
        }
    }
}

/// f(ω_i → ω_o)/n_o² = f(ω_o → ω_i)/n_i².
#[test]
fn reciprocal_up_to_the_squared_index() {
    let mut rng = Rng::new(21);
    for eta in [0.6f32, 1.05, 1.5, 2.2] {
        for alpha in [0.1f32, 0.5, 1.0] {
            for microfacet in [SINGLE, MULTIPLE] {
                let b = DielectricBoundary::new(eta, alpha, microfacet);
                let index = |w: Vec3| if w.z > 0.0 { 1.0 } else { eta };
                let mut compared = 0;
                for _ in 0..400 {
                    let a = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
                    let c = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
                    let there = b.eval(a, c).x / c.z.abs() / (index(a) * index(a));
                    let back = b.eval(c, a).x / a.z.abs() / (index(c) * index(c));
                    if there.max(back) > 1e-6 {
                        compared += 1;
                        assert!(
                            (there / back - 1.0).abs() < 2e-3,
                            "{eta} {alpha} {microfacet:?} {a} {c}: {there} {back}"
                        );
                    }
                }
                assert!(compared > 50);
            }
        }
    }
}

#[test]
fn smooth_boundary_is_fresnel_and_nearly_smooth_ones_tend_to_it() {
    for eta in [0.66f32, 1.5] {
        let smooth = DielectricBoundary::new(eta, 0.0, MULTIPLE);
        let nearly = DielectricBoundary::new(eta, 0.002, MULTIPLE);
        assert!(smooth.is_delta() && !nearly.is_delta());
        let mut rng = Rng::new(2);
        for cos in [-0.9f32, -0.5, 0.3, 0.8] {
            let wo = direction(cos, 1.0);
            let relative = if cos > 0.0 { eta } else { 1.0 / eta };
            let f = fresnel::dielectric(cos.abs(), relative);
            let s = smooth.sample(wo, f - 1e-4, Vec2::ZERO).unwrap();
            assert!(s.delta && !s.transmitted && s.pdf == f && s.weight == Vec3::ONE);
            assert_eq!(s.wi, Vec3::new(-wo.x, -wo.y, wo.z));
            if f < 1.0 {
                let s = smooth.sample(wo, f + 1e-4, Vec2::ZERO).unwrap();
                assert!(s.delta && s.transmitted && (s.pdf + f - 1.0).abs() < 1e-6);
                assert!((s.weight.x * relative * relative - 1.0).abs() < 1e-5);
                let sines = (s.wi.x.hypot(s.wi.y)) * relative / wo.x.hypot(wo.y);
                assert!((sines - 1.0).abs() < 1e-5 && s.wi.x * wo.x < 0.0, "Snell: {sines}");
            }
            let n = 20_000;
            let reflected =
                (0..n).filter(|_| !nearly.sample(wo, rng.next(), rng.vec2()).unwrap().transmitted).count();
            let sd = (f * (1.0 - f) / n as f32).sqrt();
            assert!((reflected as f32 / n as f32 - f).abs() < 4.0 * sd + 5e-4, "{cos}: {reflected} for {f}");
        }
    }
}

#[test]
fn matched_indices_are_invisible_whatever_the_roughness() {
    for alpha in [0.0f32, 0.1, 1.0] {
        for microfacet in [SINGLE, MULTIPLE] {
            let b = DielectricBoundary::new(1.0, alpha, microfacet);
            let wo = direction(0.2, 0.7);
            let s = b.sample(wo, 0.99, Vec2::splat(0.3)).unwrap();
            assert!(
                b.is_delta()
                    && s.delta
                    && s.transmitted
                    && s.wi == -wo
                    && s.weight == Vec3::ONE
                    && s.pdf == 1.0
            );
            assert_eq!(b.eval(wo, -wo), Vec3::ZERO);
        }
    }
}

/// As η → 1 a rough boundary disappears: nearly all light goes on within 2°, and nothing is lost.
#[test]
fn nearly_matched_indices_are_nearly_invisible() {
    let mut rng = Rng::new(4);
    for (eta, least) in [(1.0001f32, 0.998), (0.9999, 0.998), (1.001, 0.97)] {
        let b = DielectricBoundary::new(eta, 1.0, MULTIPLE);
        for cos in [-0.9f32, -0.4, 0.2, 1.0] {
            let wo = direction(cos, 0.0);
            let n = 5_000;
            let mut straight = 0;
            for _ in 0..n {
                let s = b.sample(wo, rng.next(), rng.vec2()).unwrap();
                assert!(s.pdf.is_finite() && s.wi.is_finite());
                straight += u32::from(s.wi.dot(-wo) > 0.9994);
            }
            let share = f64::from(straight) / f64::from(n);
            assert!(share > least, "eta {eta}, cos {cos}: {share}");
        }
    }
}

/// How the multiply scattered light divides, against walks on the microsurface: `docs/boundary.md` §7.
#[test]
fn division_is_close_to_a_walk_on_the_microsurface() {
    let mut rng = Rng::new(31);
    let mut worst = [0.0f32; 2];
    for eta in [1.05f32, 1.2, 1.5, 2.0] {
        for alpha in [0.2f32, 0.5, 1.0] {
            let b = DielectricBoundary::new(eta, alpha, MULTIPLE);
            for inside in [false, true] {
                let n = 6_000;
                let (mut model, mut truth) = ([0.0f32; 2], [0.0f32; 2]);
                for i in 0..n {
                    // Diffuse light.
                    let cos = ((i as f32 + rng.next()) / n as f32).sqrt();
                    let wo = direction(if inside { -cos } else { cos }, 0.0);
                    let w = walk(wo, alpha, eta, &mut rng);
                    let s = b.sample(wo, rng.next(), rng.vec2()).unwrap();
                    for (sums, wi) in [(&mut truth, w.direction), (&mut model, s.wi)] {
                        if wi.z * wo.z > 0.0 {
                            sums[0] += 1.0 / n as f32;
                        } else {
                            sums[1] += wi.dot(-wo) / n as f32;
                        }
                    }
                }
                let sd = (2.0 * truth[0] * (1.0 - truth[0]) / n as f32).sqrt();
                let difference = [(model[0] - truth[0]).abs(), (model[1] - truth[1]).abs()];
                println!("eta {eta} alpha {alpha} inside {inside}: reflected {model:?} for {truth:?} ± {sd}");
                worst = [worst[0].max(difference[0] - 4.0 * sd), worst[1].max(difference[1])];
            }
        }
    }
    println!("worst: reflectance {} beyond four standard errors, straightness {}", worst[0], worst[1]);
    assert!(worst[0] < 0.004, "reflectance differs by {} beyond four standard errors", worst[0]);
    assert!(worst[1] < 0.06, "mean cosine of transmitted light differs by {}", worst[1]);
}

/// Grazing directions, extreme indices, the ends of the unit interval: nothing but finite numbers.
#[test]
fn extremes_give_finite_numbers() {
    let mut rng = Rng::new(77);
    let ends = [0.0f32, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0];
    for eta in [0.05f32, 0.99998, 1.00002, 1.3, 30.0] {
        for alpha in [MIN_ROUGH_ALPHA, 0.04, 1.0] {
            for microfacet in [SINGLE, MULTIPLE] {
                let b = DielectricBoundary::new(eta, alpha, microfacet);
                for k in 0..2000 {
                    let z = [1e-12f32, 1e-6, 1e-3, 0.5, 1.0][k % 5] * if k % 2 == 0 { 1.0 } else { -1.0 };
                    let wo = direction(z, 6.0 * rng.next());
                    let mut u =
                        || if rng.next() < 0.3 { ends[(rng.next() * 4.0) as usize] } else { rng.next() };
                    let (u_lobe, u) = (u(), Vec2::new(u(), u()));
                    if let Some(s) = b.sample(wo, u_lobe, u) {
                        assert!(s.wi.is_finite() && s.weight.is_finite() && s.pdf.is_finite() && s.pdf > 0.0);
                        assert!((s.wi.length() - 1.0).abs() < 1e-4 && s.wi.z != 0.0, "{}", s.wi);
                    }
                    let wi = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
                    for wi in [wi, -wo, wo, Vec3::new(-wo.x, -wo.y, wo.z), Vec3::X] {
                        let (f, pdf) = b.eval_pdf(wo, wi);
                        assert!(
                            f.is_finite() && pdf.is_finite() && pdf >= 0.0,
                            "{eta} {alpha} {wo} {wi}: {f} {pdf}"
                        );
                    }
                }
            }
        }
    }
}

/// What crosses counts less: the choice between the lobes is another, what is found on average is not. Two test
/// functions for each lobe, by as many samples, |z| < 4.
#[test]
fn choosing_by_worth_changes_no_mean() {
    let mut rng = Rng::new(23);
    for (alpha, kind) in [(0.0, MULTIPLE), (0.1, SINGLE), (0.1, MULTIPLE), (0.6, MULTIPLE)] {
        let plain = DielectricBoundary::new(1.4, alpha, kind);
        let weighed = plain.with_worth_below(0.1);
        let wo = direction(0.4, 0.0);
        let mut moments = |b: &DielectricBoundary| {
            const N: u32 = 100_000;
            let (mut sum, mut squares, mut reflected) = ([0.0f64; 4], [0.0f64; 4], 0u32);
            for _ in 0..N {
                let Some(s) = b.sample(wo, rng.vec2().x, rng.vec2()) else { continue };
                reflected += u32::from(!s.transmitted);
                let at = 2 * usize::from(s.transmitted);
                let value = f64::from(s.weight.x);
                for (i, v) in [value, value * f64::from(s.wi.x)].into_iter().enumerate() {
                    sum[at + i] += v;
                    squares[at + i] += v * v;
                }
            }
            let n = f64::from(N);
            let found = std::array::from_fn(|i| {
                let mean = sum[i] / n;
                (mean, (squares[i] / n - mean * mean) / n)
            });
            (found, f64::from(reflected) / n)
        };
        let ((a, often_a), (b, often_b)): (([(f64, f64); 4], f64), _) = (moments(&plain), moments(&weighed));
        assert!(often_b > 2.0 * often_a, "alpha {alpha}: {often_a} {often_b}");
        for (i, ((mean_a, variance_a), (mean_b, variance_b))) in a.into_iter().zip(b).enumerate() {
            let z = (mean_a - mean_b) / (variance_a + variance_b).sqrt().max(1e-9);
            assert!(z.abs() < 4.0, "alpha {alpha}, moment {i}: {mean_a} {mean_b}, z {z}");
        }
    }
}
