//! `halfway render`

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, Parser as _};

use super::args::method::{MethodArgs, ModelArgs};
use super::args::picture::{PictureArgs, SeedArgs, ViewArgs};
use super::args::{
    CameraArgs, InputError, OutputArgs, SceneArgs, default_output, parse_crop, parse_duration,
    say_what_is_missing, try_format, try_output, try_output_folder,
};
use super::debug::Debug;
use super::keep::{KeepArgs, Keeper};
use super::output::{Format, Goal, Output, is_part, is_png};
use super::progress::{self, Meter};
use super::saves::Saves;
use super::trace::TraceArgs;
use super::{Cli, CliError, Command, Exit, passes, strategies, summary};
use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::checkpoint::SavedRender;
use crate::film::denoise::Denoiser;
use crate::film::{Exposure, Lost, Region, tev};
use crate::integrator::{Choice, Method, View};
use crate::out;
use crate::render::{
    Budget, Keeping, NoHalves, Origin, Prepared, Progress, RenderError, RenderOptions, Renderer, Report,
    Stop, TimeLimit,
};
use crate::scene::{Scene, SceneFeatures};
use crate::training::When;

/// Samples where no budget is given.
const DEFAULT_SAMPLES: u32 = 64;

/// Options of `halfway render`.
#[derive(Args, Debug)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the picture goes: .exr (linear, with layers) or .png (tone-mapped); may be given several times (default: the
    /// scene's name, .exr).
    ///
    /// EXR files are 32-bit linear Rec.709 with the layers albedo, normal, depth, variance and samples, and say in their
    /// metadata how they were made.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    outputs: OutputArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    model: ModelArgs,
    #[arg(long, value_name = "N", help = format!("Samples per pixel ({DEFAULT_SAMPLES} if no limit is given)"),
          long_help = format!("Samples per pixel ({DEFAULT_SAMPLES} if no limit is given).\n\nSamples come in groups of \
                               {SAMPLES_A_GROUP} whose points lie well apart: whole groups have the least noise, and the variance \
                               layer needs two."))]
    spp: Option<u32>,
    /// Time for rendering and pre-processing, such as 30s or 5m; loading and shader compilation come on top.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// Stop at this estimated error: the expected MAPE of the picture, 0.05 = 5 %. With --denoise it is that of the denoised
    /// picture, which is looked at now and then, for about a tenth of the time.
    #[arg(long, value_name = "ERROR")]
    error: Option<f64>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Render only this part: left, top, width, height in pixels.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    crop: Option<Region>,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    seed: SeedArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[arg(long, value_name = "DIR",
          help = format!("Also write every strategy (s light, t eye vertices) of a bidirectional integrator as a picture of \
                          its own, weighted and alone, with an overview of all; each takes the budget once more. Needs \
                          --max-depth, at most {}", strategies::LONGEST))]
    strategies: Option<PathBuf>,
    /// Also write pictures of what the method does, beside the first output: STEM.eye-subspaces.png and so on.
    #[arg(long, value_enum, value_name = "WHAT")]
    debug: Option<Debug>,
    /// Write a report with times per kernel, rays, memory per buffer, compile time and features.
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
    #[command(flatten)]
    pub keep: KeepArgs,
}

/// Renders and writes what was asked for.
///
/// # Errors
/// Bad input, no device, or a picture that cannot be written.
pub fn run(args: &RenderArgs, quiet: bool) -> Result<Exit, CliError> {
    let files = args.files()?;
    let denoiser = args.outputs.denoise.then(Denoiser::open).transpose()?;
    let viewer = args.tev.as_deref().map(tev::Viewer::connect).transpose()?;
    let load_start = Instant::now();
    let mut scene = args.scene.load()?;
    let camera = args.camera.choose(&mut scene)?;
    say_what_is_missing(&scene);
    let load_seconds = load_start.elapsed().as_secs_f64();
    let scene_hash = scene.content_hash();
    let named = args.named_method(&scene)?;
    let (method, light_tracing) = named.map_or((None, None), |(method, why)| (Some(method), why));
    let mut options = args.options(&scene, camera, &files, method)?;
    options.model = args.model.load(scene_hash, method)?;
    args.check_portion(method, &options, &scene)?;
    let strategies = match args.strategies {
        Some(_) => strategies::list(options.method, options.view.max_depth)?,
        None => Vec::new(),
    };
    let groups = if args.outputs.light_groups { passes::groups(&scene)? } else { Vec::new() };
    args.check_passes()?;
    let shown = options.view.region();
    let trace = args.trace.open([shown.width, shown.height])?;

    progress::install_interrupt();
    if args.keep.keeps() {
        progress::install_warning();
    }
    let device = args.picture.device.tracing_by(args.keep.traced_by()?);
    let context = progress::watched(&device.open(quiet)?, quiet);
    // Chosen before anything is kept: what is kept names it.
    let chosen = match method {
        Some(_) => None,
        None => Some(Prepared::automatic(&context, &scene, options.clone())?),
    };
    let mut told = Vec::new();
    if let Some(prepared) = &chosen {
        options = prepared.options().clone();
        if !quiet {
            told.clone_from(&prepared.report().choices);
            progress::say_choices(&told);
        }
    }
    let origin = Origin {
        method: options.method,
        seed: options.view.seed,
        scene_hash,
        device: context.describe(),
        command_line: format!("halfway {}", args.keep.command().join(" ")),
    };
    let keeping = args.keep.keeping(&scene, &options, &origin);
    let taken_up = args.keep.take_up(&keeping, &mut options)?;
    let prepared = match (groups.first(), chosen) {
        (Some(first), _) => {
            options = passes::of_group(&options, &scene, groups.len());
            Prepared::new(&context, &first.alone(&scene), options.clone())?
        }
        (None, Some(chosen)) if taken_up.is_none() => chosen,
        (None, _) => Prepared::new(&context, &scene, options.clone())?,
    };
    let mut renderer = prepare(prepared.with_choice(light_tracing), quiet)?;
    args.keep.begin(&mut renderer, taken_up)?;
    let goal = args.outputs.denoise.then_some(args.error).flatten();
    if goal.is_some() {
        args.check_goal(&renderer)?;
        // The error that counts is that of another picture.
        renderer.set_budget(Budget { error: None, ..options.budget });
    }
    let mut keeper = args.keep.keeper(keeping.clone(), &options, quiet);
    if let Some(keeper) = keeper.as_mut().filter(|_| renderer.learning_time().total > Duration::ZERO) {
        // What was learnt is not to be learnt again.
        let _ = keeper.write(&mut renderer)?;
    }
    let mut output = Output {
        files,
        origin,
        format: Format {
            coding: args.outputs.coding(),
            depth: args.outputs.depth(),
            view: args.view.view,
            exposure: args.view.exposure,
        },
        save_every: args.save_every,
        denoiser,
        goal: goal.map(Goal::new),
        viewer,
        title: args.scene.scene.to_string_lossy().into_owned(),
        trace,
        last_save: Instant::now(),
        last_view: Instant::now(),
        unsaved: false,
        saves: Saves::default(),
    };
    let meter = meter(quiet, &args.shown_budget(&options.budget), renderer.learning_time().total);
    let stop = render(&mut renderer, &mut output, &mut keeper, meter, &options.budget)?;
    let mut kept = None;
    if let Some(mut keeper) = keeper {
        let written = keeper.write(&mut renderer)?;
        kept = Some(keeper.path);
        if stop == Stop::Interrupted {
            written?;
        }
    }
    let mut report = renderer.report()?;
    if let Some(range) = &args.keep.samples {
        if let Some(path) = &args.stats {
            summary::write_stats(path, serde_json::to_value(&report)?, &context, load_seconds)?;
        }
        if !quiet {
            summary::rendered(&report, load_seconds, &options, &told);
        }
        return match stop {
            Stop::Interrupted => Ok(stopped(kept.as_deref(), range.start + report.samples)),
            _ => args.write_portion(&mut renderer, &keeping, &output.files[0], &report),
        };
    }
    let mut picture = renderer.picture()?;
    let halves = renderer.halves()?.map_err(|reason| args.why_no_halves(reason));
    if !groups.is_empty() {
        picture = passes::add_groups(&context, &scene, &groups, &options, picture, &mut report)?;
    }
    if args.outputs.direct() {
        passes::add_direct(&context, &scene, &options, &mut picture, &mut report)?;
    }
    let infinite = picture.non_finite_values();
    let stops = output.format.exposure.stops(&picture);
    let lost = Lost::judge(&picture, output.format.view, stops);
    output.format.exposure = Exposure::Stops(stops);
    let judged = output.finish(picture, halves, &mut report);
    let Output { files, mut saves, .. } = output;

    if let Some(path) = &args.stats {
        let stats = serde_json::to_value(&report).map_err(CliError::from);
        let written = stats.and_then(|stats| summary::write_stats(path, stats, &context, load_seconds));
        saves.report(path, written);
    }
    if !quiet {
        summary::rendered(&report, load_seconds, &options, &told);
        judged.iter().for_each(summary::judged);
        if args.view.exposure == Exposure::Auto {
            eprintln!("--exposure auto is {stops} stops");
        }
    }
    summary::warned(report.warnings.len(), &args.scene.scene);
    summary::warn_of_depth(report.rays.deep_paths());
    if !quiet || args.error.is_some() {
        report.caveats.iter().for_each(|caveat| log::warn!("{caveat}"));
    }
    lost.iter().for_each(|lost| log::warn!("{lost}"));
    if let Some(Err(error)) = args.debug.map(|debug| debug.write(&mut renderer, &files[0], &mut saves)) {
        saves.fail(error);
    }
    if let Some(folder) = args.strategies.as_deref().filter(|_| stop != Stop::Interrupted) {
        let interrupted = progress::interrupted;
        let view = args.view.view;
        let written =
            strategies::write(&mut renderer, &options, &strategies, folder, view, &mut saves, interrupted);
        saves.picture(folder, written);
    }
    let exit = args.exit(&report, infinite, stop);
    saves.end()?;
    Ok(exit)
}

impl RenderArgs {
    /// What the command of a file asks for, and whether it says no more than it has to.
    ///
    /// # Errors
    /// Why it is no render.
    pub fn of(command: &[String]) -> Result<(Box<Self>, bool), String> {
        let program = std::iter::once("halfway".to_owned());
        let cli =
            Cli::try_parse_from(program.chain(command.iter().cloned())).map_err(|error| error.to_string())?;
        match cli.command {
            Command::Render(render) => Ok((render, cli.quiet)),
            _ => Err("it is of no render".into()),
        }
    }

    /// The integrator that is asked for, or that of the render to go on with, for which it was chosen before, as the scene
    /// wants it; `None` where it is to be chosen.
    fn named_method(&self, scene: &Scene) -> Result<Option<(Method, Option<Choice>)>, CliError> {
        if let Some(named) = self.method.named_for(scene)? {
            return Ok(Some(named));
        }
        let Some(path) = self.keep.resumes() else { return Ok(None) };
        let command = SavedRender::read_header(path)?.command;
        // A file whose command is none of this version's is refused with all that differs.
        let before = Self::of(&command).ok();
        Ok(before.map(|(render, _)| render.method.named_for(scene)).transpose()?.flatten())
    }

    /// The pictures to write, after every output was tried.
    fn files(&self) -> Result<Vec<PathBuf>, InputError> {
        let files = match (self.output.is_empty(), &self.keep.samples) {
            (true, None) => vec![default_output(&self.scene.scene, "exr")],
            (true, Some(range)) => {
                vec![default_output(&self.scene.scene, &format!("{}-{}.part", range.start, range.end))]
            }
            (false, _) => self.output.clone(),
        };
        match self.keep.samples {
            None => files.iter().try_for_each(|file| try_format(file, &["exr", "png"]))?,
            Some(_) => check_portion(&files)?,
        }
        self.keep.try_outputs()?;
        let debug = self.debug.map(|debug| debug.files(&files[0])).unwrap_or_default();
        debug.iter().chain(&self.stats).try_for_each(|file| try_output(file))?;
        self.trace.try_output()?;
        self.strategies.iter().try_for_each(|folder| try_output_folder(folder))?;
        Ok(files)
    }

    /// # Errors
    /// An error that cannot be looked at.
    fn check_goal(&self, renderer: &Renderer) -> Result<(), InputError> {
        match renderer.keeps_halves() {
            true => Ok(()),
            false => Err(InputError::Usage(
                "--error with --denoise goes by the denoised picture, whose error is not known: the checkpoint was rendered \
                 without --denoise. Leave out --error, or --denoise"
                    .into(),
            )),
        }
    }

    /// Why nothing is known of the denoised picture's error.
    fn why_no_halves(&self, reason: NoHalves) -> String {
        match reason {
            NoHalves::OneGroup => format!("that takes more than {SAMPLES_A_GROUP} samples per pixel"),
            NoHalves::NotKept if self.outputs.light_groups => "its lights were rendered one by one".into(),
            NoHalves::NotKept => "the checkpoint was rendered without --denoise".into(),
        }
    }

    /// What is rendered in several passes has no picture on the way, and none of one method and one model.
    fn check_passes(&self) -> Result<(), InputError> {
        let flags = [
            ("--error", self.error.is_some()),
            ("--save-every", self.save_every.is_some()),
            ("--tev", self.tev.is_some()),
            ("--trace-error", self.trace.is_given()),
            ("--strategies", self.strategies.is_some()),
            ("--debug", self.debug.is_some()),
            ("--model", self.model.is_given()),
            ("--checkpoint or --resume", self.keep.keeps() || self.keep.resumes().is_some()),
        ];
        match flags.into_iter().find(|&(_, given)| given && self.outputs.light_groups) {
            Some((flag, _)) => Err(InputError::Usage(format!(
                "--light-groups renders lights one after the other, which does not go together with {flag}; leave one out"
            ))),
            None => Ok(()),
        }
    }

    fn options(
        &self,
        scene: &Scene,
        camera: usize,
        files: &[PathBuf],
        method: Option<Method>,
    ) -> Result<RenderOptions, InputError> {
        let no_limit = self.spp.is_none() && self.time.is_none() && self.error.is_none();
        let samples = if no_limit { Some(DEFAULT_SAMPLES) } else { self.spp };
        let portion = self.keep.samples.as_ref();
        let samples = portion.map_or(samples, |range| Some(range.end));
        if self.error.is_some_and(|error| error.is_nan() || error <= 0.0) {
            return Err(InputError::Usage("--error takes a positive number, such as 0.05 for 5 %".into()));
        }
        if self.spp == Some(0) {
            return Err(InputError::Usage("--spp takes at least 1 sample per pixel".into()));
        }
        // What is chosen later has no settings, strategies or subspaces that could be asked for.
        let method = method.unwrap_or_default();
        if let Some(debug) = self.debug {
            debug.check(method)?;
        }
        let picture = self.picture.options(scene, camera);
        // A PNG has no room for layers.
        // They are the same in all portions: the first one has them.
        let first = portion.is_none_or(|range| range.start == 0);
        let layers =
            self.outputs.denoise || self.tev.is_some() || self.strategies.is_some() || self.debug.is_some();
        let linear = !files.iter().all(|file| is_png(file));
        let options = RenderOptions {
            view: View { crop: self.crop, seed: self.seed.seed, ..picture.view },
            method,
            budget: Budget { samples, time: self.time.map(TimeLimit::Total), error: self.error },
            first_hit_layers: (layers || linear) && first,
            timing: self.stats.is_some(),
            training: self.method.training()?,
            ..picture
        };
        self.outputs.apply(self.method.apply(options), linear)
    }

    /// # Errors
    /// A portion that would choose or learn for itself alone, or is asked for more than its samples.
    fn check_portion(
        &self,
        method: Option<Method>,
        options: &RenderOptions,
        scene: &Scene,
    ) -> Result<(), InputError> {
        if self.keep.samples.is_some() && method.is_none() {
            return Err(InputError::Usage(
                "all portions of a picture are made by one integrator: name it with -i, such as -i path"
                    .into(),
            ));
        }
        if self.keep.samples.is_some() && self.outputs.of_pictures() {
            return Err(InputError::Usage(
                "a portion has the samples of a picture alone: leave out --denoise, --transparent, --layers and \
                 --light-groups"
                    .into(),
            ));
        }
        let learns = options.method.plan().learns() && options.model.is_none();
        match self.keep.samples.is_some() && learns && SceneFeatures::of(scene).lights() {
            false => Ok(()),
            true => Err(InputError::Usage(
                "all portions of a picture connect by one model: learn it with `halfway train`, and give it to each with \
                 --model"
                    .into(),
            )),
        }
    }

    /// What there is to do, as the progress counts it: of a portion only its own.
    fn shown_budget(&self, budget: &Budget) -> Budget {
        let first = self.keep.samples.as_ref().map_or(0, |range| range.start);
        Budget { samples: budget.samples.map(|samples| samples - first), ..*budget }
    }

    /// Writes the portion that was rendered.
    fn write_portion(
        &self,
        renderer: &mut Renderer,
        keeping: &Keeping,
        file: &Path,
        report: &Report,
    ) -> Result<Exit, CliError> {
        let mut layers = renderer.picture()?.layers;
        // Samples tell these.
        layers.retain(|layer| layer.name != "variance" && layer.name != "samples");
        renderer.saved(keeping, layers)?.save(file)?;
        out!("{}", file.display());
        summary::warned(report.warnings.len(), &self.scene.scene);
        summary::warn_of_depth(report.rays.deep_paths());
        Ok(self.exit(report, 0, report.stop))
    }

    /// How the program ends after a picture was written. `infinite`: values in it that f32 cannot hold.
    fn exit(&self, report: &Report, infinite: usize, stop: Stop) -> Exit {
        if let Some(fault) = faults(infinite, report.non_finite) {
            fault
        } else if stop == Stop::Interrupted {
            Exit::Interrupted
        } else if self.error.is_some() && stop != Stop::Error {
            Exit::ErrorNotMet
        } else {
            Exit::Done
        }
    }
}

/// Of values of a picture that f32 cannot hold, and samples that are not finite; says so.
pub fn faults(infinite: usize, non_finite: u64) -> Option<Exit> {
    if infinite > 0 {
        eprintln!(
            "error: {infinite} values of the picture are infinite: they are beyond {:.1e}, the largest number of its files. \
             Make the scene's lights weaker.",
            f32::MAX
        );
    } else if non_finite > 0 {
        eprintln!(
            "error: {non_finite} samples were not finite; they are left out of the picture. Please report the scene."
        );
    }
    (infinite > 0 || non_finite > 0).then_some(Exit::NonFinite)
}

/// Says what became of a portion that is not whole.
fn stopped(kept: Option<&Path>, next: u32) -> Exit {
    match kept {
        Some(path) => eprintln!("stopped at sample {next}; go on with: halfway resume {}", path.display()),
        None => eprintln!("stopped at sample {next}, and nothing is kept: that takes --checkpoint"),
    }
    Exit::Interrupted
}

fn check_portion(files: &[PathBuf]) -> Result<(), InputError> {
    match files {
        [file] if is_part(file) => try_output(file),
        _ => Err(InputError::Usage(
            "--samples makes a portion, which goes to one file: name it .part; `halfway merge` makes pictures".into(),
        )),
    }
}

/// Learns, where that is done first, and compiles. Returns the time of learning, too.
fn prepare(mut prepared: Prepared, quiet: bool) -> Result<Renderer, RenderError> {
    if prepared.learns() == Some(When::First) {
        progress::learn(&mut prepared, quiet)?;
    }
    prepared.renderer()
}

/// Renders until the budget is spent or Ctrl-C, and does on the way what is due with the picture.
fn render(
    renderer: &mut Renderer,
    output: &mut Output,
    keeper: &mut Option<Keeper>,
    mut meter: Meter,
    budget: &Budget,
) -> Result<Stop, CliError> {
    loop {
        // A pause of the loop, to save, to show or to judge the picture, is no end.
        let (mut keep, mut look) = (false, false);
        let stop = renderer.run(|progress| {
            show(&mut meter, progress, output.denoised_error(), budget);
            keep = keeper.as_ref().is_some_and(Keeper::is_due);
            look = output.is_due(progress.samples);
            let pause = keep || look;
            pause || progress::interrupted()
        })?;
        if !(keep || look) || progress::interrupted() {
            meter.finish();
            return Ok(stop);
        }
        if let Some(keeper) = keeper.as_mut().filter(|_| keep) {
            let _ = keeper.write(renderer)?;
        }
        if look {
            output.update(renderer)?;
        }
        if output.has_met_goal() {
            meter.finish();
            renderer.end(Stop::Error);
            return Ok(Stop::Error);
        }
    }
}

/// `learning` is part of a budget of time, and over.
fn meter(quiet: bool, budget: &Budget, learning: Duration) -> Meter {
    Meter::new(
        quiet,
        match (budget.samples, budget.time) {
            (Some(samples), _) => Some(u64::from(samples)),
            (None, Some(time)) => Some(time.for_rendering(learning).as_millis() as u64),
            (None, None) => None,
        },
    )
}

/// `denoised`: the error of the denoised picture, where it is looked at.
fn show(meter: &mut Meter, progress: &Progress, denoised: Option<f64>, budget: &Budget) {
    let percent = |name: &str, error: Option<f64>| {
        error.map_or(String::new(), |error| format!(", {name} {:.1} %", 100.0 * error))
    };
    let error = percent("error", progress.estimated_error) + &percent("denoised", denoised);
    let position = match budget.samples {
        Some(_) => u64::from(progress.samples),
        None => progress.elapsed.as_millis() as u64,
    };
    meter.show(position, format!("{} spp{error}", progress.samples));
}
