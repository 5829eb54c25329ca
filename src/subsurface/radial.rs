//! What the radial models share: S(x_i, ω_i; x_o, ω_o) = F_t(ω_o) R(|x_i − x_o|) F_t(ω_i) / (π C).
//!
//! The boundary has already chosen transmission (F_t(ω_o)) when a flight begins at x_o. The search finds x_i with density
//! p_A, so the throughput gains R/p_A, and the path goes on through a lobe in proportion to F_t(ω_i) cos θ_i. C is 1
//! where a model says so (Jensen et al. 2001), so that ∫ F_t cos θ dω/π = 1 − F̄ is lost, or 1 − F̄ where the profile
//! already is what leaves the surface. η² brings radiance out of the medium again, the base colour tints the crossing.
//!
//! **Textures.** Profiles are evaluated in closed form with the coefficients at x_i; radii are drawn from tables of the
//! untextured medium and of two thinner ones.

use super::exit_search::{Candidate, ExitSearch, Radii};
use super::{Arrival, Connector, Flight, PathHead, Propagator, RandomWalk, SubsurfaceModel, TexturedMedium};
use crate::geometry::Hit;
use crate::optics::diffusion::{Coefficients, RadialProfile, TabulatedProfile};
use crate::optics::fresnel;
use crate::sampling::Sampler;
use crate::scene::{Scene, Surface};
use glam::Vec3;

/// Densities of the media whose profiles radii are drawn from where coefficients are textured.
const THINNER: [f64; 2] = [0.25, 0.0625];

/// The profile of a model, and how light leaves through it.
pub(super) trait Formula: Clone + Send + Sync + 'static {
    /// The profile of one channel.
    fn profile(&self, c: &Coefficients) -> Box<dyn RadialProfile>;
    /// Whether C is 1 − F̄.
    fn normalized(&self) -> bool;
    /// Whether single scattering is added along the refracted ray.
    fn adds_single_scattering(&self) -> bool {
        false
    }
}

/// The tables of one medium.
struct Tables {
    channels: [Option<TabulatedProfile>; 3],
    /// For textured coefficients.
    thinner: Vec<TabulatedProfile>,
}

/// A radial model, ready for one scene.
pub(super) struct Radial<F> {
    formula: F,
    /// For each material.
    tables: Vec<Option<Tables>>,
    /// For flights that do not begin at the boundary: a camera in the medium.
    fallback: Box<dyn Propagator>,
}

impl<F: Formula> Radial<F> {
    pub fn new(formula: F, scene: &Scene) -> Self {
        let tables = (0..scene.description.materials.len() as u32).map(|m| {
            let medium = scene.medium(m)?;
            let textured = scene
                .material(m)
                .medium
                .as_ref()
                .is_some_and(|d| d.absorption_texture.is_some() || d.scattering_texture.is_some());
            let coefficients = |channel| Coefficients::of_medium(medium, channel, 1.0);
            let table = |c: &Coefficients| TabulatedProfile::new(&*formula.profile(c));
            let channels = std::array::from_fn(|channel| table(&coefficients(channel)));
            let thin = |factor: f64| {
                let scale = move |c: Coefficients| Coefficients {
                    sigma_a: factor * c.sigma_a,
                    sigma_s: factor * c.sigma_s,
                    ..c
                };
                (0..3).filter_map(move |channel| table(&scale(coefficients(channel)))).collect::<Vec<_>>()
            };
            let thinner = if textured { THINNER.into_iter().flat_map(thin).collect() } else { Vec::new() };
            Some(Tables { channels, thinner })
        });
        let tables = tables.collect();
        Self { formula, tables, fallback: RandomWalk.prepare(scene) }
    }

    /// R at a candidate, each channel.
    fn reflectance(&self, flight: &Flight<'_>, tables: &Tables, c: &Candidate) -> Vec3 {
        if tables.thinner.is_empty() {
            let of = |t: &Option<TabulatedProfile>| t.as_ref().map_or(0.0, |t| t.eval(c.distance));
            return Vec3::from_array([0, 1, 2].map(|i| of(&tables.channels[i])));
        }
        let mut textured = TexturedMedium::new(flight.scene, flight.enclosure);
        let (sigma_a, sigma_s) = textured.coefficients(c.position);
        let g = f64::from(flight.medium.g);
        Vec3::from_array([0, 1, 2].map(|i| {
            let (sigma_a, sigma_s) = (f64::from(sigma_a[i]), f64::from(sigma_s[i]));
            let c_i = Coefficients { sigma_a, sigma_s, g, eta: f64::from(flight.medium.ior) };
            if c_i.scatters() {
                self.formula.profile(&c_i).eval(f64::from(c.distance).max(1e-9)) as f32
            } else {
                0.0
            }
        }))
    }
}

impl<F: Formula> Propagator for Radial<F> {
    fn propagate(
        &self,
        flight: &Flight<'_>,
        head: &mut PathHead,
        sampler: &mut Sampler,
        connector: &mut dyn Connector,
    ) -> Arrival {
        let instance = flight.enclosure.instance;
        let start = head.start.filter(|s| s.instance == instance);
        let tables = self.tables.get(flight.enclosure.material as usize).and_then(Option::as_ref);
        let (Some(start), Some(tables)) = (start, tables) else {
            return self.fallback.propagate(flight, head, sampler, connector);
        };
        if self.formula.adds_single_scattering() {
            super::single_scattering::connect(flight, head, sampler, connector);
        }
        head.events += 1;
        let hit = Hit {
            t: 0.0,
            instance,
            triangle: start.triangle,
            u: start.barycentric.x,
            v: start.barycentric.y,
        };
        let from = flight.scene.geometry.surface(&hit);
        let beta = head.throughput;
        let weight = |i: usize| tables.channels[i].as_ref().map_or(0.0, |t| beta[i] * t.total());
        let own = (0..3).filter_map(|i| Some((tables.channels[i].as_ref()?, weight(i))));
        let share = (0..3).map(weight).sum::<f32>() / tables.thinner.len().max(1) as f32;
        let thinner = tables.thinner.iter().map(|t| (t, share));
        let Some(radii) = Radii::new(own.chain(thinner)) else { return Arrival::Ended };
        let search = ExitSearch::new(flight.scene, instance, from.position, from.geometric_normal, &radii);
        let found = search.find(beta, sampler, |c| self.reflectance(flight, tables, c));
        let Some((candidate, weight)) = found else { return Arrival::Ended };
        let ior = flight.medium.ior;
        let surface = Surface::new(flight.scene, &candidate.hit);
        let lobe = if self.formula.normalized() { 1.0 } else { 1.0 - fresnel::diffuse_reflectance(ior) };
        head.throughput *= weight * flight.scene.base_color(&surface).truncate() * (ior * ior * lobe);
        Arrival::Exit(Box::new(surface))
    }
}
