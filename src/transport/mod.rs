//! The path tracer: next-event estimation, multiple importance sampling, media.
//!
//! [`render()`] shares the pixels among threads; [`path`](self) follows one path; [`media`](self) keeps the stack of
//! objects around it; [`direct`](self) connects vertices to lights. A picture is a function of (scene, options, seed):
//! every pixel sums its samples in order, whatever the number of threads.

mod chance;
mod control;
mod direct;
mod dispersion;
mod emerge;
mod gathered;
mod ground;
mod interface;
mod leave;
mod media;
mod meet;
mod options;
mod path;
mod pixel;
mod place;
mod render;
pub mod searchlight;
mod session;
mod shading_normal;
mod shadow;
mod shutter;
mod split;
mod state;
mod surroundings;
mod terminator;
mod threads;
mod weight;

pub use control::{RenderControl, RenderError, RenderStats};
pub use gathered::{FirstEvent, LightLayer, LightSource, LightTag};
pub use media::{Enclosure, MediumStack};
pub use options::{RenderOptions, SampleRange, Settings, View};
pub use render::{Rendered, render, render_with};
pub use session::{Plan, Session};
pub use shutter::{Shutter, Slice, render_shutter};
