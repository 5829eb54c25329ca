use super::super::BsdfSample;
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::*;
use std::f64::consts::PI;

fn bare(roughness: f32) -> RoughDiffuse {
    RoughDiffuse::new(roughness, 1.0, |_| 0.0)
}

/// Listing 1 of the paper in double precision, with its exact albedo: f and the directional albedo.
fn eon(rho: f64, r: f64, o: [f64; 3], i: [f64; 3]) -> (f64, f64) {
    let af = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let e = |mu: f64| {
        let sin = (1.0 - mu * mu).sqrt();
        let g = sin * (mu.acos() - sin * mu) + 2.0 / 3.0 * (sin / mu * (1.0 - sin.powi(3)) - sin);
        af + r * af / PI * g
    };
    let average = af * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let s = o[0] * i[0] + o[1] * i[1];
    let once = rho / PI * af * (1.0 + r * if s > 0.0 { s / o[2].max(i[2]) } else { s });
    let tinted = rho * rho * average / (1.0 - rho * (1.0 - average));
    let more = tinted / PI * (1.0 - e(o[2])) * (1.0 - e(i[2])) / (1.0 - average);
    (once + more, rho * e(o[2]) + tinted * (1.0 - e(o[2])))
}

fn value(lobes: &RoughDiffuse, rho: f32, o: Vec3, i: Vec3) -> f32 {
    let [once, more] = lobes.eval(o, i, 1.0, 1.0);
    rho * once + lobes.again(Vec3::splat(rho)).x * more
}

#[test]
fn without_a_coat_it_is_the_papers_model() {
    let mut rng = Rng::new(8);
    for r in [0.05f32, 0.3, 0.7, 1.0] {
        let lobes = bare(r);
        for _ in 0..300 {
            let o = direction(0.02 + 0.98 * rng.next(), 6.0 * rng.next());
            let i = direction(0.02 + 0.98 * rng.next(), 6.0 * rng.next());
            let rho = rng.next();
            let wide = |w: Vec3| w.as_dvec3().to_array();
            let expected = eon(f64::from(rho), f64::from(r), wide(o), wide(i)).0 * f64::from(i.z);
            let found = f64::from(value(&lobes, rho, o, i));
            // The mean of E over all directions is by eight nodes.
            assert!(
                (found - expected).abs() < 1e-3 * expected + 1e-5,
                "{r} {rho} {o} {i}: {found} {expected}"
            );
        }
    }
}

/// The paper's closed form, and integrals of the lobes.
#[test]
fn directional_albedos_are_the_closed_form() {
    for r in [0.2f32, 0.6, 1.0] {
        let lobes = bare(r);
        for (mu, rho) in [(0.08f32, 1.0f32), (0.3, 0.5), (0.7, 0.9), (1.0, 0.2)] {
            let o = direction(mu, 0.0);
            let (_, expected) = eon(f64::from(rho), f64::from(r), o.as_dvec3().to_array(), [0.0, 0.0, 1.0]);
            let found = hemisphere(1.0, 300, |i| value(&lobes, rho, o, i));
            // Midpoints of the hemisphere at a lobe that is steep near the horizon.
            assert!((f64::from(found) - expected).abs() < 3e-3, "r {r}, mu {mu}: {found} for {expected}");
            let flat = f64::from(lobes.albedo(mu));
            let (_, white) = eon(1e-6, f64::from(r), o.as_dvec3().to_array(), [0.0, 0.0, 1.0]);
            assert!((flat - white * 1e6).abs() < 1e-4, "r {r}, mu {mu}: {flat}");
        }
    }
    assert!((bare(0.0).albedo(0.4) - 1.0).abs() < 1e-6, "Lambert's law");
}

#[test]
fn both_lobes_are_reciprocal_below_a_coat() {
    let mut rng = Rng::new(2);
    let share = |mu: f32| 0.96 - 0.9 * (1.0 - mu).powi(4);
    let lobes = RoughDiffuse::new(0.8, 0.85, |mu| 1.0 - share(mu));
    for _ in 0..200 {
        let a = direction(0.01 + 0.99 * rng.next(), 6.0 * rng.next());
        let b = direction(0.01 + 0.99 * rng.next(), 6.0 * rng.next());
        let there = lobes.eval(a, b, share(a.z), share(b.z)).map(|f| f / b.z);
        let back = lobes.eval(b, a, share(b.z), share(a.z)).map(|f| f / a.z);
        for (x, y) in there.into_iter().zip(back) {
            assert!((x - y).abs() < 1e-4 * x.abs().max(y.abs()) + 1e-6, "{there:?} {back:?}");
        }
    }
}

/// What gets out of a white base is what got in.
#[test]
fn white_below_a_coat_lets_out_all_that_it_lets_in() {
    let share = |mu: f32| 0.96 - 0.96 * (1.0 - mu).powi(5);
    // 1 − (0.04 + 0.96/21).
    let entering = 0.96 - 0.96 / 21.0;
    for r in [0.3f32, 1.0] {
        let lobes = RoughDiffuse::new(r, entering, |mu| 1.0 - share(mu));
        for mu in [0.05f32, 0.2, 0.5, 0.9] {
            let o = direction(mu, 0.0);
            let out = hemisphere(1.0, 300, |i| lobes.eval(o, i, share(mu), share(i.z)).iter().sum());
            assert!((out - share(mu)).abs() < 4e-3, "r {r}, mu {mu}: {out} for {}", share(mu));
        }
    }
}

#[test]
fn samples_follow_the_density_which_integrates_to_one() {
    for (r, mu) in [(0.1f32, 0.9f32), (0.5, 0.3), (1.0, 0.08), (1.0, 1.0)] {
        let lobes = bare(r);
        let o = direction(mu, 1.0);
        let total = hemisphere(1.0, 300, |i| {
            // Not symmetric about the x axis: both halves.
            0.5 * (lobes.pdf(o, i) + lobes.pdf(o, Vec3::new(i.x, -i.y, i.z)))
        });
        assert!((total - 1.0).abs() < 4e-3, "r {r}, mu {mu}: {total}");
        let z = chi_square(
            4,
            60_000,
            |i| if i.z > 0.0 { lobes.pdf(o, i) } else { 0.0 },
            |rng| {
                let wi = lobes.sample(o, rng.next(), rng.vec2());
                Some(BsdfSample { wi, weight: Vec3::ONE, pdf: 1.0, delta: false, transmitted: false })
            },
        );
        assert!(z < 4.0, "r {r}, mu {mu}: z = {z}");
    }
}

/// The paper's sampling has weights of at most about 2; cosines alone have 25 here.
#[test]
fn weights_are_small_near_the_horizon() {
    let (lobes, mut rng) = (bare(1.0), Rng::new(1));
    let o = direction(0.03, 0.5);
    for _ in 0..5000 {
        let i = lobes.sample(o, rng.next(), rng.vec2());
        if i.z > 0.0 {
            let weight = value(&lobes, 1.0, o, i) / lobes.pdf(o, i);
            assert!(weight < 2.6, "{i}: {weight}");
        }
    }
}
