//! Files that are either whole or not there.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::film::FilmError;

/// Replaces the file at `path` by `bytes`: they are written beside it, synced, and renamed into place, so that a
/// reader never sees half a picture and a failure leaves an existing file as it was.
///
/// A symbolic link is followed. What is neither a file nor a directory (a pipe, a device) is written to directly.
///
/// # Errors
/// [`FilmError::Write`] with the system's reason; nothing is left behind.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FilmError> {
    replace(path, |file| file.write_all(bytes))
        .map_err(|cause| FilmError::Write { path: path.to_owned(), cause })
}

fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let target = match path.canonicalize() {
        Ok(target) => target,
        Err(error) if error.kind() == io::ErrorKind::NotFound => path.to_owned(),
        Err(error) => return Err(error),
    };
    match target.metadata() {
        Ok(metadata) if metadata.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if !metadata.is_file() => return write(&mut File::options().write(true).open(target)?),
        _ => {}
    }
    let beside = beside(&target);
    let written = File::create(&beside).and_then(|mut file| {
        write(&mut file)?;
        file.sync_all()
    });
    let replaced = written.and_then(|()| std::fs::rename(&beside, &target));
    if replaced.is_err() {
        // The first error is the one to report; the file may not even have come into being.
        let _ = std::fs::remove_file(&beside);
    }
    replaced
}

/// `picture.exr` becomes `picture.exr.tmp-PID` in the same directory, since a rename works within one file system only.
fn beside(path: &Path) -> PathBuf {
    let mut name: OsString = path.as_os_str().to_owned();
    name.push(format!(".tmp-{}", std::process::id()));
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk that fills up half-way, made from the one device that always reports it.
    fn write_until_full(file: &mut File) -> io::Result<()> {
        file.write_all(b"the first half")?;
        File::options().write(true).open("/dev/full")?.write_all(b"the second")
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn r04_full_disk_keeps_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        std::fs::write(&path, b"the good old file").unwrap();
        let error = replace(&path, write_until_full).unwrap_err();
        assert_eq!(error.raw_os_error(), Some(28));
        assert_eq!(std::fs::read(&path).unwrap(), b"the good old file");
        let names: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(names, ["picture.exr"]);
    }
}
