use super::*;
use serde_json::json;

const ODD: &str = "  {\n\t\"a\" : [1.0,1e-7 , -0.0,12345678901234567890],\"\\u0062\":{ } ,\n\"c\":[ ],\"t\":\"q\\\"{\"  }\n";

#[test]
fn what_is_not_touched_is_printed_to_the_byte() {
    for text in [ODD, "{}", " [ ] ", "{\"a\":{\"a\":[[[0]]]}}"] {
        assert_eq!(Tree::parse(text).unwrap().to_string(), text);
    }
    for wrong in
        ["", "{", "{\"a\"}", "[1,]", "{\"a\":1,}", "[1 2]", "nul", "{}x", "\"", "\"\\", "01", "{1:2}"]
    {
        assert!(Tree::parse(wrong).is_err(), "{wrong}");
    }
    assert!(Tree::parse(&"[".repeat(100_000)).is_err());
}

#[test]
fn members_are_set_and_removed_without_moving_the_others() {
    let mut tree = Tree::parse(ODD).unwrap();
    let root = tree.root_mut();
    root.set("a", &json!([1, 1e-7, 0.0, 12345678901234567890u64]));
    assert!(tree.to_string() == ODD, "the same values keep their spelling");
    tree.root_mut().set("b", &json!({ "x": 2.5 }));
    assert!(tree.to_string().contains("\"\\u0062\":{\"x\":2.5} ,"), "{tree}");
    tree.root_mut().set("new", &json!([1.0, 0.5]));
    assert!(tree.to_string().ends_with("\"t\":\"q\\\"{\",\"new\":[1,0.5]  }\n"), "{tree}");
    assert!(tree.root_mut().remove("a") && !tree.root_mut().remove("a"));
    assert!(tree.to_string().starts_with("  {\n\t\"\\u0062\""), "{tree}");
    assert!(tree.root_mut().remove("new"));
    assert!(tree.to_string().ends_with("\"t\":\"q\\\"{\"  }\n"), "{tree}");
}

#[test]
fn new_members_look_like_their_neighbours() {
    let text = "{\n  \"materials\": [\n    {\n      \"name\": \"x\"\n    }\n  ]\n}";
    let mut tree = Tree::parse(text).unwrap();
    let material = tree.root_mut().get_mut("materials").unwrap().item_mut(0).unwrap();
    material.set("extensions", &json!({ "E": { "v": [1, 2.5], "w": 1e-7 } }));
    let expected = "      \"name\": \"x\",\n      \"extensions\": {\n        \"E\": {\n          \"v\": [1, 2.5],\n          \
                    \"w\": 1e-7\n        }\n      }\n    }";
    assert!(tree.to_string().contains(expected), "{tree}");
    let mut tree = Tree::parse("{\"a\":[\"x\",\"y\"]}").unwrap();
    let list = tree.root_mut().get_mut("a").unwrap();
    list.push(&json!("z"));
    assert!(list.has_string("z") && list.remove_string("x"));
    tree.root_mut().set("o", &json!({ "p": 1, "q": [1, 2] }));
    assert_eq!(tree.to_string(), "{\"a\":[\"y\",\"z\"],\"o\":{\"p\":1,\"q\":[1,2]}}");
}

#[test]
fn of_equal_keys_the_last_counts() {
    let mut tree = Tree::parse("{\"a\":1,\"a\":2}").unwrap();
    assert_eq!(tree.root().get("a").unwrap().value(), Some(json!(2)));
    assert!(tree.root_mut().remove("a"));
    assert_eq!(tree.to_string(), "{}");
}

#[test]
fn a_member_that_is_null_is_absent_and_is_filled_in_its_place() {
    let text = r#"{"a": null, "b": {"c": null, "d": [null, 1]}}"#;
    let mut tree = Tree::parse(text).unwrap();
    assert!(tree.root().get("a").is_none());
    assert_eq!(tree.root().value(), Some(json!({"b": {"d": [null, 1]}})));
    assert_eq!(tree.to_string(), text);
    tree.root_mut().object_mut("a").unwrap().set("x", &json!(1));
    let back: Value = serde_json::from_str(&tree.to_string()).unwrap();
    assert_eq!(back, json!({"a": {"x": 1}, "b": {"c": null, "d": [null, 1]}}));
}
