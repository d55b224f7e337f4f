//! `halfway bench trade`

mod page;
mod paper;
mod plot;
mod record;
mod results;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::bench::speed::SpeedProbe;
use crate::bench::trade::{Goal, Plan, Point, measure};
use crate::cli::args::{InputError, parse_duration};
use crate::cli::bench::candidate::{Candidate, Sweep, parse_integrators, parse_sweep};
use crate::cli::bench::reference::{ReferenceArgs, ReferenceFile};
use crate::cli::bench::scene::{BenchScene, BenchSceneArgs};
use crate::cli::progress::{install_interrupt, interrupted, learn};
use crate::cli::text::{command_line, short, today};
use crate::cli::{CliError, Exit};
use crate::device::Context;
use crate::film::write::write_atomic;
use crate::integrator::View;
use crate::math::fnv::fnv;
use crate::render::{Prepared, RenderError, RenderOptions};
use crate::training::When;

use record::{Drift, Key, Record, Records};
use results::{SceneResult, Trade, scene_result};

/// What is measured and how, below the options of `--help`.
const METHOD: &str = "\
For every scene and every seed each integrator, and each value of each knob, renders for --time, in an order that turns
from seed to seed. It is stopped, and its clock with it, after 8, 16, 32, ... samples a pixel, after --equal-samples, and
at the end, to compare the picture with the reference. Time is of rendering and of learning before, which every seed does
anew; not of loading and compiling. A machine that others share is not always as fast: every other second the same small
work is timed (before and after, while spcbpt learns), and times are scaled by that to the usual pace. A point at 10 s is of
a render that may go on to --time: asked for 10 s from the start, spcbpt learns less.

Every render that is done is a line of DIR/runs.jsonl. The same command again, or one with more scenes, integrators, knobs
or seeds, renders what is not there. Remove that file when the renderer itself has changed.

Made: DIR/trade.csv (every look at every render), DIR/trade.json (all figures), the page with its plots beside it.";

/// The trade between speed and accuracy: error against time and samples, of integrators and of their settings.
#[derive(Args, Debug)]
#[command(after_long_help = METHOD)]
pub struct TradeArgs {
    #[command(flatten)]
    subject: BenchSceneArgs,
    /// Integrators, with settings where the default is not meant: path,lvcbpt:connections=2,light-tracing,spcbpt.
    /// Ratios are to the first.
    #[arg(long, value_name = "LIST", default_value = "lvcbpt,spcbpt,path,bdpt")]
    integrators: String,
    /// A setting of an integrator (spcbpt if none is named) with values to try, all others at their defaults:
    /// connections=1,2,4 or lvcbpt:light-paths=1000,4000 or bdpt:light-tracing; may be given several times.
    #[arg(long, value_name = "[INTEGRATOR:]SETTING=VALUES")]
    knob: Vec<String>,
    /// Time of each render, learning included.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "30s")]
    time: Duration,
    /// A render that has not met --target by then, but may before long, goes on until it has, for this time at most.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    longest: Option<Duration>,
    /// Samples a pixel after which a render ends, time or not.
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
    /// Samples a pixel of the table at equal samples.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..))]
    equal_samples: u32,
    #[command(flatten)]
    reference: ReferenceArgs,
    /// Where runs and figures are kept.
    #[arg(short, long, value_name = "DIR", default_value = "target/trade")]
    output: PathBuf,
    /// The page to make, its plots in a folder of the same name beside it (default: DIR/trade.md).
    #[arg(long, value_name = "FILE.md")]
    markdown: Option<PathBuf>,
}

/// All that renders, and for which table.
struct Lineup {
    /// Each once: those of --integrators, then those that knobs add.
    all: Vec<Candidate>,
    /// How many of them are of --integrators.
    listed: usize,
    knobs: Vec<Sweep>,
}

impl Lineup {
    fn new(args: &TradeArgs) -> Result<Self, InputError> {
        let mut all: Vec<Candidate> = Vec::new();
        let knobs = args.knob.iter().map(|knob| parse_sweep(knob)).collect::<Result<Vec<_>, _>>()?;
        let listed = parse_integrators(&args.integrators)?;
        let is_new = |all: &[Candidate], one: &Candidate| all.iter().all(|other| other.label != one.label);
        for one in &listed {
            if !is_new(&all, one) {
                return Err(InputError::Usage(format!("--integrators names '{}' twice", one.label)));
            }
            all.push(one.clone());
        }
        for one in knobs.iter().flat_map(|knob| &knob.candidates) {
            if is_new(&all, one) {
                all.push(one.clone());
            }
        }
        Ok(Self { all, listed: listed.len(), knobs })
    }
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
    if args.longest.is_some_and(|longest| longest < args.time) {
        return Err(InputError::Usage(
            "--longest has to be at least --time; raise it, or leave it out".into(),
        )
        .into());
    }
    let keeper = args.reference.keeper()?;
    let page = args.markdown.clone().unwrap_or(args.output.join("trade.md"));
    let plots = page.with_extension("");
    for folder in [&args.output, &plots] {
        std::fs::create_dir_all(folder).map_err(CliError::folder(folder))?;
    }
    let kept = args.output.join("runs.jsonl");
    let mut records = Records::open(&kept)?;
    install_interrupt();
    let context = args.subject.picture.device.open(quiet)?;
    let plan = Plan {
        time: Some(args.time),
        samples: args.spp,
        equal_samples: args.equal_samples,
        goal: args.longest.map(|longest| Goal { error: args.target, longest }),
    };
    let mut gauge: Option<SpeedProbe> = None;
    let mut benches: Vec<Bench> = Vec::new();
    for path in &args.subject.scenes {
        let subject = args.subject.load(path)?;
        if benches.iter().any(|bench| bench.subject.name == subject.name) {
            return Err(InputError::Usage(format!(
                "two scenes are called '{}'; rename one, tables could not tell them apart",
                subject.name
            ))
            .into());
        }
        let Some(reference) = keeper.reference(&context, &subject, quiet)? else {
            return Ok(go_on(&kept, &records));
        };
        let bench = Bench { args, context: &context, subject, reference, plan, quiet };
        if !bench.render_all(&lineup, &mut records, &mut gauge)? {
            return Ok(go_on(&kept, &records));
        }
        benches.push(bench);
    }
    // What is usual is known now, over all scenes.
    let drift = Drift::of(benches.iter().flat_map(|bench| bench.found(&lineup, &records)).flatten());
    let usual_pace = drift.map_or(1.0, |drift| drift.usual_pace);
    let mut times: Vec<f64> = args.at.iter().map(Duration::as_secs_f64).collect();
    times.sort_by(f64::total_cmp);
    let ask = results::Ask { target: args.target, times: &times, equal_samples: args.equal_samples };
    let result = |bench: &Bench| {
        let runs = bench.runs(&lineup, &records, usual_pace);
        scene_result(&bench.subject, &bench.reference, &lineup.all, lineup.listed, &lineup.knobs, runs, &ask)
    };
    let scenes: Vec<SceneResult> = benches.iter().map(result).collect();
    let trade = Trade {
        date: today(),
        device: context.describe(),
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
    for (name, plot) in trade.plots() {
        write_atomic(&plots.join(name), plot.svg()?.as_bytes())?;
    }
    let folder = plots.file_name().unwrap_or_default().to_string_lossy().into_owned();
    write_atomic(&page, page::page(&trade, &folder).as_bytes())?;
    for warning in trade.warnings() {
        log::warn!("{warning}");
    }
    println!("{}", page.display());
    let non_finite = trade.non_finite();
    if non_finite > 0 {
        eprintln!("error: {non_finite} samples were not finite; they are left out of the pictures");
        return Ok(Exit::NonFinite);
    }
    Ok(Exit::Done)
}

fn go_on(kept: &std::path::Path, records: &Records) -> Exit {
    eprintln!(
        "interrupted: {} renders are kept in {}; the same command goes on from there",
        records.len(),
        kept.display()
    );
    Exit::Interrupted
}

/// One scene.
struct Bench<'a> {
    args: &'a TradeArgs,
    context: &'a Context,
    subject: BenchScene,
    reference: ReferenceFile,
    plan: Plan,
    quiet: bool,
}

impl Bench<'_> {
    /// What each candidate renders, seed by seed.
    fn keys(&self, lineup: &Lineup) -> Vec<Vec<Key>> {
        let seeds = self.args.seeds;
        lineup.all.iter().map(|one| (0..seeds).map(|round| self.key(one, round)).collect()).collect()
    }

    /// What is known of them.
    fn found<'r>(&self, lineup: &Lineup, records: &'r Records) -> Vec<Vec<&'r [Point]>> {
        let of = |key: &Key| records.find(key);
        self.keys(lineup).iter().map(|keys| keys.iter().filter_map(of).collect()).collect()
    }

    /// The same with times of the device at its usual pace.
    fn runs(&self, lineup: &Lineup, records: &Records, usual_pace: f64) -> Vec<Vec<Vec<Point>>> {
        let scaled = |points: &&[Point]| points.iter().map(|point| point.at_pace(usual_pace)).collect();
        let found = self.found(lineup, records);
        found.iter().map(|seeds| seeds.iter().map(scaled).collect()).collect()
    }

    /// Renders what is not there; false where Ctrl-C ended it.
    fn render_all(
        &self,
        lineup: &Lineup,
        records: &mut Records,
        gauge: &mut Option<SpeedProbe>,
    ) -> Result<bool, CliError> {
        let (count, seeds) = (lineup.all.len(), self.args.seeds);
        let keys = self.keys(lineup);
        let is_there = |key: &&Key| records.find(key).is_some();
        let there = keys.iter().flatten().filter(is_there).count();
        let mut left = count * seeds as usize - there;
        if there > 0 && !self.quiet {
            eprintln!("{}: {there} renders are there already, {left} to go", self.subject.name);
        }
        for round in 0..seeds {
            for place in 0..count {
                let index = if round.is_multiple_of(2) { place } else { count - 1 - place };
                let (candidate, key) = (&lineup.all[index], &keys[index][round as usize]);
                if records.find(key).is_some() {
                    continue;
                }
                if !self.quiet {
                    let longest = self.args.longest.unwrap_or(self.args.time);
                    let minutes = left as f64 * longest.as_secs_f64() / 60.0;
                    eprintln!(
                        "{}: seed {} of {seeds}, {}; {left} renders, at most {} min and their compiling",
                        self.subject.name,
                        round + 1,
                        candidate.label,
                        short(minutes)
                    );
                }
                let gauge = match gauge.as_mut() {
                    Some(gauge) => gauge,
                    None => gauge.insert(SpeedProbe::new(self.context)?),
                };
                let Some(points) = self.render(candidate, key.seed, gauge)? else { return Ok(false) };
                records.push(Record { key: key.clone(), points })?;
                left -= 1;
            }
        }
        Ok(true)
    }

    fn key(&self, candidate: &Candidate, round: u32) -> Key {
        let RenderOptions { view: View { width, height, max_depth, roulette_cap, .. }, camera, .. } =
            self.subject.options;
        // Renders share no random numbers, whoever else takes part: their errors are independent.
        let stream = fnv(candidate.label.as_bytes()) >> 33;
        Key {
            version: env!("CARGO_PKG_VERSION").into(),
            device: self.context.describe(),
            scene: self.subject.name.clone(),
            scene_hash: format!("{:016x}", self.subject.hash),
            size: [width, height],
            camera,
            max_depth,
            roulette_cap,
            integrator: candidate.label.clone(),
            settings: candidate.settings(),
            seed: stream << 32 | u64::from(self.args.seed.wrapping_add(round)),
            milliseconds: self.plan.time.map(|time| time.as_millis() as u64),
            samples: self.plan.samples,
            equal_samples: self.plan.equal_samples,
            goal: self.plan.goal.map(|goal| (goal.error, goal.longest.as_millis() as u64)),
            reference: format!("{:016x}", self.reference.hash()),
        }
    }

    /// Everything anew: who learns, learns with this seed.
    fn render(
        &self,
        candidate: &Candidate,
        seed: u64,
        gauge: &mut SpeedProbe,
    ) -> Result<Option<Vec<Point>>, CliError> {
        let options = RenderOptions { budget: self.plan.budget(), ..candidate.options(&self.subject, seed) };
        let mut prepared = Prepared::new(self.context, &self.subject.scene, options)?;
        let mut clock = gauge.clock()?;
        if prepared.learns() == Some(When::First) {
            match learn(&mut prepared, true) {
                Err(RenderError::Interrupted) => return Ok(None),
                learnt => drop(learnt?),
            }
        }
        let mut renderer = prepared.renderer()?;
        let truth = self.reference.truth(&self.subject);
        Ok(measure(&mut renderer, &self.plan, &truth, &mut clock, |_| interrupted())?)
    }
}
