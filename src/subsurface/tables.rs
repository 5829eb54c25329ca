//! The profiles of a model as tables: one for each channel of each medium and index around it, made when first used.
//!
//! **Textures.** Profiles are evaluated in closed form with the coefficients at x_i; radii are drawn from tables of the
//! untextured medium and of two thinner ones.

use super::exit_search::{Candidate, Radii};
use super::{Flight, TexturedMedium};
use crate::optics::diffusion::{Coefficients, RadialProfile, TabulatedProfile};
use crate::scene::Scene;
use glam::Vec3;
use std::collections::HashMap;
use std::ops::Deref;
use std::sync::{Arc, OnceLock, RwLock};

/// Densities of the media whose profiles radii are drawn from where coefficients are textured.
const THINNER: [f64; 2] = [0.25, 0.0625];

/// The profile of one channel.
pub(super) type Profile = dyn Fn(&Coefficients) -> Box<dyn RadialProfile> + Send + Sync;

/// What a model knows of each medium, by the material and the index around it; made when first used.
pub(super) struct PerMedium<T> {
    /// In vacuum, for each material.
    alone: Vec<OnceLock<Box<T>>>,
    /// By the material and the bits of the relative index.
    elsewhere: RwLock<HashMap<(u32, u32), Arc<T>>>,
}

/// A value of [`PerMedium`].
pub(super) enum Held<'a, T> {
    Alone(&'a T),
    Elsewhere(Arc<T>),
}

impl<T> Deref for Held<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Self::Alone(value) => value,
            Self::Elsewhere(value) => value,
        }
    }
}

impl<T> PerMedium<T> {
    pub fn new(scene: &Scene) -> Self {
        let alone = (0..scene.description.materials.len()).map(|_| OnceLock::new()).collect();
        Self { alone, elsewhere: RwLock::default() }
    }

    /// The value for the medium of a flight.
    pub fn get(&self, flight: &Flight<'_>, make: impl FnOnce() -> T) -> Held<'_, T> {
        let material = flight.enclosure.material;
        if flight.eta == flight.medium.ior
            && let Some(cell) = self.alone.get(material as usize)
        {
            return Held::Alone(cell.get_or_init(|| Box::new(make())));
        }
        let key = (material, flight.eta.to_bits());
        let known = self.elsewhere.read().ok().and_then(|known| known.get(&key).cloned());
        Held::Elsewhere(known.unwrap_or_else(|| {
            let value = Arc::new(make());
            if let Ok(mut known) = self.elsewhere.write() {
                known.insert(key, value.clone());
            }
            value
        }))
    }
}

/// The tables of a model for a scene.
pub(super) struct Tables {
    profile: Box<Profile>,
    media: PerMedium<MediumTables>,
}

/// The tables of one medium.
pub(super) struct MediumTables {
    channels: [Option<TabulatedProfile>; 3],
    /// For textured coefficients.
    thinner: Vec<TabulatedProfile>,
}

impl Tables {
    pub fn new(scene: &Scene, profile: Box<Profile>) -> Self {
        Self { profile, media: PerMedium::new(scene) }
    }

    /// The tables of the medium of a flight.
    pub fn of(&self, flight: &Flight<'_>) -> Held<'_, MediumTables> {
        self.media.get(flight, || MediumTables::new(flight, &self.profile))
    }

    /// R at a candidate, 1/m², each channel.
    pub fn reflectance(&self, flight: &Flight<'_>, tables: &MediumTables, c: &Candidate) -> Vec3 {
        if tables.thinner.is_empty() {
            return tables
                .of_each(|t| if c.distance > c.least { t.eval(c.distance) } else { t.disk_mean(c.least) });
        }
        let at = coefficients_at(flight, c.position);
        Vec3::from_array(at.map(|c_i| {
            if c_i.scatters() {
                (self.profile)(&c_i).eval(f64::from(c.distance).max(1e-9)) as f32
            } else {
                0.0
            }
        }))
    }
}

impl MediumTables {
    fn new(flight: &Flight<'_>, profile: &Profile) -> Self {
        let table = |c: &Coefficients| TabulatedProfile::new(&*profile(c));
        let own = flight.coefficients();
        let thin = |factor: f64| {
            own.map(|c| Coefficients { sigma_a: factor * c.sigma_a, sigma_s: factor * c.sigma_s, ..c })
        };
        let thinner = if flight.is_textured() {
            THINNER.into_iter().flat_map(thin).filter_map(|c| table(&c)).collect()
        } else {
            Vec::new()
        };
        Self { channels: own.map(|c| table(&c)), thinner }
    }

    fn of_each(&self, value: impl Fn(&TabulatedProfile) -> f32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|i| self.channels[i].as_ref().map_or(0.0, &value)))
    }

    /// ∫ R, each channel.
    pub fn total(&self) -> Vec3 {
        self.of_each(TabulatedProfile::total)
    }

    /// The radii that a path with the throughput `beta` is to be searched at. `None`: nothing is scattered.
    pub fn radii(&self, beta: Vec3) -> Option<Radii<'_>> {
        let weights = beta * self.total();
        let own = (0..3).filter_map(|i| Some((self.channels[i].as_ref()?, weights[i])));
        let share = weights.element_sum() / self.thinner.len().max(1) as f32;
        Radii::new(own.chain(self.thinner.iter().map(|t| (t, share))))
    }
}

/// (σa, σs) in 1/m at a world position: the textured ones, where there are textures.
pub(super) fn sigmas_at(flight: &Flight<'_>, position: Vec3) -> (Vec3, Vec3) {
    if flight.is_textured() {
        TexturedMedium::new(flight.scene, flight.enclosure).coefficients(position)
    } else {
        (flight.medium.sigma_a, flight.medium.sigma_s)
    }
}

/// The same for each channel.
pub(super) fn coefficients_at(flight: &Flight<'_>, position: Vec3) -> [Coefficients; 3] {
    let (sigma_a, sigma_s) = sigmas_at(flight, position);
    let (g, eta) = (f64::from(flight.medium.g), f64::from(flight.eta));
    [0, 1, 2].map(|i| Coefficients { sigma_a: f64::from(sigma_a[i]), sigma_s: f64::from(sigma_s[i]), g, eta })
}
