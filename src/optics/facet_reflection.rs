//! What facets of an opaque or thin surface reflect and lose, by direction: from the tables of one width, or where there
//! are two, or a film, from those of [`super::facet_tables`].
//!
//! | number | symbol | meaning |
//! | --- | --- | --- |
//! | `lost` | L(ω) | share lost by perfectly reflecting facets |
//! | `schlick` | E_w(ω) | share reflected by facets of reflectance (1 − ω·h)⁵ |
//! | `hats` | E_k(ω) | share reflected by facets whose reflectance is the hat function k of ω·h |

use super::anisotropic::Facets;
use super::boundary_tables::MIN_ROUGH_ALPHA;
use super::facet_tables::{At, FacetTables, HATS, VISIBLE, hat, visible_normals};
use super::fresnel::schlick_weight;
use super::reflection_tables::{Directional, Reflection};
use glam::{Vec2, Vec3};

const NUMBERS: usize = 2 + HATS;

/// The reflection of facets.
#[derive(Clone, Copy, Debug)]
pub(super) enum FacetReflection {
    /// Of one width, without a film.
    Plain(Reflection),
    /// Any other.
    General(At<NUMBERS>),
}

/// What is reflected and lost in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    pub(super) plain: Directional,
    /// Where they are known.
    pub(super) hats: Option<[f32; HATS]>,
}

impl FacetReflection {
    /// Of these facets, which may have a film.
    pub(super) fn new(facets: &Facets, film: bool) -> Self {
        static TABLES: FacetTables<NUMBERS> = FacetTables::new(1.0);
        let Vec2 { x, y } = facets.alpha;
        if x.max(y) < MIN_ROUGH_ALPHA {
            Self::Plain(Reflection::SMOOTH)
        } else if x == y && !film {
            Self::Plain(Reflection::at(x))
        } else {
            Self::General(TABLES.at(facets, numbers))
        }
    }

    /// Averages over directions.
    pub(super) fn average(&self) -> Directional {
        match self {
            Self::Plain(r) => Directional { lost: r.lost_average, schlick: r.schlick_average },
            Self::General(at) => shares(&at.average).plain,
        }
    }

    /// What becomes of light from a turned direction.
    #[inline]
    pub(super) fn towards(&self, w: Vec3) -> Shares {
        match self {
            Self::Plain(r) => Shares { plain: r.directional(w.z.abs()), hats: None },
            Self::General(at) => shares(&at.towards(w)),
        }
    }
}

fn shares(numbers: &[f32; NUMBERS]) -> Shares {
    let hats = std::array::from_fn(|k| numbers[2 + k]);
    Shares { plain: Directional { lost: numbers[0], schlick: numbers[1] }, hats: Some(hats) }
}

fn numbers(facets: &Facets, w: Vec3) -> [f32; NUMBERS] {
    let mut sum = [0.0; NUMBERS];
    visible_normals(facets, w, |h| {
        let c = w.dot(h).clamp(0.0, 1.0);
        let i = 2.0 * c * h - w;
        let passed = if i.z > 0.0 { VISIBLE * facets.masking(i) } else { 0.0 };
        let (k, t) = hat(c);
        sum[0] += VISIBLE - passed;
        sum[1] += passed * schlick_weight(c);
        sum[2 + k] += passed * (1.0 - t);
        sum[3 + k] += passed * t;
    });
    sum[0] = sum[0].max(0.0);
    sum
}
