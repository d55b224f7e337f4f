//! How large the scene is, and where.

use glam::DVec3;

use super::Scene;

/// A box along the axes, scene units; a point where nothing has an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    pub fn centre(&self) -> DVec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// The radius of the sphere around the box; 1 around a point, so that cameras have something to frame.
    pub fn radius(&self) -> f64 {
        if self.high == self.low { 1.0 } else { (0.5 * self.high - 0.5 * self.low).length() }
    }
}

impl Scene {
    /// The box around all vertices; the origin where there are none.
    pub fn bounds(&self) -> Bounds {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for position in self.meshes.iter().flat_map(|mesh| &mesh.positions) {
            low = low.min(*position);
            high = high.max(*position);
        }
        match low.is_finite() {
            true => Bounds { low, high },
            false => Bounds { low: DVec3::ZERO, high: DVec3::ZERO },
        }
    }
}
