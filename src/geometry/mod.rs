//! Meshes, ray queries, closed-mesh analysis and distance bounds.
//!
//! [`SceneGeometry`] holds instances of [`MeshGeometry`]; both answer closest-hit, any-hit and all-hits queries through
//! an eight-wide hierarchy whose topology `obvhs` builds. Three promises hold for every query:
//!
//! - *Watertight*: no ray passes between triangles that share an edge or a vertex (`triangle_block`, `traversal`).
//! - *Scale free*: no absolute epsilon; coordinates of 10⁻⁶ and 10⁶ are treated alike, up to 10¹⁸.
//! - *Deterministic*: the same input gives the same bits, whatever the number of threads.
//!
//! A ray leaves a surface from [`offset_origin`], with the error bounds that come with each surface point.
//! [`Topology`] says whether a mesh is closed and which triangles face the wrong way; [`DistanceBound`] says how far a
//! walk inside can go without asking.

mod clustering;
mod collapse;
mod containment;
mod distance;
mod edges;
mod huge_pages;
mod lanes;
mod layout;
mod lines;
mod mesh;
mod nearest;
mod nesting;
mod offset;
mod oriented_sets;
mod overlap;
mod place;
mod ray;
mod scene;
#[cfg(test)]
mod scene_tests;
#[cfg(test)]
mod shapes;
mod similarity;
#[cfg(test)]
mod tests;
mod topology;
#[cfg(test)]
mod topology_tests;
mod traversal;
mod triangle_block;
mod wedges;
mod weld;
mod wide_bvh;

pub use distance::DistanceBound;
pub use mesh::MeshGeometry;
pub use offset::{ROUNDING, gamma, offset_origin};
pub use overlap::BoxTree;
pub use place::TOUCHING;
pub use ray::{Aabb, MeshHit, NearestPoint, Ray};
pub use scene::{GeometryError, Hit, SceneGeometry, SurfacePoint};
pub use similarity::Similarity;
pub use topology::{Component, NO_COMPONENT, Topology};
pub use weld::close_seams;
