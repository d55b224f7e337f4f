//! The arguments that say how light is transported, shared by the subcommands that render.

use clap::{Args, ValueEnum};

use super::input::InputError;
use crate::integrator::{DEFAULT_CONNECTIONS, MAX_CONNECTIONS, Method, Training, When};

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

/// What is worth more: to see something soon, or little noise in the end. What is set by itself goes before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// One connection a vertex (lvcbpt, spcbpt), two lessons (spcbpt).
    Draft,
    /// Three connections, up to five lessons.
    #[default]
    Normal,
    /// Four connections, and up to seven lessons however little the last one taught.
    High,
}

impl Quality {
    fn connections(self) -> u32 {
        match self {
            Self::Draft => 1,
            Self::Normal => DEFAULT_CONNECTIONS,
            Self::High => 4,
        }
    }

    fn training(self) -> Training {
        let normal = Training::default();
        match self {
            Self::Draft => Training { lessons: 2, ..normal },
            Self::Normal => normal,
            Self::High => normal.with_lessons(7),
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
    /// Learn, as published, from so many full paths that path tracing finds (spcbpt). By default it learns from the paths
    /// that it finds itself, by what earlier ones taught: much sooner where light is hard to find.
    #[arg(long, value_name = "N")]
    train_paths: Option<u32>,
    /// How often spcbpt learns anew from the paths that it has found, at most (default: up to 5, as long as the last lesson
    /// was worth it).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16), conflicts_with = "train_paths")]
    lessons: Option<u32>,
    /// When spcbpt learns (default: meanwhile on a GPU that has no number of samples to reach, else first).
    #[arg(long, value_enum, conflicts_with = "train_paths")]
    learn: Option<When>,
    /// Settings for a first look, or for a last one.
    #[arg(long, value_enum, default_value_t)]
    quality: Quality,
    /// Subspaces that spcbpt sorts sub-paths into, on the eye's and on the light's side (default: as many as the
    /// training paths can teach).
    #[arg(long, value_name = "K")]
    subspaces: Option<u32>,
}

impl MethodArgs {
    #[cfg(feature = "preview")]
    pub fn integrator(&self) -> IntegratorName {
        self.integrator
    }

    fn connections(&self) -> u32 {
        self.connections.unwrap_or(self.quality.connections())
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
        if self.quality != Quality::Normal && !matches!(name, Name::Lvcbpt | Name::Spcbpt) {
            return refuse("--quality", "lvcbpt and spcbpt");
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
        let mut training = self.quality.training();
        if self.integrator != IntegratorName::Spcbpt {
            for (given, flag) in [
                (self.train_paths.is_some(), "--train-paths"),
                (self.subspaces.is_some(), "--subspaces"),
                (self.lessons.is_some(), "--lessons"),
                (self.learn.is_some(), "--learn"),
            ] {
                if given {
                    return Err(InputError::Usage(format!(
                        "{flag} is a setting of spcbpt; leave it out, or add --integrator spcbpt"
                    )));
                }
            }
        }
        training.paths = self.train_paths;
        training.when = self.learn;
        training.settings.subspaces = self.subspaces;
        training.settings.connections = self.connections();
        if let Some(lessons) = self.lessons {
            training = training.with_lessons(lessons);
        }
        training.settings.check().map_err(|error| InputError::Usage(error.to_string()))?;
        Ok(training)
    }
}
