//! The arguments that say what to render, shared by the subcommands that take a scene.

use std::path::{Path, PathBuf};

use clap::Args;
use thiserror::Error;

use crate::device::{Context, DeviceChoice};
use crate::error::DeviceError;
use crate::integrator::Region;
use crate::scene::gltf::{self, LoadOptions};
use crate::scene::{Camera, Environment, Projection, Scene, builtin};

/// Arguments that do not go together, or with the scene.
#[derive(Debug, Error)]
pub enum InputError {
    #[error("{0}")]
    Usage(String),
}

/// A scene and what is added to it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// A .gltf or .glb file, or `builtin:NAME` (see `halfway info --builtins`).
    pub scene: PathBuf,
    /// An .exr or .hdr latitude-longitude picture as environment light.
    #[arg(long, value_name = "FILE")]
    pub env: Option<PathBuf>,
    /// Factor on the environment.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub env_scale: f32,
    /// Rotation of the environment about the vertical axis, degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_hyphen_values = true)]
    pub env_rotate: f32,
    /// Let the scene refer to files outside its folder.
    #[arg(long)]
    pub allow_outside: bool,
}

impl SceneArgs {
    /// Loads the scene, adds the environment, and prints the loader's warnings.
    ///
    /// # Errors
    /// What the loader reports.
    pub fn load(&self) -> anyhow::Result<Scene> {
        let mut scene = match self.scene.to_str().and_then(|name| name.strip_prefix("builtin:")) {
            Some(name) => builtin::builtin(name).ok_or_else(|| {
                InputError::Usage(format!(
                    "no built-in scene '{name}'; there are: {}",
                    builtin::NAMES.join(", ")
                ))
            })?,
            None => {
                let options = LoadOptions { allow_outside: self.allow_outside, ..LoadOptions::default() };
                gltf::load(&self.scene, &options)?
            }
        };
        if let Some(path) = &self.env {
            let mut environment = Environment::load(path)?;
            environment.scale = self.env_scale;
            environment.rotation = self.env_rotate.to_radians();
            scene.environment = Some(environment);
        }
        for warning in &scene.warnings {
            log::warn!("{warning}");
        }
        Ok(scene)
    }
}

/// Pixels of a picture that no size is given for, where the scene has no wish either.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// The size that was asked for, else that of the scene.
pub fn picture_size(wanted: Option<[u32; 2]>, scene: &Scene) -> [u32; 2] {
    wanted.or(scene.resolution).unwrap_or(DEFAULT_SIZE)
}

/// A picture's size as `WIDTHxHEIGHT`.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parts {
        Some([width, height]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("a size is WIDTHxHEIGHT in pixels, such as 1280x720".into()),
    }
}

/// A part of a picture as `X,Y,WIDTH,HEIGHT`.
pub fn parse_crop(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) => Ok(Region { x, y, width, height }),
        _ => Err("a part is X,Y,WIDTH,HEIGHT in pixels, such as 0,0,640,360".into()),
    }
}

/// A duration such as `30s`, `1.5m`, `2h`, or plain seconds.
pub fn parse_duration(text: &str) -> Result<std::time::Duration, String> {
    let (number, unit) = match text.find(|c: char| c.is_ascii_alphabetic()) {
        Some(at) => text.split_at(at),
        None => (text, "s"),
    };
    let factor = match unit {
        "ms" => 1e-3,
        "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("a duration is a number with s, m or h, such as 30s".into()),
    };
    let seconds = number.parse::<f64>().map_err(|_| "a duration is a number with s, m or h, such as 30s")?;
    std::time::Duration::try_from_secs_f64(seconds * factor).map_err(|error| error.to_string())
}

/// The camera that `--camera` names, by index or name; without it the first, or one that frames the scene.
///
/// # Errors
/// No such camera; the message lists those there are.
pub fn choose_camera(scene: &mut Scene, wanted: Option<&str>) -> Result<usize, InputError> {
    if scene.cameras.is_empty() {
        if let Some(wanted) = wanted {
            return Err(InputError::Usage(format!(
                "--camera {wanted}: the scene has no camera; leave the option out to have one placed"
            )));
        }
        scene.cameras.push(framing_camera(scene));
        log::warn!("the scene has no camera; one was placed to see all of it");
    }
    let Some(wanted) = wanted else { return Ok(0) };
    let by_name = scene.cameras.iter().position(|camera| camera.name == wanted);
    let by_index = || wanted.parse::<usize>().ok().filter(|&index| index < scene.cameras.len());
    by_name.or_else(by_index).ok_or_else(|| {
        let list: Vec<String> =
            scene.cameras.iter().enumerate().map(|(i, camera)| format!("{i} '{}'", camera.name)).collect();
        InputError::Usage(format!("no camera {wanted}; the scene has: {}", list.join(", ")))
    })
}

/// A camera in front of the scene (+z), slightly above, that sees its whole bounding sphere.
fn framing_camera(scene: &Scene) -> Camera {
    use glam::{DVec3, Vec3};
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for position in scene.meshes.iter().flat_map(|mesh| &mesh.positions) {
        low = low.min(*position);
        high = high.max(*position);
    }
    if !low.is_finite() {
        (low, high) = (DVec3::ZERO, DVec3::ZERO);
    }
    let centre = 0.5 * low + 0.5 * high;
    let radius = if high == low { 1.0 } else { (0.5 * high - 0.5 * low).length() };
    let yfov = 40f32.to_radians();
    let back = Vec3::new(0.0, 0.35, 1.0).normalize();
    let right = Vec3::X;
    Camera {
        name: "framing".into(),
        position: centre + back.as_dvec3() * radius / f64::from(0.5 * yfov).sin(),
        right,
        up: back.cross(right),
        forward: -back,
        projection: Projection::Perspective { yfov },
    }
}

/// Opens the device and says which it is.
///
/// # Errors
/// No such device.
pub fn open_device(choice: &DeviceChoice, quiet: bool) -> Result<Context, DeviceError> {
    let context = Context::new(choice)?;
    if !quiet {
        eprintln!("device: {}", context.describe());
        if context.is_cpu() {
            eprintln!("warning: this is a software device; a GPU renders many times faster");
        }
    }
    Ok(context)
}

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

/// The default name of what is made of a scene: the scene's own.
pub fn default_output(scene: &Path, extension: &str) -> PathBuf {
    let name = scene.to_string_lossy();
    let name = name.strip_prefix("builtin:").map_or_else(|| scene.to_path_buf(), PathBuf::from);
    PathBuf::from(name.file_stem().unwrap_or(std::ffi::OsStr::new("out"))).with_extension(extension)
}
