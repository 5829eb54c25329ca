//! Files that a document gets beside it: names that are free, or whose files are the same already.

use super::Failure;
use crate::author::paint::images::NewImages;
use crate::film::atomic::directory_of;
use std::path::{Path, PathBuf};

/// As many names are tried.
const MOST_TRIED: usize = 1000;

/// A file to be written.
pub(super) struct NewFile {
    /// Its name, which is its URI too.
    pub name: String,
    pub path: PathBuf,
    pub bytes: Vec<u8>,
    /// Whether it is not there yet.
    pub is_new: bool,
}

/// The files of images, named after the document and the image.
pub(super) fn files(output: &Path, images: &NewImages) -> Result<Vec<NewFile>, Failure> {
    let folder = directory_of(output);
    let stem = output.file_stem().map(|stem| plain(&stem.to_string_lossy())).unwrap_or_default();
    let mut files: Vec<NewFile> = Vec::new();
    for (name, bytes) in images.list() {
        let base = plain(&format!("{stem}-{name}"));
        let found = (1..MOST_TRIED).find_map(|n| {
            let name = if n == 1 { format!("{base}.png") } else { format!("{base}-{n}.png") };
            // Some file systems do not tell cases apart.
            if files.iter().any(|file| file.name.eq_ignore_ascii_case(&name)) {
                return None;
            }
            let path = folder.join(&name);
            let is_new = std::fs::symlink_metadata(&path).is_err();
            let same = || std::fs::read(&path).is_ok_and(|there| there == *bytes);
            (is_new || same()).then(|| NewFile { name, bytes: bytes.clone(), is_new, path })
        });
        files.push(found.ok_or_else(|| {
            Failure::advise(
                format!("{}: all names are taken", folder.join(&base).display()),
                "write into an empty folder",
            )
        })?);
    }
    Ok(files)
}

/// Letters, digits and a few signs that mean the same in names of files and in URIs.
fn plain(text: &str) -> String {
    const LONGEST: usize = 80;
    let mut name = String::new();
    for c in text.chars().take(LONGEST) {
        match c {
            c if c.is_ascii_alphanumeric() || c == '_' => name.push(c),
            _ if name.ends_with('-') || name.is_empty() => {}
            _ => name.push('-'),
        }
    }
    name.trim_end_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain() {
        assert_eq!(plain("../Körper (1) absorption"), "K-rper-1-absorption");
        assert_eq!(plain("--a__b--"), "a__b");
        assert_eq!(plain("日本"), "");
    }
}
