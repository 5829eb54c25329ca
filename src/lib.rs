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
//! # Load, render, read a pixel
//!
//! ```
//! use nephrite::{asset, scene::Scene, transport};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let file = Path::new("samples/jade-knot/jade-knot.glb");
//! let loaded = asset::load(file, &asset::LoadOptions::default())?;
//! let camera = loaded.scene.cameras.first().cloned().ok_or("the file has no camera")?;
//! let scene = Scene::build(loaded.scene)?;
//! let options = transport::RenderOptions::new(camera).with(|o| {
//!     (o.view.width, o.view.height) = (32, 24);
//!     o.samples.count = 2;
//! });
//! let rendered = transport::render(&scene, &options, &())?;
//! let radiance = rendered.picture.pixels[12 * 32 + 16];
//! assert!(radiance.min_element() >= 0.0 && radiance.is_finite());
//! # Ok(()) }
//! ```
//!
//! # Add samples to a picture, and compare two
//!
//! ```
//! use nephrite::film::compare::Halves;
//! use nephrite::transport::{Plan, RenderOptions, Session};
//! use nephrite::{asset, scene::Scene, subsurface::Registry};
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let file = Path::new("samples/jade-knot/jade-knot.glb");
//! # let loaded = asset::load(file, &asset::LoadOptions::default())?;
//! # let camera = loaded.scene.cameras.first().cloned().ok_or("the file has no camera")?;
//! # let scene = Scene::build(loaded.scene)?;
//! let half = |seed: u32, model: &str| -> Result<_, Box<dyn std::error::Error>> {
//!     let options = RenderOptions::new(camera.clone()).with(|o| {
//!         (o.view.width, o.view.height) = (32, 24);
//!         (o.settings.seed, o.settings.subsurface) = (seed, model.to_owned());
//!     });
//!     let models = Registry::standard();
//!     let mut session = Session::new(&scene, options.view, options.settings, 0, &models)?;
//!     session.pass(&Plan::Everywhere(2), &());
//!     // Later: two more for each pixel.
//!     session.pass(&Plan::Everywhere(2), &());
//!     Ok(session.into_film())
//! };
//! let reference = Halves::new(half(1, "random-walk")?, half(2, "random-walk")?)?;
//! let dipole = Halves::new(half(3, "dipole")?, half(4, "dipole")?)?;
//! let found = dipole.compare(&reference)?;
//! println!("bias {} ± {}", found.bias.value, found.bias.standard_error);
//! # Ok(()) }
//! ```
//!
//! # Give a material a medium
//!
//! ```
//! use nephrite::asset::Limits;
//! use nephrite::author::{AuthoredFile, declare, nephrite as extension, set_extension};
//! use serde_json::json;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let file = AuthoredFile::read(Path::new("samples/jade-knot/jade-knot.glb"), &Limits::default())?;
//! let mut tree = file.tree()?;
//! let materials = tree.root_mut().get_mut("materials").ok_or("the file has no materials")?;
//! let material = materials.item_mut(0).ok_or("the file has no materials")?;
//! let milk = json!({"absorptionCoefficient": [1.1, 2.4, 14.0], "scatteringCoefficient": [2550, 3210, 3770]});
//! set_extension(material, extension::NAME, milk.as_object().ok_or("an object")?);
//! declare(tree.root_mut(), &[extension::NAME]);
//! // All that was not changed keeps its bytes.
//! let bytes = file.with_document(&tree.to_string())?;
//! assert!(bytes.len() > 1000);
//! # Ok(()) }
//! ```
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
