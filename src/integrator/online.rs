//! Learning on a thread of its own, while pictures are rendered by what was learnt so far.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crate::error::{DeviceError, RenderError};
use crate::subspace::Model;

use super::Trained;
use super::bootstrap::Course;
use super::learn::{Learning, Lesson};

/// What there is to hear.
pub enum News {
    /// Connect by this from now on.
    Lesson(Arc<Model>),
    /// The loss by the model that came last, over that by the one before it. It is told by paths that no picture shows.
    Loss(f64),
    /// Learning is over.
    End(Box<Trained>),
}

/// A course that knows how much light there is, and goes on when it is told to.
pub struct Beginning {
    lesson: Lesson,
    course: Course,
}

impl Beginning {
    /// Compiles, and looks for light, which takes a moment.
    ///
    /// # Errors
    /// As [`super::train`].
    pub fn new(lesson: Lesson) -> Result<Self, RenderError> {
        let course = Course::begin(&lesson)?;
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
    pub fn start(self) -> Result<Online, RenderError> {
        let Self { lesson, course } = self;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        let (tell, news) = mpsc::channel();
        let work = move || {
            // Where nobody listens any more, that is the end.
            let say = |news| tell.send(news).map_err(|_| RenderError::Interrupted);
            let trained = course.run(&lesson, true, |step| match step {
                _ if stopped.load(Ordering::Relaxed) => Err(RenderError::Interrupted),
                Learning::Lesson(model) => say(Ok(News::Lesson(model))),
                Learning::Loss(loss) => say(Ok(News::Loss(loss))),
                Learning::TrainingPaths(_) | Learning::LightPaths(_) | Learning::Fitting => Ok(()),
            });
            let _ = say(trained.map(|trained| News::End(Box::new(trained))));
        };
        let thread = thread::Builder::new()
            .name("learning".into())
            .spawn(work)
            .map_err(|error| DeviceError::Thread { message: error.to_string() })?;
        Ok(Online { news, stop, thread: Some(thread) })
    }
}

/// A course that runs; dropped, it ends after the step that it is at.
pub struct Online {
    news: Receiver<Result<News, RenderError>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Online {
    /// What has come since, oldest first; does not wait.
    ///
    /// # Errors
    /// What ended the course, other than its end.
    pub fn hear(&self) -> Result<Option<News>, RenderError> {
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

impl Drop for Online {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // What it panicked of is on stderr, and was heard as an end without a word.
            let _ = thread.join();
        }
    }
}
