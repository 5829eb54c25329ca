//! Punctual lights by the hundred: those with a place in a [`LightTree`], directional ones beside it.

use super::cone::Cone;
use super::mixture::{FEW, Mixture};
use super::punctual;
use super::tree::{LightBounds, LightTree};
use crate::sampling::Distribution1D;
use crate::scene::{PunctualKind, PunctualLight};
use glam::Vec3;

/// δ of the choice between the tree and directional lights.
const DEFENSIVE: f32 = 0.2;

/// Many punctual lights, sorted for the choice of one.
#[derive(Clone, Debug)]
pub(super) struct ManyPunctual {
    tree: Option<LightTree>,
    /// Lights of the tree, and the others, as indices of all.
    placed: Vec<u32>,
    distant: Vec<u32>,
    /// By irradiance, where there are more than [`FEW`] of them.
    distant_table: Option<Distribution1D>,
}

/// Mean of the colour channels.
fn mean(v: Vec3) -> f32 {
    v.element_sum() / 3.0
}

/// Irradiance (fluence without a normal) that a punctual light makes where nothing is in the way, channel mean.
pub(super) fn facing_irradiance(light: &PunctualLight, point: Vec3, normal: Option<Vec3>) -> f32 {
    let facing = |direction: Vec3| normal.map_or(1.0, |n| n.dot(direction).max(0.0));
    punctual::irradiance(light, point).map_or(0.0, |p| p.irradiance.element_sum() / 3.0 * facing(p.direction))
}

fn bounds(light: &PunctualLight) -> LightBounds {
    let cone = match &light.kind {
        PunctualKind::Spot { inner, outer } => {
            let spread = (outer - inner).max(0.0);
            Cone { axis: light.direction, axes: inner.max(0.0), spread, two_sided: false }
        }
        PunctualKind::Web(web) => {
            // Its largest candela may be anywhere within.
            let (axis, axes) = web.cone();
            Cone { axis, axes, spread: 0.0, two_sided: false }
        }
        PunctualKind::Point | PunctualKind::Directional => Cone::SPHERE,
    };
    LightBounds {
        low: light.position,
        high: light.position,
        cone,
        flux: mean(light.intensity),
        reach: light.range.filter(|r| *r > 0.0).unwrap_or(f32::INFINITY),
    }
}

impl ManyPunctual {
    /// `defensive` is the share of probability that is spread evenly among the last few.
    pub fn new(lights: &[PunctualLight], defensive: f32) -> Self {
        let is_distant = |i: &u32| lights[*i as usize].kind == PunctualKind::Directional;
        let (distant, placed): (Vec<u32>, Vec<u32>) = (0..lights.len() as u32).partition(is_distant);
        let of_tree: Vec<LightBounds> = placed.iter().map(|&i| bounds(&lights[i as usize])).collect();
        let irradiances: Vec<f32> = distant.iter().map(|&i| mean(lights[i as usize].intensity)).collect();
        Self {
            tree: LightTree::new(&of_tree, defensive),
            placed,
            distant_table: if distant.len() > FEW { Distribution1D::new(&irradiances) } else { None },
            distant,
        }
    }

    /// About the irradiance of all of them.
    pub fn importance(&self, lights: &[PunctualLight], point: Vec3, normal: Option<Vec3>) -> f32 {
        self.placed_importance(point, normal) + self.distant_importance(lights, point, normal)
    }

    fn placed_importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        self.tree.as_ref().map_or(0.0, |t| t.importance(point, normal))
    }

    fn distant_importance(&self, lights: &[PunctualLight], point: Vec3, normal: Option<Vec3>) -> f32 {
        match &self.distant_table {
            Some(table) => table.total() as f32,
            None => self.distant_weights(lights, point, normal).sum(),
        }
    }

    fn distant_weights(
        &self,
        lights: &[PunctualLight],
        point: Vec3,
        normal: Option<Vec3>,
    ) -> impl Iterator<Item = f32> {
        self.distant.iter().map(move |&i| facing_irradiance(&lights[i as usize], point, normal))
    }

    /// A light as seen from a point, and its probability; `lights` are those given to [`Self::new`].
    pub fn sample(
        &self,
        lights: &[PunctualLight],
        (point, normal): (Vec3, Option<Vec3>),
        u: f64,
    ) -> Option<(usize, f32)> {
        let weights = [self.placed_importance(point, normal), self.distant_importance(lights, point, normal)];
        let kinds = Mixture::new(DEFENSIVE, weights);
        let of_tree = kinds.probability(0);
        if u < f64::from(of_tree) {
            let light = |i: usize| self.placed[i] as usize;
            let exact = |i: usize| facing_irradiance(&lights[light(i)], point, normal);
            let (i, p) = self.tree.as_ref()?.sample((point, normal), u / f64::from(of_tree), exact)?;
            return Some((light(i), p * of_tree));
        }
        let u = ((u - f64::from(of_tree)) / (1.0 - f64::from(of_tree))) as f32;
        let (i, p, _) = match &self.distant_table {
            Some(table) => table.sample(u.clamp(0.0, crate::sampling::ONE_MINUS_EPSILON)),
            None => Mixture::new(DEFENSIVE, self.distant_weights(lights, point, normal)).sample(u)?,
        };
        Some((self.distant[i] as usize, p * kinds.probability(1)))
    }

    /// The probability of [`Self::sample`] to choose a light.
    pub fn probability(
        &self,
        lights: &[PunctualLight],
        (point, normal): (Vec3, Option<Vec3>),
        light: usize,
    ) -> f32 {
        let weights = [self.placed_importance(point, normal), self.distant_importance(lights, point, normal)];
        let kinds = Mixture::new(DEFENSIVE, weights);
        // Both lists are in the order of all lights.
        let place = |list: &[u32]| list.binary_search(&(light as u32)).ok();
        if let (Some(i), Some(tree)) = (place(&self.placed), &self.tree) {
            let exact = |i: usize| facing_irradiance(&lights[self.placed[i] as usize], point, normal);
            return kinds.probability(0) * tree.probability(i, (point, normal), exact);
        }
        let Some(i) = place(&self.distant) else { return 0.0 };
        let of_distant = match &self.distant_table {
            Some(table) => table.pdf(i),
            None => Mixture::new(DEFENSIVE, self.distant_weights(lights, point, normal)).probability(i),
        };
        kinds.probability(1) * of_distant
    }
}
