//! `halfway preview`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::args::method::{MethodArgs, ModelArgs};
use super::args::picture::{PictureArgs, SeedArgs, ViewArgs};
use super::args::{
    CameraArgs, InputError, SceneArgs, default_output, read_reference, say_what_is_missing, try_output,
};
use super::{CliError, Exit, progress, text};
use crate::film::Exposure;
use crate::integrator::{METHODS, View};
use crate::preview::{self, Display, Settings};
use crate::render::{Automatic, RenderOptions};
use crate::scene::Scene;

/// Options of `halfway preview`.
#[derive(Args, Debug)]
pub struct PreviewArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Stop at so many samples per pixel (default: never).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    seed: SeedArgs,
    #[command(flatten)]
    view: ViewArgs,
    /// A picture of the same size to compare with: beside it, and as a map of errors.
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Pictures are saved as NAME-1.exr and NAME-1.png, NAME-2 and so on (default: the scene's name).
    #[arg(short, long, value_name = "NAME")]
    output: Option<PathBuf>,
}

/// With a camera where it has none, as for every render: a model of the scene is of that camera, too.
fn load(source: &SceneArgs, camera: &CameraArgs) -> Result<Arc<Scene>, CliError> {
    let mut scene = source.load()?;
    camera.choose(&mut scene)?;
    Ok(Arc::new(scene))
}

/// Shows the window until it is closed.
///
/// # Errors
/// Bad input, no desktop, no device.
pub fn run(args: &PreviewArgs, quiet: bool) -> Result<Exit, CliError> {
    let Exposure::Stops(exposure) = args.view.exposure else {
        return Err(InputError::Usage(
            "--exposure auto is for finished pictures; in the window + and - change the exposure".into(),
        )
        .into());
    };
    // Before anything that takes long.
    let display = Display::open()?;
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene.scene, ""));
    // The longest of the names that pictures get.
    let mut first = output.clone().into_os_string();
    first.push("-1.model");
    try_output(Path::new(&first))?;
    let scene = load(&args.scene, &args.camera)?;
    say_what_is_missing(&scene);
    let [width, height] = args.picture.size(&scene);
    let reference =
        args.reference.as_deref().map(|path| read_reference(path, [width, height])).transpose()?;
    let wanted = args.method.method()?;
    let method = wanted.unwrap_or_else(|| Automatic::without_end(&scene).method);
    let slot = METHODS.iter().position(|other| other.name == method.name()).unwrap_or(0);
    let training = args.method.training()?;
    let model = args.model.load(scene.content_hash(), wanted)?;
    progress::install_interrupt();
    let context = args.picture.device.open(quiet)?;
    let most = context.device.limits().max_texture_dimension_2d;
    if width.max(height) > most {
        return Err(InputError::Usage(format!(
            "a window on this device shows at most {most} pixels per side; take a smaller --size"
        ))
        .into());
    }
    // The window places its camera itself.
    let options = args.picture.options(&scene, 0);
    let view = View { seed: args.seed.seed, ..options.view };
    let options = args.method.apply(RenderOptions { view, method, model, training, ..options });
    let mut methods = METHODS.map(|other| args.method.for_surfaces(&scene, other.default_method()).0);
    methods[slot] = args.method.for_surfaces(&scene, options.method).0;
    let (source, camera) = (args.scene.clone(), args.camera.clone());
    let settings = Settings {
        context,
        scene,
        camera: args.camera.viewpoint(),
        loader: Box::new(move || load(&source, &camera).map_err(|error| error.to_string())),
        files: args.scene.files(),
        options,
        methods,
        slot,
        samples: args.spp,
        reference,
        view: args.view.view,
        exposure,
        output,
        title: args.scene.scene.display().to_string(),
        command_line: text::command_line(),
    };
    preview::run(display, settings, progress::interrupted)?;
    Ok(if progress::interrupted() { Exit::Interrupted } else { Exit::Done })
}
