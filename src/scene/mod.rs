//! The immutable scene: what the tracer sees once a file has been read.
//!
//! [`description`] is plain data, the contract between the loader and the tracer. [`Scene::build`] compiles it:
//! acceleration structures, lights, and for every object with a medium what transport wants to know (is it closed,
//! does it contain anything else, which of two overlapping objects wins).

mod area_light;
pub(crate) mod bounds;
mod camera;
mod compile;
pub mod description;
mod emission;
mod footprint;
mod ground;
mod image;
mod intruders;
mod layering;
pub mod layers;
mod lens;
mod material;
mod mesh_facts;
mod needs;
mod object;
mod pyramid;
mod seams;
mod surface;
pub mod texture;
mod web;

pub use area_light::{AreaLight, AreaShape};
pub use camera::{Camera, auto_camera};
pub(crate) use compile::raise as raise_limit;
pub use compile::{Scene, SceneError};
pub use description::*;
pub use footprint::Footprint;
pub use intruders::{Intruder, Intruders};
pub use layers::Layers;
pub use lens::Lens;
pub use material::Shading;
pub use needs::DerivedLimits;
pub use object::{NEARLY_SMOOTH, Object};
pub use pyramid::Pyramid;
pub use seams::Analysed;
pub use surface::Surface;
pub use web::{PhotometricWeb, Photometry, TurnedWeb, WebError};
