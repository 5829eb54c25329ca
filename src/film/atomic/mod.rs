//! Files that appear complete or not at all: written under a temporary name beside the target, then renamed.
//!
//! What a name leads to is decided in one place ([`Target`]): a file of its own, a file that has other names (which is
//! written in place, so that they keep showing it), or something that cannot be renamed onto, such as a pipe.

mod target;
mod temporary;

pub use target::{Identity, Target};
pub use temporary::remove_temporaries;

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use temporary::Temporary;

/// Writes a file through `fill`; only if that succeeds does it take the name `path`, in one step. A file that was
/// there before stays as it was until then, and its permissions, its owner where that is allowed, and its other names
/// are kept. Symbolic links are followed, also where they lead to nothing yet; devices and pipes, which cannot be
/// renamed onto, are written directly.
///
/// # Errors
/// Those of `fill` and of the file system. Where all but the last step succeeds, what was written is kept under its
/// temporary name, and the error says where.
pub fn write_atomically<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let target = Target::of(path)?;
    if target.is_stream() {
        let mut stream = BufWriter::new(target.open_stream()?);
        fill(&mut stream)?;
        stream.flush()?;
        return Ok(());
    }
    let mut file = BufWriter::new(Temporary::beside(&target)?);
    fill(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.replace(&target)?;
    Ok(())
}

/// Checks that a file of that name could be written: as far as that can be told without touching what is there, and by
/// creating and removing a temporary file beside it.
///
/// # Errors
/// What writing would fail with.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let target = Target::of(path)?;
    target.check()?;
    if target.is_stream() { Ok(()) } else { Temporary::beside(&target).map(drop) }
}

/// The directory a file of that path lies in.
pub fn directory_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests;
