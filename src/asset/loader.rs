//! An asset while it is being read: the document, its caches, and everything worth telling.
//!
//! The reading itself is spread over the files of this room, each an `impl` of [`Loader`] with one idea. Extensions
//! get a `&mut Loader` and use the same checked readers.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use serde_json::Value;

use super::LoadOptions;
use super::buffer::Bytes;
use super::error::{AssetError, Diagnostic, Severity};
use super::json::Json;
use super::opened::Cache;
use super::rebase::Exact;
use super::texture::ImageSource;
use crate::plural::count;
use crate::scene::{PhotometricWeb, SceneDescription};

/// Diagnostics beyond this many are counted, not kept.
const MOST_DIAGNOSTICS: usize = 500;

/// Longer lists of factors are not read to the end.
const MOST_FACTORS: usize = 17;

/// Index of a mesh of the file, bits of the weights of its morph targets, and index of the node that skins it.
type MeshKey = (usize, (Vec<u32>, Option<usize>));

/// An asset while it is being read.
pub struct Loader<'a> {
    pub(crate) document: &'a Value,
    pub(crate) options: &'a LoadOptions,
    pub(crate) folder: Option<&'a Path>,
    pub(crate) bin: Option<Bytes>,
    pub(crate) cache: Cache,
    pub(crate) textures: HashMap<usize, Option<usize>>,
    pub(crate) images: HashMap<ImageSource, usize>,
    /// The first image in use of each buffer view and URI.
    pub(crate) image_files: HashMap<(Option<usize>, Option<&'a str>), usize>,
    pub(crate) image_sources: Vec<ImageSource>,
    /// So many of the scene's images have been decoded, or found not to be usable.
    pub(crate) decoded_images: usize,
    pub(crate) usable_images: HashSet<usize>,
    pub(crate) meshes: HashMap<MeshKey, Option<usize>>,
    pub(crate) skins: HashMap<usize, Option<Arc<[DMat4]>>>,
    pub(crate) worlds: Vec<Option<glam::DAffine3>>,
    pub(crate) parents: Option<Vec<Option<usize>>>,
    pub(crate) declared: HashSet<String>,
    pub(crate) bounds: HashMap<usize, [glam::Vec3; 2]>,
    /// What has been subtracted from the positions of meshes of the scene, where it is not zero.
    pub(crate) centers: HashMap<usize, DVec3>,
    pub(crate) exact: Exact,
    pub(crate) totals: Totals,
    /// The variant of KHR_materials_variants that is shown, if one was chosen.
    pub(crate) chosen_variant: Option<usize>,
    /// The scene as far as it has been read.
    pub scene: SceneDescription,
    diagnostics: Vec<Diagnostic>,
    told: HashSet<(String, String)>,
    untold: usize,
}

/// What has been spent of the limits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Totals {
    pub vertices: u64,
    pub triangles: u64,
    pub image_bytes: u64,
    pub file_bytes: u64,
    pub pose_elements: u64,
    pub collapsed: usize,
    pub repeated_primitives: usize,
    pub repeated_objects: usize,
}

impl<'a> Loader<'a> {
    pub(crate) fn new(document: &'a Value, options: &'a LoadOptions, folder: Option<&'a Path>) -> Self {
        Self {
            document,
            options,
            folder,
            bin: None,
            cache: Cache::default(),
            textures: HashMap::new(),
            images: HashMap::new(),
            image_files: HashMap::new(),
            image_sources: Vec::new(),
            decoded_images: 0,
            usable_images: HashSet::new(),
            meshes: HashMap::new(),
            skins: HashMap::new(),
            worlds: Vec::new(),
            parents: None,
            declared: HashSet::new(),
            bounds: HashMap::new(),
            centers: HashMap::new(),
            exact: Exact::default(),
            totals: Totals::default(),
            chosen_variant: None,
            scene: SceneDescription::default(),
            diagnostics: Vec::new(),
            told: HashSet::new(),
            untold: 0,
        }
    }

    /// Goes on where another one stopped that has not begun to read the scene.
    pub(crate) fn continuing(self, other: Loader<'_>) -> Self {
        let Loader { bin, cache, declared, totals, diagnostics, told, untold, .. } = other;
        Self { bin, cache, declared, totals, diagnostics, told, untold, ..self }
    }

    /// The document.
    pub fn root(&self) -> Json<'a> {
        Json::root(self.document)
    }

    /// The options of this load.
    pub fn options(&self) -> &'a LoadOptions {
        self.options
    }

    /// Whether the file says that it cannot be read without an extension.
    pub fn requires(&self, extension: &str) -> bool {
        let required = self.document.get("extensionsRequired").and_then(Value::as_array);
        required.is_some_and(|list| list.iter().any(|name| name == extension))
    }

    /// Number of entries of a top-level array such as `meshes`; 0 where it is absent.
    pub fn count(&self, array: &str) -> usize {
        self.document.get(array).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// Entry `index` of a top-level array, which must be an object; `from` is the place that refers to it.
    ///
    /// # Errors
    /// Where there is no such entry, or it is not an object.
    pub fn entry(&self, array: &str, index: usize, from: &str) -> Result<Json<'a>, AssetError> {
        let count = self.count(array);
        let entry = self.root().get(array).and_then(|list| list.item(index));
        let entry = entry.ok_or_else(|| {
            AssetError::invalid(from, format!("refers to {array}/{index}, but the file has {count} {array}"))
        })?;
        entry.as_object()?;
        Ok(entry)
    }

    fn tell(&mut self, severity: Severity, pointer: &str, message: String, advice: Option<&str>) {
        if self.diagnostics.len() >= MOST_DIAGNOSTICS {
            self.untold += 1;
        } else if self.told.insert((pointer.to_owned(), message.clone())) {
            let advice = advice.map(str::to_owned);
            self.diagnostics.push(Diagnostic { severity, pointer: pointer.to_owned(), message, advice });
        }
    }

    /// Tells of something that is right, but not used.
    pub fn note(&mut self, pointer: &str, message: impl Into<String>) {
        self.tell(Severity::Note, pointer, message.into(), None);
    }

    /// Tells of something doubtful.
    pub fn warn(&mut self, pointer: &str, message: impl Into<String>, advice: Option<&str>) {
        self.tell(Severity::Warning, pointer, message.into(), advice);
    }

    /// Tells of something that the file's format forbids, but that can be lived with: a warning, or an error when
    /// the load is strict.
    ///
    /// # Errors
    /// Where the load is strict.
    pub fn invalid(&mut self, pointer: &str, message: impl Into<String>) -> Result<(), AssetError> {
        let message = message.into();
        if self.options.strict {
            return Err(AssetError::Strict(Diagnostic {
                severity: Severity::Error,
                pointer: pointer.to_owned(),
                message,
                advice: None,
            }));
        }
        self.tell(Severity::Warning, pointer, message, None);
        Ok(())
    }

    /// Property `key` as a number that should lie in `range`: one that does not is [`invalid`](Self::invalid) and
    /// is brought to the nearest end.
    ///
    /// # Errors
    /// Where it is not a number, or out of range in a strict load.
    pub fn factor(
        &mut self,
        json: &Json<'_>,
        key: &str,
        default: f32,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f32, AssetError> {
        let Some(value) = json.f64(key)? else { return Ok(default) };
        let (low, high) = (*range.start(), *range.end());
        if !range.contains(&value) {
            self.invalid(&json.pointer_to(key), outside(value, low, high))?;
        }
        Ok(value.clamp(low, high) as f32)
    }

    /// Property `key` as `N` numbers, each as [`factor`](Self::factor) has it. Another count of numbers is
    /// [`invalid`](Self::invalid); missing ones are those of `default`.
    ///
    /// # Errors
    /// Where they are not numbers, or out of range or not `N` in a strict load.
    pub fn factors<const N: usize>(
        &mut self,
        json: &Json<'_>,
        key: &str,
        default: [f32; N],
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<[f32; N], AssetError> {
        let Some(array) = json.get(key) else { return Ok(default) };
        let given = array.items()?.take(MOST_FACTORS).map(|n| n.as_f64()).collect::<Result<Vec<f64>, _>>()?;
        if given.len() != N {
            self.invalid(
                array.pointer(),
                format!("{} where {N} are expected", count(given.len(), "number", "numbers")),
            )?;
        }
        let mut values = default.map(f64::from);
        for (value, given) in values.iter_mut().zip(given) {
            *value = given;
        }
        let (low, high) = (*range.start(), *range.end());
        for (i, value) in values.iter().enumerate() {
            if !range.contains(value) {
                self.invalid(&format!("{}/{i}", json.pointer_to(key)), outside(*value, low, high))?;
            }
        }
        Ok(values.map(|v| v.clamp(low, high) as f32))
    }

    /// Checks a running total against a limit.
    pub(crate) fn within(
        needed: u64,
        limit: u64,
        pointer: &str,
        what: &str,
        field: &'static str,
    ) -> Result<(), AssetError> {
        if needed <= limit {
            return Ok(());
        }
        Err(AssetError::Limit { pointer: pointer.to_owned(), what: what.to_owned(), needed, limit, field })
    }

    /// Adds bytes that are held in memory, read or decompressed, within the limit of files.
    ///
    /// # Errors
    /// Where there are more than the limits allow.
    pub fn spend_bytes(&mut self, bytes: u64, pointer: &str, what: &str) -> Result<(), AssetError> {
        self.totals.file_bytes = self.totals.file_bytes.saturating_add(bytes);
        Self::within(self.totals.file_bytes, self.options.limits.file_bytes, pointer, what, "file_bytes")
    }

    /// A light profile that has been read.
    pub(crate) fn web(&self, index: usize) -> Option<Arc<PhotometricWeb>> {
        self.cache.webs.get(&index).cloned()
    }

    /// Keeps a light profile for other nodes and moments.
    pub(crate) fn keep_web(&mut self, index: usize, web: PhotometricWeb) -> Arc<PhotometricWeb> {
        Arc::clone(self.cache.webs.entry(index).or_insert_with(|| Arc::new(web)))
    }

    /// How many more vertices and triangles the limits allow.
    pub fn room(&self) -> (u64, u64) {
        let (limits, spent) = (&self.options.limits, &self.totals);
        (limits.vertices.saturating_sub(spent.vertices), limits.triangles.saturating_sub(spent.triangles))
    }

    /// Adds to the number of vertices and triangles of the scene, within the limits.
    pub(crate) fn spend(
        &mut self,
        vertices: usize,
        triangles: usize,
        pointer: &str,
    ) -> Result<(), AssetError> {
        let limits = &self.options.limits;
        self.totals.vertices += vertices as u64;
        self.totals.triangles += triangles as u64;
        let Totals { vertices, triangles, .. } = self.totals;
        Self::within(vertices, limits.vertices, pointer, "all meshes so far, in vertices,", "vertices")?;
        Self::within(triangles, limits.triangles, pointer, "all meshes so far, in triangles,", "triangles")
    }

    /// The scene and everything that was told, most serious first, otherwise in order of appearance.
    pub(crate) fn finish(mut self) -> (SceneDescription, Vec<Diagnostic>) {
        if self.untold > 0 {
            self.diagnostics.push(Diagnostic {
                severity: Severity::Note,
                pointer: String::new(),
                message: format!("{} more messages are not shown", self.untold),
                advice: None,
            });
        }
        self.diagnostics.sort_by_key(|d| std::cmp::Reverse(d.severity));
        (self.scene, self.diagnostics)
    }
}

/// Says on which side of a range a value is.
fn outside(value: f64, low: f64, high: f64) -> String {
    const PLAIN: f64 = 1e6;
    let show = |x: f64| if x.abs() < PLAIN { format!("{x}") } else { format!("{x:e}") };
    if value < low {
        format!("{} is below {}", show(value), show(low))
    } else {
        format!("{} is above {}", show(value), show(high))
    }
}
