//! Every value of a document that has something of everything, replaced by every odd one.

use std::path::Path;

use nephrite::asset::{Asset, LoadOptions, Moment};
use serde_json::{Value, json};

use super::{bounded, corpus, fuzzing};

fn pointers(value: &Value, here: String, all: &mut Vec<String>) {
    match value {
        Value::Object(o) => o.iter().for_each(|(k, v)| pointers(v, format!("{here}/{k}"), all)),
        Value::Array(a) => a.iter().enumerate().for_each(|(i, v)| pointers(v, format!("{here}/{i}"), all)),
        _ => {}
    }
    all.push(here);
}

#[test]
fn any_value_anywhere_ends_well() {
    let everything = corpus("loader").into_iter().find(|(name, _)| name.ends_with("everything.gltf"));
    let everything = everything.expect("it is there").1;
    let mut asset =
        Asset::from_bytes(everything.clone(), Path::new(""), &LoadOptions::default()).expect("it opens");
    let loaded = asset.load(&Moment::default()).expect("the unaltered document loads");
    let animation = &loaded.summary.animations[0];
    assert_eq!((animation.channels, animation.ignored), (4, 0), "{:?}", loaded.diagnostics);
    let good: Value = serde_json::from_slice(&everything).expect("it is JSON");
    let mut all = Vec::new();
    pointers(&good, String::new(), &mut all);
    let odd = [
        Value::Null,
        json!(true),
        json!(-1),
        json!(0),
        json!(2.5),
        json!(1e300),
        json!(u64::MAX),
        json!(4_294_967_295_u64),
        json!("../../odd"),
        json!([]),
        json!([[[]]]),
        json!([1e39, -1e39, 0, 1]),
        json!({}),
    ];
    for pointer in &all {
        for value in &odd {
            let mut json = good.clone();
            *json.pointer_mut(pointer).expect("it is there") = value.clone();
            let bytes = json.to_string().into_bytes();
            bounded(pointer, || fuzzing::loader(&bytes));
        }
    }
}
