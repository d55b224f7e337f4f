//! The arguments about the picture that is rendered, shared by the subcommands that render.

use clap::Args;

use super::{parse_exposure, parse_probability, parse_size};
use crate::device::{Context, DeviceChoice, DeviceError, Traversal};
use crate::film::Exposure;
use crate::film::tonemap::ViewTransform;
use crate::integrator::{DEFAULT_ROULETTE_CAP, View};
use crate::render::RenderOptions;
use crate::scene::Scene;

/// Pixels of a picture that no size is given for, where the scene asks for none either.
pub const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// Where paths end.
#[derive(Args, Clone, Copy, Debug)]
pub struct PathArgs {
    /// Longest path, in surfaces: 1 sees lights only, 2 adds direct light (default: no limit, Russian roulette ends paths
    /// without bias).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_depth: Option<u32>,
    #[arg(long, value_name = "Q", value_parser = parse_probability,
          help = format!("Least probability with which Russian roulette lets a path go on after a surface; where the \
                          surface's albedo is larger, it is that; after 16 mirrors or clear panes in a row .95 of it, or Q \
                          of it where Q is more (default: {DEFAULT_ROULETTE_CAP})"))]
    roulette_cap: Option<f32>,
}

impl PathArgs {
    /// The options with what is given here.
    pub fn apply(&self, options: RenderOptions) -> RenderOptions {
        RenderOptions {
            view: View {
                max_depth: self.max_depth.or(options.view.max_depth),
                roulette_cap: self.roulette_cap.unwrap_or(options.view.roulette_cap),
                ..options.view
            },
            ..options
        }
    }
}

/// What computes.
#[derive(Args, Clone, Debug)]
pub struct DeviceArgs {
    /// Device by number, name or uuid:UUID as `halfway devices` lists them, or cpu; auto takes the fastest kind there is.
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: DeviceChoice,
    /// What finds where rays meet surfaces.
    #[arg(long, value_name = "HOW", value_enum, default_value_t)]
    pub traversal: Traversal,
}

impl DeviceArgs {
    /// The same; where it is not said what traces, this does.
    pub fn tracing_by(&self, before: Option<Traversal>) -> Self {
        let traversal = match self.traversal {
            Traversal::Auto => before.unwrap_or_default(),
            said => said,
        };
        Self { traversal, ..self.clone() }
    }

    /// As [`open`](Self::open), for figures that are kept and compared: kernels trace unless it is said otherwise, not what a
    /// trial finds faster that day.
    ///
    /// # Errors
    /// No such device.
    pub fn open_to_compare(&self, quiet: bool) -> Result<Context, DeviceError> {
        self.tracing_by(Some(Traversal::Compute)).open(quiet)
    }

    /// Opens the device and, unless `quiet`, says which it is.
    ///
    /// # Errors
    /// No such device.
    pub fn open(&self, quiet: bool) -> Result<Context, DeviceError> {
        let context = Context::tracing(&self.device, self.traversal)?;
        if !quiet {
            eprintln!("device: {}", context.describe());
            if context.is_cpu() {
                eprintln!("warning: this is a software device; a GPU renders many times faster");
            }
        }
        Ok(context)
    }
}

/// What chance begins with.
#[derive(Args, Clone, Copy, Debug)]
pub struct SeedArgs {
    /// Seed of all random numbers: the same seed on the same device makes the same picture or model, bit for bit.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
}

/// How large the picture is, where its paths end, and what makes it.
#[derive(Args, Clone, Debug)]
pub struct PictureArgs {
    #[arg(long, value_name = "WxH", value_parser = parse_size,
          help = format!("Size of the picture in pixels (default: what the scene asks for, else {}x{})", DEFAULT_SIZE[0],
                         DEFAULT_SIZE[1]))]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    paths: PathArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl PictureArgs {
    /// The size that is asked for, else that of the scene.
    pub fn size(&self, scene: &Scene) -> [u32; 2] {
        self.size.or(scene.resolution).unwrap_or(DEFAULT_SIZE)
    }

    /// A render of the scene seen by one of its cameras, by default in all that is not said here.
    pub fn options(&self, scene: &Scene, camera: usize) -> RenderOptions {
        let [width, height] = self.size(scene);
        self.paths.apply(RenderOptions {
            view: View { width, height, ..View::default() },
            camera,
            ..RenderOptions::default()
        })
    }
}

/// How a picture is shown.
#[derive(Args, Clone, Copy, Debug)]
pub struct ViewArgs {
    /// How scene light becomes colours on a screen or in a PNG.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub view: ViewTransform,
    /// Exposure of the view, in stops from -100 to 100; auto brings the log-average of the picture to middle grey.
    #[arg(long, value_name = "EV", default_value = "0", allow_hyphen_values = true, value_parser = parse_exposure)]
    pub exposure: Exposure,
}
