//! What is reported while something takes long, and how Ctrl-C ends it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::device::{Compiling, Context};
use crate::integrator::Choice;
use crate::render::{Prepared, RenderError};
use crate::training::{TrainingProgress, TrainingResult};

/// Between two lines where there is no terminal.
const LINE: Duration = Duration::from_secs(10);
/// Time that a round has to finish after Ctrl-C or the end of `--time`: less is done twice, and it is still soon.
const GRACE: Duration = Duration::from_secs(1);
/// Seconds of compiling a kernel below which nothing is said.
const NOTICED: f64 = 0.1;
/// Length of the bar of a share.
const WHOLE: f64 = 1000.0;

/// A bar on a terminal, a line every ten seconds elsewhere; nothing where quiet is asked for.
pub struct Meter {
    bar: ProgressBar,
    quiet: bool,
    start: Instant,
    last_line: Instant,
}

impl Meter {
    /// `length`: the position at the end, if it is known.
    pub fn new(quiet: bool, length: Option<u64>) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(length, target);
        let template = "{bar:30} {percent:>3} %  {msg}  {elapsed} passed, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self { bar, quiet, start: Instant::now(), last_line: Instant::now() }
    }

    pub fn show(&mut self, position: u64, message: String) {
        if self.bar.is_hidden() && !self.quiet && self.last_line.elapsed() >= LINE {
            let done = match self.bar.length() {
                Some(length) => format!("{:.0} %, ", 100.0 * position as f64 / length.max(1) as f64),
                None => String::new(),
            };
            eprintln!("{:.0} s: {done}{message}", self.start.elapsed().as_secs_f64());
            self.last_line = Instant::now();
        }
        self.bar.set_position(position);
        self.bar.set_message(message);
    }

    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Learns, tells how far it is, and ends at Ctrl-C.
///
/// # Errors
/// As [`Prepared::learn`].
pub fn learn(prepared: &mut Prepared, quiet: bool) -> Result<TrainingResult, RenderError> {
    let mut meter = Meter::new(quiet, Some(WHOLE as u64));
    let trained = prepared.learn(|step| {
        let (what, share) = match step {
            TrainingProgress::TrainingPaths(share) => ("training paths", share),
            TrainingProgress::LightPaths(share) => ("light paths", share),
            // A round has just been judged, or is over.
            TrainingProgress::Round(_) | TrainingProgress::Loss(_) => return interrupted(),
            TrainingProgress::Fitting => ("subspaces and Gamma", 1.0),
        };
        meter.show((share * WHOLE) as u64, format!("learning: {what}"));
        interrupted()
    });
    meter.finish();
    trained
}

/// Tells what was chosen for this scene, and why.
pub fn say_choices<'a>(choices: impl IntoIterator<Item = &'a Choice>) {
    for choice in choices {
        eprintln!("chosen: {} {} ({})", choice.what, choice.value, choice.reason);
    }
}

/// Set by Ctrl-C.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Set by SIGUSR1.
static WARNED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Ctrl-C was pressed: end well, and soon.
pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed) || WARNED.load(Ordering::Relaxed)
}

/// The device for work that ends soon after Ctrl-C, if necessary with a round unfinished, and that tells how far its driver is
/// with compiling.
pub fn watched(context: &Context, quiet: bool) -> Context {
    let meter = Mutex::new(Meter::new(quiet, Some(WHOLE as u64)));
    context.interrupted_by(interrupted, GRACE).telling_of_compiling(
        move |Compiling { done, of, seconds, .. }| {
            let mut meter = meter.lock().unwrap_or_else(PoisonError::into_inner);
            if done == of {
                meter.finish();
            } else if seconds > NOTICED {
                meter.show(
                    (WHOLE * done as f64 / of as f64) as u64,
                    format!("compiling: {done} of {of} kernels done"),
                );
            }
        },
    )
}

/// From now on Ctrl-C only makes [`interrupted`] true; a second one ends the process.
pub fn install_interrupt() {
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("\ninterrupted: finishing the round and saving what there is (again to stop at once)");
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        log::warn!("Ctrl-C will stop without saving: {error}");
    }
}

/// From now on SIGUSR1 makes [`interrupted`] true, too, however often it comes: schedulers send it before a job's time is over.
pub fn install_warning() {
    #[cfg(unix)]
    if let Err(error) = signal_hook::flag::register(signal_hook::consts::SIGUSR1, WARNED.clone()) {
        log::warn!("SIGUSR1 will stop without saving: {error}");
    }
}
