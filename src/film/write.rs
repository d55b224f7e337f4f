//! Files that are either whole or not there.

use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher};
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
    write_atomic_with(path, |file| file.write_all(bytes))
}

/// As [`write_atomic`], by a function that writes the bytes one after the other.
///
/// # Errors
/// As [`write_atomic`].
pub fn write_atomic_with(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), FilmError> {
    replace(path, write).map_err(|cause| FilmError::Write { path: path.to_owned(), cause })
}

/// Removes what [`write_atomic`] has left beside `path` where its process was killed: for files that no other process
/// writes.
pub fn remove_leftovers(path: &Path) {
    let Ok(Target::File(target)) = target(path) else { return };
    let start = beside_start(&target);
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
    for entry in fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| name.starts_with(&start) && name.ends_with(".tmp")) {
            // It is in nobody's way.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Writes a file where there is none, not even a symbolic link: for folders that others write to as well.
///
/// # Errors
/// [`FilmError::Write`] with the system's reason; nothing is left behind.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<(), FilmError> {
    let written = File::create_new(path).and_then(|mut file| {
        let written = file.write_all(bytes).and_then(|()| file.sync_all());
        if written.is_err() {
            // The first error is the one to report.
            let _ = fs::remove_file(path);
        }
        written
    });
    written.map_err(|cause| FilmError::Write { path: path.to_owned(), cause })
}

/// Tries what [`write_atomic`] will do at `path`, but for the bytes: a file is made beside it and removed again. Nothing
/// is asked of a pipe or a device, which may not be opened twice.
///
/// # Errors
/// The system's reason why there can be no such file.
pub fn try_file(path: &Path) -> io::Result<()> {
    match target(path)? {
        Target::File(target) => create_beside(&target).and_then(|(_, beside)| fs::remove_file(beside)),
        Target::Other(_) => Ok(()),
    }
}

/// Tries to write files into a folder, which is made where it is missing; all of it is removed again.
///
/// # Errors
/// The system's reason why there can be no files.
pub fn try_folder(folder: &Path) -> io::Result<()> {
    let missing: Vec<&Path> =
        folder.ancestors().take_while(|part| !part.as_os_str().is_empty() && !part.exists()).collect();
    let tried = fs::create_dir_all(folder).and_then(|()| try_file(&folder.join("file")));
    for part in missing {
        // It is empty, unless others have found a use for it by now.
        let _ = fs::remove_dir(part);
    }
    tried
}

/// What a path leads to.
enum Target {
    /// A file, or a place for one.
    File(PathBuf),
    /// A pipe or a device.
    Other(PathBuf),
}

fn target(path: &Path) -> io::Result<Target> {
    let target = match path.canonicalize() {
        Ok(target) => target,
        Err(error) if error.kind() == io::ErrorKind::NotFound => path.to_owned(),
        Err(error) => return Err(error),
    };
    match target.metadata() {
        Ok(metadata) if metadata.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if !metadata.is_file() => Ok(Target::Other(target)),
        _ => Ok(Target::File(target)),
    }
}

fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let target = match target(path)? {
        Target::File(target) => target,
        Target::Other(target) => return write(&mut File::options().write(true).open(target)?),
    };
    let (mut file, beside) = create_beside(&target)?;
    let written = write(&mut file).and_then(|()| file.sync_all());
    let replaced = written.and_then(|()| fs::rename(&beside, &target));
    if replaced.is_err() {
        // The first error is the one to report.
        let _ = fs::remove_file(&beside);
    }
    replaced
}

/// A new file in the directory of `target`, since a rename works within one file system only. Its name is short, so that
/// the target's may be as long as the file system allows, and no other process has it, wherever that runs.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let (start, process) = (beside_start(target), std::process::id());
    let mut count = 0u64;
    loop {
        let beside = target.with_file_name(format!("{start}{process}-{count}.tmp"));
        match File::create_new(&beside) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => count += 1,
            created => return created.map(|file| (file, beside)),
        }
    }
}

/// How the names of files begin that are made beside `target`.
fn beside_start(target: &Path) -> String {
    let mut hasher = DefaultHasher::new();
    target.file_name().hash(&mut hasher);
    format!(".{:016x}-", hasher.finish())
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

    /// A name as long as the file system takes is written to, and a longer one is refused in time.
    #[test]
    #[cfg(target_os = "linux")]
    fn r04_long_names() {
        let folder = tempfile::tempdir().unwrap();
        let name = |length: usize| folder.path().join("n".repeat(length));
        try_file(&name(255)).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        write_atomic(&name(255), b"bytes").unwrap();
        assert_eq!(fs::read(name(255)).unwrap(), b"bytes");
        assert_eq!(try_file(&name(256)).unwrap_err().raw_os_error(), Some(36));
    }

    #[test]
    fn r04_what_cannot_be_written_is_found_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), b"old").unwrap();
        fs::create_dir(path("folder")).unwrap();
        assert!(try_file(&path("folder")).is_err());
        assert!(try_file(&path("none/file")).is_err());
        assert!(try_file(&path("file/file")).is_err());
        assert!(try_folder(&path("file")).is_err());
        try_file(&path("file")).unwrap();
        try_folder(&path("folder")).unwrap();
        try_folder(&path("a/b/c")).unwrap();
        assert_eq!(fs::read(path("file")).unwrap(), b"old");
        let mut names: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["file", "folder"]);
        assert!(write_new(&path("file"), b"new").is_err());
        assert_eq!(fs::read(path("file")).unwrap(), b"old");
    }
}
