//! Where on an arbitrary closed mesh did light come in that left at x_o? The exit-point search that all radial models
//! share (King, Kulla, Conty, Fajardo 2013, "BSSRDF importance sampling").
//!
//! A line is thrown at the object: along one of the axes a of a frame about the normal (the normal half of the time),
//! at a distance r from x_o that is drawn from the profile of one channel. Every crossing with *the same object* is a
//! candidate. A line's density per area of the plane across it is p(r) = Σ_c P_c p_c(r), and a surface element dA offers
//! |n·a| dA to it, so over all axes a point x has density
//!
//! ```text
//! p_A(x) = Σ_a P_a |n·a| p(|D − (D·a) a|),   D = x − x_o
//! ```
//!
//! whichever axis found it. One candidate is kept, in proportion to what it would contribute; the weight is the sum over
//! the candidates. Lines go through the whole object, and profiles have no largest radius, so nothing is cut off.

use crate::geometry::{Hit, Ray};
use crate::optics::diffusion::TabulatedProfile;
use crate::sampling::{Sampler, orthonormal_basis};
use crate::scene::Scene;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// How often lines run along the normal.
const ALONG_NORMAL: f32 = 0.5;

/// Radii: a mixture of tabulated profiles.
pub struct Radii<'a> {
    parts: Vec<(&'a TabulatedProfile, f32)>,
}

impl<'a> Radii<'a> {
    /// Profiles and their weights, which need not sum to 1; `None` if no weight is positive.
    pub fn new(parts: impl Iterator<Item = (&'a TabulatedProfile, f32)>) -> Option<Self> {
        let mut parts: Vec<_> = parts.filter(|(_, w)| *w > 0.0 && w.is_finite()).collect();
        let total: f32 = parts.iter().map(|(_, w)| w).sum();
        parts.iter_mut().for_each(|(_, w)| *w /= total);
        (total > 0.0 && total.is_finite()).then_some(Self { parts })
    }

    fn sample(&self, u_part: f32, u: f32) -> f32 {
        let mut below = 0.0;
        for (profile, weight) in &self.parts {
            below += weight;
            if u_part < below {
                return profile.sample(u);
            }
        }
        self.parts.last().map_or(0.0, |(p, _)| p.sample(u))
    }

    /// The radius below which radii are not told apart at a point with coordinates of the given size: rounding moves
    /// points by that much, and profiles may be infinite at zero.
    fn least(&self, coordinate: f32) -> f32 {
        let scale = self.parts.iter().map(|(p, _)| p.max_radius()).fold(f32::INFINITY, f32::min);
        (1e-5 * scale).max(1e-6 * coordinate)
    }

    /// Density per area of the plane.
    fn pdf_area(&self, r: f32) -> f32 {
        self.parts.iter().map(|(p, w)| w * p.pdf_area(r)).sum()
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
    /// Distance from x_o, metres.
    pub distance: f32,
    /// Density per area of the search, 1/m².
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
}

impl<'a> ExitSearch<'a> {
    /// Searches the boundary of `instance` about a point of it with the given unit normal.
    pub fn new(scene: &'a Scene, instance: u32, point: Vec3, normal: Vec3, radii: &'a Radii<'a>) -> Self {
        let (x, y) = orthonormal_basis(normal);
        let least = radii.least(point.abs().max_element());
        Self { scene, instance, point, axes: [x, y, normal], radii, least }
    }

    /// Density per area, 1/m², with which a point of unit normal `normal` is among the candidates of a line.
    pub fn pdf(&self, position: Vec3, normal: Vec3) -> f32 {
        let away = position - self.point;
        let squared = away.length_squared();
        let of = |(axis, share): (&Vec3, f32)| {
            let along = away.dot(*axis);
            let r = (squared - along * along).max(0.0).sqrt();
            share * normal.dot(*axis).abs() * self.radii.pdf_area(r.max(self.least))
        };
        let side = 0.5 * (1.0 - ALONG_NORMAL);
        self.axes.iter().zip([side, side, ALONG_NORMAL]).map(of).sum()
    }

    /// The candidates on one random line.
    pub fn candidates(&self, sampler: &mut Sampler) -> Vec<Candidate> {
        let (u_axis, u_part) = (sampler.next_1d(), sampler.next_1d());
        self.candidates_of(u_axis, u_part, sampler.next_2d())
    }

    /// The candidates on the line of the given numbers.
    pub fn candidates_of(&self, u_axis: f32, u_part: f32, u: Vec2) -> Vec<Candidate> {
        let [x, y, n] = self.axes;
        let [axis, across, along] = if u_axis < ALONG_NORMAL {
            [n, x, y]
        } else if u_axis < 0.5 * (1.0 + ALONG_NORMAL) {
            [x, y, n]
        } else {
            [y, n, x]
        };
        let (r, phi) = (self.radii.sample(u_part, u.x).max(self.least), TAU * u.y);
        let middle = self.point + r * (phi.cos() * across + phi.sin() * along);
        let geometry = &self.scene.geometry;
        let size = geometry.transform(self.instance).scale
            * geometry.mesh_of(self.instance).bounds().extent().length();
        // From outside of the object, whichever of its points x_o is.
        let reach = 1.01 * size;
        let ray = Ray { origin: middle - reach * axis, direction: axis, t_max: 2.0 * reach };
        let mut hits = Vec::new();
        geometry.intersect_all_of(self.instance, &ray, &mut hits);
        let candidate = |hit: Hit| {
            let at = geometry.surface(&hit);
            let pdf = self.pdf(at.position, at.geometric_normal);
            let distance = at.position.distance(self.point).max(self.least);
            (pdf > 0.0 && pdf.is_finite()).then_some(Candidate {
                hit,
                position: at.position,
                normal: at.geometric_normal,
                distance,
                pdf,
            })
        };
        hits.into_iter().filter_map(candidate).collect()
    }

    /// Keeps one candidate of a line in proportion to `beta` times its `reflectance(candidate)` (1/m², each channel)
    /// over its density. `None`: nothing was found.
    pub fn find(
        &self,
        beta: Vec3,
        sampler: &mut Sampler,
        reflectance: impl Fn(&Candidate) -> Vec3,
    ) -> Option<Found> {
        let (mut total, mut kept) = (0.0, None);
        for candidate in self.candidates(sampler) {
            let reflectance = reflectance(&candidate);
            let share = (beta * reflectance).element_sum() / candidate.pdf;
            if share > 0.0 && share.is_finite() {
                total += share;
                if sampler.rng().f32() * total < share {
                    kept = Some((candidate, reflectance, share));
                }
            }
        }
        let (candidate, reflectance, share) = kept?;
        let inverse_pdf = total / (share * candidate.pdf);
        inverse_pdf.is_finite().then_some(Found { candidate, reflectance, inverse_pdf })
    }
}
