//! All lights of a scene, and choosing one of them for next-event estimation.
//!
//! Three groups (environment, punctual lights, emissive triangles) are weighed by the light they would send to the
//! point if nothing were in between; the group is chosen by a defensive mixture of the weights. Within a group up to
//! `FEW` lights are weighed in the same way one by one, and more of them are chosen by power.
//!
//! Everything is a function of the point and the normal, so the density of a direction that was found in another way
//! (a scattered ray that reached a light) is the same that [`Lights::sample`] would have had, *if the caller passes the
//! same point and normal*. A normal says that only light from its side counts; pass `None` inside media and where light
//! is transmitted.

use glam::{Vec2, Vec3};

use super::{
    emitter::{EmissiveTriangle, Emitter, EmitterId},
    environment::Environment,
    mixture::{FEW, Mixture},
    nearest::Lamps,
    punctual,
};
use crate::sampling::Distribution1D;
use crate::scene::{EnvironmentDescription, PunctualKind, PunctualLight};

/// δ of the choice among groups: with all three present each gets at least a tenth.
const GROUP_DEFENSIVE: f32 = 0.3;

/// δ of the choice within a group.
const LIGHT_DEFENSIVE: f32 = 0.1;

const ENVIRONMENT: usize = 0;
const PUNCTUAL: usize = 1;
const EMITTERS: usize = 2;

/// Light chosen for a point. The contribution is `f · cos · radiance / pdf` in all cases, times visibility.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction from the point towards the light.
    pub direction: Vec3,
    /// Distance in metres; infinite for environment and directional lights.
    pub distance: f32,
    /// Radiance of areas and environment; irradiance of a facing surface for punctual lights.
    pub radiance: Vec3,
    /// Solid angle density × probability of the choice; the probability alone for punctual lights.
    pub pdf: f32,
    /// Whether no other technique can find this light (punctual lights), so that it takes no MIS weight.
    pub delta: bool,
    /// The emissive triangle, if it is one.
    pub emitter: Option<EmitterId>,
}

/// Where lights are weighed against each other, when one is chosen. Usually the lit point itself; two points that use the
/// same one choose the same light with the same random number.
#[derive(Clone, Copy, Debug)]
pub struct Anchor {
    /// World position.
    pub point: Vec3,
    /// Only light from this side counts; `None`: all light.
    pub normal: Option<Vec3>,
}

/// The lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    environment: Environment,
    punctual: Vec<PunctualLight>,
    /// Sorted by instance and triangle.
    emitters: Vec<Emitter>,
    /// First emitter of each instance, with the number of emitters at the end; empty without emitters.
    first_of_instance: Vec<u32>,
    /// By power, where there are more than [`FEW`].
    punctual_table: Option<Distribution1D>,
    emitter_table: Option<Distribution1D>,
    punctual_cluster: Cluster,
    emitter_cluster: Cluster,
    lamps: Lamps,
}

/// Many lights seen as one.
#[derive(Clone, Copy, Debug, Default)]
struct Cluster {
    center: Vec3,
    radius_squared: f32,
    /// Watts, channel mean.
    power: f32,
    /// Irradiance that does not depend on distance (directional lights).
    irradiance: f32,
}

impl Cluster {
    fn new(points: impl Iterator<Item = Vec3> + Clone, power: f32, irradiance: f32) -> Self {
        let low = points.clone().fold(Vec3::INFINITY, Vec3::min);
        let high = points.fold(Vec3::NEG_INFINITY, Vec3::max);
        if low.cmpgt(high).any() {
            return Self { power, irradiance, ..Self::default() };
        }
        Self {
            center: 0.5 * (low + high),
            radius_squared: 0.25 * (high - low).length_squared(),
            power,
            irradiance,
        }
    }

    /// Estimated irradiance at a point: the power spread over a sphere through it that is not smaller than the lights.
    fn importance(&self, point: Vec3) -> f32 {
        let distance_squared = (point - self.center).length_squared().max(self.radius_squared);
        if self.power > 0.0 && distance_squared > 0.0 {
            self.irradiance + self.power / (4.0 * std::f32::consts::PI * distance_squared)
        } else {
            self.irradiance + self.power
        }
    }
}

/// The probabilities of everything that can be chosen for a point; `None` where a table is used instead.
struct Choice {
    groups: Mixture,
    punctual: Option<Mixture>,
    emitters: Option<Mixture>,
}

impl Lights {
    /// Prepares the lights. Emitters without area or power, and punctual lights without intensity, are left out.
    /// `scene_bounds` (low and high corner) weighs directional against other lights where there are many.
    pub fn build(
        emitters: Vec<EmissiveTriangle>,
        punctual: &[PunctualLight],
        environment: &EnvironmentDescription,
        scene_bounds: (Vec3, Vec3),
    ) -> Self {
        let mut emitters: Vec<Emitter> = emitters.into_iter().filter_map(Emitter::new).collect();
        emitters.sort_by_key(|e| (e.source.instance, e.source.triangle));
        let instances = emitters.last().map_or(0, |e| e.source.instance as usize + 1);
        let mut first_of_instance = Vec::new();
        if instances > 0 {
            first_of_instance = vec![0u32; instances + 1];
            for emitter in &emitters {
                first_of_instance[emitter.source.instance as usize + 1] += 1;
            }
            for i in 0..instances {
                first_of_instance[i + 1] += first_of_instance[i];
            }
        }

        let scene_radius = 0.5 * (scene_bounds.1 - scene_bounds.0).length();
        let scene_radius = if scene_radius.is_finite() && scene_radius > 0.0 { scene_radius } else { 1.0 };
        let punctual: Vec<PunctualLight> = punctual
            .iter()
            .filter(|light| light.intensity.is_finite() && light.intensity.max_element() > 0.0)
            .cloned()
            .collect();

        let powers: Vec<f32> = emitters.iter().map(|e| e.source.power.element_sum() / 3.0).collect();
        let emitter_table = if emitters.len() > FEW { Distribution1D::new(&powers) } else { None };
        let emitter_cluster =
            Cluster::new(emitters.iter().flat_map(|e| e.source.vertices), powers.iter().sum(), 0.0);
        let is_directional = |l: &&PunctualLight| l.kind == PunctualKind::Directional;
        let powers: Vec<f32> = punctual.iter().map(|l| punctual::power(l, scene_radius)).collect();
        let punctual_table = if punctual.len() > FEW { Distribution1D::new(&powers) } else { None };
        let placed = punctual.iter().filter(|l| !is_directional(l));
        let punctual_cluster = Cluster::new(
            placed.clone().map(|l| l.position),
            placed.map(|l| punctual::power(l, scene_radius)).sum(),
            punctual.iter().filter(is_directional).map(|l| l.intensity.element_sum() / 3.0).sum(),
        );
        let environment = Environment::new(environment);
        Self {
            lamps: Lamps::new(&emitters, &punctual, &environment),
            environment,
            punctual,
            emitters,
            first_of_instance,
            punctual_table,
            emitter_table,
            punctual_cluster,
            emitter_cluster,
        }
    }

    /// Whether the scene has no light at all.
    pub fn is_empty(&self) -> bool {
        self.environment.is_none() && self.punctual.is_empty() && self.emitters.is_empty()
    }

    /// Whether there are punctual lights, which only [`Self::sample`] can find.
    pub fn has_delta(&self) -> bool {
        !self.punctual.is_empty()
    }

    /// Whether there are emissive triangles.
    pub fn has_emitters(&self) -> bool {
        !self.emitters.is_empty()
    }

    /// The environment.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// The emissive triangle of an id.
    pub fn emitter(&self, id: EmitterId) -> Option<&EmissiveTriangle> {
        self.emitters.get(id.0 as usize).map(|e| &e.source)
    }

    /// How many emissive triangles there are; ids are the numbers below it.
    pub fn emitter_count(&self) -> usize {
        self.emitters.len()
    }

    /// The id of a triangle of an instance, if it emits.
    #[inline]
    pub fn emitter_id(&self, instance: u32, triangle: u32) -> Option<EmitterId> {
        let next = self.first_of_instance.get(instance as usize + 1)?;
        let first = self.first_of_instance[instance as usize] as usize;
        let range = &self.emitters[first..*next as usize];
        // Usually a whole mesh emits: then the triangle is found where it would be without gaps.
        let start = range.first()?.source.triangle;
        if let Some(offset) = triangle.checked_sub(start)
            && range.get(offset as usize).is_some_and(|e| e.source.triangle == triangle)
        {
            return Some(EmitterId(first as u32 + offset));
        }
        let i = range.binary_search_by_key(&triangle, |e| e.source.triangle).ok()?;
        Some(EmitterId((first + i) as u32))
    }

    /// Chooses a light and a direction to it. `None` where the choice sends nothing to the point (which counts as a
    /// sample of value zero).
    #[inline]
    pub fn sample(&self, point: Vec3, normal: Option<Vec3>, u_select: f32, u: Vec2) -> Option<LightSample> {
        self.sample_at(point, &Anchor { point, normal }, u_select, u)
    }

    /// As [`Self::sample`], choosing the light as seen from elsewhere.
    #[inline]
    pub fn sample_at(&self, point: Vec3, anchor: &Anchor, u_select: f32, u: Vec2) -> Option<LightSample> {
        let normal = anchor.normal;
        let choice = self.choice(anchor);
        let (group, group_probability, rest) = choice.groups.sample(u_select)?;
        match group {
            ENVIRONMENT => {
                let s = self.environment.sample(normal, u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: f32::INFINITY,
                    radiance: s.radiance,
                    pdf: s.pdf * group_probability,
                    delta: false,
                    emitter: None,
                })
            }
            PUNCTUAL => {
                let (i, probability, _) = match (&choice.punctual, &self.punctual_table) {
                    (Some(mixture), _) => mixture.sample(rest)?,
                    (None, table) => table.as_ref()?.sample(rest),
                };
                let p = punctual::irradiance(&self.punctual[i], point)?;
                Some(LightSample {
                    direction: p.direction,
                    distance: p.distance,
                    radiance: p.irradiance,
                    pdf: probability * group_probability,
                    delta: true,
                    emitter: None,
                })
            }
            _ => {
                let (i, probability, _) = match (&choice.emitters, &self.emitter_table) {
                    (Some(mixture), _) => mixture.sample(rest)?,
                    (None, table) => table.as_ref()?.sample(rest),
                };
                let s = self.emitters[i].sample(point, u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: s.distance,
                    radiance: s.radiance,
                    pdf: s.pdf * probability * group_probability,
                    delta: false,
                    emitter: Some(EmitterId(i as u32)),
                })
            }
        }
    }

    /// A random point of the closest light: of the lamp (punctual light, or emissive instance) nearest to the point, or
    /// where there is none of the directional lights and the environment. Not an estimate of all light.
    pub fn sample_closest(&self, point: Vec3, u_select: f32, u: Vec2) -> Option<LightSample> {
        self.lamps.sample((&self.emitters, &self.punctual, &self.environment), point, u_select, u)
    }

    /// Radiance of the environment from a unit direction; zero if there is none.
    #[inline]
    pub fn environment_radiance(&self, direction: Vec3) -> Vec3 {
        self.environment.radiance(direction)
    }

    /// The pdf that [`Self::sample`] at the same point and normal has for the environment in this direction.
    #[inline]
    pub fn environment_pdf(&self, point: Vec3, normal: Option<Vec3>, direction: Vec3) -> f32 {
        self.environment_pdf_at(&Anchor { point, normal }, direction)
    }

    /// The pdf that [`Self::sample_at`] has for the environment in this direction.
    #[inline]
    pub fn environment_pdf_at(&self, anchor: &Anchor, direction: Vec3) -> f32 {
        let pdf = self.environment.pdf(anchor.normal, direction);
        if pdf > 0.0 { pdf * self.choice(anchor).groups.probability(ENVIRONMENT) } else { 0.0 }
    }

    /// The pdf that [`Self::sample`] at the same point and normal has for the direction to `position`, a point of the
    /// emitter.
    #[inline]
    pub fn emitter_pdf(&self, emitter: EmitterId, point: Vec3, normal: Option<Vec3>, position: Vec3) -> f32 {
        self.emitter_pdf_at(emitter, point, &Anchor { point, normal }, position)
    }

    /// The pdf that [`Self::sample_at`] has for the direction to `position`, a point of the emitter.
    #[inline]
    pub fn emitter_pdf_at(&self, emitter: EmitterId, point: Vec3, anchor: &Anchor, position: Vec3) -> f32 {
        let i = emitter.0 as usize;
        let Some(light) = self.emitters.get(i) else { return 0.0 };
        let pdf = light.pdf(point, position);
        if pdf <= 0.0 {
            return 0.0;
        }
        let choice = self.choice(anchor);
        let probability = match (&choice.emitters, &self.emitter_table) {
            (Some(mixture), _) => mixture.probability(i),
            (None, table) => table.as_ref().map_or(0.0, |t| t.pdf(i)),
        };
        pdf * probability * choice.groups.probability(EMITTERS)
    }

    /// About the irradiance of a surface there if nothing is in the way, channel mean. Zero only where no light reaches
    /// that side.
    pub fn irradiance_estimate(&self, point: Vec3, normal: Vec3) -> f32 {
        let punctual = if self.punctual_table.is_some() {
            self.punctual_cluster.importance(point)
        } else {
            self.punctual.iter().map(|light| facing_irradiance(light, point, Some(normal))).sum()
        };
        let emitters = if self.emitter_table.is_some() {
            self.emitter_cluster.importance(point)
        } else {
            self.emitters.iter().map(|e| e.importance(point, Some(normal))).sum()
        };
        self.environment.irradiance(normal) + punctual + emitters
    }

    #[inline]
    fn choice(&self, anchor: &Anchor) -> Choice {
        let Anchor { point, normal } = *anchor;
        let punctual = self.punctual_table.is_none().then(|| {
            Mixture::new(
                LIGHT_DEFENSIVE,
                self.punctual.iter().map(|light| facing_irradiance(light, point, normal)),
            )
        });
        let emitters = self.emitter_table.is_none().then(|| {
            Mixture::new(LIGHT_DEFENSIVE, self.emitters.iter().map(|e| e.importance(point, normal)))
        });
        // Irradiance of a surface, fluence where there is none.
        let everywhere = || self.environment.mean_radiance() * 4.0 * std::f32::consts::PI;
        let environment = normal.map_or_else(everywhere, |n| self.environment.irradiance(n));
        let of = |few: &Option<Mixture>, many: &Cluster| {
            few.as_ref().map_or_else(|| many.importance(point), Mixture::sum)
        };
        let groups = Mixture::new(
            GROUP_DEFENSIVE,
            [environment, of(&punctual, &self.punctual_cluster), of(&emitters, &self.emitter_cluster)],
        );
        Choice { groups, punctual, emitters }
    }
}

/// Irradiance (fluence without a normal) that a punctual light makes where nothing is in the way, channel mean.
fn facing_irradiance(light: &PunctualLight, point: Vec3, normal: Option<Vec3>) -> f32 {
    let facing = |direction: Vec3| normal.map_or(1.0, |n| n.dot(direction).max(0.0));
    punctual::irradiance(light, point).map_or(0.0, |p| p.irradiance.element_sum() / 3.0 * facing(p.direction))
}

#[cfg(test)]
#[path = "lights_tests.rs"]
mod tests;
