//! Textures: `textureInfo` → texture → sampler and image, made on demand; images are decoded together at the end.
//!
//! Only what a material uses is decoded. An image that cannot be decoded does not end the load: the references to it
//! are taken back, as if the material had no such texture.

use std::sync::Arc;

use glam::Affine2;
use rayon::prelude::*;

use super::error::AssetError;
use super::image;
use super::json::Json;
use super::loader::Loader;
use crate::scene::{ColorSpace, ImageData, ImagePixels, Minify, TextureDescription, TextureRef, Wrap};

/// Texture coordinate sets beyond this many are refused.
pub(crate) const MOST_UV_SETS: usize = 16;

/// Images decoded at a time, so that their files need not all be in memory.
const DECODED_TOGETHER: usize = 16;

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
            None => json.usize("source")?,
        };
        let texture = match source {
            Some(source) => {
                let mut texture = self.sampler(&json)?;
                texture.image = self.image(source, &json.pointer_to("source"))?;
                self.scene.textures.push(texture);
                Some(self.scene.textures.len() - 1)
            }
            None => {
                self.warn(json.pointer(), "has no image that can be used; it is left out", None);
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

    /// The scene's image for image `index` of the file; it is decoded later.
    fn image(&mut self, index: usize, from: &str) -> Result<usize, AssetError> {
        if let Some(&known) = self.images.get(&index) {
            return Ok(known);
        }
        let json = self.entry("images", index, from)?;
        let name = json.name_or(|| match json.str("uri") {
            Ok(Some(uri)) if uri.len() <= 256 && !uri.starts_with("data:") => uri.to_owned(),
            _ => format!("image {index}"),
        });
        self.scene.images.push(Arc::new(placeholder(name)));
        self.image_sources.push(index);
        let slot = self.scene.images.len() - 1;
        self.images.insert(index, slot);
        Ok(slot)
    }

    /// Decodes the images in use, and takes back the references to those that cannot be decoded.
    pub(crate) fn decode_images(&mut self) -> Result<(), AssetError> {
        let sources = std::mem::take(&mut self.image_sources);
        let limits = &self.options.limits;
        let registry = &self.options.registry;
        let mut usable = vec![false; sources.len()];
        let mut fresh = Vec::new();
        for (slot, source) in sources.iter().enumerate() {
            match self.cache.images.get(source) {
                Some(image) => {
                    self.scene.images[slot] = Arc::clone(image);
                    usable[slot] = true;
                }
                None => fresh.push(slot),
            }
        }
        for together in fresh.chunks(DECODED_TOGETHER) {
            let mut files = Vec::new();
            for &slot in together {
                let pointer = format!("/images/{}", sources[slot]);
                let file = self.image_file(sources[slot])?;
                self.totals.image_bytes += file.as_ref().and_then(|b| image::decoded_bytes(b)).unwrap_or(0);
                let needed = self.totals.image_bytes;
                let what = "all images so far, in bytes once decoded,";
                Self::within(needed, limits.image_bytes, &pointer, what, "image_bytes")?;
                files.push(file);
            }
            let decode =
                |file: &Option<super::Bytes>| file.as_ref().map(|b| image::decode(b, registry, limits));
            let decoded: Vec<Option<Result<ImageData, String>>> = files.par_iter().map(decode).collect();
            for (&slot, result) in together.iter().zip(decoded) {
                match result {
                    Some(Ok(image)) => {
                        let name = self.scene.images[slot].name.clone();
                        let image = Arc::new(ImageData { name, ..image });
                        self.scene.images[slot] = Arc::clone(&image);
                        self.cache.images.insert(sources[slot], image);
                        usable[slot] = true;
                    }
                    Some(Err(message)) => {
                        let pointer = format!("/images/{}", sources[slot]);
                        let message = format!("the image cannot be decoded and is left out: {message}");
                        self.warn(&pointer, message, None);
                    }
                    None => {}
                }
            }
        }
        let textures = &self.scene.textures;
        let good = |r: &TextureRef| usable.get(textures[r.texture].image).copied().unwrap_or(false);
        for slot in self.scene.materials.iter_mut().flat_map(|m| m.texture_slots_mut()) {
            if slot.as_ref().is_some_and(|r| !good(r)) {
                *slot = None;
            }
        }
        Ok(())
    }

    /// The bytes of image `index` of the file, or `None`, with a warning, where they cannot be had.
    fn image_file(&mut self, index: usize) -> Result<Option<super::Bytes>, AssetError> {
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

fn placeholder(name: String) -> ImageData {
    ImageData { name, width: 1, height: 1, pixels: ImagePixels::Rgba8(vec![255; 4]) }
}
