//! TODO

pub mod studio;
