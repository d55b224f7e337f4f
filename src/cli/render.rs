//! `halfway render`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Args;

use super::args::method::MethodArgs;
use super::args::picture::{PictureArgs, ViewArgs};
use super::args::{
    CameraArgs, InputError, SceneArgs, check_folder, command_line, default_output, open_device, parse_crop,
    parse_duration,
};
use super::debug::Debug;
use super::progress::{self, Meter};
use super::trace::TraceArgs;
use super::train::held_out_gain;
use super::{Exit, strategies};
use crate::bench::trade::Checkpoint;
use crate::device::Context;
use crate::film::{Picture, Region, exr, png, tev};
use crate::integrator::Method;
use crate::render::{Budget, Origin, Prepared, Progress, RenderOptions, Report, Stop};
use crate::scene::Scene;
use crate::subspace::Model;
use crate::training::When;

/// Samples where no budget is given.
const DEFAULT_SAMPLES: u32 = 64;

/// Render a scene. The first limit of --spp, --time and --error that is met ends the render.
#[derive(Args, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the picture goes: .exr (linear, with layers) or .png (tone-mapped); may be given several times.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    method: MethodArgs,
    /// Connect by a model that `halfway train` wrote for this scene, in place of learning first (spcbpt).
    #[arg(long, value_name = "FILE.model", conflicts_with_all = ["LearnArgs", "learn", "quality"])]
    model: Option<PathBuf>,
    /// Samples a pixel (64 if no limit is given).
    #[arg(long, value_name = "N")]
    spp: Option<u32>,
    /// Time for rendering and pre-processing, such as 30s or 5m; loading and shader compilation come on top.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// Stop at this estimated error: the expected MAPE of the picture, 0.05 = 5 %.
    #[arg(long, value_name = "ERROR")]
    error: Option<f64>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Render only this part: left, top, width, height in pixels.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<Region>,
    #[command(flatten)]
    camera: CameraArgs,
    /// Same seed, same device: the same picture, bit for bit.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    view: ViewArgs,
    /// Also write every strategy (s light, t eye vertices) of a bidirectional integrator as a picture of its own, as
    /// its weighted share and alone, with an overview of all; each takes the budget once more. Needs --max-depth.
    #[arg(long, value_name = "DIR")]
    strategies: Option<PathBuf>,
    /// Also write pictures of what the method does, beside the first output.
    #[arg(long, value_enum, value_name = "WHAT")]
    debug: Option<Debug>,
    /// Write a report with times, memory, rays and features.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    trace: TraceArgs,
    /// Show the picture in the tev viewer while it renders (default address 127.0.0.1:14158).
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = tev::DEFAULT_ADDRESS)]
    tev: Option<String>,
    /// Save the picture so far at this interval.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    save_every: Option<Duration>,
}

/// Renders and writes what was asked for.
///
/// # Errors
/// Bad input, no device, or a picture that cannot be written.
pub fn run(args: &RenderArgs, quiet: bool) -> anyhow::Result<Exit> {
    let outputs = match args.output.is_empty() {
        true => vec![default_output(&args.scene.scene, "exr")],
        false => args.output.clone(),
    };
    for output in &outputs {
        check_output(output)?;
    }
    let mut viewer = args.tev.as_deref().map(tev::Viewer::connect).transpose()?;
    let load_start = Instant::now();
    let mut scene = args.scene.load()?;
    let camera = args.camera.choose(&mut scene)?;
    say_what_is_missing(&scene);
    let load_seconds = load_start.elapsed().as_secs_f64();

    let mut options = options(args, &scene, camera)?;
    if let Some(debug) = args.debug {
        debug.check(options.method)?;
    }
    let scene_hash = scene.content_hash();
    if let Some(path) = &args.model {
        options.model = Some(load_model(path, scene_hash, options.method)?);
    }
    let strategies = match args.strategies {
        Some(_) => strategies::list(options.method, options.max_depth)?,
        None => Vec::new(),
    };
    let shown = options.region();
    let mut trace = args.trace.open([shown.width, shown.height])?;

    progress::install_interrupt();
    let context = open_device(&args.picture.device, quiet)?;
    let mut prepared = Prepared::new(&context, &scene, options.clone())?;
    let mut learning = Duration::ZERO;
    if prepared.learns() == Some(When::First) {
        let trained = progress::learn(&mut prepared, quiet)?;
        learning = trained.tracing + trained.learning;
    }
    let mut renderer = prepared.renderer()?;
    let mut meter = meter(quiet, &options.budget, learning);
    let (mut last_save, mut last_view) = (Instant::now(), Instant::now());
    let title = args.scene.scene.to_string_lossy();
    let origin = Origin {
        method: options.method,
        seed: options.seed,
        scene_hash,
        device: context.describe(),
        command_line: command_line(),
    };
    let record = Record { args, origin };
    let stop = loop {
        // A pause of the loop, to save, to show or to judge the picture, is no end.
        let mut pause = false;
        let stop = renderer.run(|progress| {
            show(&mut meter, progress, &options.budget);
            pause = args.save_every.is_some_and(|every| last_save.elapsed() >= every)
                || (viewer.is_some() && last_view.elapsed() >= Duration::from_secs(1))
                || trace.as_ref().is_some_and(|trace| trace.is_due(progress.samples));
            pause || progress::interrupted()
        })?;
        if !pause || progress::interrupted() {
            break stop;
        }
        let picture = renderer.picture()?;
        if let Some(trace) = trace.as_mut().filter(|trace| trace.is_due(renderer.samples())) {
            trace.add(&renderer.report()?, &picture)?;
        }
        if let Some(viewer) = &mut viewer {
            viewer.show(&title, &picture)?;
            last_view = Instant::now();
        }
        if args.save_every.is_some_and(|every| last_save.elapsed() >= every) {
            record.write(&outputs, picture, &renderer.report()?)?;
            last_save = Instant::now();
        }
    };
    meter.finish();

    let report = renderer.report()?;
    let picture = renderer.picture()?;
    if let Some(viewer) = &mut viewer {
        viewer.show(&title, &picture)?;
    }
    let judged = trace.as_mut().map(|trace| trace.add(&report, &picture)).transpose();
    record.write(&outputs, picture, &report)?;
    // A full disk is heard of after the picture is safe.
    let judged = judged?;
    if let Some(path) = &args.stats {
        write_stats(path, &report, &context, load_seconds)?;
    }
    if !quiet {
        summary(&report, load_seconds, &options);
        if let Some(Checkpoint { mape, relmse, mean_ratio, .. }) = judged {
            eprintln!(
                "against the reference: MAPE {:.2} %, relMSE {relmse:.3e}, mean ratio {mean_ratio:.4}",
                100.0 * mape
            );
        }
    }
    for output in &outputs {
        println!("{}", output.display());
    }
    if let Some(debug) = args.debug {
        for path in debug.write(&mut renderer, &outputs[0])? {
            println!("{}", path.display());
        }
    }
    if let Some(directory) = args.strategies.as_deref().filter(|_| stop != Stop::Interrupted) {
        strategies::write(
            &mut renderer,
            &options,
            &strategies,
            directory,
            args.view.view,
            progress::interrupted,
        )?;
        println!("{}", directory.display());
    }
    Ok(if report.non_finite > 0 {
        eprintln!(
            "error: {} samples were not finite; they are left out of the picture. Please report the scene.",
            report.non_finite
        );
        Exit::NonFinite
    } else if stop == Stop::Interrupted {
        Exit::Interrupted
    } else if args.error.is_some() && stop != Stop::Error {
        Exit::ErrorNotMet
    } else {
        Exit::Done
    })
}

fn options(args: &RenderArgs, scene: &Scene, camera: usize) -> Result<RenderOptions, InputError> {
    let no_limit = args.spp.is_none() && args.time.is_none() && args.error.is_none();
    let samples = if no_limit { Some(DEFAULT_SAMPLES) } else { args.spp };
    if args.error.is_some_and(|error| error.is_nan() || error <= 0.0) {
        return Err(InputError::Usage("--error takes a positive number, such as 0.05 for 5 %".into()));
    }
    if args.spp == Some(0) {
        return Err(InputError::Usage("--spp takes at least 1 sample a pixel".into()));
    }
    Ok(RenderOptions {
        crop: args.crop,
        seed: args.seed,
        method: args.method.method()?,
        budget: Budget { samples, time: args.time, error: args.error },
        first_hit_layers: true,
        timing: args.stats.is_some(),
        training: args.method.training()?,
        ..args.picture.options(scene, camera)
    })
}

pub fn load_model(path: &Path, scene_hash: u64, method: Method) -> anyhow::Result<Arc<Model>> {
    let plan = method.plan();
    if !plan.learns() {
        return Err(InputError::Usage(
            "--model is a setting of spcbpt; leave it out, or add --integrator spcbpt".into(),
        )
        .into());
    }
    let connections = plan.connections;
    let model = Model::load(path, scene_hash)?;
    if model.settings.connections != connections {
        // No error: unbiased all the same, only not the least noise.
        log::info!(
            "the model was trained for {} connections, this render has {connections}",
            model.settings.connections
        );
    }
    Ok(Arc::new(model))
}

pub fn say_what_is_missing(scene: &Scene) {
    if scene.triangle_count() == 0 {
        log::warn!("the scene has no triangles; only its environment, if any, will be seen");
    }
    if !crate::scene::SceneFeatures::of(scene).lights() {
        log::warn!(
            "the scene has no light: the picture will be black. Give it an emissive material, a \
             KHR_lights_punctual light, or an environment with --env"
        );
    }
}

fn check_output(output: &Path) -> Result<(), InputError> {
    check_folder(output)?;
    match output.extension().and_then(|extension| extension.to_str()) {
        Some("exr" | "png") => Ok(()),
        _ => Err(InputError::Usage(format!(
            "cannot tell the format of '{}'; name it .exr or .png",
            output.display()
        ))),
    }
}

/// `learning` is part of a budget of time, and over.
fn meter(quiet: bool, budget: &Budget, learning: Duration) -> Meter {
    Meter::new(
        quiet,
        match (budget.samples, budget.time) {
            (Some(samples), _) => Some(u64::from(samples)),
            (None, Some(time)) => Some(time.saturating_sub(learning).as_millis() as u64),
            (None, None) => None,
        },
    )
}

fn show(meter: &mut Meter, progress: &Progress, budget: &Budget) {
    let error =
        progress.estimated_error.map_or(String::new(), |error| format!(", error {:.1} %", 100.0 * error));
    let position = match budget.samples {
        Some(_) => u64::from(progress.samples),
        None => progress.elapsed.as_millis() as u64,
    };
    meter.show(position, format!("{} spp{error}", progress.samples));
}

fn summary(report: &Report, load_seconds: f64, options: &RenderOptions) {
    let rate =
        f64::from(report.samples) * f64::from(options.width) * f64::from(options.height) / report.seconds;
    let reason = match report.stop {
        Stop::Samples => "--spp reached",
        Stop::Time => "--time reached",
        Stop::Error => "--error reached",
        Stop::Interrupted => "interrupted",
    };
    let error =
        report.estimated_error.map_or(String::new(), |e| format!(", estimated error {:.2} %", 100.0 * e));
    eprintln!(
        "{} spp in {:.2} s ({:.2} M samples/s){error}; {reason}. Before that: loading {load_seconds:.2} s, BVH {:.2} s, \
         compiling {:.2} s.",
        report.samples,
        report.seconds,
        rate * 1e-6,
        report.accel_seconds,
        report.compile_seconds
    );
    progress::say_choices(&report.choices);
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

/// Writes pictures.
struct Record<'a> {
    args: &'a RenderArgs,
    origin: Origin,
}

impl Record<'_> {
    fn write(&self, outputs: &[PathBuf], mut picture: Picture, report: &Report) -> anyhow::Result<()> {
        picture.metadata = report.metadata(&self.origin);
        for output in outputs {
            if output.extension().is_some_and(|extension| extension == "png") {
                png::write(output, &picture, self.args.view.view, self.args.view.exposure)
            } else {
                exr::write(output, &picture)
            }
            .with_context(|| format!("the picture was not saved to {}", output.display()))?;
        }
        Ok(())
    }
}

fn write_stats(path: &Path, report: &Report, context: &Context, load_seconds: f64) -> anyhow::Result<()> {
    let mut value = serde_json::to_value(report)?;
    value["device"] = context.describe().into();
    value["load_seconds"] = load_seconds.into();
    std::fs::write(path, serde_json::to_string_pretty(&value)?)
        .with_context(|| format!("cannot write the report to {}", path.display()))
}
