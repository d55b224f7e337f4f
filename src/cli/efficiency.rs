//! `halfway bench efficiency`

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use anyhow::Context as _;
use clap::{Args, Parser, ValueEnum};
use serde_json::json;

use super::Exit;
use super::input::{
    InputError, SceneArgs, choose_camera, default_output, parse_duration, parse_size, picture_size,
};
use super::method::{IntegratorName, MethodArgs};
use crate::device::{Context, DeviceChoice};
use crate::film::metric::{self, ReferenceNoise};
use crate::film::{Attribute, Picture, exr};
use crate::integrator::{Method, Training, When};
use crate::math::date::date;
use crate::render::efficiency::{Run, Summary, Work, measure, summary};
use crate::render::{Budget, RenderOptions, Renderer, Report};
use crate::scene::Scene;

/// Of references: no round has it, their seeds begin with a `u32`.
const REFERENCE_SEED: u64 = 1 << 63;

/// What is measured and how, below the options of `--help`.
const METHOD: &str = "\
In every round each integrator renders once, in an order that turns round from round to round, each time with a seed of
its own and always as many samples. Seconds are of rendering, without loading and compiling.

A reference is DIR/NAME.exr, or made and kept as DIR/NAME-WIDTHxHEIGHT-SCENE-INTEGRATOR.exr, SCENE a hash of all the
scene's data. One that had less than --reference-time is made anew. Remove it when the renderer itself has changed.

Columns:
  s                    median time of a render
  MAPE, relMSE         mean over the rounds, as `halfway compare` has them; the variance of the reference, where it
                       is known, is subtracted from relMSE, but not from MAPE
  trimmed              relMSE without its largest 0.1 %, nothing subtracted
  efficiency           1 / (mean relMSE x mean time)
  ratio                of efficiencies: median of the rounds' pairs, and its 95 % interval (bootstrap)
  mean ratio           the picture's mean over the reference's, +- its standard error; few rounds know that badly:
                       with 8 one in 200 is beyond 4 of them by chance
  learning             seconds of spcbpt before its first sample: done once for all rounds, in none of the times
  rays to vertices     for one sample of every pixel; connections are those tested
  MiB                  all buffers of the device";

/// Efficiency of integrators: 1 / (relMSE x time).
#[derive(Args, Debug)]
#[command(after_long_help = METHOD)]
pub struct EfficiencyArgs {
    /// .gltf or .glb files, or `builtin:NAME`.
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
    /// Integrators, with settings where the default is not meant: path,lvcbpt:connections=2,light-tracing,light.
    /// Ratios are to the first.
    #[arg(long, value_name = "LIST", default_value = "path,bdpt,lvcbpt")]
    integrators: String,
    /// Choose samples so that a render takes about this time.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "2s")]
    time: Duration,
    /// Samples a pixel, for all integrators, in place of a time.
    #[arg(long, value_name = "N", conflicts_with = "time", value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Renders of each integrator.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..))]
    rounds: u32,
    /// Size in pixels (default: the scene's own wish, or 1280x720).
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<[u32; 2]>,
    /// Which of each scene's cameras, by name or number.
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,
    /// Longest path, in surfaces (default: no limit).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_depth: Option<u32>,
    /// Seeds of the rounds count from here.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Where references are, and where they are kept.
    #[arg(long, value_name = "DIR", default_value = "target/references")]
    references: PathBuf,
    /// Time for a reference that is not there.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "60s")]
    reference_time: Duration,
    /// What makes it, written as for --integrators.
    #[arg(long, value_name = "INTEGRATOR", default_value = "path")]
    reference_integrator: String,
    #[arg(long, value_name = "DEVICE", default_value = "auto")]
    device: DeviceChoice,
    /// Let scenes refer to files outside their folder.
    #[arg(long)]
    allow_outside: bool,
    /// Print JSON, with every run, in place of the table.
    #[arg(long)]
    json: bool,
}

/// An integrator as it is named on the command line.
struct Candidate {
    label: String,
    method: Method,
    training: Training,
}

impl Candidate {
    fn options(&self, subject: &Subject) -> RenderOptions {
        RenderOptions { method: self.method, training: self.training.clone(), ..subject.options.clone() }
    }
}

/// The options of one integrator.
#[derive(Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct OneIntegrator {
    #[command(flatten)]
    method: MethodArgs,
}

/// `path,lvcbpt:connections=2,light-tracing,light`: settings follow a colon and are the options of `render`.
fn parse_integrators(list: &str) -> Result<Vec<Candidate>, InputError> {
    let mut labels: Vec<String> = Vec::new();
    for part in list.split(',') {
        let is_setting = !part.contains(':') && IntegratorName::from_str(part, false).is_err();
        match labels.last_mut() {
            Some(last) if is_setting && last.contains(':') => *last = format!("{last},{part}"),
            _ => labels.push(part.to_owned()),
        }
    }
    let candidate = |label: String| {
        let (name, settings) = label.split_once(':').unwrap_or((&label, ""));
        let settings = settings.split(',').filter(|setting| !setting.is_empty());
        let options = settings.map(|setting| format!("--{setting}"));
        let arguments = [format!("--integrator={name}")].into_iter().chain(options);
        let parsed = OneIntegrator::try_parse_from(arguments).map_err(|error| {
            let text = error.to_string();
            let first = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
            let line: Vec<&str> = first.split_whitespace().collect();
            InputError::Usage(format!("the integrator '{label}': {}", line.join(" ")))
        })?;
        let (method, training) = (parsed.method.method()?, parsed.method.training()?);
        // Learning is once for all rounds, and not in their time.
        let training = Training { when: training.when.or(Some(When::First)), ..training };
        Ok(Candidate { label, method, training })
    };
    labels.into_iter().map(candidate).collect()
}

/// A picture to compare with.
struct Reference {
    picture: Picture,
    path: PathBuf,
    noise: Option<ReferenceNoise>,
}

/// A scene with what is the same for all its renders.
struct Subject {
    name: String,
    scene: Scene,
    hash: u64,
    options: RenderOptions,
}

/// Measures scene by scene and prints.
///
/// # Errors
/// Bad input, no device, a reference that cannot be kept.
pub fn run(args: &EfficiencyArgs, quiet: bool) -> anyhow::Result<Exit> {
    let candidates = parse_integrators(&args.integrators)?;
    let [reference_maker] = &parse_integrators(&args.reference_integrator)?[..] else {
        return Err(InputError::Usage("--reference-integrator takes one integrator".into()).into());
    };
    let context = Context::new(&args.device)?;
    let (today, command) = (today(), command_line());
    let mut heading = Some(format!("## {today}, {}\n\n`{command}`", context.describe()));
    let mut results = Vec::new();
    let mut non_finite = 0;
    for path in &args.scenes {
        let subject = load(args, path)?;
        let reference = reference(args, &context, &subject, reference_maker, quiet)?;
        let measured = rounds(args, &context, &subject, &candidates, &reference, quiet)?;
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
                subject.name
            );
        }
        if args.json {
            results.push(json_of(&subject, &reference, &rows));
        } else {
            if let Some(heading) = heading.take() {
                println!("{heading}");
            }
            print_table(args, &subject, &reference, &rows);
        }
    }
    if args.json {
        let device = context.describe();
        let all = json!({ "date": today, "device": device, "command": command, "scenes": results });
        println!("{}", serde_json::to_string_pretty(&all)?);
    }
    if non_finite > 0 {
        eprintln!("error: {non_finite} samples were not finite; they are left out of the pictures");
        return Ok(Exit::NonFinite);
    }
    Ok(Exit::Done)
}

fn load(args: &EfficiencyArgs, path: &Path) -> anyhow::Result<Subject> {
    let from = SceneArgs {
        scene: path.to_owned(),
        env: None,
        env_scale: 1.0,
        env_rotate: 0.0,
        allow_outside: args.allow_outside,
    };
    let mut scene = from.load()?;
    let camera = choose_camera(&mut scene, args.camera.as_deref())?;
    let [width, height] = picture_size(args.size, &scene);
    let options = RenderOptions {
        width,
        height,
        camera,
        max_depth: args.max_depth,
        seed: args.seed.into(),
        ..RenderOptions::default()
    };
    let name = default_output(path, "").display().to_string();
    Ok(Subject { name, hash: scene.content_hash(), scene, options })
}

/// All runs of all candidates, and what each renderer reports at last.
fn rounds(
    args: &EfficiencyArgs,
    context: &Context,
    subject: &Subject,
    candidates: &[Candidate],
    reference: &Reference,
    quiet: bool,
) -> anyhow::Result<Vec<(Vec<Run>, Report)>> {
    let mut renderers = Vec::new();
    for candidate in candidates {
        renderers.push(Renderer::new(context, &subject.scene, candidate.options(subject))?);
    }
    let work = args.spp.map_or(Work::Time(args.time), Work::Samples);
    let say = |round: Option<u32>, index: usize| {
        let (name, label) = (&subject.name, &candidates[index].label);
        match round {
            _ if quiet => {}
            None => eprintln!("{name}: how fast is {label}"),
            Some(round) => eprintln!("{name}: round {} of {}, {label}", round + 1, args.rounds),
        }
    };
    Ok(measure(&mut renderers, work, args.rounds, args.seed.into(), &reference.picture, say)?)
}

/// The user's reference for a scene, or one that was made before, or else makes it.
fn reference(
    args: &EfficiencyArgs,
    context: &Context,
    subject: &Subject,
    maker: &Candidate,
    quiet: bool,
) -> anyhow::Result<Reference> {
    let RenderOptions { width, height, camera, max_depth, .. } = subject.options;
    let hash = format!("{:016x}", subject.hash);
    let with_noise = |picture: Picture, path: PathBuf| -> anyhow::Result<Reference> {
        Ok(Reference { noise: metric::reference_noise(&picture)?, picture, path })
    };
    let given = args.references.join(&subject.name).with_extension("exr");
    if given.exists() {
        let picture = Picture::read(&given)?;
        let of_another =
            matches!(picture.attribute("sceneHash"), Some(Attribute::Text(other)) if *other != hash);
        if !of_another && (picture.width, picture.height) == (width, height) {
            return with_noise(picture, given);
        }
        log::warn!("{} is of another size or scene; it is not used", given.display());
    }

    let mut name = format!("{}-{width}x{height}-{hash}-{}", subject.name, maker.label);
    if camera > 0 {
        name.push_str(&format!("-camera{camera}"));
    }
    if let Some(depth) = max_depth {
        name.push_str(&format!("-depth{depth}"));
    }
    let path = args.references.join(name.replace([':', ',', '='], "-") + ".exr");
    let asked = args.reference_time.as_secs_f64();
    if path.exists() {
        let picture = Picture::read(&path)?;
        if matches!(picture.attribute("secondsAsked"), Some(Attribute::Number(had)) if *had >= asked) {
            return with_noise(picture, path);
        }
    }
    std::fs::create_dir_all(&args.references)
        .with_context(|| format!("cannot make the folder {}", args.references.display()))?;
    if !quiet {
        eprintln!("{}: a reference by {}, {asked} s", subject.name, maker.label);
    }
    let budget = Budget { time: Some(args.reference_time), ..Budget::default() };
    let options = RenderOptions { seed: REFERENCE_SEED, budget, ..maker.options(subject) };
    let mut renderer = Renderer::new(context, &subject.scene, options)?;
    renderer.run(|_| false)?;
    let (report, mut picture) = (renderer.report()?, renderer.picture()?);
    picture.metadata = vec![
        ("integrator".into(), Attribute::Text(maker.label.clone())),
        ("spp".into(), Attribute::Number(f64::from(report.samples))),
        ("seconds".into(), Attribute::Number(report.seconds)),
        ("secondsAsked".into(), Attribute::Number(asked)),
        ("device".into(), Attribute::Text(context.describe())),
        ("sceneHash".into(), Attribute::Text(hash)),
        ("nonFiniteSamples".into(), Attribute::Number(report.non_finite as f64)),
    ];
    let reference = with_noise(picture, path)?;
    exr::write(&reference.path, &reference.picture)?;
    Ok(reference)
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

fn json_of(subject: &Subject, reference: &Reference, rows: &[Row]) -> serde_json::Value {
    let integrators: Vec<_> = rows
        .iter()
        .map(|row| {
            json!({
                "name": row.candidate.label,
                "method": row.candidate.method,
                "summary": row.summary,
                "learning_seconds": row.report.preprocessing_seconds,
                "bytes": row.bytes(),
                "memory": row.report.memory,
                "runs": row.runs,
            })
        })
        .collect();
    json!({
        "scene": subject.name,
        "hash": format!("{:016x}", subject.hash),
        "size": [subject.options.width, subject.options.height],
        "reference": { "file": reference.path, "noise": reference.noise },
        "integrators": integrators,
    })
}

fn print_table(args: &EfficiencyArgs, subject: &Subject, reference: &Reference, rows: &[Row]) {
    let RenderOptions { width, height, .. } = subject.options;
    let number = |name: &str| match reference.picture.attribute(name) {
        Some(Attribute::Number(value)) => Some(*value),
        _ => None,
    };
    let origin = match (reference.picture.attribute("integrator"), number("spp"), number("seconds")) {
        (Some(Attribute::Text(maker)), Some(spp), Some(seconds)) => {
            format!("{maker}, {} spp, {seconds:.1} s", grouped(spp))
        }
        _ => reference.path.display().to_string(),
    };
    let noise = reference.noise.map_or("taken as exact, its noise is not known".into(), |noise| {
        format!("its own relMSE {} is subtracted", short(noise.relmse))
    });
    println!(
        "\n**{}**, {width}x{height}, {} rounds; reference: {origin}; {noise}\n",
        subject.name, args.rounds
    );
    let first = &rows[0].candidate.label;
    println!(
        "| integrator | spp | s | MAPE | relMSE | trimmed | efficiency | ratio to {first} | mean ratio | learning | rays | \
         connections | light vertices | MiB |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    for row in rows {
        let summary = &row.summary;
        let ratio = match summary.ratio.map(|ratio| (ratio.median, ratio.interval)) {
            Some((median, Some([low, high]))) if [low, high] != [median; 2] => {
                format!("{} ({} to {})", short(median), short(low), short(high))
            }
            Some((median, _)) => short(median),
            None => "-".into(),
        };
        let mean_error = summary.mean_ratio_error.map_or(String::new(), |error| format!(" +- {error:.4}"));
        let columns = [
            row.candidate.label.clone(),
            grouped(f64::from(summary.samples)),
            format!("{:.3}", summary.seconds),
            short(summary.errors.mape),
            short(summary.errors.relmse),
            short(summary.errors.relmse_trimmed),
            summary.efficiency.map_or("-".into(), short),
            ratio,
            format!("{:.4}{mean_error}", summary.mean_ratio),
            short(row.report.preprocessing_seconds),
            grouped(summary.iteration.rays),
            grouped(summary.iteration.connections),
            grouped(summary.iteration.light_vertices),
            format!("{:.1}", row.bytes() as f64 / f64::from(1 << 20)),
        ];
        println!("| {} |", columns.join(" | "));
    }
}

/// Three significant digits.
fn short(value: f64) -> String {
    match value.abs() {
        size if (1e-4..1000.0).contains(&size) => {
            let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
            format!("{value:.decimals$}")
        }
        size if (1000.0..1e9).contains(&size) => grouped(value),
        0.0 => "0".into(),
        _ => format!("{value:.2e}"),
    }
}

/// A whole number with a comma at every thousand.
fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) && !text.ends_with('-') {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// In UTC.
fn today() -> String {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let [year, month, day] = date(since.as_secs() / 86_400);
    format!("{year:04}-{month:02}-{day:02}")
}

fn command_line() -> String {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    format!("halfway {}", arguments.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrators_with_settings() {
        let list = "path,lvcbpt:connections=2,light-paths=500,light-tracing,bdpt,light:light-paths=7";
        let candidates = parse_integrators(list).expect("a good list");
        let labels: Vec<&str> = candidates.iter().map(|candidate| candidate.label.as_str()).collect();
        let cache = "lvcbpt:connections=2,light-paths=500,light-tracing";
        assert_eq!(labels, ["path", cache, "bdpt", "light:light-paths=7"]);
        let methods: Vec<Method> = candidates.iter().map(|candidate| candidate.method).collect();
        let cached = Method::LvcBpt { light_paths: Some(500), connections: 2, light_tracing: true };
        let light = Method::Light { light_paths: Some(7) };
        assert_eq!(methods, [Method::Path, cached, Method::Bdpt { light_tracing: false }, light]);
    }

    #[test]
    fn integrators_that_are_none() {
        for (list, phrases) in [
            ("path,photon", ["'photon'", "lvcbpt"]),
            ("", ["''", "path"]),
            ("path,", ["''", "path"]),
            ("lvcbpt:connections=2,photon", ["--photon", "unexpected"]),
            ("path:connections=2", ["--connections", "lvcbpt"]),
            ("lvcbpt:connections=many", ["many", "connections"]),
            ("lvcbpt:subspaces=8", ["--subspaces", "spcbpt"]),
            ("bdpt:integrator=path", ["--integrator", "multiple"]),
            ("bdpt:help", ["--help", "unexpected"]),
        ] {
            let said = parse_integrators(list).err().expect(list).to_string();
            for phrase in phrases {
                assert!(said.contains(phrase), "'{phrase}' not in: {said}");
            }
        }
    }

    #[test]
    fn numbers_for_the_table() {
        assert_eq!(
            [0.0, 0.001_234_5, 0.999, 1.0, 12.345, 999.0, 12345.6, 1.5e-7, 2e12, f64::NAN].map(short),
            ["0", "0.00123", "0.999", "1.00", "12.3", "999", "12,346", "1.50e-7", "2.00e12", "NaN"]
        );
        assert_eq!(
            [0.0, 999.0, 1000.0, -123_456.0, -1_234_567.0].map(grouped),
            ["0", "999", "1,000", "-123,456", "-1,234,567"]
        );
    }
}
