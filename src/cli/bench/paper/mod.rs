//! `halfway bench paper`

mod insets;
mod page;
mod results;

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::candidate::Candidate;
use super::format::level;
use super::paper_figures;
use super::reference::{ReferenceArgs, ReferenceStore};
use super::runs::{Ask, Drift, Records, SceneRenders, Series, check_longest};
use super::scene::{BenchScene, SeenArgs};
use crate::bench::speed::SpeedProbe;
use crate::bench::trade::{Checkpoint, Goal, Plan};
use crate::cli::args::method::parse_record_share;
use crate::cli::args::{InputError, parse_duration};
use crate::cli::bench::maker_of;
use crate::cli::progress::install_interrupt;
use crate::cli::text::{command_line, today};
use crate::cli::{CliError, Exit};
use crate::device::{Context, DeviceError};
use crate::film::write::write_atomic;
use crate::integrator::method::Setting;
use crate::integrator::{Descriptor, METHODS, PcBpt};
use crate::out;
use crate::render::RenderError;

use insets::Insets;
use results::{More, Paper, SceneResult};

/// The paper's own.
const TARGET: f64 = 0.12;
const EQUAL_SAMPLES: u32 = 100;
/// Samples of its comparison with records of more candidates.
const MORE_SAMPLES: u32 = 64;
/// What makes a method's label that of its published form.
const PUBLISHED: &str = ":as-published";

/// What is measured and how, below the options of `--help`.
const METHOD: &str = "\
Every method that connects to light vertices which the whole picture shares, once with --as-published and once with its
defaults, renders each scene for --time, and for up to --longest where 12 % are near. Errors are those of the paper: MAPE is
the mean over pixels of the channels' mean of |a - b| / (b + 0.01), at most 10 a pixel. Renders are written down and used
again as in `halfway bench trade`, and times are scaled to the usual speed of the machine as there.

Made: DIR/paper.json (all figures), the page, and beside it for every scene a picture of what each method has made of it
after --inset-time.";

/// The tables of the paper on SPCBPT, measured here: LVCBPT, PCBPT, RISBPT and SPCBPT as published and as they are.
#[derive(Args, Debug)]
#[command(after_long_help = METHOD)]
pub struct PaperArgs {
    /// .gltf or .glb files (default: the scenes of the folder `scenes` that have the names of the paper's).
    #[arg(value_name = "SCENE")]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    seen: SeenArgs,
    /// Time of each render, beside learning.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "60s")]
    time: Duration,
    /// A render that has not met 12 % by then, but may before long, goes on until it has, for this time at most.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    longest: Option<Duration>,
    /// Renders of each.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    seeds: u32,
    /// Seeds count from here.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Training paths of methods that learn, as published (default: those of --as-published). A million take minutes on a CPU
    /// where light is hard to find.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    train_paths: Option<u32>,
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..),
          default_values_t = [PcBpt::LIGHT_PATHS, 4 * PcBpt::LIGHT_PATHS, 16 * PcBpt::LIGHT_PATHS],
          help = format!("Light paths that methods by records draw from in the comparison after {MORE_SAMPLES} samples, as far as \
                          their tables fit the device"))]
    more: Vec<u32>,
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_record_share, default_value = "0.06",
          help = format!("Shares of the pixels that leave records, in the same comparison: beside {}, the default",
                         PcBpt::RECORD_SHARE))]
    more_records: Vec<f64>,
    /// Time of the pictures that are shown side by side, beside learning.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "30s")]
    inset_time: Duration,
    #[command(flatten)]
    reference: ReferenceArgs,
    /// Where runs, pictures and figures are kept.
    #[arg(short, long, value_name = "DIR", default_value = "target/paper")]
    output: PathBuf,
    /// The page to make, its pictures beside it (default: DIR/paper.md).
    #[arg(long, value_name = "FILE.md")]
    markdown: Option<PathBuf>,
}

/// All that is rendered of each scene.
struct Lineup {
    /// Published and shipped by turns, in the order of [`methods`].
    methods: Vec<Candidate>,
    /// Methods by records with more light paths or more records, and with how many.
    more: Vec<(&'static str, String, Candidate)>,
}

/// The methods that are compared, the simplest first.
fn methods() -> impl Iterator<Item = &'static str> {
    let order = |takes: bool| {
        METHODS
            .into_iter()
            .filter(|method| method.takes(Setting::Connections))
            .filter(move |method| method.takes(Setting::Learning) == takes)
            .map(|method| method.name)
    };
    order(false).chain(order(true))
}

impl Lineup {
    fn new(args: &PaperArgs) -> Result<Self, InputError> {
        let learns =
            |name: &str| Descriptor::find(name).is_some_and(|method| method.takes(Setting::Learning));
        let published = |name: &str| match args.train_paths.filter(|_| learns(name)) {
            Some(paths) => format!("{name}{PUBLISHED},train-paths={paths}"),
            None => format!("{name}{PUBLISHED}"),
        };
        let labels = methods().flat_map(|name| [published(name), name.to_owned()]);
        let methods = labels.map(|label| Candidate::parse(&label)).collect::<Result<_, _>>()?;
        let by_records = METHODS.into_iter().filter(|method| method.takes(Setting::Records));
        let more = by_records.flat_map(|method| {
            let paths = args
                .more
                .iter()
                .map(|paths| (format!("{paths} light paths"), format!("light-paths={paths}")));
            let records = args.more_records.iter().map(|share| {
                (format!("records of {} of the pixels", level(*share)), format!("record-share={share}"))
            });
            paths.chain(records).map(move |(with, setting)| (method.name, with, setting))
        });
        let more = more.map(|(name, with, setting)| {
            let candidate = Candidate::parse(&format!("{name}:{setting}"))?;
            Ok((name, with, candidate))
        });
        Ok(Self { methods, more: more.collect::<Result<_, InputError>>()? })
    }
}

/// What is shared by all scenes.
struct Bench<'a> {
    args: &'a PaperArgs,
    lineup: &'a Lineup,
    context: &'a Context,
    store: ReferenceStore,
    records: Records,
    probe: Option<SpeedProbe>,
    quiet: bool,
}

/// A scene, rendered.
struct Rendered<'a> {
    renders: SceneRenders<'a>,
    /// Whether the tables of each of [`Lineup::more`] fit the device.
    fits: Vec<bool>,
    insets: Insets,
}

impl<'a> Bench<'a> {
    fn series<'b>(&self, candidates: &'b [Candidate]) -> Series<'b> {
        let plan = Plan {
            time: Some(self.args.time),
            equal_samples: EQUAL_SAMPLES,
            goal: self.args.longest.map(|longest| Goal { error: TARGET, longest }),
            as_paper: true,
            ..Plan::default()
        };
        Series { candidates, plan, seeds: self.args.seeds, first_seed: self.args.seed }
    }

    fn more_series<'b>(&self, candidate: &'b Candidate) -> Series<'b> {
        let plan = Plan {
            samples: Some(MORE_SAMPLES),
            equal_samples: MORE_SAMPLES,
            as_paper: true,
            ..Plan::default()
        };
        let candidates = std::slice::from_ref(candidate);
        Series { candidates, plan, seeds: self.args.seeds, first_seed: self.args.seed }
    }

    /// Renders what is not there yet; `None` where Ctrl-C ended that.
    fn render(&mut self, bench_scene: BenchScene) -> Result<Option<Rendered<'a>>, CliError> {
        let Some(reference) = self.store.reference(self.context, &bench_scene, self.quiet)? else {
            return Ok(None);
        };
        let renders = SceneRenders { context: self.context, bench_scene, reference, quiet: self.quiet };
        let series = self.series(&self.lineup.methods);
        if !renders.render_all(&series, &mut self.records, &mut self.probe, None)? {
            return Ok(None);
        }
        let mut fits = Vec::new();
        for (_, _, candidate) in &self.lineup.more {
            let series = self.more_series(candidate);
            match renders.render_all(&series, &mut self.records, &mut self.probe, None) {
                Ok(true) => fits.push(true),
                Ok(false) => return Ok(None),
                Err(CliError::Render(RenderError::Device(DeviceError::RecordsTooLarge { .. }))) => {
                    fits.push(false);
                }
                Err(error) => return Err(error),
            }
        }
        let insets = Insets::render(&renders, &self.lineup.methods, self.args)?;
        Ok(insets.map(|insets| Rendered { renders, fits, insets }))
    }

    /// What there is of a scene.
    fn result(&self, rendered: &Rendered) -> Result<SceneResult, CliError> {
        let Rendered { renders, fits, .. } = rendered;
        let runs = renders.stored(&self.series(&self.lineup.methods), &self.records)?;
        let mut more = Vec::new();
        for ((method, with, candidate), &fits) in self.lineup.more.iter().zip(fits) {
            let stored = renders.stored(&self.more_series(candidate), &self.records)?;
            let runs = stored.into_iter().flatten().map(<[Checkpoint]>::to_vec).collect();
            let flags = candidate.flags();
            more.push(More { method, with: with.clone(), flags, fits, runs });
        }
        let runs = runs.into_iter().map(|seeds| seeds.into_iter().map(<[Checkpoint]>::to_vec).collect());
        Ok(SceneResult::new(renders, &self.lineup.methods, runs.collect(), more))
    }
}

/// Renders what is not there yet, and makes the page of all.
///
/// # Errors
/// Bad input, no device, files that cannot be written.
pub fn run(args: &PaperArgs, quiet: bool) -> Result<Exit, CliError> {
    let lineup = Lineup::new(args)?;
    check_longest(args.time, args.longest)?;
    let paths = match args.paths.is_empty() {
        true => paper_figures::scenes().map(|name| PathBuf::from(format!("scenes/{name}.glb"))).collect(),
        false => args.paths.clone(),
    };
    let page = args.markdown.clone().unwrap_or(args.output.join("paper.md"));
    let folder = page.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    for folder in [args.output.as_path(), folder] {
        std::fs::create_dir_all(folder).map_err(CliError::folder(folder))?;
    }
    let file = args.output.join("runs.jsonl");
    install_interrupt();
    let context = args.seen.picture.device.open_to_compare(quiet)?;
    let mut bench = Bench {
        args,
        lineup: &lineup,
        context: &context,
        store: args.reference.store()?,
        records: Records::open(&file)?,
        probe: None,
        quiet,
    };
    let mut rendered: Vec<Rendered> = Vec::new();
    for path in &paths {
        let bench_scene = args.seen.load(path)?;
        bench_scene.check_name(rendered.iter().map(|other| &other.renders.bench_scene))?;
        let Some(scene) = bench.render(bench_scene)? else { return Ok(bench.records.interrupted()) };
        rendered.push(scene);
    }
    let mut scenes: Vec<SceneResult> =
        rendered.iter().map(|scene| bench.result(scene)).collect::<Result<_, _>>()?;
    // The usual speed is that over all scenes.
    let drift = Drift::of(scenes.iter().flat_map(SceneResult::runs));
    let seconds_per_unit = drift.map_or(1.0, |drift| drift.usual_seconds_per_unit);
    let ask = Ask { target: TARGET, times: &[], equal_samples: EQUAL_SAMPLES };
    scenes.iter_mut().for_each(|scene| scene.summarise(&lineup.methods, seconds_per_unit, &ask));
    let stem = page.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    for scene in &rendered {
        let picture = format!("{stem}-{}.png", scene.renders.bench_scene.name);
        scene.insets.write(&folder.join(picture), scene, args.inset_time)?;
    }
    let paper = Paper {
        date: today(),
        device: maker_of(&context),
        command: command_line(),
        version: env!("CARGO_PKG_VERSION"),
        seeds: args.seeds,
        seconds: args.time.as_secs_f64(),
        longest: args.longest.map(|longest| longest.as_secs_f64()),
        inset_seconds: args.inset_time.as_secs_f64(),
        drift,
        scenes,
    };
    let json = serde_json::to_string_pretty(&paper)?;
    write_atomic(&args.output.join("paper.json"), json.as_bytes())?;
    write_atomic(&page, page::page(&paper, &stem).as_bytes())?;
    out!("{}", page.display());
    Ok(Exit::Done)
}
