//! `halfway bench trade`

mod lineup;
mod page;
mod plot;
mod results;
mod sheet;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::bench::speed::SpeedProbe;
use crate::bench::trade::{Checkpoint, Goal, Plan};
use crate::cli::args::{InputError, parse_duration};
use crate::cli::bench::maker_of;
use crate::cli::bench::reference::ReferenceArgs;
use crate::cli::bench::runs::{Ask, Drift, Records, SceneRenders, Series, check_longest};
use crate::cli::bench::scene::BenchSceneArgs;
use crate::cli::progress::install_interrupt;
use crate::cli::text::{command_line, today};
use crate::cli::{CliError, Exit};
use crate::film::denoise::Denoiser;
use crate::film::write::write_atomic;
use crate::out;

use lineup::Lineup;
use results::{SceneResult, Trade, scene_result};

/// What is measured and how, below the options of `--help`.
const METHOD: &str = "\
For every scene and every seed each integrator, and each value of each sweep, renders for --time, in an order that turns
from seed to seed. It is stopped, and its clock with it, after 8, 16, 32, ... samples per pixel, after --equal-samples, and
at the end, to compare the picture with the reference. Time is of rendering and of learning before, which every seed does
again; not of loading and compiling. A machine that others share is not always as fast: every other second the same small
work is timed (before and after, while spcbpt learns), and times are scaled by that to the usual speed. A point at 10 s is
of a render that may go on to --time: asked for 10 s from the start, spcbpt learns less.

Every render that is done is a line of DIR/runs.jsonl. The same command again, or one with more scenes, integrators, sweeps
or seeds, renders what is not there. Remove that file when the renderer itself has changed. Lines that an earlier version
wrote in another form are reported, left as they are and not used.

Made: DIR/trade.csv (every checkpoint of every render), DIR/trade.json (all figures), the page, and beside it one picture
of all plots, of the same name.";

/// The trade between speed and accuracy: error against time and samples, of integrators and of their settings.
#[derive(Args, Debug)]
#[command(after_long_help = METHOD)]
pub struct TradeArgs {
    #[command(flatten)]
    scenes: BenchSceneArgs,
    /// Integrators, with settings where the default is not meant: path,lvcbpt:connections=2,light-tracing,spcbpt.
    /// Ratios are to the first.
    #[arg(long, value_name = "LIST", default_value = "lvcbpt,spcbpt,path,bdpt")]
    integrators: String,
    /// Each integrator denoised as well, beside what it renders: a curve of its own, spcbpt:denoise. Denoising takes none of the
    /// time that is written.
    #[arg(long)]
    denoise: bool,
    /// A setting of an integrator (spcbpt if none is named) with values to try, all others at their defaults:
    /// connections=1,2,4 or lvcbpt:light-paths=1000,4000 or bdpt:light-tracing; may be given several times.
    #[arg(long, alias = "knob", value_name = "[INTEGRATOR:]SETTING=VALUES")]
    sweep: Vec<String>,
    /// Time of each render, learning included.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "30s")]
    time: Duration,
    /// A render that has not met --target by then, but may before long, goes on until it has, for this time at most.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    longest: Option<Duration>,
    /// Samples per pixel after which a render ends, time or not.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Renders of each.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    seeds: u32,
    /// Seeds count from here.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// The MAPE whose time is asked for, 0.12 = 12 %.
    #[arg(long, value_name = "ERROR", default_value_t = 0.12)]
    target: f64,
    /// The times whose error is asked for.
    #[arg(long, value_name = "TIMES", value_delimiter = ',', value_parser = parse_duration,
          default_value = "10s,30s,60s")]
    at: Vec<Duration>,
    /// Samples per pixel of the table at equal samples.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    equal_samples: u32,
    #[command(flatten)]
    reference: ReferenceArgs,
    /// Where runs and figures are kept.
    #[arg(short, long, value_name = "DIR", default_value = "target/trade")]
    output: PathBuf,
    /// The page to make, its plots in a picture of the same name beside it (default: DIR/trade.md).
    #[arg(long, value_name = "FILE.md")]
    markdown: Option<PathBuf>,
}

/// Renders what is not there yet, and makes files and page of all.
///
/// # Errors
/// Bad input, no device, files that cannot be written.
pub fn run(args: &TradeArgs, quiet: bool) -> Result<Exit, CliError> {
    let lineup = Lineup::new(args)?;
    if !(args.target > 0.0 && args.target.is_finite()) {
        return Err(
            InputError::Usage("--target takes a positive number, such as 0.12 for 12 %".into()).into()
        );
    }
    check_longest(args.time, args.longest)?;
    let mut denoiser = lineup.all.iter().any(|one| one.denoise).then(Denoiser::open).transpose()?;
    let store = args.reference.store()?;
    let page = args.markdown.clone().unwrap_or(args.output.join("trade.md"));
    let picture = page.with_extension("svg");
    for folder in [args.output.as_path(), page.parent().unwrap_or(&args.output)] {
        std::fs::create_dir_all(folder).map_err(CliError::folder(folder))?;
    }
    let file = args.output.join("runs.jsonl");
    let mut records = Records::open(&file)?;
    install_interrupt();
    let context = args.scenes.seen.picture.device.open_to_compare(quiet)?;
    let plan = Plan {
        time: Some(args.time),
        samples: args.spp,
        equal_samples: args.equal_samples,
        goal: args.longest.map(|longest| Goal { error: args.target, longest }),
        as_paper: false,
    };
    let series = Series { candidates: &lineup.all, plan, seeds: args.seeds, first_seed: args.seed };
    let mut probe: Option<SpeedProbe> = None;
    let mut all: Vec<SceneRenders> = Vec::new();
    for path in &args.scenes.paths {
        let bench_scene = args.scenes.seen.load(path)?;
        bench_scene.check_name(all.iter().map(|other| &other.bench_scene))?;
        let Some(reference) = store.reference(&context, &bench_scene, quiet)? else {
            return Ok(records.interrupted());
        };
        let renders = SceneRenders { context: &context, bench_scene, reference, quiet };
        if !renders.render_all(&series, &mut records, &mut probe, denoiser.as_mut())? {
            return Ok(records.interrupted());
        }
        all.push(renders);
    }
    let stored: Vec<Vec<Vec<&[Checkpoint]>>> =
        all.iter().map(|renders| renders.stored(&series, &records)).collect::<Result<_, _>>()?;
    // The usual speed is that over all scenes.
    let drift = Drift::of(stored.iter().flatten().flatten().copied());
    let seconds_per_unit = drift.map_or(1.0, |drift| drift.usual_seconds_per_unit);
    let at_usual_speed =
        |points: &&[Checkpoint]| points.iter().map(|point| point.at_speed(seconds_per_unit)).collect();
    let mut times: Vec<f64> = args.at.iter().map(Duration::as_secs_f64).collect();
    times.sort_by(f64::total_cmp);
    let ask = Ask { target: args.target, times: &times, equal_samples: args.equal_samples };
    let result = |(renders, stored): (&SceneRenders, &Vec<Vec<&[Checkpoint]>>)| {
        let runs = stored.iter().map(|seeds| seeds.iter().map(at_usual_speed).collect()).collect();
        scene_result(&renders.bench_scene, &renders.reference, &lineup, runs, &ask)
    };
    let scenes: Vec<SceneResult> = all.iter().zip(&stored).map(result).collect();
    let trade = Trade {
        date: today(),
        device: maker_of(&context),
        command: command_line(),
        version: env!("CARGO_PKG_VERSION"),
        seeds: args.seeds,
        seconds: args.time.as_secs_f64(),
        longest: args.longest.map(|longest| longest.as_secs_f64()),
        samples: args.spp,
        target: args.target,
        times: times.clone(),
        drift,
        equal_samples: args.equal_samples,
        scenes,
    };
    let json = serde_json::to_string_pretty(&trade)?;
    write_atomic(&args.output.join("trade.json"), json.as_bytes())?;
    write_atomic(&args.output.join("trade.csv"), trade.csv().as_bytes())?;
    write_atomic(&picture, sheet::sheet(&trade).svg().as_bytes())?;
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    write_atomic(&page, page::page(&trade, &name).as_bytes())?;
    for warning in trade.warnings() {
        log::warn!("{warning}");
    }
    out!("{}", page.display());
    let non_finite = trade.non_finite();
    if non_finite > 0 {
        eprintln!("error: {non_finite} samples were not finite; they are left out of the pictures");
        return Ok(Exit::NonFinite);
    }
    Ok(Exit::Done)
}
