//! A harness for the program as users have it: a temporary folder, the real binary, and failures that say what was
//! run and what came of it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A temporary folder in which the program runs.
pub struct Sandbox {
    folder: tempfile::TempDir,
}

/// What one run of the program came to.
pub struct Run {
    pub command: String,
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Sandbox {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Creates a file with that content.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("a writable temporary folder");
        path
    }

    /// Names of all files in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("a readable temporary folder");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_nephrite"));
        command.args(args).current_dir(self.folder.path()).stdin(Stdio::null()).env_remove("NO_COLOR");
        command
    }

    /// Runs `nephrite` with these arguments to its end.
    pub fn run(&self, args: &[&str]) -> Run {
        Run::new(args, self.command(args).output().expect("the program starts"))
    }
}

impl Run {
    pub fn new(args: &[&str], output: Output) -> Self {
        Self {
            command: format!("nephrite {}", args.join(" ")),
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Fails unless the program ended with that code.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        self.check(self.code == Some(code), &format!("should have ended with {code}"));
        self
    }

    /// Fails unless standard error contains every one of the texts.
    #[track_caller]
    pub fn says(self, texts: &[&str]) -> Self {
        for text in texts {
            self.check(self.stderr.contains(text), &format!("should have said {text:?} on standard error"));
        }
        self
    }

    #[track_caller]
    pub fn check(&self, ok: bool, complaint: &str) {
        let Self { command, code, stdout, stderr } = self;
        assert!(
            ok,
            "\n{command}\n{complaint}\n── exit code ──\n{code:?}\n── standard output ──\n{stdout}\n── standard error ──\n{stderr}"
        );
    }
}

/// A glTF file with one triangle in the plane z = 0, with data in the document; `more` is added to its top level, such
/// as `"materials": […],`.
pub fn triangle(more: &str) -> String {
    // Three positions as floats: (-1 -1 0), (1 -1 0), (0 1 0).
    let data = "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{ {more}
        "asset": {{ "version": "2.0" }},
        "scene": 0, "scenes": [{{ "nodes": [0] }}],
        "nodes": [{{ "mesh": 0, "name": "Triangle" }}],
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }} }}] }}],
        "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                         "min": [-1, -1, 0], "max": [1, 1, 0] }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
        "buffers": [{{ "byteLength": 36, "uri": "data:application/octet-stream;base64,{data}" }}] }}"#
    )
}

/// Channel `name` of an EXR file.
pub fn exr_channel(path: &Path, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_first_flat_layer_from_file(path).expect("a readable EXR");
    let list = image.layer_data.channel_data.list;
    let found = list.iter().find(|c| c.name.to_string() == name);
    found.unwrap_or_else(|| panic!("no channel {name}")).sample_data.values_as_f32().collect()
}

/// A glTF file of closed tetrahedra with edges of √2, one for each node, all of material 0; the buffer is beside the
/// document under the name that is given, or in it. `materials` and `nodes` are JSON arrays.
pub fn tetrahedra(materials: &str, nodes: &str, uri: Option<&str>) -> String {
    use base64::Engine;
    let uri = match uri {
        Some(uri) => uri.to_owned(),
        None => {
            let data = base64::engine::general_purpose::STANDARD.encode(tetrahedron_data());
            format!("data:application/octet-stream;base64,{data}")
        }
    };
    let count = serde_json::from_str::<Vec<serde_json::Value>>(nodes).expect("an array").len();
    let all: Vec<String> = (0..count).map(|i| i.to_string()).collect();
    format!(
        r#"{{
  "asset": {{ "version": "2.0" }},
  "scenes": [ {{ "nodes": [{}] }} ],
  "scene": 0,
  "nodes": {nodes},
  "materials": {materials},
  "meshes": [
    {{ "name": "Tetra", "primitives": [ {{ "attributes": {{ "POSITION": 0 }}, "indices": 1, "material": 0 }} ] }},
    {{ "name": "Open", "primitives": [ {{ "attributes": {{ "POSITION": 0 }}, "indices": 2, "material": 0 }} ] }}
  ],
  "accessors": [
    {{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5] }},
    {{ "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" }},
    {{ "bufferView": 1, "componentType": 5123, "count": 9, "type": "SCALAR" }}
  ],
  "bufferViews": [ {{ "buffer": 0, "byteLength": 48 }}, {{ "buffer": 0, "byteOffset": 48, "byteLength": 24 }} ],
  "buffers": [ {{ "byteLength": 72, "uri": "{uri}" }} ]
}}
"#,
        all.join(", ")
    )
}

/// The buffer of [`tetrahedra`].
pub fn tetrahedron_data() -> Vec<u8> {
    let corners = [[0.5f32, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];
    let faces = [[0u16, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    let positions = corners.iter().flatten().flat_map(|v| v.to_le_bytes());
    positions.chain(faces.iter().flatten().flat_map(|i| i.to_le_bytes())).collect()
}

/// The same file as GLB: the document, and the buffer as its binary chunk.
pub fn glb(document: &str) -> Vec<u8> {
    let mut json: serde_json::Value = serde_json::from_str(document).expect("JSON");
    if let Some(buffer) = json["buffers"][0].as_object_mut() {
        buffer.remove("uri");
    }
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let data = tetrahedron_data();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    let length = |n: usize| u32::try_from(n).expect("small").to_le_bytes();
    bytes.extend(length(12 + 8 + text.len() + 8 + data.len()));
    bytes.extend(length(text.len()));
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(length(data.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}
