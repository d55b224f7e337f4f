//! The arguments that subcommands share, one file for each subject, and what they are checked for before a device is
//! opened.

mod camera;
mod error;
pub mod method;
mod output;
mod parse;
pub mod picture;
mod scene;

use std::path::{Path, PathBuf};

use crate::cli::CliError;
use crate::film::Picture;
use crate::film::write::{try_file, try_folder};

pub use camera::{CameraArgs, CameraNameArgs};
pub use error::InputError;
pub use output::OutputArgs;
pub use parse::{parse_crop, parse_duration, parse_exposure, parse_probability, parse_size, parse_stops};
pub use scene::{BackFaces, SceneArgs, say_what_is_missing};

/// Tries the place of a file to come: before hours of work, not after them. Nothing is left there.
///
/// # Errors
/// There is no such folder, or no file can be made in it, or none of this name.
pub fn try_output(output: &Path) -> Result<(), InputError> {
    if let Some(folder) = output.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir())
    {
        return Err(InputError::Usage(format!(
            "there is no folder '{}' for '{}'; make it first",
            folder.display(),
            output.display()
        )));
    }
    try_file(output).map_err(|cause| {
        InputError::Usage(format!(
            "cannot write '{}': {cause}; choose another place or name, or make it writable",
            output.display()
        ))
    })
}

/// As [`try_output`], of a file that is to have one of these formats, by its extension.
///
/// # Errors
/// As [`try_output`]; another extension.
pub fn try_format(output: &Path, formats: &[&str]) -> Result<(), InputError> {
    try_output(output)?;
    if output.extension().is_some_and(|extension| formats.iter().any(|&format| extension == format)) {
        return Ok(());
    }
    let (last, others) = formats.split_last().expect("a format");
    Err(InputError::Usage(format!(
        "cannot tell the format of '{}'; name it .{} or .{last}",
        output.display(),
        others.join(", .")
    )))
}

/// As [`try_output`], of a folder of files, which is made when they are.
///
/// # Errors
/// It cannot be made, or no files in it.
pub fn try_output_folder(folder: &Path) -> Result<(), InputError> {
    try_folder(folder).map_err(|cause| {
        InputError::Usage(format!(
            "cannot write into the folder '{}': {cause}; choose another, or make it writable",
            folder.display()
        ))
    })
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
