//! A point of a light that was chosen from one place, seen from another.
//!
//! Who chooses a light at one point and then looks for it from a second must not choose again there, not even with the same
//! random numbers: near a lamp they mean another point of it. The point itself is handed over, and its density goes from
//! the solid angle at the first place to that at the second:
//!
//! ```text
//! p₂ = p₁ dω₁/dω₂,   dω = cos θ dA/d²
//! ```

use super::emitter::EmitterId;
use super::lights::{Anchor, LightSample, Lights};
use super::punctual;
use glam::Vec3;

/// What can be chosen of a light, wherever it is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightPoint {
    /// The environment in a unit direction.
    Environment(Vec3),
    /// A punctual light; the number is its index among those with intensity.
    Punctual(u32),
    /// A point of an emissive triangle.
    Emitter(EmitterId, Vec3),
}

impl LightPoint {
    /// Whether only light sampling finds it.
    #[inline]
    pub fn is_delta(&self) -> bool {
        matches!(self, Self::Punctual(_))
    }
}

impl Lights {
    /// The unit direction from `from` to a point of a light.
    #[inline]
    pub fn direction_to(&self, point: &LightPoint, from: Vec3) -> Option<Vec3> {
        match *point {
            LightPoint::Environment(direction) => Some(direction),
            LightPoint::Punctual(i) => punctual::direction_to(self.punctual.get(i as usize)?, from),
            LightPoint::Emitter(id, position) => {
                self.emitters.get(id.0 as usize)?.towards_unit(from, position)
            }
        }
    }

    /// A sample that was chosen at `chosen_at`, seen from `from`: the density is that of [`Self::sample_at`] there, with
    /// respect to solid angle here. `None`: it sends nothing here.
    #[inline]
    pub fn seen_from(&self, sample: &LightSample, chosen_at: Vec3, from: Vec3) -> Option<LightSample> {
        match sample.point {
            LightPoint::Environment(_) => Some(*sample),
            LightPoint::Punctual(i) => {
                let p = punctual::irradiance(self.punctual.get(i as usize)?, from)?;
                Some(LightSample {
                    direction: p.direction,
                    distance: p.distance,
                    radiance: p.irradiance,
                    ..*sample
                })
            }
            LightPoint::Emitter(id, position) => {
                let emitter = self.emitters.get(id.0 as usize)?;
                let (direction, distance, radiance) = emitter.seen_from(from, position)?;
                let pdf = sample.pdf * emitter.solid_angle_ratio(chosen_at, from, position);
                (pdf > 0.0 && pdf.is_finite()).then_some(LightSample {
                    direction,
                    distance,
                    radiance,
                    pdf,
                    ..*sample
                })
            }
        }
    }

    /// The density that [`Self::sample_at`] has for a point of a light, with respect to solid angle at `from`.
    #[inline]
    pub fn density_at(&self, anchor: &Anchor, point: &LightPoint, from: Vec3) -> f32 {
        match *point {
            LightPoint::Environment(direction) => self.environment_pdf_at(anchor, direction),
            LightPoint::Punctual(i) => self.punctual_probability(i as usize, anchor),
            LightPoint::Emitter(id, position) => {
                let pdf = self.emitter_pdf_at(id, anchor.point, anchor, position);
                if pdf <= 0.0 || from == anchor.point {
                    return pdf;
                }
                let pdf = pdf * self.emitters[id.0 as usize].solid_angle_ratio(anchor.point, from, position);
                if pdf.is_finite() { pdf } else { 0.0 }
            }
        }
    }
}
