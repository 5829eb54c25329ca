use super::super::anisotropic::Facets;
use super::super::boundary::Microfacet;
use super::super::metallic_roughness::SurfaceParameters;
use super::super::substrate::{Substrate, SubstrateParameters};
use super::super::test_support::{Rng, chi_square, direction, hemisphere};
use super::super::thin_film::ThinFilm;
use super::super::treated::TreatedBoundary;
use super::super::{CoatParameters, DielectricBoundary, Fuzz};
use super::*;

fn plain(metallic: f32, alpha: f32, transmission: f32) -> SurfaceParameters {
    SurfaceParameters { metallic, alpha, transmission, ..SurfaceParameters::default() }
}

fn surface(p: SurfaceParameters) -> Base {
    Base::surface(&p)
}

fn substrate(plain: SurfaceParameters) -> SubstrateParameters {
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

fn coat(alpha: f32) -> Option<Coat> {
    Some(Coat::new(1.0, alpha))
}

fn boundary(eta: f32, alpha: f32) -> Base {
    Base::Boundary(DielectricBoundary::new(eta, alpha, Microfacet::Multiple), Vec3::ONE)
}

/// Materials that absorb nothing, the error of their energy, and the index of what is below.
fn white() -> Vec<(String, Layered, f32, f32)> {
    let mut all = Vec::new();
    let mut add = |what: String, layered, error, eta| all.push((what, layered, error, eta));
    let fibres = |r| Some(Sheen::new(Vec3::ONE, r));
    for a in [0.3f32, 0.6, 1.0] {
        for c in [0.0f32, 0.3, 1.0] {
            for (metallic, t) in [(0.0f32, 0.0f32), (1.0, 0.0), (0.0, 1.0), (0.3, 0.3)] {
                let base = surface(plain(metallic, a, t));
                add(
                    format!("coat {c} on {metallic} {a} {t}"),
                    Layered::new(coat(c), None, base, None),
                    0.01,
                    1.0,
                );
            }
            let base = boundary(1.5, a);
            add(format!("coat {c} on glass {a}"), Layered::new(coat(c), None, base, None), 0.025, 1.5);
        }
        for r in [0.2f32, 0.5, 1.0] {
            let base = surface(plain(0.0, a, 0.0));
            add(format!("sheen {r} on {a}"), Layered::new(None, fibres(r), base, None), 0.01, 1.0);
        }
        let mut p = substrate(plain(0.0, a, 0.0));
        p.diffuse_transmission = (0.4, Vec3::ONE);
        let base = Base::Substrate(Substrate::new(&p));
        add(format!("leaf {a}"), Layered::new(None, None, base, None), 2e-3, 1.0);
        let mut p = substrate(plain(0.0, a, 0.7));
        p.scatter = (0.6, Vec3::ONE, 0.3);
        let base = Base::Substrate(Substrate::new(&p));
        add(format!("paper {a}"), Layered::new(None, None, base, None), 2e-3, 1.0);
        for metallic in [0.0f32, 1.0] {
            let mut p = substrate(plain(metallic, a, 0.0));
            p.facets.alpha.x = a + (1.0 - a) * 0.36;
            p.facets.tangent = Vec2::new(0.6, 0.8);
            let base = Base::Substrate(Substrate::new(&p));
            add(format!("brushed {metallic} {a}"), Layered::new(None, None, base, None), 0.015, 1.0);
        }
    }
    all
}

fn energy(l: &Layered, wo: Vec3, eta: f32) -> f32 {
    let scale = if wo.z > 0.0 { eta * eta } else { 1.0 / (eta * eta) };
    let over = |sign: f32| {
        // Not symmetric about the plane of incidence: all azimuths.
        let even = hemisphere(sign, 120, |wi| l.eval_pdf(wo, wi).0.x);
        let odd = hemisphere(sign, 120, |wi| l.eval_pdf(wo, Vec3::new(wi.x, -wi.y, wi.z)).0.x);
        0.5 * (even + odd)
    };
    let side = wo.z.signum();
    over(side) + scale * over(-side)
}

/// Light that a smooth coat reflects into one direction is counted apart.
fn mirrored(l: &Layered, wo: Vec3) -> f32 {
    match &l.stack.coat {
        Some(coat) if coat.is_smooth() => l.held(wo).coat,
        _ => 0.0,
    }
}

/// Materials whose layers take light away.
fn tinted() -> Vec<(String, Layered, f32)> {
    let color = Vec3::new(0.9, 0.4, 0.1);
    let coat = |alpha: Vec2, weight| {
        Some(Coat::with(&CoatParameters { weight, alpha, ior: 1.6, color, darkening: 0.8 }))
    };
    let fuzz = Some(Fuzz::new(0.8, color, 0.4));
    let base = |metallic, t| {
        let base_color = Vec3::new(0.8, 0.5, 0.3);
        surface(SurfaceParameters { base_color, ..plain(metallic, 0.3, t) })
    };
    let mut rough = substrate(plain(0.0, 0.3, 0.0));
    rough.plain.base_color = Vec3::new(0.8, 0.5, 0.3);
    rough.diffuse_roughness = 0.9;
    rough.diffuse_transmission = (0.4, color);
    let rough = Base::Substrate(Substrate::new(&rough));
    let none = Stack::default();
    let all = [
        ("coat on plastic", Stack { coat: coat(Vec2::splat(0.3), 1.0), ..none }, base(0.0, 0.0), 1.0f32),
        ("coat on metal", Stack { coat: coat(Vec2::new(0.6, 0.2), 0.6), ..none }, base(1.0, 0.0), 1.0),
        ("coat on a wall", Stack { coat: coat(Vec2::splat(0.1), 1.0), ..none }, base(0.3, 0.6), 1.0),
        ("coat on glass", Stack { coat: coat(Vec2::splat(0.3), 1.0), ..none }, boundary(1.5, 0.4), 1.5),
        ("fuzz on plastic", Stack { fuzz, ..none }, base(0.0, 0.0), 1.0),
        ("fuzz on glass", Stack { fuzz, ..none }, boundary(1.5, 0.4), 1.5),
        ("fuzz on a coat", Stack { fuzz, coat: coat(Vec2::splat(0.2), 1.0), sheen: None }, rough, 1.0),
        ("plaster leaf", none, rough, 1.0),
    ];
    all.into_iter()
        .map(|(name, stack, base, eta)| {
            let mut l = Layered::stacked(stack, base, None)
                .with_coat_normal(Vec3::new(0.2, 0.1, 1.0).normalize())
                .with_coat_tangent(Vec3::new(0.5, 1.0, 0.0).normalize())
                .with_fuzz_normal(Vec3::new(0.1, 0.05, 1.0).normalize());
            l.place(&Mat3::IDENTITY);
            (name.to_owned(), l, eta)
        })
        .collect()
}

/// With normals and tangents of their own, and what they absorb.
#[test]
fn tinted_layers_take_light_away_and_are_sampled_by_their_density() {
    let mut rng = Rng::new(31);
    for (what, l, eta) in tinted() {
        for cos in [-0.6f32, 0.5, 0.95] {
            let wo = direction(cos, 2.0);
            let e = energy(&l, wo, eta);
            assert!(e < 1.0, "{what}, cos {cos}: {e}");
            for _ in 0..60 {
                let Some(s) = l.sample(wo, rng.next(), rng.vec2()).filter(|s| !s.delta) else { continue };
                let (f, pdf) = l.eval_pdf(wo, s.wi);
                assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{what}: {pdf} {}", s.pdf);
                assert!((f / pdf - s.weight).abs().max_element() < 1e-3 * s.weight.max_element() + 1e-6);
            }
        }
        let wo = direction(0.7, 2.0);
        let z = chi_square(6, 30_000, |wi| l.eval_pdf(wo, wi).1, |rng| l.sample(wo, rng.next(), rng.vec2()));
        assert!(z < 4.0, "{what}: z = {z}");
    }
}

/// The same without normals of their own: f is symmetric.
#[test]
fn tinted_layers_are_reciprocal() {
    let mut rng = Rng::new(32);
    for (what, mut l, eta) in tinted() {
        if let Some(coat) = &mut l.stack.coat {
            coat.set_frame(Mat3::from_rotation_z(0.4));
        }
        if let Some(fuzz) = &mut l.stack.fuzz {
            fuzz.set_frame(Mat3::IDENTITY);
        }
        for _ in 0..80 {
            let a = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let b = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            if a.z.abs().min(b.z.abs()) < 0.02 {
                continue;
            }
            let n = |w: Vec3| if w.z > 0.0 { 1.0 } else { eta * eta };
            let there = l.eval_pdf(a, b).0 / (b.z.abs() * n(a));
            let back = l.eval_pdf(b, a).0 / (a.z.abs() * n(b));
            let error = 3e-3 * there.max(back) + Vec3::splat(1e-5);
            assert!((there - back).abs().cmple(error).all(), "{what} {a} {b}: {there} {back}");
        }
    }
}

#[test]
fn white_layered_materials_lose_nothing() {
    let mut worst: Vec<(f32, String)> = Vec::new();
    for (what, l, error, eta) in white() {
        for cos in [-0.6f32, 0.05, 0.3, 0.7, 1.0] {
            let wo = direction(cos, 0.0);
            let e = energy(&l, wo, eta) + mirrored(&l, wo);
            worst.push(((e - 1.0).abs() / error, format!("{what}, cos {cos}: {e}")));
        }
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (w, what) in worst.iter().take(12) {
        println!("{w:.2} {what}");
    }
    assert!(worst[0].0 < 1.0, "{}", worst[0].1);
}

#[test]
fn reciprocal() {
    let mut rng = Rng::new(12);
    for (what, l, _, eta) in white() {
        for _ in 0..60 {
            let a = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            let b = direction(2.0 * rng.next() - 1.0, 6.0 * rng.next());
            if a.z.abs().min(b.z.abs()) < 0.01 {
                continue;
            }
            let n = |w: Vec3| if w.z > 0.0 { 1.0 } else { eta * eta };
            // f(i → o)/n_o² is symmetric; eval multiplies by |cos θ_i|.
            let there = l.eval_pdf(a, b).0.x / (b.z.abs() * n(a));
            let back = l.eval_pdf(b, a).0.x / (a.z.abs() * n(b));
            assert!((there - back).abs() < 2e-3 * there.max(back) + 1e-5, "{what} {a} {b}: {there} {back}");
        }
    }
}

#[test]
fn samples_follow_their_density_and_carry_value_over_density() {
    let mut rng = Rng::new(3);
    for (k, (what, l, _, _)) in white().into_iter().enumerate() {
        let wo = direction([-0.6f32, 0.15, 0.9][k % 3], 2.0);
        for _ in 0..60 {
            let Some(s) = l.sample(wo, rng.next(), rng.vec2()).filter(|s| !s.delta) else { continue };
            let (f, pdf) = l.eval_pdf(wo, s.wi);
            assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{what}: {pdf} {}", s.pdf);
            assert!((f / pdf - s.weight).abs().max_element() < 1e-3 * s.weight.max_element() + 1e-6);
            assert_eq!(s.transmitted, s.wi.z * wo.z < 0.0);
        }
        if k % 3 != 0 && wo.z > 0.5 {
            let z =
                chi_square(6, 30_000, |wi| l.eval_pdf(wo, wi).1, |rng| l.sample(wo, rng.next(), rng.vec2()));
            assert!(z < 4.0, "{what}: z = {z}");
        }
    }
}

/// The mean weight of samples is the energy, deltas included; |z| < 4.
#[test]
fn samples_of_smooth_layers_carry_all_energy() {
    let film = ThinFilm::new(1.3, 400.0, Vec3::splat(0.04));
    let treated = TreatedBoundary::new(1.5, Facets::isotropic(0.0), Microfacet::Multiple, Vec3::ONE)
        .with_specular(0.5, Vec3::new(1.0, 0.2, 3.0))
        .with_film(0.5, film);
    let smooth = [
        (Layered::new(coat(0.0), None, surface(plain(1.0, 0.0, 0.0)), None), 1.0f32, 1e-3),
        (Layered::new(coat(0.0), None, surface(plain(0.0, 0.0, 1.0)), None), 1.0, 1e-3),
        (Layered::new(coat(0.0), None, boundary(1.5, 0.0), None), 1.5, 1e-3),
        (Layered::new(None, None, Base::Treated(treated, Vec3::ONE), None), 1.5, 1e-3),
        (
            Layered::new(coat(0.0), None, boundary(1.5, 0.0), Some((surface(plain(0.5, 0.0, 0.0)), 0.5))),
            1.5,
            1e-2,
        ),
    ];
    for (k, (l, eta, error)) in smooth.iter().enumerate() {
        let mut rng = Rng::new(k as u64);
        for cos in [-0.9f32, -0.3, 0.1, 0.5, 1.0] {
            let wo = direction(cos, 1.0);
            const N: usize = 20_000;
            let (mut sum, mut squares) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
            for _ in 0..N {
                let Some(s) = l.sample(wo, rng.next(), rng.vec2()) else { continue };
                let scale = if !s.transmitted {
                    1.0
                } else if wo.z > 0.0 {
                    eta * eta
                } else {
                    1.0 / (eta * eta)
                };
                let w = (s.weight * scale).as_dvec3();
                sum += w;
                squares += w * w;
            }
            let mean = sum / N as f64;
            let sd = ((squares / N as f64 - mean * mean) / N as f64).max(glam::DVec3::ZERO).map(f64::sqrt);
            for c in 0..3 {
                assert!((mean[c] - 1.0).abs() < 4.0 * sd[c] + error, "{k}, cos {cos}: {mean} ± {sd}");
            }
        }
    }
}

/// KHR_materials_clearcoat on a black base is its microfacet lobe with f0 = 0.04, times the factor.
#[test]
fn a_coat_on_black_is_the_specification() {
    let black = surface(SurfaceParameters { base_color: Vec3::ZERO, specular: 0.0, ..plain(0.0, 0.5, 0.0) });
    let (alpha, factor) = (0.16f32, 0.7f32);
    let l = Layered::new(Some(Coat::new(factor, alpha)), None, black, None);
    let mut rng = Rng::new(5);
    for _ in 0..200 {
        let (v, n) = (direction(0.3 + 0.7 * rng.next(), 6.0 * rng.next()), Vec3::Z);
        let i = direction(0.3 + 0.7 * rng.next(), 6.0 * rng.next());
        let h = (v + i).normalize();
        let d =
            alpha * alpha / (std::f32::consts::PI * (h.dot(n).powi(2) * (alpha * alpha - 1.0) + 1.0).powi(2));
        let g = |c: f32| 2.0 * c / (c + (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt());
        let f = 0.04 + 0.96 * (1.0 - v.dot(h)).powi(5);
        let expected = factor * f * d * g(v.z) * g(i.z) / (4.0 * v.z * i.z);
        let found = l.eval_pdf(v, i).0.x / i.z;
        // What is reflected more than once is less than a hundredth of the coat's light here.
        assert!(found >= expected * 0.999 && found - expected < 1e-3, "{found} for {expected}");
    }
}
