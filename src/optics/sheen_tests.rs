use super::super::test_support::{Rng, direction, hemisphere};
use super::*;
use std::f32::consts::PI;

/// The specification's formula, written out again, where it conserves energy.
#[test]
fn the_lobe_is_the_specifications() {
    let mut rng = Rng::new(4);
    for _ in 0..200 {
        let roughness = 0.25 + 0.75 * rng.next();
        let alpha_g = roughness * roughness;
        let (v, l) = (direction(0.05 + 0.95 * rng.next(), 1.0), direction(0.05 + 0.95 * rng.next(), 4.0));
        let h = (v + l).normalize();
        let inv_r = 1.0 / alpha_g;
        let sin2 = 1.0 - h.z * h.z;
        let d = (2.0 + inv_r) * sin2.powf(0.5 * inv_r) / (2.0 * PI);
        let curve = |x: f32| {
            let k = (1.0 - alpha_g) * (1.0 - alpha_g);
            let lerp = |from: f32, to: f32| from * (1.0 - k) + to * k;
            lerp(21.5473, 25.3245) / (1.0 + lerp(3.82987, 3.32435) * x.powf(lerp(0.19823, 0.16801)))
                + lerp(-1.97760, -1.27393) * x
                + lerp(-4.32054, -4.85967)
        };
        let lambda =
            |x: f32| if x < 0.5 { curve(x).exp() } else { (2.0 * curve(0.5) - curve(1.0 - x)).exp() };
        let expected = d / ((1.0 + lambda(v.z) + lambda(l.z)) * 4.0 * v.z * l.z);
        let color = Vec3::new(1.0, 0.5, 0.0);
        let found = Sheen::new(color, roughness).eval(v, l) / l.z;
        assert!(
            (found - color * expected).abs().max_element() < 2e-3 * expected + 1e-6,
            "{found} {expected}"
        );
    }
}

/// E of the specification's formula by another program: 2000 × 1500 midpoints in double precision.
#[test]
fn fibres_reflect_what_the_specifications_formula_integrates_to() {
    let cosines = [0.1f32, 0.3, 0.7, 1.0];
    for (roughness, expected) in [
        (0.3f32, [0.540_86f32, 0.219_86, 0.028_79, 0.000_97]),
        (0.5, [0.566_62, 0.321_38, 0.104_86, 0.026_98]),
        (0.7, [0.651_17, 0.415_59, 0.185_59, 0.085_19]),
        (1.0, [0.720_51, 0.490_91, 0.264_32, 0.163_76]),
    ] {
        let fibres = Sheen::new(Vec3::ONE, roughness);
        for (mu, e) in cosines.into_iter().zip(expected) {
            // Tables have 24 roughnesses and 64 cosines.
            let found = fibres.albedo(mu);
            assert!((found - e).abs() < 2e-3, "roughness {roughness}, cos {mu}: {found} for {e}");
        }
    }
}

/// Upright fibres too, of which the formula makes up to four times the light that meets them.
#[test]
fn fibres_reflect_what_the_table_says_and_not_more_than_everything() {
    for r in [0.05f32, 0.07, 0.1, 0.2, 0.3, 0.6, 1.0] {
        let s = Sheen::new(Vec3::ONE, r);
        for mu in [0.02f32, 0.05, 0.3, 0.8, 1.0] {
            let e = hemisphere(1.0, 200, |wi| s.eval(direction(mu, 0.0), wi).x);
            println!("r {r} mu {mu}: {e} table {}", s.albedo(mu));
            // What interpolation between the tables is off by, most of it near the horizon.
            let error = if mu < 0.1 { 0.06 } else { 8e-3 };
            assert!((e - s.albedo(mu)).abs() < error && e < 1.01, "r {r}, mu {mu}: {e}, {}", s.albedo(mu));
        }
    }
}
