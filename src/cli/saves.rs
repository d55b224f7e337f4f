//! What became of the outputs of a render: one that fails does not keep the others from being written.

use std::path::{Path, PathBuf};

use super::CliError;
use crate::out;

/// What was written, and what was not and why.
#[derive(Debug, Default)]
pub struct Saves {
    written: Vec<PathBuf>,
    failed: Vec<CliError>,
    /// Where the picture was put since it found no place in its own files.
    rescued: Option<PathBuf>,
}

impl Saves {
    /// Takes down what became of the report at `path`.
    pub fn report(&mut self, path: &Path, result: Result<(), impl Into<CliError>>) {
        match result {
            Ok(()) => self.written.push(path.to_owned()),
            Err(error) => self.fail(error),
        }
    }

    /// Takes down what became of the picture, or the folder of them, at `path`. Where there is one, stdout says so.
    pub fn picture(&mut self, path: &Path, result: Result<(), impl Into<CliError>>) {
        if result.is_ok() {
            out!("{}", path.display());
        }
        self.report(path, result);
    }

    /// Takes down what became of a file that is part of an output.
    pub fn part(&mut self, result: Result<(), impl Into<CliError>>) {
        if let Err(error) = result {
            self.fail(error);
        }
    }

    /// Takes down what is no file: a viewer that has gone, a device that is lost.
    pub fn fail(&mut self, error: impl Into<CliError>) {
        self.failed.push(error.into());
    }

    /// The picture lies in a file that was not asked for.
    pub fn rescue(&mut self, path: &Path) {
        self.rescued = Some(path.to_owned());
    }

    /// Ends the render.
    ///
    /// # Errors
    /// [`CliError::Outputs`] where something failed.
    pub fn end(self) -> Result<(), CliError> {
        let Self { written, failed, rescued } = self;
        match failed.is_empty() {
            true => Ok(()),
            false => Err(CliError::Outputs { failed, written, rescued }),
        }
    }
}
