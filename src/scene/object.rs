//! What transport wants to know of a placed mesh that holds a medium.

use crate::geometry::DistanceBound;
use std::sync::Arc;

/// An instance, as the tracer sees it.
#[derive(Clone, Debug, Default)]
pub struct Object {
    /// Whether any of its triangles bounds a medium.
    pub has_medium: bool,
    /// Whether its mesh is closed, every component of it.
    pub closed: bool,
    /// Place in the total order by (priority, smaller volume, index); the highest rank around a point fills it.
    pub rank: u32,
    /// Provably contains nothing else: no foreign triangle reaches into its bounds, so a walk inside needs only its
    /// own mesh.
    pub isolated: bool,
    /// Light sources may be inside, so paths in the medium must be connected to them.
    pub lit_inside: bool,
    /// Light beyond the boundary can be aimed at from inside: there are beacons, and nothing is in the way that light
    /// passes without being bent (alpha, other media).
    pub aimable: bool,
    /// Lower bounds of the distance to the boundary, in the instance's local space; for closed isolated media.
    pub distance: Option<Arc<DistanceBound>>,
}
