//! Cameras and punctual lights: what nodes carry besides meshes.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use glam::{DAffine3, DVec3, Vec3};
use serde::Deserialize;
use serde_json::Value;

use super::document::{self, Extensions, extension};
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
    source: &document::Camera,
    name: &str,
    world: &DAffine3,
    place: &str,
) -> Result<Camera, SceneError> {
    let fault = |detail: String| SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
    let projection = match (source.kind.as_str(), &source.perspective, &source.orthographic) {
        ("perspective", Some(perspective), _) => {
            let yfov = perspective.yfov;
            if !(yfov > 0.0 && yfov < PI) {
                return Err(fault(format!("yfov {yfov} is not between 0 and pi")));
            }
            Projection::Perspective { yfov: yfov as f32 }
        }
        ("orthographic", _, Some(orthographic)) => {
            let (xmag, ymag) = (orthographic.xmag as f32, orthographic.ymag as f32);
            // Negative magnifications would mirror the picture; the specification advises against them.
            if !(xmag > 0.0 && xmag.is_finite() && ymag > 0.0 && ymag.is_finite()) {
                return Err(fault(format!("xmag {xmag} and ymag {ymag} must be positive")));
            }
            Projection::Orthographic { xmag, ymag }
        }
        (kind, ..) => {
            return Err(SceneError::invalid(
                place,
                "UNDEFINED_PROPERTY",
                format!("a camera of type \"{kind}\" without its properties"),
            ));
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

const PUNCTUAL: &str = "KHR_lights_punctual";

/// One light of the root's `KHR_lights_punctual` list.
#[derive(Debug, Deserialize)]
struct Light {
    name: Option<String>,
    #[serde(rename = "type")]
    kind: String,
    color: Option<[f64; 3]>,
    intensity: Option<f64>,
    /// Present: light ends at this distance, which is not physical and left out.
    range: Option<f64>,
    spot: Option<Spot>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Spot {
    inner_cone_angle: Option<f64>,
    outer_cone_angle: Option<f64>,
}

#[derive(Deserialize)]
struct LightList {
    lights: Vec<Value>,
}

#[derive(Deserialize)]
struct LightReference {
    light: u64,
}

/// The lights that nodes refer to, not read yet: one that is malformed does not concern the others.
pub fn light_list(root: &Extensions) -> Result<Vec<Value>, SceneError> {
    Ok(extension::<LightList>(root, PUNCTUAL, "root")?.map_or_else(Vec::new, |list| list.lights))
}

/// The index of the light that a node carries.
pub fn light_of(node: &Extensions, place: &str) -> Result<Option<u64>, SceneError> {
    Ok(extension::<LightReference>(node, PUNCTUAL, place)?.map(|reference| reference.light))
}

/// A punctual light at a node.
///
/// # Errors
/// Malformed lights, unknown types, negative intensities; where strict, cone angles not `0 <= inner < outer <= pi/2`.
pub fn light(
    source: &Value,
    world: &DAffine3,
    place: &str,
    faults: &mut Faults,
) -> Result<PunctualLight, SceneError> {
    let source = Light::deserialize(source)
        .map_err(|error| SceneError::invalid(place, "TYPE_MISMATCH", format!("cannot read it: {error}")))?;
    let fault = |detail: String| SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
    let kind = match source.kind.as_str() {
        "point" => LightKind::Point,
        "directional" => LightKind::Directional,
        "spot" => cone(source.spot.as_ref(), place, faults)?,
        other => return Err(fault(format!("light type \"{other}\" is unknown"))),
    };
    if source.range.is_some() {
        faults.note(place, "its range is ignored", "it lights any distance");
    }
    let intensity = source.intensity.unwrap_or(1.0);
    let color = DVec3::from(source.color.unwrap_or([1.0; 3])) * intensity;
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
        name: source.name.unwrap_or_else(|| place.into()),
        kind,
        intensity: narrow,
        position: world.translation,
        direction,
    })
}

/// The cone of a spot light. Angles beyond their range are cut to it: an inner one that is not below the outer one is
/// the hard edge that exporters mean by it.
fn cone(spot: Option<&Spot>, place: &str, faults: &mut Faults) -> Result<LightKind, SceneError> {
    let inner = spot.and_then(|spot| spot.inner_cone_angle).unwrap_or(0.0);
    let outer = spot.and_then(|spot| spot.outer_cone_angle).unwrap_or(FRAC_PI_4);
    let largest = FRAC_PI_2 as f32;
    let (mut narrow_inner, mut narrow_outer) = (inner as f32, outer as f32);
    // Exporters write pi/2 rounded up to single precision.
    if !(inner >= 0.0 && inner < outer && narrow_outer <= largest) {
        let detail = format!("cone angles {inner} and {outer} are not 0 <= inner < outer <= pi/2");
        let error = SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail);
        if outer <= 0.0 {
            return Err(error);
        }
        narrow_outer = narrow_outer.min(largest);
        narrow_inner = narrow_inner.clamp(0.0, narrow_outer);
        let remedy = format!("they are cut to {narrow_inner} and {narrow_outer}");
        faults.tolerate(place, error, &remedy)?;
    }
    Ok(LightKind::Spot { inner: narrow_inner, outer: narrow_outer })
}
