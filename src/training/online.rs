//! Learning on a thread of its own, while pictures are rendered by what was learnt so far.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::subspace::Model;

use super::guided::Trainer;
use super::task::{TrainingProgress, TrainingTask};
use super::{TrainingError, TrainingResult};

/// What happened since the last [`OnlineTraining::poll`].
pub enum TrainingEvent {
    /// Connect by this from now on.
    Round(Arc<Model>),
    /// The loss by the model that came last, over that by the one before it. It is told by paths that no picture shows.
    Loss(f64),
    /// Learning is over.
    End(Box<TrainingResult>),
}

/// A trainer that knows how much light there is, and goes on when it is told to.
pub struct PreparedTrainer {
    task: TrainingTask,
    trainer: Trainer,
}

impl PreparedTrainer {
    /// Compiles, and looks for light, which takes a moment.
    ///
    /// # Errors
    /// As [`super::train`].
    pub fn new(task: TrainingTask) -> Result<Self, TrainingError> {
        let trainer = Trainer::begin(&task)?;
        Ok(Self { task, trainer })
    }

    /// Chooses by power.
    pub fn model(&self) -> &Arc<Model> {
        &self.trainer.model
    }

    /// Time that it took, compiling not counted.
    pub fn elapsed(&self) -> Duration {
        self.trainer.elapsed()
    }

    /// Learns from now on.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(self) -> Result<OnlineTraining, TrainingError> {
        let Self { task, trainer } = self;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let (sender, events) = mpsc::channel();
        let work = move || {
            // A receiver that is gone ends the training.
            let publish = |event| sender.send(event).map_err(|_| TrainingError::Interrupted);
            let result = trainer.run(&task, true, |step| match step {
                _ if stopped.load(Ordering::Relaxed) => Err(TrainingError::Interrupted),
                TrainingProgress::Round(model) => publish(Ok(TrainingEvent::Round(model))),
                TrainingProgress::Loss(loss) => publish(Ok(TrainingEvent::Loss(loss))),
                TrainingProgress::TrainingPaths(_)
                | TrainingProgress::LightPaths(_)
                | TrainingProgress::Fitting => Ok(()),
            });
            let _ = publish(result.map(|result| TrainingEvent::End(Box::new(result))));
        };
        let thread = thread::Builder::new()
            .name("learning".into())
            .spawn(work)
            .map_err(|cause| TrainingError::Thread { cause })?;
        Ok(OnlineTraining { events, stop, thread: Some(thread) })
    }
}

/// A trainer that runs; dropped, it ends after the step that it is at.
pub struct OnlineTraining {
    events: Receiver<Result<TrainingEvent, TrainingError>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnlineTraining {
    /// What has come since, oldest first; does not wait.
    ///
    /// # Errors
    /// What ended the trainer, other than its end.
    pub fn poll(&self) -> Result<Option<TrainingEvent>, TrainingError> {
        match self.events.try_recv() {
            Ok(event) => event.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            // Its end comes before; without one it has panicked.
            Err(TryRecvError::Disconnected) => Err(TrainingError::Panicked),
        }
    }
}

impl Drop for OnlineTraining {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // The reason of a panic is on stderr, and `poll` has reported it.
            let _ = thread.join();
        }
    }
}
