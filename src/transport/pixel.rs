//! What one camera path found.

use crate::film::composite::Caught;
use glam::Vec3;

/// What one camera path found.
#[derive(Clone, Debug)]
pub(super) struct PixelSample {
    pub radiance: Vec3,
    /// Its parts on the layers that hold them.
    pub parts: Vec<Vec3>,
    /// How much of the background is hidden, by objects.
    pub covered: f32,
    /// The ground.
    pub caught: Option<Caught>,
}
