//! All cases of a folder, and choosing among them.

use super::{Case, ConformanceError};
use std::path::{Path, PathBuf};

/// The cases of a folder, in the order of their names.
#[derive(Clone, Debug)]
pub struct Suite {
    /// The folder.
    pub folder: PathBuf,
    /// At least one.
    pub cases: Vec<Case>,
}

impl Suite {
    /// Reads all folders with an `expect.toml` whose name matches one of `filters`, or all if there are no filters. A
    /// filter with `*` or `?` is held against the whole name, another one against any part of it. A folder that is
    /// itself a case is a suite of one.
    pub fn load(folder: &Path, filters: &[String]) -> Result<Self, ConformanceError> {
        let failed = |source| ConformanceError::Io { path: folder.to_owned(), source };
        let is_case = |path: &Path| path.join("expect.toml").is_file();
        let mut folders: Vec<PathBuf> = Vec::new();
        if is_case(folder) {
            folders.push(folder.canonicalize().map_err(failed)?);
        } else {
            for entry in std::fs::read_dir(folder).map_err(failed)? {
                folders.push(entry.map_err(failed)?.path());
            }
            folders.retain(|path| is_case(path));
        }
        let empty = |message: String| ConformanceError::Empty { path: folder.to_owned(), message };
        if folders.is_empty() {
            return Err(empty("there are no cases here (folders with an expect.toml)".to_owned()));
        }
        folders.sort();
        let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        folders.retain(|path| filters.is_empty() || filters.iter().any(|f| matches(f, &name(path))));
        if folders.is_empty() {
            return Err(empty(format!("no case is called {}", filters.join(" or "))));
        }
        let cases = folders.iter().map(|path| Case::load(path)).collect::<Result<_, _>>()?;
        Ok(Self { folder: folder.to_owned(), cases })
    }
}

/// Whether a name matches a filter.
fn matches(filter: &str, name: &str) -> bool {
    if filter.contains(['*', '?']) {
        let (filter, name): (Vec<char>, Vec<char>) = (filter.chars().collect(), name.chars().collect());
        glob(&filter, &name)
    } else {
        name.contains(filter)
    }
}

/// Whether a pattern matches all of a name: `*` stands for any characters, `?` for one. Linear in time but for going back
/// to the last star.
fn glob(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    let mut back: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                back = Some((p, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => {
                p += 1;
                n += 1;
            }
            _ => match back {
                Some((star, from)) => {
                    back = Some((star, from + 1));
                    p = star + 1;
                    n = from + 1;
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_parts_of_names_or_patterns() {
        for (filter, name, expected) in [
            ("ior", "ior-150", true),
            ("150", "ior-150", true),
            ("ior*", "ior-150", true),
            ("*150", "ior-150", true),
            ("i?r-*", "ior-150", true),
            ("or*", "ior-150", false),
            ("ior-15?", "ior-15", false),
            ("*a*b*", "xxaxbxab", true),
            ("*a*b", "xxaxbxa", false),
            ("**", "", true),
            ("?", "", false),
        ] {
            assert_eq!(matches(filter, name), expected, "{filter} {name}");
        }
    }

    #[test]
    fn a_folder_without_cases_is_an_error() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let message = Suite::load(folder.path(), &[]).expect_err("is empty").to_string();
        assert!(message.contains("no cases"), "{message}");
        assert!(matches!(Suite::load(Path::new("/no/such"), &[]), Err(ConformanceError::Io { .. })));
    }
}
