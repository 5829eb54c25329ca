//! Loads every glTF file below the given paths and prints what became of each: `ok`, `warn` or `error`.
//!
//! ```sh
//! cargo run --release --example load_check -- PATH...
//! ```

use std::path::{Path, PathBuf};
use std::time::Instant;

use nephrite::asset::{LoadOptions, Severity, load};

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if let Ok(entries) = std::fs::read_dir(path) {
        let mut entries: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
        entries.sort();
        for entry in entries {
            collect(&entry, files);
        }
    } else if path.extension().is_some_and(|e| e == "glb" || e == "gltf") {
        files.push(path.to_owned());
    }
}

fn main() {
    let mut files = Vec::new();
    let verbose = std::env::args().any(|a| a == "-v");
    for argument in std::env::args().skip(1).filter(|a| a != "-v") {
        collect(Path::new(&argument), &mut files);
    }
    let options = LoadOptions::default();
    for file in files {
        let start = Instant::now();
        let result = load(&file, &options);
        let seconds = start.elapsed().as_secs_f64();
        let name = file.display();
        match result {
            Ok(loaded) => {
                let warned = loaded.diagnostics.iter().any(|d| d.severity >= Severity::Warning);
                let outcome = if warned { "warn" } else { "ok" };
                let s = &loaded.summary;
                println!("{outcome}\t{seconds:.2}\t{name}\t{} triangles", s.instanced_triangles);
                for diagnostic in loaded.diagnostics.iter().filter(|_| verbose) {
                    println!("\t{:?} {diagnostic}", diagnostic.severity);
                }
            }
            Err(error) => println!("error\t{seconds:.2}\t{name}\t{error}"),
        }
    }
}
