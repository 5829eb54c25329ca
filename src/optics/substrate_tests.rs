use super::super::metallic_roughness::Surface;
use super::super::test_support::{Rng, direction};
use super::*;
use std::f32::consts::PI;

fn parameters(plain: SurfaceParameters) -> SubstrateParameters {
    SubstrateParameters {
        plain,
        facets: Facets::isotropic(plain.alpha),
        film: None,
        diffuse_transmission: (0.0, Vec3::ONE),
        scatter: (0.0, Vec3::ONE, 1.0),
        eta: 1.0,
        diffuse_roughness: 0.0,
    }
}

/// With nothing special about it, it is the plain surface.
#[test]
fn plain_parameters_give_the_plain_surface() {
    let mut rng = Rng::new(1);
    for microfacet in [Microfacet::Single, Microfacet::Multiple] {
        for _ in 0..500 {
            let plain = SurfaceParameters {
                base_color: Vec3::new(rng.next(), 0.5, 0.1),
                metallic: rng.next(),
                alpha: 0.04 + 0.96 * rng.next(),
                specular: rng.next(),
                specular_color: Vec3::new(1.0, rng.next(), 3.0),
                transmission: rng.next(),
                microfacet,
                ..SurfaceParameters::default()
            };
            let (a, b) = (Substrate::new(&parameters(plain)), Surface::new(&plain));
            let wo = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let wi = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let (f, g) = (a.eval_pdf(wo, wi).0, b.eval(wo, wi));
            assert!((f - g).abs().max_element() < 0.01 * g.max_element() + 1e-4, "{plain:?}: {f} for {g}");
        }
    }
}

/// KHR_materials_anisotropy's D and V, written out again from its text.
#[test]
fn brushed_metal_is_the_specification() {
    let mut rng = Rng::new(2);
    for _ in 0..500 {
        let (alpha, strength) = (0.05 + 0.95 * rng.next(), rng.next());
        let plain =
            SurfaceParameters { alpha, microfacet: Microfacet::Single, ..SurfaceParameters::default() };
        let (at, ab) = (alpha * (1.0 - strength * strength) + strength * strength, alpha);
        let mut p = parameters(plain);
        p.facets = Facets { alpha: Vec2::new(at, ab), tangent: Vec2::from_angle(0.7) };
        let v = direction(0.1 + 0.9 * rng.next(), 6.0 * rng.next());
        let l = direction(0.1 + 0.9 * rng.next(), 6.0 * rng.next());
        let h = (v + l).normalize();
        let (t, b) =
            (Vec3::new(0.7f32.cos(), 0.7f32.sin(), 0.0), Vec3::new(-0.7f32.sin(), 0.7f32.cos(), 0.0));
        let a2 = at * ab;
        let f = Vec3::new(ab * t.dot(h), at * b.dot(h), a2 * h.z);
        let w2 = a2 / f.length_squared();
        let d = a2 * w2 * w2 / PI;
        // The specification's V is the height-correlated one; core glTF and this renderer take the separable one.
        let g = |w: Vec3| 2.0 * w.z / (w.z + Vec3::new(at * t.dot(w), ab * b.dot(w), w.z).length());
        let expected = d * g(v) * g(l) / (4.0 * v.z);
        let found = Substrate::new(&p).eval_pdf(v, l).0.x;
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected}");
    }
}

/// KHR_materials_diffuse_transmission without a coat: base (1 − d)/π in front, color d/π behind.
#[test]
fn a_leaf_is_the_specification() {
    let plain = SurfaceParameters {
        base_color: Vec3::new(0.2, 0.6, 0.1),
        metallic: 0.0,
        specular: 0.0,
        ..SurfaceParameters::default()
    };
    let color = Vec3::new(0.7, 0.3, 0.9);
    let mut p = parameters(plain);
    p.diffuse_transmission = (0.25, color);
    let s = Substrate::new(&p);
    let (wo, wi) = (direction(0.4, 1.0), direction(0.6, 3.0));
    let there = s.eval_pdf(wo, Vec3::new(wi.x, wi.y, -wi.z)).0;
    assert!((there - color * (0.25 * 0.6 / PI)).length() < 1e-5, "{there}");
    assert!((s.eval_pdf(wo, wi).0 - plain.base_color * (0.75 * 0.6 / PI)).length() < 1e-5);
    // KHR_materials_scatter of a thin wall: g = −0.5 sends a quarter on.
    let mut p = parameters(SurfaceParameters { transmission: 1.0, ..plain });
    p.scatter = (1.0, color, 0.25);
    let s = Substrate::new(&p);
    assert!((s.eval_pdf(wo, wi).0 - color * (0.75 * 0.6 / PI)).length() < 1e-5);
    let there = s.eval_pdf(wo, Vec3::new(wi.x, wi.y, -wi.z)).0;
    assert!((there - color * (0.25 * 0.6 / PI)).length() < 1e-5, "{there}");
}

/// Airy's sum for one wavelength after another, unpolarised and exact, through the colour matching functions: the film's
/// closed form is meant to approximate it. Index 1.3 on 1.5, near normal incidence where Schlick is exact.
#[test]
fn a_film_has_the_colours_of_airys_formula() {
    use super::super::spectrum;
    let mut worst = 0.0f32;
    for thickness in [150.0f32, 250.0, 350.0, 500.0, 700.0] {
        let film = ThinFilm::new(1.3, thickness, Vec3::splat(0.04)).reflectance(1.0);
        let (r1, r2) = ((1.0f32 - 1.3) / 2.3, (1.3f32 - 1.5) / 2.8);
        let airy = |nm: f32| {
            let delta = 4.0 * PI * 1.3 * thickness / nm;
            let (re, im) = (r1 + r2 * delta.cos(), r2 * delta.sin());
            let (dre, dim) = (1.0 + r1 * r2 * delta.cos(), r1 * r2 * delta.sin());
            (re * re + im * im) / (dre * dre + dim * dim)
        };
        let expected = spectrum::average(airy).0;
        worst = worst.max((film - expected).abs().max_element());
        println!("{thickness}: {film} for {expected}");
    }
    // Spectral colours are outside of the gamut, and are cut off by both in different ways.
    assert!(worst < 0.016, "{worst}");
}
