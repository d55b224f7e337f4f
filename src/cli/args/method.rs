//! The arguments that say how light is transported, shared by the subcommands that render.

use clap::{Args, ValueEnum};

use super::InputError;
use crate::integrator::{DEFAULT_CONNECTIONS, MAX_CONNECTIONS, Method};
use crate::subspace::{Optimiser, Settings, SubspaceError};
use crate::training::{LONG_RENDER_ROUNDS, Training, When};

/// How light is transported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum IntegratorName {
    /// Path tracing with next-event estimation.
    #[default]
    Path,
    /// Bidirectional path tracing: every eye path is connected to a light path of its own.
    Bdpt,
    /// Bidirectional path tracing with a light vertex cache that the whole picture shares.
    Lvcbpt,
    /// Bidirectional path tracing that has learnt which light vertices are worth a connection (SPCBPT).
    Spcbpt,
    /// Light tracing: light paths alone, connected to the camera.
    Light,
}

/// What is worth more: to see something soon, or little noise in the end. What is set by itself goes before. Connections
/// and light paths are the same in all: docs/knobs.md shows no other number of them to be better, early or late.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// Two lessons at most: the first picture comes in half the time.
    Draft,
    /// Up to five lessons, in a render that is long enough up to seven, as long as the last one was worth it.
    #[default]
    Normal,
    /// Seven lessons, however little the last one taught, of up to six million connections, however short the render.
    High,
}

impl Quality {
    fn training(self) -> Training {
        let normal = Training::default();
        match self {
            Self::Draft => Training { lessons: Some(2), ..normal },
            Self::Normal => normal,
            Self::High => normal.with_rounds(LONG_RENDER_ROUNDS),
        }
    }
}

/// How light is transported, and with which settings.
#[derive(Args, Debug)]
pub struct MethodArgs {
    #[arg(short, long, value_enum, default_value_t)]
    integrator: IntegratorName,
    /// Light paths for each sample of the whole picture; a few samples may share theirs (default: lvcbpt and spcbpt a
    /// quarter of the pixels, light all of them).
    #[arg(long, value_name = "M")]
    light_paths: Option<u32>,
    /// Connections of each vertex of an eye path to the light vertex cache (lvcbpt, spcbpt).
    #[arg(long, value_name = "N")]
    connections: Option<u32>,
    /// Connect light paths to the camera as well (bdpt, lvcbpt, spcbpt): finds caustics.
    #[arg(long)]
    light_tracing: bool,
    /// When spcbpt learns (default: meanwhile on a GPU that has no number of samples to reach, else first).
    #[arg(long, value_enum, conflicts_with = "train_paths", help_heading = LEARNING)]
    learn: Option<When>,
    /// How much spcbpt learns, for a first look or for a last one.
    #[arg(long, value_enum, default_value_t, conflicts_with = "train_paths", help_heading = LEARNING)]
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
    /// connections by subspaces find, by what earlier ones taught: much sooner where light is hard to find.
    #[arg(long, value_name = "N", help_heading = LEARNING)]
    train_paths: Option<u32>,
    /// How often it learns anew from the paths that it has found, at most (default: up to 5 times, in a render that is
    /// long enough up to 7, as long as the last lesson was worth it).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16), conflicts_with = "train_paths",
          help_heading = LEARNING)]
    lessons: Option<u32>,
    /// Subspaces that sub-paths are sorted into, on the eye's and on the light's side (default: as many as the
    /// training paths can teach).
    #[arg(long, value_name = "K", help_heading = LEARNING)]
    subspaces: Option<u32>,
    /// How Gamma is improved (default: mm).
    #[arg(long, value_enum, help_heading = LEARNING)]
    optimiser: Option<Optimiser>,
    #[arg(long, value_name = "SHARE", help_heading = LEARNING,
          help = format!("Share of the connections that goes evenly to all light subspaces, above 0 and at most 1 \
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
            (self.lessons.is_some(), "--lessons"),
            (self.subspaces.is_some(), "--subspaces"),
            (self.optimiser.is_some(), "--optimiser"),
            (self.uniform_share.is_some(), "--uniform-share"),
            (self.smoothing.is_some(), "--smoothing"),
            (self.tree_depth.is_some(), "--tree-depth"),
            (self.direction_weight.is_some(), "--direction-weight"),
        ];
        flags.into_iter().find_map(|(given, flag)| given.then_some(flag))
    }

    /// A preset, with what is given here and for so many connections of an eye vertex.
    ///
    /// # Errors
    /// A setting out of its range.
    pub fn training(&self, preset: Training, connections: u32) -> Result<Training, SubspaceError> {
        let default = preset.settings.clone();
        let settings = Settings {
            subspaces: self.subspaces,
            connections,
            optimiser: self.optimiser.unwrap_or(default.optimiser),
            uniform_share: self.uniform_share.unwrap_or(default.uniform_share),
            smoothing: self.smoothing.or(default.smoothing),
            tree_depth: self.tree_depth.unwrap_or(default.tree_depth),
            direction_weight: self.direction_weight.unwrap_or(default.direction_weight),
            ..default
        };
        settings.check()?;
        let training = Training { paths: self.train_paths, settings, ..preset };
        Ok(match self.lessons {
            Some(lessons) => training.with_rounds(lessons),
            None => training,
        })
    }
}

impl MethodArgs {
    #[cfg(feature = "preview")]
    pub fn integrator(&self) -> IntegratorName {
        self.integrator
    }

    fn connections(&self) -> u32 {
        self.connections.unwrap_or(DEFAULT_CONNECTIONS)
    }

    /// The method with its settings.
    ///
    /// # Errors
    /// A setting that the integrator does not have, or out of its range.
    pub fn method(&self) -> Result<Method, InputError> {
        use IntegratorName as Name;
        let (name, light_paths) = (self.integrator, self.light_paths);
        let refuse = |flag: &str, who: &str| {
            Err(InputError::Usage(format!(
                "{flag} is a setting of {who}; leave it out, or choose with --integrator"
            )))
        };
        if light_paths.is_some() && !matches!(name, Name::Lvcbpt | Name::Spcbpt | Name::Light) {
            return refuse("--light-paths", "lvcbpt, spcbpt and light");
        }
        if self.connections.is_some() && !matches!(name, Name::Lvcbpt | Name::Spcbpt) {
            return refuse("--connections", "lvcbpt and spcbpt");
        }
        if self.light_tracing && !matches!(name, Name::Lvcbpt | Name::Spcbpt | Name::Bdpt) {
            return refuse("--light-tracing", "bdpt, lvcbpt and spcbpt");
        }
        if light_paths == Some(0) {
            return Err(InputError::Usage("--light-paths takes at least 1 light path a sample".into()));
        }
        let connections = self.connections();
        if !(1..=MAX_CONNECTIONS).contains(&connections) {
            return Err(InputError::Usage(format!("--connections takes 1 to {MAX_CONNECTIONS}")));
        }
        Ok(match name {
            Name::Path => Method::Path,
            Name::Bdpt => Method::Bdpt { light_tracing: self.light_tracing },
            Name::Lvcbpt => Method::LvcBpt { light_paths, connections, light_tracing: self.light_tracing },
            Name::Spcbpt => Method::SpcBpt { light_paths, connections, light_tracing: self.light_tracing },
            Name::Light => Method::Light { light_paths },
        })
    }
}

impl MethodArgs {
    /// What spcbpt learns from.
    ///
    /// # Errors
    /// A setting of another integrator, or out of its range.
    pub fn training(&self) -> Result<Training, InputError> {
        let preset = (self.quality != Quality::Normal).then_some("--quality");
        let given = self.learning.given().or(self.learn.and(Some("--learn"))).or(preset);
        if let Some(flag) = given.filter(|_| self.integrator != IntegratorName::Spcbpt) {
            return Err(InputError::Usage(format!(
                "{flag} is a setting of spcbpt; leave it out, or add --integrator spcbpt"
            )));
        }
        let training = self.learning.training(self.quality.training(), self.connections());
        let training = training.map_err(|error| InputError::Usage(error.to_string()))?;
        Ok(Training { when: self.learn, ..training })
    }
}
