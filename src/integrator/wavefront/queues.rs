//! The buffers between kernels, and what the device has counted in them.

use super::Wavefront;
use super::kernels::Form;
use crate::device::layout::{
    Batch, Camera, Counts, EyeLink, EyeMis, Hit, LightMis, PathRay, RecordLink, SAMPLES_A_GROUP, ShadowRay,
    SubPath, TrainingEnd, TrainingVertex,
};
use crate::device::{BufferTable, Context, DeviceError};

/// Paths in flight on a software device, at least and at most: enough to hide the tail of a batch, few enough to keep a dispatch
/// near 100 ms (docs/measurements.md, Speed).
const CPU_CAPACITY: [u32; 2] = [1 << 16, 1 << 18];
/// Paths in flight on a GPU.
const GPU_CAPACITY: u32 = 1 << 20;
/// Vertices of an eye path that there is room for on average, where paths keep lists of them.
const EYE_LINKS_A_PATH: u32 = 4;

/// Buffers that paths change places between: the name, and both of them.
pub(super) type Swapped = Vec<(&'static str, [wgpu::Buffer; 2])>;

/// Paths in flight at most, each with so many connections: as many as one buffer has room for. `pixels`: of which a group of
/// samples is to be in flight.
pub(super) fn capacity(context: &Context, connections: u32, pixels: u32) -> u32 {
    let largest = u64::from(connections) * size_of::<ShadowRay>().max(size_of::<SubPath>()) as u64;
    let room = (context.binding / largest).min(u64::from(GPU_CAPACITY)) as u32;
    let [least, most] = CPU_CAPACITY;
    let wanted = match context.is_cpu() {
        true => pixels.saturating_mul(SAMPLES_A_GROUP).min(most).next_power_of_two().max(least),
        false => GPU_CAPACITY,
    };
    wanted.min(1 << room.max(1).ilog2())
}

/// Makes the queues for `capacity` paths. `connects`: there is light to connect to.
pub(super) fn create(
    context: &Context,
    buffers: &mut BufferTable,
    camera: &Camera,
    form: &Form,
    capacity: u32,
    connects: bool,
) -> Result<Swapped, DeviceError> {
    let bytes = |size: usize| u64::from(capacity) * size as u64;
    let mut pair = |names: [&str; 2], size: usize| {
        let first = buffers.create(context, names[0], bytes(size))?.clone();
        Ok::<_, DeviceError>([first, buffers.create(context, names[1], bytes(size))?.clone()])
    };
    let mut swapped = vec![("paths", pair(["paths a", "paths b"], size_of::<PathRay>())?)];
    if form.bidirectional {
        swapped.push(("sub_paths", pair(["sub_paths a", "sub_paths b"], size_of::<SubPath>())?));
    }
    if form.resampling {
        // Eye and light paths are never in flight together.
        let ends = pair(["ends a", "ends b"], 4)?;
        swapped.push(("eye_ends", ends.clone()));
        if form.at_records {
            swapped.push(("light_ends", ends));
        }
    }
    if form.subspaces {
        // Neither are these.
        let mis = pair(["mis a", "mis b"], size_of::<EyeMis>().max(size_of::<LightMis>()))?;
        swapped.extend([("eye_mis", mis.clone()), ("light_mis", mis)]);
        buffers.create(context, "eye_labels", bytes(8))?;
    }
    if form.resampling {
        let link = if form.at_records { size_of::<RecordLink>() } else { size_of::<EyeLink>() };
        let wanted = u64::from(EYE_LINKS_A_PATH) * bytes(link);
        buffers.create(context, "eye_links", wanted.min(context.binding / 16 * 16))?;
        buffers.create(context, "eye_link_count", 4)?;
    }
    if form.at_records {
        buffers.create(context, "eye_reach", bytes(16))?;
        buffers.create(context, "light_edges", bytes(4))?;
    }
    let connections = u64::from(form.connections);
    buffers.create(context, "hits", bytes(size_of::<Hit>()))?;
    buffers.create(context, "radiance", connections * bytes(16))?;
    if connects {
        buffers.create(context, "shadow_rays", connections * bytes(size_of::<ShadowRay>()))?;
    }
    buffers.create(context, "counts", size_of::<Counts>() as u64)?;
    let indirect = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDIRECT;
    buffers.create_with(context, "arguments", 96, indirect)?;
    buffers.upload_uniform(context, "camera", &[*camera])?;
    buffers.upload_uniform(context, "batch", &[Batch::default()])?;
    Ok(swapped)
}

/// What was done so far, exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct RayCounts {
    /// Eye and light paths.
    pub paths: u64,
    pub closest_hit: u64,
    /// Connections tested: those that would carry light.
    pub occlusion: u64,
    /// Of the rays above, those of light paths.
    pub light_closest_hit: u64,
    /// Of the connections above, those of light paths to the camera.
    pub light_occlusion: u64,
    /// Vertices that light paths left in the cache.
    pub light_vertices: u64,
    /// Iterations whose light vertices found no room in the cache, and were traced once more with enough of it.
    pub cache_overflows: u64,
    /// Light vertices of infinite or undefined weight, which connections by subspaces leave out.
    pub non_finite_vertices: u64,
    /// Vertices of eye paths that drew light vertices for those near to them.
    pub records: u64,
    /// Pairs of these and a light vertex, with a ray for each that may carry light.
    pub record_entries: u64,
}

/// Surfaces of a path on average from which on a user wants to know: roulette alone ends paths after twice as many. (Between
/// mirrors it does after thirty.)
const DEEP: f64 = 120.0;

impl RayCounts {
    /// Surfaces that a path meets on average, where they are so many that little else than chance ends paths.
    pub fn deep_paths(&self) -> Option<f64> {
        let mean = self.closest_hit as f64 / self.paths.max(1) as f64;
        (mean > DEEP).then_some(mean)
    }
}

impl std::ops::Add for RayCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            paths: self.paths + other.paths,
            closest_hit: self.closest_hit + other.closest_hit,
            occlusion: self.occlusion + other.occlusion,
            light_closest_hit: self.light_closest_hit + other.light_closest_hit,
            light_occlusion: self.light_occlusion + other.light_occlusion,
            light_vertices: self.light_vertices + other.light_vertices,
            cache_overflows: self.cache_overflows + other.cache_overflows,
            non_finite_vertices: self.non_finite_vertices + other.non_finite_vertices,
            records: self.records + other.records,
            record_entries: self.record_entries + other.record_entries,
        }
    }
}

impl Wavefront {
    /// Makes buffers for so many records of each kind of kernels that write down the paths that they find. What writes them
    /// has to be bound again.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub(crate) fn make_room_for_records(
        &mut self,
        context: &Context,
        capacity: u32,
    ) -> Result<(), DeviceError> {
        for (name, size) in [
            ("training_vertices", size_of::<TrainingVertex>()),
            ("training_ends", size_of::<TrainingEnd>()),
            // The connection slots are those of ends here.
            ("radiance", 16),
        ] {
            self.buffers.create(context, name, u64::from(capacity) * size as u64)?;
        }
        if self.buffers.get("training_counts").is_err() {
            self.buffers.create(context, "training_counts", 8)?;
        }
        Ok(())
    }

    /// Whether the lists of the eye paths of the last batch had room for all of their vertices.
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn eye_links_fit(&self, context: &Context) -> Result<bool, DeviceError> {
        let Ok(links) = self.buffers.get("eye_links") else { return Ok(true) };
        let count: Vec<u32> = self.buffers.read_elements(context, "eye_link_count", 1)?;
        let room = links.size() / self.eye_link_bytes();
        Ok(count.iter().all(|&count| u64::from(count) <= room))
    }

    pub(crate) fn counts(&self, context: &Context) -> Result<Counts, DeviceError> {
        let bytes = self.buffers.read(context, "counts", size_of::<Counts>() as u64)?;
        Ok(bytemuck::pod_read_unaligned(&bytes))
    }

    /// What was done so far; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn ray_counts(&self, context: &Context) -> Result<RayCounts, DeviceError> {
        let counts = self.counts(context)?;
        Ok(RayCounts {
            paths: self.paths,
            closest_hit: total(counts.closest_total) - self.aside,
            occlusion: total(counts.shadow_total),
            non_finite_vertices: counts.non_finite_vertices.into(),
            ..self.light_counts
        })
    }
}

/// A total of the device.
pub(crate) fn total(words: [u32; 2]) -> u64 {
    u64::from(words[0]) | u64::from(words[1]) << 32
}
