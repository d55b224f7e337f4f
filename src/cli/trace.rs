//! `halfway render --reference REF.exr --trace-error FILE.csv`: how the error falls while a picture converges.

use std::fs::File;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::args::{check_folder, read_reference};
use crate::bench::trade::{Point, look};
use crate::cli::CliError;
use crate::film::Picture;
use crate::render::Report;

/// Options of a render whose picture is known better already.
#[derive(Args, Debug)]
pub struct TraceArgs {
    /// A better picture of the same view and size: the error against it is reported at the end.
    #[arg(long, value_name = "REF.exr")]
    reference: Option<PathBuf>,
    /// Write the error against --reference by samples and seconds, whenever samples have doubled and at the end. Looking
    /// takes none of the time that is written.
    #[arg(long, value_name = "FILE.csv", requires = "reference")]
    trace_error: Option<PathBuf>,
}

/// A reference, and what became of the error against it.
pub struct Trace {
    reference: Picture,
    file: Option<(File, PathBuf)>,
    last: Option<Point>,
}

impl TraceArgs {
    /// Reads the reference of a picture of so many pixels and begins the file. `None` where none is asked for.
    ///
    /// # Errors
    /// A reference that cannot be read or is of another size; a file that cannot be written.
    pub fn open(&self, size: [u32; 2]) -> Result<Option<Trace>, CliError> {
        let Some(path) = &self.reference else { return Ok(None) };
        let reference = read_reference(path, size)?;
        let mut trace = Trace { reference, file: None, last: None };
        if let Some(path) = &self.trace_error {
            check_folder(path)?;
            let file = File::create(path).map_err(CliError::write("the errors", path))?;
            trace.file = Some((file, path.clone()));
            trace.write(Point::COLUMNS)?;
        }
        Ok(Some(trace))
    }
}

impl Trace {
    /// Whether it is time for a look.
    pub fn is_due(&self, samples: u32) -> bool {
        self.file.is_some() && samples >= self.last.map_or(1, |last| last.samples.saturating_mul(2))
    }

    /// Compares a picture, and writes it down.
    ///
    /// # Errors
    /// A full disk.
    pub fn look(&mut self, report: &Report, picture: &Picture) -> Result<Point, CliError> {
        // Times are the clock's; the device's pace is for benchmarks.
        let point = look(report, picture, &self.reference, [0.0; 2])?;
        if self.last.is_none_or(|last| last.samples < point.samples) {
            self.write(&point.row())?;
        }
        self.last = Some(point);
        Ok(point)
    }

    fn write(&mut self, line: &str) -> Result<(), CliError> {
        match &mut self.file {
            Some((file, path)) => writeln!(file, "{line}").map_err(CliError::write("the errors", path)),
            None => Ok(()),
        }
    }
}
