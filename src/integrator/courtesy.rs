//! Sharing the device with others, such as a window: submissions take no longer than they are told to, and what nobody
//! wants any more ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::error::DeviceError;

use super::wavefront::Wavefront;

/// Paths in flight at first, where a submission may not take long.
const FIRST_SLICE: u32 = 1 << 12;
/// Fewer are not worth the way to the device.
const LEAST_SLICE: u32 = 1 << 10;

/// For a device that others use meanwhile, such as a window.
#[derive(Clone, Debug)]
pub struct Courtesy {
    /// No submission takes much longer.
    pub slice: Duration,
    /// Set, it ends what is rendered at once, with [`DeviceError::Abandoned`]; the film is worth nothing then.
    pub abandon: Arc<AtomicBool>,
}

impl Wavefront {
    /// From now on leaves the device to others in between.
    pub fn be_courteous(&mut self, courtesy: Courtesy) {
        self.slice = FIRST_SLICE.min(self.capacity);
        self.courtesy = Some(courtesy);
    }

    /// A submission took so long: the next batch may be larger or smaller.
    pub(super) fn pace(&mut self, taken: Duration) -> Result<(), DeviceError> {
        let Some(Courtesy { slice, abandon }) = &self.courtesy else { return Ok(()) };
        if abandon.load(Ordering::Relaxed) {
            return Err(DeviceError::Abandoned);
        }
        if taken > *slice {
            self.slice = (self.slice / 2).max(LEAST_SLICE);
        } else if taken < *slice / 3 && 2 * self.started > self.slice {
            self.slice = (self.slice * 2).min(self.capacity);
        }
        Ok(())
    }
}
