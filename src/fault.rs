//! Whose fault an error is. Every layer's error says so by a method of its own, in a `match` without a wildcard, and the
//! command's exit code follows from nothing else.

/// What kind of thing went wrong, as far as it decides what to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The user's files, options or scene: change them and start it again.
    Input,
    /// There is no device that can be used.
    Device,
    /// The machine failed: a full disk, a lost device, no memory left.
    Machine,
    /// Halfway is wrong: to be reported.
    Defect,
    /// The user ended it.
    Interrupted,
}
