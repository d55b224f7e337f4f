//! The thread that renders, and the window's handle on it. It takes requests and publishes snapshots.
//!
//! `handle.rs` says what each message does, `schedule.rs` what is built and rendered next, `publish.rs` what the window
//! and files are given.

mod denoising;
mod handle;
mod messages;
mod publish;
mod schedule;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::device::DeviceError;
use crate::render::{RenderError, Uploaded};
use crate::subspace::Model;

use super::builder::Builder;
use super::film::Film;
use super::snapshot::{Activity, Snapshot};
use super::{SLOTS, Settings};

use denoising::Denoising;
use messages::Command;
pub use messages::{Event, Request, Save, Saved};

/// The window's end of the worker; dropped, it ends the worker.
pub struct Worker {
    commands: Sender<Command>,
    events: Receiver<Event>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What both ends read and write.
#[derive(Default)]
struct Shared {
    latest: Mutex<Arc<Snapshot>>,
    /// Ends the step that is being rendered before its next submission.
    abandon: Arc<AtomicBool>,
    /// The step renders a whole picture. Small ones, for a moving camera, are finished: of a camera that never stands
    /// still there would be no picture otherwise.
    abandonable: AtomicBool,
}

impl Shared {
    fn latest(&self) -> Arc<Snapshot> {
        self.latest.lock().map(|latest| latest.clone()).unwrap_or_default()
    }
}

impl Worker {
    /// Starts with `request`. `notify` is called after every event and every snapshot, on the worker's thread.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(
        settings: Arc<Settings>,
        request: Request,
        notify: impl Fn() + Send + 'static,
    ) -> Result<Self, RenderError> {
        let (commands, received) = mpsc::channel();
        let (sender, events) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        let state = State {
            commands: received,
            events: sender,
            shared: shared.clone(),
            notify: Box::new(notify),
            settings,
            request,
            moved: Instant::now(),
            uploaded: None,
            scene_failed: false,
            films: [const { None }; SLOTS],
            failed: [false; SLOTS],
            builder: None,
            activity: None,
            stopped_builders: Vec::new(),
            next_round: None,
            shown: 0,
            working: 0,
            denoising: Denoising::default(),
            saves: Vec::new(),
            quits: false,
            snapshots: 0,
            last_snapshot: None,
            unpublished: true,
        };
        let thread = thread::Builder::new()
            .name("worker".into())
            .spawn(move || {
                let events = state.events.clone();
                if catch_unwind(AssertUnwindSafe(|| state.run())).is_err() {
                    let message = "the preview's worker has panicked; this is a defect, please report it";
                    let _ = events.send(Event::Lost(message.into()));
                }
            })
            .map_err(|cause| RenderError::Thread { purpose: "the window's worker", cause })?;
        Ok(Self { commands, events, shared, thread: Some(thread) })
    }

    /// Replaces the request; `moved`: what is being rendered shows another view, and may be abandoned.
    pub fn request(&self, request: Request, moved: bool) {
        if moved && self.shared.abandonable.load(Ordering::Relaxed) {
            self.shared.abandon.store(true, Ordering::Relaxed);
        }
        self.send(Command::Request(Box::new(request)));
    }

    /// Saves the current picture, as soon as it has a sample.
    pub fn save(&self, save: Save) {
        self.send(Command::Save(save));
    }

    /// Starts all pictures again.
    pub fn restart(&self) {
        self.send(Command::Restart);
    }

    /// Loads the scene again.
    pub fn reload(&self) {
        self.send(Command::Reload);
    }

    fn send(&self, command: Command) {
        // A worker that has ended has sent `Event::Lost`.
        let _ = self.commands.send(command);
    }

    /// The last snapshot that was published.
    pub fn snapshot(&self) -> Arc<Snapshot> {
        self.shared.latest()
    }

    /// The next event, if there is one.
    pub fn event(&self) -> Option<Event> {
        self.events.try_recv().ok()
    }

    /// Ends the worker after its current step and its saves, and returns the events since.
    pub fn finish(mut self) -> Vec<Event> {
        self.end();
        self.events.try_iter().collect()
    }

    fn end(&mut self) {
        self.send(Command::Quit);
        if let Some(thread) = self.thread.take() {
            // A panic was caught and sent as an event.
            let _ = thread.join();
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.end();
    }
}

/// A model that was trained for another view; the film takes it between groups of samples.
struct Round {
    slot: usize,
    model: Arc<Model>,
    /// Over that of the film's model, where it is known.
    loss: Option<f64>,
}

/// The worker's own end.
struct State {
    commands: Receiver<Command>,
    events: Sender<Event>,
    shared: Arc<Shared>,
    notify: Box<dyn Fn() + Send>,
    settings: Arc<Settings>,
    request: Request,
    /// When the camera moved last.
    moved: Instant,
    uploaded: Option<Uploaded>,
    /// The scene could not be put on the device; it is not tried again before it is loaded again.
    scene_failed: bool,
    films: [Option<Film>; SLOTS],
    /// Integrators that could not be made.
    failed: [bool; SLOTS],
    builder: Option<Builder>,
    /// What the builder was doing when it was last asked.
    activity: Option<Activity>,
    /// Builders whose result is of no use; their threads are still to end.
    stopped_builders: Vec<Builder>,
    next_round: Option<Round>,
    /// Whose picture is seen: another's than was requested, until that is made.
    shown: usize,
    /// The integrator that an error is put down to.
    working: usize,
    denoising: Denoising,
    saves: Vec<Save>,
    quits: bool,
    /// Published so far.
    snapshots: u64,
    /// When it was published, and how long it took to make.
    last_snapshot: Option<(Instant, Duration)>,
    /// Something has changed since the last snapshot.
    unpublished: bool,
}

impl State {
    fn run(mut self) {
        while !self.quits {
            self.poll_commands();
            if self.quits {
                break;
            }
            match self.turn() {
                Ok(()) => {}
                Err(RenderError::Device(DeviceError::Lost { message })) => {
                    return self.send(Event::Lost(message));
                }
                Err(error) => {
                    let slot = self.working;
                    self.fail(slot, &error);
                    self.films[slot] = None;
                    self.next_round = self.next_round.take().filter(|round| round.slot != slot);
                }
            }
        }
        // Saves that were asked for before the end.
        if let Err(error) = self.save() {
            self.send(Event::Lost(error.to_string()));
        }
    }

    fn turn(&mut self) -> Result<(), RenderError> {
        self.working = self.shown;
        self.poll_builder()?;
        self.build();
        self.render()?;
        self.save()?;
        self.publish()
    }

    fn send(&self, event: Event) {
        // A window that is closed needs no events.
        let _ = self.events.send(event);
        (self.notify)();
    }

    fn fail(&mut self, slot: usize, error: &RenderError) {
        self.failed[slot] = true;
        self.send(Event::Failed(error.to_string()));
    }
}
