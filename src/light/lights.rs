//! All lights of a scene, and choosing one of them for next-event estimation.
//!
//! Three groups (environment, punctual lights, emissive triangles) are weighed by the light they would send to the
//! point if nothing were in between; the group is chosen by a defensive mixture of the weights. Within a group up to
//! `FEW` lights are weighed in the same way one by one; more of them are leaves of a light tree (`tree.rs`).
//!
//! Everything is a function of the point and the normal, so the density of a direction that was found in another way
//! (a scattered ray that reached a light) is the same that [`Lights::sample`] would have had, *if the caller passes the
//! same point and normal*. A normal says that only light from its side counts; pass `None` inside media and where light
//! is transmitted.

use glam::{Vec2, Vec3};

use super::{
    emitter::{EmissiveTriangle, Emitter, EmitterId},
    environment::{Environment, Facing},
    many::{ManyPunctual, facing_irradiance},
    mixture::{FEW, Mixture},
    nearest::Lamps,
    point::LightPoint,
    punctual,
    tree::{LightTree, finer},
};
use crate::scene::{EnvironmentDescription, PunctualLight};

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
    /// What was chosen.
    pub point: LightPoint,
}

/// Where a light is chosen: the lit point, or another from which it is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Anchor {
    /// World position.
    pub point: Vec3,
    /// Only light from this side counts; `None`: all light.
    pub normal: Option<Vec3>,
    /// Light of the environment from about this side is enough: the rest can be found by chance.
    pub about: Option<Vec3>,
}

impl Anchor {
    /// A lit point, for light from the side of a normal if there is one.
    pub fn at(point: Vec3, normal: Option<Vec3>) -> Self {
        Self { point, normal, about: None }
    }

    /// What light of the environment is chosen for.
    #[inline]
    fn facing(&self) -> Facing {
        match (self.normal, self.about) {
            (Some(normal), _) => Facing::Surface(normal),
            (None, Some(normal)) => Facing::About(normal),
            (None, None) => Facing::All,
        }
    }
}

/// The lights of a scene.
#[derive(Clone, Debug)]
pub struct Lights {
    environment: Environment,
    pub(super) punctual: Vec<PunctualLight>,
    /// Sorted by instance and triangle.
    pub(super) emitters: Vec<Emitter>,
    /// First emitter of each instance, with the number of emitters at the end; empty without emitters.
    first_of_instance: Vec<u32>,
    /// Where there are more than [`FEW`].
    many_punctual: Option<ManyPunctual>,
    emitter_tree: Option<LightTree>,
    lamps: Lamps,
}

/// The probabilities of everything that can be chosen for a point; `None` where a tree is used instead.
struct Choice {
    groups: Mixture,
    punctual: Option<Mixture>,
    emitters: Option<Mixture>,
}

impl Lights {
    /// Prepares the lights. Emitters without area or power, and punctual lights without intensity, are left out.
    pub fn build(
        emitters: Vec<EmissiveTriangle>,
        punctual: &[PunctualLight],
        environment: &EnvironmentDescription,
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

        let punctual: Vec<PunctualLight> = punctual
            .iter()
            .filter(|light| light.intensity.is_finite() && light.intensity.max_element() > 0.0)
            .cloned()
            .collect();

        let many_punctual = (punctual.len() > FEW).then(|| ManyPunctual::new(&punctual, LIGHT_DEFENSIVE));
        let emitter_tree = if emitters.len() > FEW {
            let bounds: Vec<_> = emitters.iter().map(Emitter::bounds).collect();
            LightTree::new(&bounds, LIGHT_DEFENSIVE)
        } else {
            None
        };
        let environment = Environment::new(environment);
        Self {
            lamps: Lamps::new(&emitters, &punctual, &environment),
            environment,
            punctual,
            emitters,
            first_of_instance,
            many_punctual,
            emitter_tree,
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
        self.sample_at(&Anchor::at(point, normal), u_select, u)
    }

    /// As [`Self::sample`].
    #[inline]
    pub fn sample_at(&self, anchor: &Anchor, u_select: f32, u: Vec2) -> Option<LightSample> {
        let Anchor { point, normal, .. } = *anchor;
        let choice = self.choice(anchor);
        let (group, group_probability, rest) = choice.groups.sample(u_select)?;
        match group {
            ENVIRONMENT => {
                let s = self.environment.sample(anchor.facing(), u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: f32::INFINITY,
                    radiance: s.radiance,
                    pdf: s.pdf * group_probability,
                    point: LightPoint::Environment(s.direction),
                })
            }
            PUNCTUAL => {
                let (i, probability) = match (&choice.punctual, &self.many_punctual) {
                    (_, Some(many)) => many.sample(&self.punctual, (point, normal), finer(rest, u))?,
                    (mixture, None) => mixture.as_ref()?.sample(rest).map(|(i, p, _)| (i, p))?,
                };
                let p = punctual::irradiance(&self.punctual[i], point)?;
                Some(LightSample {
                    direction: p.direction,
                    distance: p.distance,
                    radiance: p.irradiance,
                    pdf: probability * group_probability,
                    point: LightPoint::Punctual(i as u32),
                })
            }
            _ => {
                let (i, probability) = match (&choice.emitters, &self.emitter_tree) {
                    (_, Some(tree)) => {
                        let exact = |i: usize| self.emitters[i].importance(point, normal);
                        tree.sample((point, normal), finer(rest, u), exact)?
                    }
                    (mixture, None) => mixture.as_ref()?.sample(rest).map(|(i, p, _)| (i, p))?,
                };
                let s = self.emitters[i].sample(point, u)?;
                Some(LightSample {
                    direction: s.direction,
                    distance: s.distance,
                    radiance: s.radiance,
                    pdf: s.pdf * probability * group_probability,
                    point: LightPoint::Emitter(EmitterId(i as u32), s.position),
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
        self.environment_pdf_at(&Anchor::at(point, normal), direction)
    }

    /// The pdf that [`Self::sample_at`] has for the environment in this direction.
    #[inline]
    pub fn environment_pdf_at(&self, anchor: &Anchor, direction: Vec3) -> f32 {
        let pdf = self.environment.pdf(anchor.facing(), direction);
        if pdf > 0.0 { pdf * self.choice(anchor).groups.probability(ENVIRONMENT) } else { 0.0 }
    }

    /// Instance and triangle of an emitter.
    pub fn emitter_triangle(&self, emitter: EmitterId) -> Option<(u32, u32)> {
        self.emitters.get(emitter.0 as usize).map(|e| (e.source.instance, e.source.triangle))
    }

    /// The pdf that [`Self::sample`] at the same point and normal has for the direction to `position`, a point of the
    /// emitter.
    #[inline]
    pub fn emitter_pdf(&self, emitter: EmitterId, point: Vec3, normal: Option<Vec3>, position: Vec3) -> f32 {
        self.emitter_pdf_at(emitter, point, &Anchor::at(point, normal), position)
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
        let probability = match (&choice.emitters, &self.emitter_tree) {
            (_, Some(tree)) => {
                let exact = |i: usize| self.emitters[i].importance(anchor.point, anchor.normal);
                tree.probability(i, (anchor.point, anchor.normal), exact)
            }
            (mixture, None) => mixture.as_ref().map_or(0.0, |m| m.probability(i)),
        };
        pdf * probability * choice.groups.probability(EMITTERS)
    }

    /// The probability that [`Self::sample_at`] has for a punctual light.
    pub(super) fn punctual_probability(&self, i: usize, anchor: &Anchor) -> f32 {
        let choice = self.choice(anchor);
        let probability = match (&choice.punctual, &self.many_punctual) {
            (_, Some(many)) => many.probability(&self.punctual, (anchor.point, anchor.normal), i),
            (mixture, None) => mixture.as_ref().map_or(0.0, |m| m.probability(i)),
        };
        probability * choice.groups.probability(PUNCTUAL)
    }

    /// About the irradiance of a surface there if nothing is in the way, channel mean. Zero only where no light reaches
    /// that side.
    pub fn irradiance_estimate(&self, point: Vec3, normal: Vec3) -> f32 {
        let punctual = match &self.many_punctual {
            Some(many) => many.importance(&self.punctual, point, Some(normal)),
            None => self.punctual.iter().map(|light| facing_irradiance(light, point, Some(normal))).sum(),
        };
        let emitters = match &self.emitter_tree {
            Some(tree) => tree.importance(point, Some(normal)),
            None => self.emitters.iter().map(|e| e.importance(point, Some(normal))).sum(),
        };
        self.environment.irradiance(normal) + punctual + emitters
    }

    #[inline]
    fn choice(&self, anchor: &Anchor) -> Choice {
        let Anchor { point, normal, .. } = *anchor;
        let punctual = self.many_punctual.is_none().then(|| {
            Mixture::new(
                LIGHT_DEFENSIVE,
                self.punctual.iter().map(|light| facing_irradiance(light, point, normal)),
            )
        });
        let emitters = self.emitter_tree.is_none().then(|| {
            Mixture::new(LIGHT_DEFENSIVE, self.emitters.iter().map(|e| e.importance(point, normal)))
        });
        // Irradiance of a surface, fluence where there is none.
        let everywhere = || self.environment.mean_radiance() * 4.0 * std::f32::consts::PI;
        let environment = normal.map_or_else(everywhere, |n| self.environment.irradiance(n));
        let of_punctual = match &self.many_punctual {
            Some(many) => many.importance(&self.punctual, point, normal),
            None => punctual.as_ref().map_or(0.0, Mixture::sum),
        };
        let of_emitters = match &self.emitter_tree {
            Some(tree) => tree.importance(point, normal),
            None => emitters.as_ref().map_or(0.0, Mixture::sum),
        };
        let groups = Mixture::new(GROUP_DEFENSIVE, [environment, of_punctual, of_emitters]);
        Choice { groups, punctual, emitters }
    }
}

#[cfg(test)]
#[path = "close_tests.rs"]
mod close_tests;
#[cfg(test)]
#[path = "lights_tests.rs"]
mod tests;
