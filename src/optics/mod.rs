//! How light meets surfaces and media: Fresnel's equations, rough boundaries, glTF's surfaces, phase functions, and the
//! coefficients of media.
//!
//! Directions are unit vectors in a local frame whose +z is the normal on the front (outside); they point away from the
//! surface. `wo` is where the path came from, towards the camera; `wi` where it goes on, towards the light; `wo.z` < 0
//! means that the path is inside. Paths carry radiance from the camera, so crossing a boundary scales their weight by
//! (n_o/n_i)² ([`boundary`]). Random numbers are passed in. Nothing here knows scenes.

pub mod albedo;
mod anisotropic;
mod base;
pub mod boundary;
mod boundary_losses;
pub mod boundary_tables;
pub mod bsdf;
mod coat;
pub mod diffusion;
mod exit_lobe;
mod facet_reflection;
mod facet_tables;
pub mod fresnel;
#[cfg(test)]
mod furnace_tests;
mod fuzz;
pub mod ggx;
mod layered;
mod lobe;
mod loss;
pub mod medium;
pub mod metallic_roughness;
#[cfg(test)]
mod microsurface_walk;
pub mod phase;
pub mod presets;
mod reflectance;
mod reflection_tables;
mod rough_diffuse;
pub mod seen_color;
pub mod seen_color_table;
mod sheen;
pub mod spectrum;
mod stack;
mod substrate;
#[cfg(test)]
mod test_support;
mod thin_film;
mod top;
mod treated;
mod warp;

pub use anisotropic::Facets;
pub use base::Base;
pub use boundary::{DielectricBoundary, Microfacet};
pub use boundary_tables::BoundaryTables;
pub use bsdf::{Bsdf, Mixed};
pub use coat::{Coat, CoatParameters, crossing};
pub use exit_lobe::{DiffuseExit, ExitLobe};
pub use fuzz::Fuzz;
use glam::Vec3;
pub use layered::Layered;
pub use medium::Medium;
pub use metallic_roughness::{Surface, SurfaceParameters};
pub use phase::HenyeyGreenstein;
pub use sheen::Sheen;
pub use stack::Stack;
pub use substrate::{Substrate, SubstrateParameters};
pub use thin_film::ThinFilm;
pub use treated::TreatedBoundary;

/// A direction drawn from a BSDF, in the local frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit direction, pointing away from the surface.
    pub wi: Vec3,
    /// f·|cos θ_i| / pdf, for radiance carried from the camera.
    pub weight: Vec3,
    /// Density per steradian; for a delta, the probability of its choice.
    pub pdf: f32,
    /// Whether the direction is one of finitely many.
    pub delta: bool,
    /// Whether `wi` is on the other side of the surface than `wo`.
    pub transmitted: bool,
}
