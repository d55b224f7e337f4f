//! Exit codes.

use crate::fault::Fault;

/// How a run ended; the process's exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    Done = 0,
    /// It failed, or the compared images differ.
    Failed = 1,
    /// Wrong usage or bad input.
    BadInput = 2,
    /// The budget ended before `--error` was met.
    ErrorNotMet = 3,
    /// No usable device.
    NoDevice = 4,
    /// Non-finite values were found.
    NonFinite = 5,
    /// Interrupted; what was rendered is saved.
    Interrupted = 130,
}

impl From<Exit> for std::process::ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl From<Fault> for Exit {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Input => Self::BadInput,
            Fault::Device => Self::NoDevice,
            Fault::Machine | Fault::Defect => Self::Failed,
            Fault::Interrupted => Self::Interrupted,
        }
    }
}
