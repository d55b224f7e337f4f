//! The scene as ray queries see it: its triangles, as kernels have them, in the driver's acceleration structure. What is shown
//! once is one part of it, and each mesh that has instances another.

use std::collections::BTreeMap;
use std::ops::Range;

use super::Target;
use crate::accel::{Accel, AccelInstance};
use crate::device::structure::{self, Geometry, Part, Place};
use crate::device::{Context, DeviceError, PagedBuffer};
use crate::scene::SceneFeatures;

/// The names that shaders give them.
const STRUCTURE: &str = "scene_structure";
const BASES: &str = "structure_bases";
/// Numbers of places that ray queries tell apart.
const MOST_PLACES: u32 = 1 << 24;

/// Why the scene has to be traced by kernels; `None` where ray queries do.
pub(super) fn obstacle(context: &Context, accel: &Accel) -> Option<String> {
    let limits = context.device.limits();
    let places = accel.instances.list.len() as u64 + 1;
    let most = limits.max_tlas_instance_count.min(MOST_PLACES);
    if places > most.into() {
        return Some(format!("ray queries of this device take {most} instances of meshes, and it has more"));
    }
    let vertices = 3 * accel.triangles.len() as u64;
    (vertices > limits.max_blas_primitive_count.into()).then(|| {
        let most = limits.max_blas_primitive_count / 3;
        format!("ray queries of this device take {most} triangles, and it has more")
    })
}

/// Builds the structure over the triangles that were uploaded.
pub(super) fn build(
    target: &mut Target<'_>,
    accel: &Accel,
    features: &SceneFeatures,
) -> Result<(), DeviceError> {
    let pages: Vec<&wgpu::Buffer> = PagedBuffer::Triangles.buffers(&target.buffers).collect();
    let bits = PagedBuffer::Triangles.page_bits(target.context.page_bytes);
    // Where alpha or the side decides, a kernel has to be asked at each triangle.
    let is_opaque = !features.alpha && !features.culling;
    let geometries = |range: Range<u32>| geometries(&pages, bits, range, is_opaque);
    let list = &accel.instances.list;
    let once = list.iter().map(|instance| instance.first_triangle).min();
    let once = once.unwrap_or(accel.triangles.len() as u32);
    let mut parts = vec![Part { geometries: geometries(0..once), places: vec![Place::own(0)] }];
    let mut shared: BTreeMap<u32, Part> = BTreeMap::new();
    for (number, instance) in (1..).zip(list) {
        let first = instance.first_triangle;
        let part = shared.entry(first).or_insert_with(|| Part {
            geometries: geometries(first..first + instance.triangles),
            places: Vec::new(),
        });
        part.places.push(Place { transform: transform(instance), number });
    }
    parts.extend(shared.into_values());
    parts.retain(|part| !part.geometries.is_empty());
    let structure = structure::build(target.context, &parts)?;
    if pages.len() > 1 {
        target.constants.push(("GEOMETRY_BITS", f64::from(bits)));
    }
    target.buffers.set_structure(STRUCTURE, structure);
    if !list.is_empty() {
        let firsts = list.iter().map(|instance| instance.first_triangle);
        let bases: Vec<u32> = std::iter::once(0).chain(firsts).collect();
        target.buffers.upload(target.context, BASES, &bases)?;
    }
    Ok(())
}

/// Triangles in a row, page by page; the only page is as long as it has to be.
fn geometries<'a>(
    pages: &[&'a wgpu::Buffer],
    bits: u32,
    range: Range<u32>,
    is_opaque: bool,
) -> Vec<Geometry<'a>> {
    let of_page = |(page, triangles): (usize, &&'a wgpu::Buffer)| {
        let begin = (page as u32) << bits;
        let end = if pages.len() == 1 { u32::MAX } else { begin + (1 << bits) };
        let (first, last) = (range.start.max(begin), range.end.min(end));
        let count = last.saturating_sub(first);
        (count > 0).then(|| Geometry { triangles, first: first - begin, count, is_opaque })
    };
    pages.iter().enumerate().filter_map(of_page).collect()
}

/// From the mesh's space to unit space, three rows of four.
fn transform(instance: &AccelInstance) -> [f32; 12] {
    let origin = instance.origin + instance.origin_rest;
    let [x, y, z] = [instance.linear.x_axis, instance.linear.y_axis, instance.linear.z_axis];
    let row = |row: usize| [x[row], y[row], z[row], origin[row]];
    let rows = [row(0), row(1), row(2)];
    std::array::from_fn(|i| rows[i / 4][i % 4])
}
