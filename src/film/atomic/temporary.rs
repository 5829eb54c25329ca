//! Files without a name of their own yet. They are known to the whole process, so that one that is told to stop can take
//! them with it.

use super::{Target, directory_of};
use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use tempfile::NamedTempFile;

/// Files that are being written.
static WRITING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn writing() -> MutexGuard<'static, Vec<PathBuf>> {
    WRITING.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Removes every temporary file, for a process that ends without finishing what it writes.
pub fn remove_temporaries() {
    for path in writing().drain(..) {
        // There is nobody left who could do something about a file that stays.
        let _ = std::fs::remove_file(path);
    }
}

/// A file that is removed unless it takes the place of another.
pub(super) struct Temporary {
    file: NamedTempFile,
}

impl Temporary {
    /// Creates one in the folder of the target.
    pub fn beside(target: &Target) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        // A new picture gets what the umask allows, like any other new file; one that replaces another is nobody's
        // business until it has the permissions of that.
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(
            &mut options,
            match target.found {
                Some(_) => 0o600,
                None => 0o666,
            },
        );
        // The system's own error, without the temporary name that nobody asked for.
        let code = Cell::new(None);
        let open = |path: &Path| options.open(path).inspect_err(|error| code.set(error.raw_os_error()));
        // Under the lock, so that none is created after all have been removed.
        let mut writing = writing();
        let file = tempfile::Builder::new()
            .prefix(".nephrite-")
            .suffix(".tmp")
            .make_in(directory_of(&target.path), open)
            .map_err(|error| code.get().map_or(error, io::Error::from_raw_os_error))?;
        writing.push(file.path().to_owned());
        Ok(Self { file })
    }

    /// Takes the place of the target, once everything is on the disk: after a power failure there is the old file or the
    /// new one.
    pub fn replace(self, target: &Target) -> io::Result<()> {
        keep_properties(self.file.as_file(), target);
        self.file.as_file().sync_all()?;
        let replaced = if target.has_other_names() {
            overwrite(self.file.path(), &target.path)
        } else {
            std::fs::rename(self.file.path(), &target.path)
        };
        if let Err(error) = replaced {
            return Err(self.kept(error));
        }
        // Not every file system knows how to; the file is there.
        let _ = File::open(directory_of(&target.path)).and_then(|folder| folder.sync_all());
        Ok(())
    }

    /// What is complete is not thrown away for a name that cannot be had.
    fn kept(mut self, error: io::Error) -> io::Error {
        self.file.disable_cleanup(true);
        let path = self.file.path().display();
        io::Error::new(error.kind(), format!("{error}; it was kept as {path}"))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        writing().retain(|path| path != self.file.path());
    }
}

impl Write for Temporary {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

/// The owner, the group and the permissions of what is replaced, as far as this process may give them.
#[cfg(unix)]
fn keep_properties(file: &File, target: &Target) {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let (Some(old), Ok(new)) = (&target.found, file.metadata()) else { return };
    // Only root may give files away; others may choose among their groups.
    if (old.uid(), old.gid()) != (new.uid(), new.gid())
        && fchown(file, Some(old.uid()), Some(old.gid())).is_err()
    {
        let _ = fchown(file, None, Some(old.gid()));
    }
    // Last, since giving files away takes bits from them.
    let _ = file.set_permissions(PermissionsExt::from_mode(old.mode() & 0o7777));
}

#[cfg(not(unix))]
fn keep_properties(file: &File, target: &Target) {
    if let Some(old) = &target.found {
        let _ = file.set_permissions(old.permissions());
    }
}

/// Gives a file the content of another one, which is removed then.
fn overwrite(from: &Path, to: &Path) -> io::Result<()> {
    let mut target = OpenOptions::new().write(true).truncate(true).open(to)?;
    io::copy(&mut File::open(from)?, &mut target)?;
    target.sync_all()?;
    // It is complete under its own name; what stays is only in the way.
    let _ = std::fs::remove_file(from);
    Ok(())
}
