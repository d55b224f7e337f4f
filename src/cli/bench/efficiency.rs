//! `halfway bench efficiency`

use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::candidate::{Candidate, parse_integrators};
use super::reference::{ReferenceArgs, ReferenceFile};
use super::scene::{BenchScene, BenchSceneArgs};
use crate::bench::efficiency::{Run, Summary, Work, measure, summary};
use crate::cli::args::parse_duration;
use crate::cli::bench::maker_of;
use crate::cli::text::{command_line, grouped, ratio, short, today};
use crate::cli::{CliError, Exit};
use crate::device::Context;
use crate::integrator::View;
use crate::out;
use crate::render::{Renderer, Report};

/// What is measured and how, below the options of `--help`.
const METHOD: &str = "\
In every round each integrator renders once, in an order that turns round from round to round, each time with a seed of
its own and always as many samples. Seconds are of rendering, without loading and compiling.

A reference is DIR/NAME.exr, or made and kept as DIR/NAME-WIDTHxHEIGHT-SCENE-CAMERA-INTEGRATOR.exr, SCENE a hash of all
the scene's data (`halfway bench reference` makes them as well, and checks them). One that is neither exact enough nor had
its time gets more passes. Remove it when the renderer itself has changed.

Columns:
  s                    median time of a render
  MAPE, relMSE         mean over the rounds, as `halfway compare` has them; the variance of the reference, where it
                       is known, is subtracted from relMSE, but not from MAPE
  trimmed              relMSE without its largest 0.1 %, nothing subtracted
  efficiency           1 / (mean relMSE x mean time)
  ratio                of efficiencies: median of the rounds' pairs, and its 95 % interval (bootstrap)
  mean ratio           the picture's mean over the reference's, +- its standard error; with few rounds that is uncertain:
                       with 8 one in 200 is beyond 4 of them by chance
  learning             seconds of spcbpt before its first sample: done once for all rounds, in none of the times
  rays to vertices     for one sample of every pixel; connections are those tested
  MiB                  all buffers of the device";

/// Efficiency of integrators: 1 / (relMSE x time).
#[derive(Args, Debug)]
#[command(after_long_help = METHOD)]
pub struct EfficiencyArgs {
    #[command(flatten)]
    scenes: BenchSceneArgs,
    /// Integrators, with settings where the default is not meant: path,lvcbpt:connections=2,light-tracing,light.
    /// Ratios are to the first.
    #[arg(long, value_name = "LIST", default_value = "path,bdpt,lvcbpt")]
    integrators: String,
    /// Choose samples so that a render takes about this time.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "2s")]
    time: Duration,
    /// Samples per pixel, for all integrators, in place of a time.
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Renders of each integrator.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..))]
    rounds: u32,
    /// Seeds of the rounds count from here.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    #[command(flatten)]
    reference: ReferenceArgs,
    /// Print JSON, with every run, in place of the table.
    #[arg(long)]
    json: bool,
}

/// Measures scene by scene and prints.
///
/// # Errors
/// Bad input, no device, a reference that cannot be kept.
pub fn run(args: &EfficiencyArgs, quiet: bool) -> Result<Exit, CliError> {
    let candidates = parse_integrators(&args.integrators)?;
    candidates.iter().try_for_each(Candidate::refuse_denoised)?;
    let store = args.reference.store()?;
    let context = args.scenes.seen.picture.device.open_to_compare(true)?;
    let (today, command) = (today(), command_line());
    let mut heading = Some(format!("## {today}, {}\n\n`{command}`", maker_of(&context)));
    let mut results = Vec::new();
    let mut non_finite = 0;
    for path in &args.scenes.paths {
        let bench_scene = args.scenes.seen.load(path)?;
        let Some(reference) = store.reference(&context, &bench_scene, quiet)? else {
            return Ok(Exit::Interrupted);
        };
        let measured = rounds(args, &context, &bench_scene, &candidates, &reference, quiet)?;
        let first = measured[0].0.clone();
        let rows: Vec<Row> = candidates
            .iter()
            .zip(measured)
            .map(|(candidate, (runs, report))| {
                non_finite += runs.iter().map(|run| run.non_finite).sum::<u64>();
                Row { candidate, summary: summary(&runs, &first, reference.noise), runs, report }
            })
            .collect();
        let too_noisy = |row: &Row| reference.noise.is_some_and(|n| row.summary.needs_better_reference(n));
        if rows.iter().any(too_noisy) {
            log::warn!(
                "{}: noise of the reference is over a tenth of an error; raise --reference-time",
                bench_scene.name
            );
        }
        if args.json {
            results.push(json_of(&bench_scene, &reference, &rows));
        } else {
            if let Some(heading) = heading.take() {
                out!("{heading}");
            }
            print_table(args, &bench_scene, &reference, &rows);
        }
    }
    if args.json {
        let device = maker_of(&context);
        let all = json!({ "date": today, "device": device, "command": command, "scenes": results });
        out!("{}", serde_json::to_string_pretty(&all)?);
    }
    if non_finite > 0 {
        eprintln!("error: {non_finite} samples were not finite; they are left out of the pictures");
        return Ok(Exit::NonFinite);
    }
    Ok(Exit::Done)
}

/// All runs of all candidates, and what each renderer reports at last.
fn rounds(
    args: &EfficiencyArgs,
    context: &Context,
    bench_scene: &BenchScene,
    candidates: &[Candidate],
    reference: &ReferenceFile,
    quiet: bool,
) -> Result<Vec<(Vec<Run>, Report)>, CliError> {
    let mut renderers = Vec::new();
    for candidate in candidates {
        renderers.push(Renderer::new(
            context,
            &bench_scene.scene,
            candidate.options(bench_scene, args.seed.into()),
        )?);
    }
    let work = args.spp.map_or(Work::Time(args.time), Work::Samples);
    let say = |round: Option<u32>, index: usize| {
        let (name, label) = (&bench_scene.name, &candidates[index].label);
        match round {
            _ if quiet => {}
            None => eprintln!("{name}: how fast is {label}"),
            Some(round) => eprintln!("{name}: round {} of {}, {label}", round + 1, args.rounds),
        }
    };
    Ok(measure(&mut renderers, work, args.rounds, args.seed.into(), &reference.of_whole(bench_scene), say)?)
}

/// A candidate's results.
struct Row<'a> {
    candidate: &'a Candidate,
    summary: Summary,
    runs: Vec<Run>,
    report: Report,
}

impl Row<'_> {
    fn bytes(&self) -> u64 {
        self.report.memory.iter().map(|(_, bytes)| bytes).sum()
    }
}

fn json_of(bench_scene: &BenchScene, reference: &ReferenceFile, rows: &[Row]) -> serde_json::Value {
    let integrators: Vec<_> = rows
        .iter()
        .map(|row| {
            json!({
                "name": row.candidate.label,
                "method": row.candidate.options(bench_scene, 0).method,
                "summary": row.summary,
                "learning_seconds": row.report.preprocessing_seconds,
                "bytes": row.bytes(),
                "memory": row.report.memory,
                "runs": row.runs,
            })
        })
        .collect();
    json!({
        "scene": bench_scene.name,
        "hash": format!("{:016x}", bench_scene.hash),
        "size": [bench_scene.options.view.width, bench_scene.options.view.height],
        "reference": { "file": reference.path, "noise": reference.noise },
        "integrators": integrators,
    })
}

fn print_table(args: &EfficiencyArgs, bench_scene: &BenchScene, reference: &ReferenceFile, rows: &[Row]) {
    let View { width, height, .. } = bench_scene.options.view;
    let origin = reference.origin();
    let noise = reference.noise.map_or("taken as exact, its noise is not known".into(), |noise| {
        format!("its own relMSE {} is subtracted", short(noise.relmse))
    });
    out!(
        "\n**{}**, {width}x{height}, {} rounds; reference: {origin}; {noise}\n",
        bench_scene.name,
        args.rounds
    );
    let first = &rows[0].candidate.label;
    out!(
        "| integrator | spp | s | MAPE | relMSE | trimmed | efficiency | ratio to {first} | mean ratio | learning | rays | \
         connections | light vertices | MiB |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    for row in rows {
        let summary = &row.summary;
        let mean_error = summary.mean_ratio_error.map_or(String::new(), |error| format!(" +- {error:.4}"));
        let columns = [
            row.candidate.label.clone(),
            grouped(f64::from(summary.samples)),
            format!("{:.3}", summary.seconds),
            short(summary.errors.mape),
            short(summary.errors.relmse),
            short(summary.errors.relmse_trimmed),
            summary.efficiency.map_or("-".into(), short),
            ratio(summary.ratio),
            format!("{:.4}{mean_error}", summary.mean_ratio),
            short(row.report.preprocessing_seconds),
            grouped(summary.iteration.rays),
            grouped(summary.iteration.connections),
            grouped(summary.iteration.light_vertices),
            format!("{:.1}", row.bytes() as f64 / f64::from(1 << 20)),
        ];
        out!("| {} |", columns.join(" | "));
    }
}
