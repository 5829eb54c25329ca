//! Files beside the document, and files that must not be opened.

use super::*;

/// A folder with `inside/scene.gltf` (written by `load_from`), two buffers inside, and one outside.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let inside = folder.path().join("inside");
    std::fs::create_dir_all(inside.join("sub")).expect("folders");
    let data = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    for name in ["inside/plain.bin", "inside/sub/büff er ❤.bin", "inside/a%20b#c.bin", "outside.bin"] {
        std::fs::write(folder.path().join(name), &data).expect("a file");
    }
    folder
}

fn load_from(folder: &Path, uri: &str, allow_outside: bool) -> Result<Loaded, AssetError> {
    let mut json = Builder::triangle().document();
    json["buffers"][0]["uri"] = json!(uri);
    let path = folder.join("inside/scene.gltf");
    std::fs::write(&path, json.to_string()).expect("a file");
    load(&path, &LoadOptions { allow_outside, ..LoadOptions::default() })
}

#[test]
fn files_in_the_folder_are_read() {
    let folder = folder();
    for (uri, clean) in [
        ("plain.bin", true),
        ("./sub/../plain.bin", true),
        ("sub/b%C3%BCff%20er%20%E2%9D%A4.bin", true),
        ("sub/büff er ❤.bin", true),
        ("a%2520b%23c.bin", true),
        ("a%20b#c.bin", false),
        ("plain.bin?version=3", false),
        ("sub\\..\\sub\\büff er ❤.bin", false),
    ] {
        let result = load_from(folder.path(), uri, false);
        if uri.contains("..\\") {
            assert!(result.is_err(), "{uri}");
            continue;
        }
        let loaded = result.unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(loaded.diagnostics.is_empty(), clean, "{uri}: {:?}", loaded.diagnostics);
    }
    let backslash = load_from(folder.path(), "sub\\büff er ❤.bin", false).expect("loads");
    assert!(told(&backslash, Severity::Warning, "/buffers/0/uri"));
}

#[test]
fn files_elsewhere_are_not_opened() {
    let folder = folder();
    let absolute = folder.path().join("outside.bin");
    let absolute = absolute.to_str().expect("a path");
    for uri in [
        "../outside.bin",
        "%2e%2e/outside.bin",
        "sub/../../outside.bin",
        "..\\outside.bin",
        absolute,
        &format!("file://{absolute}"),
        "http://localhost/plain.bin",
        "C:\\plain.bin",
        "/dev/zero",
        "a%00.bin",
        "",
        ".",
    ] {
        match load_from(folder.path(), uri, false) {
            Err(AssetError::Uri { pointer, .. }) => assert_eq!(pointer, "/buffers/0/uri", "{uri}"),
            other => panic!("{uri}: {other:?}"),
        }
    }
    for uri in ["../outside.bin", absolute, &format!("file://{absolute}")] {
        assert!(load_from(folder.path(), uri, true).is_ok(), "{uri}");
    }
    for uri in ["/dev/zero", "http://localhost/plain.bin", "."] {
        assert!(load_from(folder.path(), uri, true).is_err(), "{uri}");
    }
}

#[cfg(unix)]
#[test]
fn symbolic_links_do_not_lead_out() {
    let folder = folder();
    let link = folder.path().join("inside/link.bin");
    std::os::unix::fs::symlink(folder.path().join("outside.bin"), link).expect("a link");
    assert!(load_from(folder.path(), "link.bin", false).is_err());
    assert!(load_from(folder.path(), "link.bin", true).is_ok());
}

#[test]
fn data_uris() {
    let with = |uri: &str, length: usize| {
        let mut json = Builder::triangle().document();
        json["buffers"][0] = json!({"uri": uri, "byteLength": length});
        json["bufferViews"][0] = json!({"buffer": 0, "byteLength": length});
        json["accessors"][0] = json!({"bufferView": 0, "type": "VEC3", "componentType": F32, "count": 1});
        load_json(&json, &LoadOptions::default())
    };
    assert!(with("data:;base64,AAAAAAAAAAAAAAAA", 12).is_ok());
    assert!(with("DATA:application/gltf-buffer;BASE64,AAAA AAAA%0AAAAAAAAA", 12).is_ok());
    assert!(
        with("data:,%00%00%00%00%00%00%00%00%00%00%00%00", 12)
            .is_ok_and(|l| { told(&l, Severity::Warning, "/buffers/0/uri") })
    );
    for uri in ["data:;base64,AAAAA", "data:;base64,!!!!", "data:", "data:;base64,", "data:,"] {
        assert!(with(uri, 12).is_err(), "{uri}");
    }
}

#[test]
fn the_number_of_bytes_must_be_there() {
    let folder = folder();
    std::fs::write(folder.path().join("inside/short.bin"), [0; 35]).expect("a file");
    let message = load_from(folder.path(), "short.bin", false).expect_err("too short").to_string();
    assert_eq!(message, "/buffers/0/byteLength: 36 bytes are promised, but there are only 35");
    assert!(load_from(folder.path(), "missing.bin", false).is_err());
}

#[test]
fn names_are_found_in_either_composition_and_told_where_only_case_differs() {
    let folder = folder();
    // What macOS makes of the name: u and o with marks of their own.
    let apart = "inside/sub/u\u{308}ber o\u{308}l.bin";
    std::fs::copy(folder.path().join("inside/plain.bin"), folder.path().join(apart)).expect("a file");
    // Composed where the disk has it taken apart, percent-encoded or not; and the other way round.
    for uri in [
        "sub/\u{fc}ber \u{f6}l.bin",
        "sub/%C3%BCber%20%C3%B6l.bin",
        "sub/u\u{308}ber o\u{308}l.bin",
        "sub/bu\u{308}ff er \u{2764}.bin",
        "sub/bu%CC%88ff%20er%20%E2%9D%A4.bin",
    ] {
        let loaded = load_from(folder.path(), uri, false).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert!(loaded.diagnostics.is_empty(), "{uri}: {:?}", loaded.diagnostics);
    }
    for (uri, there) in [
        ("Plain.bin", "plain.bin"),
        ("plain.BIN?version=3", "plain.bin"),
        ("SUB/b%C3%BCff%20er%20%E2%9D%A4.bin", "sub/b\u{fc}ff er \u{2764}.bin"),
        ("sub/BU%CC%88FF%20er%20%E2%9D%A4.bin", "sub/b\u{fc}ff er \u{2764}.bin"),
    ] {
        let error = load_from(folder.path(), uri, false).expect_err("another file");
        assert_eq!(error.pointer(), "/buffers/0/uri");
        let advice = error.advice().unwrap_or_default();
        assert!(advice.contains(&format!("`{there}` is there")), "{uri}: {error} ({advice})");
    }
    // Outside of the folder nothing is looked for.
    std::fs::write(folder.path().join("\u{e9}.bin"), [0; 36]).expect("a file");
    assert!(matches!(load_from(folder.path(), "../e\u{301}.bin", false), Err(AssetError::Uri { .. })));
    assert!(load_from(folder.path(), "../e\u{301}.bin", true).is_ok());
}
