//! Pictures and models to files.

use std::path::{Path, PathBuf};

use crate::film::{Attribute, FilmError, Picture, exr, png};
use crate::integrator::Method;
use crate::render::{Origin, RenderError, Renderer};

use super::Settings;
use super::snapshot::Snapshot;
use super::worker::Save;

/// The first of `name-1`, `name-2`, ... that no file has: nothing is ever overwritten.
fn free_name(output: &Path) -> PathBuf {
    let name = output.file_name().unwrap_or(std::ffi::OsStr::new("preview")).to_string_lossy();
    let numbered = |number: u32| output.with_file_name(format!("{name}-{number}"));
    let is_free = |base: &PathBuf| ["exr", "png", "model"].iter().all(|kind| !with(base, kind).exists());
    (1..).map(numbered).find(is_free).unwrap_or_else(|| output.to_owned())
}

/// Adds an ending, also to names with a dot.
fn with(base: &Path, kind: &str) -> PathBuf {
    let mut name = base.as_os_str().to_owned();
    name.push(format!(".{kind}"));
    name.into()
}

/// Writes an EXR file with all layers, a PNG file as the window shows it, and the model where there is one; returns the
/// paths. `denoise`: adds the denoised layer, which the PNG then shows.
///
/// # Errors
/// A lost device, a file that cannot be written.
pub fn save(
    settings: &Settings,
    renderer: &mut Renderer,
    method: Method,
    camera_flags: &str,
    save: &Save,
    denoise: Option<impl FnOnce(&mut Picture) -> Result<(), FilmError>>,
) -> Result<Vec<PathBuf>, RenderError> {
    let base = free_name(&save.name);
    let report = renderer.report()?;
    let mut picture = renderer.picture()?;
    picture.metadata = report.metadata(&Origin {
        method,
        seed: settings.options.view.seed,
        scene_hash: renderer.scene_hash(),
        device: settings.context.describe(),
        command_line: settings.command_line.clone(),
    });
    picture.metadata.push(("cameraFlags".into(), Attribute::Text(camera_flags.into())));
    let mut paths = write(&base, &picture, save)?;
    if let Some(denoise) = denoise {
        // What is there already stays, whatever becomes of this.
        denoise(&mut picture)?;
        write(&base, &picture, save)?;
    }
    if let Some(model) = &renderer.model {
        let path = with(&base, "model");
        model.save(&path)?;
        paths.push(path);
    }
    Ok(paths)
}

/// Writes a snapshot, where its film is gone: the device is lost, or the camera has moved on.
///
/// # Errors
/// A file that cannot be written.
pub fn save_snapshot(
    settings: &Settings,
    snapshot: &Snapshot,
    save: &Save,
) -> Result<Vec<PathBuf>, RenderError> {
    let mut picture = (*snapshot.picture).clone();
    picture.metadata = vec![
        ("integrator".into(), Attribute::Text(settings.methods[snapshot.slot].name().into())),
        ("spp".into(), Attribute::Number(f64::from(snapshot.figures.samples))),
        ("commandLine".into(), Attribute::Text(settings.command_line.clone())),
        ("cameraFlags".into(), Attribute::Text(snapshot.camera_flags.clone())),
    ];
    write(&free_name(&save.name), &picture, save)
}

fn write(base: &Path, picture: &Picture, save: &Save) -> Result<Vec<PathBuf>, RenderError> {
    let [exr_path, png_path] = ["exr", "png"].map(|kind| with(base, kind));
    exr::write(&exr_path, picture)?;
    png::write(&png_path, picture, save.view, save.exposure)?;
    Ok(vec![exr_path, png_path])
}
