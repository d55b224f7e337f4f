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

/// What there is to hear.
pub enum TrainingEvent {
    /// Connect by this from now on.
    Round(Arc<Model>),
    /// The loss by the model that came last, over that by the one before it. It is told by paths that no picture shows.
    Loss(f64),
    /// Learning is over.
    End(Box<TrainingResult>),
}

/// A course that knows how much light there is, and goes on when it is told to.
pub struct PreparedTrainer {
    lesson: TrainingTask,
    course: Trainer,
}

impl PreparedTrainer {
    /// Compiles, and looks for light, which takes a moment.
    ///
    /// # Errors
    /// As [`super::train`].
    pub fn new(lesson: TrainingTask) -> Result<Self, TrainingError> {
        let course = Trainer::begin(&lesson)?;
        Ok(Self { lesson, course })
    }

    /// Chooses by power.
    pub fn model(&self) -> &Arc<Model> {
        &self.course.model
    }

    /// Time that it took, compiling not counted.
    pub fn elapsed(&self) -> Duration {
        self.course.elapsed()
    }

    /// Learns from now on.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(self) -> Result<OnlineTraining, TrainingError> {
        let Self { lesson, course } = self;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let (tell, news) = mpsc::channel();
        let work = move || {
            // Where nobody listens any more, that is the end.
            let say = |news| tell.send(news).map_err(|_| TrainingError::Interrupted);
            let trained = course.run(&lesson, true, |step| match step {
                _ if stopped.load(Ordering::Relaxed) => Err(TrainingError::Interrupted),
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
            .map_err(|cause| TrainingError::Thread { cause })?;
        Ok(OnlineTraining { news, stop, thread: Some(thread) })
    }
}

/// A course that runs; dropped, it ends after the step that it is at.
pub struct OnlineTraining {
    news: Receiver<Result<TrainingEvent, TrainingError>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnlineTraining {
    /// What has come since, oldest first; does not wait.
    ///
    /// # Errors
    /// What ended the course, other than its end.
    pub fn hear(&self) -> Result<Option<TrainingEvent>, TrainingError> {
        match self.news.try_recv() {
            Ok(news) => news.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            // It told its end before; without one it has panicked.
            Err(TryRecvError::Disconnected) => Err(TrainingError::Panicked),
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
