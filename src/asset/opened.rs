//! An asset that has been opened and can be read at any number of moments: the document is parsed, files are read and
//! images decoded once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use serde_json::Value;

use super::animation::{Moment, apply};
use super::error::shorten;
use super::loader::Loader;
use super::{Accessor, AssetError, Bytes, ImageSource, LoadOptions, Loaded, Summary, container, input, uri};
use crate::scene::{ImageData, PhotometricWeb};

/// A `.gltf` or `.glb` file that can be read at several moments of its animations.
#[derive(Debug)]
pub struct Asset {
    document: Value,
    duplicates: Vec<String>,
    nulls: (Vec<String>, u64),
    oddities: Vec<String>,
    bin: Option<Bytes>,
    /// The file that holds the document; `None` for bytes and streams.
    path: Option<PathBuf>,
    /// None for a stream.
    folder: Option<PathBuf>,
    file_bytes: u64,
    options: LoadOptions,
    cache: Cache,
}

/// What does not change with the moment.
#[derive(Debug, Default)]
pub(crate) struct Cache {
    pub buffers: HashMap<usize, Bytes>,
    pub views: HashMap<usize, Bytes>,
    /// Decoded images, by where they are in the file.
    pub images: HashMap<ImageSource, Arc<ImageData>>,
    /// Light profiles of EXT_lights_ies, by index in the file.
    pub webs: HashMap<usize, Arc<PhotometricWeb>>,
    /// Accessors of keyframes, by index in the file.
    pub keyframes: HashMap<usize, Arc<Accessor>>,
    /// First and last time of keyframes, or what is wrong with them, by the pointer of their accessor.
    pub times: HashMap<String, Result<[f32; 2], String>>,
    /// The origin of the scene at the first moment that was read, which holds for all.
    pub origin: Option<DVec3>,
}

impl Asset {
    /// Opens a file; which kind it is, its first bytes tell. Of a folder, the only such file in it is opened, or the
    /// `.glb` of two that differ only in that.
    ///
    /// # Errors
    /// Where the file cannot be read, or is not JSON in a sound container.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, AssetError> {
        let path = &input::document_in(path)?;
        let bytes = uri::document(path, options.limits.file_bytes)?;
        let asset = Self::from_bytes(bytes, path.parent().unwrap_or(Path::new("")), options)?;
        Ok(Self { path: Some(path.clone()), ..asset })
    }

    /// Opens the bytes of a file whose relative URIs are below `folder`.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_bytes(bytes: Vec<u8>, folder: &Path, options: &LoadOptions) -> Result<Self, AssetError> {
        Self::from_document(bytes, Some(folder.to_owned()), options)
    }

    /// Opens a file from a stream, such as standard input. It has no folder, so it cannot name files.
    ///
    /// # Errors
    /// As [`open`](Self::open), and, when it is read, where it names a file by a relative URI.
    pub fn from_stream(stream: impl std::io::Read, options: &LoadOptions) -> Result<Self, AssetError> {
        Self::from_document(uri::stream(stream, options.limits.file_bytes)?, None, options)
    }

    fn from_document(
        bytes: Vec<u8>,
        folder: Option<PathBuf>,
        options: &LoadOptions,
    ) -> Result<Self, AssetError> {
        let bytes = Bytes::from(bytes);
        let parts = container::split(&bytes)?;
        let json_bytes = bytes.get(parts.json).unwrap_or_default();
        let container::Parsed { document, duplicates, nulls } =
            container::parse(json_bytes, options.limits.json_values)?;
        Ok(Self {
            document,
            duplicates,
            nulls,
            oddities: parts.oddities,
            bin: parts.bin.and_then(|range| bytes.slice(range.start, range.len())),
            path: None,
            folder,
            file_bytes: bytes.len() as u64,
            options: options.clone(),
            cache: Cache::default(),
        })
    }

    /// Names of the animations; `None` for those that have none.
    pub fn animation_names(&self) -> Vec<Option<&str>> {
        let list = self.document.get("animations").and_then(Value::as_array);
        list.into_iter().flatten().map(|a| a.get("name").and_then(Value::as_str)).collect()
    }

    /// The paths of the files that it is read from, also of those that are not there.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = self.path.iter().cloned().collect();
        if let Some(folder) = &self.folder {
            let named = uri::named_in(&self.document);
            files.extend(named.iter().flat_map(|(_, uri)| uri::candidates(folder, uri)));
        }
        files
    }

    /// Reads the scene at a moment. What is odd about files and images is told the first time only; the origin is that of
    /// the first time, so that moments can be compared.
    ///
    /// # Errors
    /// Where the file is not glTF 2.0, refers to what is not there, requires an extension that is not in the registry,
    /// or asks for more than the limits; where the moment names an animation that is not there.
    pub fn load(&mut self, moment: &Moment) -> Result<Loaded, AssetError> {
        let cache = std::mem::take(&mut self.cache);
        let (loaded, cache) = self.load_with(cache, moment)?;
        self.cache = cache;
        Ok(loaded)
    }

    /// A loader that has read nothing yet.
    pub(crate) fn loader(&self) -> Loader<'_> {
        let mut loader = Loader::new(&self.document, &self.options, self.folder.as_deref());
        loader.totals.file_bytes = self.file_bytes;
        loader.bin = self.bin.clone();
        loader
    }

    fn load_with(&self, cache: Cache, moment: &Moment) -> Result<(Loaded, Cache), AssetError> {
        let mut loader = self.loader();
        loader.cache = cache;
        for oddity in &self.oddities {
            loader.invalid("", oddity)?;
        }
        for key in &self.duplicates {
            let key = shorten(key);
            loader.invalid("", format!("the key `{key}` occurs twice in one object; the last one counts"))?;
        }
        let (keys, count) = &self.nulls;
        if *count > 0 {
            let names: Vec<String> = keys.iter().map(|key| format!("`{}`", shorten(key))).collect();
            let what = if *count == 1 { "1 property is" } else { &format!("{count} properties are") };
            loader.note("", format!("{what} null, which counts as absent: {}", names.join(", ")));
        }
        loader.version()?;
        let extensions = loader.extensions()?;
        let (animations, edits) = loader.animate(moment)?;
        let mut animated;
        if !edits.is_empty() {
            animated = self.document.clone();
            apply(&mut animated, &edits);
            loader = Loader::new(&animated, &self.options, self.folder.as_deref()).continuing(loader);
        }
        loader.read()?;
        loader.rebase();
        loader.drop_repeated_objects();
        loader.decode_images()?;
        for extension in self.options.registry.iter() {
            extension.finish(&mut loader)?;
        }
        loader.afterthoughts(!moment.animations.is_empty())?;
        let summary = Summary::new(&loader, extensions, animations);
        let cache = std::mem::take(&mut loader.cache);
        let (scene, diagnostics) = loader.finish();
        Ok((Loaded { scene, diagnostics, summary }, cache))
    }
}
