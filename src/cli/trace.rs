//! `halfway render --reference REF.exr --trace-error FILE.csv`: how the error falls while a picture converges.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::args::{InputError, read_reference, try_output};
use crate::bench::trade::Checkpoint;
use crate::cli::CliError;
use crate::film::metric::flip;
use crate::film::write::write_atomic;
use crate::film::{FilmError, Picture};
use crate::render::Report;

/// Options of a render that is compared with a better picture.
#[derive(Args, Debug)]
pub struct TraceArgs {
    /// A better picture of the same view and size: the error against it is reported at the end.
    #[arg(long, value_name = "REF.exr")]
    reference: Option<PathBuf>,
    /// Write the error against --reference by samples and seconds, whenever samples have doubled and at the end.
    /// Comparing takes none of the time that is written.
    #[arg(long, value_name = "FILE.csv", requires = "reference")]
    trace_error: Option<PathBuf>,
}

/// A reference, and the file of errors against it.
pub struct Trace {
    reference: Picture,
    file: Option<TraceFile>,
    last: Option<Checkpoint>,
}

/// Rows that are appended to a file as they come.
struct TraceFile {
    path: PathBuf,
    /// All rows.
    text: String,
    /// Until one cannot be written: then all of them are, at the end.
    file: Option<File>,
}

impl TraceArgs {
    /// Errors on the way are wanted.
    pub fn is_given(&self) -> bool {
        self.trace_error.is_some()
    }

    /// Tries the place of the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn try_output(&self) -> Result<(), InputError> {
        self.trace_error.iter().try_for_each(|path| try_output(path))
    }

    /// Reads the reference of a picture of so many pixels and begins the file. `None` where none is asked for.
    ///
    /// # Errors
    /// A reference that cannot be read or is of another size; a file that cannot be written.
    pub fn open(&self, size: [u32; 2]) -> Result<Option<Trace>, CliError> {
        let Some(path) = &self.reference else { return Ok(None) };
        let reference = read_reference(path, size)?;
        let file = self.trace_error.as_deref().map(TraceFile::create).transpose()?;
        Ok(Some(Trace { reference, file, last: None }))
    }
}

impl Trace {
    /// Whether it is time for a checkpoint.
    pub fn is_due(&self, samples: u32) -> bool {
        self.file.is_some() && samples >= self.last.map_or(1, |last| last.samples.saturating_mul(2))
    }

    /// Compares a picture, and writes it down.
    ///
    /// # Errors
    /// Pictures that cannot be compared.
    pub fn add(&mut self, report: &Report, picture: &Picture) -> Result<Checkpoint, FilmError> {
        // Times are the clock's; the device's pace is for benchmarks.
        let point = Checkpoint::new(report, picture, &self.reference, [0.0; 2])?;
        let point = Checkpoint { flip: Some(flip(picture, &self.reference)), ..point };
        if let Some(file) = self.file.as_mut().filter(|_| self.last.is_none_or(|l| l.samples < point.samples))
        {
            file.add(&point.row());
        }
        self.last = Some(point);
        Ok(point)
    }

    /// Ends the file, where there is one: its path, and whether all of it is there.
    pub fn end(self) -> Option<(PathBuf, Result<(), FilmError>)> {
        self.file.map(|file| (file.path.clone(), file.end()))
    }
}

impl TraceFile {
    fn create(path: &Path) -> Result<Self, CliError> {
        let file = File::create(path).map_err(CliError::write("the errors", path))?;
        let mut file = Self { path: path.to_owned(), text: String::new(), file: Some(file) };
        file.add(Checkpoint::COLUMNS);
        Ok(file)
    }

    fn add(&mut self, line: &str) {
        let line = format!("{line}\n");
        let appended = self.file.as_mut().map_or(Ok(()), |file| file.write_all(line.as_bytes()));
        if appended.is_err() {
            self.file = None;
        }
        self.text.push_str(&line);
    }

    fn end(self) -> Result<(), FilmError> {
        // A file that was removed can be appended to as well.
        if self.file.is_some() && self.path.exists() {
            return Ok(());
        }
        write_atomic(&self.path, self.text.as_bytes())
    }
}
