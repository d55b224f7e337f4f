//! Spot lights of any cone: the light that arrives is their flux, and falls off as glTF's formula says.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use halfway::integrator::{Bdpt, Connections, LightTracing, LvcBpt, Method, SpcBpt, View};
use halfway::render::RenderOptions;
use halfway::scene::{Camera, LightKind, Projection, PunctualLight, Scene};

use crate::bidirectional::{mean, renders};
use crate::judge::{grey, horizontal, scene};
use crate::shots::options;
use crate::stats::Moments;

const ALBEDO: f64 = 0.5;
const DISTANCE: f64 = 0.8;

/// 1 - cos, to the last digits of a small angle.
fn one_minus_cos(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// Flux of a cone of intensity 1: the integral of the square of a ramp between the cosines of both half angles.
fn flux([inner, outer]: [f32; 2]) -> f64 {
    let [core, all] = [inner, outer].map(|angle| one_minus_cos(f64::from(angle)));
    TAU * (core + (all - core) / 3.0)
}

/// A floor that a spot lights from above at a slant, and a camera above it that sees the lit part and little else. The
/// mean radiance is albedo / pi times the flux over the area that the camera sees.
fn lit(cone: [f32; 2]) -> (Scene, f64) {
    let mut scene = scene([(grey(ALBEDO as f32), horizontal(4.0, 0.0, true))]);
    let towards = DVec3::new(-0.1, -1.0, 0.15).normalize();
    let centre = DVec3::new(0.1, 0.0, -0.2);
    scene.lights = vec![PunctualLight {
        name: "spot".into(),
        kind: LightKind::Spot { inner: cone[0], outer: cone[1] },
        intensity: Vec3::ONE,
        position: centre - DISTANCE * towards,
        direction: towards.as_vec3(),
    }];
    // The light's axis is at 0.18 rad to the vertical, so its ellipse is hardly longer than a circle.
    let half = 1.25 * DISTANCE * f64::from(cone[1]).tan();
    scene.cameras = vec![Camera {
        name: "above".into(),
        position: centre + 0.5 * DVec3::Y,
        right: Vec3::X,
        up: Vec3::NEG_Z,
        forward: Vec3::NEG_Y,
        projection: Projection::Orthographic { xmag: half as f32, ymag: half as f32 },
    }];
    (scene, ALBEDO / PI * flux(cone) / (4.0 * half * half))
}

#[track_caller]
fn assert_flux(cone: [f32; 2], method: Method, samples: u32) {
    let (scene, expected) = lit(cone);
    let size = options([32, 32], samples);
    let options = RenderOptions { view: View { max_depth: Some(2), ..size.view }, method, ..size };
    let means: Moments = renders(&scene, &options, 0..8).iter().map(|picture| mean(picture)).collect();
    let (found, error) = (means.mean / expected, means.standard_error() / expected);
    println!("{}, cone of {cone:?}: {found:.4} +- {error:.4} of its flux", method.name());
    assert!(
        error < 1e-3,
        "{}, cone of {cone:?}: {error:e} is too large to judge half a percent",
        method.name()
    );
    assert!((found - 1.0).abs() < 0.005, "{}, cone of {cone:?}: {found:.4} of its flux", method.name());
}

#[test]
fn a_spot_sends_its_flux_whatever_its_cone() {
    for cone in
        [[0.0, 0.5], [0.0, 0.035], [0.0, 1e-3], [0.0, 1e-4], [0.0, 2e-5], [0.0, 5e-6], [9.999e-5, 1e-4]]
    {
        assert_flux(cone, Method::Path, 16);
    }
    let light = Method::Light(LightTracing { light_paths: None });
    for cone in [[0.034, 0.035], [0.0, 1e-4]] {
        assert_flux(cone, light, 16);
    }
}

/// Hard edges, where both angles are one or differ by less than the rounding of their cosines.
#[test]
fn a_spot_with_a_hard_edge_sends_its_flux() {
    let light = Method::Light(LightTracing { light_paths: None });
    for cone in [[0.4, 0.4], [0.4, 0.4 + 3e-8], [1e-3, 1e-3]] {
        assert_flux(cone, Method::Path, 16);
        assert_flux(cone, light, 16);
    }
}

#[test]
fn bidirectional_methods_send_a_narrow_cones_flux() {
    let bdpt = Method::Bdpt(Bdpt { light_tracing: true });
    let lvcbpt = Method::LvcBpt(LvcBpt {
        light_paths: Some(1024),
        connections: Connections::even(2),
        light_tracing: true,
    });
    for method in [bdpt, lvcbpt, Method::SpcBpt(SpcBpt::default())] {
        assert_flux([0.0, 1e-3], method, 32);
    }
}
