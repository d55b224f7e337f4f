//! Learning from the paths that connections by subspaces find themselves, by what earlier ones have taught: light that
//! path tracing hardly ever meets is found as soon as connections know where it is.
//!
//! Nothing here is shown: samples and the picture's are independent, so that whatever is learnt, the picture is unbiased.

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use crate::device::layout::LightFeature;
use crate::device::{DeviceError, Kernel};
use crate::film::Region;
use crate::math::statistics::{geometric_mean, mean};
use crate::subspace::{self, FirstConnections, LightSample, Model, TrainingSet};

use super::TrainingError;
use super::first_connections::FirstConnectionsTrial;
use super::options::{DEFAULT_ROUNDS, LONG_RENDER_ROUNDS, MOST_ROUNDS};
use super::records::{Records, light_features, light_sample, pixel_of};
use super::task::{
    Clock, LIGHT_PATHS, TrainingProgress, TrainingResult, TrainingTask, WarmStart, training_batch,
};
use crate::integrator::bidirectional::{Bidirectional, Purpose};
use crate::integrator::wavefront::total;
use crate::integrator::{Choice, Connections, Integrator as _, Method, Settings, SpcBpt, View};

/// Camera paths of an iteration at most: a small picture of the whole teaches as much as a large one.
const PATHS_AN_ITERATION: u32 = 1 << 14;
/// Room for records at first, for each of them.
const RECORDS_A_PATH: u32 = 8;
/// Connections after which more teach little that a picture shows: twice as many lower its variance by 4 to 10 %
/// (docs/measurements.md, Against pre-tracing as published). Each of the first rounds beyond the usual ones may have twice as
/// many, of some 100 bytes each.
const ENOUGH_NODES: usize = 1_500_000;

/// Variance by the choice of a connection, where an eye vertex has one, over that by eye paths, whatever they connect to.
/// Rounds lower the first only: as much as with this in two scenes (docs/measurements.md, Connections and shares by depth).
const VARIANCE_OF_A_CONNECTION: f64 = 4.0;
/// What a round gains, of what the two before it did on average (docs/measurements.md, Longer renders).
const GAIN_OF_THE_NEXT: f64 = 0.5;
/// Rounds that a warm start does without.
const ROUNDS_OF_A_WARM_START: u32 = 2;

/// Finds paths and learns from them, by turns.
///
/// # Errors
/// As [`super::train`].
pub(super) fn train(
    task: &TrainingTask,
    go_on: impl FnMut(TrainingProgress) -> Result<(), TrainingError>,
) -> Result<TrainingResult, TrainingError> {
    // After a warm start the caller asks whether the new model is better.
    Trainer::begin(task)?.run(task, task.warm_start.is_some(), go_on)
}

/// A round comes when there is twice as much to learn from as for the last.
fn iteration_of(round: u32) -> u32 {
    1 << (round.clamp(1, MOST_ROUNDS) - 1)
}

/// Connections that are enough for so many rounds.
fn enough_nodes(rounds: u32) -> usize {
    ENOUGH_NODES << (rounds.clamp(DEFAULT_ROUNDS, LONG_RENDER_ROUNDS) - DEFAULT_ROUNDS)
}

/// One iteration's paths, found by a model; with the mixture's density of it, p0 plus the sum over N Gamma / Q mass is 1
/// for each.
///
/// # Errors
/// As [`super::train`].
pub(super) fn find_paths(task: &TrainingTask, model: &Model) -> Result<TrainingSet, TrainingError> {
    let mut trainer = Trainer::new(task)?;
    trainer.integrator.set_model(&task.context, model)?;
    trainer.find_paths(task, 1)?;
    Ok(trainer.set)
}

/// What was found and learnt so far.
pub(super) struct Trainer {
    integrator: Bidirectional,
    samples_kernel: Kernel,
    records: Records,
    set: TrainingSet,
    first_connections: FirstConnectionsTrial,
    lights: Arc<Vec<LightSample>>,
    light_paths: u32,
    camera_paths: u64,
    pub model: Arc<Model>,
    /// The model before the last round, until it is known what that was worth.
    before: Option<Arc<Model>>,
    losses: Vec<f64>,
    clock: Clock,
}

impl Trainer {
    fn new(task: &TrainingTask) -> Result<Self, TrainingError> {
        let TrainingTask { context, scene, camera, settings, training, .. } = task;
        let settings = small(settings);
        let light_paths = settings.view.region().pixels();
        // Paths say how dense they are by these, all through.
        let connections = Connections { adapts: false, ..task.connections() };
        let method =
            Method::SpcBpt(SpcBpt { light_paths: Some(light_paths), connections, light_tracing: false });
        let settings = Settings { method, ..settings };
        let set = TrainingSet::new(settings.view.width, settings.view.height);
        let model = Model::untrained(&task.input(&set, &[], 0), training.settings.clone());
        let mut integrator =
            Bidirectional::new(context, scene.clone(), camera, settings, Some(&model), Purpose::Records)?;
        let samples_kernel = integrator.wavefront.compile(context, "light_samples", &[])?;
        let room = settings.view.region().pixels() * RECORDS_A_PATH;
        let records = Records::new(context, &mut integrator.wavefront, room)?;
        integrator.bind(context)?;
        // The driver compiles at the first dispatch: that is not learning's time.
        let tiny = integrator.wavefront.tiny_batch();
        integrator.find_paths(context, &tiny, 1)?;
        integrator.wavefront.reset(context)?;
        let batch = training_batch(&integrator.wavefront, 0);
        let tile_of = |path| {
            let [x, y] = pixel_of(&batch, path);
            set.tile_of(x, y)
        };
        let tiles = (0..batch.pixel_count).map(tile_of).collect();
        Ok(Self {
            integrator,
            samples_kernel,
            records,
            set,
            first_connections: FirstConnectionsTrial::new(tiles),
            lights: Arc::default(),
            light_paths: 0,
            camera_paths: 0,
            model: Arc::new(model),
            before: None,
            losses: Vec::new(),
            clock: Clock::new(),
        })
    }

    /// Compiles, and knows then how much light there is.
    ///
    /// # Errors
    /// As [`super::train`].
    pub fn begin(task: &TrainingTask) -> Result<Self, TrainingError> {
        let mut trainer = Self::new(task)?;
        match &task.warm_start {
            Some(warm_start) => {
                trainer.lights = warm_start.lights.clone();
                trainer.light_paths = warm_start.light_paths;
                trainer.model = warm_start.model.clone();
                trainer.integrator.set_model(&task.context, &warm_start.model)?;
            }
            None => trainer.look_for_light(task)?,
        }
        Ok(trainer)
    }

    /// Time since it began, compiling not counted.
    pub fn elapsed(&self) -> Duration {
        self.clock.elapsed()
    }

    /// All rounds. `judge_last`: find out what the last one was worth, too.
    ///
    /// # Errors
    /// As [`super::train`].
    pub fn run(
        mut self,
        task: &TrainingTask,
        judge_last: bool,
        mut go_on: impl FnMut(TrainingProgress) -> Result<(), TrainingError>,
    ) -> Result<TrainingResult, TrainingError> {
        let training = &task.training;
        let (usual, limit) = training.most_rounds();
        // A warm start has no use for what an iteration or two can teach.
        let skipped = if task.warm_start.is_some() { ROUNDS_OF_A_WARM_START.min(usual - 1) } else { 0 };
        let mut most = usual;
        let [mut iteration, mut taught] = [0, skipped];
        let mut next_round = iteration_of(taught + 1);
        let reason = loop {
            iteration += 1;
            let enough = enough_nodes(most);
            let found = self.find_paths(task, iteration)?;
            if let Some(loss) = self.judge(found)? {
                go_on(TrainingProgress::Loss(loss))?;
                // Rounds beyond the usual ones were decided on before.
                if most == usual
                    && let Some(reason) = self.not_worth_another(task)
                {
                    break reason;
                }
            }
            let nodes = self.set.nodes().len();
            let share = f64::from(iteration) / f64::from(iteration_of(most));
            go_on(TrainingProgress::TrainingPaths(share.max(nodes as f64 / enough as f64).min(1.0)))?;
            let due = iteration >= next_round;
            let end = if nodes >= enough {
                Some("more connections would hardly teach more")
            } else if due && taught + 1 >= most {
                Some("as many as wanted")
            } else {
                None
            };
            if due || end.is_some() {
                go_on(TrainingProgress::Fitting)?;
                self.learn(task)?;
                taught += 1;
                next_round = 2 * iteration;
                go_on(TrainingProgress::Round(self.model.clone()))?;
            }
            match end {
                // A render that is long enough gains by more, as long as rounds do.
                Some(_) if most < limit && self.not_worth_another(task).is_none() => {
                    most += 1;
                }
                Some(reason) => break reason.to_string(),
                None => {}
            }
        };
        if judge_last && self.before.is_some() {
            let found = self.find_paths(task, iteration + 1)?;
            if let Some(loss) = self.judge(found)? {
                go_on(TrainingProgress::Loss(loss))?;
            }
        }
        // Paths that only judged the last round tell of first connections, too.
        let first_connections = self.wanted_connections(task);
        if first_connections != self.model.first_connections {
            Arc::make_mut(&mut self.model).first_connections = first_connections;
        }
        let warm_start =
            WarmStart { model: self.model.clone(), lights: self.lights, light_paths: self.light_paths };
        let mut result = self.clock.result(self.model, self.camera_paths);
        result.losses = self.losses;
        result.warm_start = Some(warm_start);
        result.choices.push(Choice::new("rounds", taught - skipped, reason));
        Ok(result)
    }

    /// What the last round was worth is said by paths that had no part in it; `None` if it is known.
    fn judge(&mut self, found: Range<usize>) -> Result<Option<f64>, TrainingError> {
        let Some(before) = self.before.take() else { return Ok(None) };
        let loss = 1.0 / subspace::relative_loss(&before, &self.set, found)?;
        self.losses.push(loss);
        Ok(Some(loss))
    }

    /// Why learning ends here. A few bright paths make single losses uncertain, so the last two that are known are asked
    /// together.
    fn not_worth_another(&self, task: &TrainingTask) -> Option<String> {
        let known = &self.losses[self.losses.len().saturating_sub(2)..];
        let gain = if known.is_empty() { 0.0 } else { 1.0 - geometric_mean(known) };
        let counts = task.connections().counts.map(f64::from);
        let (training, connections) = (&task.training, mean(&counts));
        let share_of_choice = VARIANCE_OF_A_CONNECTION / (VARIANCE_OF_A_CONNECTION + connections);
        let variance = GAIN_OF_THE_NEXT * gain * share_of_choice;
        // The next round comes when there is twice as much to learn from.
        let share = training.share_of_render(self.camera_paths, self.clock.time_per_path(self.camera_paths));
        if training.least_gain == 0.0 || (gain >= training.least_gain && variance >= share) {
            return None;
        }
        let gained = format!("lately a round lowered the loss by {:.0} %", 100.0 * gain);
        Some(match gain < training.least_gain {
            true => format!("{gained} only"),
            false => format!(
                "{gained}, so another may lower the variance by {:.0} %, and would take {:.0} % of the render",
                100.0 * variance,
                100.0 * share
            ),
        })
    }

    /// Learns how much light there is: connections then choose by power.
    fn look_for_light(&mut self, task: &TrainingTask) -> Result<(), TrainingError> {
        let paths = self.integrator.wavefront.settings.view.region().pixels();
        let batch = training_batch(&self.integrator.wavefront, 0);
        let counts = self.integrator.fill_cache(&task.context, &batch, paths)?;
        let features = self.cache(task, counts.light_vertices)?;
        self.take_lights(&features, paths);
        self.learn(task)?;
        // Before this one nothing was found.
        self.before = None;
        Ok(())
    }

    /// One camera path per pixel against a cache of light paths; says which full paths that found.
    fn find_paths(&mut self, task: &TrainingTask, iteration: u32) -> Result<Range<usize>, TrainingError> {
        let context = &task.context;
        let first = self.set.paths().len();
        let connections = task.connections();
        let batch = training_batch(&self.integrator.wavefront, iteration);
        let paths = self.integrator.wavefront.settings.view.region().pixels();
        loop {
            self.records.clear(context, &self.integrator.wavefront)?;
            let counts = self.integrator.find_paths(context, &batch, paths)?;
            let after = self.integrator.wavefront.counts(context)?;
            let features = self.cache(task, counts.light_vertices)?;
            let wavefront = &mut self.integrator.wavefront;
            match self.records.take(context, wavefront, &batch, &features, &connections, &mut self.set)? {
                None => {
                    self.take_lights(&features, paths);
                    self.camera_paths += u64::from(batch.pixel_count * batch.sample_count);
                    // Before there is anything to choose by, more is left to chance than in the render.
                    if iteration > 1 {
                        let rays = total(after.closest_total) - total(counts.closest_total);
                        self.first_connections.take(&self.records.light, rays, self.records.connecting);
                    }
                    return Ok(first..self.set.paths().len());
                }
                Some(needed) => {
                    // Once more with room for all.
                    self.records = Records::new(context, wavefront, needed)?;
                    self.integrator.bind(context)?;
                }
            }
        }
    }

    fn cache(&mut self, task: &TrainingTask, vertices: u32) -> Result<Vec<LightFeature>, DeviceError> {
        light_features(&task.context, &mut self.integrator.wavefront, &self.samples_kernel, vertices)
    }

    fn take_lights(&mut self, features: &[LightFeature], paths: u32) {
        if self.light_paths < LIGHT_PATHS {
            let lights = Arc::make_mut(&mut self.lights);
            lights.extend(features.iter().filter(|feature| feature.weight > 0.0).map(light_sample));
            self.light_paths += paths;
        }
    }

    /// How many first connections are worth it, as far as is known by now.
    fn wanted_connections(&self, task: &TrainingTask) -> Option<FirstConnections> {
        self.first_connections.wanted(task.connections().counts[0])
    }

    fn learn(&mut self, task: &TrainingTask) -> Result<(), TrainingError> {
        let input = task.input(&self.set, &self.lights, self.light_paths);
        let first_connections = self.wanted_connections(task);
        let model = self.clock.learn(|| task.fit(&input, first_connections))?;
        self.before = Some(std::mem::replace(&mut self.model, model));
        self.integrator.set_model(&task.context, &self.model)?;
        Ok(())
    }
}

/// The same picture, but not larger than an iteration; of a part with gaps all of it.
fn small(settings: &Settings) -> Settings {
    let part = settings.view.region().hull();
    let whole = part.pixels();
    let factor = (f64::from(PATHS_AN_ITERATION) / f64::from(whole)).sqrt().min(1.0);
    let scaled = |pixels: u32| ((f64::from(pixels) * factor) as u32).max(1);
    let region = Region::new(
        (f64::from(part.x) * factor) as u32,
        (f64::from(part.y) * factor) as u32,
        scaled(part.width),
        scaled(part.height),
    );
    let view = View {
        width: scaled(settings.view.width).max(region.x + region.width),
        height: scaled(settings.view.height).max(region.y + region.height),
        crop: Some(region),
        ..settings.view
    };
    Settings { view, ..*settings }
}

#[cfg(test)]
mod tests {
    use super::{ENOUGH_NODES, enough_nodes};

    #[test]
    fn more_rounds_may_learn_from_more() {
        assert_eq!([1, 5, 6, 7, 16].map(enough_nodes), [1, 1, 2, 4, 4].map(|times| times * ENOUGH_NODES));
    }
}
