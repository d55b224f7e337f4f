//! Results on standard output. Whoever reads them may have enough before the end, as `| head` has: the rest is dropped, and
//! files are written all the same. What else goes wrong is remembered for the program's end.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;

static FAULT: OnceLock<String> = OnceLock::new();

/// A line, as `println!` has it.
#[macro_export]
macro_rules! out {
    () => { $crate::out!("") };
    ($($text:tt)*) => { $crate::stdout::line(format_args!($($text)*)) };
}

/// See [`out!`].
pub fn line(text: Arguments) {
    if let Err(error) = writeln!(io::stdout().lock(), "{text}")
        && error.kind() != ErrorKind::BrokenPipe
    {
        FAULT.get_or_init(|| error.to_string());
    }
}

/// Why lines are missing that somebody waits for.
pub fn fault() -> Option<&'static str> {
    FAULT.get().map(String::as_str)
}
