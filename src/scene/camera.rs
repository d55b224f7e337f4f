//! Cameras.

use glam::{DVec3, Vec3};

use super::Bounds;

/// A pinhole or parallel camera. `right`, `up` and `forward` are orthonormal; the picture's x runs along `right`,
/// its y runs down.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    pub name: String,
    /// World position, scene units.
    pub position: DVec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    pub projection: Projection,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `yfov`: full vertical field of view in radians; the horizontal one follows from the picture's own aspect.
    Perspective { yfov: f32 },
    /// Half extents in scene units.
    Orthographic { xmag: f32, ymag: f32 },
}

impl Projection {
    /// A field of view given in degrees, above 0 and below 180. `None`: out of that range, to `f32`'s precision.
    pub fn perspective(degrees: f64) -> Option<Self> {
        let yfov = degrees.to_radians() as f32;
        // The constant is above pi: half of it has a negative tangent.
        (yfov > 0.0 && yfov < std::f32::consts::PI).then_some(Self::Perspective { yfov })
    }

    /// An orthographic projection of the same shape that shows `height` scene units. `None`: it is a perspective one, or
    /// half the height is out of `f32`'s range.
    pub fn with_height(self, height: f64) -> Option<Self> {
        let Self::Orthographic { xmag, ymag } = self else { return None };
        let tall = (0.5 * height) as f32;
        // Exact where the height is the old one: the product has 48 bits.
        let wide = (f64::from(xmag) * f64::from(tall) / f64::from(ymag)) as f32;
        let valid = |extent: f32| extent > 0.0 && extent.is_finite();
        (valid(tall) && valid(wide)).then_some(Self::Orthographic { xmag: wide, ymag: tall })
    }

    /// Scene units from the top of the picture to its bottom, `distance` in front of the camera.
    pub fn height_at(self, distance: f64) -> f64 {
        match self {
            Self::Perspective { yfov } => 2.0 * distance * (0.5 * f64::from(yfov)).tan(),
            Self::Orthographic { ymag, .. } => 2.0 * f64::from(ymag),
        }
    }
}

/// A camera by the point where it stands and the one that it looks at: the words of the command line. Equal poses make
/// cameras that are equal bit for bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// World position, scene units.
    pub from: DVec3,
    /// A point in the middle of the picture, scene units.
    pub at: DVec3,
    /// The direction that is up in the picture, as far as it is perpendicular to that of looking; of any length.
    pub up: DVec3,
    pub projection: Projection,
}

impl Pose {
    /// `None`: the two points are the same, `up` runs along the line between them, or something is not finite.
    pub fn camera(&self, name: &str) -> Option<Camera> {
        // By halves, as the difference of finite points may not be finite.
        let forward = direction(0.5 * self.at - 0.5 * self.from)?;
        let across = forward.cross(direction(self.up)?);
        // Below that, what is left is the rounding of the points.
        if across.length() < 1e-10 {
            return None;
        }
        let right = across.normalize();
        let up = right.cross(forward).normalize();
        Some(Camera {
            name: name.into(),
            position: self.from,
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            projection: self.projection,
        })
    }
}

/// The unit vector along one of any length, if it has a direction.
fn direction(vector: DVec3) -> Option<DVec3> {
    (vector / vector.abs().max_element()).try_normalize()
}

impl Camera {
    /// The point in the middle of the picture, `distance` scene units in front of the camera.
    pub fn point_ahead(&self, distance: f64) -> DVec3 {
        self.position + self.forward.as_dvec3() * distance
    }

    /// A camera in front of the scene (+z), slightly above, that sees its whole bounding sphere.
    pub fn framing(bounds: &Bounds) -> Self {
        let yfov = 40f32.to_radians();
        let back = Vec3::new(0.0, 0.35, 1.0).normalize();
        let right = Vec3::X;
        Self {
            name: "framing".into(),
            position: bounds.centre() + back.as_dvec3() * bounds.radius() / f64::from(0.5 * yfov).sin(),
            right,
            up: back.cross(right),
            forward: -back,
            projection: Projection::Perspective { yfov },
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LENS: Projection = Projection::Perspective { yfov: 0.7 };

    fn pose(from: DVec3, at: DVec3, up: DVec3) -> Pose {
        Pose { from, at, up, projection: LENS }
    }

    #[test]
    fn a_pose_looks_where_it_says() {
        let camera = pose(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, -4.0), DVec3::new(0.0, 9.0, 5.0));
        let camera = camera.camera("here").unwrap();
        assert_eq!((camera.right, camera.up, camera.forward), (Vec3::X, Vec3::Y, Vec3::NEG_Z));
        assert_eq!((camera.name.as_str(), camera.projection), ("here", LENS));
        assert_eq!(camera.point_ahead(7.0), DVec3::new(1.0, 2.0, -4.0));
    }

    #[test]
    fn what_leaves_no_direction_is_refused() {
        let at = DVec3::new(0.3, 1.5, -2.0);
        for (from, up) in [
            (at, DVec3::Y),
            (at + DVec3::Y, DVec3::Y),
            (at + DVec3::new(0.1, 0.2, 0.3), DVec3::new(-1.0, -2.0, -3.0)),
            (at + DVec3::X, DVec3::ZERO),
            (at + DVec3::X, DVec3::NAN),
            (DVec3::INFINITY, DVec3::Y),
        ] {
            assert_eq!(pose(from, at, up).camera(""), None, "{from} {up}");
        }
    }

    proptest! {
        #[test]
        fn axes_are_orthonormal_at_any_scale(
            exponent in -150..150i32,
            from in prop::array::uniform3(-1.0..1.0f64),
            at in prop::array::uniform3(-1.0..1.0f64),
            up in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let scale = 10f64.powi(exponent);
            let [from, at, up] = [from, at, up].map(DVec3::from);
            prop_assume!(from.distance(at) > 1e-3 && up.length() > 1e-3);
            prop_assume!((at - from).normalize().cross(up.normalize()).length() > 1e-3);
            let camera = pose(from * scale, at * scale, up / scale).camera("").unwrap();
            let (right, up, forward) = (camera.right, camera.up, camera.forward);
            for (a, b) in [(right, up), (up, forward), (forward, right)] {
                prop_assert!(a.dot(b).abs() < 2e-7 && (a.length() - 1.0).abs() < 2e-7);
            }
            prop_assert!(right.cross(up).dot(forward) < -0.999_999);
            prop_assert!((camera.forward.as_dvec3() - (at - from).normalize()).length() < 1e-7);
        }
    }
}
