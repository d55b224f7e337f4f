//! Records: vertices of a few eye paths of each iteration, each with a table by which the eye vertices near to it draw
//! vertices of the light cache.

use super::RESERVE;
use super::settings::{PcBpt, RecordCost};
use crate::device::layout::{Batch, Record};
use crate::device::{Bound, Context, DeviceError, Feature, Kernel};
use crate::integrator::Weights;
use crate::integrator::wavefront::{Bounces, Size, Stage, Wavefront};
use crate::math::kd_tree::KdTree;
use crate::math::rng::{RandomKey, random4};

/// Sets the numbers of the records' eye paths apart from those of the picture's: where records are is then independent of
/// what is connected by them.
const RECORD_STREAM: u32 = 0x7f4a_7c15;
/// Room for the records of each path at first; it grows where that is too little.
const FIRST_RECORDS_A_PATH: u64 = 6;
/// Least Q, as a share of the mean: where no light was seen to arrive, some may.
const LEAST_Q: f32 = 1e-3;
/// Pairs of a record and a light vertex that one dispatch looks at.
const PAIRS_AT_ONCE: u32 = 1 << 17;

/// What earlier iterations tell of places: the mean light Q that a light path brings to each of some records.
struct Known {
    tree: KdTree,
    /// In the tree's order.
    q: Vec<f32>,
}

impl Known {
    /// The mean of the three nearest; `None` where nothing is known.
    fn q_at(&self, position: [f32; 3]) -> Option<f32> {
        let nearest = self.tree.nearest(position);
        let sum: f32 = nearest.iter().map(|&(place, _)| self.q[place as usize]).sum();
        (sum > 0.0).then(|| sum / nearest.len() as f32)
    }
}

pub(super) struct Records {
    /// Every so many-th pixel, along both sides of the picture, has an eye path that leaves records.
    pub stride: u32,
    /// Records that there is room for, and entries of their tables.
    capacity: u32,
    entries: u64,
    /// Of the iteration that is under way.
    pub count: u32,
    tree: KdTree,
    has_grown: bool,
    /// Where weights know of it.
    known: Option<Known>,
    resampling: bool,
    vertices: Kernel,
    weights: Kernel,
    tables: Kernel,
    nearest: Kernel,
    /// Where weights know what light vertices bring to records.
    reach: Option<Kernel>,
    /// `None` until they are bound.
    stages: Option<Stages>,
}

/// The kernels with their buffers.
struct Stages {
    /// Of the eye paths that leave records.
    bounces: Bounces,
    eye_shade: [Bound; 2],
    weights: Bound,
    tables: Bound,
    nearest: [Bound; 2],
    reach: Option<[Bound; 2]>,
}

impl Records {
    /// Compiles; about `share` of the pixels have an eye path that leaves records.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(
        context: &Context,
        wavefront: &mut Wavefront,
        share: f64,
        weights: Weights,
    ) -> Result<Self, DeviceError> {
        let resampling = matches!(weights, Weights::Resampling | Weights::AtRecords);
        let mut compile = |name: &str, extra: &[Feature]| wavefront.compile(context, name, extra);
        let records = Self {
            stride: PcBpt::stride(share),
            capacity: 0,
            entries: 0,
            count: 0,
            tree: KdTree::default(),
            has_grown: false,
            known: None,
            resampling,
            vertices: compile("record_vertices", &[])?,
            weights: compile("record_weights", &[Feature::AnyHit])?,
            tables: compile("record_tables", &[])?,
            nearest: compile("eye_records", &[])?,
            reach: match weights == Weights::AtRecords {
                true => Some(compile("eye_reach", &[Feature::AnyHit])?),
                false => None,
            },
            stages: None,
        };
        let buffers = &mut wavefront.buffers;
        buffers.create(context, "eye_records", u64::from(wavefront.capacity) * 16)?;
        // Something to bind; more room comes with the pilot.
        for name in ["found_records", "found_count", "records", "record_weights", "record_ends"] {
            buffers.create(context, name, size_of::<Record>() as u64)?;
        }
        if resampling {
            buffers.create(context, "record_sums", 16)?;
        }
        Ok(records)
    }

    /// Binds the kernels to the buffers of now; `eye_shade`: goes on with eye paths.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub fn bind(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        eye_shade: &[Bound; 2],
    ) -> Result<(), DeviceError> {
        let vertices = wavefront.bind_pair(context, &self.vertices)?;
        let bounce = |parity: usize| {
            vec![
                Stage::new(&wavefront.closest_hit[parity], Size::Paths),
                Stage::new(&vertices[parity], Size::Paths),
                Stage::new(&eye_shade[parity], Size::Paths),
                Stage::new(&wavefront.advance, Size::Count(1)),
            ]
        };
        self.stages = Some(Stages {
            bounces: [bounce(0), bounce(1)].into(),
            eye_shade: eye_shade.clone(),
            weights: self.weights.bind(context, &wavefront.buffers)?,
            tables: self.tables.bind(context, &wavefront.buffers)?,
            nearest: wavefront.bind_pair(context, &self.nearest)?,
            reach: match &self.reach {
                Some(kernel) => Some(wavefront.bind_pair(context, kernel)?),
                None => None,
            },
        });
        Ok(())
    }

    /// Once more, after a buffer was made again.
    fn rebind(&mut self, context: &Context, wavefront: &mut Wavefront) -> Result<(), DeviceError> {
        match self.stages.take() {
            Some(stages) => self.bind(context, wavefront, &stages.eye_shade),
            None => Ok(()),
        }
    }

    /// Finds the records near to the vertices that eye paths have reached, and what reaches those of the vertices before.
    pub fn of_eye_vertices(&self, parity: usize) -> Vec<Stage> {
        let bound = self.stages.iter().flat_map(|stages| [Some(&stages.nearest), stages.reach.as_ref()]);
        bound.flatten().map(|bound| Stage::new(&bound[parity], Size::Paths)).collect()
    }

    /// A lattice of pixels all over the picture, in another place each time.
    fn lattice(&self, template: &Batch) -> Batch {
        let seed = template.seed.wrapping_add(RECORD_STREAM);
        let words = random4(RandomKey { pixel: 0, sample: template.first_sample, seed }, 0);
        let offset = |word: u32, size: u32| word % self.stride.min(size);
        let (crop_x, crop_y) = (offset(words.x, template.width), offset(words.y, template.height));
        Batch {
            crop_x,
            crop_y,
            crop_width: (template.width - crop_x).div_ceil(self.stride),
            crop_height: (template.height - crop_y).div_ceil(self.stride),
            crop_stride: self.stride,
            sample_count: 1,
            seed,
            ..*template
        }
    }

    /// Finds the records of the sample that `template` begins with.
    ///
    /// # Errors
    /// A lost device, or more records than fit.
    pub fn prepare(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        template: &Batch,
    ) -> Result<(), DeviceError> {
        let found = self.find(context, wavefront, template)?;
        let records = self.in_order(found);
        self.count = records.len() as u32;
        wavefront.buffers.write(context, "records", bytemuck::cast_slice(&records))
    }

    /// Traces the eye paths that leave them.
    fn find(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        template: &Batch,
    ) -> Result<Vec<Record>, DeviceError> {
        let lattice = self.lattice(template);
        let paths = lattice.crop_width * lattice.crop_height;
        if self.capacity == 0 {
            self.make_room(context, wavefront, u64::from(paths) * FIRST_RECORDS_A_PATH)?;
        }
        let first_rays = wavefront.camera_rays.clone();
        loop {
            wavefront.buffers.write(context, "found_count", &[0; 4])?;
            let slice = wavefront.slice;
            for first in (0..paths).step_by(slice as usize) {
                let batch = Batch { first_pixel: first, pixel_count: slice.min(paths - first), ..lattice };
                let encoder = wavefront.start(context, &batch, &first_rays)?;
                if let Some(stages) = &self.stages {
                    wavefront.bounce(context, encoder, &stages.bounces, batch.max_depth)?;
                }
            }
            let found: Vec<u32> = wavefront.buffers.read_elements(context, "found_count", 1)?;
            let found = found.into_iter().sum();
            if found <= self.capacity {
                return wavefront.buffers.read_elements(context, "found_records", found);
            }
            self.make_room(context, wavefront, (f64::from(found) * RESERVE) as u64)?;
        }
    }

    fn make_room(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        records: u64,
    ) -> Result<(), DeviceError> {
        for name in ["found_records", "records"] {
            wavefront.buffers.create(context, name, records * size_of::<Record>() as u64)?;
        }
        if self.resampling {
            wavefront.buffers.create(context, "record_sums", records * 4)?;
        }
        self.capacity = records as u32;
        self.has_grown = true;
        self.rebind(context, wavefront)
    }

    /// Makes room for the tables of the records of so many light vertices.
    ///
    /// # Errors
    /// Tables that do not fit.
    pub fn make_room_for_tables(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        vertices: u32,
    ) -> Result<(), DeviceError> {
        let records = self.count;
        let entries = u64::from(records) * u64::from(vertices);
        if entries <= self.entries {
            return Ok(());
        }
        let limit = context.binding;
        let bytes = entries * RecordCost::ENTRY_BYTES;
        if bytes > limit {
            return Err(DeviceError::RecordsTooLarge { records, vertices, bytes, limit });
        }
        let with_reserve = ((entries as f64 * RESERVE) as u64).min(limit / RecordCost::ENTRY_BYTES);
        for name in ["record_weights", "record_ends"] {
            wavefront.buffers.create(context, name, with_reserve * RecordCost::ENTRY_BYTES)?;
        }
        self.entries = with_reserve;
        self.has_grown = true;
        self.rebind(context, wavefront)
    }

    /// Makes the tables of records for the `vertices` of the cache.
    ///
    /// # Errors
    /// A lost device, or tables that do not fit.
    pub fn fill(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        template: &Batch,
        vertices: u32,
    ) -> Result<(), DeviceError> {
        self.make_room_for_tables(context, wavefront, vertices)?;
        let Some(stages) = &self.stages else { return Ok(()) };
        let at_once = (PAIRS_AT_ONCE / vertices.max(1)).max(1);
        for first in (0..self.count).step_by(at_once as usize) {
            let end = self.count.min(first + at_once);
            wavefront.set_batch(context, &Batch { records: end, first_record: first, ..*template })?;
            let pairs = Size::Count((end - first) * vertices);
            wavefront.submit(context, &[Stage::new(&stages.weights, pairs)])?;
            if wavefront.shares_device() {
                context.wait()?;
            }
        }
        wavefront.set_batch(context, &Batch { records: self.count, ..*template })?;
        let tables = Size::Count(self.count * self.tables.workgroup());
        wavefront.submit(context, &[Stage::new(&stages.tables, tables)])?;
        wavefront.light_counts.records += u64::from(self.count);
        wavefront.light_counts.record_entries += u64::from(self.count) * u64::from(vertices);
        Ok(())
    }

    /// Whether a buffer was made again since this was asked: what else uses it has to be bound again.
    pub fn take_grown(&mut self) -> bool {
        std::mem::take(&mut self.has_grown)
    }

    /// Learns from the tables as they are, which `before` others have gone before, and which come from so many light paths.
    /// All records that follow know of it.
    ///
    /// # Errors
    /// A lost device.
    pub fn learn(
        &mut self,
        context: &Context,
        wavefront: &Wavefront,
        before: u32,
        light_paths: u32,
    ) -> Result<(), DeviceError> {
        let sums: Vec<f32> = wavefront.buffers.read_elements(context, "record_sums", self.count)?;
        let running = |(&position, &sum): (&[f32; 3], &f32)| {
            let q = sum / light_paths as f32;
            let known = self.known.as_ref().and_then(|known| known.q_at(position));
            known.map_or(q, |known| (known * before as f32 + q) / (before + 1) as f32)
        };
        let q: Vec<f32> = self.tree.points().iter().zip(&sums).map(running).collect();
        let floor = LEAST_Q * q.iter().sum::<f32>() / q.len().max(1) as f32;
        let q = q.into_iter().map(|q| q.max(floor)).collect();
        self.known = Some(Known { tree: self.tree.clone(), q });
        Ok(())
    }

    /// Forgets what was learnt: another camera, other records.
    pub fn forget(&mut self) {
        self.known = None;
    }

    /// In the order of their tree, each with what it counts at most of near light vertices, and what is known of it.
    fn in_order(&mut self, mut found: Vec<Record>) -> Vec<Record> {
        // The order in which the device found them changes from run to run.
        found.sort_unstable_by_key(|record| (record.path, record.depth_sides));
        let positions: Vec<[f32; 3]> = found.iter().map(|record| record.position).collect();
        let (tree, order) = KdTree::build(&positions);
        let record = |&index: &u32| {
            let record = found[index as usize];
            let q = self.known.as_ref().and_then(|known| known.q_at(record.position));
            let inv_q = q.map_or(0.0, |q| (1.0 / q).min(f32::MAX));
            Record { most_geometry: most_geometry(&tree, record.position), inv_q, ..record }
        };
        let records = order.iter().map(record).collect();
        self.tree = tree;
        records
    }
}

/// A record stands for the eye vertices that are about as far from it as other records are, at a distance d; from a light
/// vertex at any distance their geometry terms are 1 / d^2 on average, or less.
fn most_geometry(tree: &KdTree, position: [f32; 3]) -> f32 {
    // The first is the record itself.
    let nearest = tree.nearest(position);
    let farthest = nearest.iter().skip(1).map(|&(_, distance_sq)| distance_sq).fold(0.0, f32::max);
    if farthest > 0.0 { (1.0 / farthest).min(f32::MAX) } else { f32::MAX }
}
