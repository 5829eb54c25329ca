//! Light from environments, emissive triangles and punctual lights, and choosing among them.

pub mod beacon;
pub mod emitter;
pub mod environment;
mod irradiance;
pub mod lights;
mod mixture;
mod nearest;
pub mod punctual;
pub mod studio;

pub use emitter::{EmissionField, EmissiveRadiance, EmissiveTriangle, EmitterId};
pub use environment::Environment;
pub use lights::{Anchor, LightSample, Lights};
