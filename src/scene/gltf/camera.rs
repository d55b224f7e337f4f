//! Cameras and punctual lights: what nodes carry besides meshes.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{DAffine3, DVec3, Vec3};
use gltf::json;
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Spot, Type as LightType};
use gltf::json::validation::Checked;

use super::faults::Faults;
use crate::scene::SceneError;
use crate::scene::camera::{Camera, Projection};
use crate::scene::light::{LightKind, PunctualLight};

/// A glTF camera at a node. Only the node's rotation and translation count: it looks along the node's -z, with
/// the part of its y that is perpendicular to that as up. Depth ranges and `aspectRatio` are left out; the picture's
/// own aspect is used.
///
/// # Errors
/// A camera without its projection, angles and extents out of range, a node transform without an orientation.
pub fn camera(
    source: &json::Camera,
    name: &str,
    world: &DAffine3,
    place: &str,
) -> Result<Camera, SceneError> {
    let fault = |detail: String| SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
    let projection = match (&source.type_, &source.perspective, &source.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(perspective), _) => {
            let yfov = perspective.yfov;
            if !(yfov > 0.0 && yfov < PI) {
                return Err(fault(format!("yfov {yfov} is not between 0 and pi")));
            }
            Projection::Perspective { yfov }
        }
        (Checked::Valid(CameraType::Orthographic), _, Some(orthographic)) => {
            let (xmag, ymag) = (orthographic.xmag, orthographic.ymag);
            // Negative magnifications would mirror the picture; the specification advises against them.
            if !(xmag > 0.0 && xmag.is_finite() && ymag > 0.0 && ymag.is_finite()) {
                return Err(fault(format!("xmag {xmag} and ymag {ymag} must be positive")));
            }
            Projection::Orthographic { xmag, ymag }
        }
        _ => {
            let detail = "it is neither a perspective nor an orthographic camera with its properties";
            return Err(SceneError::invalid(place, "UNDEFINED_PROPERTY", detail));
        }
    };
    let axes = world.matrix3;
    let orientation = (-axes.z_axis).try_normalize().and_then(|forward| {
        let up = axes.y_axis.try_normalize()?;
        let up = (up - forward * up.dot(forward)).try_normalize()?;
        Some((forward, up))
    });
    let Some((forward, up)) = orientation else {
        return Err(fault("the transform of its node leaves it no direction to look in".into()));
    };
    Ok(Camera {
        name: name.into(),
        position: world.translation,
        right: forward.cross(up).as_vec3(),
        up: up.as_vec3(),
        forward: forward.as_vec3(),
        projection,
    })
}

/// A punctual light at a node.
///
/// # Errors
/// Malformed lights, unknown types, negative intensities; where strict, cone angles not `0 <= inner < outer <= pi/2`.
pub fn light(
    source: &Light,
    world: &DAffine3,
    place: &str,
    faults: &mut Faults,
) -> Result<PunctualLight, SceneError> {
    let fault = |detail: String| SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
    let kind = match source.type_ {
        Checked::Valid(LightType::Point) => LightKind::Point,
        Checked::Valid(LightType::Directional) => LightKind::Directional,
        Checked::Valid(LightType::Spot) => cone(source.spot.as_ref(), place, faults)?,
        Checked::Invalid => return Err(fault("its type is none of point, spot and directional".into())),
    };
    if source.range.is_some() {
        faults.note(place, "its range is ignored", "it lights any distance");
    }
    // What overflows in single precision is seen below.
    let color = Vec3::from(source.color).as_dvec3() * f64::from(source.intensity);
    let narrow = color.as_vec3();
    if !(color.cmpge(DVec3::ZERO).all() && narrow.is_finite()) {
        return Err(fault(format!("colour times intensity is {color}")));
    }
    let direction = match kind {
        LightKind::Point => Vec3::NEG_Z,
        _ => (-world.matrix3.z_axis)
            .try_normalize()
            .ok_or_else(|| fault("the transform of its node leaves it no direction".into()))?
            .as_vec3(),
    };
    Ok(PunctualLight {
        name: source.name.clone().unwrap_or_else(|| place.into()),
        kind,
        intensity: narrow,
        position: world.translation,
        direction,
    })
}

/// The cone of a spot light. Angles beyond their range are cut to it: an inner one that is not below the outer one is
/// the hard edge that exporters mean by it.
fn cone(spot: Option<&Spot>, place: &str, faults: &mut Faults) -> Result<LightKind, SceneError> {
    let inner = spot.map_or(0.0, |spot| spot.inner_cone_angle);
    let outer = spot.map_or(FRAC_PI_4, |spot| spot.outer_cone_angle);
    // Exporters write pi/2 rounded up to single precision.
    if !(inner >= 0.0 && inner < outer && outer <= FRAC_PI_2) {
        let detail = format!("cone angles {inner} and {outer} are not 0 <= inner < outer <= pi/2");
        let error = SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
        if outer <= 0.0 {
            return Err(error);
        }
        let outer = outer.min(FRAC_PI_2);
        let inner = inner.clamp(0.0, outer);
        faults.tolerate(place, error, &format!("they are cut to {inner} and {outer}"))?;
        return Ok(LightKind::Spot { inner, outer });
    }
    Ok(LightKind::Spot { inner, outer })
}
