//! The ray through a point of the picture.

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
