//! cli

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::accel::AccelError;
use crate::cli::args::InputError;
use crate::device::DeviceError;
use crate::fault::Fault;
use crate::film::FilmError;
#[cfg(feature = "preview")]
use crate::preview::PreviewError;
use crate::render::RenderError;
use crate::scene::SceneError;
use crate::subspace::SubspaceError;

/// Why a subcommand ended early: the layers' errors, and those of the files that subcommands write themselves.
#[derive(Debug, Error)]
pub enum CliError {
    #[error(transparent)]
    Input(#[from] InputError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Accel(#[from] AccelError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Subspace(#[from] SubspaceError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[cfg(feature = "preview")]
    #[error(transparent)]
    Preview(#[from] PreviewError),
    #[error("cannot make the folder {path}: {cause}; choose another place")]
    Folder { path: PathBuf, cause: io::Error },
    #[error("cannot read {what} in {path}: {cause}; check that the file is readable")]
    Read { what: &'static str, path: PathBuf, cause: io::Error },
    #[error("cannot write {what} to {path}: {cause}; choose another place or make room")]
    Write { what: &'static str, path: PathBuf, cause: io::Error },
    #[error("cannot write results to standard output: {cause}; make room, or send them to another file")]
    Stdout { cause: &'static str },
    /// Some outputs of a render; the others are there.
    #[error("{}", say_outputs(failed, written, rescued.as_deref()))]
    Outputs { failed: Vec<CliError>, written: Vec<PathBuf>, rescued: Option<PathBuf> },
    #[error("cannot write figures as JSON: {cause}; this is a defect of Halfway, please report it")]
    Json { cause: serde_json::Error },
    #[error("cannot draw the plot '{title}': {cause}; this is a defect of Halfway, please report it")]
    Plot { title: String, cause: String },
}

impl CliError {
    /// For `map_err` where a folder is made.
    pub fn folder(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |cause| Self::Folder { path: path.to_owned(), cause }
    }

    /// For `map_err` where `what` is written.
    pub fn write(what: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |cause| Self::Write { what, path: path.to_owned(), cause }
    }

    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Input(error) => error.fault(),
            Self::Scene(error) => error.fault(),
            Self::Accel(error) => error.fault(),
            Self::Device(error) => error.fault(),
            Self::Film(error) => error.fault(),
            Self::Subspace(error) => error.fault(),
            Self::Render(error) => error.fault(),
            #[cfg(feature = "preview")]
            Self::Preview(error) => error.fault(),
            Self::Read { .. } => Fault::Input,
            Self::Folder { .. } | Self::Write { .. } | Self::Stdout { .. } | Self::Outputs { .. } => {
                Fault::Machine
            }
            Self::Json { .. } | Self::Plot { .. } => Fault::Defect,
        }
    }
}

/// A line for each that failed, and where the rest is.
fn say_outputs(failed: &[CliError], written: &[PathBuf], rescued: Option<&Path>) -> String {
    let mut text = match failed.len() {
        1 => "an output failed:".to_string(),
        count => format!("{count} outputs failed:"),
    };
    failed.iter().for_each(|error| text.push_str(&format!("\n  {error}")));
    if let Some(path) = rescued {
        text.push_str(&format!("\nthe picture is kept in {}: move it from there", path.display()));
    }
    let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    match written.is_empty() {
        true => text.push_str("\nno output was written"),
        false => text.push_str(&format!("\nwritten: {}", written.join(", "))),
    }
    text
}

impl From<serde_json::Error> for CliError {
    fn from(cause: serde_json::Error) -> Self {
        Self::Json { cause }
    }
}
