//! What is reported of a render or a training that is over: lines on stderr, and reports as JSON.

use std::path::Path;

use super::CliError;
use super::progress::say_choices;
use crate::bench::trade::Checkpoint;
use crate::device::Context;
use crate::device::host_memory::peak_memory;
use crate::film::write::write_atomic;
use crate::integrator::Choice;
use crate::render::{RenderOptions, Report, Stop};
use crate::subspace::TrainingReport;
use crate::training::TrainingResult;

/// Tells what a render did, but for the choices that were `told` when it began.
pub fn rendered(report: &Report, load_seconds: f64, options: &RenderOptions, told: &[Choice]) {
    let rate = f64::from(report.samples) * f64::from(options.view.width) * f64::from(options.view.height)
        / report.seconds;
    let reason = match report.stop {
        Stop::Samples => "--spp reached",
        Stop::Time => "--time reached",
        Stop::Error => "--error reached",
        Stop::Interrupted => "interrupted",
    };
    let error = report.estimated_error.map_or(String::new(), |error| {
        let denoised =
            report.denoised_error.map_or(String::new(), |error| format!(" ({} denoised)", percent(error)));
        format!(", estimated error {}{denoised}", percent(error))
    });
    let environment = match report.environment_seconds {
        seconds if seconds >= 0.05 => format!(" ({seconds:.2} s of them the environment)"),
        _ => String::new(),
    };
    eprintln!(
        "{} spp in {:.2} s ({:.2} M samples/s){error}; {reason}. Before that: loading {load_seconds:.2} s, BVH {:.2} s, \
         lights and upload {:.2} s{environment}, compiling {:.2} s.",
        report.samples,
        report.seconds,
        rate * 1e-6,
        report.accel_seconds,
        report.upload_seconds,
        report.compile_seconds
    );
    if let Some(reason) = &report.denoised_error_unknown {
        eprintln!("the error of the denoised picture is not known: {reason}");
    }
    say_choices(report.choices.iter().filter(|choice| !told.contains(choice)));
    if let Some(training) = &report.training {
        let gain = held_out_gain(training)
            .map_or(String::new(), |gain| format!(", held-out loss {gain:.3} of the start's"));
        let when = match options.model {
            Some(_) => "learnt before".to_string(),
            None => format!(
                "learnt in {:.2} s ({:.2} s of them tracing)",
                report.preprocessing_seconds, report.pretracing_seconds
            ),
        };
        eprintln!(
            "{when} from {} paths with {} connections: {} eye subspaces in use{gain}",
            training.counts.paths, training.counts.nodes, training.counts.learnt_rows,
        );
    }
    if report.dropped_triangles > 0 {
        eprintln!("{} triangles without area were left out", report.dropped_triangles);
    }
}

/// Nothing is certain that has noise.
fn percent(error: f64) -> String {
    match 100.0 * error {
        percent if percent > 0.0 && percent < 0.01 => "below 0.01 %".into(),
        percent => format!("{percent:.2} %"),
    }
}

/// Tells, however quiet, how many parts of a scene's file are not shown as it has them.
pub fn warned(warnings: usize, scene: &Path) {
    let s = if warnings == 1 { "" } else { "s" };
    if warnings > 0 {
        eprintln!("{warnings} warning{s} about the scene; list with: halfway info {}", scene.display());
    }
}

/// Warns where light goes on and on.
pub fn warn_of_depth(deep_paths: Option<f64>) {
    if let Some(surfaces) = deep_paths {
        log::warn!(
            "paths meet {surfaces:.0} surfaces on average before they end: light of such depths carries the picture, since \
             next to nothing in this scene absorbs light. Where surfaces absorb nothing at all (albedo 1) the noise may have no \
             bound, so do not trust its estimate, and a closed room has no finite picture. Give surfaces an albedo of at most \
             0.999, or end paths with --max-depth"
        );
    }
}

/// Tells how far a picture is from its reference.
pub fn judged(point: &Checkpoint) {
    let Checkpoint { mape, relmse, mean_ratio, .. } = point;
    eprintln!(
        "against the reference: MAPE {:.2} %, relMSE {relmse:.3e}, mean ratio {mean_ratio:.4}",
        100.0 * mape
    );
}

/// Tells what a training did.
pub fn trained(trained: &TrainingResult) {
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
    say_choices(&trained.choices);
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
fn held_out_gain(report: &TrainingReport) -> Option<f64> {
    let loss = |step: usize| report.losses.get(step)?.held_out;
    let start = loss(0).filter(|start| *start > 0.0)?;
    Some(loss(report.best_step as usize)? / start)
}

/// The report on a training.
pub fn training_stats(trained: &TrainingResult, report: &Report) -> serde_json::Value {
    let model = &trained.model;
    serde_json::json!({
        "scene_hash": format!("{:016x}", model.scene_hash),
        "accel_seconds": report.accel_seconds,
        "upload_seconds": report.upload_seconds,
        "environment_seconds": report.environment_seconds,
        "pretracing_seconds": trained.tracing.as_secs_f64(),
        "preprocessing_seconds": (trained.tracing + trained.learning).as_secs_f64(),
        "camera_paths": trained.camera_paths,
        "round_losses": trained.losses,
        "choices": trained.choices,
        "subspaces": model.subspaces,
        "connections": model.connections,
        "first_connections": model.first_connections,
        "settings": model.settings,
        "training": model.report,
    })
}

/// Writes a report, with the device, the time of loading and the most memory that there was at once.
///
/// # Errors
/// A file that cannot be written.
pub fn write_stats(
    path: &Path,
    mut value: serde_json::Value,
    context: &Context,
    load_seconds: f64,
) -> Result<(), CliError> {
    value["device"] = context.describe().into();
    value["load_seconds"] = load_seconds.into();
    value["peak_memory_bytes"] = peak_memory().into();
    Ok(write_atomic(path, serde_json::to_string_pretty(&value)?.as_bytes())?)
}
