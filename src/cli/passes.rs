//! Layers that are renders of their own: the light of each group of lights, and direct light. Light adds up, so a picture is
//! the sum of those that its lights make one by one.

use super::args::InputError;
use super::progress;
use crate::device::Context;
use crate::film::Picture;
use crate::integrator::View;
use crate::render::{Budget, RenderError, RenderOptions, Renderer, Report, SeenLayers, Stop, TimeLimit};
use crate::scene::{LightGroup, Scene, SceneFeatures};

/// Surfaces of paths that are direct light, or light that is seen itself.
const DIRECT_DEPTH: u32 = 2;

/// From the seed of one group to the next: an odd number that no user's seeds are apart.
const SEED_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// The groups of a scene that is to be rendered group by group.
///
/// # Errors
/// There is no light.
pub fn groups(scene: &Scene) -> Result<Vec<LightGroup>, InputError> {
    let groups = LightGroup::of(scene);
    if groups.is_empty() {
        return Err(InputError::Usage(
            "--light-groups needs a light, and the scene has none; leave it out".into(),
        ));
    }
    Ok(groups)
}

/// The options for one of so many groups: a share of the time, and kernels that are the same for all.
pub fn of_group(options: &RenderOptions, scene: &Scene, groups: usize) -> RenderOptions {
    let share = |time: TimeLimit| match time {
        TimeLimit::Total(time) => TimeLimit::Total(time / groups as u32),
        TimeLimit::Rendering(time) => TimeLimit::Rendering(time / groups as u32),
    };
    let budget = Budget { time: options.budget.time.map(share), ..options.budget };
    RenderOptions { budget, features: Some(SceneFeatures::of(scene)), ..options.clone() }
}

/// Renders the groups after the first, of which there is a picture already, and makes all of them layers of their sum. The
/// report then has the time of all, and the least number of samples.
///
/// # Errors
/// What rendering reports.
pub fn add_groups(
    context: &Context,
    scene: &Scene,
    groups: &[LightGroup],
    options: &RenderOptions,
    first: Picture,
    report: &mut Report,
) -> Result<Picture, RenderError> {
    let mut sum = first;
    push_layer(&mut sum, &layer_of(&groups[0]), None);
    for (index, group) in groups.iter().enumerate().skip(1) {
        // Errors of groups are to be independent, or their variances would not add up.
        let seed = options.view.seed.wrapping_add(SEED_STEP.wrapping_mul(index as u64));
        let view = View { seed, ..options.view };
        let layers = SeenLayers::default();
        let options = RenderOptions { view, first_hit_layers: false, seen: layers, ..options.clone() };
        let mut renderer = Renderer::new(context, &group.alone(scene), options)?;
        let stop = renderer.run(|_| progress::interrupted())?;
        let (other, its_report) = (renderer.radiance()?, renderer.report()?);
        report.seconds += its_report.seconds;
        report.preprocessing_seconds += its_report.preprocessing_seconds;
        report.samples = report.samples.min(its_report.samples);
        report.non_finite += its_report.non_finite;
        push_layer(&mut sum, &layer_of(group), Some(&other));
        add(&mut sum, &other);
        if stop == Stop::Interrupted {
            report.stop = stop;
        }
    }
    // An estimate of one group is none of the sum.
    report.estimated_error = None;
    Ok(sum)
}

fn layer_of(group: &LightGroup) -> String {
    // A dot would make a layer within a layer.
    format!("light.{}", group.name.replace('.', "_"))
}

/// Adds a layer with the colours of another picture, or of its own.
fn push_layer(picture: &mut Picture, layer: &str, other: Option<&Picture>) {
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let colors = other.map_or(&picture.rgb, |other| &other.rgb);
        let values = colors.iter().map(|pixel| pixel[channel]).collect();
        picture.push_channel(layer, name, values);
    }
}

/// Adds the light of another picture, and the variance that comes with it.
fn add(sum: &mut Picture, other: &Picture) {
    let variances = sum.variance().zip(other.variance()).map(|(a, b)| {
        [0, 1, 2].map(|channel| {
            (0..a.pixels()).map(|pixel| a.at(channel, pixel) + b.at(channel, pixel)).collect::<Vec<f64>>()
        })
    });
    for (a, b) in sum.rgb.iter_mut().zip(&other.rgb) {
        *a = [0, 1, 2].map(|channel| a[channel] + b[channel]);
    }
    sum.layers.retain(|layer| layer.name != "variance");
    if let Some(variances) = variances {
        sum.push_variance(variances);
    }
}

/// Renders direct light once more, with as many samples, and adds it and what is left of the picture as layers.
///
/// # Errors
/// What rendering reports.
pub fn add_direct(
    context: &Context,
    scene: &Scene,
    options: &RenderOptions,
    picture: &mut Picture,
    report: &mut Report,
) -> Result<(), RenderError> {
    let depth = options.view.max_depth.map_or(DIRECT_DEPTH, |depth| depth.min(DIRECT_DEPTH));
    let options = RenderOptions {
        view: View { max_depth: Some(depth), ..options.view },
        budget: Budget { samples: Some(report.samples), ..Budget::default() },
        first_hit_layers: false,
        seen: SeenLayers::default(),
        ..options.clone()
    };
    let mut renderer = Renderer::new(context, scene, options)?;
    renderer.run(|_| progress::interrupted())?;
    let direct = renderer.radiance()?;
    report.seconds += renderer.elapsed().as_secs_f64();
    push_layer(picture, "direct", Some(&direct));
    let rest = picture.rgb.iter().zip(&direct.rgb).map(|(all, direct)| [0, 1, 2].map(|c| all[c] - direct[c]));
    let rest = Picture::new(picture.width, picture.height, rest.collect());
    push_layer(picture, "indirect", Some(&rest));
    Ok(())
}
