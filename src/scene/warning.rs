//! What is wrong with a file without keeping its scene from being shown.

use std::fmt;

/// A part of a file that is not shown as the file has it. Shown as one line.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Warning {
    /// Such as `meshes[3].primitives[0]`.
    pub part: String,
    /// What is wrong with it, or not supported.
    pub problem: String,
    /// What was done about it, and where that is known, what to do.
    pub remedy: String,
}

impl Warning {
    /// A warning of its three parts, each without a full stop.
    pub fn new(part: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { part: part.into(), problem: problem.into(), remedy: remedy.into() }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}; {}", self.part, self.problem, self.remedy)
    }
}
