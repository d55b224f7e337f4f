//! The ray through a point of the picture, and the way back.

use glam::{DVec2, DVec3};
use halfway::scene::{Camera, Projection};

use super::geometry::Ray;

/// `pixel`: x to the right in [0, width), y down in [0, height).
pub fn ray(camera: &Camera, resolution: [u32; 2], pixel: DVec2) -> Ray {
    let [width, height] = resolution.map(f64::from);
    let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|v| v.as_dvec3());
    let across = 2.0 * pixel.x / width - 1.0;
    let above = 1.0 - 2.0 * pixel.y / height;
    match camera.projection {
        Projection::Perspective { yfov } => {
            let half_height = (0.5 * f64::from(yfov)).tan();
            let half_width = half_height * width / height;
            let direction: DVec3 = forward + across * half_width * right + above * half_height * up;
            Ray { origin: camera.position, direction: direction.normalize() }
        }
        Projection::Orthographic { xmag, ymag } => {
            let offset = across * f64::from(xmag) * right + above * f64::from(ymag) * up;
            Ray { origin: camera.position + offset, direction: forward }
        }
    }
}

/// How a point of the scene is seen.
pub struct Seen {
    /// As in [`ray`]; outside of the picture's rectangle where the point is not in it.
    pub pixel: DVec2,
    /// Where the camera's ray to it starts.
    pub origin: DVec3,
}

/// `None` for what is not in front of the camera.
pub fn project(camera: &Camera, resolution: [u32; 2], point: DVec3) -> Option<Seen> {
    let [width, height] = resolution.map(f64::from);
    let [right, up, forward] = [camera.right, camera.up, camera.forward].map(|v| v.as_dvec3());
    let offset = point - camera.position;
    let depth = offset.dot(forward);
    if depth <= 0.0 {
        return None;
    }
    let half = half_extents(camera, resolution);
    let (plane, origin) = match camera.projection {
        Projection::Perspective { .. } => (offset / depth, camera.position),
        Projection::Orthographic { .. } => (offset, point - depth * forward),
    };
    let (across, above) = (plane.dot(right) / half.x, plane.dot(up) / half.y);
    Some(Seen { pixel: DVec2::new(0.5 * (across + 1.0) * width, 0.5 * (1.0 - above) * height), origin })
}

/// Density of the ray towards `direction` (unit, away from the camera) when the film's point is uniform in one pixel: per
/// solid angle for a perspective camera, per area across the ray for a parallel one.
pub fn pixel_pdf(camera: &Camera, resolution: [u32; 2], direction: DVec3) -> f64 {
    let [width, height] = resolution.map(f64::from);
    let half = half_extents(camera, resolution);
    let pixel_area = (2.0 * half.x / width) * (2.0 * half.y / height);
    match camera.projection {
        Projection::Perspective { .. } => {
            let cos = direction.dot(camera.forward.as_dvec3());
            1.0 / (pixel_area * cos.powi(3))
        }
        Projection::Orthographic { .. } => 1.0 / pixel_area,
    }
}

/// Half the picture's extents, of a perspective camera on the plane at distance 1.
fn half_extents(camera: &Camera, resolution: [u32; 2]) -> DVec2 {
    let [width, height] = resolution.map(f64::from);
    match camera.projection {
        Projection::Perspective { yfov } => {
            let half_height = (0.5 * f64::from(yfov)).tan();
            DVec2::new(half_height * width / height, half_height)
        }
        Projection::Orthographic { xmag, ymag } => DVec2::new(xmag.into(), ymag.into()),
    }
}
