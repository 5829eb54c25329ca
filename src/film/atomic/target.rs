//! What a name leads to, and whether it could be replaced.

use super::directory_of;
use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

/// As many links may lead to one another; Linux follows as many.
const MOST_LINKS: usize = 40;

/// The end of the links that a name begins.
#[derive(Debug)]
pub struct Target {
    /// Where a file is or will be.
    pub path: PathBuf,
    /// What is there.
    pub found: Option<Metadata>,
    /// The name is one of an open file, as `/dev/stdout` is: what it leads to may be a file, but not one to be replaced.
    is_descriptor: bool,
}

/// What tells files apart, whatever they are called.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Identity {
    /// Device and number of a file that is there.
    File(u64, u64),
    /// The folder and the name of one that is not, or of any where the system has no numbers.
    Name(PathBuf),
}

impl Target {
    /// Follows links to their end, whether or not there is something.
    ///
    /// # Errors
    /// Names of folders, names that the system does not take, and links that lead in a circle.
    pub fn of(path: &Path) -> io::Result<Self> {
        if ends_with_separator(path) || path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is the name of a directory"));
        }
        let mut target = path.to_owned();
        let mut is_descriptor = false;
        for _ in 0..MOST_LINKS {
            is_descriptor |= names_a_descriptor(&target);
            match std::fs::symlink_metadata(&target) {
                // A link in /proc says what it leads to in words that are no path (`pipe:[123]`).
                Ok(found) if found.is_symlink() && is_descriptor => {
                    let found = optional(std::fs::metadata(&target))?;
                    return Ok(Self { path: target, found, is_descriptor });
                }
                Ok(found) if found.is_symlink() => {
                    let to = std::fs::read_link(&target)?;
                    target = directory_of(&target).join(to);
                }
                found => return Ok(Self { path: target, found: optional(found)?, is_descriptor }),
            }
        }
        Err(io::Error::other("too many symbolic links lead to one another"))
    }

    /// Whether it is written directly: what is no file, and what another program has opened for this one.
    pub fn is_stream(&self) -> bool {
        self.is_descriptor || self.found.as_ref().is_some_and(|found| !found.is_file() && !found.is_dir())
    }

    /// Opens what is written directly. A file behind a descriptor may have a beginning that is to stay.
    pub(super) fn open_stream(&self) -> io::Result<File> {
        OpenOptions::new().append(true).open(&self.path)
    }

    /// Whether it has names besides this one, which replacing it would leave with what was there before.
    pub(super) fn has_other_names(&self) -> bool {
        #[cfg(unix)]
        let links = self.found.as_ref().map_or(1, std::os::unix::fs::MetadataExt::nlink);
        #[cfg(not(unix))]
        let links = 1;
        links > 1
    }

    /// What tells this file from others; `None` for what is no file, where several may write.
    pub fn identity(&self) -> Option<Identity> {
        if self.is_stream() {
            return None;
        }
        #[cfg(unix)]
        if let Some(found) = &self.found {
            use std::os::unix::fs::MetadataExt;
            return Some(Identity::File(found.dev(), found.ino()));
        }
        let folder = directory_of(&self.path);
        let folder = folder.canonicalize().unwrap_or(folder);
        Some(Identity::Name(folder.join(self.path.file_name()?)))
    }

    /// Whether it could be replaced, as far as that can be told without opening it: a pipe that is opened and closed
    /// has told its reader that all is over.
    pub(super) fn check(&self) -> io::Result<()> {
        let Some(found) = &self.found else { return Ok(()) };
        if found.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        self.check_access()?;
        self.check_sticky(found)
    }

    #[cfg(unix)]
    fn check_access(&self) -> io::Result<()> {
        use nix::{errno::Errno, unistd};
        match unistd::access(&self.path, unistd::AccessFlags::W_OK) {
            // Whoever may write into the folder may replace a file that he may not write to, unless it is immutable or
            // has other names.
            Err(Errno::EACCES) if !self.is_stream() && !self.has_other_names() => Ok(()),
            other => other.map_err(io::Error::from),
        }
    }

    #[cfg(not(unix))]
    fn check_access(&self) -> io::Result<()> {
        Ok(())
    }

    /// In a sticky folder, such as `/tmp`, a file is replaced only by its owner, the folder's, and root.
    #[cfg(unix)]
    fn check_sticky(&self, found: &Metadata) -> io::Result<()> {
        use std::os::unix::fs::MetadataExt;
        const STICKY: u32 = 0o1000;
        let folder = directory_of(&self.path).metadata()?;
        let me = nix::unistd::geteuid().as_raw();
        let may = me == 0 || found.uid() == me || folder.uid() == me;
        if self.is_stream() || self.has_other_names() || folder.mode() & STICKY == 0 || may {
            return Ok(());
        }
        let text = "it belongs to somebody else, and the folder lets only owners replace files";
        Err(io::Error::new(io::ErrorKind::PermissionDenied, text))
    }

    #[cfg(not(unix))]
    fn check_sticky(&self, _: &Metadata) -> io::Result<()> {
        Ok(())
    }
}

/// `None` for what is not there; other errors, such as a name that is too long, are errors.
fn optional(found: io::Result<Metadata>) -> io::Result<Option<Metadata>> {
    match found {
        Ok(found) => Ok(Some(found)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// `Path` forgets separators at the end.
fn ends_with_separator(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| std::path::is_separator(char::from(byte)))
}

/// Whether a path is that of a file that is open: `/dev/stdout`, `/dev/fd/3`, `/proc/self/fd/3`.
fn names_a_descriptor(path: &Path) -> bool {
    let folder = path.parent().unwrap_or(path);
    let of_process = folder.starts_with("/proc") && folder.file_name().is_some_and(|name| name == "fd");
    let of_device = path == Path::new("/dev/stdout") || path == Path::new("/dev/stderr");
    cfg!(unix) && (of_process || of_device || folder == Path::new("/dev/fd"))
}
