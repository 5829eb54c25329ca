//! nephrite: a path tracer for glTF 2.0, made for light that travels below surfaces.
//!
//! Data flows one way through the rooms of this crate:
//!
//! ```text
//! .gltf/.glb ──asset──▶ Scene ──transport──▶ Film ──film──▶ Picture ──▶ .exr .png
//!               ▲ extension     ▲ subsurface
//!                               │ light, optics, geometry, sampling
//! ```
//!
//! [`author`] changes the media of a file and nothing else of it; [`conformance`] holds pictures against what is known
//! of them. [`asset`] and [`extension`] turn files into a [`scene::SceneDescription`] and never trace a ray;
//! [`transport`], [`subsurface`], [`optics`] and [`geometry`] never see glTF. Two seams take plug-ins:
//! [`extension::Extension`] (one file a glTF extension) and [`subsurface::SubsurfaceModel`] (one file a model).
//!
//! Units: metres, radians, radiance in W/(m² sr) up to a common scale, coefficients in 1/m, colour in linear
//! Rec. 709. Directions in shading point away from the surface. `eta` is inside over outside.

pub mod asset;
pub mod author;
pub mod cli;
pub mod conformance;
pub mod extension;
pub mod film;
pub mod geometry;
mod guard;
pub mod light;
pub mod optics;
mod plural;
mod room;
pub mod sampling;
pub mod scene;
pub mod subsurface;
pub mod transport;
