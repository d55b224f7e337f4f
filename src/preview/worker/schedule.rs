//! What is built and rendered next, in which slices, and when a snapshot is due.

use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::device::layout::SAMPLES_A_GROUP;
use crate::integrator::SubmissionLimit;
use crate::preview::SLOTS;
use crate::preview::builder::{Builder, Purpose};
use crate::preview::film::Aim;
use crate::render::{RenderError, RenderOptions};
use crate::training::When;

use super::State;

/// What differs between GPUs and software devices.
struct Tuning {
    /// A frame of the window waits for one submission at most; on software, dispatches are dear.
    submission: Duration,
    /// Sides of the picture are divided by this while the camera moves, until the time of a sample is measured.
    first_divisor: u32,
}

const GPU: Tuning = Tuning { submission: Duration::from_millis(20), first_divisor: 1 };
const SOFTWARE: Tuning = Tuning { submission: Duration::from_millis(100), first_divisor: 4 };

/// Seconds of a step, and of a sample while the camera moves.
const STEP: f64 = 0.1;
const MOVING_STEP: f64 = 0.05;
/// The camera stands still once it has not moved for so long; after `SETTLED`, training for its view is worth its time.
const STILL: Duration = Duration::from_millis(250);
const SETTLED: Duration = Duration::from_millis(1000);
/// Time between snapshots, over the time that one takes.
const SNAPSHOT_INTERVAL: u32 = 3;

impl State {
    fn tuning(&self) -> &'static Tuning {
        if self.settings.context.is_cpu() { &SOFTWARE } else { &GPU }
    }

    pub(super) fn submission_limit(&self) -> SubmissionLimit {
        SubmissionLimit { slice: self.tuning().submission, abandon: self.shared.abandon.clone() }
    }

    fn is_moving(&self) -> bool {
        self.request.moving || (self.request.view > 0 && self.moved.elapsed() < STILL)
    }

    fn options(&self, slot: usize) -> RenderOptions {
        let mut options = self.settings.options.clone();
        options.method = self.settings.methods[slot];
        options.training.when = Some(When::First);
        options.first_hit_layers = true;
        options.timing = true;
        options.model = options.model.filter(|_| self.model_fits());
        options
    }

    /// There is a model, and it belongs to the scene as it is now.
    pub(super) fn model_fits(&self) -> bool {
        let hash = self.uploaded.as_ref().map(|uploaded| uploaded.hash);
        self.settings.options.model.as_ref().is_some_and(|model| Some(model.scene_hash) == hash)
    }

    /// The method needs a model that has to be trained.
    fn has_to_train(&self, slot: usize) -> bool {
        let has_lights = self.uploaded.as_ref().is_some_and(|uploaded| uploaded.has_lights());
        self.settings.methods[slot].plan().learns() && !self.model_fits() && has_lights
    }

    /// Starts to build what was requested and is missing.
    pub(super) fn build(&mut self) {
        if self.builder.as_ref().is_some_and(|builder| self.is_superfluous(builder)) {
            self.stop_builder();
        }
        if self.builder.is_none() {
            self.builder = self.next_builder();
        }
    }

    /// It builds a film that is requested no more. The first film is finished all the same: there is none to show yet.
    fn is_superfluous(&self, builder: &Builder) -> bool {
        let requested = [Some(self.request.slot), self.request.beside];
        builder.purpose == Purpose::Film
            && self.films.iter().any(Option::is_some)
            && !requested.contains(&Some(builder.slot))
    }

    fn next_builder(&self) -> Option<Builder> {
        let Some(uploaded) = &self.uploaded else {
            return (!self.scene_failed).then(|| Builder::scene(&self.settings, false));
        };
        let (slot, view, camera) = (self.request.slot, self.request.view, self.request.camera.clone());
        let missing = [self.stand_in(), Some(slot), self.request.beside]
            .into_iter()
            .flatten()
            .find(|&slot| self.films[slot].is_none() && !self.failed[slot]);
        if let Some(slot) = missing {
            return Some(Builder::film(slot, view, uploaded, camera, self.options(slot)));
        }
        let settled = !self.is_moving() && self.moved.elapsed() >= SETTLED && !self.request.paused;
        let film = self.films[slot].as_ref()?;
        (settled && film.trained_view != view && self.has_to_train(slot)).then(|| {
            let (options, warm_start) = (self.options(slot), film.warm_start.clone());
            Builder::round(slot, view, uploaded, camera, options, warm_start)
        })
    }

    /// The first method that trains nothing, to be seen while the first film is trained for.
    fn stand_in(&self) -> Option<usize> {
        let needed = self.has_to_train(self.request.slot) && self.films.iter().all(Option::is_none);
        (0..SLOTS).find(|&slot| needed && !self.has_to_train(slot))
    }

    /// The film that was requested, or another until that is made.
    fn seen(&self) -> usize {
        let there = |slot: &usize| self.films[*slot].is_some();
        [self.request.slot, self.shown]
            .into_iter()
            .find(there)
            .or((0..SLOTS).find(there))
            .unwrap_or(self.shown)
    }

    /// The film that is rendered next: of two, the one with less time spent on it; `None` where all is done.
    pub(super) fn next_film(&self) -> Option<usize> {
        let moving = self.is_moving();
        if self.request.paused && !moving && self.saves.is_empty() {
            return None;
        }
        let time_spent = |slot: usize| {
            let film = self.films[slot].as_ref()?;
            let fresh = !film.is_whole(self.request.view);
            let more = self.request.samples.is_none_or(|most| film.renderer.samples() < most);
            (fresh || more).then_some((slot, if fresh { Duration::ZERO } else { film.renderer.elapsed() }))
        };
        let beside = self.request.beside.filter(|_| !moving);
        let both = [Some(self.seen()), beside].into_iter().flatten();
        both.filter_map(time_spent).min_by_key(|(_, elapsed)| *elapsed).map(|(slot, _)| slot)
    }

    /// Renders one step.
    pub(super) fn render(&mut self) -> Result<(), RenderError> {
        self.shown = self.seen();
        let Some(slot) = self.next_film() else { return Ok(()) };
        self.working = slot;
        let (moving, first_divisor) = (self.is_moving(), self.tuning().first_divisor);
        let aim = Aim {
            camera: self.request.camera.clone(),
            view: self.request.view,
            size: [self.settings.options.view.width, self.settings.options.view.height],
        };
        let Some(film) = &mut self.films[slot] else { return Ok(()) };
        let divisor = if moving { film.divisor_for(MOVING_STEP, first_divisor) } else { 1 };
        // A moving picture keeps its size until the camera goes on: else it would never gather samples.
        let keeps = moving && film.view() == Some(aim.view);
        film.aim(&aim, if keeps { film.divisor } else { divisor })?;
        let samples = film.renderer.samples();
        let mut most = self.request.samples.map_or(u32::MAX, |limit| limit.saturating_sub(samples).max(1));
        // Samples of a group are all made using one model.
        let in_group = samples % SAMPLES_A_GROUP;
        if let Some(round) = self.next_round.take_if(|round| round.slot == slot && in_group == 0) {
            film.use_model(round.model, round.loss)?;
        } else if self.next_round.as_ref().is_some_and(|round| round.slot == slot) {
            most = most.min(SAMPLES_A_GROUP - in_group);
        }
        self.shared.abandonable.store(film.divisor == 1, Ordering::Relaxed);
        if film.divisor > 1 {
            self.shared.abandon.store(false, Ordering::Relaxed);
        }
        film.step(STEP, most)?;
        film.estimate()?;
        self.unpublished = true;
        Ok(())
    }

    /// Making snapshots takes a limited share of the time; the last one, before the worker idles, is always due.
    pub(super) fn snapshot_is_due(&self) -> bool {
        let due = self.last_snapshot.is_none_or(|(end, taken)| end.elapsed() >= SNAPSHOT_INTERVAL * taken);
        self.unpublished && (due || self.next_film().is_none())
    }
}
