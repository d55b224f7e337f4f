//! Colours are linear Rec.709; mirrors `lib/color.wgsl`.

use glam::Vec3;

/// Relative luminance, ITU-R BT.709.
pub fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
