//! Every surface in white light, direction by direction: what leaves for one of what arrives.
//!
//! Energy is the mean weight of samples whose numbers fill the unit cube evenly, so that it holds for the lobes and
//! for the sampler at once, and for smooth surfaces as for rough ones.

use super::test_support::{Rng, direction};
use super::*;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

/// How far the energy of a direction may be from what it should be.
const ERROR: f32 = 0.01;
/// Cells along each edge of the cube of random numbers, with one sample in each: as many as it takes for noise to be no
/// excuse, [`NOISE`] standard errors of which count as an error, or the most.
const CELLS: [u32; 3] = [9, 20, 40];
const NOISE: f32 = 3.0;

struct White {
    name: String,
    surface: Layered,
    /// Index of what is below over that of what is above.
    eta: f32,
    /// What is expected: closed forms of surfaces that do not keep all.
    kept: Kept,
}

/// What a white surface returns.
#[derive(Clone, Copy, PartialEq)]
enum Kept {
    /// All.
    All,
    /// All of the channel of which the coat reflects most. The base gets what that leaves, 1 − max E, as
    /// KHR_materials_specular has it, so others have 1 − (max E − E).
    Strongest,
    /// A wall that facets with a film let through: they take the maximum each for itself, and together leave
    /// 1 − E\[max F\] + E\[F\], which is at most 1; films of this test come to 0.98.
    FilmedWall,
    /// All, but for what a brushed coat throws back, which takes the mean of its two widths: half a percent more.
    BrushedCoat,
}

impl Kept {
    /// How far an energy is off.
    fn off(self, e: Vec3) -> f32 {
        match self {
            Self::All => (e - Vec3::ONE).abs().max_element(),
            Self::BrushedCoat => ((e - Vec3::ONE).abs().max_element() - 0.005).max(0.0),
            Self::Strongest => (e.max_element() - 1.0).abs(),
            Self::FilmedWall => (e.max_element() - 1.0).max(0.98 - e.max_element()).max(0.0),
        }
    }
}

/// The tangent of the brushed ones.
const TURN: f32 = 0.7;

/// Mean weight of the samples of one direction, étendue undone, and the largest standard error of a channel if the samples
/// were independent. In their cells they are better than that.
fn energy(l: &Layered, wo: Vec3, eta: f32, cells: u32) -> (Vec3, f32) {
    let scale = if wo.z > 0.0 { eta * eta } else { 1.0 / (eta * eta) };
    let mut rng = Rng::new(1);
    let (mut sum, mut squares) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
    let samples = cells.pow(3);
    for k in 0..samples {
        let mut at = |k: u32| ((k % cells) as f32 + rng.next()) / cells as f32;
        let (a, u) = (at(k), Vec2::new(at(k / cells), at(k / cells / cells)));
        if let Some(s) = l.sample(wo, a, u) {
            let weight = (s.weight * if s.transmitted { scale } else { 1.0 }).as_dvec3();
            sum += weight;
            squares += weight * weight;
        }
    }
    let n = f64::from(samples);
    let (mean, square) = (sum / n, squares / n);
    (mean.as_vec3(), ((square - mean * mean).max_element().max(0.0) / n).sqrt() as f32)
}

fn plain(metallic: f32, alpha: f32, transmission: f32) -> SurfaceParameters {
    SurfaceParameters { metallic, alpha, transmission, ..SurfaceParameters::default() }
}

fn general(plain: SurfaceParameters) -> SubstrateParameters {
    SubstrateParameters {
        facets: Facets::isotropic(plain.alpha),
        plain,
        film: None,
        diffuse_transmission: (0.0, Vec3::ONE),
        scatter: (0.0, Vec3::ONE, 1.0),
        eta: 1.0,
        diffuse_roughness: 0.0,
    }
}

/// glTF's widths of a roughness (α) and a strength.
fn brushed(alpha: f32, strength: f32) -> Facets {
    let along = alpha + (1.0 - alpha) * strength * strength;
    Facets { alpha: Vec2::new(along, alpha), tangent: Vec2::from_angle(TURN) }
}

const ALPHAS: [f32; 5] = [0.0, 0.0025, 0.16, 0.7, 1.0];

/// A list of surfaces being made.
struct Whites(Vec<White>);

impl Whites {
    fn add(&mut self, name: String, surface: Layered, eta: f32, kept: Kept) {
        self.0.push(White { name, surface, eta, kept });
    }

    fn bare(&mut self, name: String, base: Base, kept: Kept) {
        let eta = base.boundary().map_or(1.0, |b| b.0);
        self.add(name, Layered::new(None, None, base, None), eta, kept);
    }

    fn general(&mut self, name: String, p: &SubstrateParameters, kept: Kept) {
        self.bare(name, Base::Substrate(Substrate::new(p)), kept);
    }

    fn plain(&mut self, a: f32) {
        let mut add = |name: &str, p: SurfaceParameters, kept| {
            self.bare(format!("{name}, {a}"), Base::surface(&p), kept);
        };
        add("metal", plain(1.0, a, 0.0), Kept::All);
        for ior in [1.0f32, 1.33, 2.4, 0.0] {
            add(&format!("plastic {ior}"), SurfaceParameters { ior, ..plain(0.0, a, 0.0) }, Kept::All);
        }
        for specular in [0.0f32, 0.5] {
            let p = SurfaceParameters { specular, ..plain(0.0, a, 0.0) };
            add(&format!("plastic of specular {specular}"), p, Kept::All);
        }
        let specular_color = Vec3::new(1.0, 0.4, 4.0);
        let p = SurfaceParameters { specular_color, ..plain(0.0, a, 0.0) };
        add("plastic of a specular color", p, Kept::Strongest);
        add("thin wall", plain(0.0, a, 1.0), Kept::All);
        add("metal, plastic and wall", plain(0.3, a, 0.4), Kept::All);
    }

    fn treated(&mut self, a: f32) {
        let mut p = general(plain(0.0, a, 0.0));
        p.diffuse_transmission = (0.4, Vec3::ONE);
        self.general(format!("leaf {a}"), &p, Kept::All);
        p.eta = 1.5;
        let leaf = Layered::new(None, None, Base::Substrate(Substrate::new(&p)), None);
        self.add(format!("leaf on a medium {a}"), leaf, 1.5, Kept::All);
        let mut p = general(plain(0.0, a, 0.7));
        p.scatter = (0.6, Vec3::ONE, 0.3);
        self.general(format!("paper {a}"), &p, Kept::All);
        for (share, thickness) in [(1.0f32, 400.0f32), (0.5, 250.0)] {
            for (m, t, kept) in
                [(1.0f32, 0.0f32, Kept::All), (0.0, 0.0, Kept::Strongest), (0.0, 1.0, Kept::FilmedWall)]
            {
                let film = Some((share, 1.3, thickness));
                let p = SubstrateParameters { film, ..general(plain(m, a, t)) };
                self.general(format!("film {thickness} on {m} {t}, {a}"), &p, kept);
            }
        }
        for eta in [1.33f32, 2.4] {
            let b = DielectricBoundary::new(eta, a, Microfacet::Multiple);
            self.bare(format!("glass {eta}, {a}"), Base::Boundary(b, Vec3::ONE), Kept::All);
            let t = TreatedBoundary::new(eta, Facets::isotropic(a), Microfacet::Multiple, Vec3::ONE);
            for (factor, color) in [(0.0f32, Vec3::ONE), (1.0, Vec3::new(0.2, 1.0, 4.0))] {
                let t = t.with_specular(factor, color);
                let name = format!("glass {eta} of specular {factor} {color}, {a}");
                self.bare(name, Base::Treated(t, Vec3::ONE), Kept::All);
            }
            let t = t.with_film(1.0, ThinFilm::new(1.8, 500.0, t.f0()));
            self.bare(format!("glass {eta} with a film, {a}"), Base::Treated(t, Vec3::ONE), Kept::All);
        }
    }

    fn brushed(&mut self, a: f32, strength: f32) {
        let facets = brushed(a, strength);
        let of = |m, t| SubstrateParameters { facets, ..general(plain(m, a, t)) };
        for (m, t) in [(1.0f32, 0.0f32), (0.0, 0.0), (0.0, 1.0)] {
            self.general(format!("brushed {m} {t}, {a}, strength {strength}"), &of(m, t), Kept::All);
        }
        let t = TreatedBoundary::new(1.5, facets, Microfacet::Multiple, Vec3::ONE);
        self.bare(format!("brushed glass, {a}, strength {strength}"), Base::Treated(t, Vec3::ONE), Kept::All);
        for (m, t, kept) in
            [(1.0f32, 0.0f32, Kept::All), (0.0, 0.0, Kept::Strongest), (0.0, 1.0, Kept::FilmedWall)]
        {
            let p = SubstrateParameters { film: Some((1.0, 1.3, 400.0)), ..of(m, t) };
            self.general(format!("film on brushed {m} {t}, {a}, strength {strength}"), &p, kept);
        }
        // Of facets that differ most, 0.04 and 1, a film on glass loses 1.1 % near the horizon.
        if strength < 1.0 {
            let filmed = t.with_film(1.0, ThinFilm::new(1.8, 500.0, t.f0()));
            let name = format!("brushed glass with a film, {a}, strength {strength}");
            self.bare(name, Base::Treated(filmed, Vec3::ONE), Kept::All);
        }
        let base = Base::Substrate(Substrate::new(&of(1.0, 0.0)));
        let coat = Layered::new(Some(Coat::new(1.0, a)), None, base, None);
        self.add(format!("coat on brushed metal, {a}, strength {strength}"), coat, 1.0, Kept::All);
        let sheen = Layered::new(None, Some(Sheen::new(Vec3::ONE, 0.5)), base, None);
        self.add(format!("sheen on brushed metal, {a}, strength {strength}"), sheen, 1.0, Kept::All);
    }

    fn layered(&mut self, a: f32) {
        for (m, t) in [(1.0f32, 0.0f32), (0.0, 0.0), (0.3, 0.4)] {
            let base = Base::surface(&plain(m, a, t));
            for (factor, coat) in [(1.0f32, 0.0f32), (0.5, 0.1), (1.0, 0.4), (1.0, 1.0)] {
                let l = Layered::new(Some(Coat::new(factor, coat)), None, base, None);
                self.add(format!("coat {coat} {factor} on {m} {t}, {a}"), l, 1.0, Kept::All);
            }
            for r in [0.05f32, 0.2, 0.6] {
                let l = Layered::new(None, Some(Sheen::new(Vec3::ONE, r)), base, None);
                self.add(format!("sheen {r} on {m} {t}, {a}"), l, 1.0, Kept::All);
            }
            let l = Layered::new(Some(Coat::new(1.0, 0.2)), Some(Sheen::new(Vec3::ONE, 0.5)), base, None);
            self.add(format!("coat and sheen on {m} {t}, {a}"), l, 1.0, Kept::All);
        }
        let base = Base::Boundary(DielectricBoundary::new(1.5, a, Microfacet::Multiple), Vec3::ONE);
        for coat in [0.0f32, 0.4] {
            let l = Layered::new(Some(Coat::new(1.0, coat)), None, base, None);
            self.add(format!("coat {coat} on glass {a}"), l, 1.5, Kept::All);
        }
        let l = Layered::new(None, Some(Sheen::new(Vec3::ONE, 0.5)), base, None);
        self.add(format!("sheen on glass {a}"), l, 1.5, Kept::All);
    }
}

impl Whites {
    /// Coats of any index, with darkening, which whites do not know; brushed ones, and fuzz, also on a coat.
    fn drafts(&mut self, a: f32) {
        let coat = |ior: f32, alpha: Vec2| {
            let color = Vec3::ONE;
            Some(Coat::with(&CoatParameters { weight: 1.0, alpha, ior, color, darkening: 1.0 }))
        };
        let fuzz = |weight, r| Some(Fuzz::new(weight, Vec3::ONE, r));
        let none = Stack::default();
        let stacks = [
            ("coat 1.2", Stack { coat: coat(1.2, Vec2::ZERO), ..none }),
            ("coat 2.4, 0.3", Stack { coat: coat(2.4, Vec2::splat(0.3)), ..none }),
            ("brushed coat 1.5", Stack { coat: coat(1.5, Vec2::new(0.5, 0.05)), ..none }),
            ("fuzz 0.1", Stack { fuzz: fuzz(1.0, 0.1), ..none }),
            ("fuzz 0.5", Stack { fuzz: fuzz(1.0, 0.5), ..none }),
            ("half of fuzz 1", Stack { fuzz: fuzz(0.5, 1.0), ..none }),
            ("fuzz 0.3 and coat", Stack { fuzz: fuzz(1.0, 0.3), coat: coat(1.5, Vec2::ZERO), sheen: None }),
            (
                "fuzz 0.8 and coat 0.2",
                Stack { fuzz: fuzz(0.7, 0.8), coat: coat(1.5, Vec2::splat(0.2)), sheen: None },
            ),
        ];
        for (name, stack) in stacks {
            let kept = if name.contains("brushed") { Kept::BrushedCoat } else { Kept::All };
            for (m, t) in [(1.0f32, 0.0f32), (0.0, 0.0), (0.3, 0.4)] {
                let surface = Layered::stacked(stack, Base::surface(&plain(m, a, t)), None);
                self.add(format!("{name} on {m} {t}, {a}"), surface, 1.0, kept);
            }
            let glass = Base::Boundary(DielectricBoundary::new(1.5, a, Microfacet::Multiple), Vec3::ONE);
            if !name.contains("brushed") && !name.contains("2.4") {
                self.add(
                    format!("{name} on glass, {a}"),
                    Layered::stacked(stack, glass, None),
                    1.5,
                    Kept::All,
                );
            }
        }
    }

    /// Diffuse facets below coats of plastic, as leaf and paper, and below layers.
    fn rough(&mut self, a: f32, diffuse_roughness: f32) {
        let rough = |plain| SubstrateParameters { diffuse_roughness, ..general(plain) };
        let of = |p: &SubstrateParameters| Base::Substrate(Substrate::new(p));
        for (ior, specular) in [(1.5f32, 1.0f32), (2.4, 1.0), (1.5, 0.0)] {
            let p = rough(SurfaceParameters { ior, specular, ..plain(0.0, a, 0.0) });
            self.general(format!("plaster {diffuse_roughness} {ior} {specular}, {a}"), &p, Kept::All);
        }
        let mut p = rough(plain(0.0, a, 0.0));
        p.diffuse_transmission = (0.4, Vec3::ONE);
        self.general(format!("leaf {diffuse_roughness}, {a}"), &p, Kept::All);
        p.eta = 1.5;
        let leaf = Layered::new(None, None, of(&p), None);
        self.add(format!("leaf {diffuse_roughness} on a medium, {a}"), leaf, 1.5, Kept::All);
        let mut p = rough(plain(0.0, a, 0.7));
        p.scatter = (0.6, Vec3::ONE, 0.3);
        self.general(format!("paper {diffuse_roughness}, {a}"), &p, Kept::All);
        let base = of(&rough(plain(0.0, a, 0.0)));
        let coated = Layered::new(Some(Coat::new(1.0, 0.1)), None, base, None);
        self.add(format!("coat on plaster {diffuse_roughness}, {a}"), coated, 1.0, Kept::All);
        let stack = Stack { fuzz: Some(Fuzz::new(1.0, Vec3::ONE, 0.5)), ..Stack::default() };
        let fuzzy = Layered::stacked(stack, base, None);
        self.add(format!("fuzz on plaster {diffuse_roughness}, {a}"), fuzzy, 1.0, Kept::All);
        let brushed = SubstrateParameters { facets: brushed(a.max(0.04), 0.6), ..rough(plain(0.0, a, 0.0)) };
        self.general(format!("brushed plaster {diffuse_roughness}, {a}"), &brushed, Kept::All);
    }
}

fn check(whites: Whites) {
    let mut worst = (0.0f32, String::new());
    for w in whites.0 {
        let cosines: &[f32] =
            if w.eta == 1.0 { &[0.03, 0.1, 0.3, 0.6, 0.95] } else { &[-0.05, -0.4, -0.8, 0.1, 0.6] };
        let azimuths = if w.name.contains("brushed") { 4 } else { 1 };
        for &cos in cosines {
            for k in 0..azimuths {
                let wo = direction(cos, TURN + FRAC_PI_2 * k as f32 / 3.0);
                let mut e = Vec3::ZERO;
                for cells in CELLS {
                    let se;
                    (e, se) = energy(&w.surface, wo, w.eta, cells);
                    if w.kept.off(e) + NOISE * se < ERROR {
                        break;
                    }
                }
                let off = w.kept.off(e);
                if off > worst.0 {
                    worst = (off, format!("{}, cosine {cos}, azimuth {k}: {e}", w.name));
                }
            }
        }
    }
    println!("{worst:?}");
    assert!(worst.0 < ERROR, "{}", worst.1);
}

#[test]
fn white_plain_surfaces_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    ALPHAS.into_iter().for_each(|a| whites.plain(a));
    check(whites);
}

#[test]
fn white_treated_surfaces_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    ALPHAS.into_iter().for_each(|a| whites.treated(a));
    check(whites);
}

#[test]
fn white_brushed_surfaces_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    for (a, strength) in
        [(0.0025f32, 0.2f32), (0.0025, 0.8), (0.04, 0.5), (0.04, 1.0), (0.3, 0.7), (1.0, 0.5)]
    {
        whites.brushed(a, strength);
    }
    check(whites);
}

#[test]
fn white_layered_surfaces_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    [0.0f32, 0.16, 1.0].into_iter().for_each(|a| whites.layered(a));
    check(whites);
}

#[test]
fn white_coats_and_fuzz_of_the_drafts_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    [0.0f32, 0.3].into_iter().for_each(|a| whites.drafts(a));
    check(whites);
}

#[test]
fn white_diffuse_facets_return_all_light_in_every_direction() {
    let mut whites = Whites(Vec::new());
    for (a, r) in [(0.0f32, 0.5f32), (0.16, 1.0), (1.0, 1.0)] {
        whites.rough(a, r);
    }
    check(whites);
}
