//! References: where they are kept, and `halfway bench reference`, which makes and checks them.

mod file;
mod store;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::candidate::Candidate;
use super::scene::{BenchScene, BenchSceneArgs};
use crate::bench::reference::{self, AccumulatedReference, Check};
use crate::cli::args::{InputError, parse_duration};
use crate::cli::progress::{install_interrupt, interrupted};
use crate::cli::text::{grouped, short};
use crate::cli::{CliError, Exit};
use crate::device::Context;
use crate::film::{Attribute, exr};
use crate::out;

pub use file::ReferenceFile;
pub use store::{ReferenceArgs, ReferenceStore};

/// Standard errors between the means of a reference and its check that chance does not explain: from a few passes, they
/// are uncertain themselves.
const MOST_Z: f64 = 5.0;
/// What makes references by default.
const DEFAULT_MAKER: &str = "spcbpt";

/// Makes references of independent passes, each of which is kept as soon as it is there, until the picture is as exact
/// as asked, or the time is over; then checks each by another integrator. The same command goes on where it was.
#[derive(Args, Debug)]
pub struct MakeReferenceArgs {
    #[command(flatten)]
    scenes: BenchSceneArgs,
    /// Time of rendering (default: 60s, or as long as --error takes).
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// The MAPE that the reference may have itself, 0.01 = 1 %: enough, whatever time is left.
    #[arg(long, value_name = "ERROR", value_parser = parse_error)]
    error: Option<f64>,
    /// What makes it, with settings where the default is not meant: spcbpt:connections=4.
    #[arg(long, value_name = "INTEGRATOR", default_value = DEFAULT_MAKER)]
    integrator: String,
    /// What checks it, again if something else has (default: path, or lvcbpt for references by path).
    #[arg(long, value_name = "INTEGRATOR")]
    check_integrator: Option<String>,
    /// Time for the check (default: a quarter of what the reference took).
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    check_time: Option<Duration>,
    /// Every N-th pixel of every N-th row only, in 1 / N^2 of the time: for `bench trade --reference-stride N`.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    stride: u32,
    /// Where references are kept.
    #[arg(long, value_name = "DIR", default_value = "target/references")]
    references: PathBuf,
}

fn parse_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(error) if error > 0.0 && error.is_finite() => Ok(error),
        _ => Err("an error is a positive number, such as 0.01 for 1 %".into()),
    }
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// Makes the references, checks them, and prints how exact they are.
///
/// # Errors
/// Bad input, no device, a reference that cannot be kept.
pub fn run(args: &MakeReferenceArgs, quiet: bool) -> Result<Exit, CliError> {
    let maker = Candidate::parse(&args.integrator)?;
    let default_checker = if args.integrator == "path" { "lvcbpt" } else { "path" };
    let checker = Candidate::parse(args.check_integrator.as_deref().unwrap_or(default_checker))?;
    [&maker, &checker].into_iter().try_for_each(Candidate::refuse_denoised)?;
    let store = ReferenceStore {
        folder: args.references.clone(),
        time: args.time,
        error: args.error,
        stride: args.stride,
        maker: Some(maker.clone()),
    };
    install_interrupt();
    let context = args.scenes.seen.picture.device.open_to_compare(quiet)?;
    let mut exit = Exit::Done;
    for path in &args.scenes.paths {
        let bench_scene = args.scenes.seen.load(path)?;
        let kept = store.kept(&bench_scene, &maker.label)?;
        let Some(mut reference) = store.grow(&context, &bench_scene, &maker, kept, quiet)? else {
            eprintln!("interrupted; what is there is kept, the same command goes on with it");
            return Ok(Exit::Interrupted);
        };
        let stands = |text: &str| {
            args.check_integrator.is_none() || text.starts_with(&format!("{} with ", checker.label))
        };
        if !reference.checked().is_some_and(stands) {
            let accumulated = reference.accumulated().ok_or_else(|| {
                let path = reference.path.display();
                InputError::Usage(format!(
                    "{path} does not list its passes; move it away, and it is made again"
                ))
            })?;
            let time = args.check_time.unwrap_or(Duration::from_secs_f64(accumulated.seconds / 4.0));
            let Some((check, other)) =
                check(&context, &bench_scene, &store, &accumulated, &checker, time, quiet)?
            else {
                return Ok(Exit::Interrupted);
            };
            let result = describe(&check, &checker, &other);
            reference.picture.metadata.retain(|(name, _)| name != "checked" && name != "checkZ");
            reference.picture.metadata.push(("checked".into(), Attribute::Text(result)));
            reference.picture.metadata.push(("checkZ".into(), Attribute::Number(check.z().unwrap_or(0.0))));
            exr::write(&reference.path, &reference.picture)?;
        }
        let error = reference.noise.map_or("unknown".into(), |noise| percent(noise.mape));
        out!("{}: {}; own MAPE {error}", bench_scene.name, reference.origin());
        out!("  {}\n  {}", reference.checked().unwrap_or_default(), reference.path.display());
        if reference.number("nonFiniteSamples").is_some_and(|count| count > 0.0) {
            eprintln!("error: {}: some samples were not finite; they are left out", bench_scene.name);
            exit = Exit::NonFinite;
        }
        if reference.number("checkZ").is_some_and(|z| z.abs() > MOST_Z) {
            eprintln!(
                "error: {}: the two integrators do not agree; do not use this reference",
                bench_scene.name
            );
            exit = Exit::Failed;
        }
        if args.error.zip(reference.noise).is_some_and(|(wanted, noise)| noise.mape > wanted) {
            eprintln!(
                "{}: --time ended before --error was met; the same command with more goes on",
                bench_scene.name
            );
            exit = if exit == Exit::Done { Exit::ErrorNotMet } else { exit };
        }
    }
    Ok(exit)
}

/// Renders with another integrator and compares; `None` where Ctrl-C ended that.
fn check(
    context: &Context,
    bench_scene: &BenchScene,
    store: &ReferenceStore,
    accumulated: &AccumulatedReference,
    checker: &Candidate,
    time: Duration,
    quiet: bool,
) -> Result<Option<(Check, AccumulatedReference)>, CliError> {
    if !quiet {
        eprintln!("{}: {} checks it, {} s", bench_scene.name, checker.label, short(time.as_secs_f64()));
    }
    let store = ReferenceStore {
        folder: PathBuf::new(),
        time: Some(time),
        error: None,
        stride: store.stride,
        maker: None,
    };
    let mut renderer = store.renderer(context, bench_scene, checker)?;
    let mut other: Option<AccumulatedReference> = None;
    while let Some(pass) = store.next_pass(other.as_ref(), None) {
        // Seeds of its own: both may be of the same kind.
        other = AccumulatedReference::with_pass(other, &mut renderer, 1, pass, |_| interrupted())?;
        if other.is_none() || interrupted() {
            return Ok(None);
        }
    }
    Ok(other.map(|other| reference::check(accumulated, &other).map(|check| (check, other))).transpose()?)
}

fn describe(check: &Check, checker: &Candidate, other: &AccumulatedReference) -> String {
    let error = check.mean_ratio_error.map_or(String::new(), |error| format!(" +- {error:.5}"));
    let z = check.z().map_or(String::new(), |z| format!(" ({z:+.1} standard errors)"));
    let tiles = check.tiles.map_or(String::new(), |tiles| {
        format!("; worst of {} tiles {:+.1} standard errors", tiles.tests, tiles.worst_z)
    });
    format!(
        "{} with {} spp: mean ratio {:.5}{error}{z}{tiles}",
        checker.label,
        grouped(other.samples as f64),
        check.mean_ratio
    )
}
