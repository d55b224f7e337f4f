//! Meshes that are shown in many places (`accel/instances.rs`), as the device has them.

use super::Target;
use crate::accel::{AccelInstance, Instances};
use crate::device::layout::{self, InstanceNumbers, TRIANGLE_INSTANCE};
use crate::device::{DeviceError, PagedBuffer};

/// Uploads `instances` and `instance_blocks`, where there are any, and what says whose a number is.
pub(super) fn upload(target: &mut Target<'_>, instances: &Instances) -> Result<(), DeviceError> {
    if instances.list.is_empty() {
        return Ok(());
    }
    target.upload_by(PagedBuffer::Instances, instances.list.len(), 1, |range, items| {
        items.extend(instances.list[range].iter().map(instance));
    })?;
    target.upload(PagedBuffer::InstanceBlocks, &instances.blocks)?;
    let numbers = InstanceNumbers { first: instances.first_number, block_bits: instances.block_bits };
    target.buffers.upload_uniform(target.context, "instance_numbers", &[numbers])
}

/// What stands for an instance in the scene's tree, at an index of its triangles.
pub(super) fn entry(instances: &Instances, index: usize) -> layout::Triangle {
    let instance = instances.entries.partition_point(|&entry| (entry as usize) < index);
    layout::Triangle { material_flags: TRIANGLE_INSTANCE, light: instance as u32, ..Default::default() }
}

fn instance(instance: &AccelInstance) -> layout::Instance {
    let [x, y, z] = instance.linear.to_cols_array_2d();
    let [inverse_x, inverse_y, inverse_z] = instance.inverse.to_cols_array_2d();
    layout::Instance {
        x,
        root: instance.root,
        y,
        shift: instance.first_number - instance.first_triangle,
        z,
        handedness: if instance.is_mirrored { -1.0 } else { 1.0 },
        origin: instance.origin.to_array(),
        reach: instance.reach,
        origin_rest: instance.origin_rest.to_array(),
        inverse_x,
        inverse_y,
        inverse_z,
        ..Default::default()
    }
}
