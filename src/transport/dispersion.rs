//! Dispersion: a path draws one wavelength where a dispersive boundary first refracts it ([`crate::optics::spectrum`]),
//! and keeps it. In media that scatter it would be forgotten anyway, so there all refract alike. What a smooth boundary
//! reflects goes the same way for all wavelengths, so it keeps the path's three colours.

use super::interface::Contrast;
use super::media::Enclosure;
use super::path::PathTracer;
use super::state::Path;
use crate::optics::boundary_tables::MIN_ROUGH_ALPHA;
use crate::optics::{Bsdf, BsdfSample, fresnel, spectrum};
use crate::sampling::Sampler;
use glam::Vec3;

/// A wavelength that was drawn at the boundary that is being shaded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    /// Indices and dispersions inside and outside.
    sides: [(f32, f32); 2],
    /// What to multiply with if the path keeps it; already in the throughput unless `pending`.
    weight: Vec3,
    pending: bool,
}

impl PathTracer<'_> {
    /// The index inside over outside for the path's wavelength, which is drawn here if it has none; `None` where neither
    /// side is dispersive.
    pub(super) fn disperse(
        &self,
        path: &mut Path,
        contrast: &Contrast,
        sampler: &mut Sampler,
    ) -> Option<(f32, Option<Drawn>)> {
        let &Contrast { enclosure, outside, .. } = contrast;
        let side = |e: Option<Enclosure>| {
            let medium = e.and_then(|e| self.scene.medium(e.material));
            let clear = medium.is_some_and(|m| m.sigma_s.max_element() <= 0.0);
            let dispersion =
                e.filter(|_| clear).map_or(0.0, |e| self.scene.material(e.material).dispersion());
            (medium.map_or(1.0, |m| m.ior), dispersion)
        };
        let sides = [side(Some(enclosure)), side(outside)];
        if sides[0].1 == 0.0 && sides[1].1 == 0.0 {
            return None;
        }
        let index = |(ior, dispersion): (f32, f32), nm| spectrum::index(ior, dispersion, nm);
        let ratio = |nm| index(sides[0], nm) / index(sides[1], nm);
        if let Some(nm) = path.wavelength {
            return Some((ratio(nm), None));
        }
        // Rough boundaries need tables for each index.
        let m = self.scene.material(enclosure.material);
        let rough = m.roughness * m.roughness >= MIN_ROUGH_ALPHA
            || m.layers.as_ref().is_some_and(|l| l.anisotropy.is_some());
        let u = sampler.rng().f32();
        let (nm, weight) = if rough { spectrum::draw_stratum(u) } else { spectrum::draw(u) };
        path.wavelength = Some(nm);
        Some((ratio(nm), Some(Drawn { sides, weight, pending: true })))
    }

    /// Weighs a path by the wavelength that it has drawn, before lights are sampled: unless the boundary is a plain smooth
    /// one, where reflected paths are to stay as they are.
    pub(super) fn weigh_wavelength(&self, path: &mut Path, bsdf: &Bsdf, drawn: &mut Drawn) {
        if !(matches!(bsdf, Bsdf::Boundary(_)) && bsdf.is_delta()) {
            path.head.throughput *= drawn.weight;
            drawn.pending = false;
        }
    }

    /// Weighs a path that has left a smooth boundary: refracted, it keeps its wavelength; reflected, it has all of them
    /// again, with the colour of the reflectance.
    pub(super) fn keep_wavelength(&self, path: &mut Path, drawn: &Drawn, wo: Vec3, sample: &BsdfSample) {
        if !drawn.pending {
            return;
        }
        if sample.transmitted {
            path.head.throughput *= drawn.weight;
            return;
        }
        path.wavelength = None;
        let [inside, outside] = drawn.sides;
        let (colored, plain) = spectrum::average(|nm| {
            let eta = spectrum::index(inside.0, inside.1, nm) / spectrum::index(outside.0, outside.1, nm);
            fresnel::dielectric(wo.z.abs().min(1.0), if wo.z > 0.0 { eta } else { 1.0 / eta })
        });
        if plain > 0.0 {
            path.head.throughput *= colored / plain;
        }
    }
}
