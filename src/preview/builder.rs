//! What takes long, on a thread of its own: loading, training, compiling.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::render::{Prepared, RenderError, RenderOptions, Renderer, Uploaded};
use crate::scene::{Camera, Scene};
use crate::training::{TrainingProgress, TrainingResult, WarmStart};

use super::Settings;
use super::snapshot::Activity;

/// What was built.
pub enum Built {
    Scene(Arc<Scene>, Box<Uploaded>),
    Film(Box<Renderer>, Option<WarmStart>),
    /// A model for another view.
    Round(Box<TrainingResult>),
}

/// Which of them is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Scene,
    Film,
    Round,
}

/// Why nothing was built.
pub enum Failure {
    Stopped,
    /// The scene's file, in words for the user.
    Scene(String),
    Render(RenderError),
}

impl<E: Into<RenderError>> From<E> for Failure {
    fn from(error: E) -> Self {
        match error.into() {
            RenderError::Interrupted => Self::Stopped,
            error => Self::Render(error),
        }
    }
}

/// Dropped, it stops, and waits until its thread has ended.
pub struct Builder {
    pub purpose: Purpose,
    /// The integrator and the view that it builds for; 0 for a scene.
    pub slot: usize,
    pub view: u64,
    state: Arc<State>,
    result: Receiver<Result<Built, Failure>>,
    thread: Option<JoinHandle<()>>,
}

/// What both threads read and write.
#[derive(Default)]
struct State {
    stop: AtomicBool,
    activity: Mutex<Activity>,
}

impl State {
    fn set_activity(&self, what: &str, fraction: Option<f32>) {
        if let Ok(mut activity) = self.activity.lock() {
            *activity = Activity { what: what.to_string(), fraction };
        }
    }

    /// True where training is to stop.
    fn training(&self, step: &TrainingProgress) -> bool {
        match step {
            TrainingProgress::TrainingPaths(done) => self.set_activity("training: paths", Some(*done as f32)),
            TrainingProgress::LightPaths(done) => {
                self.set_activity("training: light paths", Some(*done as f32));
            }
            TrainingProgress::Fitting => self.set_activity("training: subspaces and Gamma", None),
            TrainingProgress::Round(_) | TrainingProgress::Loss(_) => {}
        }
        self.stop.load(Ordering::Relaxed)
    }
}

impl Builder {
    /// Puts the scene on the device; `again`: loads it from its file first.
    pub fn scene(settings: &Arc<Settings>, again: bool) -> Self {
        let settings = settings.clone();
        Self::spawn(Purpose::Scene, 0, 0, move |state| {
            state.set_activity("loading the scene", None);
            let scene = match again {
                true => (settings.loader)().map_err(Failure::Scene)?,
                false => settings.scene.clone(),
            };
            state.set_activity("building the BVH", None);
            let uploaded = Uploaded::new(&settings.context, &scene, None)?;
            Ok(Built::Scene(scene, Box::new(uploaded)))
        })
    }

    /// Trains where the method needs that, and compiles.
    pub fn film(slot: usize, view: u64, uploaded: &Uploaded, camera: Camera, options: RenderOptions) -> Self {
        let uploaded = uploaded.clone();
        Self::spawn(Purpose::Film, slot, view, move |state| {
            let name = options.method.name();
            let mut prepared = Prepared::of(&uploaded, &camera, options)?;
            let warm_start = match prepared.learns() {
                Some(_) => {
                    state.set_activity("training", None);
                    prepared.learn(|step| state.training(&step))?.warm_start
                }
                None => None,
            };
            state.set_activity(&format!("compiling {name}"), None);
            Ok(Built::Film(Box::new(prepared.renderer()?), warm_start))
        })
    }

    /// Trains for another view.
    pub fn round(
        slot: usize,
        view: u64,
        uploaded: &Uploaded,
        camera: Camera,
        options: RenderOptions,
        warm_start: Option<WarmStart>,
    ) -> Self {
        let uploaded = uploaded.clone();
        Self::spawn(Purpose::Round, slot, view, move |state| {
            state.set_activity("training for this view", None);
            let mut prepared = Prepared::of(&uploaded, &camera, options)?.starting_from(warm_start);
            Ok(Built::Round(Box::new(prepared.learn(|step| state.training(&step))?)))
        })
    }

    fn spawn(
        purpose: Purpose,
        slot: usize,
        view: u64,
        work: impl FnOnce(&State) -> Result<Built, Failure> + Send + 'static,
    ) -> Self {
        let state = Arc::new(State::default());
        let (sender, result) = mpsc::channel();
        let (own_state, own_sender) = (state.clone(), sender.clone());
        let spawned = thread::Builder::new().name("builder".into()).spawn(move || {
            // A builder that was dropped has no use for the result.
            let _ = own_sender.send(work(&own_state));
        });
        let thread = match spawned {
            Ok(thread) => Some(thread),
            Err(cause) => {
                let error = RenderError::Thread { purpose: "work in the background", cause };
                let _ = sender.send(Err(Failure::Render(error)));
                None
            }
        };
        Self { purpose, slot, view, state, result, thread }
    }

    /// Asks the thread to end as soon as it can, and does not wait for that.
    pub fn stop(&self) {
        self.state.stop.store(true, Ordering::Relaxed);
    }

    pub fn activity(&self) -> Activity {
        self.state.activity.lock().map(|activity| activity.clone()).unwrap_or_default()
    }

    /// The result, once, if there is one.
    pub fn take(&self) -> Option<Result<Built, Failure>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err(Failure::Render(RenderError::Panicked { what: "work in the background" })))
            }
        }
    }
}

impl Drop for Builder {
    fn drop(&mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // The message of a panic is on stderr.
            let _ = thread.join();
        }
    }
}
