//! Physics of the whole path tracer, measured by rendering triangle meshes: numbers nobody here rendered, and
//! invariants. Every statistical statement holds with |z| < 4 for the fixed seed.

mod aiming;
mod area_lights;
mod arrangements;
mod clip;
mod close_lamps;
mod crowds;
mod determinism;
mod directed_models;
mod exit_search;
mod furnace;
mod gltf;
mod half_space;
mod inner_lamps;
mod lab;
mod lens;
mod lights;
mod materials;
mod measured_lights;
mod media;
mod model_media;
mod models;
mod places;
mod searchlight;
mod seen_color;
mod session;
mod slabs;
mod smooth_glass;
mod spheres;
mod stacks;
mod terminator;
mod views;
mod within_places;
