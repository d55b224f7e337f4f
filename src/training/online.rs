//! Learning on a thread of its own, while pictures are rendered by what was learnt so far.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::device::DeviceError;
use crate::render::RenderError;
use crate::subspace::Model;

use super::TrainingResult;
use super::guided::Trainer;
use super::task::{TrainingProgress, TrainingTask};

/// What there is to hear.
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
    pub fn new(task: TrainingTask) -> Result<Self, RenderError> {
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
    pub fn start(self) -> Result<OnlineTraining, RenderError> {
        let Self { task, trainer } = self;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let (tell, news) = mpsc::channel();
        let work = move || {
            // Where nobody listens any more, that is the end.
            let say = |news| tell.send(news).map_err(|_| RenderError::Interrupted);
            let trained = trainer.run(&task, true, |step| match step {
                _ if stopped.load(Ordering::Relaxed) => Err(RenderError::Interrupted),
                TrainingProgress::Round(model) => say(Ok(TrainingEvent::Round(model))),
                TrainingProgress::Loss(loss) => say(Ok(TrainingEvent::Loss(loss))),
                TrainingProgress::TrainingPaths(_)
                | TrainingProgress::LightPaths(_)
                | TrainingProgress::Fitting => Ok(()),
            });
            let _ = say(trained.map(|trained| TrainingEvent::End(Box::new(trained))));
        };
        let thread = thread::Builder::new()
            .name("learning".into())
            .spawn(work)
            .map_err(|error| DeviceError::Thread { message: error.to_string() })?;
        Ok(OnlineTraining { news, stop, thread: Some(thread) })
    }
}

/// A trainer that runs; dropped, it ends after the step that it is at.
pub struct OnlineTraining {
    news: Receiver<Result<TrainingEvent, RenderError>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnlineTraining {
    /// What has come since, oldest first; does not wait.
    ///
    /// # Errors
    /// What ended the trainer, other than its end.
    pub fn hear(&self) -> Result<Option<TrainingEvent>, RenderError> {
        match self.news.try_recv() {
            Ok(news) => news.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            // It told its end before; without one it has panicked.
            Err(TryRecvError::Disconnected) => {
                Err(DeviceError::Thread { message: "it ended without a word".into() }.into())
            }
        }
    }
}

impl Drop for OnlineTraining {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // What it panicked of is on stderr, and was heard as an end without a word.
            let _ = thread.join();
        }
    }
}
