//! References: where they are kept, and `halfway bench reference`, which makes and checks them.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::candidate::Candidate;
use super::scene::{BenchScene, BenchSceneArgs};
use crate::bench::reference::{self, AccumulatedReference, Check, Pass, Reference};
use crate::cli::args::{InputError, parse_duration};
use crate::cli::progress::{install_interrupt, interrupted};
use crate::cli::text::{grouped, short};
use crate::cli::{CliError, Exit};
use crate::device::Context;
use crate::film::metric::{self, ReferenceNoise};
use crate::film::{Attribute, Picture, Region, exr};
use crate::integrator::View;
use crate::math::fnv::fnv;
use crate::render::{Budget, RenderOptions, Renderer, TimeLimit};

/// Where neither time nor error is asked for.
const DEFAULT_TIME: Duration = Duration::from_secs(60);
/// Standard errors between the means of a reference and its check that no chance explains: known by a few portions only,
/// they are themselves uncertain.
const MOST_Z: f64 = 5.0;
/// What makes references where nobody says.
const DEFAULT_MAKER: &str = "spcbpt";

/// References for a benchmark.
#[derive(Args, Debug)]
pub struct ReferenceArgs {
    /// Where references are, and where they are kept.
    #[arg(long, value_name = "DIR", default_value = "target/references")]
    references: PathBuf,
    /// Time for a reference that is not there (default: 60s, or as long as --reference-error takes).
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    reference_time: Option<Duration>,
    /// The MAPE that a reference may have itself, 0.01 = 1 %: enough, whatever time is left.
    #[arg(long, value_name = "ERROR", value_parser = parse_error)]
    reference_error: Option<f64>,
    /// What makes it, written as for --integrators (default: whatever made the most exact that is kept, else spcbpt).
    #[arg(long, value_name = "INTEGRATOR")]
    reference_integrator: Option<String>,
    /// Compare every N-th pixel of every N-th row only, so that references take 1 / N^2 of the time.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    reference_stride: u32,
}

impl ReferenceArgs {
    /// # Errors
    /// No such integrator.
    pub fn keeper(&self) -> Result<ReferenceStore, InputError> {
        let maker = self.reference_integrator.as_deref().map(Candidate::parse).transpose()?;
        Ok(ReferenceStore {
            folder: self.references.clone(),
            time: self.reference_time,
            error: self.reference_error,
            stride: self.reference_stride,
            maker,
        })
    }
}

/// Makes references of independent portions, each of which is kept as soon as it is there, until the picture is as exact
/// as asked, or the time is over; then checks each by another integrator. The same command goes on where it was.
#[derive(Args, Debug)]
pub struct MakeReferenceArgs {
    #[command(flatten)]
    subject: BenchSceneArgs,
    /// Time of rendering (default: 60s, or as long as --error takes).
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time: Option<Duration>,
    /// The MAPE that the reference may have itself, 0.01 = 1 %: enough, whatever time is left.
    #[arg(long, value_name = "ERROR", value_parser = parse_error)]
    error: Option<f64>,
    /// What makes it, with settings where the default is not meant: spcbpt:connections=4.
    #[arg(long, value_name = "INTEGRATOR", default_value = DEFAULT_MAKER)]
    integrator: String,
    /// What checks it (default: path, or lvcbpt for references by path).
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

/// A picture to compare with.
pub struct ReferenceFile {
    pub picture: Picture,
    pub path: PathBuf,
    pub noise: Option<ReferenceNoise>,
}

impl ReferenceFile {
    fn new(picture: Picture, path: PathBuf) -> Result<Self, CliError> {
        Ok(Self { noise: metric::reference_noise(&picture)?, picture, path })
    }

    fn number(&self, name: &str) -> Option<f64> {
        match self.picture.attribute(name) {
            Some(Attribute::Number(value)) => Some(*value),
            _ => None,
        }
    }

    fn text(&self, name: &str) -> Option<&str> {
        match self.picture.attribute(name) {
            Some(Attribute::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// What made it, with how many samples in which time; else its file.
    pub fn origin(&self) -> String {
        match (self.text("integrator"), self.number("spp"), self.number("seconds")) {
            (Some(maker), Some(spp), Some(seconds)) => {
                let part = match self.stride() {
                    1 => String::new(),
                    stride => format!(" of every {}th pixel", stride * stride),
                };
                format!("{maker}, {} spp{part}, {} s", grouped(spp), short(seconds))
            }
            _ => self.path.display().to_string(),
        }
    }

    /// What a second integrator said of it; `None` where none was asked.
    pub fn checked(&self) -> Option<&str> {
        self.text("checked")
    }

    /// Of the lattice of pixels that it has; 1: all.
    pub fn stride(&self) -> u32 {
        self.number("stride").map_or(1, |stride| stride as u32).max(1)
    }

    /// As what pictures of the whole are compared with.
    pub fn truth(&self, subject: &BenchScene) -> Reference<'_> {
        let RenderOptions { view: View { width, height, .. }, .. } = subject.options;
        Reference { picture: &self.picture, region: Region::lattice(width, height, self.stride()) }
    }

    /// Tells references apart.
    pub fn hash(&self) -> u64 {
        fnv(bytemuck::cast_slice(self.picture.rgb.as_flattened()))
    }

    /// What it grew from, where it is one of ours.
    fn grown(&self) -> Option<AccumulatedReference> {
        let portion = |text: &str| {
            let (samples, mean) = text.split_once(':')?;
            Some(Pass { samples: samples.parse().ok()?, mean: mean.parse().ok()? })
        };
        Some(AccumulatedReference {
            picture: self.picture.clone(),
            samples: self.number("spp")? as u64,
            seconds: self.number("seconds")?,
            non_finite: self.number("nonFiniteSamples")? as u64,
            portions: self.text("portions")?.split(' ').map(portion).collect::<Option<_>>()?,
        })
    }
}

/// Where references are, and how exact they have to be.
pub struct ReferenceStore {
    folder: PathBuf,
    time: Option<Duration>,
    error: Option<f64>,
    /// Of the lattice of pixels that they have; 1: all.
    stride: u32,
    /// What makes them; `None`: what made the most exact that is there, else the default.
    maker: Option<Candidate>,
}

impl ReferenceStore {
    /// The user's reference for a scene, or one that was made before, or else makes it; one that is not exact enough yet
    /// goes on growing. `None` where Ctrl-C ended that.
    ///
    /// # Errors
    /// A folder that cannot be written, or what rendering reports.
    pub fn reference(
        &self,
        context: &Context,
        subject: &BenchScene,
        quiet: bool,
    ) -> Result<Option<ReferenceFile>, CliError> {
        if let Some(given) = self.given(subject)? {
            return Ok(Some(given));
        }
        let default = Candidate::parse(DEFAULT_MAKER)?;
        let (maker, kept) = match &self.maker {
            Some(maker) => (maker.clone(), self.kept(subject, &maker.label)?),
            None => match self.most_exact(subject)? {
                Some((maker, kept)) => (maker, Some(kept)),
                None => (default, None),
            },
        };
        self.grow(context, subject, &maker, kept, quiet)
    }

    /// DIR/NAME.exr, if it is of this scene and size.
    fn given(&self, subject: &BenchScene) -> Result<Option<ReferenceFile>, CliError> {
        let given = self.folder.join(&subject.name).with_extension("exr");
        if !given.exists() {
            return Ok(None);
        }
        let reference = ReferenceFile::new(Picture::read(&given)?, given)?;
        let of_this = reference.text("sceneHash").is_none_or(|hash| hash == format!("{:016x}", subject.hash));
        let Reference { picture, region } = reference.truth(subject);
        if of_this && (picture.width, picture.height) == (region.width, region.height) {
            return Ok(Some(reference));
        }
        log::warn!("{} is of another size or scene; it is not used", reference.path.display());
        Ok(None)
    }

    /// The beginning of the names of all references of a scene and view.
    fn stem(&self, subject: &BenchScene) -> String {
        let RenderOptions { view: View { width, height, max_depth, .. }, camera, .. } = subject.options;
        let depth = max_depth.map_or(String::new(), |depth| format!(".depth{depth}"));
        let stride = if self.stride > 1 { format!(".stride{}", self.stride) } else { String::new() };
        format!("{}-{width}x{height}{stride}-{:016x}-camera{camera}{depth}-", subject.name, subject.hash)
    }

    fn path(&self, subject: &BenchScene, label: &str) -> PathBuf {
        self.folder.join(self.stem(subject) + &label.replace([':', ',', '='], "-") + ".exr")
    }

    fn kept(&self, subject: &BenchScene, label: &str) -> Result<Option<ReferenceFile>, CliError> {
        let path = self.path(subject, label);
        let kept = path.exists().then(|| ReferenceFile::new(Picture::read(&path)?, path)).transpose()?;
        // One that does not say what it grew from cannot go on.
        Ok(kept.filter(|kept| kept.grown().is_some()))
    }

    fn most_exact(&self, subject: &BenchScene) -> Result<Option<(Candidate, ReferenceFile)>, CliError> {
        let mut best: Option<(Candidate, ReferenceFile)> = None;
        let stem = self.stem(subject);
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return Ok(None) };
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if !name.starts_with(&stem) || !name.ends_with(".exr") {
                continue;
            }
            let reference = ReferenceFile::new(Picture::read(&path)?, path)?;
            let maker = reference.text("integrator").and_then(|label| Candidate::parse(label).ok());
            let error = |reference: &ReferenceFile| reference.noise.map_or(f64::INFINITY, |noise| noise.mape);
            let Some(maker) = maker.filter(|_| reference.grown().is_some()) else { continue };
            if best.as_ref().is_none_or(|(_, best)| error(&reference) < error(best)) {
                best = Some((maker, reference));
            }
        }
        Ok(best)
    }

    /// Time that is left for a reference; `None` where it is exact enough, or had its time.
    fn left(&self, grown: Option<&AccumulatedReference>, noise: Option<ReferenceNoise>) -> Option<Duration> {
        let time = match (self.time, self.error) {
            (None, None) => Some(DEFAULT_TIME),
            (time, _) => time,
        };
        let had = Duration::from_secs_f64(grown.map_or(0.0, |grown| grown.seconds));
        // A hundredth less is as good.
        let left = time.map_or(Duration::MAX, |time| time.saturating_sub(had));
        let is_over = time.is_some_and(|time| left < time / 100);
        let is_exact = self.error.zip(noise).is_some_and(|(error, noise)| noise.mape <= error);
        // Portions are not so many that they are short, nor so few that they do not tell how they scatter.
        let portion = (had / 4).clamp(Duration::from_secs(2), Duration::from_secs(60));
        let portion = portion.min(time.map_or(portion, |time| time / 8)).min(left);
        (!is_over && !is_exact).then_some(portion)
    }

    fn grow(
        &self,
        context: &Context,
        subject: &BenchScene,
        maker: &Candidate,
        kept: Option<ReferenceFile>,
        quiet: bool,
    ) -> Result<Option<ReferenceFile>, CliError> {
        let mut reference = kept;
        let mut grown = reference.as_ref().and_then(ReferenceFile::grown);
        let noise = |reference: &Option<ReferenceFile>| reference.as_ref().and_then(|kept| kept.noise);
        if self.left(grown.as_ref(), noise(&reference)).is_none() {
            return Ok(reference);
        }
        std::fs::create_dir_all(&self.folder).map_err(CliError::folder(&self.folder))?;
        if !quiet {
            eprintln!("{}: a reference by {}{}", subject.name, maker.label, self.wish());
        }
        let mut renderer = self.renderer(context, subject, maker)?;
        while let Some(time) = self.left(grown.as_ref(), noise(&reference)) {
            let Some(more) =
                AccumulatedReference::with_portion(grown, &mut renderer, 0, time, |_| interrupted())?
            else {
                return Ok(None);
            };
            let made = ReferenceFile::new(
                Picture { metadata: self.metadata(context, subject, maker, &more), ..more.picture.clone() },
                self.path(subject, &maker.label),
            )?;
            exr::write(&made.path, &made.picture)?;
            if !quiet {
                let error = made.noise.map_or("unknown".into(), |noise| percent(noise.mape));
                let seconds = short(more.seconds);
                eprintln!("{}: {} spp, {seconds} s, own MAPE {error}", subject.name, more.samples);
            }
            (grown, reference) = (Some(more), Some(made));
            if interrupted() {
                return Ok(None);
            }
        }
        Ok(reference)
    }

    fn renderer(
        &self,
        context: &Context,
        subject: &BenchScene,
        maker: &Candidate,
    ) -> Result<Renderer, CliError> {
        let budget = Budget { time: self.time.map(TimeLimit::Total), ..Budget::default() };
        let RenderOptions { view: View { width, height, .. }, .. } = subject.options;
        let crop = (self.stride > 1).then(|| Region::lattice(width, height, self.stride));
        let options = RenderOptions {
            view: View { crop, ..maker.options(subject, 1 << 63).view },
            budget,
            ..maker.options(subject, 1 << 63)
        };
        Ok(Renderer::new(context, &subject.scene, options)?)
    }

    fn metadata(
        &self,
        context: &Context,
        subject: &BenchScene,
        maker: &Candidate,
        grown: &AccumulatedReference,
    ) -> Vec<(String, Attribute)> {
        let portions: Vec<String> =
            grown.portions.iter().map(|portion| format!("{}:{}", portion.samples, portion.mean)).collect();
        vec![
            ("integrator".into(), Attribute::Text(maker.label.clone())),
            ("spp".into(), Attribute::Number(grown.samples as f64)),
            ("seconds".into(), Attribute::Number(grown.seconds)),
            ("portions".into(), Attribute::Text(portions.join(" "))),
            ("device".into(), Attribute::Text(context.describe())),
            ("sceneHash".into(), Attribute::Text(format!("{:016x}", subject.hash))),
            ("nonFiniteSamples".into(), Attribute::Number(grown.non_finite as f64)),
            ("stride".into(), Attribute::Number(f64::from(self.stride))),
        ]
    }

    fn wish(&self) -> String {
        let time = self.time.or(self.error.is_none().then_some(DEFAULT_TIME));
        let time = time.map_or(String::new(), |time| format!(", {} s", time.as_secs_f64()));
        time + &self.error.map_or(String::new(), |error| format!(", own MAPE {}", percent(error)))
    }
}

fn percent(share: f64) -> String {
    format!("{} %", short(100.0 * share))
}

/// Makes the references, checks them, and says how exact they are.
///
/// # Errors
/// Bad input, no device, a reference that cannot be kept.
pub fn run(args: &MakeReferenceArgs, quiet: bool) -> Result<Exit, CliError> {
    let maker = Candidate::parse(&args.integrator)?;
    let default_checker = if args.integrator == "path" { "lvcbpt" } else { "path" };
    let checker = Candidate::parse(args.check_integrator.as_deref().unwrap_or(default_checker))?;
    let keeper = ReferenceStore {
        folder: args.references.clone(),
        time: args.time,
        error: args.error,
        stride: args.stride,
        maker: Some(maker.clone()),
    };
    install_interrupt();
    let context = args.subject.picture.device.open(quiet)?;
    let mut exit = Exit::Done;
    for path in &args.subject.scenes {
        let subject = args.subject.load(path)?;
        let kept = keeper.kept(&subject, &maker.label)?;
        let Some(mut reference) = keeper.grow(&context, &subject, &maker, kept, quiet)? else {
            eprintln!("interrupted; what is there is kept, the same command goes on with it");
            return Ok(Exit::Interrupted);
        };
        if reference.checked().is_none() {
            let grown = reference.grown().ok_or_else(|| {
                let path = reference.path.display();
                InputError::Usage(format!(
                    "{path} does not say what it was made of; move it away, and it is made again"
                ))
            })?;
            let time = args.check_time.unwrap_or(Duration::from_secs_f64(grown.seconds / 4.0));
            let Some((check, other)) = check(&context, &subject, &keeper, &grown, &checker, time, quiet)?
            else {
                return Ok(Exit::Interrupted);
            };
            let said = describe(&check, &checker, &other);
            reference.picture.metadata.push(("checked".into(), Attribute::Text(said)));
            reference.picture.metadata.push(("checkZ".into(), Attribute::Number(check.z().unwrap_or(0.0))));
            exr::write(&reference.path, &reference.picture)?;
        }
        let error = reference.noise.map_or("unknown".into(), |noise| percent(noise.mape));
        println!("{}: {}; own MAPE {error}", subject.name, reference.origin());
        println!("  {}\n  {}", reference.checked().unwrap_or_default(), reference.path.display());
        if reference.number("nonFiniteSamples").is_some_and(|count| count > 0.0) {
            eprintln!("error: {}: some samples were not finite; they are left out", subject.name);
            exit = Exit::NonFinite;
        }
        if reference.number("checkZ").is_some_and(|z| z.abs() > MOST_Z) {
            eprintln!("error: {}: the two integrators do not agree; do not use this reference", subject.name);
            exit = Exit::Failed;
        }
        if args.error.zip(reference.noise).is_some_and(|(wanted, noise)| noise.mape > wanted) {
            eprintln!(
                "{}: --time ended before --error was met; the same command with more goes on",
                subject.name
            );
            exit = if exit == Exit::Done { Exit::ErrorNotMet } else { exit };
        }
    }
    Ok(exit)
}

/// Renders with another integrator and compares; `None` where Ctrl-C ended that.
fn check(
    context: &Context,
    subject: &BenchScene,
    keeper: &ReferenceStore,
    grown: &AccumulatedReference,
    checker: &Candidate,
    time: Duration,
    quiet: bool,
) -> Result<Option<(Check, AccumulatedReference)>, CliError> {
    if !quiet {
        eprintln!("{}: {} checks it, {} s", subject.name, checker.label, short(time.as_secs_f64()));
    }
    let keeper = ReferenceStore {
        folder: PathBuf::new(),
        time: Some(time),
        error: None,
        stride: keeper.stride,
        maker: None,
    };
    let mut renderer = keeper.renderer(context, subject, checker)?;
    let mut other: Option<AccumulatedReference> = None;
    while let Some(portion) = keeper.left(other.as_ref(), None) {
        // Seeds of its own: both may be of the same kind.
        other = AccumulatedReference::with_portion(other, &mut renderer, 1, portion, |_| interrupted())?;
        if other.is_none() || interrupted() {
            return Ok(None);
        }
    }
    Ok(other.map(|other| reference::check(grown, &other).map(|check| (check, other))).transpose()?)
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
