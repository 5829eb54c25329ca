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

/// Bytes that a texel of an environment takes: radiance as it was read and with its scale, and its place in the tables.
pub(crate) const ENVIRONMENT_TEXEL_BYTES: u64 = 2 * size_of::<glam::Vec3>() as u64 + 8;

/// Bytes that an emissive triangle of an instance takes, with its parts of the trees.
pub(crate) const EMITTER_BYTES: u64 =
    (size_of::<EmissiveTriangle>() + size_of::<emitter::Emitter>() + size_of::<tree::Node>() + 8) as u64
        + nearest::LAMP_BYTES;

/// Bytes that a light without size takes, with its parts of the trees.
pub(crate) const PUNCTUAL_BYTES: u64 =
    (size_of::<crate::scene::PunctualLight>() + size_of::<tree::Node>() + 8) as u64 + nearest::LAMP_BYTES;
