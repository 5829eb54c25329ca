//! Images and textures that are added to a document, and where their bytes go: into the binary chunk of a `.glb`, beside a
//! `.gltf`, or into the document.

use super::PaintError;
use crate::author::AuthoredFile;
use crate::author::text::{Node, Tree};
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// Images that a document is to get, each once.
#[derive(Debug, Default)]
pub struct NewImages {
    /// Names and bytes of PNGs, in the order of their indices.
    images: Vec<(String, Vec<u8>)>,
    known: HashMap<Vec<u8>, usize>,
    /// Textures of them: image, sampler, and the texture's index.
    textures: Vec<(usize, Option<usize>, usize)>,
    /// Images of the document before.
    before: usize,
}

/// Where the bytes of images go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place<'a> {
    /// Behind so many bytes of the binary chunk.
    Chunk(usize),
    /// Data URIs.
    Document,
    /// Files of these names.
    Files(&'a [String]),
}

impl NewImages {
    /// For a document.
    pub fn new(document: &Value) -> Self {
        let before = document.get("images").and_then(Value::as_array).map_or(0, Vec::len);
        Self { before, ..Self::default() }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// Names and bytes.
    pub fn list(&self) -> &[(String, Vec<u8>)] {
        &self.images
    }

    /// The index of the texture of an image with that sampler; both are added unless they are there.
    pub fn texture(
        &mut self,
        root: &mut Node<'_>,
        name: &str,
        png: Vec<u8>,
        sampler: Option<usize>,
    ) -> usize {
        let image = *self.known.entry(png).or_insert_with_key(|png| {
            self.images.push((name.to_owned(), png.clone()));
            self.before + self.images.len() - 1
        });
        if let Some((.., index)) = self.textures.iter().find(|(i, s, _)| (*i, *s) == (image, sampler)) {
            return *index;
        }
        let mut texture = Map::new();
        if let Some(sampler) = sampler {
            texture.insert("sampler".to_owned(), json!(sampler));
        }
        texture.insert("source".to_owned(), json!(image));
        texture.insert("name".to_owned(), json!(name));
        let index = push(root, "textures", &Value::Object(texture));
        self.textures.push((image, sampler, index));
        index
    }

    /// All bytes, each image at a multiple of four.
    pub fn chunk(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (_, png) in &self.images {
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            bytes.extend_from_slice(png);
        }
        bytes
    }

    /// Adds the images to a document.
    pub fn attach(&self, tree: &mut Tree<'_>, place: Place<'_>) {
        use base64::Engine;
        let root = tree.root_mut();
        let mut at = 0usize;
        for (i, (name, png)) in self.images.iter().enumerate() {
            let image = match place {
                Place::Files(names) => json!({ "name": name, "uri": names.get(i) }),
                Place::Document => {
                    let data = base64::engine::general_purpose::STANDARD.encode(png);
                    json!({ "name": name, "uri": format!("data:image/png;base64,{data}") })
                }
                Place::Chunk(before) => {
                    at = at.next_multiple_of(4);
                    let view = json!({ "buffer": 0, "byteOffset": before + at, "byteLength": png.len() });
                    at += png.len();
                    let view = push(root, "bufferViews", &view);
                    json!({ "name": name, "mimeType": "image/png", "bufferView": view })
                }
            };
            push(root, "images", &image);
        }
        if let Place::Chunk(before) = place {
            let length = json!(before + at);
            match root.get_mut("buffers").and_then(|list| list.item_mut(0)) {
                Some(buffer) => buffer.set("byteLength", &length),
                None => drop(push(root, "buffers", &json!({ "byteLength": length }))),
            }
        }
    }
}

/// Where images of a file go unless they are files: into its binary chunk if it has one, or could have.
pub fn place_inside(file: &AuthoredFile) -> Place<'static> {
    let buffers = file.document().get("buffers").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    match (file.is_binary(), file.chunk_length(), buffers.first()) {
        (true, Some(length), Some(first))
            if first.get("uri").is_none() && first.get("extensions").is_none() =>
        {
            Place::Chunk(length.next_multiple_of(4))
        }
        (true, None, None) => Place::Chunk(0),
        _ => Place::Document,
    }
}

/// Adds an entry to an array of the document, which is made if there is none; its index.
pub fn push(root: &mut Node<'_>, key: &str, value: &Value) -> usize {
    match root.get_mut(key) {
        Some(list) => list.push(value),
        None => root.set(key, &json!([value])),
    }
    root.get(key).map_or(0, Node::len).saturating_sub(1)
}

/// A PNG of 16-bit colours, linear.
///
/// # Errors
/// Where it has no size that a PNG could have.
pub fn png_of_coefficients(width: u32, texels: &[[u16; 3]]) -> Result<Vec<u8>, PaintError> {
    let bytes: Vec<u8> = texels.iter().flatten().flat_map(|v| v.to_be_bytes()).collect();
    png(width, texels.len(), png::ColorType::Rgb, png::BitDepth::Sixteen, &bytes)
}

/// A white PNG with alpha.
///
/// # Errors
/// As [`png_of_coefficients`].
pub fn png_of_alpha(width: u32, texels: &[u8]) -> Result<Vec<u8>, PaintError> {
    let bytes: Vec<u8> = texels.iter().flat_map(|a| [255, 255, 255, *a]).collect();
    png(width, texels.len(), png::ColorType::Rgba, png::BitDepth::Eight, &bytes)
}

fn png(
    width: u32,
    texels: usize,
    color: png::ColorType,
    depth: png::BitDepth,
    bytes: &[u8],
) -> Result<Vec<u8>, PaintError> {
    let height = u32::try_from(texels / width.max(1) as usize).unwrap_or(u32::MAX);
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(bytes)?;
        writer.finish()
    });
    written.map_err(|e| PaintError::Picture(e.to_string()))?;
    Ok(out)
}
