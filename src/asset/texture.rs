//! Textures: `textureInfo` → texture → sampler and image, made on demand; images are decoded together at the end.
//!
//! Only what a material uses is decoded. An image that cannot be decoded does not end the load: the references to it
//! are taken back, as if the material had no such texture.

use std::sync::Arc;

use glam::Affine2;
use rayon::prelude::*;

use super::LoadOptions;
use super::buffer::Bytes;
use super::error::AssetError;
use super::image;
use super::json::Json;
use super::loader::Loader;
use crate::scene::{ColorSpace, ImageData, ImagePixels, Minify, TextureDescription, TextureRef, Wrap};

/// Texture coordinate sets beyond this many are refused.
pub(crate) const MOST_UV_SETS: usize = 16;

/// Images decoded at a time, so that their files need not all be in memory.
const DECODED_TOGETHER: usize = 16;

/// An image of the file, and which of its layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ImageSource {
    /// Index in `images`.
    pub image: usize,
    /// Layer of an array of images; 0 where there is only one.
    pub layer: usize,
}

impl From<usize> for ImageSource {
    fn from(image: usize) -> Self {
        Self { image, layer: 0 }
    }
}

impl Loader<'_> {
    /// The `textureInfo` at `key` of `json`, if present and usable.
    ///
    /// # Errors
    /// Where it refers to something that is not there.
    pub fn texture_slot(
        &mut self,
        json: &Json<'_>,
        key: &str,
        color_space: ColorSpace,
    ) -> Result<Option<TextureRef>, AssetError> {
        let Some(info) = json.object(key)? else { return Ok(None) };
        let index = info.usize("index")?.ok_or_else(|| info.error_at("index", "is missing"))?;
        let Some(texture) = self.texture(index, &info.pointer_to("index"))? else { return Ok(None) };
        let uv_set = match info.usize("texCoord")? {
            Some(set) => self.uv_set(&info.pointer_to("texCoord"), set)?,
            None => 0,
        };
        let mut out = TextureRef { texture, uv_set, transform: Affine2::IDENTITY, color_space };
        if info.get("extensions").is_some() {
            for extension in self.options.registry.iter() {
                if let Some(own) = info.extension(extension.name()) {
                    extension.texture_info(self, &own, &mut out)?;
                }
            }
        }
        Ok(Some(out))
    }

    /// Checks the number of a texture coordinate set.
    ///
    /// # Errors
    /// Where it is absurdly large.
    pub fn uv_set(&self, pointer: &str, set: usize) -> Result<usize, AssetError> {
        if set >= MOST_UV_SETS {
            return Err(AssetError::invalid(pointer, format!("{set} is above {}", MOST_UV_SETS - 1)));
        }
        Ok(set)
    }

    /// The scene's texture for texture `index` of the file; `None` if it has no image that can be used.
    fn texture(&mut self, index: usize, from: &str) -> Result<Option<usize>, AssetError> {
        if let Some(&known) = self.textures.get(&index) {
            return Ok(known);
        }
        let json = self.entry("textures", index, from)?;
        let mut source = None;
        if json.get("extensions").is_some() {
            for extension in self.options.registry.iter() {
                if let Some(own) = json.extension(extension.name()) {
                    source = extension.texture_source(self, &own)?.or(source);
                }
            }
        }
        let source = match source {
            Some(source) => Some(source),
            None => json.usize("source")?.map(ImageSource::from),
        };
        let texture = match source {
            Some(source) => {
                let mut texture = self.sampler(&json)?;
                texture.image = self.image(source, &json.pointer_to("source"))?;
                self.scene.textures.push(texture);
                Some(self.scene.textures.len() - 1)
            }
            None => {
                self.invalid(json.pointer(), "has no image that can be used; it is left out")?;
                None
            }
        };
        self.textures.insert(index, texture);
        Ok(texture)
    }

    fn sampler(&mut self, texture: &Json<'_>) -> Result<TextureDescription, AssetError> {
        let mut out = TextureDescription {
            image: 0,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            linear_filter: true,
            minify: Minify::Footprint,
        };
        let Some(index) = texture.usize("sampler")? else { return Ok(out) };
        let json = self.entry("samplers", index, &texture.pointer_to("sampler"))?;
        out.wrap_u = self.wrap(&json, "wrapS")?;
        out.wrap_v = self.wrap(&json, "wrapT")?;
        out.linear_filter = match json.usize("magFilter")? {
            Some(9728) => false,
            Some(9729) | None => true,
            Some(other) => {
                self.invalid(&json.pointer_to("magFilter"), format!("{other} is no filter of glTF"))?;
                true
            }
        };
        match json.usize("minFilter")? {
            // NEAREST and LINEAR ask for no mipmaps.
            Some(9728 | 9729) => out.minify = Minify::Point,
            Some(9984..=9987) | None => {}
            Some(other) => {
                self.invalid(&json.pointer_to("minFilter"), format!("{other} is no filter of glTF"))?
            }
        }
        Ok(out)
    }

    fn wrap(&mut self, sampler: &Json<'_>, key: &str) -> Result<Wrap, AssetError> {
        Ok(match sampler.usize(key)? {
            Some(10497) | None => Wrap::Repeat,
            Some(33648) => Wrap::MirroredRepeat,
            Some(33071) => Wrap::ClampToEdge,
            Some(other) => {
                self.invalid(&sampler.pointer_to(key), format!("{other} is no wrap mode of glTF"))?;
                Wrap::Repeat
            }
        })
    }

    /// The scene's image for an image of the file; it is decoded later.
    fn image(&mut self, source: ImageSource, from: &str) -> Result<usize, AssetError> {
        if let Some(&known) = self.images.get(&source) {
            return Ok(known);
        }
        let index = source.image;
        let json = self.entry("images", index, from)?;
        // Entries that name the same bytes are one image.
        let bytes = (json.usize("bufferView").ok().flatten(), json.str("uri").ok().flatten());
        if bytes != (None, None) {
            let first = *self.image_files.entry(bytes).or_insert(index);
            let twin = ImageSource { image: first, ..source };
            if let Some(&slot) = self.images.get(&twin) {
                self.images.insert(source, slot);
                return Ok(slot);
            }
        }
        let name = json.name_or(|| match json.str("uri") {
            Ok(Some(uri)) if uri.len() <= 256 && !uri.starts_with("data:") => uri.to_owned(),
            _ => format!("image {index}"),
        });
        self.scene.images.push(Arc::new(placeholder(name)));
        self.image_sources.push(source);
        let slot = self.scene.images.len() - 1;
        self.images.insert(source, slot);
        Ok(slot)
    }

    /// Finds the next files of images in use that are yet to be decoded, as many as are decoded together.
    ///
    /// # Errors
    /// Where the images are larger than the limits allow.
    pub(crate) fn images_to_decode(&mut self) -> Result<ImageFiles, AssetError> {
        let mut files = Vec::new();
        let mut together = 0_u64;
        let first = self.decoded_images;
        let last = (first + DECODED_TOGETHER).min(self.image_sources.len());
        for slot in first..last {
            let source = self.image_sources[slot];
            if let Some(image) = self.cache.images.get(&source) {
                self.scene.images[slot] = Arc::clone(image);
                self.usable_images.insert(slot);
                files.push((None, source.layer));
                continue;
            }
            let ImageSource { image: index, layer } = source;
            let file = self.image_file(index)?;
            let bytes = file.as_ref().and_then(|b| image::decoded_bytes(b, &self.options.registry));
            self.totals.image_bytes = self.totals.image_bytes.saturating_add(bytes.unwrap_or(0));
            let (needed, limit) = (self.totals.image_bytes, self.options.limits.image_bytes);
            let what = "all images so far, in bytes once decoded,";
            Self::within(needed, limit, &format!("/images/{index}"), what, "image_bytes")?;
            // Decoders have the pixels in their own form first.
            together = together.saturating_add(2 * bytes.unwrap_or(0));
            if !crate::room::is_there(together) {
                let pointer = format!("/images/{index}");
                return Err(AssetError::Memory { pointer, what: "decoding images", needed: together });
            }
            files.push((file, layer));
        }
        self.decoded_images = last;
        Ok(ImageFiles { first, files })
    }

    /// Puts decoded images where they belong.
    pub(crate) fn keep_images(&mut self, decoded: DecodedImages) -> Result<(), AssetError> {
        for (slot, result) in (decoded.first..).zip(decoded.images) {
            match result {
                Some(Ok(image)) => {
                    let name = self.scene.images[slot].name.clone();
                    let image = Arc::new(ImageData { name, ..image });
                    self.scene.images[slot] = Arc::clone(&image);
                    self.cache.images.insert(self.image_sources[slot], image);
                    self.usable_images.insert(slot);
                }
                Some(Err(message)) => {
                    let pointer = format!("/images/{}", self.image_sources[slot].image);
                    self.invalid(
                        &pointer,
                        format!("the image cannot be decoded and is left out: {message}"),
                    )?;
                }
                None => {}
            }
        }
        Ok(())
    }

    /// Decodes the images in use that have not been, and takes back the references to those that cannot be decoded.
    pub(crate) fn decode_images(&mut self) -> Result<(), AssetError> {
        while self.decoded_images < self.image_sources.len() {
            let decoded = self.images_to_decode()?.decode(self.options);
            self.keep_images(decoded)?;
        }
        let textures = &self.scene.textures;
        let usable = &self.usable_images;
        let good = |r: &TextureRef| usable.contains(&textures[r.texture].image);
        for slot in self.scene.materials.iter_mut().flat_map(|m| m.texture_slots_mut()) {
            if slot.as_ref().is_some_and(|r| !good(r)) {
                *slot = None;
            }
        }
        Ok(())
    }

    /// The pixels of an image of the file, decoded at once; `None`, with a warning, where they cannot be had. Images
    /// of materials are better left to [`texture_slot`](Self::texture_slot), which decodes them together.
    ///
    /// # Errors
    /// Where there is no such image, or it is larger than the limits allow.
    pub fn image_pixels(&mut self, source: ImageSource, from: &str) -> Result<Option<ImageData>, AssetError> {
        self.entry("images", source.image, from)?;
        let Some(file) = self.image_file(source.image)? else { return Ok(None) };
        let (limits, registry) = (&self.options.limits, &self.options.registry);
        let bytes = image::decoded_bytes(&file, registry).unwrap_or(0);
        self.totals.image_bytes = self.totals.image_bytes.saturating_add(bytes);
        let what = "all images so far, in bytes once decoded,";
        Self::within(self.totals.image_bytes, limits.image_bytes, from, what, "image_bytes")?;
        match image::decode(&file, source.layer, registry, limits) {
            Ok(pixels) => Ok(Some(pixels)),
            Err(message) => {
                let pointer = format!("/images/{}", source.image);
                self.invalid(&pointer, format!("the image cannot be decoded and is left out: {message}"))?;
                Ok(None)
            }
        }
    }

    /// The bytes of image `index` of the file, or `None`, with a warning, where they cannot be had.
    fn image_file(&mut self, index: usize) -> Result<Option<Bytes>, AssetError> {
        let json = self.entry("images", index, "/images")?;
        let view = json.usize("bufferView")?;
        let uri = json.str("uri")?;
        if view.is_some() && uri.is_some() {
            self.invalid(json.pointer(), "has both `uri` and `bufferView`; the latter is used")?;
        }
        let bytes = match (view, uri) {
            (Some(view), _) => self.buffer_view(view, &json.pointer_to("bufferView"))?,
            (None, Some(uri)) => match self.read_uri(&json.pointer_to("uri"), uri) {
                Ok(bytes) => bytes,
                Err(e @ (AssetError::Strict(_) | AssetError::Limit { .. })) => return Err(e),
                Err(e) if self.options.strict => return Err(e),
                Err(e) => {
                    let advice = e.advice();
                    let pointer = e.pointer().to_owned();
                    let text = e.to_string();
                    let text = text.strip_prefix(&format!("{pointer}: ")).unwrap_or(&text);
                    let message = format!("the image is left out: {text}");
                    self.warn(&pointer, message, advice.as_deref());
                    return Ok(None);
                }
            },
            (None, None) => {
                self.invalid(json.pointer(), "has neither `uri` nor `bufferView`; it is left out")?;
                return Ok(None);
            }
        };
        if let Some(declared) = json.str("mimeType")?
            && let Some(actual) = image::mime(&bytes)
            && declared != actual
        {
            self.invalid(&json.pointer_to("mimeType"), format!("the image is {actual}"))?;
        }
        Ok(Some(bytes))
    }
}

/// Files of images that are decoded together, and which of the scene's images they are.
pub(crate) struct ImageFiles {
    first: usize,
    files: Vec<(Option<Bytes>, usize)>,
}

/// What has become of them; `None` where there was no file.
pub(crate) struct DecodedImages {
    first: usize,
    images: Vec<Option<Result<ImageData, String>>>,
}

impl ImageFiles {
    /// Decodes the files, on all threads.
    pub fn decode(&self, options: &LoadOptions) -> DecodedImages {
        let decode = |(file, layer): &(Option<Bytes>, usize)| {
            file.as_ref().map(|b| image::decode(b, *layer, &options.registry, &options.limits))
        };
        DecodedImages { first: self.first, images: self.files.par_iter().map(decode).collect() }
    }
}

fn placeholder(name: String) -> ImageData {
    ImageData { name, width: 1, height: 1, pixels: ImagePixels::Rgba8(vec![255; 4]) }
}
