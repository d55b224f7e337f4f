//! Faults of one part of a file: the rest of the scene is shown all the same, unless that is ruled out.

use std::collections::HashSet;

use crate::scene::{SceneError, Warning};

/// Collects the warnings of a file; the same one is kept once.
#[derive(Debug, Default)]
pub struct Faults {
    /// Each fault is an error.
    strict: bool,
    warnings: Vec<Warning>,
    known: HashSet<Warning>,
}

impl Faults {
    /// None so far.
    pub fn new(strict: bool) -> Self {
        Self { strict, ..Self::default() }
    }

    /// Adds a warning of what the file may well have, but is not shown as it is there: no error, even where strict.
    pub fn note(&mut self, part: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) {
        let warning = Warning::new(part, problem, remedy);
        if self.known.insert(warning.clone()) {
            self.warnings.push(warning);
        }
    }

    /// Takes note of `error`, which concerns nothing but `part` or something in it; `remedy` says what is done about
    /// it.
    ///
    /// # Errors
    /// `error` where strict, and where it concerns the whole file: limits and missing extensions.
    pub fn tolerate(&mut self, part: &str, error: SceneError, remedy: &str) -> Result<(), SceneError> {
        if self.strict {
            return Err(error);
        }
        let mut part = part;
        let problem = match &error {
            SceneError::Invalid { at, code, detail } if at.contains(part) => {
                part = at;
                format!("{detail} ({code})")
            }
            SceneError::Invalid { at, code, detail } => format!("{at}: {detail} ({code})"),
            SceneError::Image { detail, .. } => format!("it cannot be decoded: {detail}"),
            SceneError::Read { path, cause } => format!("cannot read {}: {cause}", path.display()),
            SceneError::Uri { uri, reason } => format!("refused to read \"{uri}\": {reason}"),
            _ => return Err(error),
        };
        self.note(part, problem, remedy);
        Ok(())
    }

    /// The value, or nothing where reading it failed and [`Self::tolerate`] allows that.
    ///
    /// # Errors
    /// Those of [`Self::tolerate`].
    pub fn or_without<T>(
        &mut self,
        part: &str,
        read: Result<T, SceneError>,
        remedy: &str,
    ) -> Result<Option<T>, SceneError> {
        match read {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.tolerate(part, error, remedy).map(|()| None),
        }
    }

    /// True where each fault is an error.
    pub fn is_strict(&self) -> bool {
        self.strict
    }

    /// There is no warning yet.
    pub fn is_empty(&self) -> bool {
        self.warnings.is_empty()
    }

    /// All warnings in the order of reading.
    pub fn into_warnings(self) -> Vec<Warning> {
        self.warnings
    }
}
