//! Writing media into glTF files, and between the ways of describing them.
//!
//! A document is changed as text ([`text`]): what nobody asked to change keeps every byte. [`file`](mod@file) takes
//! `.gltf` and `.glb` apart and puts them together again, [`medium`] reads the medium of a material from whichever
//! description wins, [`nephrite`], [`khronos`] and [`openpbr`] write it, [`bodies`] knows how large the objects are,
//! [`paint`] makes coefficient textures of base colours, and [`check`] finds what is wrong with all of it. All numbers are
//! doubles: what is converted there and back should come back.

pub mod bodies;
pub mod check;
pub mod file;
pub mod khronos;
pub mod medium;
pub mod nephrite;
pub mod openpbr;
pub mod paint;
pub mod text;

pub use file::AuthoredFile;
pub use medium::{Form, Medium, Reading};

use serde_json::Value;
use text::Node;

/// Keeps `extensionsUsed` true: adds the extensions of `names` that the document uses and that are not listed, and removes
/// those that it does not use any more, from `extensionsRequired` too. An empty list goes.
pub fn declare(root: &mut Node<'_>, names: &[&str]) {
    let Some(document) = root.value() else { return };
    for name in names {
        if uses(&document, name) {
            let listed = root.get("extensionsUsed").is_some_and(|list| list.has_string(name));
            match root.get_mut("extensionsUsed") {
                Some(list) if !listed => list.push(&Value::from(*name)),
                Some(_) => {}
                None => root.set("extensionsUsed", &Value::from(vec![*name])),
            }
            continue;
        }
        for key in ["extensionsUsed", "extensionsRequired"] {
            let Some(list) = root.get_mut(key) else { continue };
            if list.remove_string(name) && list.is_empty() {
                root.remove(key);
            }
        }
    }
}

/// Whether any object of the document carries an extension.
fn uses(document: &Value, name: &str) -> bool {
    let mut stack = vec![document];
    while let Some(value) = stack.pop() {
        match value {
            Value::Array(items) => stack.extend(items),
            Value::Object(members) => {
                if members.get("extensions").is_some_and(|e| e.get(name).is_some()) {
                    return true;
                }
                stack.extend(members.iter().filter(|(key, _)| *key != "extras").map(|(_, value)| value));
            }
            _ => {}
        }
    }
    false
}

/// Sets members of an extension of a material; members that are not named stay.
pub fn set_extension(material: &mut Node<'_>, name: &str, members: &serde_json::Map<String, Value>) {
    let Some(extensions) = material.object_mut("extensions") else { return };
    match extensions.get_mut(name) {
        Some(own) => members.iter().for_each(|(key, value)| own.set(key, value)),
        None => extensions.set(name, &Value::Object(members.clone())),
    }
}

/// Removes a member of an object-valued property, and the property with its last member; whether it was there.
pub fn remove_member(parent: &mut Node<'_>, property: &str, key: &str) -> bool {
    let Some(object) = parent.get_mut(property) else { return false };
    let found = object.remove(key);
    if found && object.is_empty() {
        parent.remove(property);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use text::Tree;

    #[test]
    fn what_is_used_is_declared_and_nothing_else_is_touched() {
        let text = r#"{"extensionsUsed":["A","B"],"extensionsRequired":["B"],"x":[{"extensions":{"C":{}}}],"extras":{"extensions":{"D":{}}}}"#;
        let mut tree = Tree::parse(text).unwrap();
        declare(tree.root_mut(), &["B", "C", "D"]);
        let expected =
            r#"{"extensionsUsed":["A","C"],"x":[{"extensions":{"C":{}}}],"extras":{"extensions":{"D":{}}}}"#;
        assert_eq!(tree.to_string(), expected);
        let mut tree = Tree::parse(r#"{"materials":[{"extensions":{"C":{}}}]}"#).unwrap();
        declare(tree.root_mut(), &["C"]);
        assert!(tree.root().get("extensionsUsed").unwrap().has_string("C"));
    }
}
