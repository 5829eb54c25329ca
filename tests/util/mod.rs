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
