//! What connecting by subspaces needs on the device: the model, and the light cache sorted by light subspace.

use crate::device::layout::{Hit, PathRay, TreeNode, Triangle};
use crate::device::{Bound, BufferTable, Context, Kernel};
use crate::error::DeviceError;
use crate::subspace::{Model, Tree};

use super::FirstSubspaces;
use super::wavefront::{Size, Stage, Wavefront};

/// As in `shaders/bind/buckets.wgsl`.
const RUNS: u32 = 256;

pub(super) struct Subspaces {
    /// Classifies the vertices of eye paths.
    pub labels: [Bound; 2],
    /// Sorts the cache.
    pub sort: Vec<Stage>,
    /// With the invocations of each.
    kernels: Vec<(Kernel, u32)>,
}

impl Subspaces {
    /// Uploads the model and compiles.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(context: &Context, wavefront: &mut Wavefront, model: &Model) -> Result<Self, DeviceError> {
        let k = model.subspaces;
        let buffers = &mut wavefront.buffers;
        upload_tree(context, buffers, "eye_tree", &model.eye_tree)?;
        upload_tree(context, buffers, "light_tree", &model.light_tree)?;
        buffers.upload(context, "source_labels", &model.sources)?;
        let tables = model.tables()?;
        buffers.upload(context, "gamma_pdf", &tables.pdf)?;
        let alias: Vec<[u32; 2]> =
            tables.entries.iter().map(|entry| [entry.threshold, entry.alias]).collect();
        buffers.upload(context, "gamma_alias", &alias)?;
        let inv_q: Vec<f32> = model.q.iter().map(|q| 1.0 / q).collect();
        buffers.upload(context, "inv_q", &inv_q)?;
        buffers.create(context, "bucket_ends", u64::from(k) * u64::from(RUNS) * 4)?;
        let labels = wavefront.compile(context, "eye_labels", &[])?;
        let labels = wavefront.bind_pair(context, &labels)?;
        let mut compile = |name: &str| wavefront.compile(context, name, &[]);
        let (scan, tables) = (compile("bucket_scan")?, compile("bucket_tables")?);
        let workgroups = k * tables.workgroup;
        let kernels = vec![
            (compile("bucket_counts")?, RUNS),
            (scan, 1),
            (compile("bucket_order")?, RUNS),
            (tables, workgroups),
        ];
        Ok(Self { labels, sort: Vec::new(), kernels })
    }

    /// For a cache of `vertices`.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub fn bind(
        &mut self,
        context: &Context,
        wavefront: &mut Wavefront,
        vertices: u64,
    ) -> Result<(), DeviceError> {
        for name in ["bucket_items", "bucket_tables", "bucket_sums"] {
            wavefront.buffers.create(context, name, vertices * 8)?;
        }
        self.sort = self
            .kernels
            .iter()
            .map(|(kernel, count)| {
                Ok(Stage::new(&kernel.bind(context, &wavefront.buffers)?, Size::Count(*count)))
            })
            .collect::<Result<_, DeviceError>>()?;
        Ok(())
    }

    /// Traces one camera ray a pixel and classifies what it meets.
    ///
    /// # Errors
    /// A lost device.
    pub fn first(
        &self,
        context: &Context,
        wavefront: &mut Wavefront,
    ) -> Result<Vec<FirstSubspaces>, DeviceError> {
        let triangles = wavefront.buffers.get("triangles")?.size();
        let triangles: Vec<Triangle> =
            bytemuck::pod_collect_to_vec(&wavefront.buffers.read(context, "triangles", triangles)?);
        let mut all = Vec::new();
        for batch in wavefront.batches(0, 1) {
            let rays = wavefront.camera_rays.clone();
            let mut encoder = wavefront.start(context, &batch, &rays)?;
            let stages =
                [&wavefront.closest_hit[0], &self.labels[0]].map(|kernel| Stage::new(kernel, Size::Paths));
            wavefront.record(&mut encoder, &stages)?;
            context.queue.submit([encoder.finish()]);
            let count = batch.pixel_count;
            let rays: Vec<PathRay> = read(context, wavefront, "paths a", count)?;
            let hits: Vec<Hit> = read(context, wavefront, "hits", count)?;
            let labels: Vec<[u32; 2]> = read(context, wavefront, "eye_labels", count)?;
            all.extend(rays.iter().zip(&hits).zip(labels).map(|((ray, hit), labels)| {
                // Where nothing is met there is no such triangle.
                let dark = triangles.get(hit.triangle as usize).is_some_and(|triangle| triangle.light == 0);
                FirstSubspaces { labels: dark.then_some(labels), world_direction: ray.direction }
            }));
        }
        Ok(all)
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

fn upload_tree(
    context: &Context,
    buffers: &mut BufferTable,
    name: &str,
    tree: &Tree,
) -> Result<(), DeviceError> {
    buffers.upload::<TreeNode>(context, name, tree.nodes())
}
