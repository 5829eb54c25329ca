//! Light from environments, emissive triangles and punctual lights, and choosing among them.

pub mod beacon;
mod blocks;
mod cone;
pub mod emitter;
pub mod environment;
pub mod environment_map;
mod irradiance;
pub mod lights;
mod many;
mod mixture;
mod nearest;
mod point;
pub mod punctual;
pub mod studio;
mod tree;
mod tree_build;

pub use emitter::{EmissionField, EmissiveRadiance, EmissiveTriangle, EmitterId};
pub use environment::{Environment, Facing};
pub use lights::{Anchor, LightSample, Lights};
pub use point::LightPoint;
