//! The start-up check: a driver that cuts long loops short would give wrong pictures without an error.

use super::buffer::BufferTable;
use super::context::{Context, DeviceChoice};
use super::kernels::Kernel;
use super::traversal::Traversal;
use crate::device::DeviceError;

impl Context {
    /// Opens a device that traces by kernels, and runs the start-up check on it.
    ///
    /// # Errors
    /// No adapter, none that fits `choice`, or one that computes wrongly.
    pub fn new(choice: &DeviceChoice) -> Result<Self, DeviceError> {
        Self::tracing(choice, Traversal::Compute)
    }

    /// As [`new`](Self::new), with rays traced as is asked for.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`DeviceError::NoRayQueries`].
    pub fn tracing(choice: &DeviceChoice, traversal: Traversal) -> Result<Self, DeviceError> {
        let context = Self::unchecked(choice, traversal)?;
        check_loops(&context)?;
        Ok(context)
    }
}

/// Runs `loop_check.wgsl`, whose loops are longer than any we trace with.
///
/// # Errors
/// [`DeviceError::CutsLoops`] with the counts found and what to install.
fn check_loops(context: &Context) -> Result<(), DeviceError> {
    const EXPECTED: [u32; 3] = [200_000, 65_000, 300_000];
    let kernel = Kernel::new(context, "loop_check", Default::default(), &[])?;
    let mut buffers = BufferTable::default();
    buffers.upload(context, "loop_trips", &EXPECTED)?;
    buffers.create(context, "loop_counts", 12)?;
    let bound = kernel.bind(context, &buffers)?;
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), 1);
    context.queue.submit([encoder.finish()]);
    let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&buffers.read(context, "loop_counts", 12)?);
    if counts == EXPECTED {
        Ok(())
    } else {
        Err(DeviceError::CutsLoops { device: context.describe(), counts, expected: EXPECTED.to_vec() })
    }
}
