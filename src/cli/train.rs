//! `halfway train`

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use clap::Args;

use super::args::method::LearnArgs;
use super::args::picture::PictureArgs;
use super::args::{CameraArgs, InputError, SceneArgs, check_folder, default_output, open_device};
use super::{Exit, progress};
use crate::integrator::{DEFAULT_CONNECTIONS, MAX_CONNECTIONS, Method, SpcBpt, View};
use crate::render::{Prepared, RenderOptions, Report};
use crate::scene::{Scene, SceneFeatures};
use crate::subspace::TrainingReport;
use crate::training::{Training, TrainingResult, When};

/// Learn which light vertices of a scene are worth a connection, seen by one of its cameras, and keep it in a file for
/// `halfway render --integrator spcbpt --model FILE`. Whatever was learnt, pictures stay unbiased: it is about noise only.
#[derive(Args, Debug)]
pub struct TrainArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the model goes (default: the scene's name, .model).
    #[arg(short, long, value_name = "FILE.model")]
    output: Option<PathBuf>,
    /// Connections of each vertex of an eye path that the render will have. With another number it stays unbiased.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_CONNECTIONS,
          value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_CONNECTIONS)))]
    connections: u32,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    camera: CameraArgs,
    /// Same seed, same device: the same model, bit for bit.
    #[arg(long, default_value_t = 0)]
    seed: u64,
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
pub fn run(args: &TrainArgs, quiet: bool) -> anyhow::Result<Exit> {
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene.scene, "model"));
    check_output(&output)?;
    let training = args.learn.training(Training::default())?;
    let training = Training { when: Some(When::First), ..training };
    let load_start = Instant::now();
    let mut scene = args.scene.load()?;
    let camera = args.camera.choose(&mut scene)?;
    check_light(&scene)?;
    let load_seconds = load_start.elapsed().as_secs_f64();

    progress::install_interrupt();
    let context = open_device(&args.picture.device, quiet)?;
    let options = RenderOptions {
        view: View { seed: args.seed, ..args.picture.options(&scene, camera).view },
        method: Method::SpcBpt(SpcBpt { connections: args.connections, ..SpcBpt::default() }),
        training,
        ..args.picture.options(&scene, camera)
    };
    let mut prepared = Prepared::new(&context, &scene, options)?;
    let trained = progress::learn(&mut prepared, quiet)?;
    trained.model.save(&output)?;
    if let Some(path) = &args.stats {
        let mut value = stats(&trained, prepared.report());
        value["device"] = context.describe().into();
        value["load_seconds"] = load_seconds.into();
        std::fs::write(path, serde_json::to_string_pretty(&value)?)
            .with_context(|| format!("cannot write the report to {}", path.display()))?;
    }
    if !quiet {
        summary(&trained);
    }
    println!("{}", output.display());
    Ok(Exit::Done)
}

/// As for pictures, the name has to say what the file is: a slip never overwrites a scene.
fn check_output(output: &Path) -> Result<(), InputError> {
    check_folder(output)?;
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

fn stats(trained: &TrainingResult, report: &Report) -> serde_json::Value {
    let model = &trained.model;
    serde_json::json!({
        "scene_hash": format!("{:016x}", model.scene_hash),
        "accel_seconds": report.accel_seconds,
        "upload_seconds": report.upload_seconds,
        "pretracing_seconds": report.pretracing_seconds,
        "preprocessing_seconds": report.preprocessing_seconds,
        "camera_paths": trained.camera_paths,
        "round_losses": trained.losses,
        "choices": trained.choices,
        "subspaces": model.subspaces,
        "connections": model.connections,
        "settings": model.settings,
        "training": model.report,
    })
}

fn summary(trained: &TrainingResult) {
    let (model, report) = (&trained.model, &trained.model.report);
    let counts = &report.counts;
    eprintln!(
        "learnt in {:.2} s: {:.2} s of tracing, {:.2} s of fitting",
        (trained.tracing + trained.learning).as_secs_f64(),
        trained.tracing.as_secs_f64(),
        trained.learning.as_secs_f64()
    );
    eprintln!(
        "from {} paths with {} connections, found among {} camera paths",
        counts.paths, counts.nodes, trained.camera_paths
    );
    progress::say_choices(&trained.choices);
    eprintln!(
        "{} subspaces a side: {} eye and {} light subspaces in use",
        model.subspaces, counts.learnt_rows, counts.active_columns
    );
    if let Some(gain) = held_out_gain(report) {
        eprintln!(
            "held-out loss {gain:.3} of the start's, after {} of {} steps, {} learnt from neighbours",
            report.best_step,
            report.losses.len().saturating_sub(1),
            report.losses.get(report.best_step as usize).map_or(0.0, |loss| loss.smoothing)
        );
    }
}

/// The loss on paths that taught nothing, over what it was before the first step.
pub fn held_out_gain(report: &TrainingReport) -> Option<f64> {
    let loss = |step: usize| report.losses.get(step)?.held_out;
    let start = loss(0).filter(|start| *start > 0.0)?;
    Some(loss(report.best_step as usize)? / start)
}
