//! Sharing the device with others, such as a window: submissions take no longer than a limit, and what
//! is of no use any more ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::device::DeviceError;

use super::Wavefront;

/// Shares of the queues that are used at first, and at least: every submission costs the device something, however few
/// paths it has.
const FIRST_SHARE: u32 = 4;
const LEAST_SHARE: u32 = 16;

/// For a device that others use meanwhile, such as a window.
#[derive(Clone, Debug)]
pub struct SubmissionLimit {
    /// No submission takes much longer.
    pub slice: Duration,
    /// Set, it ends what is rendered at once, with [`DeviceError::Abandoned`]; the film is worth nothing then.
    pub abandon: Arc<AtomicBool>,
}

impl Wavefront {
    /// From now on leaves the device to others in between.
    pub fn limit_submissions(&mut self, submission_limit: SubmissionLimit) {
        self.slice = self.capacity / FIRST_SHARE;
        self.submission_limit = Some(submission_limit);
    }

    /// A submission took so long: the next batch may be larger or smaller.
    pub(crate) fn pace(&mut self, taken: Duration) -> Result<(), DeviceError> {
        let Some(SubmissionLimit { slice, abandon }) = &self.submission_limit else { return Ok(()) };
        if abandon.load(Ordering::Relaxed) {
            return Err(DeviceError::Abandoned);
        }
        // Twice the paths take less than twice as long.
        if taken > *slice * 3 / 2 {
            self.slice = (self.slice / 2).max(self.capacity / LEAST_SHARE);
        } else if taken < *slice * 2 / 3 && 2 * self.started > self.slice {
            self.slice = (self.slice * 2).min(self.capacity);
        }
        Ok(())
    }
}
