//! What connecting by subspaces needs on the device: the model, and the light cache sorted by light subspace.

use crate::device::layout::TreeNode;
use crate::device::{Bound, BufferTable, Context, Kernel};
use crate::error::DeviceError;
use crate::subspace::{Model, Tree};

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
}

fn upload_tree(
    context: &Context,
    buffers: &mut BufferTable,
    name: &str,
    tree: &Tree,
) -> Result<(), DeviceError> {
    buffers.upload::<TreeNode>(context, name, tree.nodes())
}
