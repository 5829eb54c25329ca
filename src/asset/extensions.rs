//! Which extensions a file uses, and whether it can go without those that are not supported.

use super::error::AssetError;
use super::loader::Loader;
use super::summary::ExtensionSummary;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

impl Loader<'_> {
    /// Whether the file declares that it uses an extension.
    pub fn uses(&self, name: &str) -> bool {
        self.declared.contains(name)
    }

    /// Finds the extensions of the file, and refuses to go on without those that it requires.
    pub(crate) fn extensions(&mut self) -> Result<Vec<ExtensionSummary>, AssetError> {
        let root = self.root();
        let names = |key: &str| -> Result<Vec<(String, String)>, AssetError> {
            let list = root.array(key)?.into_iter();
            list.map(|n| Ok((n.as_str()?.to_owned(), n.pointer().to_owned()))).collect()
        };
        let (used, required) = (names("extensionsUsed")?, names("extensionsRequired")?);
        self.declared = used.iter().map(|(n, _)| n.clone()).collect();
        for (name, pointer) in &required {
            if self.declared.insert(name.clone()) {
                self.invalid(pointer, format!("{name} is required, but not in /extensionsUsed"))?;
            }
        }
        let mut found = places(self.document);
        for (name, (_, pointer)) in &found {
            if !self.declared.contains(name) && self.options.registry.get(name).is_some() {
                self.invalid(pointer, format!("{name} is not in /extensionsUsed; it is read all the same"))?;
            }
        }
        let required: BTreeSet<&String> = required.iter().map(|(n, _)| n).collect();
        let all: BTreeSet<String> = self.declared.iter().chain(found.keys()).cloned().collect();
        let mut missing: Vec<String> = Vec::new();
        let mut summaries = Vec::new();
        for name in all {
            let is_required = required.contains(&name);
            let (places, pointer) = found.remove(&name).unwrap_or_default();
            let (supported, ignored) = match self.options.registry.get(&name) {
                Some(extension) => (true, extension.shortfall().map(str::to_owned)),
                None => (false, Some("not supported".to_owned())),
            };
            if !supported && is_required {
                missing.push(name.clone());
            } else if !supported {
                let pointer = if pointer.is_empty() { "/extensionsUsed" } else { &pointer };
                let message = format!("{name} is not supported and is ignored");
                if name.starts_with("KHR_materials_") {
                    self.warn(pointer, message, Some("the material will look different from what was meant"));
                } else {
                    self.note(pointer, message);
                }
            }
            summaries.push(ExtensionSummary { name, required: is_required, places, supported, ignored });
        }
        if missing.is_empty() { Ok(summaries) } else { Err(AssetError::RequiredExtension { names: missing }) }
    }
}

/// How many objects carry each extension, and the pointer of the first of them.
fn places(document: &Value) -> BTreeMap<String, (usize, String)> {
    const MOST_NAMES: usize = 256;
    let mut found: BTreeMap<String, (usize, String)> = BTreeMap::new();
    let mut stack = vec![(document, String::new())];
    while let Some((value, pointer)) = stack.pop() {
        match value {
            Value::Array(array) => {
                let items = array.iter().enumerate().filter(|(_, v)| v.is_object() || v.is_array());
                stack.extend(items.rev().map(|(i, v)| (v, format!("{pointer}/{i}"))));
            }
            Value::Object(object) => {
                if let Some(Value::Object(extensions)) = object.get("extensions") {
                    for name in extensions.keys() {
                        if found.len() < MOST_NAMES || found.contains_key(name) {
                            let entry = found.entry(name.clone()).or_default();
                            entry.0 += 1;
                            if entry.0 == 1 {
                                entry.1 = format!("{pointer}/extensions/{name}");
                            }
                        }
                    }
                }
                let items = object.iter().filter(|(k, v)| *k != "extras" && (v.is_object() || v.is_array()));
                stack.extend(items.rev().map(|(k, v)| (v, format!("{pointer}/{k}"))));
            }
            _ => {}
        }
    }
    found
}
