//! Colours to coefficients: each texel is inverted behind the boundary of its medium.
//!
//! A colour C and an extinction σt make σa = σt a(C) and σs = σt (1 − a(C)), where a is the share of absorption of a half
//! space that shows C. The textures are 16 bits deep and multiply the largest coefficients that occur. The σa of bright
//! places beside dark ones is a small number of steps, so its rounding would be seen: it is rounded first, and σs is what
//! makes the colour right beside the rounded σa. The mean free path of such places is then a little off, which is not seen.

use super::{Colors, mean};
use crate::author::Medium;
use crate::optics::seen_color::shares_of_seen_color;
use crate::optics::seen_color_table::SeenColorTable;
use glam::Vec3;
use rayon::prelude::*;

/// Steps of a channel.
const STEPS: f64 = 65535.0;
/// A share of absorption below this part of a step is none.
const NONE: f64 = 0.125;
/// How far a rounded absorption may change the mean free path.
const MOST_CHANGE: f64 = 2.0;

/// What the colours are put into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Extinction coefficient, 1/m, above 0.
    pub sigma_t: [f64; 3],
    /// Mean cosine.
    pub g: f64,
    /// Index of refraction.
    pub ior: f64,
}

/// Coefficients of a coat.
#[derive(Clone, Debug, PartialEq)]
pub struct Painted {
    /// Absorption and scattering coefficients that textures multiply, 1/m.
    pub sigma_a: [f64; 3],
    /// See `sigma_a`.
    pub sigma_s: [f64; 3],
    /// Width and texels of the absorption texture, 16 bits a channel, if it is not white.
    pub absorption: Option<(u32, Vec<[u16; 3]>)>,
    /// The same of scattering.
    pub scattering: Option<(u32, Vec<[u16; 3]>)>,
}

impl Painted {
    /// A homogeneous medium that looks like the mean of all places, for those who know no textures.
    pub fn mean(&self, basis: &Basis) -> Medium {
        let white = Medium { sigma_a: self.sigma_a, sigma_s: self.sigma_s, g: basis.g, ior: basis.ior };
        let texel = |texture: &Option<(u32, Vec<[u16; 3]>)>, i: u32| match texture {
            Some((width, texels)) => {
                let height = texels.len() as u32 / width.max(&1);
                let [x, y] = mean::field(i, [*width, height]);
                let texel = texels.get((y * width + x) as usize).copied().unwrap_or([u16::MAX; 3]);
                texel.map(|v| f64::from(f32::from(v) / 65535.0))
            }
            None => [1.0; 3],
        };
        if self.absorption.is_none() && self.scattering.is_none() {
            return white;
        }
        mean::mean(white, |i| [texel(&self.absorption, i), texel(&self.scattering, i)])
    }
}

impl Basis {
    /// The coefficients that show these colours.
    pub fn paint(&self, colors: &Colors) -> Painted {
        match colors {
            Colors::Uniform(color) => self.uniform(*color),
            Colors::Picture { width, texels } => self.picture(*width, texels),
        }
    }

    fn uniform(&self, color: Vec3) -> Painted {
        let shares = color.to_array().map(|c| shares_of_seen_color(f64::from(c), self.g, self.ior));
        let of = |share: usize| [0, 1, 2].map(|i| digits(self.sigma_t[i] * shares[i][share]));
        let (sigma_a, sigma_s) = (of(1), of(0));
        Painted { sigma_a, sigma_s, absorption: None, scattering: None }
    }

    fn picture(&self, width: u32, texels: &[Vec3]) -> Painted {
        let table = SeenColorTable::new(self.g, self.ior);
        let darkest = texels.iter().fold(Vec3::ONE, |low, t| low.min(*t));
        // Absorption falls with the colour.
        let largest = darkest.to_array().map(|c| table.shares(f64::from(c))[1]);
        let absorbed = |i: usize, share: f64| match share / largest[i].max(f64::MIN_POSITIVE) * STEPS {
            steps if steps < NONE => 0.0,
            steps => steps.round().max(1.0),
        };
        // Of one texel: σa in steps, σs in units of σt.
        let texel = |i: usize, color: f32| {
            let [scattered, share] = table.shares(f64::from(color));
            let steps = absorbed(i, share);
            let change = if share > 0.0 && steps > 0.0 { steps / STEPS * largest[i] / share } else { 1.0 };
            (steps, scattered * change.min(MOST_CHANGE))
        };
        let most = texels
            .par_iter()
            .map(|t| Vec3::from_array([0, 1, 2].map(|i| texel(i, t[i]).1 as f32)))
            .reduce(|| Vec3::ZERO, Vec3::max)
            .to_array()
            .map(f64::from);
        let round = |v: f64| v.round().clamp(0.0, STEPS) as u16;
        let (absorption, scattering): (Vec<[u16; 3]>, Vec<[u16; 3]>) = texels
            .par_iter()
            .map(|t| {
                let both = [0, 1, 2].map(|i| texel(i, t[i]));
                let share = |i: usize| both[i].1 / most[i].max(f64::MIN_POSITIVE) * STEPS;
                (both.map(|(steps, _)| round(steps)), [0, 1, 2].map(|i| round(share(i))))
            })
            .unzip();
        let sigma_a = [0, 1, 2].map(|i| digits(self.sigma_t[i] * largest[i]));
        let sigma_s = [0, 1, 2].map(|i| digits(self.sigma_t[i] * most[i]));
        let needed = |coefficient: [f64; 3], texels: &[[u16; 3]]| {
            coefficient != [0.0; 3]
                && texels.iter().any(|t| (0..3).any(|i| coefficient[i] > 0.0 && t[i] < u16::MAX))
        };
        let texture =
            |coefficient, texels: Vec<[u16; 3]>| needed(coefficient, &texels).then_some((width, texels));
        Painted {
            absorption: texture(sigma_a, absorption),
            scattering: texture(sigma_s, scattering),
            sigma_a,
            sigma_s,
        }
    }
}

/// Eight digits: more than a computed coefficient is good for.
pub fn digits(value: f64) -> f64 {
    format!("{value:.7e}").parse().unwrap_or(value)
}
