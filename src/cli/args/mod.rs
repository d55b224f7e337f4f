//! The arguments that say what to render, shared by the subcommands that take a scene.

mod error;
pub mod method;
pub mod picture;

use std::fmt;
use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;

use crate::cli::CliError;
use crate::device::{Context, DeviceChoice, DeviceError};
use crate::film::{Picture, Region};
use crate::scene::gltf::{self, LoadOptions};
use crate::scene::{Camera, Environment, Pose, Projection, Scene, builtin};

pub use error::InputError;

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
    /// The files that it is read from, as far as they are named here: none of a built-in scene.
    #[cfg(feature = "preview")]
    pub fn files(&self) -> Vec<PathBuf> {
        let is_file = |path: &&PathBuf| !path.to_string_lossy().starts_with("builtin:");
        std::iter::once(&self.scene).filter(is_file).chain(&self.env).cloned().collect()
    }

    /// Loads the scene, adds the environment, and prints the loader's warnings.
    ///
    /// # Errors
    /// What the loader reports.
    pub fn load(&self) -> Result<Scene, CliError> {
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

/// Which camera, and how it is moved. Displays as these arguments on a command line, quoted for a shell; parsed again
/// they make the same camera bit for bit.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct CameraArgs {
    /// Which of the scene's cameras, by name or number.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<String>,
    /// Stand at this point instead, in scene units; the camera's projection stays.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_at", allow_hyphen_values = true)]
    pub look_from: Option<DVec3>,
    /// The point in the middle of the picture then.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_from", allow_hyphen_values = true)]
    pub look_at: Option<DVec3>,
    /// The direction that is up in the picture then (default: 0,1,0).
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, requires = "look_from", allow_hyphen_values = true)]
    pub look_up: Option<DVec3>,
    /// Vertical field of view of a perspective camera, in place of its own.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub fov: Option<f64>,
    /// Scene units from the bottom to the top of what an orthographic camera sees, in place of its own.
    #[arg(long, value_name = "UNITS", allow_hyphen_values = true)]
    pub ortho_height: Option<f64>,
}

impl CameraArgs {
    /// The arguments that choose a camera of the scene as it is: by name where that finds it, else by number. None for
    /// the camera that stands in where the scene has none.
    pub fn naming(scene: &Scene, index: usize) -> Self {
        let cameras = scene.own_cameras();
        let stands_in = || *cameras == [Camera::framing(&scene.bounds())];
        let name = cameras.get(index).map(|camera| camera.name.as_str());
        let camera = match name {
            _ if cameras.is_empty() || stands_in() => None,
            // A dash would begin another argument.
            Some(name)
                if !name.starts_with('-')
                    && !name.contains(char::is_control)
                    && find_camera(cameras, name) == Some(index) =>
            {
                Some(name.to_string())
            }
            _ => Some(index.to_string()),
        };
        Self { camera, ..Self::default() }
    }

    /// The scene's own camera that is asked for, before it is moved; one that frames the scene where it has none.
    ///
    /// # Errors
    /// No such camera.
    pub fn own(&self, scene: &Scene) -> Result<Camera, InputError> {
        match (scene.own_cameras(), &self.camera) {
            ([], None) => Ok(Camera::framing(&scene.bounds())),
            (cameras, wanted) => Ok(cameras[own_camera(scene, wanted.as_deref())?].clone()),
        }
    }

    /// The same camera of the scene, moved to a pose.
    pub fn moved(&self, pose: &Pose) -> Self {
        let (fov, ortho_height) = match pose.projection {
            Projection::Perspective { yfov } => {
                let same = |degrees| Projection::perspective(degrees) == Some(pose.projection);
                (Some(shortest(f64::from(yfov).to_degrees(), same)), None)
            }
            Projection::Orthographic { ymag, .. } => {
                let same = |height: f64| (0.5 * height) as f32 == ymag;
                (None, Some(shortest(2.0 * f64::from(ymag), same)))
            }
        };
        Self {
            camera: self.camera.clone(),
            look_from: Some(pose.from),
            look_at: Some(pose.at),
            look_up: (pose.up != DVec3::Y).then_some(pose.up),
            fov,
            ortho_height,
        }
    }

    /// The pose that is asked for in place of that of `own`, with the projection of [`CameraArgs::projection`].
    ///
    /// # Errors
    /// As for the projection.
    pub fn pose(&self, own: &Camera) -> Result<Option<Pose>, InputError> {
        let (Some(from), Some(at)) = (self.look_from, self.look_at) else { return Ok(None) };
        let up = self.look_up.unwrap_or(DVec3::Y);
        Ok(Some(Pose { from, at, up, projection: self.projection(own)? }))
    }

    /// The projection of `own`, changed as asked for.
    ///
    /// # Errors
    /// A setting of the other kind of projection, or out of its range.
    pub fn projection(&self, own: &Camera) -> Result<Projection, InputError> {
        let refuse = |detail: String| Err(InputError::Usage(detail));
        match (own.projection, self.fov, self.ortho_height) {
            (Projection::Orthographic { .. }, Some(_), _) => refuse(format!(
                "--fov is for perspective cameras, and '{}' is orthographic; give --ortho-height, or another --camera",
                own.name
            )),
            (Projection::Perspective { .. }, _, Some(_)) => refuse(format!(
                "--ortho-height is for orthographic cameras, and '{}' is perspective; give --fov, or another --camera",
                own.name
            )),
            (_, Some(degrees), _) => Projection::perspective(degrees).map_or_else(
                || refuse(format!("--fov {degrees}: give degrees above 0 and below 180, such as 40")),
                Ok,
            ),
            (projection, _, Some(height)) => projection.with_height(height).map_or_else(
                || {
                    refuse(format!(
                        "--ortho-height {height}: give a positive height in scene units, such as 2.5"
                    ))
                },
                Ok,
            ),
            (projection, None, None) => Ok(projection),
        }
    }

    /// The camera that these arguments make of one of the scene's.
    ///
    /// # Errors
    /// A setting of the other kind of projection or out of its range, points that leave no direction to look in.
    pub fn apply(&self, own: &Camera) -> Result<Camera, InputError> {
        let name = moved_name(own);
        let Some(pose) = self.pose(own)? else {
            let projection = self.projection(own)?;
            let name = if projection == own.projection { own.name.clone() } else { name };
            return Ok(Camera { name, projection, ..own.clone() });
        };
        pose.camera(&name).ok_or_else(|| {
            InputError::Usage(match pose.from == pose.at {
                true => "--look-from and --look-at are the same point; move one of them".into(),
                false => format!(
                    "no picture has {} upright when it looks from {} at {}; give another direction by --look-up",
                    point(pose.up),
                    point(pose.from),
                    point(pose.at)
                ),
            })
        })
    }

    /// The index of the camera that is asked for. One that is moved is placed in the scene, beside its own.
    ///
    /// # Errors
    /// No such camera, or what [`CameraArgs::apply`] refuses.
    pub fn choose(&self, scene: &mut Scene) -> Result<usize, InputError> {
        let index = choose_camera(scene, self.camera.as_deref())?;
        let camera = self.apply(&scene.cameras[index])?;
        Ok(if camera == scene.cameras[index] { index } else { scene.place_camera(camera) })
    }

    /// The arguments one by one, as a program is given them.
    pub fn words(&self) -> Vec<String> {
        let points =
            [("--look-from", self.look_from), ("--look-at", self.look_at), ("--look-up", self.look_up)];
        let numbers = [("--fov", self.fov), ("--ortho-height", self.ortho_height)];
        let camera = self.camera.iter().map(|name| ("--camera", name.clone()));
        let points = points.into_iter().filter_map(|(flag, value)| Some((flag, point(value?))));
        let numbers = numbers.into_iter().filter_map(|(flag, value)| Some((flag, decimals(value?))));
        let pairs = camera.chain(points).chain(numbers);
        pairs.flat_map(|(flag, value)| [flag.to_string(), value]).collect()
    }
}

impl fmt::Display for CameraArgs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = |c: char| c.is_alphanumeric() || "_-+.,:/@%".contains(c);
        let quoted = |word: &String| match !word.is_empty() && word.chars().all(plain) {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', r"'\''")),
        };
        f.write_str(&self.words().iter().map(quoted).collect::<Vec<_>>().join(" "))
    }
}

/// The name of a camera that was one of the scene's.
pub fn moved_name(own: &Camera) -> String {
    format!("{} (moved)", own.name)
}

/// A point or a direction as `X,Y,Z`.
fn parse_point(text: &str) -> Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if DVec3::new(x, y, z).is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("a point is X,Y,Z in scene units, such as 0,1.5,-2".into()),
    }
}

fn point(value: DVec3) -> String {
    value.to_array().map(decimals).join(",")
}

/// The shortest decimals that are read as the same number, with an exponent where it is very large or small.
fn decimals(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_string)
}

/// The number of fewest digits near `value` that is the `same`.
fn shortest(value: f64, same: impl Fn(f64) -> bool) -> f64 {
    let mut rounded = (0..17).filter_map(|digits| format!("{value:.digits$e}").parse().ok());
    rounded.find(|&number| same(number)).unwrap_or(value)
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
        Some(&[x, y, width, height]) => Ok(Region::new(x, y, width, height)),
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
    if scene.own_cameras().is_empty() && wanted.is_none() {
        // In front of one that was placed.
        scene.cameras.insert(0, Camera::framing(&scene.bounds()));
        log::warn!("the scene has no camera; one was placed to see all of it");
    }
    own_camera(scene, wanted)
}

/// The index of the camera that `--camera` names; without it the first, which there is.
fn own_camera(scene: &Scene, wanted: Option<&str>) -> Result<usize, InputError> {
    let cameras = scene.own_cameras();
    let Some(wanted) = wanted else { return Ok(0) };
    if cameras.is_empty() {
        return Err(InputError::Usage(format!(
            "--camera {wanted}: the scene has no camera; leave the option out to have one placed"
        )));
    }
    find_camera(cameras, wanted).ok_or_else(|| {
        let list: Vec<String> =
            cameras.iter().enumerate().map(|(i, camera)| format!("{i} '{}'", camera.name)).collect();
        InputError::Usage(format!("no camera {wanted}; the scene has: {}", list.join(", ")))
    })
}

/// By name, else by number.
fn find_camera(cameras: &[Camera], wanted: &str) -> Option<usize> {
    let by_name = cameras.iter().position(|camera| camera.name == wanted);
    by_name.or_else(|| wanted.parse().ok().filter(|&index| index < cameras.len()))
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

#[cfg(test)]
mod tests {
    use clap::Parser;
    use proptest::prelude::*;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        camera: CameraArgs,
    }

    fn parse(words: &[String]) -> Result<CameraArgs, clap::Error> {
        Line::try_parse_from(std::iter::once("program").chain(words.iter().map(String::as_str)))
            .map(|line| line.camera)
    }

    fn words(line: &str) -> Vec<String> {
        line.split(' ').map(str::to_string).collect()
    }

    fn args(line: &str) -> CameraArgs {
        parse(&words(line)).unwrap()
    }

    fn own(name: &str, projection: Projection) -> Camera {
        Camera { name: name.into(), projection, ..Camera::framing(&Scene::default().bounds()) }
    }

    const LENS: Projection = Projection::Perspective { yfov: 0.7 };
    const PARALLEL: Projection = Projection::Orthographic { xmag: 0.3, ymag: 0.7 };

    #[test]
    fn flags_move_a_camera() {
        let mut scene = Scene { cameras: vec![own("a", LENS), own("b", PARALLEL)], ..Scene::default() };
        let before = scene.content_hash();
        assert_eq!(args("--camera b").choose(&mut scene).unwrap(), 1);
        assert_eq!(scene.cameras.len(), 2, "nothing moved");

        let moved = args("--look-from -1,2,1e3 --look-at -1,2,0 --look-up 0,3,0 --fov 90");
        assert_eq!(moved.choose(&mut scene).unwrap(), 2);
        let camera = &scene.cameras[2];
        assert_eq!((camera.name.as_str(), camera.position), ("a (moved)", DVec3::new(-1.0, 2.0, 1e3)));
        assert_eq!(camera.forward, glam::Vec3::NEG_Z);
        assert_eq!(camera.projection, Projection::Perspective { yfov: std::f32::consts::FRAC_PI_2 });

        let taller = args("--camera 1 --ortho-height 2.8");
        assert_eq!(taller.choose(&mut scene).unwrap(), 2, "in place of the last that was placed");
        let camera = &scene.cameras[2];
        assert_eq!((camera.name.as_str(), camera.position), ("b (moved)", scene.cameras[1].position));
        assert_eq!(camera.projection, Projection::Orthographic { xmag: 0.6, ymag: 1.4 });
        assert_eq!(scene.content_hash(), before, "a model stays valid");
        assert!(args("--camera 2").choose(&mut scene).is_err(), "a placed camera has no number");
    }

    #[test]
    fn the_camera_that_stands_in_can_be_moved() {
        let mut scene = Scene::default();
        choose_camera(&mut scene, None).unwrap();
        let learnt = scene.content_hash();
        let mut scene = Scene::default();
        assert_eq!(args("--look-from 0,0,5 --look-at 0,0,0").choose(&mut scene).unwrap(), 1);
        assert_eq!((scene.cameras[1].name.as_str(), scene.content_hash()), ("framing (moved)", learnt));
        assert_eq!(CameraArgs::naming(&scene, 0), CameraArgs::default());
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        for line in [
            "--look-from 1,2,3",
            "--look-at 1,2,3",
            "--look-up 0,1,0",
            "--look-from 1,2 --look-at 1,2,3",
            "--look-from 1,2,inf --look-at 1,2,3",
        ] {
            assert!(parse(&words(line)).is_err(), "{line}");
        }
        for (line, projection, says) in [
            ("--fov 40", PARALLEL, "give --ortho-height"),
            ("--ortho-height 4", LENS, "give --fov"),
            ("--fov 180", LENS, "below 180"),
            ("--fov -3", LENS, "above 0"),
            ("--fov nan", LENS, "above 0"),
            ("--ortho-height 0", PARALLEL, "positive"),
            ("--ortho-height 1e50", PARALLEL, "positive"),
            ("--look-from 1,2,3 --look-at 1,2,3", LENS, "same point"),
            ("--look-from 1,2,3 --look-at 1,9,3", LENS, "--look-up"),
        ] {
            let refused = args(line).apply(&own("a", projection)).unwrap_err().to_string();
            assert!(refused.contains(says), "{line}: {refused}");
        }
    }

    #[test]
    fn cameras_are_named_so_that_they_are_found() {
        let names = ["front", "it's b", "front", "-5", "", "3"];
        let cameras = names.map(|name| own(name, LENS)).to_vec();
        let scene = Scene { cameras, ..Scene::default() };
        let lines = [0, 1, 2, 4].map(|index| CameraArgs::naming(&scene, index).to_string());
        assert_eq!(lines, ["--camera front", r"--camera 'it'\''s b'", "--camera 2", "--camera ''"]);
    }

    #[test]
    fn angles_come_back_in_few_digits() {
        let own = own("a", LENS);
        for tenths in 1..1800 {
            let degrees = f64::from(tenths) / 10.0;
            let projection = Projection::perspective(degrees).unwrap();
            let pose = Pose { from: DVec3::Z, at: DVec3::ZERO, up: DVec3::Y, projection };
            assert_eq!(CameraArgs::default().moved(&pose).fov, Some(degrees));
        }
        // Every f32 in a stretch, and steps through all binades.
        let stretch = 0.7f32.to_bits()..0.7f32.to_bits() + 20_000;
        let steps = (1..std::f32::consts::PI.to_bits()).step_by(54_321);
        for yfov in stretch.chain(steps).map(f32::from_bits) {
            let projection = Projection::Perspective { yfov };
            let pose = Pose { from: DVec3::Z, at: DVec3::ZERO, up: DVec3::Y, projection };
            let again = parse(&CameraArgs::default().moved(&pose).words()).unwrap();
            assert_eq!(again.projection(&own).unwrap(), projection, "{yfov:e}: {again}");
        }
    }

    proptest! {
        #[test]
        fn a_pose_comes_back_from_its_flags(
            from in prop::array::uniform3(prop::num::f64::NORMAL | prop::num::f64::ZERO),
            at in prop::array::uniform3(-1e3..1e3f64),
            up in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
            near in any::<bool>(),
            lens in any::<bool>(),
            size in 1e-30..3.1f32,
        ) {
            let at = DVec3::from(at);
            let from = if near { at + DVec3::from(from.map(f64::sin)) } else { DVec3::from(from) };
            let own = own("a", if lens { LENS } else { PARALLEL });
            let projection = match lens {
                true => Projection::Perspective { yfov: size },
                false => PARALLEL.with_height(f64::from(size)).unwrap(),
            };
            let pose = Pose { from, at, up: up.map_or(DVec3::Y, DVec3::from), projection };
            let camera = pose.camera("a (moved)");
            let words = CameraArgs::default().moved(&pose).words();
            let again = parse(&words).unwrap();
            prop_assert_eq!(again.pose(&own).unwrap(), Some(pose), "{}", words.join(" "));
            // Floats are written so that no two look alike.
            let again = again.apply(&own).ok();
            prop_assert_eq!(format!("{again:?}"), format!("{camera:?}"), "{}", words.join(" "));
        }
    }
}
