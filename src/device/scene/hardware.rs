//! The scene as ray queries see it: its triangles, as kernels have them, in the driver's acceleration structure.

use super::Target;
use crate::accel::Accel;
use crate::device::structure::{self, Geometry};
use crate::device::{DeviceError, PagedBuffer};
use crate::scene::SceneFeatures;

/// The name that shaders give it.
pub(super) const STRUCTURE: &str = "scene_structure";

/// Why the scene has to be traced by kernels; `None` where ray queries do.
pub(super) fn obstacle(accel: &Accel) -> Option<&'static str> {
    if !accel.instances.list.is_empty() {
        Some(
            "it shows meshes as instances, which ray queries of this version know nothing of (--instances never copies them)",
        )
    } else if accel.thin_gaps {
        Some("surfaces in it are nearer to each other than distances of ray queries tell apart")
    } else {
        None
    }
}

/// Builds the structure over the triangles that were uploaded.
pub(super) fn build(
    target: &mut Target<'_>,
    count: usize,
    features: &SceneFeatures,
) -> Result<(), DeviceError> {
    let mut left = count as u64;
    let mut geometries = Vec::new();
    for triangles in PagedBuffer::Triangles.buffers(&target.buffers) {
        let count = left.min(triangles.size() / PagedBuffer::Triangles.element());
        left -= count;
        // Where alpha or the side decides, a kernel has to be asked at each triangle.
        let is_opaque = !features.alpha && !features.culling;
        geometries.push(Geometry { triangles, count: count as u32, is_opaque });
    }
    geometries.retain(|geometry| geometry.count > 0);
    let structure = structure::build(target.context, &geometries)?;
    if geometries.len() > 1 {
        let bits = PagedBuffer::Triangles.page_bits(target.context.page_bytes);
        target.constants.push(("GEOMETRY_BITS", f64::from(bits)));
    }
    target.buffers.set_structure(STRUCTURE, structure);
    Ok(())
}
