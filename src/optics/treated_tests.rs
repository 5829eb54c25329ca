use super::super::DielectricBoundary;
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::*;

fn treated(alpha: f32) -> TreatedBoundary {
    TreatedBoundary::new(1.5, Facets::isotropic(alpha), Microfacet::Multiple, Vec3::ONE)
}

/// Without a treatment it is the bare boundary.
#[test]
fn untreated_is_the_bare_boundary() {
    let mut rng = Rng::new(6);
    for alpha in [0.1f32, 0.5, 1.0] {
        let (t, b) = (treated(alpha), DielectricBoundary::new(1.5, alpha, Microfacet::Multiple));
        for _ in 0..300 {
            let wo = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let wi = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let (f, g) = (t.eval_pdf(wo, wi).0, b.eval(wo, wi));
            // Tables of facets with two widths are coarser than those of one. At α 0.1 and near the horizon what comes
            // back is up to 0.01 a steradian off, which goes to or comes from the other side: the sum over both is
            // kept.
            let coarse = if alpha < 0.3 { 1.2e-2 } else { 2e-3 };
            assert!((f - g).abs().max_element() < 2e-3 * g.x + coarse, "{wo} {wi}: {f} for {g}");
        }
    }
}

/// KHR_materials_specular: at normal incidence a smooth boundary reflects 0.04 s color and lets the rest cross.
#[test]
fn specular_scales_and_tints_the_reflection() {
    let color = Vec3::new(1.0, 0.5, 2.0);
    for factor in [0.0f32, 0.4, 1.0] {
        let t = treated(0.0).with_specular(factor, color);
        let m = t.meet(1.0, true);
        assert!((m.reflected - 0.04 * color * factor).abs().max_element() < 1e-6);
        let grazing = t.meet(1e-4, true).reflected;
        assert!((grazing - Vec3::splat(factor)).abs().max_element() < 2e-3, "{grazing}");
        assert_eq!(t.meet(0.3, false).reflected, Vec3::ONE, "total internal reflection");
    }
}

/// Rough, and rough and tinted: reciprocal, sampled as evaluated, and of all energy in every direction.
#[test]
fn rough_treated_boundaries_conserve_energy() {
    let mut worst = 0.0f32;
    for alpha in [0.1f32, 0.3, 0.6, 1.0] {
        let film = ThinFilm::new(1.8, 500.0, Vec3::splat(0.04));
        let plain = treated(alpha);
        for t in [plain, plain.with_specular(0.3, Vec3::ONE), plain.with_film(1.0, film)] {
            for cos in [-0.9f32, -0.5, 0.2, 0.9] {
                let wo = direction(cos, 0.0);
                let scale = if cos > 0.0 { 2.25 } else { 1.0 / 2.25 };
                let e = hemisphere(cos.signum(), 200, |wi| t.eval_pdf(wo, wi).0.x)
                    + scale * hemisphere(-cos.signum(), 200, |wi| t.eval_pdf(wo, wi).0.x);
                worst = worst.max((e - 1.0).abs());
                assert!((e - 1.0).abs() < 0.01, "alpha {alpha}, cos {cos}: {e}");
                let mut rng = Rng::new(9);
                for _ in 0..100 {
                    let wi = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
                    let n = |w: Vec3| if w.z > 0.0 { 1.0 } else { 2.25 };
                    let there = t.eval_pdf(wo, wi).0.y / (wi.z.abs() * n(wo));
                    let back = t.eval_pdf(wi, wo).0.y / (wo.z.abs() * n(wi));
                    assert!((there - back).abs() < 2e-3 * there + 1e-5, "{wi}: {there} {back}");
                }
            }
            let wo = direction(0.9, 1.0);
            let z =
                chi_square(2, 30_000, |wi| t.eval_pdf(wo, wi).1, |rng| t.sample(wo, rng.next(), rng.vec2()));
            assert!(z < 4.0, "z = {z}");
        }
    }
    println!("largest |energy - 1|: {worst}");
}
