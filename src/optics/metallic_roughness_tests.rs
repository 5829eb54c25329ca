use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::*;
use std::f32::consts::PI;

const WHITE: SurfaceParameters = SurfaceParameters {
    base_color: Vec3::ONE,
    metallic: 1.0,
    alpha: 1.0,
    ior: 1.5,
    specular: 1.0,
    specular_color: Vec3::ONE,
    transmission: 0.0,
    microfacet: Microfacet::Multiple,
};

fn energy(s: &Surface, wo: Vec3) -> f32 {
    hemisphere(1.0, 400, |wi| s.eval(wo, wi).x) + hemisphere(-1.0, 400, |wi| s.eval(wo, wi).x)
}

#[test]
fn white_surfaces_reflect_and_transmit_everything() {
    let mut worst = 0.0f32;
    for (metallic, transmission, ior) in [
        (1.0, 0.0, 1.5),
        (0.0, 0.0, 1.5),
        (0.0, 0.0, 2.4),
        (0.0, 1.0, 1.5),
        (0.4, 0.5, 1.33),
        (0.0, 0.3, 1.0),
    ] {
        for alpha in [0.3f32, 0.55, 1.0] {
            let s = Surface::new(&SurfaceParameters { metallic, transmission, ior, alpha, ..WHITE });
            for cos in [-0.5f32, 0.05, 0.3, 0.7, 1.0] {
                let e = energy(&s, direction(cos, 0.0));
                worst = worst.max((e - 1.0).abs());
                assert!((e - 1.0).abs() < 1e-3, "{metallic} {transmission} {ior} {alpha} {cos}: {e}");
            }
        }
    }
    println!("largest |albedo - 1|: {worst}");
}

/// The specification, written out again from its text.
fn khronos(p: &SurfaceParameters, v: Vec3, l: Vec3) -> Vec3 {
    let alpha = p.alpha;
    let (nv, nl) = (v.z, l.z);
    let h = (v + l).normalize();
    let (nh, vh) = (h.z, v.dot(h));
    let d = alpha * alpha / (PI * ((nh * nh) * (alpha * alpha - 1.0) + 1.0).powi(2));
    let g = |c: f32| 2.0 * c / (c + (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt());
    let specular = d * g(nv) * g(nl) / (4.0 * nv * nl);
    let w = (1.0 - vh).powi(5);
    let f0 = ((p.ior - 1.0) / (p.ior + 1.0)).powi(2) * p.specular_color * p.specular;
    let f = f0 + (Vec3::splat(p.specular) - f0) * w;
    let dielectric = (1.0 - f.max_element()) * p.base_color / PI + f * specular;
    let metal = (p.base_color + (Vec3::ONE - p.base_color) * w) * specular;
    (dielectric * (1.0 - p.metallic) + metal * p.metallic) * nl
}

#[test]
fn single_scattering_is_appendix_b() {
    let mut rng = Rng::new(17);
    for _ in 0..2000 {
        let p = SurfaceParameters {
            base_color: Vec3::new(rng.next(), rng.next(), rng.next()),
            metallic: rng.next(),
            alpha: 0.04 + 0.96 * rng.next(),
            ior: 1.0 + rng.next(),
            specular: rng.next(),
            specular_color: Vec3::new(rng.next(), rng.next(), rng.next()),
            transmission: 0.0,
            microfacet: Microfacet::Single,
        };
        let v = direction(0.05 + 0.95 * rng.next(), 6.0 * rng.next());
        let l = direction(0.05 + 0.95 * rng.next(), 6.0 * rng.next());
        let (f, expected) = (Surface::new(&p).eval(v, l), khronos(&p, v, l));
        assert!(
            (f - expected).abs().max_element() < 2e-3 * expected.max_element() + 1e-6,
            "{p:?}: {f} for {expected}"
        );
    }
}

#[test]
fn reciprocal() {
    let mut rng = Rng::new(12);
    for microfacet in [Microfacet::Single, Microfacet::Multiple] {
        for _ in 0..2000 {
            let p = SurfaceParameters {
                base_color: Vec3::new(rng.next(), 0.5, 0.1),
                metallic: rng.next(),
                alpha: 0.04 + 0.96 * rng.next(),
                transmission: rng.next(),
                microfacet,
                ..WHITE
            };
            let s = Surface::new(&p);
            let a = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let b = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let (there, back) = (s.eval(a, b) / b.z.abs(), s.eval(b, a) / a.z.abs());
            assert!((there - back).abs().max_element() < 1e-3 * there.max_element() + 1e-6, "{p:?} {a} {b}");
        }
    }
}

#[test]
fn samples_follow_their_density_and_carry_value_over_density() {
    let mut rng = Rng::new(3);
    let mut worst = 0.0f64;
    for microfacet in [Microfacet::Single, Microfacet::Multiple] {
        for (metallic, transmission) in [(1.0, 0.0), (0.0, 0.0), (0.2, 0.6)] {
            for alpha in [0.25f32, 1.0] {
                let base_color = Vec3::new(0.8, 0.4, 0.2);
                let p = SurfaceParameters { base_color, metallic, transmission, alpha, microfacet, ..WHITE };
                let s = Surface::new(&p);
                for cos in [-0.6f32, 0.1, 0.9] {
                    let wo = direction(cos, 2.0);
                    for _ in 0..200 {
                        if let Some(x) = s.sample(wo, rng.next(), rng.vec2()) {
                            let (f, pdf) = s.eval_pdf(wo, x.wi);
                            assert!((pdf / x.pdf - 1.0).abs() < 1e-3, "{pdf} {}", x.pdf);
                            assert!((f / pdf - x.weight).abs().max_element() < 1e-3 * x.weight.max_element());
                            assert_eq!(x.transmitted, x.wi.z * wo.z < 0.0);
                        }
                    }
                    let z =
                        chi_square(6, 60_000, |wi| s.pdf(wo, wi), |rng| s.sample(wo, rng.next(), rng.vec2()));
                    worst = worst.max(z);
                    let lossy = microfacet == Microfacet::Single && cos.abs() < 0.5;
                    assert!(z < 4.0 || lossy, "{p:?} {cos}: z = {z}");
                }
            }
        }
    }
    println!("largest z {worst}");
}

#[test]
fn lambertian_is_its_colour() {
    let color = Vec3::new(0.9, 0.5, 0.0);
    let s = Surface::lambertian(color);
    let (wo, wi) = (direction(0.3, 0.0), direction(0.6, 2.0));
    assert!((s.eval(wo, wi) - color * 0.6 / PI).length() < 1e-6);
    let x = s.sample(wo, 0.5, Vec2::splat(0.3)).unwrap();
    assert!((x.weight - color).length() < 1e-6 && !x.delta && !x.transmitted);
}

#[test]
fn smooth_metal_is_a_mirror_and_smooth_plastic_a_coat_on_a_diffuse_base() {
    let mirror =
        Surface::new(&SurfaceParameters { alpha: 0.0, base_color: Vec3::new(1.0, 0.8, 0.3), ..WHITE });
    let wo = direction(0.5, 1.0);
    let s = mirror.sample(wo, 0.3, Vec2::splat(0.4)).unwrap();
    assert!(mirror.is_delta() && s.delta && s.pdf == 1.0);
    assert!((s.wi - Vec3::new(-wo.x, -wo.y, wo.z)).length() < 1e-6);
    let expected = Vec3::new(1.0, 0.8, 0.3) + Vec3::new(0.0, 0.2, 0.7) * 0.5f32.powi(5);
    assert!((s.weight - expected).length() < 1e-6);

    let plastic = Surface::new(&SurfaceParameters { alpha: 0.0, metallic: 0.0, ..WHITE });
    assert!(!plastic.is_delta());
    let fresnel = 0.04 + 0.96 * 0.5f32.powi(5);
    let diffuse = hemisphere(1.0, 200, |wi| plastic.eval(wo, wi).x);
    assert!((diffuse + fresnel - 1.0).abs() < 1e-3, "{diffuse}");
    let mut rng = Rng::new(5);
    let n = 20_000;
    let mirrored: f32 = (0..n)
        .filter_map(|_| plastic.sample(wo, rng.next(), rng.vec2()))
        .filter(|s| s.delta)
        .map(|s| s.weight.x / n as f32)
        .sum();
    assert!((mirrored - fresnel).abs() < 0.01, "{mirrored} for {fresnel}");
}

#[test]
fn a_smooth_thin_wall_does_not_bend_light() {
    let s = Surface::new(&SurfaceParameters { alpha: 0.0, metallic: 0.0, transmission: 1.0, ..WHITE });
    let wo = direction(-0.7, 1.0);
    let x = s.sample(wo, 0.99, Vec2::splat(0.4)).unwrap();
    assert!(s.is_delta() && x.delta && x.transmitted && (x.wi + wo).length() < 1e-6);
    let fresnel = 0.04 + 0.96 * 0.3f32.powi(5);
    assert!((x.weight.x * x.pdf - (1.0 - fresnel)).abs() < 1e-5);
}

/// Grazing directions, extreme parameters, the ends of the unit interval: nothing but finite numbers.
#[test]
fn extremes_give_finite_numbers() {
    let mut rng = Rng::new(78);
    let ends = [0.0f32, 1e-30, 0.5, 1.0 - f32::EPSILON / 2.0];
    for k in 0..20_000 {
        let mut u = || if rng.next() < 0.5 { ends[(rng.next() * 4.0) as usize].round() } else { rng.next() };
        let p = SurfaceParameters {
            base_color: Vec3::new(u(), u(), u()),
            metallic: u(),
            alpha: u(),
            ior: [0.0, 1.0, 1.5, 3.0][k % 4],
            specular: u(),
            specular_color: Vec3::new(u(), u(), 3.0 * u()),
            transmission: u(),
            microfacet: if k % 3 == 0 { Microfacet::Single } else { Microfacet::Multiple },
        };
        let s = Surface::new(&p);
        let z = [1e-12f32, 1e-6, 1e-3, 0.5, 1.0][k % 5] * if k % 2 == 0 { 1.0 } else { -1.0 };
        let wo = direction(z, 6.0 * rng.next());
        let u_lobe = ends[(rng.next() * 4.0) as usize];
        let u = Vec2::new(ends[(rng.next() * 4.0) as usize], rng.next());
        if let Some(x) = s.sample(wo, u_lobe, u) {
            assert!(
                x.wi.is_finite() && x.weight.is_finite() && x.pdf.is_finite() && x.pdf > 0.0,
                "{p:?}: {x:?}"
            );
            assert!(x.weight.min_element() >= 0.0, "{p:?}: {x:?}");
        }
        for wi in [direction(2.0 * rng.next() - 1.0, 1.0), -wo, wo, Vec3::new(-wo.x, -wo.y, wo.z), Vec3::X] {
            let (f, pdf) = s.eval_pdf(wo, wi);
            assert!(
                f.is_finite() && pdf.is_finite() && f.min_element() >= 0.0 && pdf >= 0.0,
                "{p:?} {wo} {wi}: {f}"
            );
        }
    }
}
