//! What the camera sees first, for layers beside the picture.

use crate::device::layout::FirstHitPixel;
use crate::device::{Context, DeviceError};

use super::{Extent, Wavefront, record, total};

impl Wavefront {
    /// Sums what the camera sees first over `samples` samples of every pixel, and takes the sums. None of these rays is
    /// counted or timed.
    ///
    /// # Errors
    /// A lost device.
    pub fn first_hits(&mut self, context: &Context, samples: u32) -> Result<Vec<FirstHitPixel>, DeviceError> {
        let timing = self.timing.take();
        let before = total(self.counts(context)?.closest_total);
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(self.buffers.get("first_hits")?, 0, None);
        context.queue.submit([encoder.finish()]);
        for batch in self.batches(0, samples) {
            let paths = batch.pixel_count * batch.sample_count;
            let mut encoder = self.start(context, &batch, &self.camera_rays.clone())?;
            record(&mut encoder, &mut None, &self.closest_hit[0], Extent::Count(paths));
            if let Some(first_hit) = &self.first_hit {
                record(&mut encoder, &mut None, first_hit, Extent::Count(batch.pixel_count));
            }
            context.queue.submit([encoder.finish()]);
            if self.shares_device() {
                context.wait()?;
            }
        }
        self.timing = timing;
        self.aside += total(self.counts(context)?.closest_total) - before;
        let bytes = u64::from(self.settings.view.region().pixels()) * size_of::<FirstHitPixel>() as u64;
        Ok(bytemuck::pod_collect_to_vec(&self.buffers.read(context, "first_hits", bytes)?))
    }
}
