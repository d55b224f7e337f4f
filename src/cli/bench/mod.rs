//! `halfway bench`: each benchmark's command in a file or folder of its own; what they share is in [`scene`],
//! [`candidate`] and [`reference`].

mod candidate;
mod efficiency;
mod format;
mod paper;
mod paper_figures;
mod rays;
mod reference;
mod runs;
mod scene;
mod sweep;
mod trade;

use clap::{Args, Subcommand};

use crate::cli::{CliError, Exit};
use crate::device::Context;
use crate::render::made_by;
use efficiency::EfficiencyArgs;
use paper::PaperArgs;
use rays::RaysArgs;
use reference::MakeReferenceArgs;
use trade::TradeArgs;

/// Measure a part of the renderer.
#[derive(Args, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    bench: Bench,
}

#[derive(Subcommand, Debug)]
enum Bench {
    /// Rays per second: primary, diffuse bounce, shadow.
    Rays(RaysArgs),
    /// Efficiency of integrators, 1 / (relMSE x time), with confidence, as a Markdown table.
    Efficiency(EfficiencyArgs),
    /// What speed costs in accuracy: error against time, of integrators and of their settings, as a page with plots.
    Trade(Box<TradeArgs>),
    /// The tables of the paper on SPCBPT, measured here, as a page.
    Paper(Box<PaperArgs>),
    /// Make references as exact as asked, and check each by another integrator.
    Reference(MakeReferenceArgs),
}

/// What figures are of: the device, and what of it traces. For contexts in which that is the same for all scenes.
fn maker_of(context: &Context) -> String {
    made_by(&context.describe(), context.traversal)
}

/// Runs a benchmark.
///
/// # Errors
/// Bad input, no device, files that cannot be written.
pub fn run(args: &BenchArgs, quiet: bool) -> Result<Exit, CliError> {
    match &args.bench {
        Bench::Rays(args) => rays::run(args),
        Bench::Efficiency(args) => efficiency::run(args, quiet),
        Bench::Trade(args) => trade::run(args, quiet),
        Bench::Paper(args) => paper::run(args, quiet),
        Bench::Reference(args) => reference::run(args, quiet),
    }
}
