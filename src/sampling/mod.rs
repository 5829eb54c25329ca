//! Random and low-discrepancy numbers, discrete and image distributions, and warps from the unit square.
//!
//! Every function takes its uniform numbers as arguments; [`Sampler`] and [`SmallRng`] are the two places where
//! they come from. Uniform numbers lie in \[0, 1), never 1.

pub mod arctangent;
pub mod close_triangle;
pub mod distribution;
pub mod exponential;
pub mod fast_math;
pub mod frame;
pub mod lanes;
pub mod mis;
pub mod rng;
pub mod sampler;
pub mod spherical_triangle;
#[cfg(test)]
pub(crate) mod statistics;
pub mod warp;

pub use arctangent::atan2;
pub use close_triangle::CloseTriangle;
pub use distribution::{Cell, Distribution1D, Distribution2D};
pub use frame::{Frame, orthonormal_basis};
pub use mis::{balance_heuristic, power_heuristic};
pub use rng::SmallRng;
pub use sampler::Sampler;
pub use spherical_triangle::SphericalTriangle;

/// The largest `f32` below one: what a remapped uniform number is clamped to.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;
