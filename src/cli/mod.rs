//! The command line: one file for each subcommand. Results go to stdout, progress and messages to stderr.

pub mod args;
mod bench;
mod compare;
mod debug;
mod devices;
mod error;
mod exit;
mod info;
mod keep;
mod merge;
mod output;
mod passes;
#[cfg(feature = "preview")]
mod preview;
mod progress;
mod render;
mod resume;
mod saves;
mod strategies;
mod summary;
mod text;
mod trace;
mod train;

use clap::{Parser, Subcommand};

use crate::stdout;

pub use error::CliError;
pub use exit::Exit;

/// Below the options of `--help`.
const EXIT_CODES: &str = "\
Results go to stdout, progress and messages to stderr. Ctrl-C ends the round that runs, writes the picture and says so; a
second one stops at once.

Exit codes:
  0    done
  1    failed, or compared images differ
  2    wrong usage or bad input
  3    the budget ended before --error was met
  4    no usable device
  5    non-finite values were found; they are counted and left out of the picture
  130  interrupted; what was rendered is saved";

/// Halfway renders glTF scenes by light transport on Vulkan compute shaders.
#[derive(Parser)]
#[command(version, about, max_term_width = 100, after_long_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Say more: -v what is done, -vv details.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// Only results, errors, and how many warnings there are about the scene.
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to EXR and PNG files.
    ///
    /// The first limit of --spp, --time and --error that is met ends the render.
    Render(Box<render::RenderArgs>),
    /// Go on with a render from its checkpoint.
    ///
    /// The picture is that of a render that was never stopped, bit for bit.
    Resume(resume::ResumeArgs),
    /// Merge portions of one render to its picture.
    ///
    /// It is the picture of one render of all their samples, bit for bit.
    Merge(merge::MergeArgs),
    /// Look at a scene in a window while it renders: move about, switch integrators.
    ///
    /// The picture is saved when the window is closed, bit for bit the one that `halfway render` makes of as many samples
    /// with the same flags.
    #[cfg(feature = "preview")]
    Preview(Box<preview::PreviewArgs>),
    /// Learn where paths of a scene connect, for renders with --integrator spcbpt --model.
    ///
    /// Pictures stay unbiased whatever was learnt: it is about noise only. Learn with the camera, --size, --max-depth,
    /// --roulette-cap and --connections of the render: it learns what they need.
    Train(Box<train::TrainArgs>),
    /// Compare a picture with a reference: error metrics, noise tests, a heat map of where it is wrong.
    Compare(compare::CompareArgs),
    /// Say what a scene contains, what it switches on and what each part costs.
    // All that it is asked for may be a list or a model.
    #[command(mut_arg("scene", |scene| scene.required(false)))]
    Info(info::InfoArgs),
    /// Measure.
    Bench(bench::BenchArgs),
    /// List the devices that --device can name.
    Devices,
}

/// Runs the subcommand.
///
/// # Errors
/// What went wrong; [`CliError::fault`] says how the process then ends.
pub fn run(cli: &Cli) -> Result<Exit, CliError> {
    let exit = match &cli.command {
        Command::Render(args) => render::run(args, cli.quiet),
        Command::Resume(args) => resume::run(args, cli.quiet),
        Command::Merge(args) => merge::run(args, cli.quiet),
        #[cfg(feature = "preview")]
        Command::Preview(args) => preview::run(args, cli.quiet),
        Command::Train(args) => train::run(args, cli.quiet),
        Command::Compare(args) => compare::run(args),
        Command::Info(args) => info::run(args),
        Command::Bench(args) => bench::run(args, cli.quiet),
        Command::Devices => Ok(devices::run()),
    }?;
    match stdout::fault() {
        Some(cause) => Err(CliError::Stdout { cause }),
        None => Ok(exit),
    }
}
