//! Files that appear complete or not at all: written under a temporary name beside the target, then renamed.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file through `fill`; only if that succeeds does it take the name `path`, in one step. A file that was
/// there before stays as it was until then. Symbolic links are followed; devices and pipes, which cannot be
/// renamed onto, are written directly.
pub fn write_atomically<E: From<io::Error>>(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.metadata().is_ok_and(|m| !m.is_file() && !m.is_dir()) {
        let mut device = std::fs::OpenOptions::new().write(true).open(&target)?;
        return fill(&mut device);
    }
    let mut file = BufWriter::new(temporary_beside(&target)?);
    fill(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.persist(&target).map_err(|failed| failed.error)?;
    Ok(())
}

/// Checks, by creating and removing a temporary file, that a file of that name could be written.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    match target.metadata() {
        Ok(found) if found.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")),
        Ok(found) if !found.is_file() => std::fs::OpenOptions::new().write(true).open(&target).map(|_| ()),
        _ => temporary_beside(&target).map(|_| ()),
    }
}

/// The directory a file of that path lies in.
pub fn directory_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".nephrite-").suffix(".tmp");
    // Temporary files are private by default; a picture gets what the umask allows, like any other new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(directory_of(target)).map_err(without_path)
}

/// The system's own error, without the temporary name that nobody asked for.
fn without_path(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(std::error::Error::source);
    let code = inner.and_then(|e| e.downcast_ref::<io::Error>()).and_then(io::Error::raw_os_error);
    code.map_or(error, io::Error::from_raw_os_error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_debris() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        std::fs::write(&path, "good").unwrap();
        let failed: io::Result<()> = write_atomically(&path, |out| {
            out.write_all(b"half a pic")?;
            Err(io::Error::other("disk on fire"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "disk on fire");
        assert_eq!(std::fs::read(&path).unwrap(), b"good");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

        let written: io::Result<()> = write_atomically(&path, |out| out.write_all(b"better"));
        written.unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"better");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_directory_that_does_not_exist_cannot_be_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nowhere").join("a.png");
        assert_eq!(check_writable(&missing).unwrap_err().kind(), io::ErrorKind::NotFound);
        assert_eq!(check_writable(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        check_writable(&folder.path().join("a.png")).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn pictures_are_as_readable_as_other_files_and_links_are_followed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, picture, link) =
            (folder.path().join("plain"), folder.path().join("picture"), folder.path().join("link"));
        std::fs::write(&plain, "x").unwrap();
        std::fs::write(&picture, "x").unwrap();
        std::fs::remove_file(&picture).unwrap();
        let first: io::Result<()> = write_atomically(&picture, |out| out.write_all(b"1"));
        first.unwrap();
        let mode = |p: &Path| p.metadata().unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&picture), mode(&plain));

        std::os::unix::fs::symlink(&picture, &link).unwrap();
        let second: io::Result<()> = write_atomically(&link, |out| out.write_all(b"2"));
        second.unwrap();
        assert!(link.symlink_metadata().unwrap().file_type().is_symlink());
        assert_eq!(std::fs::read(&picture).unwrap(), b"2");
    }
}
