//! What takes long, on a thread of its own: loading, learning, compiling.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::render::{Prepared, RenderError, RenderOptions, Renderer, Uploaded};
use crate::scene::{Camera, Scene};
use crate::training::{TrainingProgress, TrainingResult, WarmStart};

use super::Settings;
use super::snapshot::Making;

/// What comes of it.
pub enum Built {
    Scene(Arc<Scene>, Box<Uploaded>),
    Film(Box<Renderer>, Option<WarmStart>),
    /// Something was learnt for another view.
    Round(Box<TrainingResult>),
}

/// What it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Scene,
    Film,
    Round,
}

/// Why nothing came of it.
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

/// Dropped, it ends as soon as it can.
pub struct Builder {
    pub purpose: Purpose,
    /// The integrator that it is for, and the view.
    pub slot: usize,
    pub view: u64,
    state: Arc<State>,
    result: Receiver<Result<Built, Failure>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct State {
    stop: AtomicBool,
    making: Mutex<Making>,
}

impl State {
    fn say(&self, what: &str, share: Option<f32>) {
        if let Ok(mut making) = self.making.lock() {
            *making = Making { what: what.to_string(), share };
        }
    }

    /// True where it is to end.
    fn learning(&self, step: &TrainingProgress) -> bool {
        match step {
            TrainingProgress::TrainingPaths(share) => self.say("learning: paths", Some(*share as f32)),
            TrainingProgress::LightPaths(share) => self.say("learning: light paths", Some(*share as f32)),
            TrainingProgress::Fitting => self.say("learning: subspaces and Gamma", None),
            TrainingProgress::Round(_) | TrainingProgress::Loss(_) => {}
        }
        self.stop.load(Ordering::Relaxed)
    }
}

impl Builder {
    /// Loads the scene, for the first time or anew.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn scene(settings: &Arc<Settings>, again: bool) -> Result<Self, RenderError> {
        let settings = settings.clone();
        Self::spawn(Purpose::Scene, 0, 0, move |state| {
            state.say("loading the scene", None);
            let loaded = match again {
                true => (settings.loader)().map_err(Failure::Scene)?,
                false => settings.scene.clone(),
            };
            state.say("building the BVH", None);
            let uploaded = Uploaded::new(&settings.context, &loaded, None)?;
            Ok(Built::Scene(loaded, Box::new(uploaded)))
        })
    }

    /// Learns where the integrator has to, and compiles.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn film(
        slot: usize,
        view: u64,
        uploaded: &Uploaded,
        camera: Camera,
        options: RenderOptions,
    ) -> Result<Self, RenderError> {
        let uploaded = uploaded.clone();
        Self::spawn(Purpose::Film, slot, view, move |state| {
            let name = options.method.name();
            let mut prepared = Prepared::of(&uploaded, &camera, options)?;
            let known = match prepared.learns() {
                Some(_) => {
                    state.say("learning", None);
                    prepared.learn(|step| state.learning(&step))?.warm_start
                }
                None => None,
            };
            state.say(&format!("compiling {name}"), None);
            Ok(Built::Film(Box::new(prepared.renderer()?), known))
        })
    }

    /// Learns for another view.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn lesson(
        slot: usize,
        view: u64,
        uploaded: &Uploaded,
        camera: Camera,
        options: RenderOptions,
        known: Option<WarmStart>,
    ) -> Result<Self, RenderError> {
        let uploaded = uploaded.clone();
        Self::spawn(Purpose::Round, slot, view, move |state| {
            state.say("learning for this view", None);
            let mut prepared = Prepared::of(&uploaded, &camera, options)?.after(known);
            Ok(Built::Round(Box::new(prepared.learn(|step| state.learning(&step))?)))
        })
    }

    fn spawn(
        purpose: Purpose,
        slot: usize,
        view: u64,
        work: impl FnOnce(&State) -> Result<Built, Failure> + Send + 'static,
    ) -> Result<Self, RenderError> {
        let state = Arc::new(State::default());
        let (tell, result) = mpsc::channel();
        let own = state.clone();
        let thread = thread::Builder::new()
            .name("builder".into())
            .spawn(move || {
                // Where nobody listens any more, nobody wants it.
                let _ = tell.send(work(&own));
            })
            .map_err(|cause| RenderError::Thread { purpose: "building", cause })?;
        Ok(Self { purpose, slot, view, state, result, thread: Some(thread) })
    }

    /// Nobody wants it any more: it ends as soon as it can, and nobody has to wait for that.
    pub fn stop(&self) {
        self.state.stop.store(true, Ordering::Relaxed);
    }

    /// What it does.
    pub fn making(&self) -> Making {
        self.state.making.lock().map(|making| making.clone()).unwrap_or_default()
    }

    /// What came of it, if it is over.
    pub fn take(&self) -> Option<Result<Built, Failure>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Err(Failure::Render(RenderError::Panicked { what: "building" })))
            }
        }
    }
}

impl Drop for Builder {
    fn drop(&mut self) {
        self.stop();
        if let Some(thread) = self.thread.take() {
            // What it panicked of is on stderr.
            let _ = thread.join();
        }
    }
}
