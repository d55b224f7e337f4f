//! The queues between kernels, and the loop over the surfaces of a batch of paths: trace, shade, advance, connect.

use std::collections::BTreeMap;
use std::time::Duration;

use crate::device::layout::{Batch, Camera, Counts, FilmPixel, FirstHitPixel, Hit, PathRay, ShadowRay};
use crate::device::scene::DeviceScene;
use crate::device::timing::Timing;
use crate::device::{Bound, BufferTable, Context, Kernel};
use crate::error::DeviceError;
use crate::math::rng::seed_key;

use super::Settings;

/// Surfaces between two looks at how many paths are left.
const BOUNCES_A_SUBMISSION: u32 = 8;
/// Depth is stored in 16 bits.
const LARGEST_DEPTH: u32 = 0xffff;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Region {
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }
}

/// Rays traced so far, exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct RayCounts {
    pub closest_hit: u64,
    pub occlusion: u64,
}

/// The stages of one bounce with their buffers; paths change places between two buffers, hence two of each.
struct Bounce {
    closest_hit: Bound,
    shade: Bound,
}

/// Kernels and queues of a path-space wavefront.
pub struct Wavefront {
    pub buffers: BufferTable,
    settings: Settings,
    capacity: u32,
    camera_rays: Bound,
    bounces: [Bounce; 2],
    advance: Bound,
    occlusion: Option<Bound>,
    accumulate: Bound,
    first_hit: Option<Bound>,
    pub timing: Option<Timing>,
    pub compile_time: Duration,
}

impl Wavefront {
    /// Compiles the kernels and makes queues for `capacity` paths at a time.
    ///
    /// # Errors
    /// A kernel that does not compile, a queue that does not fit.
    pub fn new(
        context: &Context,
        scene: &mut DeviceScene,
        camera: &Camera,
        settings: Settings,
        capacity: u32,
        shade: &str,
    ) -> Result<Self, DeviceError> {
        let features = scene.kernel_features();
        let mut compile_time = Duration::ZERO;
        let mut compile = |name: &str, any_hit: bool| {
            let mut features = features.clone();
            if any_hit {
                features.insert("any_hit");
            }
            let kernel = Kernel::new(context, name, &features, &scene.constants)?;
            compile_time += kernel.compile_time;
            Ok::<Kernel, DeviceError>(kernel)
        };
        let camera_rays = compile("camera_rays", false)?;
        let closest_hit = compile("closest_hit", false)?;
        let shade = compile(shade, false)?;
        let advance = compile("queue_advance", false)?;
        let occlusion = if features.contains("lights") { Some(compile("occlusion", true)?) } else { None };
        let accumulate = compile("film_accumulate", false)?;
        let first_hit = if settings.first_hit { Some(compile("first_hit", false)?) } else { None };

        let mut buffers = std::mem::take(&mut scene.buffers);
        let bytes = |size: usize| u64::from(capacity) * size as u64;
        let path_buffers = ["paths a", "paths b"]
            .map(|name| buffers.create(context, name, bytes(size_of::<PathRay>())).cloned());
        let [path_a, path_b] = path_buffers;
        let (path_a, path_b) = (path_a?, path_b?);
        buffers.create(context, "hits", bytes(size_of::<Hit>()))?;
        buffers.create(context, "radiance", bytes(16))?;
        if occlusion.is_some() {
            buffers.create(context, "shadow_rays", bytes(size_of::<ShadowRay>()))?;
        }
        buffers.create(context, "counts", size_of::<Counts>() as u64)?;
        buffers.create_with(
            context,
            "arguments",
            32,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT,
        )?;
        let pixels = u64::from(settings.region.pixels());
        buffers.create(context, "film", pixels * size_of::<FilmPixel>() as u64)?;
        if first_hit.is_some() {
            buffers.create(context, "first_hits", pixels * size_of::<FirstHitPixel>() as u64)?;
        }
        buffers.upload_uniform(context, "camera", &[*camera])?;
        buffers.upload_uniform(context, "batch", &[Batch::default()])?;

        buffers.share("paths_in", path_a.clone());
        buffers.share("paths_out", path_b.clone());
        let camera_rays = camera_rays.bind(context, &buffers)?;
        let even = Bounce {
            closest_hit: closest_hit.bind(context, &buffers)?,
            shade: shade.bind(context, &buffers)?,
        };
        let advance = advance.bind(context, &buffers)?;
        let occlusion = occlusion.map(|kernel| kernel.bind(context, &buffers)).transpose()?;
        let accumulate = accumulate.bind(context, &buffers)?;
        let first_hit = first_hit.map(|kernel| kernel.bind(context, &buffers)).transpose()?;
        buffers.share("paths_in", path_b);
        buffers.share("paths_out", path_a);
        let odd = Bounce {
            closest_hit: closest_hit.bind(context, &buffers)?,
            shade: shade.bind(context, &buffers)?,
        };
        buffers.unshare("paths_in");
        buffers.unshare("paths_out");
        Ok(Self {
            buffers,
            settings,
            capacity,
            camera_rays,
            bounces: [even, odd],
            advance,
            occlusion,
            accumulate,
            first_hit,
            timing: if settings.timing { Timing::new(context) } else { None },
            compile_time,
        })
    }

    /// Traces samples `first_sample .. first_sample + samples` of every pixel into the film on the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn render(&mut self, context: &Context, first_sample: u32, samples: u32) -> Result<(), DeviceError> {
        for batch in self.batches(first_sample, samples) {
            self.trace(context, &batch)?;
        }
        Ok(())
    }

    /// Sums what the camera sees first over `samples` samples of every pixel, and takes the sums.
    ///
    /// # Errors
    /// A lost device.
    pub fn first_hits(&mut self, context: &Context, samples: u32) -> Result<Vec<FirstHitPixel>, DeviceError> {
        for batch in self.batches(0, samples) {
            let paths = batch.pixel_count * batch.sample_count;
            let mut encoder = self.start(context, &batch)?;
            record(&mut encoder, &mut self.timing, &self.bounces[0].closest_hit, Size::Count(paths));
            if let Some(first_hit) = &self.first_hit {
                record(&mut encoder, &mut self.timing, first_hit, Size::Count(batch.pixel_count));
            }
            context.queue.submit([encoder.finish()]);
        }
        let bytes = u64::from(self.settings.region.pixels()) * size_of::<FirstHitPixel>() as u64;
        Ok(bytemuck::pod_collect_to_vec(&self.buffers.read(context, "first_hits", bytes)?))
    }

    /// Runs every kernel once, on one pixel, and forgets the result: drivers compile at the first dispatch.
    ///
    /// # Errors
    /// A lost device.
    pub fn warm_up(&mut self, context: &Context) -> Result<(), DeviceError> {
        let mut batch = self.batches(0, 1)[0];
        (batch.pixel_count, batch.max_depth) = (1, 2);
        self.trace(context, &batch)?;
        self.take_film(context)?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(self.buffers.get("counts")?, 0, None);
        context.queue.submit([encoder.finish()]);
        if let Some(timing) = &mut self.timing {
            timing.totals.clear();
        }
        context.wait()
    }

    /// Cuts samples into batches that the queues hold: whole rounds over small pictures, parts of large ones.
    fn batches(&self, first_sample: u32, samples: u32) -> Vec<Batch> {
        let pixels = self.settings.region.pixels();
        let pixels_a_batch = pixels.min(self.capacity);
        let samples_a_batch = (self.capacity / pixels).max(1);
        let template = Batch {
            width: self.settings.width,
            height: self.settings.height,
            crop_x: self.settings.region.x,
            crop_y: self.settings.region.y,
            crop_width: self.settings.region.width,
            seed: seed_key(self.settings.seed),
            max_depth: self.settings.max_depth.unwrap_or(LARGEST_DEPTH).min(LARGEST_DEPTH),
            ..Batch::default()
        };
        let mut batches = Vec::new();
        for sample in (0..samples).step_by(samples_a_batch as usize) {
            for pixel in (0..pixels).step_by(pixels_a_batch as usize) {
                batches.push(Batch {
                    first_pixel: pixel,
                    pixel_count: pixels_a_batch.min(pixels - pixel),
                    first_sample: first_sample + sample,
                    sample_count: samples_a_batch.min(samples - sample),
                    ..template
                });
            }
        }
        batches
    }

    /// Fills the queue with the camera rays of a batch.
    fn start(&mut self, context: &Context, batch: &Batch) -> Result<wgpu::CommandEncoder, DeviceError> {
        self.buffers.write(context, "batch", bytemuck::bytes_of(batch))?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let paths = batch.pixel_count * batch.sample_count;
        record(&mut encoder, &mut self.timing, &self.camera_rays, Size::Count(paths));
        record(&mut encoder, &mut self.timing, &self.advance, Size::Count(1));
        Ok(encoder)
    }

    fn trace(&mut self, context: &Context, batch: &Batch) -> Result<(), DeviceError> {
        let mut encoder = self.start(context, batch)?;
        let mut depth = 0;
        loop {
            for _ in 0..BOUNCES_A_SUBMISSION.min(batch.max_depth - depth) {
                self.bounce(&mut encoder, depth as usize % 2)?;
                depth += 1;
            }
            context.queue.submit([encoder.finish()]);
            encoder = context.device.create_command_encoder(&Default::default());
            if let Some(timing) = &mut self.timing {
                timing.collect(context)?;
            }
            if depth >= batch.max_depth || self.counts(context)?.paths_in == 0 {
                break;
            }
        }
        record(&mut encoder, &mut self.timing, &self.accumulate, Size::Count(batch.pixel_count));
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn bounce(&mut self, encoder: &mut wgpu::CommandEncoder, parity: usize) -> Result<(), DeviceError> {
        let arguments = self.buffers.get("arguments")?;
        let stages = &self.bounces[parity];
        record(encoder, &mut self.timing, &stages.closest_hit, Size::Indirect(arguments, 0));
        record(encoder, &mut self.timing, &stages.shade, Size::Indirect(arguments, 0));
        record(encoder, &mut self.timing, &self.advance, Size::Count(1));
        if let Some(occlusion) = &self.occlusion {
            record(encoder, &mut self.timing, occlusion, Size::Indirect(arguments, 16));
        }
        Ok(())
    }

    fn counts(&self, context: &Context) -> Result<Counts, DeviceError> {
        let bytes = self.buffers.read(context, "counts", size_of::<Counts>() as u64)?;
        Ok(bytemuck::pod_read_unaligned(&bytes))
    }

    /// Rays traced so far; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn ray_counts(&self, context: &Context) -> Result<RayCounts, DeviceError> {
        let counts = self.counts(context)?;
        let total = |words: [u32; 2]| u64::from(words[0]) | u64::from(words[1]) << 32;
        Ok(RayCounts { closest_hit: total(counts.closest_total), occlusion: total(counts.shadow_total) })
    }

    /// The film's sums since they were last taken; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn film(&self, context: &Context) -> Result<Vec<FilmPixel>, DeviceError> {
        let bytes = u64::from(self.settings.region.pixels()) * size_of::<FilmPixel>() as u64;
        Ok(bytemuck::pod_collect_to_vec(&self.buffers.read(context, "film", bytes)?))
    }

    /// Takes the film's sums and sets them to zero; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn take_film(&self, context: &Context) -> Result<Vec<FilmPixel>, DeviceError> {
        let film = self.film(context)?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(self.buffers.get("film")?, 0, None);
        context.queue.submit([encoder.finish()]);
        Ok(film)
    }

    /// Seconds and dispatches by kernel, where timed.
    pub fn kernel_times(&self) -> BTreeMap<String, (f64, u64)> {
        self.timing.as_ref().map(|timing| timing.totals.clone()).unwrap_or_default()
    }
}

/// How large a dispatch is: known here, or read by the device at an offset in bytes.
enum Size<'a> {
    Count(u32),
    Indirect(&'a wgpu::Buffer, u64),
}

fn record(encoder: &mut wgpu::CommandEncoder, timing: &mut Option<Timing>, kernel: &Bound, size: Size) {
    let timestamp_writes = timing.as_mut().and_then(|timing| timing.writes(&kernel.name));
    let mut pass = encoder
        .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&kernel.name), timestamp_writes });
    match size {
        Size::Count(invocations) => kernel.dispatch(&mut pass, invocations),
        Size::Indirect(arguments, offset) => kernel.dispatch_indirect(&mut pass, arguments, offset),
    }
}
