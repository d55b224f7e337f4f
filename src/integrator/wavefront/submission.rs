//! Sharing the device with others, such as a window, and ending soon: submissions take no longer than a limit, and what
//! is of no use any more ends between two of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::device::{Context, DeviceError};

use super::Wavefront;

/// Shares of the queues that are used at first, and at least: every submission costs the device something, however few
/// paths it has. Software devices, which are slow, use no more than so many paths then.
const FIRST_SHARE: u32 = 4;
const LEAST_SHARE: u32 = 16;
const FIRST_OF_SOFTWARE: u32 = 1 << 14;
const LEAST_OF_SOFTWARE: u32 = 1 << 12;

/// Dispatches of a submission at first, and at most. Their number doubles where they take less than [`SHORT`], and halves
/// where they take longer than [`LONG`].
const FIRST_DISPATCHES: usize = 16;
const MOST_DISPATCHES: usize = 1 << 12;
const SHORT: Duration = Duration::from_millis(80);
const LONG: Duration = Duration::from_millis(300);

/// For a device that others use meanwhile, such as a window.
#[derive(Clone, Debug)]
pub struct SubmissionLimit {
    /// No submission takes much longer.
    pub slice: Duration,
    /// Set, it ends what is rendered at once, with [`DeviceError::Abandoned`]; the film is worth nothing then.
    pub abandon: Arc<AtomicBool>,
}

/// How much goes to the device at once, and when a round is left unfinished.
pub(super) struct Pace {
    /// Dispatches of a submission.
    pub dispatches: usize,
    limit: Option<SubmissionLimit>,
    /// When the budget's time is over.
    deadline: Option<Instant>,
    /// Since when [`Context::interrupted`] is seen.
    interrupted: Option<Instant>,
    /// What is under way could not be undone.
    is_held: bool,
}

impl Default for Pace {
    fn default() -> Self {
        Self { dispatches: FIRST_DISPATCHES, limit: None, deadline: None, interrupted: None, is_held: false }
    }
}

impl Pace {
    /// So many dispatches took so long: the next submission may be larger or smaller.
    pub fn learn(&mut self, dispatches: usize, taken: Duration) {
        if taken > LONG {
            self.dispatches = (self.dispatches / 2).max(1);
        } else if taken < SHORT && dispatches == self.dispatches {
            self.dispatches = (self.dispatches * 2).min(MOST_DISPATCHES);
        }
    }

    /// Ends the round if it is to end now.
    ///
    /// # Errors
    /// [`DeviceError::Abandoned`].
    pub fn check(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.interrupted = context.interrupted().then(|| self.interrupted.unwrap_or_else(Instant::now));
        let abandoned = self.limit.as_ref().is_some_and(|limit| limit.abandon.load(Ordering::Relaxed));
        let since = [self.interrupted, self.deadline].into_iter().flatten().min();
        let is_late =
            context.grace().zip(since).is_some_and(|(grace, since)| Instant::now() >= since + grace);
        if abandoned || (is_late && !self.is_held) { Err(DeviceError::Abandoned) } else { Ok(()) }
    }
}

impl Wavefront {
    /// From now on leaves the device to others in between.
    pub fn limit_submissions(&mut self, submission_limit: SubmissionLimit) {
        self.slice = self.part(FIRST_SHARE, FIRST_OF_SOFTWARE);
        self.pace.limit = Some(submission_limit);
    }

    /// A share of the queues, but on a software device so many paths at most.
    fn part(&self, share: u32, of_software: u32) -> u32 {
        let most = if self.is_software() { of_software } else { u32::MAX };
        (self.capacity / share).min(most)
    }

    /// Others use the device meanwhile.
    pub(crate) fn shares_device(&self) -> bool {
        self.pace.limit.is_some()
    }

    /// From now on leaves a round unfinished, with [`DeviceError::Abandoned`], if it goes on for longer than the context's
    /// [grace](Context::grace) after `deadline`.
    pub(crate) fn set_deadline(&mut self, deadline: Option<Instant>) {
        self.pace.deadline = deadline;
    }

    /// From now on, what is under way is finished at any rate (but where all is abandoned).
    pub(crate) fn hold(&mut self, is_held: bool) {
        self.pace.is_held = is_held;
    }

    /// The first submission of a batch took so long: the next batch may be larger or smaller.
    pub(super) fn adapt_slice(&mut self, taken: Duration) {
        let Some(SubmissionLimit { slice, .. }) = &self.pace.limit else { return };
        // Twice the paths take less than twice as long.
        if taken > *slice * 3 / 2 {
            self.slice = (self.slice / 2).max(self.part(LEAST_SHARE, LEAST_OF_SOFTWARE));
        } else if taken < *slice * 2 / 3 && 2 * self.started > self.slice {
            self.slice = (self.slice * 2).min(self.capacity);
        }
    }
}
