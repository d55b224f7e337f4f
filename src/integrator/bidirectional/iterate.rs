//! One iteration: light paths into the cache and to the camera, then eye paths against the cache.

use super::records::Records;
use super::{Bidirectional, PILOT_SAMPLE, RESERVE};
use crate::device::layout::{Batch, Counts};
use crate::device::{Context, DeviceError};
use crate::integrator::Selector;
use crate::integrator::wavefront::{Bounces, Size, Stage, Wavefront, total};

/// Iterations that tell weights of records: docs/measurements.md.
const LEARNING_ITERATIONS: u32 = 4;

/// What light paths are traced for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Light {
    CameraAndCache,
    Cache,
}

impl Bidirectional {
    /// Traces `paths` light paths into the cache that all eye paths share, and nothing else; `batch` says of which sample.
    ///
    /// # Errors
    /// A lost device.
    pub fn fill_cache(
        &mut self,
        context: &Context,
        batch: &Batch,
        paths: u32,
    ) -> Result<Counts, DeviceError> {
        self.trace_light(context, &self.shared_batches(batch, paths), Light::Cache)
    }

    /// Traces `paths` light paths for the number of their vertices; the cache may have no room for them.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn count_light_vertices(
        &mut self,
        context: &Context,
        batch: &Batch,
        paths: u32,
    ) -> Result<Counts, DeviceError> {
        self.clear_light_vertices(context)?;
        for batch in self.shared_batches(batch, paths) {
            self.trace_light_batch(context, &batch, Light::Cache)?;
        }
        self.wavefront.counts(context)
    }

    fn clear_light_vertices(&mut self, context: &Context) -> Result<(), DeviceError> {
        self.wavefront.light_at_hand = None;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let offset = std::mem::offset_of!(Counts, light_vertices) as u64;
        encoder.clear_buffer(self.wavefront.buffers.get("counts")?, offset, Some(8));
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The light paths of an iteration, `paths` of them, as many at a time as the queues hold.
    fn shared_batches(&self, template: &Batch, paths: u32) -> Vec<Batch> {
        let most = self.wavefront.slice;
        (0..paths)
            .step_by(most as usize)
            .map(|first| Batch {
                light_path_count: paths,
                first_light_path: first,
                pixel_count: most.min(paths - first),
                sample_count: 1,
                ..*template
            })
            .collect()
    }

    /// Traces batches of light paths into the empty cache and sorts it.
    fn trace_light(
        &mut self,
        context: &Context,
        batches: &[Batch],
        purpose: Light,
    ) -> Result<Counts, DeviceError> {
        let before = self.wavefront.counts(context)?;
        let mut purpose = purpose;
        let counts = loop {
            self.clear_light_vertices(context)?;
            for batch in batches {
                self.trace_light_batch(context, batch, purpose)?;
            }
            let counts = self.wavefront.counts(context)?;
            let fits = self.capacity == 0 || counts.light_vertices <= self.capacity;
            if fits || self.must_halve(context, batches, &counts) {
                break counts;
            }
            self.wavefront.light_counts.cache_overflows += 1;
            // Once more with room for all; what went to the camera has arrived there.
            let needed = u64::from(counts.light_vertices);
            let with_reserve = (needed as f64 * RESERVE) as u64;
            self.make_cache(context, with_reserve.min(self.most_vertices(context)).max(needed))?;
            purpose = Light::Cache;
        };
        let totals = &mut self.wavefront.light_counts;
        totals.light_closest_hit += total(counts.closest_total) - total(before.closest_total);
        totals.light_occlusion += total(counts.shadow_total) - total(before.shadow_total);
        if !self.must_halve(context, batches, &counts) {
            self.wavefront.light_counts.light_vertices += u64::from(counts.light_vertices);
            self.wavefront.submit(context, &self.stages.sort)?;
        }
        Ok(counts)
    }

    /// No buffer holds the vertices of these light paths, but each belongs to the eye path of its pixel: half of the pixels
    /// may do.
    fn must_halve(&self, context: &Context, batches: &[Batch], counts: &Counts) -> bool {
        self.connects_own_path()
            && batches.iter().any(|batch| batch.pixel_count > 1)
            && u64::from(counts.light_vertices) > self.most_vertices(context)
    }

    pub(super) fn trace_light_batch(
        &mut self,
        context: &Context,
        batch: &Batch,
        purpose: Light,
    ) -> Result<(), DeviceError> {
        let Some(rays) = &self.stages.light_rays else { return Ok(()) };
        let bounce = match purpose {
            Light::CameraAndCache => &self.stages.light_bounce,
            Light::Cache => &self.stages.quiet_light_bounce,
        };
        let mut encoder = self.wavefront.start(context, batch, rays)?;
        if self.plan.selector.is_none() {
            self.wavefront.record(&mut encoder, &self.stages.camera_tests)?;
        }
        self.wavefront.bounce(context, encoder, bounce, batch.max_depth)
    }

    /// Each eye path has a light path of its own.
    fn connects_own_path(&self) -> bool {
        self.plan.selector == Some(Selector::OwnPath)
    }

    /// The stages of the bounces of eye paths.
    fn eye_bounces(&self, counts: &Counts) -> Bounces {
        let bounce = |depth: usize, parity: usize| {
            let wanted = match self.connects_own_path() {
                true => counts.longest_light_path.max(1),
                false => self.plan.connections.counts[depth],
            };
            // What the kernels have slots for, however many a model wants.
            let in_flight = self.set_connections().in_flight();
            let mut stages = vec![Stage::new(&self.wavefront.closest_hit[parity], Size::Paths)];
            if let Some(labels) = self.subspaces.as_ref().and_then(|subspaces| subspaces.labels.as_ref()) {
                stages.push(Stage::new(&labels[parity], Size::Paths));
            }
            stages.extend(self.records.iter().flat_map(|records| records.of_eye_vertices(parity)));
            if let Some(connect) = &self.stages.connect {
                for first in (0..wanted).step_by(in_flight as usize) {
                    let size = match self.wavefront.is_software() {
                        true => Size::Paths,
                        false => Size::Connections(in_flight.min(wanted - first)),
                    };
                    stages.push(Stage::new(&connect[parity], size));
                    stages.extend(self.wavefront.test_connections.iter().cloned());
                }
            }
            if let Some(shade) = &self.stages.eye_shade {
                stages.push(Stage::new(&shade[parity], Size::Paths));
            }
            stages.push(Stage::new(&self.wavefront.advance, Size::Count(1)));
            stages
        };
        Bounces { first: vec![bounce(0, 0), bounce(1, 1)], others: [bounce(2, 0), bounce(2, 1)] }
    }

    /// Traces eye paths against the cache.
    fn trace_eye(&mut self, context: &Context, batch: &Batch, counts: &Counts) -> Result<(), DeviceError> {
        let first_rays = self.wavefront.camera_rays.clone();
        let encoder = self.wavefront.start(context, batch, &first_rays)?;
        if self.stages.eye_shade.is_some() {
            let bounce = self.eye_bounces(counts);
            return self.wavefront.bounce(context, encoder, &bounce, batch.max_depth);
        }
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// A batch as the method's kernels want it.
    pub(super) fn complete(&self, batch: Batch, light_paths: u32) -> Batch {
        let to_camera = self.stages.light_rays.is_some() && self.plan.to_camera;
        let [first, second, deep, hit_scale] = self.density_scales;
        Batch {
            light_path_count: light_paths,
            connections: self.plan.connections.counts,
            hit_scale,
            density_scales: [first, second, deep],
            camera_paths: if to_camera { light_paths as f32 * self.plan.camera_share() } else { 0.0 },
            records: self.records.as_ref().map_or(0, |records| records.count),
            vertices_per_path: self.vertices_per_path.max(1.0) as f32,
            ..batch
        }
    }

    /// Traces the eye paths of a batch against `light_paths` light paths, for kernels that write down what they find.
    ///
    /// # Errors
    /// A lost device.
    pub fn find_paths(
        &mut self,
        context: &Context,
        batch: &Batch,
        light_paths: u32,
    ) -> Result<Counts, DeviceError> {
        let batch = self.complete(*batch, light_paths);
        let counts = self.trace_light(context, &self.shared_batches(&batch, light_paths), Light::Cache)?;
        self.trace_eye(context, &batch, &counts)?;
        Ok(counts)
    }

    /// The batches' samples, of the iteration whose first is `first`.
    pub(super) fn iterate(
        &mut self,
        context: &Context,
        batches: &[Batch],
        first: u32,
        light_paths: u32,
    ) -> Result<(), DeviceError> {
        let lit = self.stages.light_rays.is_some();
        self.prepare_records(context, &batches[0])?;
        let batches: Vec<Batch> = batches.iter().map(|&batch| self.complete(batch, light_paths)).collect();
        let mut purpose = Light::CameraAndCache;
        let mut counts = Counts::default();
        if lit && !self.connects_own_path() {
            counts = self.light_of(context, &Batch { first_sample: first, ..batches[0] }, light_paths)?;
        } else if lit && self.plan.to_camera {
            self.wavefront.clear_splats(context);
            if batches.len() > 1 {
                // All that light paths bring to the camera has to be there before the first pixel is summed.
                for batch in &batches {
                    self.trace_light(context, &[*batch], purpose)?;
                }
                purpose = Light::Cache;
            }
        }
        self.fill_tables(context, &batches[0], &counts)?;
        batches.iter().try_for_each(|batch| self.add_batch(context, batch, &counts, purpose))
    }

    /// The light paths of an iteration, by its first sample: those at hand if they are these.
    fn light_of(
        &mut self,
        context: &Context,
        template: &Batch,
        light_paths: u32,
    ) -> Result<Counts, DeviceError> {
        if let Some((first, counts)) = self.wavefront.light_at_hand
            && first == template.first_sample
        {
            return Ok(counts);
        }
        if self.plan.to_camera {
            self.wavefront.clear_splats(context);
        }
        let batches = self.shared_batches(template, light_paths);
        let counts = self.trace_light(context, &batches, Light::CameraAndCache)?;
        self.wavefront.light_at_hand = Some((template.first_sample, counts));
        Ok(counts)
    }

    /// Traces eye paths, after light paths of their own where they have them, and adds what they find to the film.
    fn add_batch(
        &mut self,
        context: &Context,
        batch: &Batch,
        shared: &Counts,
        purpose: Light,
    ) -> Result<(), DeviceError> {
        let counts = match self.stages.light_rays.is_some() && self.connects_own_path() {
            true => self.trace_light(context, &[*batch], purpose)?,
            false => *shared,
        };
        if !self.must_halve(context, &[*batch], &counts) {
            self.trace_eye(context, batch, &counts)?;
            if self.wavefront.eye_links_fit(context)? {
                return self.wavefront.accumulate(context, batch);
            }
        }
        // Half as many paths have twice the room each; one path has all that it can need. What goes to the camera has
        // arrived there.
        halves(batch).iter().try_for_each(|half| self.add_batch(context, half, shared, Light::Cache))
    }

    /// The records of a sample, where there are any.
    fn prepare_records(&mut self, context: &Context, template: &Batch) -> Result<(), DeviceError> {
        self.with_records(context, |records, wavefront| records.prepare(context, wavefront, template))
    }

    /// Their tables for the cache as it is.
    fn fill_tables(&mut self, context: &Context, batch: &Batch, counts: &Counts) -> Result<(), DeviceError> {
        self.with_records(context, |records, wavefront| {
            records.fill(context, wavefront, batch, counts.light_vertices)
        })
    }

    /// Works on the records, where there are any, and binds all that uses their buffers where these have grown.
    pub(super) fn with_records(
        &mut self,
        context: &Context,
        work: impl FnOnce(&mut Records, &mut Wavefront) -> Result<(), DeviceError>,
    ) -> Result<(), DeviceError> {
        let Some(records) = &mut self.records else { return Ok(()) };
        work(records, &mut self.wavefront)?;
        if records.take_grown() {
            self.bind(context)?;
        }
        Ok(())
    }

    /// Weights may know no more of records than iterations that are in no picture tell: what a sample's own light paths say
    /// would bias it, and what those of other samples say, the samples would depend on where a render begins.
    ///
    /// # Errors
    /// A lost device.
    pub(super) fn learn_from_records(&mut self, context: &Context) -> Result<(), DeviceError> {
        let seed = Some(self.wavefront.settings.view.seed);
        let Some(records) = &mut self.records else { return Ok(()) };
        if !self.plan.resamples() || self.learnt_by == seed {
            return Ok(());
        }
        records.forget();
        for iteration in 0..LEARNING_ITERATIONS {
            let template = self.wavefront.batches(PILOT_SAMPLE - 1 - iteration, 1)[0];
            self.prepare_records(context, &template)?;
            let batch = self.complete(template, self.light_paths);
            let counts =
                self.trace_light(context, &self.shared_batches(&batch, self.light_paths), Light::Cache)?;
            self.fill_tables(context, &batch, &counts)?;
            if let Some(records) = &mut self.records {
                records.learn(context, &self.wavefront, iteration, self.light_paths)?;
            }
        }
        self.learnt_by = seed;
        Ok(())
    }
}

/// A batch in two, each with half of the pixels.
fn halves(batch: &Batch) -> [Batch; 2] {
    let first = batch.pixel_count / 2;
    let (second_pixel, second) = (batch.first_pixel + first, batch.pixel_count - first);
    [
        Batch { pixel_count: first, ..*batch },
        Batch { first_pixel: second_pixel, pixel_count: second, ..*batch },
    ]
}
