//! The thread that renders: it takes wishes, and tells what there is to show.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::device::layout::SAMPLES_A_GROUP;
use crate::error::{DeviceError, RenderError};
use crate::film::tonemap::View;
use crate::integrator::{Courtesy, Method, When};
use crate::render::{RenderOptions, Uploaded};
use crate::scene::{Camera, Scene};
use crate::subspace::Model;

use super::builder::{Builder, Built, Failure};
use super::film::{Aim, Film};
use super::saving;
use super::snapshot::{Figures, Learnt, Making, Snapshot};
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
pub struct Wish {
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
}

/// A picture to be saved: as `base.exr` and `base.png`.
#[derive(Clone, Debug)]
pub struct Save {
    pub base: PathBuf,
    pub view: View,
    pub exposure: f32,
    /// What `halfway render` has to be told of the camera.
    pub camera_flags: String,
}

/// What happens in its turn.
enum Order {
    Wish(Box<Wish>),
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
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Begins with `wish`. `notify` is called whenever there is something new.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(
        settings: Arc<Settings>,
        wish: Wish,
        notify: impl Fn() + Send + 'static,
    ) -> Result<Self, DeviceError> {
        let (orders, received) = mpsc::channel();
        let (tell, events) = mpsc::channel();
        let latest = Arc::new(Mutex::new(Arc::new(Snapshot::default())));
        let abandon = Arc::new(AtomicBool::new(false));
        let work = Work {
            orders: received,
            events: tell,
            latest: latest.clone(),
            abandon: abandon.clone(),
            notify: Box::new(notify),
            settings,
            wish,
            moved: Instant::now(),
            uploaded: None,
            films: [const { None }; SLOTS],
            failed: [false; SLOTS],
            builder: None,
            making: None,
            lesson: None,
            shown: 0,
            saves: Vec::new(),
            quits: false,
            snapshots: 0,
            last_snapshot: None,
            news: true,
        };
        let thread = thread::Builder::new()
            .name("worker".into())
            .spawn(move || work.run())
            .map_err(|error| DeviceError::Thread { message: error.to_string() })?;
        Ok(Self { orders, events, latest, abandon, thread: Some(thread) })
    }

    /// What is wanted from now on; `moved`: the view of before is of no more use.
    pub fn wish(&self, wish: Wish, moved: bool) {
        if moved {
            self.abandon.store(true, Ordering::Relaxed);
        }
        self.order(Order::Wish(Box::new(wish)));
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
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the preview's worker has panicked; this is a defect of Halfway, please report it");
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.end();
    }
}

/// The worker's own end.
struct Work {
    orders: Receiver<Order>,
    events: Sender<Event>,
    latest: Arc<Mutex<Arc<Snapshot>>>,
    abandon: Arc<AtomicBool>,
    notify: Box<dyn Fn() + Send>,
    settings: Arc<Settings>,
    wish: Wish,
    /// When the camera moved last.
    moved: Instant,
    uploaded: Option<Uploaded>,
    films: [Option<Film>; SLOTS],
    /// Integrators that could not be made.
    failed: [bool; SLOTS],
    builder: Option<Builder>,
    /// What it was told of it last.
    making: Option<Making>,
    /// A model for the view of now, and its loss over that of the one before, to be used between groups.
    lesson: Option<(usize, Arc<Model>, f64)>,
    /// Whose picture is seen: another's than was wished for, as long as that is not made.
    shown: usize,
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
            let result = self.turn();
            match result {
                Ok(()) => {}
                Err(RenderError::Device(DeviceError::Lost { message })) => {
                    self.tell(Event::Lost(message));
                    return;
                }
                Err(error) => {
                    self.fail(self.shown, &error);
                    self.films[self.shown] = None;
                }
            }
        }
        // What was asked to be saved, and has a sample.
        if let Err(error) = self.save() {
            self.tell(Event::Failed(error.to_string()));
        }
        self.builder = None;
    }

    fn turn(&mut self) -> Result<(), RenderError> {
        self.take_built();
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
            Order::Wish(wish) => {
                self.abandon.store(false, Ordering::Relaxed);
                if wish.view != self.wish.view {
                    self.moved = Instant::now();
                }
                if wish.slot != self.wish.slot || wish.beside != self.wish.beside {
                    self.failed = [false; SLOTS];
                }
                self.wish = *wish;
            }
            Order::Save(save) => self.saves.push(save),
            Order::Restart => {
                self.films.iter_mut().flatten().for_each(Film::forget);
            }
            Order::Reload => match Builder::scene(&self.settings, true) {
                Ok(builder) => self.builder = Some(builder),
                Err(error) => self.tell(Event::Failed(error.to_string())),
            },
            Order::Quit => self.quits = true,
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
        options
    }

    fn courtesy(&self) -> Courtesy {
        let slice = SLICES[usize::from(self.settings.context.is_cpu())];
        Courtesy { slice, abandon: self.abandon.clone() }
    }

    fn take_built(&mut self) {
        let Some(builder) = &self.builder else { return };
        let making = builder.making();
        if self.making.as_ref() != Some(&making) {
            self.making = Some(making);
            self.news = true;
        }
        let Some(result) = builder.take() else { return };
        self.news = true;
        self.making = None;
        let (slot, view) = (builder.slot, builder.view);
        self.builder = None;
        match result {
            Ok(Built::Scene(loaded, uploaded)) => {
                // Renderers of the last scene go before those of this one come.
                self.films = [const { None }; SLOTS];
                self.failed = [false; SLOTS];
                self.lesson = None;
                self.uploaded = Some(*uploaded);
                self.tell(Event::Loaded(loaded));
            }
            Ok(Built::Film(mut renderer, known)) => {
                renderer.be_courteous(self.courtesy());
                self.films[slot] = Some(Film::new(*renderer, view, known));
            }
            Ok(Built::Lesson(trained)) => {
                if let Some(film) = &mut self.films[slot] {
                    film.learnt_view = view;
                    film.known = trained.known.clone();
                    let loss: f64 = trained.losses.iter().product();
                    if loss < 1.0 - LEAST_GAIN {
                        self.lesson = Some((slot, trained.model, loss));
                    } else if let (Some(known), Some(model)) = (&mut film.known, &film.renderer.model) {
                        known.model = model.clone();
                    }
                }
            }
            Err(Failure::Stopped) => {}
            Err(Failure::Scene(message)) => self.tell(Event::Failed(message)),
            Err(Failure::Render(error)) => self.fail(slot, &error),
        }
    }

    /// Begins to make what is wished for and is not there.
    fn build(&mut self) -> Result<(), RenderError> {
        if self.builder.is_some() {
            return Ok(());
        }
        let Some(uploaded) = self.uploaded.clone() else {
            if !self.failed[0] {
                self.builder = Some(Builder::scene(&self.settings, false)?);
            }
            return Ok(());
        };
        let wish = &self.wish;
        let (slot, view, camera) = (wish.slot, wish.view, wish.camera.clone());
        let is_missing = |slot: usize| self.films[slot].is_none() && !self.failed[slot];
        let learns = |slot: usize| {
            matches!(self.settings.methods[slot], Method::SpcBpt { .. })
                && self.settings.options.model.is_none()
                && uploaded.has_lights()
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
        if self.wish.paused && !moving {
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
        let moving = self.is_moving();
        let is_cpu = usize::from(self.settings.context.is_cpu());
        let aim = Aim {
            camera: self.wish.camera.clone(),
            view: self.wish.view,
            size: [self.settings.options.width, self.settings.options.height],
        };
        let limit = self.wish.samples;
        let Some(film) = &mut self.films[slot] else { return Ok(()) };
        let divisor = if moving { film.divisor_for(MOVING_STEP, FIRST_DIVISORS[is_cpu]) } else { 1 };
        // A moving picture keeps its size until the camera goes on: else it would never gather samples.
        let keeps = moving && film.view() == Some(aim.view);
        film.aim(&aim, if keeps { film.divisor } else { divisor })?;
        let mut most = limit.map_or(u32::MAX, |limit| limit.saturating_sub(film.renderer.samples()).max(1));
        if self.lesson.as_ref().is_some_and(|lesson| lesson.0 == slot) {
            let in_group = film.renderer.samples() % SAMPLES_A_GROUP;
            if in_group == 0 {
                if let Some((_, model, loss)) = self.lesson.take() {
                    film.renderer.connect_by(model)?;
                    film.renderer.weigh_earlier(loss);
                }
            } else {
                most = most.min(SAMPLES_A_GROUP - in_group);
            }
        }
        film.step(STEP, most)?;
        film.estimate()?;
        self.news = true;
        Ok(())
    }

    /// Saves what was asked for, as soon as the picture is whole.
    fn save(&mut self) -> Result<(), RenderError> {
        if self.saves.is_empty() {
            return Ok(());
        }
        let Some(film) = &mut self.films[self.shown] else { return Ok(()) };
        if !film.is_whole(self.wish.view) || film.renderer.samples() == 0 {
            return Ok(());
        }
        for save in std::mem::take(&mut self.saves) {
            let method = self.settings.methods[self.shown];
            match saving::save(&self.settings, &mut film.renderer, method, &save) {
                Ok(paths) => {
                    let samples = film.renderer.samples();
                    let saved = Saved { paths, slot: self.shown, view: self.wish.view, samples };
                    let _ = self.events.send(Event::Saved(saved));
                }
                Err(RenderError::Film(error)) => {
                    let _ = self.events.send(Event::Failed(error.to_string()));
                }
                Err(error) => return Err(error),
            }
        }
        (self.notify)();
        Ok(())
    }

    /// Tells how things stand, but for a part of the time only.
    fn publish(&mut self) -> Result<(), RenderError> {
        let due = self.last_snapshot.is_none_or(|(end, took)| end.elapsed() >= SNAPSHOTS_APART * took);
        let idle = self.next_film().is_none();
        if !self.news || !(due || idle) {
            return Ok(());
        }
        let start = Instant::now();
        let mut snapshot = Snapshot {
            slot: self.shown,
            view: self.wish.view,
            number: self.snapshots + 1,
            ..self.latest.lock().map(|latest| (**latest).clone()).unwrap_or_default()
        };
        let is_there = |film: &Film| film.view() == Some(self.wish.view) && film.renderer.samples() > 0;
        if let Some(film) = self.films[self.shown].as_mut().filter(|film| is_there(film)) {
            snapshot.picture = Arc::new(film.renderer.radiance()?);
            snapshot.figures = figures(film, self.wish.view)?;
            snapshot.subspaces = match self.wish.subspaces && film.divisor == 1 {
                true => film.renderer.first_subspaces()?.map(Arc::new),
                false => None,
            };
            snapshot.non_finite = match self.wish.non_finite {
                true => Some(Arc::new(film.renderer.non_finite()?)),
                false => None,
            };
        }
        snapshot.beside = match self.wish.beside.and_then(|slot| self.films[slot].as_ref()) {
            Some(film) if is_there(film) && film.divisor == 1 => Some(Arc::new(film.renderer.radiance()?)),
            _ => None,
        };
        snapshot.figures.making = self.making.clone();
        snapshot.figures.done = idle && self.builder.is_none();
        snapshot.figures.memory = memory(self.films.iter().flatten());
        self.snapshots += 1;
        if let Ok(mut latest) = self.latest.lock() {
            *latest = Arc::new(snapshot);
        }
        self.last_snapshot = Some((Instant::now(), start.elapsed()));
        self.news = false;
        (self.notify)();
        Ok(())
    }
}

fn figures(film: &Film, view: u64) -> Result<Figures, RenderError> {
    let report = film.renderer.status()?;
    let samples = f64::from(report.samples.max(1));
    let mut kernels: Vec<(String, f64)> =
        report.kernels.iter().map(|(name, (seconds, _))| (name.clone(), seconds / samples)).collect();
    kernels.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(Figures {
        samples: report.samples,
        seconds: report.seconds,
        seconds_a_sample: film.seconds_a_sample.filter(|_| film.divisor == 1),
        kernels,
        error: film.error(),
        errors: film.errors.clone(),
        non_finite_samples: report.non_finite - report.rays.non_finite_vertices,
        non_finite_vertices: report.rays.non_finite_vertices,
        light_vertices: report.rays.light_vertices,
        learnt: film.renderer.model.as_ref().map(|model| Learnt {
            subspaces: model.subspaces,
            used: model.report.counts.learnt_rows,
            paths: model.report.counts.paths,
            losses: report.lesson_losses,
            of_this_view: film.learnt_view == view,
        }),
        choices: report.choices,
        ..Figures::default()
    })
}

/// Buffers that films share are in each of their tables, and count once.
fn memory<'a>(films: impl Iterator<Item = &'a Film>) -> Vec<(String, u64)> {
    let mut all: Vec<(String, u64)> = Vec::new();
    let mut seen = std::collections::HashSet::new();
    for film in films {
        for (name, buffer) in film.renderer.buffers() {
            if seen.insert(buffer.clone()) {
                match all.iter_mut().find(|(other, _)| other == name) {
                    Some((_, bytes)) => *bytes += buffer.size(),
                    None => all.push((name.clone(), buffer.size())),
                }
            }
        }
    }
    all.sort_by(|a, b| b.1.cmp(&a.1));
    all
}
