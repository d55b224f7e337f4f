//! The arguments that subcommands share, one file for each subject, and what they are checked for before a device is
//! opened.

mod camera;
mod error;
pub mod method;
mod parse;
pub mod picture;
mod scene;

use std::path::{Path, PathBuf};

use crate::cli::CliError;
use crate::film::Picture;

pub use camera::{CameraArgs, CameraNameArgs};
pub use error::InputError;
pub use parse::{parse_crop, parse_duration, parse_exposure, parse_probability, parse_size, parse_stops};
pub use scene::{SceneArgs, say_what_is_missing};

/// How this program was called, for files that say how they came to be.
pub fn command_line() -> String {
    std::env::args().collect::<Vec<_>>().join(" ")
}

/// Asks for the folder of a file to come: before hours of work, not after them.
///
/// # Errors
/// There is none.
pub fn check_folder(output: &Path) -> Result<(), InputError> {
    match output.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        Some(folder) => Err(InputError::Usage(format!(
            "there is no folder '{}' for '{}'; make it first",
            folder.display(),
            output.display()
        ))),
        None => Ok(()),
    }
}

/// What a picture of so many pixels is to be compared with.
///
/// # Errors
/// A file that cannot be read, or a picture of another size.
pub fn read_reference(path: &Path, [width, height]: [u32; 2]) -> Result<Picture, CliError> {
    let reference = Picture::read(path)?;
    if [reference.width, reference.height] != [width, height] {
        return Err(InputError::Usage(format!(
            "the reference {} has {}x{} pixels, the picture {width}x{height}; render it as the reference was (--size, --crop)",
            path.display(),
            reference.width,
            reference.height
        ))
        .into());
    }
    Ok(reference)
}

/// The default name of what is made of a scene: the scene's own.
pub fn default_output(scene: &Path, extension: &str) -> PathBuf {
    let name = scene.to_string_lossy();
    let name = name.strip_prefix("builtin:").map_or_else(|| scene.to_path_buf(), PathBuf::from);
    PathBuf::from(name.file_stem().unwrap_or(std::ffi::OsStr::new("out"))).with_extension(extension)
}
