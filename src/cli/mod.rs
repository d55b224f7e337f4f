//! The command line: one file for each subcommand. Results go to stdout, progress and messages to stderr.

pub mod args;
mod bench;
mod compare;
mod debug;
mod devices;
mod info;
mod output;
#[cfg(feature = "preview")]
mod preview;
mod progress;
mod render;
mod strategies;
mod summary;
mod text;
mod trace;
mod train;

use clap::{Parser, Subcommand};

/// How a run ended; the process's exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    Done = 0,
    /// It failed, or the compared images differ.
    Failed = 1,
    /// Wrong usage or bad input.
    BadInput = 2,
    /// The budget ended before `--error` was met.
    ErrorNotMet = 3,
    /// No usable device.
    NoDevice = 4,
    /// Non-finite values were found.
    NonFinite = 5,
    /// Interrupted; what was rendered is saved.
    Interrupted = 130,
}

impl From<Exit> for std::process::ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

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
    /// Only results and errors.
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to EXR and PNG files.
    Render(Box<render::RenderArgs>),
    /// Look at a scene in a window while it renders: move about, switch integrators.
    #[cfg(feature = "preview")]
    Preview(Box<preview::PreviewArgs>),
    /// Learn where paths of a scene connect, for renders with --integrator spcbpt --model.
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
/// What went wrong; [`exit_code`] says how the process then ends.
pub fn run(cli: &Cli) -> anyhow::Result<Exit> {
    match &cli.command {
        Command::Render(args) => render::run(args, cli.quiet),
        #[cfg(feature = "preview")]
        Command::Preview(args) => preview::run(args, cli.quiet),
        Command::Train(args) => train::run(args, cli.quiet),
        Command::Compare(args) => Ok(compare::run(args)?),
        Command::Info(args) => info::run(args),
        Command::Bench(args) => bench::run(args, cli.quiet),
        Command::Devices => Ok(devices::run()),
    }
}

/// The exit code that belongs to an error.
pub fn exit_code(error: &anyhow::Error) -> Exit {
    use crate::device::DeviceError;
    use crate::film::FilmError;
    use crate::render::RenderError;
    use crate::scene::SceneError;
    use crate::subspace::SubspaceError;
    if let Some(RenderError::Interrupted) = error.downcast_ref() {
        return Exit::Interrupted;
    }
    let device = error.downcast_ref::<DeviceError>().or_else(|| match error.downcast_ref::<RenderError>() {
        Some(RenderError::Device(device)) => Some(device),
        _ => None,
    });
    match device {
        Some(
            DeviceError::NoAdapter
            | DeviceError::NotFound { .. }
            | DeviceError::Open { .. }
            | DeviceError::CutsLoops { .. },
        ) => return Exit::NoDevice,
        Some(DeviceError::Scene(_)) => return Exit::BadInput,
        Some(DeviceError::Subspace(subspace)) if subspace.is_bad_input() => return Exit::BadInput,
        Some(_) => return Exit::Failed,
        None => {}
    }
    #[cfg(feature = "preview")]
    if let Some(error) = error.downcast_ref() {
        use crate::preview::PreviewError;
        return match error {
            PreviewError::Input(_) => Exit::BadInput,
            _ => Exit::Failed,
        };
    }
    let input = error.is::<SceneError>()
        || error.is::<args::InputError>()
        || error.downcast_ref().is_some_and(FilmError::is_bad_input)
        || error.downcast_ref().is_some_and(SubspaceError::is_bad_input)
        || error.is::<RenderError>();
    if input { Exit::BadInput } else { Exit::Failed }
}
