//! What changes in a document besides the medium once its paint has been taken: the base colour becomes white, vertex
//! colours go, and primitives get another material where one is not enough.

use super::Alpha;
use crate::asset::painting::shown_with;
use crate::author::text::Node;
use serde_json::{Map, Value, json};

/// Makes the base colour of a material white. Of `alpha` the factor stays, and the texture `texture`, whose description is
/// `info` with another index.
pub fn neutralise(material: &mut Node<'_>, alpha: &Alpha, texture: Option<Value>) {
    let Some(surface) = material.get_mut("pbrMetallicRoughness") else {
        if alpha.factor != 1.0 || texture.is_some() {
            material.set("pbrMetallicRoughness", &json!({}));
            neutralise(material, alpha, texture);
        }
        return;
    };
    match texture {
        Some(info) => surface.set("baseColorTexture", &info),
        None => drop(surface.remove("baseColorTexture")),
    }
    if alpha.factor == 1.0 {
        surface.remove("baseColorFactor");
    } else {
        surface.set("baseColorFactor", &json!([1, 1, 1, shortest(alpha.factor)]));
    }
}

/// A `textureInfo` for another texture, with the coordinates and their transform of `like`.
pub fn texture_info(like: Option<&Value>, index: usize) -> Value {
    let mut info = Map::new();
    info.insert("index".to_owned(), json!(index));
    for (key, value) in
        like.and_then(Value::as_object).into_iter().flatten().filter(|(key, _)| *key != "index")
    {
        info.insert(key.clone(), value.clone());
    }
    Value::Object(info)
}

/// Removes the vertex colours of a primitive, wherever they are told of: in its attributes, its morph targets, and its
/// Draco stream. Further sets, whose numbers would have a gap, become attributes of the application (`_COLOR_1`). Whether
/// there were any.
pub fn clear_vertex_colors(root: &mut Node<'_>, mesh: usize, primitive: usize) -> bool {
    let Some(primitive) = primitive_mut(root, mesh, primitive) else { return false };
    let Some(before) = primitive.value() else { return false };
    if before.pointer("/attributes/COLOR_0").is_none() {
        return false;
    }
    if let Some(attributes) = primitive.get_mut("attributes") {
        clear(attributes);
    }
    const DRACO: &str = "KHR_draco_mesh_compression";
    let extensions = primitive.get_mut("extensions");
    if let Some(attributes) =
        extensions.and_then(|e| e.get_mut(DRACO)).and_then(|own| own.get_mut("attributes"))
    {
        clear(attributes);
    }
    let targets = before.get("targets").and_then(Value::as_array).map_or(0, Vec::len);
    if let Some(list) = primitive.get_mut("targets") {
        for i in 0..targets {
            if let Some(target) = list.item_mut(i) {
                clear(target);
            }
        }
    }
    true
}

fn clear(attributes: &mut Node<'_>) {
    attributes.remove("COLOR_0");
    let Some(Value::Object(members)) = attributes.value() else { return };
    for (key, value) in members.iter().filter(|(key, _)| key.starts_with("COLOR_")) {
        attributes.remove(key);
        attributes.set(&format!("_{key}"), value);
    }
}

fn primitive_mut<'n, 'a>(root: &'n mut Node<'a>, mesh: usize, primitive: usize) -> Option<&'n mut Node<'a>> {
    root.get_mut("meshes")?.item_mut(mesh)?.get_mut("primitives")?.item_mut(primitive)
}

/// Gives a primitive another material in place of one, also among its variants.
pub fn use_material(root: &mut Node<'_>, [mesh, primitive]: [usize; 2], old: usize, new: usize) {
    let Some(primitive) = primitive_mut(root, mesh, primitive) else { return };
    let Some(before) = primitive.value() else { return };
    let is_old = |value: &Value| value.get("material").and_then(Value::as_u64) == Some(old as u64);
    if is_old(&before) {
        primitive.set("material", &json!(new));
    }
    let mappings = before.pointer("/extensions/KHR_materials_variants/mappings").and_then(Value::as_array);
    for (i, _) in mappings.into_iter().flatten().enumerate().filter(|(_, mapping)| is_old(mapping)) {
        let list = primitive
            .get_mut("extensions")
            .and_then(|e| e.get_mut("KHR_materials_variants"))
            .and_then(|own| own.get_mut("mappings"));
        if let Some(mapping) = list.and_then(|list| list.item_mut(i)) {
            mapping.set("material", &json!(new));
        }
    }
}

/// Primitives with vertex colours that may be shown with a material: mesh, index in it, and all materials of it.
pub fn colored_primitives(document: &Value, material: usize) -> Vec<([usize; 2], Vec<usize>)> {
    let mut found = Vec::new();
    let list =
        |value: &Value, key: &str| value.get(key).and_then(Value::as_array).cloned().unwrap_or_default();
    for (m, mesh) in list(document, "meshes").iter().enumerate() {
        for (p, primitive) in list(mesh, "primitives").iter().enumerate() {
            let materials = shown_with(primitive);
            if materials.contains(&material) && primitive.pointer("/attributes/COLOR_0").is_some() {
                found.push(([m, p], materials));
            }
        }
    }
    found
}

/// The pointer of an animation channel that moves the base colour of a material.
pub fn animated_base_color(document: &Value, material: usize) -> Option<String> {
    let prefix = format!("/materials/{material}/pbrMetallicRoughness/baseColor");
    let animations = document.get("animations").and_then(Value::as_array)?;
    animations.iter().enumerate().find_map(|(a, animation)| {
        let channels = animation.get("channels").and_then(Value::as_array)?;
        let moves = |channel: &Value| {
            let pointer = channel.pointer("/target/extensions/KHR_animation_pointer/pointer");
            pointer.and_then(Value::as_str).is_some_and(|pointer| pointer.starts_with(&prefix))
        };
        channels.iter().position(moves).map(|c| format!("/animations/{a}/channels/{c}"))
    })
}

/// Removes an unused coefficient texture of an extension object, or sets it.
pub fn set_texture(members: &mut Map<String, Value>, key: &str, info: Option<Value>) {
    match info {
        Some(info) => drop(members.insert(key.to_owned(), info)),
        None => drop(members.remove(key)),
    }
}

/// The shortest decimal that is the same number in single precision.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
