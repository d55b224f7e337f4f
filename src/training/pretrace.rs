//! Learning as published: full paths by path tracing, with known densities, and light paths for Q.

use crate::device::layout::Batch;
use crate::device::{Context, DeviceError, Kernel};
use crate::subspace::{Connections, LightSample, TrainingSet};

use super::TrainingError;
use super::records::{Records, light_features, light_sample};
use super::task::{Clock, LIGHT_PATHS, TrainingProgress, TrainingResult, TrainingTask, training_batch};
use crate::integrator::bidirectional::{Bidirectional, Purpose};
use crate::integrator::wavefront::{Bounces, Size, Stage, Wavefront};
use crate::integrator::{LvcBpt, Method, Settings};

/// Camera paths traced at a time, and room for their records at first.
const PATHS_A_BATCH: u32 = 1 << 16;
const FIRST_RECORDS: u32 = PATHS_A_BATCH * 8;
/// Camera paths for each training path after which the search ends: light that is so hard to find teaches little.
const PATIENCE: u64 = 200;

/// Traces so many training paths and learns from them.
///
/// # Errors
/// As [`super::train`].
pub(super) fn train(
    task: &TrainingTask,
    paths: u32,
    mut go_on: impl FnMut(TrainingProgress) -> Result<(), TrainingError>,
) -> Result<TrainingResult, TrainingError> {
    let TrainingTask { context, scene, camera, settings, .. } = task;
    let connections = task.connections();
    let method = Method::LvcBpt(LvcBpt {
        light_paths: Some(PATHS_A_BATCH),
        connections: Connections { thinning: connections.thinning, ..Connections::even(1) },
        light_tracing: false,
    });
    let settings = Settings { method, ..*settings };
    let mut bidirectional =
        Bidirectional::new(context, scene.clone(), camera, settings, None, Purpose::LightVertices)?;
    let mut pretrace = Pretrace::new(context, &mut bidirectional.wavefront)?;
    // The driver compiles at the first dispatch: that is not learning's time.
    let tiny = bidirectional.wavefront.tiny_batch();
    let mut set = TrainingSet::new(settings.view.width, settings.view.height);
    pretrace.trace(context, &mut bidirectional.wavefront, &tiny, &connections, &mut set.clone())?;
    bidirectional.fill_cache(context, &tiny, 1)?;
    let mut clock = Clock::new();
    let mut camera_paths = 0;
    let wanted = paths as usize;
    // Samples of every pixel so far, and in the next round: as many as are likely to be enough.
    let (mut sample, mut samples) = (0, 1);
    let most_samples = (PATHS_A_BATCH / settings.view.region().pixels()).max(1);
    let patience = PATIENCE * wanted as u64;
    while set.paths().len() < wanted && camera_paths < patience {
        for batch in batches(&bidirectional.wavefront, sample, samples) {
            pretrace.trace(context, &mut bidirectional.wavefront, &batch, &connections, &mut set)?;
            camera_paths += u64::from(batch.pixel_count * batch.sample_count);
            let found = set.paths().len() as f64 / wanted as f64;
            go_on(TrainingProgress::TrainingPaths(
                found.max(camera_paths as f64 / patience as f64).min(1.0),
            ))?;
        }
        sample += samples;
        let found = set.paths().len();
        let missing = wanted.saturating_sub(found) as u64 * u64::from(sample);
        samples = missing.div_ceil(found.max(1) as u64).clamp(1, u64::from(most_samples)) as u32;
    }
    let lights = light_samples(context, &mut bidirectional, &mut go_on)?;
    go_on(TrainingProgress::Fitting)?;
    let input = task.input(&set, &lights, LIGHT_PATHS);
    let model = clock.learn(|| task.fit(&input, None))?;
    Ok(clock.result(model, camera_paths))
}

/// Samples of every pixel, all of small pictures at a time.
fn batches(wavefront: &Wavefront, sample: u32, samples: u32) -> Vec<Batch> {
    let pixels = wavefront.settings.view.region().pixels();
    (0..pixels)
        .step_by(PATHS_A_BATCH as usize)
        .map(|first_pixel| Batch {
            first_pixel,
            pixel_count: PATHS_A_BATCH.min(pixels - first_pixel),
            sample_count: samples,
            ..training_batch(wavefront, sample)
        })
        .collect()
}

/// The kernels of pre-tracing.
struct Pretrace {
    shade: Kernel,
    bounces: Bounces,
    records: Records,
}

impl Pretrace {
    fn new(context: &Context, wavefront: &mut Wavefront) -> Result<Self, DeviceError> {
        let records = Records::new(context, wavefront, FIRST_RECORDS)?;
        let shade = wavefront.compile(context, "training_shade", &[])?;
        let mut pretrace = Self { shade, bounces: Bounces::default(), records };
        pretrace.bind(context, wavefront)?;
        Ok(pretrace)
    }

    fn bind(&mut self, context: &Context, wavefront: &mut Wavefront) -> Result<(), DeviceError> {
        let shade = wavefront.bind_pair(context, &self.shade)?;
        wavefront.bind_tests(context)?;
        let bounce = |parity: usize| {
            let mut bounce = vec![
                Stage::new(&wavefront.closest_hit[parity], Size::Paths),
                Stage::new(&shade[parity], Size::Paths),
            ];
            bounce.extend(wavefront.test_connections.iter().cloned());
            bounce.push(Stage::new(&wavefront.advance, Size::Count(1)));
            bounce
        };
        self.bounces = [bounce(0), bounce(1)].into();
        Ok(())
    }

    /// Traces a batch and adds the paths that found light.
    fn trace(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        batch: &Batch,
        connections: &Connections,
        set: &mut TrainingSet,
    ) -> Result<(), DeviceError> {
        loop {
            self.records.clear(context, wavefront)?;
            let first_rays = wavefront.camera_rays.clone();
            let encoder = wavefront.start(context, batch, &first_rays)?;
            wavefront.bounce(context, encoder, &self.bounces, batch.max_depth)?;
            let Some(needed) = self.records.take(context, wavefront, batch, &[], connections, set)? else {
                return Ok(());
            };
            // Once more with room for all.
            self.records = Records::new(context, wavefront, needed)?;
            self.bind(context, wavefront)?;
        }
    }
}

/// Light vertices for Q.
fn light_samples(
    context: &Context,
    light: &mut Bidirectional,
    mut go_on: impl FnMut(TrainingProgress) -> Result<(), TrainingError>,
) -> Result<Vec<LightSample>, TrainingError> {
    let mut samples = Vec::new();
    let kernel = light.wavefront.compile(context, "light_samples", &[])?;
    for (pass, first) in (0..LIGHT_PATHS).step_by(PATHS_A_BATCH as usize).enumerate() {
        let paths = PATHS_A_BATCH.min(LIGHT_PATHS - first);
        let batch = training_batch(&light.wavefront, pass as u32);
        let counts = light.fill_cache(context, &batch, paths)?;
        let features = light_features(context, &mut light.wavefront, &kernel, counts.light_vertices)?;
        samples.extend(features.iter().map(light_sample));
        go_on(TrainingProgress::LightPaths(f64::from(first + paths) / f64::from(LIGHT_PATHS)))?;
    }
    Ok(samples)
}
