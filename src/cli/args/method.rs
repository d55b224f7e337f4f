//! The arguments that say how light is transported, shared by the subcommands that render.

use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

use super::InputError;
use crate::cli::CliError;
use crate::integrator::method::{Given, Setting};
use crate::integrator::{DEFAULT_CONNECTIONS, Descriptor, MAX_CONNECTIONS, METHODS, Method};
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

/// How light is transported, and with which settings.
#[derive(Args, Debug)]
pub struct MethodArgs {
    /// How light is transported.
    #[arg(short, long, value_name = "NAME", value_parser = IntegratorParser, default_value = METHODS[0].name)]
    integrator: &'static Descriptor,
    #[arg(long, value_name = "M",
          help = format!("Light paths for each sample of the whole picture; a few samples may share theirs ({}; default: a \
                          quarter of the number of pixels, light as many as pixels)", names_of(Setting::LightPaths)))]
    light_paths: Option<u32>,
    #[arg(long, value_name = "N",
          help = format!("Connections of each vertex of an eye path to the light vertex cache, 1 to {MAX_CONNECTIONS} \
                          ({}; default: {DEFAULT_CONNECTIONS})", names_of(Setting::Connections)))]
    connections: Option<u32>,
    #[arg(long, help = format!("Connect light paths to the camera as well ({}): finds caustics",
                               names_of(Setting::LightTracing)))]
    light_tracing: bool,
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
    /// Share of what neighbouring subspaces have learnt in every step of Gamma, 0 to 1 (default: what suits paths that
    /// were held out).
    #[arg(long, value_name = "SHARE", help_heading = LEARNING)]
    smoothing: Option<f64>,
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
            (self.smoothing.is_some(), "--smoothing"),
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
            smoothing: self.smoothing.or(default.smoothing),
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
    type Value = &'static Descriptor;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<Self::Value, clap::Error> {
        let names = METHODS.map(|method| method.name);
        let name = clap::builder::PossibleValuesParser::new(names).parse_ref(command, argument, value)?;
        Descriptor::find(&name).ok_or_else(|| clap::Error::new(clap::error::ErrorKind::InvalidValue))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(METHODS.iter().map(|method| PossibleValue::new(method.name).help(method.help))))
    }
}

/// `a, b and c`: the methods that have a setting.
fn names_of(setting: Setting) -> String {
    let names: Vec<&str> =
        METHODS.iter().filter(|method| method.takes(setting)).map(|method| method.name).collect();
    match names.as_slice() {
        [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
        names => names.concat(),
    }
}

impl MethodArgs {
    pub fn integrator(&self) -> &'static Descriptor {
        self.integrator
    }

    /// The method with its settings.
    ///
    /// # Errors
    /// A setting that the integrator does not have, or out of its range.
    pub fn method(&self) -> Result<Method, InputError> {
        let given = Given {
            light_paths: self.light_paths,
            connections: self.connections,
            light_tracing: self.light_tracing,
        };
        for (flag, setting, is_given) in [
            ("--light-paths", Setting::LightPaths, given.light_paths.is_some()),
            ("--connections", Setting::Connections, given.connections.is_some()),
            ("--light-tracing", Setting::LightTracing, given.light_tracing),
        ] {
            self.refuse(flag, setting, is_given)?;
        }
        if given.light_paths == Some(0) {
            return Err(InputError::Usage("--light-paths takes at least 1 light path per sample".into()));
        }
        if given.connections.is_some_and(|connections| !(1..=MAX_CONNECTIONS).contains(&connections)) {
            return Err(InputError::Usage(format!("--connections takes 1 to {MAX_CONNECTIONS}")));
        }
        Ok((self.integrator.make)(&given))
    }

    /// Refuses a setting that is given and that the integrator does not have.
    fn refuse(&self, flag: &str, setting: Setting, is_given: bool) -> Result<(), InputError> {
        if !is_given || self.integrator.takes(setting) {
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
    /// Reads the model, if one is named.
    ///
    /// # Errors
    /// A method that does not learn; a file that cannot be read, or is of another scene.
    pub fn load(&self, scene_hash: u64, method: Method) -> Result<Option<Arc<Model>>, CliError> {
        let Some(path) = &self.model else { return Ok(None) };
        let plan = method.plan();
        if !plan.learns() {
            let usage = "--model is a setting of spcbpt; leave it out, or add --integrator spcbpt";
            return Err(InputError::Usage(usage.into()).into());
        }
        let model = Model::load(path, scene_hash)?;
        if model.connections != plan.connections {
            // No error: unbiased all the same, only not the least noise.
            log::info!(
                "the model was trained for {} connections, this render has {}",
                model.connections,
                plan.connections
            );
        }
        Ok(Some(Arc::new(model)))
    }
}
