//! Whether a scene's rays are traced by kernels or by ray queries, where that is to be chosen: by what both make of rays of
//! the scene's own.

use std::time::Duration;

use super::RenderError;
use super::rays::{RaySet, RayTracer, further_rays, primary_rays};
use crate::accel::Accel;
use crate::device::layout::{Camera, Hit};
use crate::device::scene::{DeviceScene, Tracing};
use crate::device::{Context, Feature};
use crate::integrator::Choice;
use crate::scene::Scene;

/// Of the picture whose rays are traced: enough of them to keep a GPU busy.
const SIZE: [u32; 2] = [512, 512];
/// What both take together for the rays of each kind.
const TRIAL: Duration = Duration::from_millis(40);
/// How much faster ray queries have to be: a trial that ends about even would choose now this and now that, and the bits of
/// pictures with it.
const CLEARLY: f64 = 1.1;
/// Of this many rays one may be found to hit something else: at edges, where rounding decides.
const ONE_DIFFERS: usize = 1000;
/// Distances agree within this part of them, and of unit space.
const ROUNDING: f32 = 1e-4;

/// Settles what is still open, and says what was chosen where there was a choice.
///
/// # Errors
/// What the layers below report.
pub fn settle(
    context: &Context,
    device_scene: &mut DeviceScene,
    scene: &Scene,
    accel: &Accel,
) -> Result<Option<Choice>, RenderError> {
    if device_scene.tracing == Tracing::Open {
        let tracing = choose(context, device_scene, scene, accel)?;
        device_scene.settle(tracing);
    }
    let (value, reason) = match &device_scene.tracing {
        Tracing::Hardware { reason } => ("hardware", reason),
        Tracing::Compute { reason } => ("compute", reason),
        Tracing::Open => return Ok(None),
    };
    Ok(reason.as_ref().map(|reason| Choice::new("traversal", value, reason.as_str())))
}

/// What traces the scene's rays faster, where both find the same.
fn choose(
    context: &Context,
    device_scene: &DeviceScene,
    scene: &Scene,
    accel: &Accel,
) -> Result<Tracing, RenderError> {
    let by_kernels = |reason: String| Ok(Tracing::Compute { reason: Some(reason) });
    let Some(camera) = scene.cameras.first() else {
        return by_kernels("the scene has no camera to try ray queries from".into());
    };
    let [width, height] = SIZE;
    let primary = primary_rays(&Camera::new(&device_scene.unit, camera, width, height), SIZE);
    let rays = primary.rays.len() as u64;
    let compute = RayTracer::new(context, device_scene, &[], rays)?;
    let hardware = match RayTracer::new(context, device_scene, &[Feature::RayQuery], rays) {
        Ok(hardware) => hardware,
        Err(error) => return by_kernels(format!("ray queries do not work here: {error}")),
    };
    let hits = compute.hits(context, &primary)?;
    let [bounce, shadow] = further_rays(accel, &primary, &hits);
    let mut differing = different(&hits, &hardware.hits(context, &primary)?);
    let mut traced = primary.rays.len();
    if !bounce.rays.is_empty() {
        differing += different(&compute.hits(context, &bounce)?, &hardware.hits(context, &bounce)?);
        let [ours, theirs] = [compute.occluded(context, &shadow)?, hardware.occluded(context, &shadow)?];
        differing += ours.iter().zip(&theirs).filter(|(a, b)| a != b).count();
        traced += bounce.rays.len() + shadow.rays.len();
    }
    if differing * ONE_DIFFERS > traced {
        return by_kernels(format!("ray queries find something else for {differing} of {traced} rays"));
    }
    let mut seconds = [0.0; 2];
    for set in [&primary, &bounce, &shadow].into_iter().filter(|set| !set.rays.is_empty()) {
        let [ours, theirs] = seconds_of(context, [&compute, &hardware], set)?;
        seconds[0] += ours;
        seconds[1] += theirs;
    }
    let ratio = seconds[0] / seconds[1];
    let reason = Some(format!("in a trial ray queries were {ratio:.2} times as fast as kernels"));
    Ok(match ratio > CLEARLY {
        true => Tracing::Hardware { reason },
        false => Tracing::Compute { reason },
    })
}

/// Rays for which two tracers found different things.
fn different(ours: &[Hit], theirs: &[Hit]) -> usize {
    ours.iter().zip(theirs).filter(|(a, b)| differs(a, b)).count()
}

/// Neighbours at an edge, and surfaces that meet, are the same as far as a ray can tell.
fn differs(a: &Hit, b: &Hit) -> bool {
    let close = (a.t - b.t).abs() <= ROUNDING * (1.0 + a.t.abs());
    a.triangle != b.triangle && !close
}

/// The best time of each for a set, turn by turn.
fn seconds_of(context: &Context, tracers: [&RayTracer; 2], set: &RaySet) -> Result<[f64; 2], RenderError> {
    let mut best = [f64::INFINITY; 2];
    let mut left = TRIAL.as_secs_f64();
    for tracer in tracers {
        tracer.load(context, set)?;
    }
    while left > 0.0 {
        for (best, tracer) in best.iter_mut().zip(tracers) {
            let seconds = tracer.dispatch(context, set)?;
            *best = best.min(seconds);
            left -= seconds;
        }
    }
    Ok(best)
}
