//! Extensions of materials against numbers that are not ours: formulas of their specifications written out once more in
//! double precision, closed forms of optics, and quadrature; rendered, from a glTF material to pixels.
//!
//! `docs/materials.md` lists them.

#[allow(dead_code)]
#[path = "../physics/lab.rs"]
mod lab;

mod drafts;
mod film;
mod formula;
mod scenes;
mod surfaces;
mod transport;
