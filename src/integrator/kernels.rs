//! Which kernels each method compiles, and for which features: known without a device, so that a test can look at the text
//! of every kernel that any scene may ask for. Debug builds check that nothing else is compiled.

use crate::device::{Feature, Features};

use super::plan::{LightPaths, Plan, Weights};

/// What all kernels of a wavefront for a plan may have in common, for a scene and a device with these features.
pub fn forms(plan: &Plan, scene: Features) -> Vec<Features> {
    if plan.light_paths == LightPaths::None {
        return vec![scene];
    }
    let mut base = scene.with(&[Feature::Bidirectional]);
    if plan.to_camera {
        base.insert(Feature::Splats);
    }
    // Without a light there is nothing to learn, and no subspaces.
    let mut forms = vec![base];
    if plan.weights == Weights::Subspaces && scene.contains(Feature::Lights) {
        forms.push(base.with(&[Feature::Subspaces]));
        forms.push(base.with(&[Feature::SubspaceDirections]));
    }
    if scene.contains(Feature::Lights) {
        match plan.weights {
            Weights::Resampling => forms.push(base.with(&[Feature::Resampling])),
            Weights::AtRecords => forms.push(base.with(&[Feature::AtRecords])),
            Weights::Ratio | Weights::Subspaces => {}
        }
    }
    if plan.thins() && !scene.contains(Feature::LambertOnly) && !scene.contains(Feature::PunctualLights) {
        let thinned: Vec<Features> = forms.iter().map(|form| form.with(&[Feature::Thinning])).collect();
        forms.extend(thinned);
    }
    if plan.shares_cache() {
        let independent: Vec<Features> =
            forms.iter().map(|form| form.with(&[Feature::Independent])).collect();
        forms.extend(independent);
    }
    let lambert =
        |form: &Features| form.contains(Feature::LambertOnly) && !form.contains(Feature::SubspaceDirections);
    let lambert: Vec<Features> = forms
        .iter()
        .filter(|form| lambert(form))
        .map(|form| form.with(&[Feature::LambertVertices]))
        .collect();
    let learning: Vec<Features> = forms
        .iter()
        .filter(|form| form.contains(Feature::Subspaces))
        .map(|form| form.with(&[Feature::Learns]))
        .collect();
    forms.extend(lambert);
    forms.extend(learning);
    forms
}

/// The kernels of a wavefront of one of the [`forms`] of a plan, each with all its features.
pub fn kernels(plan: &Plan, form: Features) -> Vec<(&'static str, Features)> {
    let mut kernels = vec![("camera_rays", form), ("closest_hit", form), ("queue_advance", form)];
    // The picture may be larger than a binding.
    let pages = [form, form.with(&[Feature::FilmPages])];
    for form in pages {
        kernels.extend([("film_accumulate", form), ("first_hit", form)]);
        if !form.contains(Feature::LambertOnly) {
            kernels.push(("first_hit", form.with(&[Feature::ThroughMirrors])));
        }
    }
    if !form.contains(Feature::LambertOnly) {
        kernels.push(("mirror_follow", form));
    }
    let lights = form.contains(Feature::Lights);
    if lights {
        kernels.extend([("shadow_advance", form), ("occlusion", form.with(&[Feature::AnyHit]))]);
    }
    let sky = form.contains(Feature::Environment).then(|| form.with(&[Feature::Transparent]));
    if !form.contains(Feature::Bidirectional) {
        kernels.push(("path_shade", form));
        kernels.extend(sky.map(|sky| ("path_shade", sky)));
        return kernels;
    }
    if plan.selector.is_some() {
        kernels.push(("eye_shade", form));
        kernels.extend(sky.map(|sky| ("eye_shade", sky)));
    }
    if !lights {
        return kernels;
    }
    let light = form.with(&light_features(plan));
    kernels.extend([("light_rays", light), ("light_shade", light)]);
    let nominal = nominal_features(plan);
    let may_guide = form.contains(Feature::Subspaces);
    if may_guide {
        let guided = light.with(&[Feature::LightGuide]).with(nominal);
        kernels.extend([("light_rays", guided), ("light_shade", guided)]);
    }
    if form.contains(Feature::Alpha) {
        kernels.push(("closest_hit", light));
    }
    if plan.to_camera {
        let splats = light.with(&[Feature::AnyHit, Feature::SplatsAtomic]);
        kernels.extend([("camera_connections", light), ("occlusion", splats)]);
        let pages = splats.with(&[Feature::FilmPages]);
        kernels.extend([("occlusion", pages), ("splat_page", pages)]);
    }
    if let Some(selector) = plan.selector {
        let connections = form.with(selector.features());
        kernels.extend([("light_scan", form), ("light_order", form), ("light_connections", connections)]);
        if may_guide && plan.to_camera {
            kernels.push(("light_connections", connections.with(nominal)));
        }
    }
    if form.contains(Feature::Subspaces) {
        let sort = ["eye_labels", "bucket_counts", "bucket_scan", "bucket_order", "bucket_tables"];
        kernels.extend(sort.map(|kernel| (kernel, form)));
    }
    if plan.record_share().is_some() {
        kernels.extend(["record_vertices", "record_tables", "eye_records"].map(|kernel| (kernel, form)));
        kernels.push(("record_weights", form.with(&[Feature::AnyHit])));
        if form.contains(Feature::AtRecords) {
            kernels
                .extend(["eye_reach", "light_edges"].map(|kernel| (kernel, form.with(&[Feature::AnyHit]))));
        }
        return kernels;
    }
    // What `training` compiles beside them.
    if plan.shares_cache() && !form.contains(Feature::LambertVertices) {
        kernels.extend([("light_samples", form), ("training_shade", form)]);
    }
    kernels
}

/// What kernels have beside it where light paths are guided.
pub(crate) fn nominal_features(plan: &Plan) -> &'static [Feature] {
    if plan.to_camera { &[Feature::Nominal] } else { &[] }
}

/// What the kernels of light paths have beside their form.
pub(crate) fn light_features(plan: &Plan) -> Vec<Feature> {
    let mut features = vec![Feature::LightPaths];
    if plan.light_paths.are_shared() {
        features.push(Feature::SharedLightPaths);
    }
    features.push(if plan.selector.is_some() { Feature::LightCache } else { Feature::LightOnly });
    features
}
