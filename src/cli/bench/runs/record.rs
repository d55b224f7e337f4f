//! Renders that are done, one per line of a file that lines are only added to, so that a benchmark that is cut off goes
//! on.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::bench::key::RunKey;
use crate::bench::trade::Checkpoint;
use crate::cli::{CliError, Exit};

/// A render that was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    #[serde(flatten)]
    pub key: RunKey,
    pub checkpoints: Vec<Checkpoint>,
}

/// How a device's speed changed while renders were measured.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Drift {
    /// Seconds for a unit of work, over all that was measured.
    pub usual_seconds_per_unit: f64,
    /// That of the fastest and of the slowest render over it.
    pub best: f64,
    pub worst: f64,
}

impl Drift {
    /// Of renders; `None` without any.
    pub fn of<'a>(renders: impl Iterator<Item = &'a [Checkpoint]>) -> Option<Self> {
        let ends: Vec<&Checkpoint> = renders.filter_map(<[Checkpoint]>::last).collect();
        let (seconds, work) = ends.iter().fold((0.0, 0.0), |(seconds, work), end| {
            (seconds + end.total_seconds(), work + end.total_work())
        });
        let usual_seconds_per_unit = seconds / work;
        let over = |end: &&Checkpoint| end.total_seconds() / end.total_work() / usual_seconds_per_unit;
        let best = ends.iter().map(over).min_by(f64::total_cmp)?;
        let worst = ends.iter().map(over).max_by(f64::total_cmp)?;
        Some(Self { usual_seconds_per_unit, best, worst })
    }
}

/// The file, and what is in it.
pub struct Records {
    path: PathBuf,
    records: Vec<Record>,
}

impl Records {
    /// Tells that Ctrl-C ended the benchmark, and how it goes on.
    pub fn interrupted(&self) -> Exit {
        eprintln!(
            "interrupted: {} renders are kept in {}; the same command goes on from there",
            self.len(),
            self.path.display()
        );
        Exit::Interrupted
    }

    /// Reads the file, if there is one. A last line without its end, which a program that was stopped leaves, is taken
    /// out; lines that are not understood stay, and both are reported.
    ///
    /// # Errors
    /// A file that cannot be read, or not be shortened.
    pub fn open(path: &Path) -> Result<Self, CliError> {
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            text => {
                text.map_err(|cause| CliError::Read { what: "the runs", path: path.to_owned(), cause })?
            }
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        if whole < text.len() {
            log::warn!("the last line of {} is cut off: that run is done again", path.display());
            let file = OpenOptions::new().write(true).open(path);
            file.and_then(|file| file.set_len(whole as u64))
                .map_err(CliError::write("all but the cut-off line", path))?;
        }
        let mut records = Vec::new();
        for (number, line) in text[..whole].lines().enumerate() {
            match serde_json::from_str(line) {
                Ok(record) => records.push(record),
                Err(error) => log::warn!(
                    "{}, line {}: {error}; it is left as it is and not used",
                    path.display(),
                    number + 1
                ),
            }
        }
        Ok(Self { path: path.to_owned(), records })
    }

    /// The checkpoints of a render that is done; the last one, should there be several.
    pub fn find(&self, key: &RunKey) -> Option<&[Checkpoint]> {
        self.records
            .iter()
            .rev()
            .find(|record| record.key == *key)
            .map(|record| record.checkpoints.as_slice())
    }

    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Writes a render down before anything else is done.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn push(&mut self, record: Record) -> Result<(), CliError> {
        let mut line = serde_json::to_string(&record)?;
        line.push('\n');
        let file = OpenOptions::new().create(true).append(true).open(&self.path);
        // In one piece: a line is there or it is not, as far as the system can help it.
        let written = file.and_then(|mut file: File| {
            file.write_all(line.as_bytes())?;
            file.sync_data()
        });
        written.map_err(CliError::write("a run", &self.path))?;
        self.records.push(record);
        Ok(())
    }
}
