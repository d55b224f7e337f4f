//! The arguments that say how light is transported, shared by the subcommands that render.

use clap::{Args, ValueEnum};

use super::input::InputError;
use crate::integrator::{DEFAULT_CONNECTIONS, MAX_CONNECTIONS, Method, Training};

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

/// How light is transported, and with which settings.
#[derive(Args, Debug)]
pub struct MethodArgs {
    #[arg(short, long, value_enum, default_value_t)]
    integrator: IntegratorName,
    /// Light paths of an iteration, that is for one sample of every pixel (default: lvcbpt a quarter of the pixels,
    /// light all of them).
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
    /// Subspaces that spcbpt sorts sub-paths into, on the eye's and on the light's side (default: as many as the
    /// training paths can teach).
    #[arg(long, value_name = "K")]
    subspaces: Option<u32>,
}

impl MethodArgs {
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
            return Err(InputError::Usage("--light-paths takes at least 1 light path an iteration".into()));
        }
        let connections = self.connections.unwrap_or(DEFAULT_CONNECTIONS);
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
        let mut training = Training::default();
        if self.integrator != IntegratorName::Spcbpt {
            for (given, flag) in
                [(self.train_paths.is_some(), "--train-paths"), (self.subspaces.is_some(), "--subspaces")]
            {
                if given {
                    return Err(InputError::Usage(format!(
                        "{flag} is a setting of spcbpt; leave it out, or add --integrator spcbpt"
                    )));
                }
            }
        }
        training.paths = self.train_paths;
        training.settings.subspaces = self.subspaces;
        training.settings.connections = self.connections.unwrap_or(DEFAULT_CONNECTIONS);
        training.settings.check().map_err(|error| InputError::Usage(error.to_string()))?;
        Ok(training)
    }
}
