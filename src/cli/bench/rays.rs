//! `halfway bench rays`

use std::path::{Path, PathBuf};

use clap::Args;

use crate::bench::rays::RayBench;
use crate::cli::args::picture::DeviceArgs;
use crate::cli::args::{CameraNameArgs, SceneArgs, parse_size};
use crate::cli::{CliError, Exit};
use crate::device::Traversal;
use crate::out;
use crate::render::made_by;
use crate::render::rays::RaySet;

/// Traces rays of three kinds and prints millions per second, and what a ray looks at on its way.
///
/// Nodes and triangles are counted by kernels of their own. Lanes are live while their own ray looks at nodes, of those that
/// go along until the longest ray among them is done.
#[derive(Args, Debug)]
pub struct RaysArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// One primary ray for each pixel of this size.
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "512x512")]
    size: [u32; 2],
    #[command(flatten)]
    camera: CameraNameArgs,
    /// Seconds of tracing for each kind.
    #[arg(long, default_value_t = 2.0)]
    seconds: f64,
    #[command(flatten)]
    device: DeviceArgs,
    /// Print JSON in place of the table.
    #[arg(long)]
    json: bool,
    /// Write triangles and rays as little-endian f32 (see tools/embree), and trace nothing more.
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
}

/// Traces and prints, or dumps.
///
/// # Errors
/// Bad input, no device, files that cannot be written.
pub fn run(args: &RaysArgs) -> Result<Exit, CliError> {
    let mut scene = args.scene.load()?;
    let camera = args.camera.choose(&mut scene)?;
    let context = args.device.open(true)?;
    let mut bench = RayBench::new(&context, &scene, camera, args.size)?;
    if let Some(folder) = &args.dump {
        std::fs::create_dir_all(folder).map_err(CliError::folder(folder))?;
        write(folder, "triangles", &bench.triangles())?;
        for set in &bench.sets {
            write(folder, set.name, &dump_rays(set))?;
        }
        out!("{}", folder.display());
        return Ok(Exit::Done);
    }
    if !args.json && bench.traversal == Traversal::Hardware {
        out!("by the device's ray queries:");
    }
    let mut results = serde_json::Map::new();
    for index in 0..bench.sets.len() {
        let result = bench.measure(&context, index, args.seconds)?;
        let set = &bench.sets[index];
        if !args.json {
            let work = result.work.map_or_else(String::new, |work| {
                format!(
                    "; a ray looks at {:.1} nodes and {:.1} triangles, {:.1} of {} lanes live",
                    work.nodes_per_ray, work.triangles_per_ray, work.live_lanes, work.lanes
                )
            });
            out!(
                "{:<8} {:>8.3} Mrays/s   {} rays, {} hits{work}",
                set.name,
                result.mrays_per_second,
                set.rays.len(),
                result.hits
            );
        }
        results.insert(set.name.into(), serde_json::to_value(result)?);
    }
    if args.json {
        results.insert("device".into(), made_by(&context.describe(), bench.traversal).into());
        out!("{}", serde_json::Value::Object(results));
    }
    Ok(Exit::Done)
}

/// Origin, tmin, direction, tmax.
fn dump_rays(set: &RaySet) -> Vec<f32> {
    set.rays
        .iter()
        .flat_map(|ray| {
            let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
            [ox, oy, oz, 0.0, dx, dy, dz, ray.t_max]
        })
        .collect()
}

fn write(folder: &Path, name: &str, data: &[f32]) -> Result<(), CliError> {
    let path = folder.join(name).with_extension("f32");
    std::fs::write(&path, bytemuck::cast_slice(data)).map_err(CliError::write("the figures", &path))
}
