//! Media in full view: reflection is chosen by what it is worth, and more than one walk follows a refraction where walks are
//! short.
//!
//! Chosen by energy alone, the highlights of a dark medium are found as rarely as its boundary reflects. And where a
//! walk has few events, the rest of a sample costs more than the walk: several walks a sample are cheaper than as many
//! samples.

use super::gathered::Gathered;
use super::media::Enclosure;
use super::path::PathTracer;
use super::state::Path;
use crate::optics::Bsdf;
use crate::sampling::Sampler;

impl PathTracer<'_> {
    /// Tells the boundary of an object, met from outside, what lies below is worth.
    pub(super) fn weigh_below(&self, bsdf: &mut Bsdf, e: Enclosure) {
        if let Bsdf::Boundary(boundary) = bsdf
            && let Some(returned) = self.scene.objects[e.instance as usize].returned
        {
            *boundary = boundary.with_worth_below(returned);
        }
    }

    /// Walks to follow for a path that has just crossed a boundary.
    pub(super) fn walks(&self, path: &Path) -> u32 {
        let inside = path.stack.current().filter(|_| path.bounces == 1);
        inside.map_or(1, |e| self.scene.objects[e.instance as usize].walks)
    }

    /// Follows a path to its ends that many times.
    pub(super) fn follow_each(
        &self,
        path: &Path,
        walks: u32,
        gathered: &mut Gathered<'_>,
        sampler: &mut Sampler,
    ) {
        let mut found = gathered.anew();
        for _ in 0..walks {
            self.follow(&mut path.clone(), &mut found, sampler);
        }
        gathered.add_share(&found, walks as f32);
    }
}
