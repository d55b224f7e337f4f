//! Pre-tracing: eye paths with known densities for Gamma, light paths for Q, and the training with them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};

use crate::device::layout::{
    Batch, Camera, LIGHT_ENVIRONMENT, LIGHT_TRIANGLE, Light, LightFeature, PunctualLight, TrainingEnd,
    TrainingVertex, Triangle,
};
use crate::device::scene::DeviceScene;
use crate::device::{Context, Kernel};
use crate::error::{DeviceError, RenderError};
use crate::math::rng::seed_key;
use crate::subspace::{
    self, Feature, LightEnd, LightSample, LightSourceInfo, Model, SourceKind, TrainingNode, TrainingPath,
    TrainingSet,
};

use super::bidirectional::Bidirectional;
use super::wavefront::{Bounce, Size, Stage, Wavefront};
use super::{Method, Settings};

/// Camera paths traced at a time, and room for their records at first; it grows where that is too little.
const PATHS_A_BATCH: u32 = 1 << 16;
const FIRST_RECORDS: u32 = PATHS_A_BATCH * 8;
/// Light paths for Q: more do not lower the error (`prototype.md`, 5).
const LIGHT_PATHS: u32 = 200_000;
/// Camera paths for each training path after which the search ends: light that is so hard to find teaches little.
const PATIENCE: u64 = 200;
/// Vertices of the longest training path.
const LONGEST_PATH: u32 = 64;
/// Sets the numbers of training paths apart from those of every render.
const TRAINING_STREAM: u32 = 0x2545_f491;

/// What to learn from, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    /// Full paths.
    pub paths: u32,
    pub settings: subspace::Settings,
}

/// Training paths where no number is asked for.
pub const DEFAULT_TRAINING_PATHS: u32 = 200_000;

impl Default for Training {
    fn default() -> Self {
        Self { paths: DEFAULT_TRAINING_PATHS, settings: subspace::Settings::default() }
    }
}

/// How far learning is; where a share is known, of what is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Learning {
    /// Full paths for Gamma.
    TrainingPaths(f64),
    /// Light paths for Q.
    LightPaths(f64),
    /// Trees and Gamma, on the host: asked before, not meanwhile.
    Fitting,
}

/// A trained model with what it took.
#[derive(Clone)]
pub struct Trained {
    pub model: Arc<Model>,
    /// Of tracing on the device, and of the rest.
    pub tracing: Duration,
    pub learning: Duration,
    /// Camera paths that it took to find the training paths.
    pub camera_paths: u64,
}

/// Traces training paths of the picture and learns from them, until `interrupted` says so; it is asked after every
/// batch.
///
/// # Errors
/// A lost device, a scene without light to connect to, [`RenderError::Interrupted`].
pub fn train(
    context: &Context,
    scene: &DeviceScene,
    camera: &Camera,
    mut settings: Settings,
    scene_hash: u64,
    training: &Training,
    mut interrupted: impl FnMut(Learning) -> bool,
) -> Result<Trained, RenderError> {
    settings.method =
        Method::LvcBpt { light_paths: Some(PATHS_A_BATCH), connections: 1, light_tracing: false };
    settings.strategy = None;
    settings.timing = false;
    settings.first_hit = false;
    let mut bidirectional = Bidirectional::new(context, scene.clone(), camera, settings, None)?;
    let start = Instant::now();
    let sources = sources(context, scene)?;
    let mut pretrace = Pretrace::new(context, &mut bidirectional.wavefront)?;
    let mut set = TrainingSet::new(settings.width, settings.height);
    let mut camera_paths = 0;
    let wanted = training.paths as usize;
    // Samples of every pixel so far, and in the next round: as many as are likely to be enough.
    let (mut sample, mut samples) = (0, 1);
    let most_samples = (PATHS_A_BATCH / settings.region.pixels()).max(1);
    let patience = PATIENCE * wanted as u64;
    let mut go_on = |step: Learning| if interrupted(step) { Err(RenderError::Interrupted) } else { Ok(()) };
    while set.paths().len() < wanted && camera_paths < patience {
        for batch in batches(&bidirectional.wavefront, sample, samples) {
            pretrace.trace(context, &mut bidirectional.wavefront, &batch, &mut set)?;
            camera_paths += u64::from(batch.pixel_count * batch.sample_count);
            let found = set.paths().len() as f64 / wanted as f64;
            go_on(Learning::TrainingPaths(found.max(camera_paths as f64 / patience as f64).min(1.0)))?;
        }
        sample += samples;
        let found = set.paths().len();
        let missing = wanted.saturating_sub(found) as u64 * u64::from(sample);
        samples = missing.div_ceil(found.max(1) as u64).clamp(1, u64::from(most_samples)) as u32;
    }
    let lights = light_samples(context, &mut bidirectional, &mut go_on)?;
    go_on(Learning::Fitting)?;
    let tracing = start.elapsed();
    let settings = training.settings.clone();
    let model = subspace::train(&set, &lights, u64::from(LIGHT_PATHS), &sources, scene_hash, settings)
        .map_err(DeviceError::from)?;
    Ok(Trained { model: Arc::new(model), tracing, learning: start.elapsed() - tracing, camera_paths })
}

/// Samples of every pixel, all of small pictures at a time.
fn batches(wavefront: &Wavefront, sample: u32, samples: u32) -> Vec<Batch> {
    let template = wavefront.batches(sample, 1)[0];
    let pixels = wavefront.settings.region.pixels();
    (0..pixels)
        .step_by(PATHS_A_BATCH as usize)
        .map(|first_pixel| Batch {
            first_pixel,
            pixel_count: PATHS_A_BATCH.min(pixels - first_pixel),
            sample_count: samples,
            seed: seed_key(wavefront.settings.seed).wrapping_add(TRAINING_STREAM),
            max_depth: template.max_depth.min(LONGEST_PATH),
            ..template
        })
        .collect()
}

/// The kernels of pre-tracing.
struct Pretrace {
    shade: Kernel,
    occlusion: Kernel,
    bounce: Bounce,
    /// Room for so many.
    records: u32,
}

impl Pretrace {
    fn new(context: &Context, wavefront: &mut Wavefront) -> Result<Self, DeviceError> {
        wavefront.buffers.create(context, "training_counts", 8)?;
        let shade = wavefront.compile(context, "training_shade", &[])?;
        let occlusion = wavefront.compile(context, "occlusion", &["any_hit"])?;
        let mut pretrace = Self { shade, occlusion, bounce: [Vec::new(), Vec::new()], records: 0 };
        pretrace.make_room(context, wavefront, FIRST_RECORDS)?;
        Ok(pretrace)
    }

    /// Makes buffers for `records` of each kind and binds what writes them.
    fn make_room(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        records: u32,
    ) -> Result<(), DeviceError> {
        for (name, size) in [
            ("training_vertices", size_of::<TrainingVertex>()),
            ("training_ends", size_of::<TrainingEnd>()),
            // The cells of connections are those of ends here.
            ("radiance", 16),
        ] {
            wavefront.buffers.create(context, name, u64::from(records) * size as u64)?;
        }
        let shade = wavefront.bind_pair(context, &self.shade)?;
        let occlusion = self.occlusion.bind(context, &wavefront.buffers)?;
        self.bounce = [0, 1].map(|parity: usize| {
            vec![
                Stage::new(&wavefront.closest_hit[parity], Size::Paths),
                Stage::new(&shade[parity], Size::Paths),
                wavefront.test_connections[0].clone(),
                Stage::new(&occlusion, Size::Shadow),
                Stage::new(&wavefront.advance, Size::Count(1)),
            ]
        });
        self.records = records;
        Ok(())
    }

    /// Traces a batch and adds the paths that found light.
    fn trace(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        batch: &Batch,
        set: &mut TrainingSet,
    ) -> Result<(), DeviceError> {
        let [vertex_count, end_count] = loop {
            let mut encoder = context.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(wavefront.buffers.get("training_counts")?, 0, None);
            context.queue.submit([encoder.finish()]);
            let first_rays = wavefront.camera_rays.clone();
            let encoder = wavefront.start(context, batch, &first_rays)?;
            wavefront.bounce(context, encoder, &self.bounce, batch.max_depth)?;
            let counts: [u32; 2] =
                bytemuck::pod_read_unaligned(&wavefront.buffers.read(context, "training_counts", 8)?);
            let needed = counts[0].max(counts[1]);
            if needed <= self.records {
                break counts;
            }
            // Once more with room for all.
            self.make_room(context, wavefront, needed.saturating_add(needed / 4))?;
        };
        let vertices: Vec<TrainingVertex> = read(context, wavefront, "training_vertices", vertex_count)?;
        let ends: Vec<TrainingEnd> = read(context, wavefront, "training_ends", end_count)?;
        let visible: Vec<[f32; 4]> = read(context, wavefront, "radiance", end_count)?;
        gather(batch, &vertices, ends, &visible, set);
        Ok(())
    }
}

fn read<T: bytemuck::Pod>(
    context: &Context,
    wavefront: &Wavefront,
    name: &str,
    count: u32,
) -> Result<Vec<T>, DeviceError> {
    let bytes = wavefront.buffers.read(context, name, u64::from(count) * size_of::<T>() as u64)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// From records, which come in any order, to paths in the order of their pixels.
fn gather(
    batch: &Batch,
    records: &[TrainingVertex],
    ends: Vec<TrainingEnd>,
    visible: &[[f32; 4]],
    set: &mut TrainingSet,
) {
    // The vertices of a path have all depths from 0 on, each once.
    let mut first_of = vec![0; (batch.pixel_count * batch.sample_count) as usize + 1];
    for vertex in records {
        first_of[vertex.path as usize + 1] += 1;
    }
    for path in 1..first_of.len() {
        first_of[path] += first_of[path - 1];
    }
    let mut vertices = vec![TrainingVertex::default(); records.len()];
    for vertex in records {
        vertices[first_of[vertex.path as usize] + (vertex.depth_delta & 0xffff) as usize] = *vertex;
    }
    let mut ends: Vec<TrainingEnd> = ends
        .into_iter()
        .zip(visible)
        .filter(|(end, visible)| end.depth_sampled >> 16 == 0 || visible[0] > 0.0)
        .map(|(end, _)| end)
        .collect();
    ends.sort_unstable_by_key(|end| (end.path, end.depth_sampled & 0xffff, end.depth_sampled >> 16));
    let mut nodes = Vec::new();
    for end in &ends {
        let first = first_of[end.path as usize];
        let last = first + (end.depth_sampled & 0xffff) as usize;
        nodes.clear();
        connections(&vertices[first..=last], end, &mut nodes);
        let pixel = batch.first_pixel + end.path % batch.pixel_count;
        let [x, y] = [batch.crop_x + pixel % batch.crop_width, batch.crop_y + pixel / batch.crop_width];
        let path = TrainingPath { tile: set.tile_of(x, y), contribution: end.contribution, p0: end.p0 };
        set.push_path(path, &nodes);
    }
}

/// The connections that could have made the path x_1 .. x_{n-1}, x_n: `algorithm.md` 2.1, with all densities over that
/// of the path.
fn connections(vertices: &[TrainingVertex], end: &TrainingEnd, nodes: &mut Vec<TrainingNode>) {
    let color = |c: [f32; 3]| Vec3::from(c).as_dvec3();
    let is_delta = |vertex: &TrainingVertex| vertex.depth_delta >> 16 != 0;
    let sampled = end.depth_sampled >> 16 != 0;
    // f_y of the light sub-path that ends at x_{j+1}, times PE(j) over p.
    let mut arriving = color(end.emitted);
    for (j, vertex) in vertices.iter().enumerate().rev() {
        let next = vertices.get(j + 1);
        if !is_delta(vertex) && !next.is_some_and(is_delta) {
            let light = match next {
                Some(next) => LightEnd::Surface(Feature {
                    direction: towards_light(vertices, j + 1, end),
                    ..feature(next)
                }),
                None => LightEnd::Source { light: end.light, at: end.at },
            };
            nodes.push(TrainingNode { eye: feature(vertex), light, mass: arriving.element_sum() as f32 });
        }
        // x_{j+1} scatters the light on to x_j.
        let (f, geometry) = match next {
            None => (DVec3::ONE, end.geometry),
            Some(next) if j + 2 == vertices.len() && sampled => (color(end.f), next.geometry),
            Some(next) => (color(next.f), next.geometry),
        };
        arriving *= f * f64::from(geometry) / f64::from(vertex.pdf_area);
    }
}

fn feature(vertex: &TrainingVertex) -> Feature {
    Feature {
        position: vertex.position.into(),
        normal: vertex.normal.into(),
        direction: vertex.direction.into(),
    }
}

/// Unit direction from a vertex to the one after it, as a light sub-path that ends at it looks back.
fn towards_light(vertices: &[TrainingVertex], index: usize, end: &TrainingEnd) -> Vec3 {
    vertices.get(index + 1).map_or(end.direction.into(), |next| {
        (Vec3::from(next.position) - Vec3::from(vertices[index].position)).normalize_or_zero()
    })
}

/// Light vertices for Q.
fn light_samples(
    context: &Context,
    light: &mut Bidirectional,
    mut go_on: impl FnMut(Learning) -> Result<(), RenderError>,
) -> Result<Vec<LightSample>, RenderError> {
    let mut samples = Vec::new();
    let kernel = light.wavefront.compile(context, "light_samples", &[])?;
    for (pass, first) in (0..LIGHT_PATHS).step_by(PATHS_A_BATCH as usize).enumerate() {
        let paths = PATHS_A_BATCH.min(LIGHT_PATHS - first);
        let counts = light.fill_cache(context, u32::MAX - 1 - pass as u32, paths)?;
        let vertices = counts.light_vertices;
        let bytes = u64::from(vertices) * size_of::<LightFeature>() as u64;
        light.wavefront.buffers.create(context, "light_features", bytes)?;
        let bound = kernel.bind(context, &light.wavefront.buffers)?;
        light.wavefront.submit(context, &[Stage::new(&bound, Size::Count(vertices))])?;
        let features: Vec<LightFeature> = read(context, &light.wavefront, "light_features", vertices)?;
        samples.extend(features.iter().map(|feature| LightSample {
            end: match feature.light {
                0 => LightEnd::Surface(Feature {
                    position: feature.position.into(),
                    normal: feature.normal.into(),
                    direction: feature.direction.into(),
                }),
                light => {
                    LightEnd::Source { light: light - 1, at: [feature.direction[0], feature.direction[1]] }
                }
            },
            weight: feature.weight,
        }));
        go_on(Learning::LightPaths(f64::from(first + paths) / f64::from(LIGHT_PATHS)))?;
    }
    Ok(samples)
}

/// The lights as the grouping of their points sees them.
fn sources(context: &Context, scene: &DeviceScene) -> Result<Vec<LightSourceInfo>, DeviceError> {
    let buffers = &scene.buffers;
    let count = scene.light_count as u64;
    if count == 0 {
        return Ok(Vec::new());
    }
    let lights: Vec<Light> =
        bytemuck::pod_collect_to_vec(&buffers.read(context, "lights", count * size_of::<Light>() as u64)?);
    let whole = |name: &str| buffers.get(name).and_then(|buffer| buffers.read(context, name, buffer.size()));
    let triangles: Vec<Triangle> = bytemuck::pod_collect_to_vec(&whole("triangles")?);
    let punctual: Vec<PunctualLight> = match scene.features.punctual_lights {
        true => bytemuck::pod_collect_to_vec(&whole("punctual_lights")?),
        false => Vec::new(),
    };
    let source = |light: &Light| match light.kind {
        LIGHT_TRIANGLE => {
            let triangle = &triangles[light.index as usize];
            let [a, b, c] = [triangle.v0, triangle.v1, triangle.v2].map(Vec3::from);
            let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let flip = if triangle.material_flags & crate::device::layout::TRIANGLE_FLIPPED != 0 {
                -1.0
            } else {
                1.0
            };
            SourceKind::Triangle {
                position: (a + b + c) / 3.0,
                normal: (flip * cross.normalize_or_zero()).as_vec3(),
                area: 0.5 * cross.length() as f32,
            }
        }
        LIGHT_ENVIRONMENT => SourceKind::Environment,
        _ => {
            let light = &punctual[light.index as usize];
            SourceKind::Punctual { position: light.position.into(), direction: light.direction.into() }
        }
    };
    Ok(lights
        .iter()
        .map(|light| LightSourceInfo { kind: source(light), power: f64::from(light.pdf_select) })
        .collect())
}
