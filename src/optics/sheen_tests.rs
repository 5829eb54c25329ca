use super::super::test_support::{Rng, direction, hemisphere};
use super::*;
use std::f32::consts::PI;

/// The specification's formula, written out again.
#[test]
fn the_lobe_is_the_specifications() {
    let mut rng = Rng::new(4);
    for _ in 0..200 {
        let r = 0.1 + 0.9 * rng.next();
        let (v, l) = (direction(0.05 + 0.95 * rng.next(), 1.0), direction(0.05 + 0.95 * rng.next(), 4.0));
        let h = (v + l).normalize();
        let inv_r = 1.0 / r;
        let sin2 = 1.0 - h.z * h.z;
        let d = (2.0 + inv_r) * sin2.powf(0.5 * inv_r) / (2.0 * PI);
        let curve = |x: f32| {
            let k = (1.0 - r) * (1.0 - r);
            let lerp = |from: f32, to: f32| from * (1.0 - k) + to * k;
            lerp(21.5473, 25.3245) / (1.0 + lerp(3.82987, 3.32435) * x.powf(lerp(0.19823, 0.16801)))
                + lerp(-1.97760, -1.27393) * x
                + lerp(-4.32054, -4.85967)
        };
        let lambda =
            |x: f32| if x < 0.5 { curve(x).exp() } else { (2.0 * curve(0.5) - curve(1.0 - x)).exp() };
        let expected = d / ((1.0 + lambda(v.z) + lambda(l.z)) * 4.0 * v.z * l.z);
        let color = Vec3::new(1.0, 0.5, 0.0);
        let found = Sheen::new(color, r).eval(v, l) / l.z;
        assert!(
            (found - color * expected).abs().max_element() < 2e-3 * expected + 1e-6,
            "{found} {expected}"
        );
    }
}

#[test]
fn fibres_reflect_what_the_table_says_and_not_more_than_everything() {
    for r in [0.1f32, 0.3, 0.6, 1.0] {
        let s = Sheen::new(Vec3::ONE, r);
        for mu in [0.05f32, 0.3, 0.8, 1.0] {
            let e = hemisphere(1.0, 200, |wi| s.eval(direction(mu, 0.0), wi).x);
            println!("r {r} mu {mu}: {e} table {} residue {}", s.albedo(mu), s.residue(mu, 1.0, 0.0));
            assert!((e - s.albedo(mu)).abs() < 8e-3 && e < 1.0, "r {r}, mu {mu}: {e}, {}", s.albedo(mu));
        }
    }
}
