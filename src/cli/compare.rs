//! `halfway compare`: how far a picture is from its reference.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::args::parse_stops;
use super::{CliError, Exit};
use crate::film::metric::{self, Comparison, NoiseSource};
use crate::film::tonemap::ViewTransform;
use crate::film::{FilmError, Picture, heatmap, png};
use crate::out;

/// What the metrics mean, below the options of `--help`.
const METRICS: &str = "\
Metrics (a: the picture's value, b: the reference's, e: 1 % of the reference's mean; scene-linear RGB):
  mape                  mean of |a - b| / (b + e): the average relative error
  mape-paper            mean of |a - b| / (b + 0.01), a pixel counting at most 10
  mape-paper-unclamped  the same without that limit
  relmse                mean of (a - b)^2 / (b^2 + e^2): punishes few bright wrong pixels
  relmse-trimmed        the same without its largest 0.1 %
  mean                  |A / B - 1| of the pictures' means: the bias
  mean-z                the same in standard errors: beyond 3 noise hardly explains it
  tile-z                difference of 8x8-pixel tiles in standard errors, the worst one; needs the variance
                        layers of both pictures
  psnr                  decibels between the displayed pictures; larger is better
  flip                  visible difference of the displayed pictures, 0 (none) to 1 (LDR-FLIP, 67 pixels per degree)

Exit codes: 0 within the limits, 1 beyond --fail-above, 2 bad input, 5 NaN or infinite pixels.";

/// Options of `halfway compare`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = METRICS)]
pub struct CompareArgs {
    /// The picture to judge: .exr, .hdr, .pfm or .png.
    #[arg(value_name = "PICTURE")]
    pub picture: PathBuf,
    /// What it should look like, of the same size.
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,
    /// Fail (exit code 1) when a metric is larger, for example mape=0.1; may be given several times.
    #[arg(long, value_name = "METRIC=VALUE", value_parser = parse_limit)]
    pub fail_above: Vec<Limit>,
    /// Write where the picture is wrong, as colours of the relative error.
    #[arg(long, value_name = "FILE.png")]
    pub heatmap: Option<PathBuf>,
    /// How pictures are displayed for psnr and flip [default: neutral, srgb when a file is PNG].
    #[arg(long)]
    pub view: Option<ViewTransform>,
    /// Stops of exposure for psnr and flip.
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = parse_stops)]
    pub exposure: f32,
    /// Print JSON in place of the table.
    #[arg(long)]
    pub json: bool,
}

/// A metric that can be limited: larger is worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    Mape,
    MapePaper,
    MapePaperUnclamped,
    Relmse,
    RelmseTrimmed,
    Mean,
    MeanZ,
    TileZ,
    Flip,
}

impl Metric {
    /// The number that is compared with a limit; `None` where the pictures do not say enough for it.
    pub fn value(self, comparison: &Comparison) -> Option<f64> {
        Some(match self {
            Self::Mape => comparison.mape,
            Self::MapePaper => comparison.mape_paper,
            Self::MapePaperUnclamped => comparison.mape_paper_unclamped,
            Self::Relmse => comparison.relmse,
            Self::RelmseTrimmed => comparison.relmse_trimmed,
            Self::Mean => (comparison.mean.ratio - 1.0).abs(),
            Self::MeanZ => comparison.mean.z()?.abs(),
            Self::TileZ => comparison.tiles?.worst_z.abs(),
            Self::Flip => comparison.flip,
        })
    }

    fn name(self) -> String {
        value_name(&self)
    }
}

/// The name by which an option's value is known on the command line.
fn value_name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// The largest value of a metric that passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    pub metric: Metric,
    pub value: f64,
}

fn parse_limit(text: &str) -> Result<Limit, String> {
    let (name, value) = text.split_once('=').ok_or("write METRIC=VALUE, for example mape=0.1")?;
    let metric = Metric::from_str(name, true).map_err(|_| {
        let names: Vec<String> = Metric::value_variants().iter().map(|metric| metric.name()).collect();
        format!("there is no metric '{name}' to limit; choose one of {}", names.join(", "))
    })?;
    match value.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(Limit { metric, value }),
        _ => Err(format!("'{value}' is no number of at least 0")),
    }
}

/// A metric beyond its limit, for the report.
#[derive(Serialize)]
struct Excess {
    metric: Metric,
    value: f64,
    limit: f64,
}

/// Compares, prints the result on stdout, and writes the heat map.
///
/// # Errors
/// Bad input: a file that cannot be read, different sizes, a black or negative reference, a limit on a metric that the
/// pictures do not allow; or a heat map that cannot be written.
pub fn run(args: &CompareArgs) -> Result<Exit, CliError> {
    let picture = Picture::read(&args.picture)?;
    let reference = Picture::read(&args.reference)?;
    let is_png =
        |path: &PathBuf| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    let is_display = is_png(&args.picture) || is_png(&args.reference);
    let view = args.view.unwrap_or(if is_display { ViewTransform::Srgb } else { ViewTransform::default() });
    let comparison = match metric::compare(&picture, &reference, view, args.exposure) {
        Err(error @ FilmError::NonFiniteCompared { .. }) => {
            eprintln!("error: {error}");
            return Ok(Exit::NonFinite);
        }
        other => other?,
    };
    let mut beyond = Vec::new();
    for limit in &args.fail_above {
        let value = limit
            .metric
            .value(&comparison)
            .ok_or_else(|| FilmError::MetricUnknown { metric: limit.metric.name() })?;
        if value > limit.value {
            beyond.push(Excess { metric: limit.metric, value, limit: limit.value });
        }
    }
    if args.json {
        print_json(&comparison, &beyond)?;
    } else {
        print_table(args, &picture, &comparison, view);
        for Excess { metric, value, limit } in &beyond {
            out!("beyond the limit: {} = {value:.6} > {limit}", metric.name());
        }
    }
    if let Some(path) = &args.heatmap {
        let colors = heatmap::colors(&metric::relative_error(&picture, &reference)?);
        png::write_bytes(path, picture.width, picture.height, &colors)?;
        if !args.json {
            out!("heat map of the relative error in {}: {}", path.display(), heatmap::LEGEND);
        }
    }
    Ok(if beyond.is_empty() { Exit::Done } else { Exit::Failed })
}

fn print_json(comparison: &Comparison, beyond: &[Excess]) -> Result<(), CliError> {
    #[derive(Serialize)]
    struct Report<'a> {
        #[serde(flatten)]
        comparison: &'a Comparison,
        beyond: &'a [Excess],
    }
    let json = serde_json::to_string_pretty(&Report { comparison, beyond })?;
    out!("{json}");
    Ok(())
}

fn print_table(args: &CompareArgs, picture: &Picture, comparison: &Comparison, view: ViewTransform) {
    let mean = comparison.mean;
    let noise = match (mean.standard_error, mean.source) {
        (None, _) => "noise unknown: a single tile".to_owned(),
        (Some(error), source) => {
            let source = match source {
                NoiseSource::Both => "variance of both",
                NoiseSource::Picture => "variance of the picture, the reference taken as exact",
                NoiseSource::Reference => "variance of the reference, the picture taken as exact",
                NoiseSource::TileScatter => "scatter of 8x8 tiles",
            };
            let z = mean.z().unwrap_or(0.0);
            format!("+- {error:.6}: {z:+.2} standard errors from 1 ({source})")
        }
    };
    let tiles =
        comparison.tiles.map_or(("-".to_owned(), "needs the variance layers of both".to_owned()), |tiles| {
            let place = format!(
                "{} of the tile at {},{}",
                ["red", "green", "blue"][tiles.channel],
                tiles.column,
                tiles.row
            );
            (
                format!("{:+.3}", tiles.worst_z),
                format!("{place}; chance over {} tests: {:.2e}", tiles.tests, tiles.p_value),
            )
        });
    let through = format!("seen through {} at {} EV", value_name(&view), args.exposure);
    let six = |value: f64| format!("{value:.6}");
    out!("picture    {} ({} x {})", args.picture.display(), picture.width, picture.height);
    out!("reference  {}", args.reference.display());
    for (name, value, note) in [
        ("mape", six(comparison.mape), "average relative error".to_owned()),
        (
            "mape-paper",
            six(comparison.mape_paper),
            format!("unclamped {:.6}", comparison.mape_paper_unclamped),
        ),
        ("relmse", six(comparison.relmse), "average squared relative error".to_owned()),
        ("relmse-trimmed", six(comparison.relmse_trimmed), "without its largest 0.1 %".to_owned()),
        ("mean ratio", six(mean.ratio), noise),
        ("tile-z", tiles.0, tiles.1),
        ("psnr", format!("{:.3}", comparison.psnr), format!("dB, {through}")),
        ("flip", six(comparison.flip), format!("0 to 1, {through}")),
    ] {
        out!("  {name:<15} {value:>12}  {note}");
    }
}
