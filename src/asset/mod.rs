//! Files to scenes: reads glTF 2.0 (`.gltf`, `.glb`) into a [`SceneDescription`].
//!
//! The file is taken for a serde tree and read through checked cursors ([`Json`]), since files in the wild break the
//! schema in every possible way, and since complaints should say where. Every extension is a plug-in of
//! [`crate::extension`]. Nothing that a file says can make the loader panic, recurse, read outside the file's folder,
//! or allocate before it has checked a size against the data or the [`Limits`].
//!
//! ```no_run
//! use nephrite::asset::{LoadOptions, load};
//!
//! let loaded = load("model.glb".as_ref(), &LoadOptions::default())?;
//! for diagnostic in &loaded.diagnostics {
//!     eprintln!("{diagnostic}");
//! }
//! println!("{} objects", loaded.scene.instances.len());
//! # Ok::<(), nephrite::asset::AssetError>(())
//! ```

mod accessor;
mod animation;
mod buffer;
mod camera;
pub(crate) mod container;
pub mod environment;
mod error;
mod extensions;
mod fans;
mod image;
mod input;
mod json;
mod limits;
mod lm63;
mod loader;
mod manifold;
mod marks;
mod material;
mod mesh;
mod morph;
mod node;
mod opened;
pub(crate) mod painting;
mod place;
mod pose;
mod primitive;
mod rebase;
mod skin;
mod spelling;
mod summary;
mod tangent;
mod texture;
mod topology;
pub(crate) mod uri;

use std::path::Path;

pub(crate) use crate::guard::guarded;
pub use accessor::{Accessor, Component};
pub use animation::{AnimationSummary, Moment, MutableProperty, PropertyKind};
pub use buffer::Bytes;
pub use error::{AssetError, Diagnostic, Severity};
pub(crate) use input::documents_in;
pub use json::Json;
pub use limits::Limits;
pub use lm63::{Lm63, Lm63Error};
pub use loader::Loader;
pub use manifold::MergedVertices;
pub(crate) use mesh::FARTHEST;
pub use node::{NodeContext, light_frame};
pub use opened::Asset;
pub use primitive::DecodedPrimitive;
pub use summary::*;
pub use texture::ImageSource;
pub use topology::Topology;

use crate::extension::Registry;
use crate::scene::SceneDescription;

/// How to load a file.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Index of the scene to show; by default the file's own choice, else its first.
    pub scene: Option<usize>,
    /// Name or index of the variant of KHR_materials_variants to show; by default what each primitive itself says.
    pub variant: Option<String>,
    /// Whether violations of the format that could be lived with are errors.
    pub strict: bool,
    /// How much a file may ask for.
    pub limits: Limits,
    /// Whether URIs may name files outside the folder of the document.
    pub allow_outside: bool,
    /// The extensions that are understood.
    pub registry: Registry,
    /// Name or index of the camera that is looked through; by default the first. Where it and what it sees are far from
    /// the origin of the file, positions are counted from there ([`SceneDescription::origin`]).
    pub camera: Option<String>,
    /// `SceneDescription::weld_tolerance`.
    pub weld_tolerance: Option<f32>,
}

/// A file that was loaded.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What it shows.
    pub scene: SceneDescription,
    /// What is worth telling about it, most serious first.
    pub diagnostics: Vec<Diagnostic>,
    /// What is in the file.
    pub summary: Summary,
}

/// Loads a `.gltf` or `.glb` file as it is at rest; which of them it is, its first bytes tell. Of a folder, the only such
/// file in it is loaded, or the `.glb` of two that differ only in that. [`Asset`] has the moments of its animations.
///
/// # Errors
/// Where the file cannot be read, is not glTF 2.0, refers to what is not there, requires an extension that is not in
/// the registry, or asks for more than the limits.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, AssetError> {
    Asset::open(path, options)?.load(&Moment::default())
}

/// Loads the bytes of a `.gltf` or `.glb` file whose relative URIs are below `folder`.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(bytes: Vec<u8>, folder: &Path, options: &LoadOptions) -> Result<Loaded, AssetError> {
    Asset::from_bytes(bytes, folder, options)?.load(&Moment::default())
}

/// Loads a `.gltf` or `.glb` file from a stream, such as standard input. It has no folder, so it cannot name files.
///
/// # Errors
/// As [`load`], and where it names a file by a relative URI.
pub fn load_stream(stream: impl std::io::Read, options: &LoadOptions) -> Result<Loaded, AssetError> {
    Asset::from_stream(stream, options)?.load(&Moment::default())
}

impl<'a> Loader<'a> {
    /// Only glTF 2 is read (§3.2): any 2.x, unless it says that it needs more.
    fn version(&mut self) -> Result<(), AssetError> {
        let Some(asset) = self.root().object("asset")? else {
            return Err(AssetError::invalid("/asset", "is missing, so this is no glTF 2.0 file"));
        };
        let major = |v: &str| v.split('.').next().and_then(|v| v.parse::<u32>().ok());
        let version = match asset.get("version") {
            Some(v) if v.value().is_number() => {
                self.invalid(v.pointer(), "should be a string")?;
                v.value().to_string()
            }
            Some(v) => v.as_str()?.to_owned(),
            None => return Err(asset.error_at("version", "is missing, so this is no glTF 2.0 file")),
        };
        let least = asset.str("minVersion")?;
        if major(&version) != Some(2) || least.is_some_and(|v| major(v) != Some(2)) {
            let version = error::shorten(least.unwrap_or(&version));
            let message = format!("glTF {version} is not supported");
            return Err(asset.error_at("version", message).with_advice("convert the asset to glTF 2.0"));
        }
        if let Some(least) = least.filter(|v| *v != "2.0") {
            self.warn(
                &asset.pointer_to("minVersion"),
                format!("glTF {} is newer", error::shorten(least)),
                None,
            );
        }
        Ok(())
    }

    /// Reads everything but the pixels.
    fn read(&mut self) -> Result<(), AssetError> {
        let scene = self.chosen_scene()?;
        let places = [Some(self.root()), scene.clone()];
        for place in places.into_iter().flatten().filter(|p| p.get("extensions").is_some()) {
            for extension in self.options.registry.iter() {
                if let Some(own) = place.extension(extension.name()) {
                    extension.document(self, &own)?;
                }
            }
        }
        if let Some(wanted) = self.options.variant.as_ref().filter(|_| self.chosen_variant.is_none()) {
            let message = format!("there is no variant {wanted:?}: the file has no KHR_materials_variants");
            return Err(AssetError::invalid("/extensions", message));
        }
        self.materials()?;
        let roots = match &scene {
            Some(scene) => {
                let roots = scene.array("nodes")?.into_iter();
                roots
                    .map(|n| Ok((n.as_usize()?, n.pointer().to_owned())))
                    .collect::<Result<Vec<_>, AssetError>>()?
            }
            None => self.all_roots()?,
        };
        // Materials name all images: the first of them are decoded while meshes are read.
        let files = self.images_to_decode()?;
        let options = self.options;
        let (decoded, read) = rayon::join(|| files.decode(options), || self.nodes(roots));
        read.and_then(|()| self.keep_images(decoded))
    }

    /// The scene to show: the option, else the file's default, else its first; `None` where it has no scenes.
    fn chosen_scene(&mut self) -> Result<Option<Json<'a>>, AssetError> {
        let root = self.root();
        let count = self.count("scenes");
        if let Some(index) = self.options.scene {
            return match root.get("scenes").and_then(|list| list.item(index)) {
                Some(scene) => Ok(Some(scene)),
                None => {
                    Err(AssetError::invalid("/scenes", format!("there is no scene {index}, only {count}")))
                }
            };
        }
        if let Some(index) = root.usize("scene")? {
            return self.entry("scenes", index, "/scene").map(Some);
        }
        if count == 0 {
            return Ok(None);
        }
        if count > 1 {
            let message = "the file names no default scene; the first of several is shown";
            self.note("/scenes", message);
        }
        self.entry("scenes", 0, "/scenes").map(Some)
    }

    /// All nodes that are not below others.
    fn all_roots(&mut self) -> Result<Vec<(usize, String)>, AssetError> {
        let count = self.count("nodes");
        if count > 0 {
            self.warn("/scenes", "the file has no scenes; all its nodes are shown", None);
        }
        let mut is_child = vec![false; count];
        for index in 0..count {
            for child in self.entry("nodes", index, "/nodes")?.array("children")? {
                if let Some(seen) = is_child.get_mut(child.as_usize()?) {
                    *seen = true;
                }
            }
        }
        Ok((0..count).filter(|&i| !is_child[i]).map(|i| (i, format!("/nodes/{i}"))).collect())
    }

    /// What is worth telling once everything has been read.
    fn afterthoughts(&mut self, played: bool) -> Result<(), AssetError> {
        if self.scene.instances.is_empty() {
            self.warn("", "there is nothing to see in the scene", None);
        }
        let collapsed = self.totals.collapsed;
        if collapsed > 0 {
            let triangles = crate::plural::count(collapsed, "triangle", "triangles");
            let are = if collapsed == 1 { "is" } else { "are" };
            self.note("/meshes", format!("{triangles} with two corners at one place {are} left out"));
        }
        let loader::Totals { repeated_primitives, repeated_objects, .. } = self.totals;
        if repeated_primitives > 0 {
            let message = match repeated_primitives {
                1 => "1 primitive is left out: it repeats another one of its mesh".to_owned(),
                n => format!("{n} primitives are left out: each repeats another one of its mesh"),
            };
            self.warn("/meshes", message, None);
        }
        if repeated_objects > 0 {
            let message = match repeated_objects {
                1 => "1 object is left out: it is in the very place of another one of its mesh".to_owned(),
                n => {
                    format!("{n} objects are left out: each is in the very place of another one of its mesh")
                }
            };
            self.warn("/nodes", message, None);
        }
        if self.count("animations") > 0 && !played {
            self.note("/animations", "animations are not played; the scene is shown as it is at rest");
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests;
