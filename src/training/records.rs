//! What kernels that learn write down on the device, and the training paths in it.

use glam::Vec3;

use crate::device::layout::{Batch, LightFeature, THINNING_UNITS, TrainingEnd, TrainingVertex};
use crate::device::{Context, DeviceError, Kernel};
use crate::subspace::{Connections, Feature, LightEnd, LightSample, TrainingNode, TrainingPath, TrainingSet};

use super::first_connections::PathLight;
use crate::integrator::wavefront::{Size, Stage, Wavefront};

/// In the place of a light vertex: the path ends at a point on a light that is not in the cache.
const NO_LIGHT_VERTEX: u32 = u32::MAX;

/// Room for records, which grows where it is too little.
pub(super) struct Records {
    capacity: u32,
    /// Of those that were taken last, the light of each path, and how many first vertices connect.
    pub light: Vec<PathLight>,
    pub connecting: f64,
}

impl Records {
    /// Makes buffers for `capacity` records of each kind. What writes them has to be bound again.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub fn new(context: &Context, wavefront: &mut Wavefront, capacity: u32) -> Result<Self, DeviceError> {
        wavefront.make_room_for_records(context, capacity)?;
        Ok(Self { capacity, light: Vec::new(), connecting: 0.0 })
    }

    /// Forgets what was written.
    pub fn clear(&self, context: &Context, wavefront: &Wavefront) -> Result<(), DeviceError> {
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(wavefront.buffers.get("training_counts")?, 0, None);
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Adds the paths that found light to the set; `lights`: the light cache, where they end in it; `connections`: of the
    /// render to come. How much room would have been needed, where not all fitted: then nothing is added.
    pub fn take(
        &mut self,
        context: &Context,
        wavefront: &Wavefront,
        batch: &Batch,
        lights: &[LightFeature],
        connections: &Connections,
        set: &mut TrainingSet,
    ) -> Result<Option<u32>, DeviceError> {
        let counts: [u32; 2] =
            bytemuck::pod_read_unaligned(&wavefront.buffers.read(context, "training_counts", 8)?);
        let needed = counts[0].max(counts[1]);
        if needed > self.capacity {
            return Ok(Some(needed.saturating_add(needed / 4)));
        }
        let vertices: Vec<TrainingVertex> =
            wavefront.buffers.read_elements(context, "training_vertices", counts[0])?;
        let ends: Vec<TrainingEnd> = wavefront.buffers.read_elements(context, "training_ends", counts[1])?;
        let visible: Vec<[f32; 4]> = wavefront.buffers.read_elements(context, "radiance", counts[1])?;
        self.light = gather(batch, &vertices, ends, &visible, lights, connections, set);
        let first = |vertex: &&TrainingVertex| vertex.depth_thinning & 0xffff == 0;
        self.connecting = vertices.iter().filter(first).map(thinning).sum();
        Ok(None)
    }
}

/// Reads the sorted light cache.
///
/// # Errors
/// A lost device.
pub(super) fn light_features(
    context: &Context,
    wavefront: &mut Wavefront,
    kernel: &Kernel,
    vertices: u32,
) -> Result<Vec<LightFeature>, DeviceError> {
    let bytes = u64::from(vertices) * size_of::<LightFeature>() as u64;
    wavefront.buffers.create(context, "light_features", bytes)?;
    let bound = kernel.bind(context, &wavefront.buffers)?;
    wavefront.submit(context, &[Stage::new(&bound, Size::Count(vertices))])?;
    wavefront.buffers.read_elements(context, "light_features", vertices)
}

/// A light vertex for Q.
pub(super) fn light_sample(feature: &LightFeature) -> LightSample {
    LightSample { end: light_end(feature), weight: feature.weight }
}

fn light_end(feature: &LightFeature) -> LightEnd {
    match feature.light {
        0 => LightEnd::Surface(Feature {
            position: feature.position.into(),
            normal: feature.normal.into(),
            direction: feature.direction.into(),
        }),
        light => LightEnd::Source { light: light - 1, at: [feature.direction[0], feature.direction[1]] },
    }
}

/// From records, which come in any order, to paths in the order of their pixels; returns the light of each eye path.
fn gather(
    batch: &Batch,
    records: &[TrainingVertex],
    ends: Vec<TrainingEnd>,
    visible: &[[f32; 4]],
    lights: &[LightFeature],
    connections: &Connections,
    set: &mut TrainingSet,
) -> Vec<PathLight> {
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
        vertices[first_of[vertex.path as usize] + (vertex.depth_thinning & 0xffff) as usize] = *vertex;
    }
    let mut ends: Vec<TrainingEnd> = ends
        .into_iter()
        .zip(visible)
        .filter(|(end, visible)| end.depth_sampled >> 16 == 0 || visible[0] > 0.0)
        .map(|(end, _)| end)
        .collect();
    ends.sort_unstable_by_key(|end| {
        let number = end.depth_sampled >> 16;
        (end.path, end.depth_sampled & 0xffff, number > 0, end.vertex, number)
    });
    let mut light = vec![PathLight::default(); first_of.len() - 1];
    let mut nodes = Vec::new();
    for end in &ends {
        let first = first_of[end.path as usize];
        let last = first + (end.depth_sampled & 0xffff) as usize;
        nodes.clear();
        let path = &vertices[first..=last];
        eye_side(path, end, lights, connections, &mut nodes);
        let p0 = match end.vertex {
            NO_LIGHT_VERTEX => end.p0,
            vertex => light_side(end, vertex as usize, lights, connections, &mut nodes),
        };
        let (depth, number) = (end.depth_sampled & 0xffff, end.depth_sampled >> 16);
        match number.checked_sub(1).filter(|_| depth == 0 && end.vertex != NO_LIGHT_VERTEX) {
            Some(number) => light[end.path as usize].add_first(number, end.contribution),
            None => light[end.path as usize].add(end.contribution),
        }
        let [x, y] = pixel_of(batch, end.path);
        // The cache's places are those of an iteration.
        let first = lights.get(end.vertex as usize).map_or(0, |y| end.vertex - y.depth);
        let path = TrainingPath {
            tile: set.tile_of(x, y),
            contribution: end.contribution,
            share: end.share,
            p0: p0 * connections.hit_scale(),
            eye_edges: depth + 1,
            light_path: u64::from(batch.first_sample) << 32 | u64::from(first),
        };
        // Paths that share their eye's part tell much the same.
        let group = batch.first_sample.wrapping_mul(0x9e37_79b9).wrapping_add(batch.first_pixel + end.path);
        set.push_path(group, path, &nodes);
    }
    light
}

/// Where a path of a batch is in the picture.
pub(super) fn pixel_of(batch: &Batch, path: u32) -> [u32; 2] {
    let pixel = batch.first_pixel + path % batch.pixel_count;
    [
        batch.crop_x + batch.crop_stride * (pixel % batch.crop_width),
        batch.crop_y + batch.crop_stride * (pixel / batch.crop_width),
    ]
}

/// The part of its connections that a vertex makes; 0 of a delta vertex.
fn thinning(vertex: &TrainingVertex) -> f64 {
    f64::from(vertex.depth_thinning >> 16) / f64::from(THINNING_UNITS)
}

/// The connections that could have made the path x_1 .. x_{n-1}, x_n, one for each of its edges between surfaces or to a
/// light, with all densities over that of the path. Where x_n is no point on a light but a vertex of the cache: those as far as x_n.
fn eye_side(
    vertices: &[TrainingVertex],
    end: &TrainingEnd,
    lights: &[LightFeature],
    connections: &Connections,
    nodes: &mut Vec<TrainingNode>,
) {
    let color = |c: [f32; 3]| Vec3::from(c).as_dvec3();
    let is_delta = |vertex: &TrainingVertex| vertex.depth_thinning >> 16 == 0;
    let sampled = end.depth_sampled >> 16 != 0;
    // f_y of the light sub-path that ends at x_{j+1}, times PE(j) over p; from the light to the eye.
    let mut arriving = color(end.emitted);
    for (j, vertex) in vertices.iter().enumerate().rev() {
        let next = vertices.get(j + 1);
        let connects = !is_delta(vertex) && !next.is_some_and(is_delta);
        let light = match next {
            Some(next) => {
                LightEnd::Surface(Feature { direction: towards_light(vertices, j + 1, end), ..feature(next) })
            }
            None => match lights.get(end.vertex as usize) {
                Some(feature) => light_end(feature),
                None => LightEnd::Source { light: end.light, at: end.at },
            },
        };
        nodes.push(TrainingNode {
            eye: feature(vertex),
            light,
            towards: towards_light(vertices, j, end),
            mass: if connects {
                arriving.element_sum() as f32 * connections.scale_at(j) * thinning(vertex) as f32
            } else {
                0.0
            },
        });
        // x_{j+1} scatters the light on to x_j.
        let (f, geometry) = match next {
            None => (color(end.f_light), end.geometry),
            Some(next) if j + 2 == vertices.len() && sampled => (color(end.f), next.geometry),
            Some(next) => (color(next.f), next.geometry),
        };
        arriving *= f * f64::from(geometry) / f64::from(vertex.pdf_area);
    }
    nodes.reverse();
}

/// The connections further along the light's sub-path, whose last vertex has the place `last` in the cache; returns
/// PE(n) / p.
fn light_side(
    end: &TrainingEnd,
    last: usize,
    lights: &[LightFeature],
    connections: &Connections,
    nodes: &mut Vec<TrainingNode>,
) -> f32 {
    let Some(y) = lights.get(last) else { return 0.0 };
    let inv_density = f64::from(end.emitted.iter().sum::<f32>()) / f64::from(y.weight);
    // What the eye's side would sample, over what the light's side did: of all vertices from `last` to the one at hand.
    let mut ratio = f64::from(end.pdf_light) / f64::from(y.pdf_area);
    let mut direction = -Vec3::from(end.direction);
    let mut pdf_back = end.pdf_back;
    let first = last - y.depth as usize;
    let mut depth = (end.depth_sampled & 0xffff) as usize;
    for at in (first + 1..=last).rev() {
        let (vertex, before) = (&lights[at], &lights[at - 1]);
        let position = Vec3::from(vertex.position);
        depth += 1;
        // A delta vertex has no weight.
        let connects = vertex.weight > 0.0 && before.weight > 0.0;
        let scale = connections.scale_at(depth) * vertex.thinning;
        let mass = (ratio * inv_density * f64::from(before.weight)) as f32 * scale;
        nodes.push(TrainingNode {
            eye: Feature { position, normal: vertex.normal.into(), direction },
            light: light_end(before),
            towards: vertex.direction.into(),
            mass: if connects { mass } else { 0.0 },
        });
        ratio *= f64::from(pdf_back) / f64::from(before.pdf_area);
        pdf_back = vertex.pdf_back;
        direction = (position - Vec3::from(before.position)).normalize_or_zero();
    }
    if lights[first].can_be_hit != 0 { (ratio * inv_density) as f32 } else { 0.0 }
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
