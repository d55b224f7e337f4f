//! What a bent normal does with directions, in f64 and by angles: what `shaders/lib/bend.wgsl` is judged by.
//!
//! Both normals lie in a plane. In it, longitude is counted from the geometric normal; the shading normal is at 2 a. The
//! map from the directions above the surface, longitudes -90 to 90 degrees, onto those that the BSDF knows, 2 a - 90 to
//! 2 a + 90, keeps latitudes, and longitudes but in a band at either end. There, with the distance p from where the band
//! begins,
//!
//!   cot p' = cot p -+ (cot a - cot 3 a)
//!
//! stretches a to 3 a at the end that the normal leans to, and shrinks 3 a to a at the other one. The map is continuous,
//! its derivative begins with 1, and no direction is left out on either side: neither is light.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// Normals less apart (sine of the angle) are the same to the map, here as in the kernels.
const LEAST_SINE: f64 = 1.0 / 1024.0;

/// The two normals of a point.
#[derive(Clone, Copy, Debug)]
pub struct Normals {
    geometric: DVec3,
    /// Where longitude 90 degrees is.
    across: DVec3,
    /// a; 0 for normals that are the same.
    half: f64,
}

/// A direction that the map has moved.
#[derive(Clone, Copy, Debug)]
pub struct Moved {
    pub world: DVec3,
    /// Solid angle there for solid angle here.
    pub jacobian: f64,
}

impl Normals {
    /// Unit normals, on the same side.
    pub fn new(shading: DVec3, geometric: DVec3) -> Self {
        let apart = shading - shading.dot(geometric) * geometric;
        if apart.length() < LEAST_SINE {
            return Self { geometric, across: DVec3::ZERO, half: 0.0 };
        }
        let half = 0.5 * apart.length().atan2(shading.dot(geometric));
        Self { geometric, across: apart.normalize(), half }
    }

    /// As the BSDF knows a direction of the world.
    pub fn to_shading(self, world: DVec3) -> Moved {
        self.moved(world, world.dot(self.geometric), 1.0)
    }

    /// A direction of the world for one of the BSDF; `cos` of that to the shading normal.
    pub fn to_geometric(self, world: DVec3, cos: f64) -> Moved {
        self.moved(world, cos, -1.0)
    }

    fn moved(self, world: DVec3, side: f64, forward: f64) -> Moved {
        let Self { geometric, across, half: a } = self;
        if a == 0.0 {
            return Moved { world, jacobian: 1.0 };
        }
        let side = side.signum();
        let [x, y] = [geometric, across].map(|axis| side * world.dot(axis));
        let longitude = y.atan2(x);
        let step = forward * (1.0 / a.tan() - 1.0 / (3.0 * a).tan());
        // Where the band begins, the way it runs, and the step of the cotangent.
        let bands = [(FRAC_PI_2 - a, 1.0, -step), (3.0 * a - FRAC_PI_2, -1.0, step)];
        for (start, way, step) in bands {
            let p = (longitude - start) * way;
            if p > 0.0 {
                let moved = 1f64.atan2(1.0 / p.tan() + step);
                let (sin, cos) = (start + way * moved).sin_cos();
                let length = x.hypot(y);
                let delta = (length * cos - x) * geometric + (length * sin - y) * across;
                return Moved { world: world + side * delta, jacobian: (moved.sin() / p.sin()).powi(2) };
            }
        }
        Moved { world, jacobian: 1.0 }
    }
}
