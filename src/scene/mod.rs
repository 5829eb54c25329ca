//! The immutable scene: what the tracer sees once a file has been read.
//!
//! [`description`] is plain data, the contract between the loader and the tracer; [`texture`] evaluates images.

pub mod description;
pub mod texture;

pub use description::*;
