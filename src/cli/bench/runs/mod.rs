//! The renders of one scene: those that are stored, and those that are still to be made.

mod record;
mod results;

use std::time::Duration;

use crate::bench::key::{self, RunKey, Settings};
use crate::bench::speed::SpeedProbe;
use crate::bench::trade::{Checkpoint, Plan, measure};
use crate::cli::CliError;
use crate::cli::args::InputError;
use crate::cli::bench::candidate::Candidate;
use crate::cli::bench::maker_of;
use crate::cli::bench::reference::ReferenceFile;
use crate::cli::bench::scene::BenchScene;
use crate::cli::progress::{interrupted, learn};
use crate::cli::text::short;
use crate::device::Context;
use crate::film::denoise::Denoiser;
use crate::math::fnv::fnv;
use crate::render::{Prepared, RenderError, RenderOptions};
use crate::training::When;

pub use record::{Drift, Record, Records};
pub use results::{Ask, CandidateResult, ReferenceResult};

/// A scene with its reference, to be rendered.
pub struct SceneRenders<'a> {
    pub context: &'a Context,
    pub bench_scene: BenchScene,
    pub reference: ReferenceFile,
    pub quiet: bool,
}

/// What is to be rendered of each scene: integrators, each by the same plan with the same number of seeds.
pub struct Series<'a> {
    pub candidates: &'a [Candidate],
    pub plan: Plan,
    /// How many, and the first of them.
    pub seeds: u32,
    pub first_seed: u32,
}

/// Renders that go on to a goal may do so for longer than others, not for less.
///
/// # Errors
/// `longest` is shorter than `time`.
pub fn check_longest(time: Duration, longest: Option<Duration>) -> Result<(), InputError> {
    match longest.is_some_and(|longest| longest < time) {
        true => {
            Err(InputError::Usage("--longest has to be at least --time; raise it, or leave it out".into()))
        }
        false => Ok(()),
    }
}

impl SceneRenders<'_> {
    /// The keys of each candidate's renders, seed by seed.
    fn keys(&self, series: &Series) -> Result<Vec<Vec<RunKey>>, CliError> {
        let seed = |one: &Candidate, round: u32| seed_of(one, series.first_seed.wrapping_add(round));
        let keys = |one: &Candidate| {
            (0..series.seeds).map(|round| self.key(&series.plan, one, seed(one, round))).collect()
        };
        series.candidates.iter().map(keys).collect()
    }

    /// Those that are stored: their checkpoints, by candidate and seed.
    ///
    /// # Errors
    /// Settings that no key can be made of.
    pub fn stored<'r>(
        &self,
        series: &Series,
        records: &'r Records,
    ) -> Result<Vec<Vec<&'r [Checkpoint]>>, CliError> {
        let of = |key: &RunKey| records.find(key);
        Ok(self.keys(series)?.iter().map(|keys| keys.iter().filter_map(of).collect()).collect())
    }

    /// Renders what is not stored; false where Ctrl-C ended it.
    ///
    /// # Errors
    /// What rendering reports, a record that cannot be written.
    pub fn render_all(
        &self,
        series: &Series,
        records: &mut Records,
        probe: &mut Option<SpeedProbe>,
        mut denoiser: Option<&mut Denoiser>,
    ) -> Result<bool, CliError> {
        let (count, seeds) = (series.candidates.len(), series.seeds);
        let keys = self.keys(series)?;
        let is_there = |key: &&RunKey| records.find(key).is_some();
        let there = keys.iter().flatten().filter(is_there).count();
        let mut left = count * seeds as usize - there;
        if there > 0 && !self.quiet {
            eprintln!("{}: {there} renders are there already, {left} to go", self.bench_scene.name);
        }
        for round in 0..seeds {
            for place in 0..count {
                let index = if round.is_multiple_of(2) { place } else { count - 1 - place };
                let (candidate, key) = (&series.candidates[index], &keys[index][round as usize]);
                if records.find(key).is_some() {
                    continue;
                }
                if !self.quiet {
                    let longest = series.plan.goal.map(|goal| goal.longest).or(series.plan.time);
                    let at_most = longest.map_or(String::new(), |longest| {
                        let minutes = left as f64 * longest.as_secs_f64() / 60.0;
                        format!(", at most {} min and their compiling", short(minutes))
                    });
                    eprintln!(
                        "{}: seed {} of {seeds}, {}; {left} renders{at_most}",
                        self.bench_scene.name,
                        round + 1,
                        candidate.label,
                    );
                }
                let probe = match probe.as_mut() {
                    Some(probe) => probe,
                    None => probe.insert(SpeedProbe::new(self.context)?),
                };
                let denoiser = denoiser.as_deref_mut().filter(|_| candidate.denoise);
                let Some(points) = self.render(candidate, &series.plan, key.seed, probe, denoiser)? else {
                    return Ok(false);
                };
                records.push(Record { key: key.clone(), checkpoints: points })?;
                left -= 1;
            }
        }
        Ok(true)
    }

    /// What a render's figures depend on.
    ///
    /// # Errors
    /// Settings that no key can be made of.
    pub fn key(&self, plan: &Plan, candidate: &Candidate, seed: u64) -> Result<RunKey, CliError> {
        let options = candidate.options(&self.bench_scene, seed);
        Ok(RunKey {
            key_version: key::VERSION,
            version: env!("CARGO_PKG_VERSION").into(),
            device: maker_of(self.context),
            scene: self.bench_scene.name.clone(),
            scene_hash: format!("{:016x}", self.bench_scene.hash),
            reference: format!("{:016x}", self.reference.hash()),
            size: [options.view.width, options.view.height],
            camera: options.camera,
            integrator: candidate.label.clone(),
            seed,
            settings: Settings::of(&options, plan)?,
        })
    }

    /// A render from the beginning, learning included; `None` where Ctrl-C ended it.
    fn render(
        &self,
        candidate: &Candidate,
        plan: &Plan,
        seed: u64,
        probe: &mut SpeedProbe,
        denoiser: Option<&mut Denoiser>,
    ) -> Result<Option<Vec<Checkpoint>>, CliError> {
        let options = RenderOptions { budget: plan.budget(), ..candidate.options(&self.bench_scene, seed) };
        let mut prepared = Prepared::new(self.context, &self.bench_scene.scene, options)?;
        let mut clock = probe.clock()?;
        if prepared.learns() == Some(When::First) {
            match learn(&mut prepared, true) {
                Err(RenderError::Interrupted) => return Ok(None),
                learnt => drop(learnt?),
            }
        }
        let mut renderer = prepared.renderer()?;
        let reference = self.reference.of_whole(&self.bench_scene);
        Ok(measure(&mut renderer, plan, &reference, &mut clock, denoiser, |_| interrupted())?)
    }
}

/// Renders of different integrators share no random numbers, so that their errors are independent.
pub fn seed_of(candidate: &Candidate, round: u32) -> u64 {
    let stream = fnv(candidate.label.as_bytes()) >> 33;
    stream << 32 | u64::from(round)
}
