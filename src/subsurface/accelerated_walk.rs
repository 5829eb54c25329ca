//! `accelerated-walk`: the random walk, which jumps across spheres where it is deep inside of an object
//! ([`super::sphere_jumps`]). Nearly the truth, sooner: `docs/models.md` has its bias.

use super::random_walk;
use super::{Propagator, SubsurfaceModel};
use crate::scene::Scene;

/// The random walk with jumps.
pub struct AcceleratedWalk;

impl SubsurfaceModel for AcceleratedWalk {
    fn name(&self) -> &str {
        "accelerated-walk"
    }

    fn summary(&self) -> &str {
        "the random walk, with jumps across spheres deep inside: nearly the truth, sooner in thick dense media"
    }

    fn prepare(&self, scene: &Scene) -> Box<dyn Propagator> {
        random_walk::prepare(scene, true)
    }
}
