//! Local frames, z is the normal; mirrors `lib/frame.wgsl` and `safe_normalize` of `lib/math.wgsl`.

use glam::Vec3;

/// A right-handed orthonormal frame in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub tangent: Vec3,
    pub bitangent: Vec3,
    pub normal: Vec3,
}

impl Frame {
    /// A frame about a unit normal: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017,
    /// listing 3.
    pub fn from_normal(normal: Vec3) -> Self {
        let side = if normal.z >= 0.0 { 1.0 } else { -1.0 };
        let a = -1.0 / (side + normal.z);
        let b = normal.x * normal.y * a;
        Self {
            tangent: Vec3::new(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
            bitangent: Vec3::new(b, side + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    pub fn to_local(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }

    pub fn to_world(&self, local: Vec3) -> Vec3 {
        local.x * self.tangent + local.y * self.bitangent + local.z * self.normal
    }
}

/// v / |v| for every finite v whose largest component is at least 2^-126; the zero vector below that; v itself
/// where it is not finite, so that the fault stays visible.
pub fn safe_normalize(v: Vec3) -> Vec3 {
    let exponent = v.to_array().map(|c| c.to_bits() & 0x7f80_0000).into_iter().fold(0, u32::max);
    if exponent == 0x7f80_0000 {
        return v;
    }
    if exponent == 0 {
        return Vec3::ZERO;
    }
    // The power of two that brings the largest component into [1, 2), or into [2, 4) at the top of the range.
    let scaled = v * f32::from_bits((0x7f00_0000 - exponent).max(0x0080_0000));
    scaled / scaled.dot(scaled).sqrt()
}
