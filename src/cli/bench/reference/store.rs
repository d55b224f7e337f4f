//! Where references are kept, and what makes those that are not there.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::file::ReferenceFile;
use super::{DEFAULT_MAKER, parse_error, percent};
use crate::bench::reference::{AccumulatedReference, Reference};
use crate::cli::CliError;
use crate::cli::args::{InputError, parse_duration};
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::maker_of;
use crate::cli::bench::scene::BenchScene;
use crate::cli::progress::interrupted;
use crate::cli::text::short;
use crate::device::Context;
use crate::film::metric::ReferenceNoise;
use crate::film::{Attribute, Picture, Region, exr};
use crate::integrator::View;
use crate::render::{Budget, RenderOptions, Renderer, TimeLimit};

/// Time of rendering where neither time nor error is asked for.
const DEFAULT_TIME: Duration = Duration::from_secs(60);

/// References for a benchmark.
#[derive(Args, Debug)]
pub struct ReferenceArgs {
    /// Where references are, and where they are kept.
    #[arg(long, value_name = "DIR", default_value = "target/references")]
    references: PathBuf,
    /// Time for a reference that is not there yet (default: 60s, or as long as --reference-error takes).
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
    /// Where this says that references are.
    ///
    /// # Errors
    /// No such integrator.
    pub fn store(&self) -> Result<ReferenceStore, InputError> {
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

/// Where references are, and how exact they have to be.
pub struct ReferenceStore {
    pub(super) folder: PathBuf,
    /// Limits of a reference: time of rendering, and the MAPE that it may have itself.
    pub(super) time: Option<Duration>,
    pub(super) error: Option<f64>,
    /// Of the lattice of pixels that they have; 1: all.
    pub(super) stride: u32,
    /// What makes them; `None`: what made the most exact that is there, else the default.
    pub(super) maker: Option<Candidate>,
}

impl ReferenceStore {
    /// The user's reference for a scene, or one that was made before, or else makes it; one that is not exact enough
    /// yet gets more passes. `None` where Ctrl-C ended that.
    ///
    /// # Errors
    /// A folder that cannot be written, or what rendering reports.
    pub fn reference(
        &self,
        context: &Context,
        bench_scene: &BenchScene,
        quiet: bool,
    ) -> Result<Option<ReferenceFile>, CliError> {
        if let Some(given) = self.given(bench_scene)? {
            return Ok(Some(given));
        }
        let default = Candidate::parse(DEFAULT_MAKER)?;
        let (maker, kept) = match &self.maker {
            Some(maker) => (maker.clone(), self.kept(bench_scene, &maker.label)?),
            None => match self.most_exact(bench_scene)? {
                Some((maker, kept)) => (maker, Some(kept)),
                None => (default, None),
            },
        };
        self.grow(context, bench_scene, &maker, kept, quiet)
    }

    /// DIR/NAME.exr, if it is of this scene and size.
    fn given(&self, bench_scene: &BenchScene) -> Result<Option<ReferenceFile>, CliError> {
        let given = self.folder.join(&bench_scene.name).with_extension("exr");
        if !given.exists() {
            return Ok(None);
        }
        let reference = ReferenceFile::new(Picture::read(&given)?, given)?;
        let of_this =
            reference.text("sceneHash").is_none_or(|hash| hash == format!("{:016x}", bench_scene.hash));
        let Reference { picture, region } = reference.of_whole(bench_scene);
        if of_this && (picture.width, picture.height) == (region.width, region.height) {
            return Ok(Some(reference));
        }
        log::warn!("{} is of another size or scene; it is not used", reference.path.display());
        Ok(None)
    }

    /// The beginning of the names of all references of a scene and view.
    fn stem(&self, bench_scene: &BenchScene) -> String {
        let RenderOptions { view: View { width, height, max_depth, .. }, camera, .. } = bench_scene.options;
        let depth = max_depth.map_or(String::new(), |depth| format!(".depth{depth}"));
        let stride = if self.stride > 1 { format!(".stride{}", self.stride) } else { String::new() };
        format!(
            "{}-{width}x{height}{stride}-{:016x}-camera{camera}{depth}-",
            bench_scene.name, bench_scene.hash
        )
    }

    fn path(&self, bench_scene: &BenchScene, label: &str) -> PathBuf {
        self.folder.join(self.stem(bench_scene) + &label.replace([':', ',', '='], "-") + ".exr")
    }

    /// The one that this integrator made, if there is one.
    pub(super) fn kept(
        &self,
        bench_scene: &BenchScene,
        label: &str,
    ) -> Result<Option<ReferenceFile>, CliError> {
        let path = self.path(bench_scene, label);
        let kept = path.exists().then(|| ReferenceFile::new(Picture::read(&path)?, path)).transpose()?;
        // Without the passes that it is made of, none can be added.
        Ok(kept.filter(|kept| kept.accumulated().is_some()))
    }

    /// The one with the least error of its own, and what made it.
    fn most_exact(&self, bench_scene: &BenchScene) -> Result<Option<(Candidate, ReferenceFile)>, CliError> {
        let mut best: Option<(Candidate, ReferenceFile)> = None;
        let stem = self.stem(bench_scene);
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
            let Some(maker) = maker.filter(|_| reference.accumulated().is_some()) else { continue };
            if best.as_ref().is_none_or(|(_, best)| error(&reference) < error(best)) {
                best = Some((maker, reference));
            }
        }
        Ok(best)
    }

    /// Time of the next pass of a reference; `None` where it is exact enough, or had its time.
    pub(super) fn next_pass(
        &self,
        accumulated: Option<&AccumulatedReference>,
        noise: Option<ReferenceNoise>,
    ) -> Option<Duration> {
        let time = match (self.time, self.error) {
            (None, None) => Some(DEFAULT_TIME),
            (time, _) => time,
        };
        let had = Duration::from_secs_f64(accumulated.map_or(0.0, |accumulated| accumulated.seconds));
        let left = time.map_or(Duration::MAX, |time| time.saturating_sub(had));
        // A hundredth less is as good.
        let is_over = time.is_some_and(|time| left < time / 100);
        let is_exact = self.error.zip(noise).is_some_and(|(error, noise)| noise.mape <= error);
        // Not so many passes that they are short, nor so few that their scatter is unknown.
        let pass = (had / 4).clamp(Duration::from_secs(2), Duration::from_secs(60));
        let pass = pass.min(time.map_or(pass, |time| time / 8)).min(left);
        (!is_over && !is_exact).then_some(pass)
    }

    /// Adds passes to what is kept until it is exact enough or had its time; each is written to the file before the
    /// next begins. `None` where Ctrl-C ended that.
    ///
    /// # Errors
    /// As [`reference`](Self::reference).
    pub(super) fn grow(
        &self,
        context: &Context,
        bench_scene: &BenchScene,
        maker: &Candidate,
        kept: Option<ReferenceFile>,
        quiet: bool,
    ) -> Result<Option<ReferenceFile>, CliError> {
        let mut reference = kept;
        let mut accumulated = reference.as_ref().and_then(ReferenceFile::accumulated);
        let noise = |reference: &Option<ReferenceFile>| reference.as_ref().and_then(|kept| kept.noise);
        if self.next_pass(accumulated.as_ref(), noise(&reference)).is_none() {
            return Ok(reference);
        }
        std::fs::create_dir_all(&self.folder).map_err(CliError::folder(&self.folder))?;
        if !quiet {
            eprintln!("{}: a reference by {}{}", bench_scene.name, maker.label, self.limits());
        }
        let mut renderer = self.renderer(context, bench_scene, maker)?;
        while let Some(time) = self.next_pass(accumulated.as_ref(), noise(&reference)) {
            let Some(more) =
                AccumulatedReference::with_pass(accumulated, &mut renderer, 0, time, |_| interrupted())?
            else {
                return Ok(None);
            };
            let made = ReferenceFile::new(
                Picture {
                    metadata: self.metadata(context, bench_scene, maker, &more),
                    ..more.picture.clone()
                },
                self.path(bench_scene, &maker.label),
            )?;
            exr::write(&made.path, &made.picture)?;
            if !quiet {
                let error = made.noise.map_or("unknown".into(), |noise| percent(noise.mape));
                let seconds = short(more.seconds);
                eprintln!("{}: {} spp, {seconds} s, own MAPE {error}", bench_scene.name, more.samples);
            }
            (accumulated, reference) = (Some(more), Some(made));
            if interrupted() {
                return Ok(None);
            }
        }
        Ok(reference)
    }

    pub(super) fn renderer(
        &self,
        context: &Context,
        bench_scene: &BenchScene,
        maker: &Candidate,
    ) -> Result<Renderer, CliError> {
        let budget = Budget { time: self.time.map(TimeLimit::Total), ..Budget::default() };
        let View { width, height, .. } = bench_scene.options.view;
        let crop = (self.stride > 1).then(|| Region::lattice(width, height, self.stride));
        let options = maker.options(bench_scene, 1 << 63);
        let options = RenderOptions { budget, view: View { crop, ..options.view }, ..options };
        Ok(Renderer::new(context, &bench_scene.scene, options)?)
    }

    fn metadata(
        &self,
        context: &Context,
        bench_scene: &BenchScene,
        maker: &Candidate,
        accumulated: &AccumulatedReference,
    ) -> Vec<(String, Attribute)> {
        let passes: Vec<String> =
            accumulated.passes.iter().map(|pass| format!("{}:{}", pass.samples, pass.mean)).collect();
        vec![
            ("integrator".into(), Attribute::Text(maker.label.clone())),
            ("spp".into(), Attribute::Number(accumulated.samples as f64)),
            ("seconds".into(), Attribute::Number(accumulated.seconds)),
            ("passes".into(), Attribute::Text(passes.join(" "))),
            ("device".into(), Attribute::Text(maker_of(context))),
            ("sceneHash".into(), Attribute::Text(format!("{:016x}", bench_scene.hash))),
            ("nonFiniteSamples".into(), Attribute::Number(accumulated.non_finite as f64)),
            ("stride".into(), Attribute::Number(f64::from(self.stride))),
        ]
    }

    /// As a message has them.
    fn limits(&self) -> String {
        let time = self.time.or(self.error.is_none().then_some(DEFAULT_TIME));
        let time = time.map_or(String::new(), |time| format!(", {} s", time.as_secs_f64()));
        time + &self.error.map_or(String::new(), |error| format!(", own MAPE {}", percent(error)))
    }
}
