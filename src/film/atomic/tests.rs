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
