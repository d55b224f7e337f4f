//! The arguments that say how light is transported, shared by the subcommands that render.

use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::InputError;
use crate::cli::CliError;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::integrator::method::{Given, Setting};
use crate::integrator::{
    Choice, Connections, Descriptor, MAX_CONNECTIONS, METHODS, Method, PcBpt, RecordWeights, View,
};
use crate::render::{PUBLISHED_LIGHT_PATHS_PER_PIXEL, RenderOptions, for_surfaces};
use crate::scene::Scene;
use crate::subspace::{LEAST_UNIFORM_SHARE, Model, Optimiser, Settings, SubspaceError};
use crate::training::{DEFAULT_ROUNDS, LONG_RENDER_ROUNDS, MOST_ROUNDS, Training, When};

/// Rounds of a first look.
const DRAFT_ROUNDS: u32 = 2;

/// What is worth more: to see something soon, or little noise in the end. What is set by itself goes before. Connections
/// and light paths are the same in all: docs/sweeps.md shows no other number of them to be better, early or late.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    #[value(help = format!("At most {DRAFT_ROUNDS} rounds of learning: the first picture comes in half the time"))]
    Draft,
    #[default]
    #[value(help = format!("Up to {DEFAULT_ROUNDS} rounds, in a render that is long enough up to {LONG_RENDER_ROUNDS}, \
                            as long as the last one was worth it"))]
    Normal,
    #[value(help = format!("{LONG_RENDER_ROUNDS} rounds, the last of them from many more paths, however little they teach \
                            and however short the render; about a gigabyte of memory"))]
    High,
}

impl Quality {
    fn training(self) -> Training {
        let normal = Training::default();
        match self {
            Self::Draft => Training { rounds: Some(DRAFT_ROUNDS), ..normal },
            Self::Normal => normal,
            Self::High => normal.with_rounds(LONG_RENDER_ROUNDS),
        }
    }
}

/// The name by which a program chooses.
const AUTO: &str = "auto";

/// What `--integrator` takes.
#[derive(Clone, Copy, Debug)]
enum Integrator {
    /// What will have the least error at the end of the budget.
    Auto,
    Named(&'static Descriptor),
}

/// How light is transported, and with which settings.
#[derive(Args, Debug)]
pub struct MethodArgs {
    /// How light is transported.
    #[arg(short, long, value_name = "NAME", value_parser = IntegratorParser, default_value = AUTO)]
    integrator: Integrator,
    #[arg(long, value_name = "M",
          help = format!("Light paths for each sample of the whole picture; in lvcbpt and spcbpt the {SAMPLES_A_GROUP} samples of a \
                          group share theirs ({}; default: a quarter of the number of pixels, there fewer in large pictures, light \
                          as many as pixels, {} {})",
                         names_of(Setting::LightPaths), names_of(Setting::Records), PcBpt::LIGHT_PATHS))]
    light_paths: Option<u32>,
    #[command(flatten)]
    connections: ConnectionArgs,
    #[arg(long, conflicts_with = "no_light_tracing",
          help = format!("Connect light paths to the camera as well ({}): finds caustics. bdpt, lvcbpt and spcbpt do so by \
                          themselves where glossy surfaces bring light to others", names_of(Setting::LightTracing)))]
    light_tracing: bool,
    #[arg(long, help = format!("Do not connect light paths to the camera, whatever the surfaces are ({})",
                               names_of(Setting::LightTracing)))]
    no_light_tracing: bool,
    #[arg(long, value_name = "SHARE", value_parser = parse_record_share,
          help = format!("Share of the pixels that have an eye path which leaves records in each sample, above 0 and up to 1; it is \
                          rounded to every so many-th pixel ({}; default: {})", names_of(Setting::Records), PcBpt::RECORD_SHARE))]
    record_share: Option<f64>,
    #[arg(
        long,
        value_enum,
        value_name = "FORM",
        help = "What the weights of risbpt know of connections by records (default: nabata; --as-published: simple)"
    )]
    risbpt_weights: Option<RecordWeights>,
    #[arg(long, help = format!("Each sample has light paths, points and draws of its own, in place of groups of samples whose points lie \
                                well apart: more noise. For research ({})", names_of(Setting::Connections)))]
    independent: bool,
    #[arg(long, conflicts_with_all = ["light_paths", "ConnectionArgs", "light_tracing", "record_share", "risbpt_weights", "independent", "learn",
                                      "quality", "rounds", "subspaces", "optimiser", "uniform_share", "power_share",
                                      "smoothing", "no_light_guide", "lloyd_steps", "tree_depth", "direction_weight"],
          help = format!("The method as its paper has it, without what has been added here, for comparison: --independent, \
                          --connections 3, --shares 1,1,1,1, --no-thinning, and --light-paths of {PUBLISHED_LIGHT_PATHS_PER_PIXEL:.4} \
                          for each pixel, which is 100,000 for 1920x1080 ({}: {} at any size); spcbpt learns by --train-paths \
                          1000000, where no other number is given beside this, and --subspaces 1000 --lloyd-steps 0 --power-share 0 --smoothing 0 --optimiser softmax --no-light-guide ({})",
                         names_of(Setting::Records), PcBpt::LIGHT_PATHS, names_of(Setting::Connections)))]
    as_published: bool,
    /// When spcbpt learns (default: meanwhile on a GPU unless --spp is given, else first). Only first makes the same
    /// picture again.
    #[arg(long, value_enum, value_name = "WHEN", conflicts_with = "train_paths", help_heading = LEARNING)]
    learn: Option<When>,
    /// How much spcbpt learns, for a first look or for a last one.
    #[arg(long, value_enum, value_name = "LEVEL", default_value_t, conflicts_with = "train_paths",
          help_heading = LEARNING)]
    quality: Quality,
    #[command(flatten)]
    learning: LearnArgs,
}

/// How many connections there are, and how far weights trust them.
#[derive(Args, Clone, Copy, Debug)]
pub struct ConnectionArgs {
    #[arg(long, value_name = "N1,N2,N3", value_parser = parse_counts,
          help = format!("Connections of each vertex of an eye path to the light vertex cache, 1 to {MAX_CONNECTIONS}: of the \
                          first vertex, of the second, of all that follow, or one number for all. In lists of benchmarks \
                          with / in between ({}; default: {}; by default spcbpt has 3 to 15 of first vertices, as many \
                          as are worth it, once enough was learnt to tell)",
                         names_of(Setting::Connections), default_counts()))]
    pub connections: Option<[u32; 3]>,
    #[arg(long, value_name = "B1,B2,B3,H", value_parser = parse_shares,
          help = format!("How far weights trust these connections, and light that is hit, beside what the balance heuristic \
                          does: factors on their densities. Pictures are unbiased with any. For research ({}; default: \
                          {})", names_of(Setting::Connections), default_shares()))]
    pub shares: Option<[f32; 4]>,
    #[arg(long, help = format!("Connect vertices of narrow lobes, such as polished metal, as often as all others; by default they \
                                make an eighth of their connections or more. For research ({})", names_of(Setting::Connections)))]
    pub no_thinning: bool,
}

/// `lvcbpt 3, spcbpt 9,2,1`: the default of each method that has connections.
fn defaults(text: impl Fn(&Connections) -> String) -> String {
    let methods = METHODS.iter().filter(|method| method.takes(Setting::Connections));
    let each = methods
        .map(|method| format!("{} {}", method.name, text(&method.default_method().plan().connections)));
    each.collect::<Vec<_>>().join("; ")
}

fn default_counts() -> String {
    defaults(Connections::counts_text)
}

fn default_shares() -> String {
    defaults(Connections::shares_text)
}

/// Numbers with commas or slashes in between.
fn numbers<T: std::str::FromStr>(text: &str) -> Option<Vec<T>> {
    text.split([',', '/']).map(|number| number.trim().parse().ok()).collect()
}

fn parse_counts(text: &str) -> Result<[u32; 3], String> {
    let counts: Option<Vec<u32>> = numbers(text);
    let range = 1..=MAX_CONNECTIONS;
    match counts.filter(|counts| counts.len() <= 3 && counts.iter().all(|count| range.contains(count))) {
        Some(counts) => Ok(std::array::from_fn(|vertex| counts[vertex.min(counts.len() - 1)])),
        None => Err(format!("takes one to three numbers from 1 to {MAX_CONNECTIONS}, such as 9,2,1")),
    }
}

fn parse_shares(text: &str) -> Result<[f32; 4], String> {
    let shares: Option<Vec<f32>> = numbers(text);
    let shares = shares.filter(|shares| shares.iter().all(|share| (1e-3..=1e3).contains(share)));
    let shares = shares.and_then(|shares| shares.try_into().ok());
    shares.ok_or_else(|| "takes four numbers from .001 to 1000, such as 3,2,1,4".to_owned())
}

pub fn parse_record_share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share| *share > 0.0 && *share <= 1.0);
    share.ok_or_else(|| "takes a share above 0, 1 at most, such as 0.004".to_owned())
}

/// Where `--help` lists these.
const LEARNING: &str = "Learning (spcbpt)";

/// What spcbpt learns from, and what it makes of that.
#[derive(Args, Debug)]
pub struct LearnArgs {
    /// Learn, as published, from so many full paths that path tracing finds. By default it learns from the paths that
    /// connections by subspaces find, guided by the rounds before: much sooner where light is hard to find.
    #[arg(long, value_name = "N", help_heading = LEARNING)]
    train_paths: Option<u32>,
    #[arg(long, alias = "lessons", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_ROUNDS)),
          conflicts_with = "train_paths", help_heading = LEARNING,
          help = format!("Rounds of learning, each from all paths that were found by then, however little they gain \
                          (default: up to {DEFAULT_ROUNDS}, in a render that is long enough up to {LONG_RENDER_ROUNDS}, as \
                          long as the last one was worth it)"))]
    rounds: Option<u32>,
    /// Subspaces that sub-paths are sorted into, on the eye's and on the light's side (default: as many as the
    /// training paths can teach).
    #[arg(long, value_name = "K", help_heading = LEARNING)]
    subspaces: Option<u32>,
    /// How Gamma is improved (default: mm).
    #[arg(long, value_enum, value_name = "NAME", help_heading = LEARNING)]
    optimiser: Option<Optimiser>,
    #[arg(long, value_name = "SHARE", help_heading = LEARNING,
          help = format!("Share of the connections that goes evenly to all light subspaces, {LEAST_UNIFORM_SHARE} to 1 \
                          (default: {})", Settings::default().uniform_share))]
    uniform_share: Option<f64>,
    #[arg(long, value_name = "SHARE", help_heading = LEARNING,
          help = format!("Share of the other connections that goes to light subspaces by their power, 0 to 1: bright light that \
                          learning did not meet makes fewer fireflies (default: {})", Settings::default().power_share))]
    power_share: Option<f64>,
    /// Share of what neighbouring subspaces have learnt in every step of Gamma, 0 to 1 (default: what suits paths that
    /// were held out).
    #[arg(long, value_name = "SHARE", help_heading = LEARNING)]
    smoothing: Option<f64>,
    /// Light paths go where surfaces scatter and lights shine, not where their light was found to be wanted.
    #[arg(long, help_heading = LEARNING)]
    no_light_guide: bool,
    #[arg(long, value_name = "STEPS", help_heading = LEARNING,
          help = format!("Steps that move the centres of the subspaces to the middle of what is nearest to them, up to 100 \
                          (default: {})", Settings::default().lloyd_steps))]
    lloyd_steps: Option<u32>,
    #[arg(long, value_name = "LEVELS", help_heading = LEARNING,
          help = format!("Most levels of the classification trees (default: {})", Settings::default().tree_depth))]
    tree_depth: Option<u32>,
    #[arg(long, value_name = "WEIGHT", help_heading = LEARNING,
          help = format!("Weight of the direction that a sub-path arrives from, beside that of the surface's normal, in \
                          sorting it; 0: it does not count. Anything else makes rendering slower (default: {})",
                         Settings::default().direction_weight))]
    direction_weight: Option<f32>,
}

impl LearnArgs {
    /// The first of these that is given.
    fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.train_paths.is_some(), "--train-paths"),
            (self.rounds.is_some(), "--rounds"),
            (self.subspaces.is_some(), "--subspaces"),
            (self.optimiser.is_some(), "--optimiser"),
            (self.uniform_share.is_some(), "--uniform-share"),
            (self.power_share.is_some(), "--power-share"),
            (self.smoothing.is_some(), "--smoothing"),
            (self.no_light_guide, "--no-light-guide"),
            (self.lloyd_steps.is_some(), "--lloyd-steps"),
            (self.tree_depth.is_some(), "--tree-depth"),
            (self.direction_weight.is_some(), "--direction-weight"),
        ];
        flags.into_iter().find_map(|(given, flag)| given.then_some(flag))
    }

    /// A preset, with what is given here.
    ///
    /// # Errors
    /// A setting out of its range.
    pub fn training(&self, preset: Training) -> Result<Training, SubspaceError> {
        let default = preset.settings.clone();
        let settings = Settings {
            subspaces: self.subspaces,
            optimiser: self.optimiser.unwrap_or(default.optimiser),
            uniform_share: self.uniform_share.unwrap_or(default.uniform_share),
            power_share: self.power_share.unwrap_or(default.power_share),
            smoothing: self.smoothing.or(default.smoothing),
            light_guide: default.light_guide && !self.no_light_guide,
            lloyd_steps: self.lloyd_steps.unwrap_or(default.lloyd_steps),
            tree_depth: self.tree_depth.unwrap_or(default.tree_depth),
            direction_weight: self.direction_weight.unwrap_or(default.direction_weight),
            ..default
        };
        settings.check()?;
        let training = Training { paths: self.train_paths, settings, ..preset };
        Ok(match self.rounds {
            Some(rounds) => training.with_rounds(rounds),
            None => training,
        })
    }
}

/// Reads the name of a method.
#[derive(Clone)]
struct IntegratorParser;

impl clap::builder::TypedValueParser for IntegratorParser {
    type Value = Integrator;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<Self::Value, clap::Error> {
        let names = std::iter::once(AUTO).chain(METHODS.iter().map(|method| method.name));
        let name = clap::builder::PossibleValuesParser::new(names).parse_ref(command, argument, value)?;
        if name == AUTO {
            return Ok(Integrator::Auto);
        }
        let found = Descriptor::find(&name).map(Integrator::Named);
        found.ok_or_else(|| clap::Error::new(clap::error::ErrorKind::InvalidValue))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let auto = PossibleValue::new(AUTO).help(
            "path or spcbpt, whichever a pilot expects to have the least error at the end of the budget",
        );
        let methods = METHODS.iter().map(|method| PossibleValue::new(method.name).help(method.help));
        Some(Box::new(std::iter::once(auto).chain(methods)))
    }
}

/// `a, b and c`: the methods that have a setting.
pub fn names_of(setting: Setting) -> String {
    let names: Vec<&str> =
        METHODS.iter().filter(|method| method.takes(setting)).map(|method| method.name).collect();
    match names.as_slice() {
        [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
        names => names.concat(),
    }
}

impl MethodArgs {
    /// The integrator that is named; `None`: one is to be chosen.
    pub fn integrator(&self) -> Option<&'static Descriptor> {
        match self.integrator {
            Integrator::Auto => None,
            Integrator::Named(descriptor) => Some(descriptor),
        }
    }

    /// The method with its settings; `None`: one is to be chosen.
    ///
    /// # Errors
    /// A setting that the integrator does not have, or out of its range.
    pub fn method(&self) -> Result<Option<Method>, InputError> {
        let given = Given {
            light_paths: self.light_paths,
            connections: self.connections.connections,
            shares: self.connections.shares,
            no_thinning: self.connections.no_thinning,
            light_tracing: self.light_tracing,
            record_share: self.record_share,
            record_weights: self.risbpt_weights,
        };
        for (flag, setting, is_given) in [
            ("--light-paths", Setting::LightPaths, given.light_paths.is_some()),
            ("--connections", Setting::Connections, given.connections.is_some()),
            ("--shares", Setting::Connections, given.shares.is_some()),
            ("--no-thinning", Setting::Connections, given.no_thinning),
            ("--light-tracing", Setting::LightTracing, given.light_tracing),
            ("--no-light-tracing", Setting::LightTracing, self.no_light_tracing),
            ("--record-share", Setting::Records, given.record_share.is_some()),
            ("--risbpt-weights", Setting::RecordWeights, given.record_weights.is_some()),
            ("--independent", Setting::Connections, self.independent),
            ("--as-published", Setting::Connections, self.as_published),
        ] {
            self.refuse(flag, setting, is_given)?;
        }
        if given.light_paths == Some(0) {
            return Err(InputError::Usage("--light-paths takes at least 1 light path per sample".into()));
        }
        Ok(self.integrator().map(|descriptor| (descriptor.make)(&given)))
    }

    /// As [`method`](Self::method), as the scene wants it.
    ///
    /// # Errors
    /// As [`method`](Self::method).
    pub fn named_for(&self, scene: &Scene) -> Result<Option<(Method, Option<Choice>)>, InputError> {
        Ok(self.method()?.map(|method| self.for_surfaces(scene, method)))
    }

    /// The method as the scene wants it, where nothing is said of light tracing; and why.
    pub fn for_surfaces(&self, scene: &Scene, method: Method) -> (Method, Option<Choice>) {
        match self.light_tracing || self.no_light_tracing || self.as_published {
            true => (method, None),
            false => for_surfaces(scene, method),
        }
    }

    /// The options with what is not of the method alone, or depends on the picture.
    pub fn apply(&self, options: RenderOptions) -> RenderOptions {
        let independent = options.view.independent || self.independent;
        let options = RenderOptions { view: View { independent, ..options.view }, ..options };
        if self.as_published { options.as_published() } else { options }
    }

    /// Refuses a setting that is given and that the integrator does not have.
    fn refuse(&self, flag: &str, setting: Setting, is_given: bool) -> Result<(), InputError> {
        if !is_given || self.integrator().is_some_and(|descriptor| descriptor.takes(setting)) {
            return Ok(());
        }
        let who = names_of(setting);
        Err(InputError::Usage(format!(
            "{flag} is a setting of {who}; leave it out, or choose with --integrator"
        )))
    }

    /// What it learns from, where it learns.
    ///
    /// # Errors
    /// A setting of another integrator, or out of its range.
    pub fn training(&self) -> Result<Training, InputError> {
        let preset = (self.quality != Quality::Normal).then_some("--quality");
        let given = self.learning.given().or(self.learn.and(Some("--learn"))).or(preset);
        self.refuse(given.unwrap_or_default(), Setting::Learning, given.is_some())?;
        let training = self.learning.training(self.quality.training());
        let training = training.map_err(|error| InputError::Usage(error.to_string()))?;
        Ok(Training { when: self.learn, ..training })
    }
}

/// What was learnt before.
#[derive(Args, Debug)]
pub struct ModelArgs {
    /// Connect by a model that `halfway train` wrote for this scene, in place of learning first (spcbpt).
    #[arg(long, value_name = "FILE.model", conflicts_with_all = ["LearnArgs", "learn", "quality"],
          help_heading = LEARNING)]
    model: Option<PathBuf>,
}

impl ModelArgs {
    /// A model is named.
    pub fn is_given(&self) -> bool {
        self.model.is_some()
    }

    /// Reads the model, if one is named. Without a method it will be one that takes the model.
    ///
    /// # Errors
    /// A method that does not learn; a file that cannot be read, or is of another scene.
    pub fn load(&self, scene_hash: u64, method: Option<Method>) -> Result<Option<Arc<Model>>, CliError> {
        let Some(path) = &self.model else { return Ok(None) };
        let Some(method) = method else { return Ok(Some(Arc::new(Model::load(path, scene_hash)?))) };
        let plan = method.plan();
        if !plan.learns() {
            let usage = "--model is a setting of spcbpt; leave it out, or add --integrator spcbpt";
            return Err(InputError::Usage(usage.into()).into());
        }
        let model = Model::load(path, scene_hash)?;
        if model.connections != (Connections { adapts: model.connections.adapts, ..plan.connections }) {
            // No error: unbiased all the same, only not the least noise.
            log::info!(
                "the model was trained for {}, this render has {}",
                model.connections,
                plan.connections
            );
        }
        Ok(Some(Arc::new(model)))
    }
}
