//! Where on an arbitrary closed mesh did light come in that left at x_o? The exit-point search that all radial models
//! share (King, Kulla, Conty, Fajardo 2013, "BSSRDF importance sampling").
//!
//! Lines are thrown at the object: always `LINES` along the normal at x_o, and with probability `SIDEWAYS` one along
//! one of two tangents, each at a distance r from x_o that is drawn from the profile of one channel. Every crossing
//! with the boundary of *the same object* is a candidate. A line's density per area of the plane across it is p(r) =
//! Σ_c P_c p_c(r), and a surface element dA offers |n·a| dA to it, so over all lines a point x has the expected number
//! of candidates per area
//!
//! ```text
//! λ(x) = Σ_a N_a |n·a| p(|D − (D·a) a|) q,   D = x − x_o
//! ```
//!
//! with N_a lines along a on average, whichever line found it (multi-sample balance heuristic, Veach 1997, §9.2). A line
//! reaches somewhat farther than it is away from x_o; with probability `FAR` it goes on through the whole object, hence q
//! is 1 near by and `FAR` beyond: nothing is cut off.
//!
//! One candidate is kept, in proportion to what it would contribute if nothing was in the way of its lights (resampled
//! importance sampling, Talbot, Cline & Egbert 2005).

use crate::geometry::{Hit, Ray};
use crate::optics::diffusion::TabulatedProfile;
use crate::sampling::{Sampler, SmallRng, fast_math, orthonormal_basis};
use crate::scene::Scene;
use glam::{Vec2, Vec3};

/// Lines along the normal.
const LINES: usize = 2;
/// Probability of a line along one of the tangents.
const SIDEWAYS: f32 = 0.4;
/// How far every line reaches from the plane through x_o across it: a multiple of its distance from x_o, and a part of the
/// radius that holds 90 % of the energy.
const REACH: f32 = 1.5;
const LEAST_REACH: f32 = 0.2;
/// Probability that a line goes on through the whole object.
const FAR: f32 = 0.1;

/// Steps of the golden ratio spread evenly however many they are.
const GOLDEN: f32 = 0.618_034;
/// What light comes by other ways than straight from its source, as a share of the mean over the candidates.
const INDIRECT: f32 = 0.2;

/// Most profiles of a mixture: those of three channels, and of two thinner media each.
const PARTS: usize = 9;

/// Radii: a mixture of tabulated profiles.
pub struct Radii<'a> {
    parts: [Option<(&'a TabulatedProfile, f32)>; PARTS],
}

impl<'a> Radii<'a> {
    /// Profiles and their weights, which need not sum to 1; those after the ninth are left out. `None` if no weight is
    /// positive.
    pub fn new(parts: impl Iterator<Item = (&'a TabulatedProfile, f32)>) -> Option<Self> {
        let mut own = [None; PARTS];
        let mut total = 0.0;
        let usable = parts.filter(|(_, w)| *w > 0.0 && w.is_finite());
        for (place, (profile, weight)) in own.iter_mut().zip(usable) {
            *place = Some((profile, weight));
            total += weight;
        }
        own.iter_mut().flatten().for_each(|(_, w)| *w /= total);
        (total > 0.0 && total.is_finite()).then_some(Self { parts: own })
    }

    fn parts(&self) -> impl Iterator<Item = (&'a TabulatedProfile, f32)> {
        self.parts.iter().map_while(|part| *part)
    }

    fn sample(&self, u_part: f32, u: f32) -> f32 {
        let (mut below, mut last) = (0.0, None);
        for (profile, weight) in self.parts() {
            below += weight;
            last = Some(profile);
            if u_part < below {
                break;
            }
        }
        last.map_or(0.0, |p| p.sample(u))
    }

    /// The radius below which radii are not told apart at a point with coordinates of the given size: rounding moves
    /// points by that much, and profiles may be infinite at zero.
    fn least(&self, coordinate: f32) -> f32 {
        let scale = self.parts().map(|(p, _)| p.max_radius()).fold(f32::INFINITY, f32::min);
        (1e-5 * scale).max(1e-6 * coordinate)
    }

    /// The largest radius that holds 90 % of a part's energy.
    fn near(&self) -> f32 {
        self.parts().map(|(p, _)| p.near_radius()).fold(0.0, f32::max)
    }

    /// Density per area of the plane, averaged over the disk of radius `r`.
    fn disk_density(&self, r: f32) -> f32 {
        let within: f32 = self.parts().map(|(p, w)| w * p.cdf(r)).sum();
        within / (std::f32::consts::PI * r * r)
    }

    /// Density per area of the plane.
    fn pdf_area(&self, r: f32) -> f32 {
        let log_r = r.log2();
        self.parts().map(|(p, w)| w * p.pdf_area_at(r, log_r)).sum()
    }
}

/// A candidate for the point where light came in.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The crossing.
    pub hit: Hit,
    /// World position.
    pub position: Vec3,
    /// Unit normal of the triangle, outwards.
    pub normal: Vec3,
    /// Distance from x_o, metres; [`Candidate::least`] where it is smaller.
    pub distance: f32,
    /// The radius within which distances are not told apart: there R is to be averaged.
    pub least: f32,
    /// Expected number of candidates of the search per area, 1/m².
    pub pdf: f32,
}

/// The candidate that a search keeps.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Which.
    pub candidate: Candidate,
    /// What the caller said of it.
    pub reflectance: Vec3,
    /// What to multiply with, m²: one over its density and over the probability of keeping it.
    pub inverse_pdf: f32,
}

/// The search about one point of one instance.
pub struct ExitSearch<'a> {
    scene: &'a Scene,
    instance: u32,
    point: Vec3,
    /// Tangent, bitangent, normal.
    axes: [Vec3; 3],
    radii: &'a Radii<'a>,
    least: f32,
    near: f32,
}

impl<'a> ExitSearch<'a> {
    /// Searches the boundary of `instance` about a point of it with the given unit normal.
    pub fn new(scene: &'a Scene, instance: u32, point: Vec3, normal: Vec3, radii: &'a Radii<'a>) -> Self {
        let (x, y) = orthonormal_basis(normal);
        let least = radii.least(point.abs().max_element());
        Self { scene, instance, point, axes: [x, y, normal], radii, least, near: radii.near() }
    }

    /// How far lines at the radius `r` go from the plane at least.
    fn reach(&self, r: f32) -> f32 {
        REACH * r + LEAST_REACH * self.near
    }

    /// Expected number of candidates per area, 1/m², at a point of unit normal `normal`.
    pub fn pdf(&self, position: Vec3, normal: Vec3) -> f32 {
        let away = position - self.point;
        let squared = away.length_squared();
        let of = |(axis, share): (&Vec3, f32)| {
            let along = away.dot(*axis);
            let r = (squared - along * along).max(0.0).sqrt();
            let reached = if along.abs() <= self.reach(r) { share } else { share * FAR };
            let radii = &self.radii;
            let density = if r < self.least { radii.disk_density(self.least) } else { radii.pdf_area(r) };
            reached * normal.dot(*axis).abs() * density
        };
        self.axes.iter().zip([0.5 * SIDEWAYS, 0.5 * SIDEWAYS, LINES as f32]).map(of).sum()
    }

    /// Visits the candidates of one search: `u_part` and `u`, in \[0, 1), place the lines along the normal.
    pub fn visit(&self, u_part: f32, u: Vec2, rng: &mut SmallRng, mut visit: impl FnMut(Candidate)) {
        let [x, y, n] = self.axes;
        let turned = |u: f32, step: f32, k: usize| (u + step * k as f32).fract();
        for k in 0..LINES {
            let u_part = turned(u_part, GOLDEN, k);
            let u = Vec2::new(turned(u.x, 1.0 / LINES as f32, k), turned(u.y, GOLDEN, k));
            let (far, again) = (rng.f32() < FAR, rng.f32());
            self.cross(n, (x, y), u_part, u, (far, again), &mut visit);
        }
        if rng.f32() < SIDEWAYS {
            let (u_part, u) = (rng.f32(), rng.vec2());
            let far = rng.f32() < FAR;
            let (axis, across) = if rng.f32() < 0.5 { (x, (y, n)) } else { (y, (n, x)) };
            self.cross(axis, across, u_part, u, (far, rng.f32()), &mut visit);
        }
    }

    /// Visits the crossings of one line with the object.
    fn cross(
        &self,
        axis: Vec3,
        across: (Vec3, Vec3),
        u_part: f32,
        u: Vec2,
        (far, sampled_again): (bool, f32),
        visit: &mut impl FnMut(Candidate),
    ) {
        let mut r = self.radii.sample(u_part, u.x);
        if r < self.least {
            // Evenly over the disk.
            r = self.least * sampled_again.sqrt();
        }
        let (sin, cos) = fast_math::sin_cos_turns(u.y - 0.5);
        let middle = self.point + r * (cos * across.0 + sin * across.1);
        let geometry = &self.scene.geometry;
        let reach = if far {
            // From outside of the object, whichever of its points x_o is.
            let mesh = geometry.mesh_of(self.instance);
            1.01 * geometry.transform(self.instance).scale * mesh.bounds().extent().length()
        } else {
            self.reach(r)
        };
        let ray = Ray { origin: middle - reach * axis, direction: axis, t_max: 2.0 * reach };
        let materials = &self.scene.mesh(self.instance).triangle_materials;
        geometry.visit_hits_of(self.instance, &ray, |hit| {
            if self.scene.medium(materials[hit.triangle as usize]).is_none() {
                return;
            }
            let at = geometry.surface(&hit);
            let (position, normal) = (at.position, at.geometric_normal);
            let pdf = self.pdf(position, normal);
            let distance = position.distance(self.point).max(self.least);
            if pdf > 0.0 && pdf.is_finite() {
                visit(Candidate { hit, position, normal, distance, least: self.least, pdf });
            }
        });
    }

    /// Keeps one candidate. `beta` is the throughput so far, `reflectance(candidate)` what it is to be multiplied with
    /// (1/m², each channel). `None`: nothing was found.
    pub fn find(
        &self,
        beta: Vec3,
        sampler: &mut Sampler,
        reflectance: impl Fn(&Candidate) -> Vec3,
    ) -> Option<Found> {
        let (u_part, u) = (sampler.next_1d(), sampler.next_2d());
        let mut all = Vec::with_capacity(8);
        let (mut total, mut lit) = (0.0, 0.0);
        self.visit(u_part, u, sampler.rng(), |candidate| {
            let reflectance = reflectance(&candidate);
            let share = (beta * reflectance).element_sum() / candidate.pdf;
            if share > 0.0 && share.is_finite() {
                let light = self.scene.lights.irradiance_estimate(candidate.position, candidate.normal);
                total += share;
                lit += share * light;
                all.push((candidate, reflectance, share, light));
            }
        });
        let everywhere = if lit > 0.0 { INDIRECT * lit / total } else { 1.0 };
        let weight = |share: f32, light: f32| share * (light + everywhere);
        let sum: f32 = all.iter().map(|(_, _, share, light)| weight(*share, *light)).sum();
        let mut u = sampler.rng().f32() * sum;
        let last = all.len().checked_sub(1)?;
        for (i, (candidate, reflectance, share, light)) in all.into_iter().enumerate() {
            let weight = weight(share, light);
            if u < weight || i == last {
                let inverse_pdf = sum / (weight * candidate.pdf);
                return inverse_pdf.is_finite().then_some(Found { candidate, reflectance, inverse_pdf });
            }
            u -= weight;
        }
        None
    }
}
