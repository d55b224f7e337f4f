//! The thread that renders: it takes wishes, and tells what there is to show.

mod telling;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::device::DeviceError;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::tonemap::ViewTransform;
use crate::integrator::SubmissionLimit;
use crate::render::{RenderError, RenderOptions, Uploaded};
use crate::scene::{Camera, Scene};
use crate::subspace::Model;
use crate::training::When;

use super::builder::{Builder, Built, Failure, Purpose};
use super::film::{Aim, Film};
use super::snapshot::{Making, Snapshot};
use super::{SLOTS, Settings};

/// A frame of the window waits for one submission: on a GPU, and on a software device, whose dispatches are dear.
const SLICES: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(100)];
/// Time of a step where nobody moves, and of a small picture where somebody does.
const STEP: f64 = 0.1;
const MOVING_STEP: f64 = 0.05;
/// The camera stands still if it was not moved for so long; and after this it is worth learning for its view.
const STILL: Duration = Duration::from_millis(250);
const SETTLED: Duration = Duration::from_millis(1000);
/// A model that lowers the loss by less is not worth the change.
const LEAST_GAIN: f64 = 0.05;
/// Time between snapshots, in times that one takes.
const SNAPSHOTS_APART: u32 = 3;
/// As sides are divided while the camera moves, before anybody knows how long a sample takes: on a GPU, and in software.
const FIRST_DIVISORS: [u32; 2] = [1, 4];

/// What the window wants to see. A new one takes the place of the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    pub camera: Camera,
    /// Counts up with every change of the camera.
    pub view: u64,
    /// It will change again soon.
    pub moving: bool,
    pub slot: usize,
    /// Another integrator that is to be seen beside it.
    pub beside: Option<usize>,
    pub paused: bool,
    /// Samples after which a picture is good enough.
    pub samples: Option<u32>,
    pub subspaces: bool,
    pub non_finite: bool,
    /// What `halfway render` has to be told of the camera.
    pub camera_flags: String,
}

/// A picture to be saved: as `name-1.exr` and `name-1.png`, or the next number that is free.
#[derive(Clone, Debug)]
pub struct Save {
    pub name: PathBuf,
    pub view: ViewTransform,
    pub exposure: f32,
}

/// What happens in its turn.
enum Order {
    Request(Box<Request>),
    Save(Save),
    Restart,
    Reload,
    Quit,
}

/// What happened.
pub enum Event {
    Loaded(Arc<Scene>),
    Saved(Saved),
    /// Something did not work; the rest goes on.
    Failed(String),
    /// The device is gone, and with it all but the last snapshot.
    Lost(String),
}

/// Where a picture went, and which it was.
pub struct Saved {
    pub paths: Vec<PathBuf>,
    pub slot: usize,
    pub view: u64,
    pub samples: u32,
}

/// The window's end of the worker; dropped, it ends the worker.
pub struct Worker {
    orders: Sender<Order>,
    events: Receiver<Event>,
    latest: Arc<Mutex<Arc<Snapshot>>>,
    abandon: Arc<AtomicBool>,
    abandonable: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Begins with `wish`. `notify` is called whenever there is something new.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(
        settings: Arc<Settings>,
        wish: Request,
        notify: impl Fn() + Send + 'static,
    ) -> Result<Self, RenderError> {
        let (orders, received) = mpsc::channel();
        let (tell, events) = mpsc::channel();
        let latest = Arc::new(Mutex::new(Arc::new(Snapshot::default())));
        let abandon = Arc::new(AtomicBool::new(false));
        let abandonable = Arc::new(AtomicBool::new(false));
        let work = Work {
            orders: received,
            events: tell,
            latest: latest.clone(),
            abandon: abandon.clone(),
            abandonable: abandonable.clone(),
            notify: Box::new(notify),
            settings,
            wish,
            moved: Instant::now(),
            uploaded: None,
            films: [const { None }; SLOTS],
            failed: [false; SLOTS],
            builder: None,
            making: None,
            leaving: Vec::new(),
            scene_failed: false,
            lesson: None,
            shown: 0,
            working: 0,
            saves: Vec::new(),
            quits: false,
            snapshots: 0,
            last_snapshot: None,
            news: true,
        };
        let thread = thread::Builder::new()
            .name("worker".into())
            .spawn(move || {
                let tell = work.events.clone();
                if catch_unwind(AssertUnwindSafe(|| work.run())).is_err() {
                    let message = "the preview's worker has panicked; this is a defect, please report it";
                    let _ = tell.send(Event::Lost(message.into()));
                }
            })
            .map_err(|cause| RenderError::Thread { purpose: "the window's worker", cause })?;
        Ok(Self { orders, events, latest, abandon, abandonable, thread: Some(thread) })
    }

    /// What is wanted from now on; `moved`: the view of before is of no more use.
    pub fn wish(&self, wish: Request, moved: bool) {
        if moved && self.abandonable.load(Ordering::Relaxed) {
            self.abandon.store(true, Ordering::Relaxed);
        }
        self.order(Order::Request(Box::new(wish)));
    }

    /// Saves the picture of now, once it has a sample.
    pub fn save(&self, save: Save) {
        self.order(Order::Save(save));
    }

    /// Begins all pictures anew.
    pub fn restart(&self) {
        self.order(Order::Restart);
    }

    /// Loads the scene anew.
    pub fn reload(&self) {
        self.order(Order::Reload);
    }

    fn order(&self, order: Order) {
        // A worker that is gone has said why.
        let _ = self.orders.send(order);
    }

    pub fn snapshot(&self) -> Arc<Snapshot> {
        self.latest.lock().map(|latest| latest.clone()).unwrap_or_default()
    }

    /// The next thing that happened; `None` if nothing did.
    pub fn event(&self) -> Option<Event> {
        self.events.try_recv().ok()
    }

    /// Ends the worker after what it is at, and says what happened since.
    pub fn finish(mut self) -> Vec<Event> {
        self.end();
        self.events.try_iter().collect()
    }

    fn end(&mut self) {
        self.order(Order::Quit);
        if let Some(thread) = self.thread.take() {
            // It has told what it panicked of.
            let _ = thread.join();
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.end();
    }
}

/// A model for another view than that which an integrator has learnt for, to be used between groups.
struct Round {
    slot: usize,
    model: Arc<Model>,
    /// Over that of the model before, where it is known.
    loss: Option<f64>,
}

/// The worker's own end.
struct Work {
    orders: Receiver<Order>,
    events: Sender<Event>,
    latest: Arc<Mutex<Arc<Snapshot>>>,
    abandon: Arc<AtomicBool>,
    /// What is rendered is whole. Small pictures are for those who move on and on: were they abandoned, none would come.
    abandonable: Arc<AtomicBool>,
    notify: Box<dyn Fn() + Send>,
    settings: Arc<Settings>,
    wish: Request,
    /// When the camera moved last.
    moved: Instant,
    uploaded: Option<Uploaded>,
    films: [Option<Film>; SLOTS],
    /// Integrators that could not be made.
    failed: [bool; SLOTS],
    builder: Option<Builder>,
    /// What it was told of it last.
    making: Option<Making>,
    /// Builders that nobody waits for.
    leaving: Vec<Builder>,
    /// There is no scene to show, and trying again would not help.
    scene_failed: bool,
    lesson: Option<Round>,
    /// Whose picture is seen: another's than was wished for, as long as that is not made.
    shown: usize,
    /// The integrator at work: whose fault an error is.
    working: usize,
    saves: Vec<Save>,
    quits: bool,
    snapshots: u64,
    /// When it was made, and how long that took.
    last_snapshot: Option<(Instant, Duration)>,
    /// There is something that no snapshot tells.
    news: bool,
}

impl Work {
    fn run(mut self) {
        while !self.quits {
            self.hear();
            if self.quits {
                break;
            }
            match self.turn() {
                Ok(()) => {}
                Err(RenderError::Device(DeviceError::Lost { message })) => {
                    return self.tell(Event::Lost(message));
                }
                Err(error) => {
                    let slot = self.working;
                    self.fail(slot, &error);
                    self.films[slot] = None;
                    self.lesson = self.lesson.take().filter(|lesson| lesson.slot != slot);
                }
            }
        }
        // What was asked to be saved, and has a sample.
        if let Err(error) = self.save() {
            self.tell(Event::Lost(error.to_string()));
        }
    }

    fn turn(&mut self) -> Result<(), RenderError> {
        self.working = self.shown;
        self.take_built()?;
        self.build()?;
        self.render()?;
        self.save()?;
        self.publish()
    }

    fn tell(&self, event: Event) {
        // A window that is gone wants to know nothing.
        let _ = self.events.send(event);
        (self.notify)();
    }

    fn fail(&mut self, slot: usize, error: &dyn std::fmt::Display) {
        self.failed[slot] = true;
        self.tell(Event::Failed(error.to_string()));
    }

    /// Takes the orders that are there; waits a moment for some where there is nothing to do.
    fn hear(&mut self) {
        if self.next_film().is_none() {
            match self.orders.recv_timeout(Duration::from_millis(30)) {
                Ok(order) => self.obey(order),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.quits = true,
            }
        }
        while let Ok(order) = self.orders.try_recv() {
            self.obey(order);
        }
    }

    fn obey(&mut self, order: Order) {
        self.news = true;
        match order {
            Order::Request(wish) => {
                self.abandon.store(false, Ordering::Relaxed);
                if wish.view != self.wish.view {
                    self.moved = Instant::now();
                    self.save_what_was_seen();
                }
                if wish.slot != self.wish.slot || wish.beside != self.wish.beside {
                    self.failed = [false; SLOTS];
                }
                self.wish = *wish;
            }
            Order::Save(save) => self.saves.push(save),
            Order::Restart => {
                self.films.iter_mut().flatten().for_each(Film::forget);
                self.failed = [false; SLOTS];
            }
            Order::Reload => match Builder::scene(&self.settings, true) {
                Ok(builder) => {
                    self.leave();
                    self.builder = Some(builder);
                }
                Err(error) => self.tell(Event::Failed(error.to_string())),
            },
            Order::Quit => self.quits = true,
        }
    }

    /// Lets the builder end when it can.
    fn leave(&mut self) {
        if let Some(builder) = self.builder.take() {
            builder.stop();
            self.leaving.push(builder);
        }
    }

    fn is_moving(&self) -> bool {
        self.wish.moving || (self.wish.view > 0 && self.moved.elapsed() < STILL)
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

    /// There is a model, and it is of the scene as it is.
    fn model_fits(&self) -> bool {
        let hash = self.uploaded.as_ref().map(|uploaded| uploaded.hash);
        self.settings.options.model.as_ref().is_some_and(|model| Some(model.scene_hash) == hash)
    }

    fn courtesy(&self) -> SubmissionLimit {
        let slice = SLICES[usize::from(self.settings.context.is_cpu())];
        SubmissionLimit { slice, abandon: self.abandon.clone() }
    }

    fn take_built(&mut self) -> Result<(), RenderError> {
        self.leaving.retain(|builder| builder.take().is_none());
        let Some(builder) = &self.builder else { return Ok(()) };
        let making = builder.making();
        if self.making.as_ref() != Some(&making) {
            self.making = Some(making);
            self.news = true;
        }
        let Some(result) = builder.take() else { return Ok(()) };
        self.news = true;
        self.making = None;
        let (purpose, slot, view) = (builder.purpose, builder.slot, builder.view);
        self.builder = None;
        match result {
            Ok(Built::Scene(loaded, uploaded)) => {
                // Renderers of the last scene go before those of this one come.
                self.films = [const { None }; SLOTS];
                self.failed = [false; SLOTS];
                self.lesson = None;
                self.uploaded = Some(*uploaded);
                self.scene_failed = false;
                if self.settings.options.model.is_some() && !self.model_fits() {
                    let message = "the model is of another state of the scene: spcbpt learns anew";
                    self.tell(Event::Failed(message.into()));
                }
                self.tell(Event::Loaded(loaded));
            }
            Ok(Built::Film(mut renderer, known)) => {
                renderer.limit_submissions(self.courtesy());
                self.films[slot] = Some(Film::new(*renderer, view, known));
            }
            Ok(Built::Round(trained)) => {
                if let Some(film) = &mut self.films[slot] {
                    film.learnt_view = view;
                    film.known = trained.warm_start.clone();
                    let loss = (!trained.losses.is_empty()).then(|| trained.losses.iter().product::<f64>());
                    if loss.is_none_or(|loss| loss < 1.0 - LEAST_GAIN) {
                        // One that was not used yet was what this one is compared with.
                        let before = self.lesson.take().and_then(|lesson| lesson.loss).unwrap_or(1.0);
                        let loss = loss.map(|loss| loss * before);
                        self.lesson = Some(Round { slot, model: trained.model, loss });
                    } else if let (Some(known), Some(model)) = (&mut film.known, &film.renderer.model) {
                        known.model = model.clone();
                    }
                }
            }
            Err(Failure::Stopped) => {}
            Err(Failure::Scene(message)) => self.tell(Event::Failed(message)),
            Err(Failure::Render(error @ RenderError::Device(DeviceError::Lost { .. }))) => return Err(error),
            Err(Failure::Render(error)) => match purpose {
                Purpose::Film => self.fail(slot, &error),
                Purpose::Scene => {
                    self.scene_failed = true;
                    self.tell(Event::Failed(error.to_string()));
                }
                Purpose::Round => {
                    if let Some(film) = &mut self.films[slot] {
                        film.learnt_view = view;
                    }
                    self.tell(Event::Failed(error.to_string()));
                }
            },
        }
        Ok(())
    }

    /// Begins to make what is wished for and is not there.
    fn build(&mut self) -> Result<(), RenderError> {
        let wished = [Some(self.wish.slot), self.wish.beside];
        let seen = self.films.iter().any(Option::is_some);
        let of_no_use = |builder: &Builder| {
            builder.purpose == Purpose::Film && seen && !wished.contains(&Some(builder.slot))
        };
        if self.builder.as_ref().is_some_and(of_no_use) {
            self.leave();
        }
        if self.builder.is_some() {
            return Ok(());
        }
        let Some(uploaded) = self.uploaded.clone() else {
            if !self.scene_failed {
                self.builder = Some(Builder::scene(&self.settings, false)?);
            }
            return Ok(());
        };
        let wish = &self.wish;
        let (slot, view, camera) = (wish.slot, wish.view, wish.camera.clone());
        let is_missing = |slot: usize| self.films[slot].is_none() && !self.failed[slot];
        let learns = |slot: usize| {
            self.settings.methods[slot].plan().learns() && !self.model_fits() && uploaded.has_lights()
        };
        // Who learns first shows something else meanwhile.
        let stand_in = (learns(slot) && self.films.iter().all(Option::is_none)).then_some(0);
        let wanted = [stand_in, Some(slot), wish.beside].into_iter().flatten().find(|&slot| is_missing(slot));
        if let Some(slot) = wanted {
            self.builder = Some(Builder::film(slot, view, &uploaded, camera, self.options(slot))?);
            return Ok(());
        }
        if let Some(film) = &self.films[slot]
            && learns(slot)
            && film.learnt_view != view
            && !self.is_moving()
            && self.moved.elapsed() >= SETTLED
            && !wish.paused
        {
            let (options, known) = (self.options(slot), film.known.clone());
            self.builder = Some(Builder::lesson(slot, view, &uploaded, camera, options, known)?);
        }
        Ok(())
    }

    /// The film that is to be seen, or another until that is there.
    fn seen(&self) -> usize {
        let there = |slot: &usize| self.films[*slot].is_some();
        [self.wish.slot, self.shown].into_iter().find(there).or((0..SLOTS).find(there)).unwrap_or(self.shown)
    }

    /// Whose turn it is to be rendered; `None` where all is done.
    fn next_film(&self) -> Option<usize> {
        let moving = self.is_moving();
        if self.wish.paused && !moving && self.saves.is_empty() {
            return None;
        }
        let left = |slot: usize| {
            let film = self.films[slot].as_ref()?;
            let fresh = !film.is_whole(self.wish.view);
            let more = self.wish.samples.is_none_or(|most| film.renderer.samples() < most);
            (fresh || more).then_some((slot, if fresh { Duration::ZERO } else { film.renderer.elapsed() }))
        };
        let beside = self.wish.beside.filter(|_| !moving);
        let both = [Some(self.seen()), beside].into_iter().flatten();
        both.filter_map(left).min_by_key(|(_, elapsed)| *elapsed).map(|(slot, _)| slot)
    }

    fn render(&mut self) -> Result<(), RenderError> {
        self.shown = self.seen();
        let Some(slot) = self.next_film() else { return Ok(()) };
        self.working = slot;
        let moving = self.is_moving();
        let is_cpu = usize::from(self.settings.context.is_cpu());
        let aim = Aim {
            camera: self.wish.camera.clone(),
            view: self.wish.view,
            size: [self.settings.options.view.width, self.settings.options.view.height],
        };
        let limit = self.wish.samples;
        let Some(film) = &mut self.films[slot] else { return Ok(()) };
        let divisor = if moving { film.divisor_for(MOVING_STEP, FIRST_DIVISORS[is_cpu]) } else { 1 };
        // A moving picture keeps its size until the camera goes on: else it would never gather samples.
        let keeps = moving && film.view() == Some(aim.view);
        // An iteration that a limit has cut short cannot go on: its light paths were fewer.
        if film.renderer.samples() % film.renderer.samples_at_once() != 0 && film.is_whole(aim.view) {
            film.forget();
        }
        film.aim(&aim, if keeps { film.divisor } else { divisor })?;
        let mut most = limit.map_or(u32::MAX, |limit| limit.saturating_sub(film.renderer.samples()).max(1));
        if self.lesson.as_ref().is_some_and(|lesson| lesson.slot == slot) {
            let in_group = film.renderer.samples() % SAMPLES_A_GROUP;
            if in_group == 0 {
                if let Some(Round { model, loss, .. }) = self.lesson.take() {
                    film.renderer.connect_by(model)?;
                    if let Some(loss) = loss {
                        film.renderer.weigh_earlier(loss);
                    }
                }
            } else {
                most = most.min(SAMPLES_A_GROUP - in_group);
            }
        }
        self.abandonable.store(film.divisor == 1, Ordering::Relaxed);
        if film.divisor > 1 {
            self.abandon.store(false, Ordering::Relaxed);
        }
        film.step(STEP, most)?;
        film.estimate()?;
        self.news = true;
        Ok(())
    }
}
