//! What a method cannot show of a scene, and what it cannot know of its own error.

use super::glossy::{caustics, names};
use crate::integrator::Plan;
use crate::scene::Scene;

/// What users have to know of pictures of this scene by such a method, a line each; `parallel`: of the camera's rays.
pub fn caveats(scene: &Scene, parallel: bool, plan: &Plan) -> Vec<String> {
    let only_light_paths = plan.to_camera && plan.selector.is_none();
    if only_light_paths { unreachable(scene, parallel) } else { unknown(scene, plan).into_iter().collect() }
}

/// What light paths cannot be connected to the camera from.
fn unreachable(scene: &Scene, parallel: bool) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(names) = names(scene, |material| material.is_delta() || material.unlit) {
        lines.push(format!(
            "light paths reach no pixel that shows a mirror, clear glass or an unlit surface: {names} will be black; take \
             another integrator, or give these materials some roughness"
        ));
    }
    if scene.environment.is_some() && parallel {
        lines.push(
            "light paths do not reach an orthographic camera, or one as far away, from the environment: it will be black; take \
             another integrator"
                .into(),
        );
    }
    lines
}

/// Light that eye paths may never find, so that its absence is in no estimate.
fn unknown(scene: &Scene, plan: &Plan) -> Option<String> {
    if plan.to_camera {
        return None;
    }
    let names = caustics(scene)?;
    let remedy = match plan.selector {
        Some(_) => "add --light-tracing",
        None => "compare with `-i bdpt --light-tracing`",
    };
    Some(format!(
        "light that reaches other surfaces by way of smooth ones ({names}) is found by accident or not at all without \
         connections to the camera: the picture may lack some of it (caustics), and the estimated error cannot know; {remedy}"
    ))
}
