//! The document that a path means: the file itself, or the one in a folder.

use std::path::{Path, PathBuf};

use super::error::AssetError;
use super::spelling::{Twin, twin};

/// Names of files that a message lists.
const MOST_NAMED: usize = 8;

/// The path itself, or, of a folder, the only `.gltf` or `.glb` file directly in it. Where a folder has the same model
/// as both, the `.glb` is taken: it is complete in itself. A path that is not there may be there with its letters composed
/// otherwise.
pub(crate) fn document_in(path: &Path) -> Result<PathBuf, AssetError> {
    if !path.is_dir() {
        if path.symlink_metadata().is_ok() {
            return Ok(path.to_owned());
        }
        return match twin(Path::new(""), path) {
            Some(Twin::Composition(there)) => document_in(&there),
            Some(Twin::Case(there)) => Err(AssetError::Container {
                message: format!("{}: there is no such file", path.display()),
                advice: Some(format!("{} is there, which differs in case", there.display())),
            }),
            None => Ok(path.to_owned()),
        };
    }
    let found = listed(path)?;
    match &found[..] {
        [only] => Ok(only.clone()),
        [glb, gltf] if glb.file_stem() == gltf.file_stem() => Ok(glb.clone()),
        several => {
            let names = several.iter().take(MOST_NAMED).filter_map(|p| p.file_name());
            let mut names: Vec<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
            if several.len() > MOST_NAMED {
                names.push(format!("and {} more", several.len() - MOST_NAMED));
            }
            Err(AssetError::Container {
                message: format!("{} holds several glTF files: {}", path.display(), names.join(", ")),
                advice: Some("name one of them".to_owned()),
            })
        }
    }
}

/// The path itself, or, of a folder, all `.gltf` and `.glb` files directly in it, by name; at least one.
pub(crate) fn documents_in(path: &Path) -> Result<Vec<PathBuf>, AssetError> {
    if path.is_dir() { listed(path) } else { Ok(vec![path.to_owned()]) }
}

/// The `.gltf` and `.glb` files directly in a folder, `.glb` before `.gltf` of the same name.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, AssetError> {
    let io = |source| AssetError::Io { pointer: String::new(), path: folder.to_owned(), source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let file = entry.map_err(io)?.path();
        let extension = file.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if matches!(extension.as_deref(), Some("gltf" | "glb")) && !file.is_dir() {
            found.push(file);
        }
    }
    if found.is_empty() {
        return Err(AssetError::Container {
            message: format!("{} holds no .gltf or .glb file", folder.display()),
            advice: Some("name the file itself; folders below are not searched".to_owned()),
        });
    }
    // `.glb` sorts before `.gltf`, whatever else begins with the same letters.
    found.sort_by(|a, b| (a.file_stem(), a).cmp(&(b.file_stem(), b)));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_means_its_only_document() {
        let folder = tempfile::tempdir().expect("a folder");
        let add = |name: &str| std::fs::write(folder.path().join(name), "").expect("a file");
        let found = || {
            let path = document_in(folder.path()).map_err(|e| e.to_string())?;
            Ok::<_, String>(path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default())
        };
        assert!(found().is_err_and(|e| e.contains("no .gltf or .glb")));
        add("readme.txt");
        add("a.gltf");
        assert_eq!(found().as_deref(), Ok("a.gltf"));
        add("a.GLB");
        assert_eq!(found().as_deref(), Ok("a.GLB"));
        add("b.glb");
        assert!(found().is_err_and(|e| ["a.gltf", "a.GLB", "b.glb"].iter().all(|n| e.contains(n))));
        assert_eq!(document_in(Path::new("no/such.glb")).ok(), Some("no/such.glb".into()));
    }
}
