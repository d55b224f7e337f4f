//! `halfway train`

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::args::method::{ConnectionArgs, LearnArgs};
use super::args::picture::{PictureArgs, SeedArgs};
use super::args::{CameraArgs, InputError, SceneArgs, default_output, try_output};
use super::{CliError, Exit, progress, summary};
use crate::integrator::View;
use crate::integrator::method::{Given, SPCBPT};
use crate::out;
use crate::render::{Prepared, RenderOptions};
use crate::scene::{Scene, SceneFeatures};
use crate::training::{Training, When};

/// Options of `halfway train`.
#[derive(Args, Debug)]
pub struct TrainArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the model goes (default: the scene's name, .model).
    #[arg(short, long, value_name = "FILE.model")]
    output: Option<PathBuf>,
    #[command(flatten)]
    connections: ConnectionArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    seed: SeedArgs,
    /// Write a report with times, counts and the loss at every step.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    learn: LearnArgs,
}

/// Learns and writes the model.
///
/// # Errors
/// Bad input, a scene without light, no device, or a file that cannot be written.
pub fn run(args: &TrainArgs, quiet: bool) -> Result<Exit, CliError> {
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene.scene, "model"));
    check_output(&output)?;
    args.stats.iter().try_for_each(|stats| try_output(stats))?;
    let training = args.learn.training(Training::default())?;
    let training = Training { when: Some(When::First), ..training };
    let load_start = Instant::now();
    let mut scene = args.scene.load()?;
    let camera = args.camera.choose(&mut scene)?;
    check_light(&scene)?;
    let load_seconds = load_start.elapsed().as_secs_f64();

    progress::install_interrupt();
    let context = progress::watched(&args.picture.device.open(quiet)?, quiet);
    let picture = args.picture.options(&scene, camera);
    let ConnectionArgs { connections, shares, no_thinning } = args.connections;
    let given = Given { connections, shares, no_thinning, ..Given::default() };
    let options = RenderOptions {
        view: View { seed: args.seed.seed, ..picture.view },
        method: (SPCBPT.make)(&given),
        training,
        ..picture
    };
    let mut prepared = Prepared::new(&context, &scene, options)?;
    let trained = progress::learn(&mut prepared, quiet)?;
    trained.model.save(&output)?;
    if let Some(path) = &args.stats {
        let stats = summary::training_stats(&trained, prepared.report());
        summary::write_stats(path, stats, &context, load_seconds)?;
    }
    if !quiet {
        summary::trained(&trained);
    }
    summary::warned(scene.warnings.len(), &args.scene.scene);
    out!("{}", output.display());
    Ok(Exit::Done)
}

/// As for pictures, the name has to say what the file is: a slip never overwrites a scene.
fn check_output(output: &Path) -> Result<(), InputError> {
    try_output(output)?;
    match output.extension().and_then(|extension| extension.to_str()) {
        Some("model") => Ok(()),
        _ => Err(InputError::Usage(format!("name the model .model, not '{}'", output.display()))),
    }
}

fn check_light(scene: &Scene) -> Result<(), InputError> {
    match SceneFeatures::of(scene).lights() {
        true => Ok(()),
        false => Err(InputError::Usage(
            "the scene has no light, so there is nothing to learn; give it an emissive material, a KHR_lights_punctual \
             light, or an environment with --env"
                .into(),
        )),
    }
}
