//! Names that are the same to people and not to a file system.
//!
//! One letter with an accent may be one code point or two (Unicode's NFC and NFD). Some systems and archivers turn one
//! into the other, and then a document names a file that is there, but not by these bytes: it is found all the same. Names
//! that differ in case are different files, and most likely a mistake: they are pointed out and not opened.

use std::path::{Component, Path, PathBuf};

use unicode_normalization::UnicodeNormalization;

/// A file whose name differs from the one that was looked for.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Twin {
    /// Only in how letters with marks are composed.
    Composition(PathBuf),
    /// In case.
    Case(PathBuf),
}

/// Looks for the twin of a path below `base` that is not there, part by part. Of several, the first by their bytes.
pub(super) fn twin(base: &Path, path: &Path) -> Option<Twin> {
    let below = path.strip_prefix(base).unwrap_or(path);
    let mut found = if below == path { PathBuf::new() } else { base.to_owned() };
    let mut same_case = true;
    for part in below.components() {
        let next = found.join(part);
        let Component::Normal(name) = part else {
            found = next;
            continue;
        };
        if next.symlink_metadata().is_ok() {
            found = next;
            continue;
        }
        let name = name.to_str()?;
        let folder = if found.as_os_str().is_empty() { Path::new(".") } else { &found };
        let entries =
            std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut close: Vec<(bool, String)> = entries
            .filter(|entry| caseless(entry).eq(caseless(name)))
            .map(|entry| (entry.nfc().ne(name.nfc()), entry))
            .collect();
        close.sort();
        let (differs, entry) = close.into_iter().next()?;
        same_case &= !differs;
        found.push(entry);
    }
    let twin = if same_case { Twin::Composition } else { Twin::Case };
    found.exists().then(|| twin(found))
}

fn caseless(name: &str) -> impl Iterator<Item = char> {
    name.nfd().flat_map(char::to_lowercase)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_may_each_be_written_otherwise() {
        let folder = tempfile::tempdir().expect("a folder");
        // é and ü: composed in the name of the folder, taken apart in that of the file.
        let there = folder.path().join("t\u{e9}x").join("mu\u{308}ll.png");
        std::fs::create_dir(there.parent().expect("a folder")).expect("a folder");
        std::fs::write(&there, "").expect("a file");
        let look = |path: &str| twin(folder.path(), &folder.path().join(path));
        for same in ["te\u{301}x/m\u{fc}ll.png", "t\u{e9}x/m\u{fc}ll.png", "te\u{301}x/mu\u{308}ll.png"] {
            assert_eq!(look(same), Some(Twin::Composition(there.clone())), "{same}");
        }
        for case in ["T\u{e9}x/mu\u{308}ll.png", "te\u{301}x/M\u{dc}LL.PNG"] {
            assert_eq!(look(case), Some(Twin::Case(there.clone())), "{case}");
        }
        for other in ["tex/mu\u{308}ll.png", "t\u{e9}x/mull.png", "t\u{e9}x/mu\u{308}ll.png/x", "x"] {
            assert_eq!(look(other), None, "{other}");
        }
        // A name that is there in the right case comes before others.
        std::fs::write(folder.path().join("t\u{e9}x/M\u{fc}ll.png"), "").expect("a file");
        assert_eq!(look("t\u{e9}x/m\u{fc}ll.png"), Some(Twin::Composition(there)));
    }
}
