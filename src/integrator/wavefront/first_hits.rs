//! What the camera sees first, for layers beside the picture.

use crate::device::layout::{Counts, FirstHitPixel, Hit, NO_TRIANGLE};
use crate::device::{Bound, Context, DeviceError};

use super::film_pages::FIRST_HITS;
use super::{Extent, Wavefront, record, total};

/// Mirrors and panes of smooth glass, one behind the other, that layers look through.
const MOST_MIRRORS: u32 = 16;

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
        self.clear(FIRST_HITS, &mut encoder);
        context.queue.submit([encoder.finish()]);
        for batch in self.batches(0, samples) {
            let paths = batch.pixel_count * batch.sample_count;
            let mut encoder = self.start(context, &batch, &self.camera_rays.clone())?;
            record(&mut encoder, &mut None, &self.closest_hit[0], Extent::Count(paths));
            if let Some(follow) = self.mirror_follow.clone() {
                encoder = self.follow_mirrors(context, encoder, &follow, paths)?;
            }
            if let Some(first_hit) = self.first_hit.get(self.pages.of(batch.first_pixel)) {
                record(&mut encoder, &mut None, first_hit, Extent::Count(batch.pixel_count));
            }
            context.queue.submit([encoder.finish()]);
            if self.shares_device() {
                context.wait()?;
            }
        }
        self.timing = timing;
        self.aside += total(self.counts(context)?.closest_total) - before;
        self.read_first_hits(context)
    }

    /// What the camera's rays of samples `first .. first + samples` meet, in order for each pixel: `visit` gets the pixel, and
    /// nothing where they leave the scene. None of these rays is counted or timed.
    ///
    /// # Errors
    /// A lost device.
    pub fn camera_hits(
        &mut self,
        context: &Context,
        first: u32,
        samples: u32,
        mut visit: impl FnMut(usize, Option<&Hit>),
    ) -> Result<(), DeviceError> {
        let timing = self.timing.take();
        let before = total(self.counts(context)?.closest_total);
        for batch in self.batches(first, samples) {
            let paths = batch.pixel_count * batch.sample_count;
            let mut encoder = self.start(context, &batch, &self.camera_rays.clone())?;
            record(&mut encoder, &mut None, &self.closest_hit[0], Extent::Count(paths));
            context.queue.submit([encoder.finish()]);
            let bytes = u64::from(paths) * size_of::<Hit>() as u64;
            let hits: Vec<Hit> = bytemuck::pod_collect_to_vec(&self.buffers.read(context, "hits", bytes)?);
            for (path, hit) in hits.iter().enumerate() {
                let pixel = batch.first_pixel as usize + path % batch.pixel_count as usize;
                visit(pixel, Some(hit).filter(|hit| hit.triangle != NO_TRIANGLE));
            }
        }
        self.timing = timing;
        self.aside += total(self.counts(context)?.closest_total) - before;
        Ok(())
    }

    /// Sends paths on from mirrors and smooth glass until none is at one, as often as they may.
    fn follow_mirrors(
        &mut self,
        context: &Context,
        mut encoder: wgpu::CommandEncoder,
        follow: &Bound,
        paths: u32,
    ) -> Result<wgpu::CommandEncoder, DeviceError> {
        let counted = std::mem::offset_of!(Counts, paths_out) as u64;
        for _ in 0..MOST_MIRRORS {
            encoder.clear_buffer(self.buffers.get("counts")?, counted, Some(4));
            record(&mut encoder, &mut None, follow, Extent::Count(paths));
            context.queue.submit([encoder.finish()]);
            encoder = context.device.create_command_encoder(&Default::default());
            if self.counts(context)?.paths_out == 0 {
                break;
            }
            record(&mut encoder, &mut None, &self.closest_hit[0], Extent::Count(paths));
        }
        encoder.clear_buffer(self.buffers.get("counts")?, counted, Some(4));
        Ok(encoder)
    }
}
