//! `halfway info`

use clap::Args;

use super::Exit;
use super::input::{InputError, SceneArgs};
use crate::accel::Accel;
use crate::scene::{LightKind, Projection, Scene, SceneFeatures, builtin};

/// Say what a scene contains, which features it switches on and what an integrator cannot sample in it.
#[derive(Args, Debug)]
pub struct InfoArgs {
    #[command(flatten)]
    scene: Option<SceneArgs>,
    /// List the built-in scenes instead.
    #[arg(long)]
    builtins: bool,
}

/// What a feature costs where it is on; printed beside its name.
fn cost(feature: &str) -> &'static str {
    match feature {
        "lambert_only" => "saves the microfacet code and its table of albedos",
        "transmission" => "adds refraction to the shading kernel",
        "rough_transmission" => "adds a microfacet lobe for transmission",
        "absorption" => "an exponential for each segment inside a volume",
        "alpha" => "looks up opacity inside the traversal, at every hit of such a surface",
        "textures" => "look-ups while shading; 4 bytes a texel of memory",
        "normals" => "12 bytes a vertex",
        "normal_map" => "28 bytes a vertex, one look-up a surface",
        "vertex_colors" => "16 bytes a vertex",
        "uv0" | "uv1" => "8 bytes a vertex",
        "area_lights" | "punctual_lights" => "one shadow ray a surface, shared by all lights",
        "environment" => "24 bytes a texel; misses are shaded",
        "unlit" => "a test a surface",
        _ => "",
    }
}

/// Prints the description.
///
/// # Errors
/// What the loader reports.
pub fn run(args: &InfoArgs) -> anyhow::Result<Exit> {
    if args.builtins {
        builtin::NAMES.iter().for_each(|name| println!("builtin:{name}"));
        return Ok(Exit::Done);
    }
    let scene = args
        .scene
        .as_ref()
        .ok_or_else(|| InputError::Usage("name a scene, or list the built-in ones with --builtins".into()))?
        .load()?;
    let accel = Accel::build(&scene)?;
    contents(&scene, &accel);
    println!("\nfeatures that the kernels are compiled for:");
    for (name, on) in SceneFeatures::of(&scene).table() {
        if on {
            println!("  {name:<19} {}", cost(name));
        }
    }
    let off: Vec<&str> =
        SceneFeatures::of(&scene).table().iter().filter(|(_, on)| !on).map(|(name, _)| *name).collect();
    println!("  not there, and not compiled: {}", off.join(", "));
    println!("\nthe path integrator:");
    limits(&scene).iter().for_each(|line| println!("  {line}"));
    Ok(Exit::Done)
}

fn contents(scene: &Scene, accel: &Accel) {
    let vertices: usize = scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
    println!("scene {}", scene.name);
    println!(
        "  {} triangles, {vertices} vertices in {} meshes; {} without area left out",
        scene.triangle_count(),
        scene.meshes.len(),
        accel.dropped
    );
    println!(
        "  BVH: {} nodes, {} levels, {:.1} MiB with triangles, built in {:.2} s",
        accel.nodes.len(),
        accel.depth,
        (accel.nodes.len() * 80 + accel.triangles.len() * 48) as f64 / f64::from(1 << 20),
        accel.build_time.as_secs_f64()
    );
    let texels: usize = scene.images.iter().map(|image| image.texels.len()).sum();
    println!(
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
    println!("  lights: {emissive} emitting triangles, {} punctual", scene.lights.len());
    for light in &scene.lights {
        let kind = match light.kind {
            LightKind::Point => "point",
            LightKind::Spot { .. } => "spot",
            LightKind::Directional => "directional",
        };
        println!("    {kind} '{}'", light.name);
    }
    if let Some(environment) = &scene.environment {
        println!("  environment '{}', {}x{}", environment.name, environment.width, environment.height);
    }
    for (index, camera) in scene.cameras.iter().enumerate() {
        let projection = match camera.projection {
            Projection::Perspective { yfov } => format!("perspective, {:.1} degrees high", yfov.to_degrees()),
            Projection::Orthographic { ymag, .. } => format!("orthographic, {} units high", 2.0 * ymag),
        };
        println!("  camera {index} '{}': {projection}", camera.name);
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
