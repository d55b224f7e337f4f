//! What each message does: commands of the window, and results of the builder.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use crate::device::DeviceError;
use crate::preview::SLOTS;
use crate::preview::builder::{Builder, Built, Failure, Purpose};
use crate::preview::film::Film;
use crate::render::{RenderError, Uploaded};
use crate::scene::Scene;
use crate::training::TrainingResult;

use super::messages::{Command, Event, Request};
use super::{Round, State};

/// A model that lowers the loss by a smaller share is not taken: earlier samples would weigh less for next to nothing.
const LEAST_GAIN: f64 = 0.05;
/// Where there is nothing to render, the worker waits so long for a command before it asks the builder again.
const IDLE_WAIT: Duration = Duration::from_millis(30);

impl State {
    /// Handles the commands that are there; waits a moment for one where there is nothing to render.
    pub(super) fn poll_commands(&mut self) {
        if self.next_film().is_none() {
            match self.commands.recv_timeout(IDLE_WAIT) {
                Ok(command) => self.handle(command),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.quits = true,
            }
        }
        while let Ok(command) = self.commands.try_recv() {
            self.handle(command);
        }
    }

    fn handle(&mut self, command: Command) {
        self.unpublished = true;
        match command {
            Command::Request(request) => self.take_request(*request),
            Command::Save(save) => self.saves.push(save),
            Command::Restart => {
                self.films.iter_mut().flatten().for_each(Film::forget);
                self.failed = [false; SLOTS];
            }
            Command::Reload => {
                self.stop_builder();
                self.builder = Some(Builder::scene(&self.settings, true));
            }
            Command::Quit => self.quits = true,
        }
    }

    fn take_request(&mut self, request: Request) {
        self.shared.abandon.store(false, Ordering::Relaxed);
        if request.view != self.request.view {
            self.moved = Instant::now();
            self.save_last_seen();
        }
        if request.slot != self.request.slot || request.beside != self.request.beside {
            self.failed = [false; SLOTS];
        }
        if request.denoised != self.request.denoised {
            self.denoising.try_again();
        }
        self.request = request;
    }

    /// Its thread ends as soon as it can, without being waited for.
    pub(super) fn stop_builder(&mut self) {
        if let Some(builder) = self.builder.take() {
            builder.stop();
            self.stopped_builders.push(builder);
        }
    }

    /// Takes what the builder has made, if it is done.
    pub(super) fn poll_builder(&mut self) -> Result<(), RenderError> {
        self.stopped_builders.retain(|builder| builder.take().is_none());
        let Some(builder) = &self.builder else { return Ok(()) };
        let activity = builder.activity();
        if self.activity.as_ref() != Some(&activity) {
            self.activity = Some(activity);
            self.unpublished = true;
        }
        let Some(result) = builder.take() else { return Ok(()) };
        self.unpublished = true;
        self.activity = None;
        let (purpose, slot, view) = (builder.purpose, builder.slot, builder.view);
        self.builder = None;
        match result {
            Ok(Built::Scene(scene, uploaded)) => self.take_scene(scene, *uploaded),
            Ok(Built::Film(mut renderer, warm_start)) => {
                renderer.limit_submissions(self.submission_limit());
                self.films[slot] = Some(Film::new(*renderer, view, warm_start));
            }
            Ok(Built::Round(trained)) => self.take_round(slot, view, *trained),
            Err(Failure::Stopped) => {}
            Err(Failure::Scene(message)) => self.send(Event::Failed(message)),
            Err(Failure::Render(error @ RenderError::Device(DeviceError::Lost { .. }))) => return Err(error),
            Err(Failure::Render(error)) => self.build_failed(purpose, slot, view, &error),
        }
        Ok(())
    }

    /// It is not tried again before something else is requested.
    fn build_failed(&mut self, purpose: Purpose, slot: usize, view: u64, error: &RenderError) {
        match purpose {
            Purpose::Scene => self.scene_failed = true,
            Purpose::Film => self.failed[slot] = true,
            Purpose::Round => {
                if let Some(film) = &mut self.films[slot] {
                    film.trained_view = view;
                }
            }
        }
        self.send(Event::Failed(error.to_string()));
    }

    fn take_scene(&mut self, scene: Arc<Scene>, uploaded: Uploaded) {
        // Renderers of the last scene are dropped before those of this one are made: the device has room for one.
        self.films = [const { None }; SLOTS];
        self.failed = [false; SLOTS];
        self.next_round = None;
        self.uploaded = Some(uploaded);
        self.scene_failed = false;
        if self.settings.options.model.is_some() && !self.model_fits() {
            let message = "the model belongs to another state of the scene: a new one is trained instead";
            self.send(Event::Failed(message.into()));
        }
        self.send(Event::Loaded(scene));
    }

    fn take_round(&mut self, slot: usize, view: u64, trained: TrainingResult) {
        let Some(film) = &mut self.films[slot] else { return };
        film.trained_view = view;
        film.warm_start = trained.warm_start;
        let loss = (!trained.losses.is_empty()).then(|| trained.losses.iter().product::<f64>());
        if loss.is_none_or(|loss| loss < 1.0 - LEAST_GAIN) {
            // The loss is over that of the round before, which may still wait to be taken by the film.
            let before = self.next_round.take().and_then(|round| round.loss).unwrap_or(1.0);
            let loss = loss.map(|loss| loss * before);
            self.next_round = Some(Round { slot, model: trained.model, loss });
        } else if let (Some(warm_start), Some(model)) = (&mut film.warm_start, &film.renderer.model) {
            warm_start.model = model.clone();
        }
    }
}
