use super::super::BsdfSample;
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::*;

const ROUGHNESSES: [f32; 5] = [0.1, 0.3, 0.5, 0.8, 1.0];

#[test]
fn the_bent_cosines_integrate_to_one() {
    for y in ROUGHNESSES {
        for mu in [0.05f32, 0.4, 1.0] {
            let (o, bent) = (direction(mu, 0.0), Bent::new(mu, y));
            // Squares of the cosine: of upright fibres all of it lies along the horizon.
            let total = hemisphere(1.0, 400, |w| {
                let i = direction(w.z * w.z, w.y.atan2(w.x));
                bent.kernel(o, i) * i.z * 2.0 * w.z
            });
            assert!((total - 1.0).abs() < 5e-3, "y {y}, mu {mu}: {total}");
        }
    }
}

/// The mean of both directions reflects about what the paper's lobe does, whose volume is reciprocal.
#[test]
fn the_reciprocal_lobe_reflects_about_what_the_papers_does() {
    for y in ROUGHNESSES {
        let fuzz = Fuzz::new(1.0, Vec3::ONE, y);
        for mu in [0.1f32, 0.3, 0.6, 1.0] {
            let (found, paper) = (fuzz.held(mu), reflected(mu, y));
            println!("roughness {y}, cos {mu}: {found} for {paper}");
            assert!((found - paper).abs() < 0.06, "roughness {y}, cos {mu}: {found} for {paper}");
        }
    }
}

#[test]
fn it_reflects_what_the_table_says_and_not_more_than_everything() {
    for y in [0.05f32, 0.12, 0.4, 0.75, 1.0] {
        let fuzz = Fuzz::new(1.0, Vec3::ONE, y);
        for mu in [0.03f32, 0.1, 0.3, 0.8, 1.0] {
            let o = direction(mu, 0.0);
            let e = hemisphere(1.0, 240, |w| {
                let i = direction(w.z * w.z, w.y.atan2(w.x));
                fuzz.eval_pdf(o, i).0.x * 2.0 * w.z
            });
            // What interpolation between the tables is off by, most of it near the horizon.
            let error = if mu < 0.05 { 0.03 } else { 0.01 };
            println!("roughness {y}, cos {mu}: {e}, table {}", fuzz.held(mu));
            assert!((e - fuzz.held(mu)).abs() < error && e < 1.01, "{y} {mu}: {e} {}", fuzz.held(mu));
        }
    }
}

#[test]
fn reciprocal_and_of_its_colour_and_weight() {
    let (mut rng, color) = (Rng::new(3), Vec3::new(1.0, 0.5, 0.0));
    for y in ROUGHNESSES {
        let (white, tinted) = (Fuzz::new(1.0, Vec3::ONE, y), Fuzz::new(0.25, color, y));
        for _ in 0..100 {
            let a = direction(0.02 + 0.98 * rng.next(), 6.0 * rng.next());
            let b = direction(0.02 + 0.98 * rng.next(), 6.0 * rng.next());
            let (there, back) = (white.eval_pdf(a, b).0.x / b.z, white.eval_pdf(b, a).0.x / a.z);
            assert!((there - back).abs() < 1e-3 * there.max(back) + 1e-6, "{y} {a} {b}: {there} {back}");
            let f = tinted.eval_pdf(a, b).0;
            assert!((f - 0.25 * color * there * b.z).abs().max_element() < 1e-4 * there + 1e-6);
        }
    }
}

/// Lobes that scatter back: the viewer's side of the normal is brighter.
#[test]
fn it_scatters_back() {
    let fuzz = Fuzz::new(1.0, Vec3::ONE, 0.5);
    let o = direction(0.3, 0.0);
    let towards = |phi: f32| fuzz.eval_pdf(o, direction(0.3, phi)).0.x;
    assert!(towards(0.0) > 1.25 * towards(PI), "{} {}", towards(0.0), towards(PI));
}

#[test]
fn samples_follow_the_density() {
    for (y, mu) in [(0.3f32, 0.8f32), (0.6, 0.2), (1.0, 0.5)] {
        let (fuzz, o) = (Fuzz::new(1.0, Vec3::ONE, y), direction(mu, 2.0));
        let z = chi_square(
            5,
            60_000,
            |i| if i.z > 0.0 { fuzz.eval_pdf(o, i).1 } else { 0.0 },
            |rng| {
                let wi = fuzz.sample(o, rng.next(), rng.vec2());
                Some(BsdfSample { wi, weight: Vec3::ONE, pdf: 1.0, delta: false, transmitted: false })
            },
        );
        assert!(z < 4.0, "roughness {y}, cos {mu}: z = {z}");
    }
}
