//! What connecting by subspaces needs on the device: the model, and the light cache sorted by light subspace.

use glam::Vec3;

use crate::device::layout::{Hit, PathRay, Triangle};
use crate::device::{Bound, Context, DeviceError, Kernel, PagedBuffer};
use crate::subspace::Model;
use crate::subspace::guide::{cell_bounds, even_cells};

use crate::integrator::FirstSubspaces;
use crate::integrator::wavefront::{Size, Stage, Wavefront};

/// As in `shaders/bind/buckets.wgsl`.
const RUNS: u32 = 256;

pub(super) struct Subspaces {
    /// Classifies the vertices of eye paths.
    pub labels: Option<[Bound; 2]>,
    /// Sorts the cache.
    pub sort: Vec<Stage>,
    /// Light paths are guided.
    pub guided: bool,
    label_kernel: Kernel,
    counts: Kernel,
    scan: Kernel,
    order: Kernel,
    tables: Kernel,
}

impl Subspaces {
    /// Uploads the model and compiles. Light paths are guided by this and by all later models that know how, if this one
    /// does.
    ///
    /// # Errors
    /// A kernel that does not compile, a buffer that does not fit.
    pub fn new(context: &Context, wavefront: &mut Wavefront, model: &Model) -> Result<Self, DeviceError> {
        let mut compile = |name: &str| wavefront.compile(context, name, &[]);
        let subspaces = Self {
            labels: None,
            sort: Vec::new(),
            guided: model.guide.is_some(),
            label_kernel: compile("eye_labels")?,
            counts: compile("bucket_counts")?,
            scan: compile("bucket_scan")?,
            order: compile("bucket_order")?,
            tables: compile("bucket_tables")?,
        };
        subspaces.upload(context, wavefront, model)?;
        Ok(subspaces)
    }

    /// Another model; what uses it has to be bound again.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub fn upload(
        &self,
        context: &Context,
        wavefront: &mut Wavefront,
        model: &Model,
    ) -> Result<(), DeviceError> {
        wavefront.subspaces = model.subspaces;
        let buffers = &mut wavefront.buffers;
        buffers.upload(context, "eye_tree", model.eye_tree.nodes())?;
        buffers.upload(context, "light_tree", model.light_tree.nodes())?;
        buffers.upload(context, "source_labels", &model.sources)?;
        let tables = model.tables()?;
        buffers.upload(context, "gamma_pdf", &tables.pdf)?;
        buffers.upload(context, "gamma_cutpoints", &tables.entries)?;
        let inv_q: Vec<f32> = model.q.iter().map(|q| 1.0 / q).collect();
        buffers.upload(context, "inv_q", &inv_q)?;
        if self.guided {
            let guide = model.guide.as_ref();
            let cells = guide.map_or_else(|| even_cells(model.subspaces), |guide| guide.cells.clone());
            buffers.upload(context, "guide_bounds", &cell_bounds(&cells))?;
            // A model without a guide goes on with the picks of the one before.
            if let Some(guide) = guide {
                buffers.upload(context, "guide_picks", &guide.pick_table()?)?;
            }
        }
        buffers.create(context, "bucket_ends", u64::from(model.subspaces) * u64::from(RUNS) * 4)?;
        Ok(())
    }

    /// For a cache of `vertices`.
    ///
    /// # Errors
    /// A buffer that does not fit.
    pub fn make_room(context: &Context, wavefront: &mut Wavefront, vertices: u64) -> Result<(), DeviceError> {
        for name in ["bucket_items", "bucket_tables", "bucket_sums"] {
            wavefront.buffers.create(context, name, vertices * 8)?;
        }
        Ok(())
    }

    /// Binds the kernels to the buffers of now.
    ///
    /// # Errors
    /// A buffer that is missing.
    pub fn bind(&mut self, context: &Context, wavefront: &mut Wavefront) -> Result<(), DeviceError> {
        self.labels = Some(wavefront.bind_pair(context, &self.label_kernel)?);
        let table_invocations = wavefront.subspaces * self.tables.workgroup();
        self.sort =
            [(&self.counts, RUNS), (&self.scan, 1), (&self.order, RUNS), (&self.tables, table_invocations)]
                .into_iter()
                .map(|(kernel, count)| {
                    Ok(Stage::new(&kernel.bind(context, &wavefront.buffers)?, Size::Count(count)))
                })
                .collect::<Result<_, DeviceError>>()?;
        Ok(())
    }

    /// Traces one camera ray per pixel and classifies what it meets.
    ///
    /// # Errors
    /// A lost device.
    pub fn first(
        &self,
        context: &Context,
        wavefront: &mut Wavefront,
    ) -> Result<Vec<FirstSubspaces>, DeviceError> {
        let triangles: Vec<Triangle> = PagedBuffer::Triangles.read(context, &wavefront.buffers)?;
        let Some([labels, _]) = &self.labels else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        for batch in wavefront.batches(0, 1) {
            let rays = wavefront.camera_rays.clone();
            let mut encoder = wavefront.start(context, &batch, &rays)?;
            let stages = [&wavefront.closest_hit[0], labels].map(|kernel| Stage::new(kernel, Size::Paths));
            wavefront.record(&mut encoder, &stages)?;
            context.queue.submit([encoder.finish()]);
            let count = batch.pixel_count;
            let rays: Vec<PathRay> = wavefront.buffers.read_elements(context, "paths a", count)?;
            let hits: Vec<Hit> = wavefront.buffers.read_elements(context, "hits", count)?;
            let labels: Vec<[u32; 2]> = wavefront.buffers.read_elements(context, "eye_labels", count)?;
            all.extend(rays.iter().zip(&hits).zip(labels).map(|((ray, hit), labels)| {
                // Triangles of instances have numbers beyond those that are stored; none of them emits.
                let dark = triangles.get(hit.triangle as usize).is_none_or(|triangle| triangle.light == 0);
                let position = Vec3::from(ray.origin) + hit.t * Vec3::from(ray.direction);
                FirstSubspaces {
                    labels: (hit.triangle != u32::MAX && dark).then_some(labels),
                    world_direction: ray.direction,
                    position: position.to_array(),
                }
            }));
        }
        Ok(all)
    }
}
