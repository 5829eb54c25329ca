//! `NEPHRITE_materials_subsurface` in a document: read, written, and checked against the rules of its schema.

use serde_json::{Map, Value, json};

use super::medium::{Form, Medium, Reading, number, surface_ior, triple};
use super::set_extension;
use super::text::Node;

/// Name of the extension.
pub const NAME: &str = "NEPHRITE_materials_subsurface";

/// The medium that the extension of a material describes.
pub fn read(material: &Value) -> Option<Reading> {
    let own = material.get("extensions")?.get(NAME)?;
    let density = number(own, "densityFactor").unwrap_or(1.0);
    let coefficient = |key: &str| triple(own, key).unwrap_or([0.0; 3]).map(|v| v * density);
    let mut beyond = Vec::new();
    for key in ["absorptionTexture", "scatteringTexture"] {
        if own.get(key).is_some() {
            beyond.push(format!("{key} has no equivalent; the coefficients are those of white texels"));
        }
    }
    if let Some(priority) = number(own, "priority").filter(|p| *p != 0.0) {
        beyond.push(format!("the priority of {priority} has no equivalent"));
    }
    let medium = Medium {
        sigma_a: coefficient("absorptionCoefficient"),
        sigma_s: coefficient("scatteringCoefficient"),
        g: number(own, "scatterAnisotropy").unwrap_or(0.0),
        ior: number(own, "ior").unwrap_or_else(|| surface_ior(material)),
    };
    Some(Reading { medium, form: Form::Nephrite, beyond })
}

/// Writes the extension for a medium.
pub fn write(material: &mut Node<'_>, medium: &Medium) {
    let mut members = Map::new();
    if medium.sigma_a != [0.0; 3] {
        members.insert("absorptionCoefficient".to_owned(), json!(medium.sigma_a));
    }
    if medium.sigma_s != [0.0; 3] {
        members.insert("scatteringCoefficient".to_owned(), json!(medium.sigma_s));
    }
    if medium.g != 0.0 {
        members.insert("scatterAnisotropy".to_owned(), json!(medium.g));
    }
    members.insert("ior".to_owned(), json!(medium.ior));
    set_extension(material, NAME, &members);
}

/// What of an extension object breaks the rules of its schema: the JSON pointer within the object, and why.
pub fn violations(own: &Value) -> Vec<(String, String)> {
    let Some(members) = own.as_object() else {
        return vec![(String::new(), "should be an object".to_owned())];
    };
    let mut found = Vec::new();
    for (key, value) in members {
        let pointer = format!("/{key}");
        match key.as_str() {
            "absorptionCoefficient" | "scatteringCoefficient" => match value.as_array() {
                Some(items) if items.len() == 3 => {
                    for (i, item) in items.iter().enumerate() {
                        let pointer = format!("{pointer}/{i}");
                        found.extend(range(item, |v| v >= 0.0, "at least 0").map(|why| (pointer, why)));
                    }
                }
                _ => found.push((pointer, "should be an array of three numbers".to_owned())),
            },
            "absorptionTexture" | "scatteringTexture" => {
                let sound = value.get("index").and_then(Value::as_u64).is_some();
                let why = (!sound).then(|| "should be a textureInfo with an `index`".to_owned());
                found.extend(why.map(|why| (pointer, why)));
            }
            "scatterAnisotropy" => {
                let why = range(value, |v| v > -1.0 && v < 1.0, "greater than -1 and less than 1");
                found.extend(why.map(|why| (pointer, why)));
            }
            "ior" => found.extend(range(value, |v| v >= 1.0, "at least 1").map(|why| (pointer, why))),
            "densityFactor" => {
                found.extend(range(value, |v| v >= 0.0, "at least 0").map(|why| (pointer, why)))
            }
            "priority" => {
                let whole = |v: f64| v.fract() == 0.0 && v.abs() <= f64::from(i32::MAX) + 1.0;
                found.extend(range(value, whole, "an integer of 32 bits").map(|why| (pointer, why)));
            }
            _ => {}
        }
    }
    found
}

fn range(value: &Value, allowed: impl Fn(f64) -> bool, what: &str) -> Option<String> {
    match value.as_f64() {
        Some(v) if allowed(v) => None,
        Some(v) => Some(format!("{v} should be {what}")),
        None => Some(format!("should be a number, {what}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All violations at once, and exactly where the schema sees them.
    #[test]
    fn violations_are_those_of_the_schema() {
        let schema = include_str!(
            "../../extensions/NEPHRITE_materials_subsurface/schema/material.NEPHRITE_materials_subsurface.schema.json"
        );
        let mut schema: Value = serde_json::from_str(schema).unwrap();
        // What the extension refers to is in other files; here only that a textureInfo has an index.
        schema.as_object_mut().unwrap().remove("allOf");
        for key in ["absorptionTexture", "scatteringTexture"] {
            schema["properties"][key] = json!({ "type": "object", "required": ["index"], "properties": { "index": { "type": "integer", "minimum": 0 } } });
        }
        let validator = jsonschema::validator_for(&schema).unwrap();
        let good = json!({ "absorptionCoefficient": [0, 1.5, 1e9], "scatteringCoefficient": [1, 2, 3], "scatterAnisotropy": -0.99,
            "ior": 1, "densityFactor": 0, "priority": -3, "absorptionTexture": { "index": 0 }, "extras": 5 });
        assert!(violations(&good).is_empty() && validator.is_valid(&good));
        for (key, wrong, at) in [
            ("absorptionCoefficient", json!([1, -1, 2]), "/absorptionCoefficient/1"),
            ("scatteringCoefficient", json!([1, 2]), "/scatteringCoefficient"),
            ("scatteringCoefficient", json!(3), "/scatteringCoefficient"),
            ("scatterAnisotropy", json!(1), "/scatterAnisotropy"),
            ("scatterAnisotropy", json!("0"), "/scatterAnisotropy"),
            ("ior", json!(0.99), "/ior"),
            ("densityFactor", json!(-0.1), "/densityFactor"),
            ("priority", json!(1.5), "/priority"),
            ("priority", json!(3e9), "/priority"),
            ("scatteringTexture", json!({}), "/scatteringTexture"),
        ] {
            let mut bad = good.clone();
            bad[key] = wrong.clone();
            let found = violations(&bad);
            assert!(found.len() == 1 && found[0].0 == at, "{key} {wrong}: {found:?}");
            assert!(!validator.is_valid(&bad), "{key} {wrong}");
        }
    }
}
