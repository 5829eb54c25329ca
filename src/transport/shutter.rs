//! Motion blur: a picture that is exposed for a while is a mean of pictures of moments.
//!
//! The time is cut into strata, and each is rendered at one random moment of it, as a scene of its own. So everything
//! that changes is blurred alike: objects, joints, lights, the camera, materials and media. The mean over seeds is the
//! integral over time, without bias (Cook, Porter & Carpenter 1984, with the moments of a stratum shared by all
//! pixels, since a scene is compiled for each). A stratum is as long as its share of the samples, so that all samples
//! weigh the same; a scene in which nothing moves gives the picture without a shutter.
//!
//! Strata are visited in an order that spreads over the time (van der Corput), so that what is finished when somebody
//! cancels is blurred evenly.

use super::control::{RenderControl, RenderError};
use super::options::{RenderOptions, View};
use super::render::{Goal, Rendered, begin, expose};
use super::session::Session;
use crate::sampling::rng::hash3;
use crate::scene::{CameraDescription, Scene};
use crate::subsurface::Registry;
use std::sync::Arc;

/// An open shutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// When it opens, seconds.
    pub open: f64,
    /// When it closes, seconds.
    pub close: f64,
    /// Moments to render; never more than samples.
    pub slices: u32,
}

/// A moment and the samples that are taken of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Seconds.
    pub time: f64,
    /// Index of the first sample.
    pub first_sample: u32,
    /// Number of samples.
    pub samples: u32,
}

impl Shutter {
    /// The moments, in the order in which they are rendered.
    pub fn slices(&self, spp: u32, seed: u32) -> Vec<Slice> {
        /// Tells these random numbers from others of the same seed.
        const MOMENTS: u32 = 0x7368_7574;
        let n = self.slices.clamp(1, spp.max(1));
        let bits = n.next_power_of_two().trailing_zeros();
        let reversed = |i: u32| if bits == 0 { 0 } else { i.reverse_bits() >> (32 - bits) };
        let mut order: Vec<u32> = (0..n).collect();
        order.sort_by_key(|&stratum| reversed(stratum));
        let share = |place: u32| (u64::from(spp) * u64::from(place) / u64::from(n)) as u32;
        let mut slices: Vec<(u32, Slice)> = (0..n)
            .zip(order)
            .map(|(place, stratum)| {
                let (first_sample, end) = (share(place), share(place + 1));
                (stratum, Slice { time: self.open, first_sample, samples: end - first_sample })
            })
            .collect();
        let mut in_time: Vec<&mut (u32, Slice)> = slices.iter_mut().collect();
        in_time.sort_by_key(|(stratum, _)| *stratum);
        let mut before = 0;
        for (stratum, slice) in in_time {
            let jitter = (hash3(*stratum, MOMENTS, seed) >> 11) as f64 / (1_u64 << 53) as f64;
            let fraction = (f64::from(before) + jitter * f64::from(slice.samples)) / f64::from(spp.max(1));
            slice.time = self.open + (self.close - self.open) * fraction;
            before += slice.samples;
        }
        slices.into_iter().map(|(_, slice)| slice).collect()
    }
}

/// Renders a picture while the shutter is open; `pose` gives the scene and the camera of a moment. When it is
/// cancelled the moments that are finished are kept, or what there is of the first.
///
/// One session sees all moments: its scene changes, its film goes on.
///
/// # Errors
/// Those of `pose`; unknown models, empty images, no threads.
pub fn render_shutter<E: From<RenderError>>(
    shutter: &Shutter,
    options: &RenderOptions,
    control: &dyn RenderControl,
    models: &Registry,
    mut pose: impl FnMut(f64) -> Result<(Scene, CameraDescription), E>,
) -> Result<Rendered, E> {
    let count = options.samples.count;
    let pixels = u64::from(options.view.width) * u64::from(options.view.height);
    let mut open: Option<Session<Arc<Scene>>> = None;
    for slice in shutter.slices(count, options.settings.seed) {
        if open.is_some() && control.cancelled() {
            break;
        }
        let (scene, camera) = pose(slice.time)?;
        let view = View { camera, ..options.view.clone() };
        let is_first = open.is_none();
        let session = match &mut open {
            Some(session) => {
                session.set_scene(Arc::new(scene));
                session.set_view(view)?;
                session
            }
            none => {
                let options = RenderOptions { view, ..options.clone() };
                none.insert(begin(Arc::new(scene), &options, models)?)
            }
        };
        let before = pixels * u64::from(slice.first_sample);
        let goal = Goal { control, before, total: pixels * u64::from(count), is_first };
        let finished = session.film().clone();
        if !expose(session, slice.samples, &goal) {
            if !is_first {
                // Part of a moment would weigh more than the others.
                session.resume(finished).map_err(RenderError::from)?;
            }
            break;
        }
        if slice.first_sample + slice.samples < count {
            control.between_passes(&|| Rendered::of(session));
        }
    }
    let Some(session) = open else {
        let View { width, height, .. } = options.view;
        return Err(RenderError::Empty { width, height, spp: count }.into());
    };
    Ok(Rendered::from_session(session))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_share_the_samples_and_cover_the_time_in_strata() {
        for (spp, slices) in [(64, 16), (5, 16), (50, 16), (7, 3), (1, 1), (16, 1)] {
            let shutter = Shutter { open: 2.0, close: 3.0, slices };
            let found = shutter.slices(spp, 9);
            assert_eq!(found.len() as u32, slices.min(spp));
            let mut next = 0;
            for slice in &found {
                assert_eq!(slice.first_sample, next);
                assert!(slice.samples > 0);
                next += slice.samples;
            }
            assert_eq!(next, spp);
            let mut in_time = found.clone();
            in_time.sort_by(|a, b| a.time.total_cmp(&b.time));
            let mut before = 0.0;
            for slice in in_time {
                let end = before + f64::from(slice.samples) / f64::from(spp);
                assert!((before..=end).contains(&(slice.time - 2.0)), "{slice:?}");
                before = end;
            }
        }
    }

    #[test]
    fn every_beginning_is_spread_over_the_time_and_moments_are_uniform() {
        let shutter = Shutter { open: 0.0, close: 1.0, slices: 16 };
        let first: Vec<f64> = shutter.slices(16, 1).iter().take(4).map(|s| s.time).collect();
        for quarter in 0..4 {
            let inside = |t: &&f64| (**t * 4.0) as u32 == quarter;
            assert_eq!(first.iter().filter(inside).count(), 1, "{first:?}");
        }
        // The first moment is uniform in [0, 1/16]: a mean over n seeds has standard error 1/16/√(12 n).
        let n = 1000;
        let mean = (0..n).map(|seed| shutter.slices(16, seed)[0].time).sum::<f64>() / f64::from(n);
        let z = (mean - 1.0 / 32.0) / (1.0 / 16.0 / (12.0 * f64::from(n)).sqrt());
        assert!(z.abs() < 4.0, "{z}");
        assert_ne!(shutter.slices(16, 1), shutter.slices(16, 2));
    }
}
