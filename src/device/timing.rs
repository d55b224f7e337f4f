//! Seconds per kernel, from the device's own timestamps.

use std::collections::BTreeMap;

use super::buffer::read_back;
use super::context::Context;
use crate::device::DeviceError;

/// wgpu's limit on the queries of one set.
const CAPACITY: u32 = 4096;

/// Collects pairs of timestamps; each pair belongs to a kernel's name.
pub struct Timing {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pending: Vec<String>,
    /// Seconds and number of dispatches so far, by kernel.
    pub totals: BTreeMap<String, (f64, u64)>,
}

impl Timing {
    /// `None` when the device has no timestamps.
    pub fn new(context: &Context) -> Option<Self> {
        if !context.timestamps {
            return None;
        }
        let queries = context.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("kernel times"),
            ty: wgpu::QueryType::Timestamp,
            count: CAPACITY,
        });
        let resolved = context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("kernel times"),
            size: u64::from(CAPACITY) * 8,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self { queries, resolved, pending: Vec::new(), totals: BTreeMap::new() })
    }

    /// Where a pass of `kernel` writes its times; `None` when the queries of this submission are used up (the dispatch then
    /// goes untimed, and counts nowhere).
    pub fn writes(&mut self, kernel: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let first = self.pending.len() as u32 * 2;
        if first + 2 > CAPACITY {
            return None;
        }
        self.pending.push(kernel.to_string());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.totals.clear();
        self.pending.clear();
    }

    /// There may not be queries for another submission: it is time to [`collect`](Self::collect).
    pub fn is_filling(&self) -> bool {
        self.pending.len() as u32 > CAPACITY / 4
    }

    /// Reads the pending timestamps into the totals; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn collect(&mut self, context: &Context) -> Result<(), DeviceError> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let count = self.pending.len() as u32 * 2;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        context.queue.submit([encoder.finish()]);
        let bytes = read_back(context, &self.resolved, u64::from(count) * 8)?;
        let times: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let period = f64::from(context.queue.get_timestamp_period()) * 1e-9;
        for (kernel, pair) in self.pending.drain(..).zip(times.chunks_exact(2)) {
            let total = self.totals.entry(kernel).or_default();
            total.0 += pair[1].saturating_sub(pair[0]) as f64 * period;
            total.1 += 1;
        }
        Ok(())
    }
}
