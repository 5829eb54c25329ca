//! Who waits for a picture: progress, cancellation, and what there is to tell at the end.

use super::render::Rendered;

/// Progress and cancellation, from whoever waits.
pub trait RenderControl: Sync {
    /// Called now and then with the samples done so far and in all.
    fn advance(&self, samples_done: u64, samples_total: u64);
    /// Whether to stop; what is finished is kept. Asked often, at least every 20 ms; it stays so.
    fn cancelled(&self) -> bool;
    /// Called by [`render()`](super::render()) between passes, while nothing is rendered; `picture` makes the picture so far,
    /// whose pixels all have the same number of samples.
    fn between_passes(&self, _picture: &dyn Fn() -> Rendered) {}
}

/// Neither watches nor cancels.
impl RenderControl for () {
    fn advance(&self, _: u64, _: u64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Work done and trouble met.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderStats {
    /// Rays followed: camera rays, bounces, shadow rays, and one for each flight through a medium.
    pub rays: u64,
    /// Scattering events in media.
    pub scattering_events: u64,
    /// Paths that ended at the cap on events.
    pub truncated_paths: u64,
    /// Paths that left a medium without crossing its boundary.
    pub leaked_paths: u64,
    /// Those of them that were in an object whose mesh is closed.
    pub lost_paths: u64,
    /// Samples that were not finite and count as black.
    pub invalid_samples: u64,
}

impl std::ops::AddAssign for RenderStats {
    fn add_assign(&mut self, more: Self) {
        self.rays += more.rays;
        self.scattering_events += more.scattering_events;
        self.truncated_paths += more.truncated_paths;
        self.leaked_paths += more.leaked_paths;
        self.lost_paths += more.lost_paths;
        self.invalid_samples += more.invalid_samples;
    }
}

/// Why nothing was rendered.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No such model.
    #[error("there is no subsurface model `{name}`; there are: {}", known.join(", "))]
    UnknownModel {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// An empty image.
    #[error("an image of {width}×{height} pixels and {spp} samples is empty")]
    Empty {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Samples a pixel.
        spp: u32,
    },
    /// There is no memory for the picture.
    #[error("there is no memory for {width}×{height} pixels, which take {:.1} GB", *bytes as f64 / 1e9)]
    Memory {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What is needed.
        bytes: u64,
    },
    /// The operating system gave no threads.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why not.
        reason: String,
    },
    /// A film that is to be continued is of another size or has other layers.
    #[error(transparent)]
    Film(#[from] crate::film::MergeError),
}
