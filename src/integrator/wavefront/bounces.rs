//! Batches of samples, and the loop over the surfaces of their paths.

use std::time::Instant;

use super::Wavefront;
use crate::device::layout::{Batch, EVERY_STRATEGY, SAMPLES_A_GROUP};
use crate::device::timing::Timing;
use crate::device::{Bound, Context, DeviceError};
use crate::math::rng::seed_key;

/// Surfaces between two looks at how many paths are left, at most.
const BOUNCES_PER_SUBMISSION: u32 = 8;
/// Depth is stored in 16 bits.
const LARGEST_DEPTH: u32 = 0xffff;
/// Sets the numbers of light paths apart from those of eye paths.
const LIGHT_STREAM: u32 = 0x9e37_79b9;

/// How many invocations a stage has: known here, or read by the device from `arguments`.
#[derive(Clone, Copy)]
pub(crate) enum Size {
    Count(u32),
    /// Paths in the queue.
    Paths,
    /// Connections in the queue.
    Shadow,
    /// So many connections for each path in the queue, as many as there are slots at most.
    Connections(u32),
}

/// A kernel of a bounce.
#[derive(Clone)]
pub(crate) struct Stage {
    pub kernel: Bound,
    pub size: Size,
}

impl Stage {
    pub fn new(kernel: &Bound, size: Size) -> Self {
        Self { kernel: kernel.clone(), size }
    }
}

/// The stages of a bounce. Paths change places between two buffers, hence two of each.
pub(crate) type Bounce = [Vec<Stage>; 2];

/// The stages of each bounce, where the first differ.
#[derive(Default)]
pub(crate) struct Bounces {
    pub first: Vec<Vec<Stage>>,
    pub others: Bounce,
}

impl From<Bounce> for Bounces {
    fn from(others: Bounce) -> Self {
        Self { first: Vec::new(), others }
    }
}

impl Bounces {
    fn at(&self, depth: u32) -> &[Stage] {
        self.first.get(depth as usize).unwrap_or(&self.others[depth as usize % 2])
    }
}

impl Wavefront {
    /// Samples of the whole picture that the queues hold at once; but no more than a group.
    pub(crate) fn samples_at_once(&self) -> u32 {
        let pixels = self.settings.view.width * self.settings.view.height;
        let most = (self.capacity / pixels).clamp(1, SAMPLES_A_GROUP);
        // Groups are made of whole rounds.
        1 << most.ilog2()
    }

    /// A batch of one path of the first pixel, to make drivers compile: they do so at the first dispatch.
    pub(crate) fn tiny_batch(&self) -> Batch {
        Batch { pixel_count: 1, sample_count: 1, max_depth: 2, ..self.batches(0, 1)[0] }
    }

    /// Cuts samples into batches that the queues hold: whole rounds over small pictures, parts of large ones. Where only
    /// slices of the queues are used, there are fewer pixels in a batch, not fewer samples.
    pub(crate) fn batches(&self, first_sample: u32, samples: u32) -> Vec<Batch> {
        let pixels = self.settings.view.region().pixels();
        let samples_a_batch = (self.capacity / pixels).max(1);
        let pixels_a_batch = pixels.min((self.slice / samples_a_batch.min(samples.max(1))).max(1));
        let strategy = self.settings.strategy;
        let template = Batch {
            width: self.settings.view.width,
            height: self.settings.view.height,
            crop_x: self.settings.view.region().x,
            crop_y: self.settings.view.region().y,
            crop_width: self.settings.view.region().width,
            crop_height: self.settings.view.region().height,
            crop_stride: self.settings.view.region().stride,
            seed: seed_key(self.settings.view.seed),
            // Another stream than any user's seed gives the eye paths.
            light_seed: seed_key(!self.settings.view.seed).wrapping_add(LIGHT_STREAM),
            max_depth: self.settings.view.max_depth.unwrap_or(LARGEST_DEPTH).min(LARGEST_DEPTH),
            only_s: strategy.map_or(EVERY_STRATEGY, |strategy| strategy.s),
            only_t: strategy.map_or(EVERY_STRATEGY, |strategy| strategy.t),
            weighted: u32::from(strategy.is_none_or(|strategy| strategy.weighted)),
            subspaces: self.subspaces,
            splat_scale: self.splat_scale,
            ..Batch::default()
        };
        let mut batches = Vec::new();
        for sample in (0..samples).step_by(samples_a_batch as usize) {
            let mut pixel = 0;
            while pixel < pixels {
                let pixel_count = pixels_a_batch.min(self.pages.left(pixel)).min(pixels - pixel);
                batches.push(Batch {
                    first_pixel: pixel,
                    pixel_count,
                    first_sample: first_sample + sample,
                    sample_count: samples_a_batch.min(samples - sample),
                    ..template
                });
                pixel += pixel_count;
            }
        }
        batches
    }

    /// What kernels see from now on.
    pub(crate) fn set_batch(&mut self, context: &Context, batch: &Batch) -> Result<(), DeviceError> {
        self.pace.check(context)?;
        self.buffers.write(context, "batch", bytemuck::bytes_of(batch))
    }

    /// Fills the queue with the first rays of a batch.
    pub(crate) fn start(
        &mut self,
        context: &Context,
        batch: &Batch,
        first_rays: &Bound,
    ) -> Result<wgpu::CommandEncoder, DeviceError> {
        self.set_batch(context, batch)?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        if let Ok(count) = self.buffers.get("eye_link_count") {
            encoder.clear_buffer(count, 0, None);
        }
        let paths = batch.pixel_count * batch.sample_count;
        self.started = paths;
        record(&mut encoder, &mut self.timing, first_rays, Extent::Count(paths));
        record(&mut encoder, &mut self.timing, &self.advance, Extent::Count(1));
        Ok(encoder)
    }

    /// Records stages one after the other.
    pub(crate) fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        stages: &[Stage],
    ) -> Result<(), DeviceError> {
        let arguments = self.buffers.get("arguments")?;
        // A pass of their own only where each is timed: it costs as much as two dispatches.
        let mut shared = match self.timing {
            Some(_) => None,
            None => Some(encoder.begin_compute_pass(&Default::default()).forget_lifetime()),
        };
        for stage in stages {
            let extent = match stage.size {
                Size::Count(count) => Extent::Count(count),
                Size::Paths => Extent::Indirect(arguments, 0),
                Size::Shadow => Extent::Indirect(arguments, 16),
                Size::Connections(slots) => Extent::Indirect(arguments, 16 + 16 * u64::from(slots)),
            };
            match &mut shared {
                Some(pass) => dispatch(pass, &stage.kernel, extent),
                None => record(encoder, &mut self.timing, &stage.kernel, extent),
            }
        }
        Ok(())
    }

    /// Bounces until no path is left, but `max_bounces` at most. What `encoder` holds goes before.
    pub(crate) fn bounce(
        &mut self,
        context: &Context,
        mut encoder: wgpu::CommandEncoder,
        stages: &Bounces,
        max_bounces: u32,
    ) -> Result<(), DeviceError> {
        let mut depth = 0;
        // Stages of the bounce at `depth` that are recorded: it may take several submissions.
        let mut recorded = 0;
        let mut is_first = true;
        self.paths += u64::from(self.started);
        loop {
            let start = Instant::now();
            let end = (depth + BOUNCES_PER_SUBMISSION).min(max_bounces);
            let mut left = self.pace.dispatches;
            while left > 0 && depth < end {
                let bounce = stages.at(depth);
                let count = left.min(bounce.len() - recorded);
                self.record(&mut encoder, &bounce[recorded..recorded + count])?;
                left -= count;
                recorded += count;
                if recorded == bounce.len() {
                    recorded = 0;
                    depth += 1;
                }
            }
            context.queue.submit([encoder.finish()]);
            encoder = context.device.create_command_encoder(&Default::default());
            if let Some(timing) = self.timing.as_mut().filter(|timing| timing.is_filling()) {
                timing.collect(context)?;
            }
            let counts = self.counts(context)?;
            self.pace.learn(self.pace.dispatches - left, start.elapsed());
            if std::mem::take(&mut is_first) {
                self.adapt_slice(start.elapsed());
            }
            // A bounce that is half recorded may have connections left to test.
            if recorded == 0 && (depth >= max_bounces || counts.paths_in == 0) {
                return Ok(());
            }
            self.pace.check(context)?;
        }
    }

    /// Adds a batch to the film.
    pub(crate) fn accumulate(&mut self, context: &Context, batch: &Batch) -> Result<(), DeviceError> {
        let stage =
            Stage::new(&self.accumulate[self.pages.of(batch.first_pixel)], Size::Count(batch.pixel_count));
        self.submit(context, &[stage])?;
        self.accumulated += u64::from(batch.pixel_count) * u64::from(batch.sample_count);
        Ok(())
    }

    /// Submits stages on their own.
    pub(crate) fn submit(&mut self, context: &Context, stages: &[Stage]) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        self.record(&mut encoder, stages)?;
        context.queue.submit([encoder.finish()]);
        Ok(())
    }
}

/// A [`Size`] as the encoder wants it: an offset in bytes where the device decides.
pub(crate) enum Extent<'a> {
    Count(u32),
    Indirect(&'a wgpu::Buffer, u64),
}

pub(crate) fn record(
    encoder: &mut wgpu::CommandEncoder,
    timing: &mut Option<Timing>,
    kernel: &Bound,
    extent: Extent,
) {
    let timestamp_writes = timing.as_mut().and_then(|timing| timing.writes(&kernel.name));
    let mut pass = encoder
        .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&kernel.name), timestamp_writes });
    dispatch(&mut pass, kernel, extent);
}

fn dispatch(pass: &mut wgpu::ComputePass, kernel: &Bound, extent: Extent) {
    match extent {
        Extent::Count(invocations) => kernel.dispatch(pass, invocations),
        Extent::Indirect(arguments, offset) => kernel.dispatch_indirect(pass, arguments, offset),
    }
}
