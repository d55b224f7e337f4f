//! `halfway info`

use std::path::PathBuf;

use clap::{Args, ValueEnum as _};

use super::args::method::names_of;
use super::args::picture::DEFAULT_SIZE;
use super::args::{InputError, SceneArgs};
use super::{CliError, Exit};
use crate::accel::{Accel, arranged};
use crate::device::context::{adapter, binding_of};
use crate::device::host_memory::{free_memory, used_memory};
use crate::device::scene::{SceneMemory, readable_bytes};
use crate::device::{DeviceChoice, DeviceError, Feature, Features};
use crate::integrator::method::Setting;
use crate::integrator::{PcBpt, View};
use crate::out;
use crate::render::{PictureMemory, RenderOptions};
use crate::scene::{LightKind, Projection, Repeated, Scene, SceneFeatures, Viewpoint, builtin};
use crate::subspace::Model;
use crate::subspace::gamma::{Loss, Tried};
use crate::subspace::guide::GUIDE_CELLS;

/// Options of `halfway info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    scene: Option<SceneArgs>,
    /// List the built-in scenes instead.
    #[arg(long)]
    builtins: bool,
    /// Say what a model of `halfway train` has learnt, and whether it fits the scene if one is given.
    #[arg(long, value_name = "FILE.model")]
    model: Option<PathBuf>,
}

/// Prints the description.
///
/// # Errors
/// What the loader reports.
pub fn run(args: &InfoArgs) -> Result<Exit, CliError> {
    if args.builtins {
        builtin::NAMES.iter().for_each(|name| out!("builtin:{name}"));
        return Ok(Exit::Done);
    }
    let model = args.model.as_deref().map(Model::read).transpose()?;
    let scene = args.scene.as_ref().map(SceneArgs::read).transpose()?;
    match (&scene, &model) {
        (Some(scene), _) => describe(scene)?,
        (None, Some(_)) => {}
        (None, None) => {
            let usage = "name a scene or a model (--model FILE), or list the built-in scenes with --builtins";
            return Err(InputError::Usage(usage.into()).into());
        }
    }
    if let (Some(path), Some(model)) = (&args.model, &model) {
        if scene.is_some() {
            out!();
        }
        out!("model {}", path.display());
        learnt(model).iter().for_each(|(name, value)| out!("  {name:<19} {value}"));
        if let Some(mut scene) = scene {
            // As a render would see it.
            Viewpoint::default().choose(&mut scene).map_err(InputError::from)?;
            out!("  {:<19} {}", "fits the scene", fit(model, scene.content_hash()));
        }
    }
    Ok(Exit::Done)
}

fn describe(scene: &Scene) -> Result<(), CliError> {
    memory(scene)?;
    let arranged = arranged(scene);
    let accel = Accel::build(&arranged)?;
    contents(scene, &accel);
    repeated(&arranged);
    if !scene.warnings.is_empty() {
        out!("\nwarnings: {} (--strict refuses faults of the file)", scene.warnings.len());
        scene.warnings.iter().for_each(|warning| out!("  {warning}"));
    }
    out!("\nfeatures that the kernels are compiled for:");
    let features = Features::from(SceneFeatures::of(scene));
    let (on, off): (Vec<Feature>, Vec<Feature>) =
        Feature::of_scenes().partition(|&feature| features.contains(feature));
    on.iter().for_each(|feature| out!("  {:<19} {}", feature.name(), feature.about()));
    let off: Vec<&str> = off.into_iter().map(Feature::name).collect();
    out!("  not there, and not compiled: {}", off.join(", "));
    out!("\nthe path integrator:");
    limits(scene).iter().for_each(|line| out!("  {line}"));
    Ok(())
}

/// What the scene will take of memory, and whether the device that would be chosen has it: before anything is built.
fn memory(scene: &Scene) -> Result<(), DeviceError> {
    let memory = SceneMemory::of(scene, &SceneFeatures::of(scene));
    let parts: Vec<String> = memory
        .buffers
        .iter()
        .map(|&(buffer, bytes)| format!("{} {}", buffer.name(), readable_bytes(bytes)))
        .collect();
    out!("memory that the scene takes, as foretold:");
    out!("  device {}: {}", readable_bytes(memory.device()), parts.join(", "));
    let now = used_memory();
    let host = readable_bytes(now.unwrap_or(0) + memory.host_peak);
    out!("  host {host} at the peak, before the picture");
    let pixel = |first_hit_layers| {
        let view = View::sized(1, 1);
        let memory = PictureMemory::of(&RenderOptions { view, first_hit_layers, ..RenderOptions::default() });
        memory.device + memory.host
    };
    out!("  a picture: {} bytes a pixel beside that, {} with an EXR's layers", pixel(false), pixel(true));
    let [width, height] = scene.resolution.unwrap_or(DEFAULT_SIZE);
    let records = PcBpt::default().record_cost(width, height);
    out!(
        "  {} at {width}x{height}: about {} records with tables of about {} light vertices; {:.1} M shadow rays a sample, {}",
        names_of(Setting::Records),
        records.records,
        records.vertices,
        records.shadow_rays() as f64 * 1e-6,
        readable_bytes(2 * records.buffer_bytes())
    );
    out!(
        "  --risbpt-weights nabata, the default of risbpt: {:.1} M rays a sample beside that",
        records.weight_rays() as f64 * 1e-6
    );
    let Ok(adapter) = adapter(&DeviceChoice::Auto) else { return Ok(()) };
    let (info, limits) = (adapter.get_info(), adapter.limits());
    let page_bytes = binding_of(&limits);
    let is_cpu = info.device_type == wgpu::DeviceType::Cpu;
    if is_cpu {
        let both = readable_bytes(now.unwrap_or(0) + memory.together());
        out!("  host and device are one here: {both} at the peak");
    }
    let free = if is_cpu { free_memory() } else { None };
    memory.check_for(page_bytes, limits.max_storage_buffers_per_shader_stage, free)?;
    let pages = memory.pages(page_bytes).extra();
    let split = match pages {
        0 => "in one piece each".to_string(),
        pages => format!("in {pages} bindings more than a small scene"),
    };
    out!("  it fits {}, {split}", info.name);
    if records.buffer_bytes() > page_bytes {
        out!(
            "  the tables of records do not, as far as that can be foretold: the device binds {} at once; a smaller \
             --record-share or fewer --light-paths take less",
            readable_bytes(page_bytes)
        );
    }
    out!();
    Ok(())
}

fn fit(model: &Model, scene_hash: u64) -> String {
    if model.scene_hash == scene_hash {
        return "yes".into();
    }
    format!("no, that is {scene_hash:016x}: another scene, or changed since, or another --env; train again")
}

/// What a model knows, and from what: names and values.
fn learnt(model: &Model) -> Vec<(&'static str, String)> {
    let (report, settings) = (&model.report, &model.settings);
    let counts = &report.counts;
    let k = model.subspaces;
    let chosen = if settings.subspaces.is_some() { "as asked for" } else { "as many as the paths can teach" };
    let [least, mean, most] = report.row_entropy;
    let optimiser = settings.optimiser.to_possible_value();
    let [start, best] = [0, report.best_step as usize].map(|step| report.losses.get(step));
    let ratio = start.zip(best).map(|(start, best)| Loss {
        train: best.train / start.train,
        held_out: start.held_out.zip(best.held_out).map(|(start, best)| best / start),
        ..*best
    });
    let tried = |tried: &Tried| format!("{} ({})", tried.smoothing, short(tried.held_out));
    let tried: Vec<String> = report.tried.iter().map(tried).collect();
    vec![
        ("scene", format!("{:016x}", model.scene_hash)),
        ("subspaces", format!("{k} eye, {k} light: {chosen}")),
        (
            "eye subspaces",
            format!("{} learnt, {} nodes of the tree", counts.learnt_rows, counts.eye_tree_nodes),
        ),
        (
            "light subspaces",
            format!(
                "{} in use, {} nodes of the tree; {} for points on lights, {} with Q at its floor",
                counts.active_columns,
                counts.light_tree_nodes,
                counts.source_subspaces,
                counts.floored_columns
            ),
        ),
        (
            "Gamma's rows",
            format!(
                "entropy {least:.2} least, {mean:.2} mean, {most:.2} most, of {:.2} bits",
                f64::from(k).log2()
            ),
        ),
        ("light paths", guided(model)),
        ("Q", format!("the largest is {} times the smallest", short(report.q_spread))),
        ("loss", format!("{:<14} held-out paths", "training paths")),
        ("  at the start", losses(start)),
        ("  at the best", losses(best)),
        ("  best over start", losses(ratio.as_ref())),
        (
            "steps",
            format!(
                "{} ({}), the best is {}",
                report.losses.len().saturating_sub(1),
                optimiser.as_ref().map_or("", |value| value.get_name()),
                report.best_step
            ),
        ),
        (
            "smoothing",
            format!(
                "{} from neighbours at the best; held-out loss by share: {}",
                best.map_or(0.0, |best| best.smoothing),
                if tried.is_empty() { "-".into() } else { tried.join(", ") }
            ),
        ),
        (
            "learnt from",
            format!(
                "{} paths, {} held out of them, with {} connections; {} light vertices",
                counts.paths, counts.held_out_paths, counts.nodes, counts.light_samples
            ),
        ),
        (
            "left out",
            format!(
                "{} faulty paths, {} faulty light vertices, {} paths that no connection makes; {} outliers held back",
                counts.faulty_paths,
                counts.faulty_light_samples,
                counts.unreachable_paths,
                counts.clamped_paths
            ),
        ),
        (
            "first connections",
            match &model.first_connections {
                Some(first) => format!("{}: {}", first.count, first.reason()),
                None => "as many as the render has: the model does not say how many are worth it".into(),
            },
        ),
        (
            "learnt for",
            format!(
                "{}, uniform share {}, power share {}",
                model.connections, settings.uniform_share, settings.power_share
            ),
        ),
        ("time", format!("{:.2} s, tracing not counted", report.seconds.total)),
    ]
}

/// Whether light paths are guided, and how far.
fn guided(model: &Model) -> String {
    let gain = model.report.guide_gain.exp();
    match (&model.guide, model.settings.light_guide) {
        (Some(guide), _) => {
            let strongest = guide.strongest();
            // An eighth more than an even share: something was learnt.
            let knowing = strongest.iter().filter(|&&most| most > 1.125).count();
            let most = strongest.iter().copied().fold(1.0, f64::max) / GUIDE_CELLS as f64;
            let pick = guide.picks.iter().copied().fold(0.0, f32::max);
            format!(
                "guided; {gain:.2} times as dense where their light is wanted: from {knowing} of {} light subspaces, {:.0} % into \
                 one of {GUIDE_CELLS} cells of directions at most; {:.0} % start at one of {} lights",
                strongest.len(),
                100.0 * most,
                100.0 * pick,
                guide.picks.len()
            )
        }
        (None, true) => {
            format!("not guided; they would be {gain:.2} times as dense where their light is wanted")
        }
        (None, false) => "not guided, as asked for".into(),
    }
}

fn losses(loss: Option<&Loss>) -> String {
    let held_out = loss.and_then(|loss| loss.held_out);
    let [train, held_out] =
        [loss.map(|loss| loss.train), held_out].map(|loss| loss.map_or("-".into(), short));
    format!("{train:<14} {held_out}")
}

/// Four digits, with an exponent where there would be many more.
fn short(value: f64) -> String {
    match value.abs() {
        size if size == 0.0 || (1e-3..1e5).contains(&size) => {
            let digits = (3 - size.max(1.0).log10().floor() as i32).clamp(0, 3) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.3e}"),
    }
}

fn contents(scene: &Scene, accel: &Accel) {
    let vertices: usize = scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
    out!("scene {}", scene.name);
    out!(
        "  {} triangles, {vertices} vertices in {} meshes; {} without area left out",
        scene.triangle_count(),
        scene.meshes.len(),
        accel.dropped
    );
    out!(
        "  BVH: {} nodes, {} levels, {:.1} MiB with triangles, built in {:.2} s",
        accel.nodes.len(),
        accel.depth,
        (accel.nodes.len() * 80 + accel.triangles.len() * 48) as f64 / f64::from(1 << 20),
        accel.build_time.as_secs_f64()
    );
    let texels: usize = scene.images.iter().map(|image| image.texels.len()).sum();
    out!(
        "  {} materials, {} images ({:.1} MiB)",
        scene.materials.len(),
        scene.images.len(),
        texels as f64 * 4.0 / f64::from(1 << 20)
    );
    let emitting = |mesh: &crate::scene::Mesh| {
        let material = &scene.materials[mesh.material as usize];
        material.unlit || material.emission.max_element() > 0.0
    };
    let emissive: usize =
        scene.meshes.iter().filter(|mesh| emitting(mesh)).map(|mesh| mesh.triangles.len()).sum();
    let coincidence = accel.coincidence;
    out!(
        "  lights: {emissive} emitting triangles, {} punctual; {} of the former lie in other surfaces, {} are hidden \
         by faces of the same corners",
        scene.lights.len(),
        coincidence.overlapping_emitters,
        coincidence.hidden_emitters
    );
    for light in &scene.lights {
        let kind = match light.kind {
            LightKind::Point => "point",
            LightKind::Spot { .. } => "spot",
            LightKind::Directional => "directional",
        };
        out!("    {kind} '{}'", light.name);
    }
    if let Some(environment) = &scene.environment {
        out!("  environment '{}', {}x{}", environment.name, environment.width, environment.height);
    }
    if !scene.variants.is_empty() {
        out!("  variants (--variant NAME): {}", scene.variants.join(", "));
    }
    for (index, camera) in scene.cameras.iter().enumerate() {
        let projection = match camera.projection {
            Projection::Perspective { yfov } => format!("perspective, {:.1} degrees high", yfov.to_degrees()),
            Projection::Orthographic { ymag, .. } => format!("orthographic, {} units high", 2.0 * ymag),
        };
        out!("  camera {index} '{}': {projection}", camera.name);
    }
}

/// How meshes are held that are shown in many places.
fn repeated(scene: &Scene) {
    for repeated in &scene.repeated {
        let Repeated { mesh, triangles, places, reason, .. } = repeated;
        out!("  mesh '{mesh}', {triangles} triangles in {places} places: {}; {reason}", repeated.held());
    }
}

/// What path tracing finds only by chance or not at all in this scene.
fn limits(scene: &Scene) -> Vec<String> {
    let mut lines = Vec::new();
    let used = |test: fn(&crate::scene::Material) -> bool| {
        scene.meshes.iter().any(|mesh| test(&scene.materials[mesh.material as usize]))
    };
    let features = SceneFeatures::of(scene);
    if !features.lights() {
        lines.push("cannot find any light: there is none, the picture will be black".into());
    }
    let delta = used(|material| material.is_delta());
    if delta && features.punctual_lights {
        lines.push(
            "cannot find punctual lights by way of mirrors and smooth glass: those reflections and caustics are missing"
                .into(),
        );
    }
    if delta && features.area_lights {
        lines.push("finds caustics of mirrors and smooth glass by chance only: expect noise there".into());
    }
    if lines.is_empty() {
        lines.push("can find all light of this scene".into());
    }
    lines
}
