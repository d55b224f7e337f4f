//! How large the scene is, and where.

use glam::DVec3;

/// A box along the axes, scene units; a point where nothing has an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    /// The box around all points; the origin where there are none.
    pub fn of(points: impl Iterator<Item = DVec3>) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            low = low.min(point);
            high = high.max(point);
        }
        match low.is_finite() {
            true => Self { low, high },
            false => Self { low: DVec3::ZERO, high: DVec3::ZERO },
        }
    }

    pub fn centre(&self) -> DVec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// The radius of the sphere around the box; 1 around a point, so that cameras have something to frame.
    pub fn radius(&self) -> f64 {
        if self.high == self.low { 1.0 } else { (0.5 * self.high - 0.5 * self.low).length() }
    }
}
