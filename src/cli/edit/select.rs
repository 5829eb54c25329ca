//! Materials by name, by index, or all.

use crate::cli::{Failure, names};
use serde_json::Value;

/// Indices of the materials that are asked for, ascending.
pub(super) fn materials(document: &Value, wanted: &[String]) -> Result<Vec<usize>, Failure> {
    let all = document.get("materials").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let name = |material: &Value| material.get("name").and_then(Value::as_str).map(str::to_owned);
    let mut chosen = Vec::new();
    for wanted in wanted {
        if wanted == "*" {
            chosen.extend(0..all.len());
            continue;
        }
        let named: Vec<usize> = (0..all.len()).filter(|&i| name(&all[i]).as_ref() == Some(wanted)).collect();
        let index = || wanted.parse().ok().filter(|&i: &usize| i < all.len());
        match (named.is_empty(), index()) {
            (false, _) => chosen.extend(named),
            (true, Some(index)) => chosen.push(index),
            (true, None) if all.is_empty() => {
                return Err(Failure::advise(
                    "the file has no materials",
                    "give its meshes a material first: without one there is nothing that could hold a medium",
                ));
            }
            (true, None) => {
                let known: Vec<String> = all.iter().filter_map(name).collect();
                return Err(Failure::advise(
                    names::unknown("material", wanted, known.iter().map(String::as_str)),
                    format!("give a name, an index from 0 to {}, or * for all", all.len() - 1),
                ));
            }
        }
    }
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn names_come_before_indices() {
        let document = json!({ "materials": [{ "name": "1" }, {}, { "name": "x" }, { "name": "x" }] });
        let find = |wanted: &[&str]| {
            materials(&document, &wanted.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>()).ok()
        };
        assert_eq!(find(&["1"]), Some(vec![0]));
        assert_eq!(find(&["3", "x"]), Some(vec![2, 3]));
        assert_eq!(find(&["*"]), Some(vec![0, 1, 2, 3]));
        assert_eq!(find(&[]), Some(vec![]));
        assert!(find(&["4"]).is_none() && find(&["y"]).is_none());
        assert!(materials(&json!({}), &["0".to_owned()]).is_err());
    }
}
