//! Writing animated values into a document.

use glam::{DMat4, DVec3};
use serde_json::{Map, Number, Value, json};

use super::{Edit, PropertyKind};

/// Writes values into the document whose properties they are of.
pub(crate) fn apply(document: &mut Value, edits: &[Edit]) {
    for edit in edits {
        let defaults = default_weights(document, edit);
        // Properties were found in this document.
        let _ = write(document, edit, defaults);
    }
}

fn write(document: &mut Value, edit: &Edit, defaults: Vec<Value>) -> Option<()> {
    let Edit { property, values } = edit;
    let path = &property.path;
    let depth = path.len().checked_sub(if property.kind == PropertyKind::Weight { 2 } else { 1 })?;
    let around = path[..depth].iter().try_fold(document, |value, token| child(value, token))?;
    let around = around.as_object_mut()?;
    let leaf = path.last()?;
    if path.first()? == "nodes" && depth == 2 && around.contains_key("matrix") {
        take_apart(around);
    }
    if is_infinite_index(path, around) {
        return None;
    }
    let number = |v: &f64| Number::from_f64(*v).map_or(Value::Null, Value::Number);
    match property.kind {
        PropertyKind::Bool => around.insert(leaf.clone(), Value::Bool(*values.first()? != 0.0)),
        PropertyKind::Float => around.insert(leaf.clone(), number(values.first()?)),
        PropertyKind::Weight => {
            let array = around.entry("weights").or_insert_with(|| Value::Array(defaults)).as_array_mut()?;
            let index: usize = leaf.parse().ok()?;
            if array.len() <= index {
                array.resize(index + 1, json!(0));
            }
            array[index] = number(values.first()?);
            None
        }
        _ => around.insert(leaf.clone(), Value::Array(values.iter().map(number).collect())),
    };
    Some(())
}

/// KHR_materials_ior: an index of zero, the mode of specular-glossiness, stays what it is.
fn is_infinite_index(path: &[String], around: &Map<String, Value>) -> bool {
    path.ends_with(&["KHR_materials_ior".to_owned(), "ior".to_owned()])
        && around.get("ior").and_then(Value::as_f64) == Some(0.0)
}

/// The weights that a node without any takes from its mesh.
fn default_weights(document: &Value, edit: &Edit) -> Vec<Value> {
    let [root, index, _, _] = &edit.property.path[..] else { return Vec::new() };
    let node = document.get(root).and_then(|nodes| nodes.get(index.parse::<usize>().ok()?));
    let mesh = node.and_then(|node| node.get("mesh")?.as_u64());
    let weights = mesh.and_then(|mesh| document.pointer(&format!("/meshes/{mesh}/weights"))?.as_array());
    weights.cloned().unwrap_or_default()
}

/// Replaces the matrix of a node by translation, rotation and scale, as far as it is made of them.
fn take_apart(node: &mut Map<String, Value>) {
    let Some(matrix) = node.remove("matrix") else { return };
    let numbers: Vec<f64> = matrix.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    let Ok(columns) = <[f64; 16]>::try_from(numbers) else { return };
    let matrix = DMat4::from_cols_array(&columns);
    let translation = matrix.w_axis.truncate();
    if !translation.is_finite() {
        return;
    }
    node.insert("translation".to_owned(), json!(translation.to_array()));
    let (scale, rotation, _) = matrix.to_scale_rotation_translation();
    if scale.is_finite() && rotation.is_finite() && scale != DVec3::ZERO {
        node.insert("scale".to_owned(), json!(scale.to_array()));
        node.insert("rotation".to_owned(), json!(rotation.to_array()));
    }
}

fn child<'v>(value: &'v mut Value, token: &str) -> Option<&'v mut Value> {
    match value {
        Value::Object(object) => object.get_mut(token),
        Value::Array(array) => array.get_mut(token.parse::<usize>().ok()?),
        _ => None,
    }
}
