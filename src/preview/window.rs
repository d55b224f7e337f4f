//! The window: events in, frames out.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::WindowId;

use super::canvas::{self, Canvas};
use super::controls::Navigator;
use super::display::{Look, Show};
use super::frames::Frames;
use super::gui::Gui;
use super::panel::{self, Action, Choices, Split, Status};
use super::snapshot::Snapshot;
use super::textures::Textures;
use super::watch::Watch;
use super::worker::{Event, Request, Save, Worker};
use super::{PreviewError, Settings, saving};
use crate::integrator::METHODS;
use crate::out;
use crate::scene::Scene;

/// Time between checks of the scene's files, of interrupts, and of the progress of work in the background.
const TICK: Duration = Duration::from_millis(250);
/// How long a message is shown.
const MESSAGE: Duration = Duration::from_secs(8);
/// How long the camera counts as moving after the last movement by a wheel or a key.
const COASTING: Duration = Duration::from_millis(150);

/// A connection to the desktop.
pub struct Display(EventLoop<Wake>);

/// The worker has something new.
#[derive(Clone, Copy, Debug)]
pub struct Wake;

impl Display {
    /// # Errors
    /// There is no desktop.
    pub fn open() -> Result<Self, PreviewError> {
        let events = EventLoop::with_user_event().build().map_err(|error| {
            // The library's message begins with a place in its own source.
            let message = error.to_string();
            let message = message.rsplit(": ").next().unwrap_or(&message).trim_end_matches('.').to_string();
            PreviewError::NoDisplay { message }
        })?;
        Ok(Self(events))
    }
}

/// Shows the window until it is closed or `interrupted` returns true; then saves the picture.
///
/// # Errors
/// A camera that is not there, a window that does not open, a lost device (after its last picture was saved).
pub fn run(
    display: Display,
    settings: Settings,
    interrupted: impl Fn() -> bool + 'static,
) -> Result<(), PreviewError> {
    let settings = Arc::new(settings);
    let navigator = Navigator::new(&settings.scene, &settings.camera)?;
    let mut app = App {
        proxy: display.0.create_proxy(),
        interrupted: Box::new(interrupted),
        choices: Choices {
            look: Look { show: Show::default(), view: settings.view, exposure: settings.exposure },
            slot: settings.slot,
            split: Split::None,
            paused: false,
            samples: settings.samples,
            panel: true,
        },
        divider: 0.5,
        scene: settings.scene.clone(),
        navigator,
        view: 0,
        moving_until: Instant::now(),
        held: false,
        request: None,
        worker: None,
        gui: None,
        textures: Textures::default(),
        frames: Frames::default(),
        message: None,
        saved: None,
        watch: Watch::new(settings.files.clone()),
        next_tick: Instant::now(),
        next_frame: None,
        end: None,
        settings,
    };
    // The library panics where another program destroys its window: the picture is saved all the same.
    let shown = catch_unwind(AssertUnwindSafe(|| display.0.run_app(&mut app)));
    let problem = match shown {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(error.to_string()),
        Err(_) => Some("another program destroyed it".into()),
    };
    if let Some(message) = problem {
        app.end.get_or_insert(PreviewError::Window { message });
    }
    app.close()
}

struct App {
    settings: Arc<Settings>,
    proxy: EventLoopProxy<Wake>,
    interrupted: Box<dyn Fn() -> bool>,
    choices: Choices,
    divider: f32,
    scene: Arc<Scene>,
    navigator: Navigator,
    /// Counts the camera's changes.
    view: u64,
    moving_until: Instant,
    /// A button is held down on the picture.
    held: bool,
    /// What the worker was sent last.
    request: Option<Request>,
    worker: Option<Worker>,
    gui: Option<Gui>,
    textures: Textures,
    frames: Frames,
    message: Option<(Instant, String)>,
    /// The picture that was saved last: integrator, view, samples.
    saved: Option<(usize, u64, u32)>,
    watch: Watch,
    next_tick: Instant,
    /// When the interface is to be drawn again.
    next_frame: Option<Instant>,
    end: Option<PreviewError>,
}

impl ApplicationHandler<Wake> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.gui.is_some() {
            return;
        }
        match Gui::new(events, &self.settings.context, &self.settings).and_then(|gui| {
            self.gui = Some(gui);
            self.begin()
        }) {
            Ok(()) => {}
            Err(error) => {
                self.end = Some(error);
                events.exit();
            }
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, _: Wake) {
        self.poll_worker(events);
        self.redraw();
    }

    fn new_events(&mut self, events: &ActiveEventLoop, _: StartCause) {
        if (self.interrupted)() {
            events.exit();
        }
        // Not only after a timeout: while the worker renders, its snapshots wake the loop all the time.
        let now = Instant::now();
        if now >= self.next_tick {
            self.next_tick = now + TICK;
            self.tick();
        }
        if self.next_frame.is_some_and(|due| due <= now) {
            self.next_frame = None;
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let next = self.next_frame.map_or(self.next_tick, |due| due.min(self.next_tick));
        events.set_control_flow(ControlFlow::WaitUntil(next));
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let WindowEvent::RedrawRequested = event {
            return self.frame(events);
        }
        let Some(gui) = &mut self.gui else { return };
        let response = gui.input.on_window_event(&gui.window, &event);
        if response.repaint {
            gui.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                gui.resize(&self.settings.context, size.width, size.height);
                gui.window.request_redraw();
            }
            _ => {}
        }
    }
}

impl App {
    fn begin(&mut self) -> Result<(), PreviewError> {
        let request = self.next_request();
        let proxy = self.proxy.clone();
        // The loop has ended where this fails.
        let notify = move || {
            let _ = proxy.send_event(Wake);
        };
        self.worker = Some(Worker::new(self.settings.clone(), request.clone(), notify)?);
        self.request = Some(request);
        Ok(())
    }

    fn redraw(&self) {
        if let Some(gui) = &self.gui {
            gui.window.request_redraw();
        }
    }

    fn show_message(&mut self, message: String) {
        self.message = Some((Instant::now(), message));
    }

    /// What is done every [`TICK`].
    fn tick(&mut self) {
        if self.watch.has_changed() {
            self.show_message("the scene has changed on disk and is loaded again".into());
            if let Some(worker) = &self.worker {
                worker.reload();
            }
        }
        self.send_request();
        if self.message.as_ref().is_some_and(|(since, _)| since.elapsed() > MESSAGE) {
            self.message = None;
            self.redraw();
        }
    }

    /// Handles the events of the worker.
    fn poll_worker(&mut self, events: &ActiveEventLoop) {
        while let Some(event) = self.worker.as_ref().and_then(Worker::event) {
            match event {
                Event::Loaded(loaded) => self.take_scene(loaded),
                Event::Lost(message) => {
                    self.end = Some(PreviewError::Lost { message });
                    events.exit();
                }
                event => self.report(event),
            }
        }
    }

    fn report(&mut self, event: Event) {
        match event {
            Event::Saved(saved) => {
                self.saved = Some((saved.slot, saved.view, saved.samples));
                let names: Vec<String> = saved.paths.iter().map(|path| path.display().to_string()).collect();
                let method = METHODS[saved.slot].name;
                names.iter().for_each(|name| out!("{name}"));
                eprintln!("saved: {method}, {} spp", saved.samples);
                self.show_message(format!("saved: {method}, {} spp: {}", saved.samples, names.join(", ")));
            }
            Event::Failed(message) => {
                eprintln!("error: {message}");
                self.show_message(message);
            }
            Event::Loaded(_) | Event::Lost(_) => {}
        }
    }

    /// Shows a scene that was loaded again, by the camera of before where it still has that.
    fn take_scene(&mut self, loaded: Arc<Scene>) {
        if Arc::ptr_eq(&loaded, &self.scene) {
            return;
        }
        let same = Navigator::new(&loaded, &self.navigator.viewpoint());
        match same.or_else(|_| Navigator::new(&loaded, &self.settings.camera)) {
            Ok(navigator) => self.navigator = navigator,
            Err(error) => self.show_message(error.to_string()),
        }
        log::info!("{} was loaded again", loaded.name);
        self.scene = loaded;
        self.saved = None;
        self.send_request();
    }

    fn next_request(&mut self) -> Request {
        let camera = self.navigator.camera();
        if self.request.as_ref().is_some_and(|last| last.camera != camera) {
            self.view += 1;
        }
        Request {
            camera,
            camera_flags: self.navigator.flags(),
            view: self.view,
            moving: self.held || Instant::now() < self.moving_until,
            slot: self.choices.slot,
            beside: match self.choices.split {
                Split::Slot(slot) => Some(slot),
                Split::None | Split::Reference => None,
            },
            paused: self.choices.paused,
            samples: self.choices.samples,
            denoised: self.choices.look.show == Show::Denoised,
            subspaces: matches!(self.choices.look.show, Show::EyeSubspaces | Show::LightSubspaces),
            non_finite: self.choices.look.show == Show::NonFinite,
        }
    }

    /// Sends the worker a request, where it has changed.
    fn send_request(&mut self) {
        let request = self.next_request();
        let Some(worker) = &self.worker else { return };
        let moved = self.request.as_ref().is_some_and(|last| last.view != request.view);
        if self.request.as_ref() != Some(&request) {
            worker.request(request.clone(), moved);
            self.request = Some(request);
        }
    }

    fn frame(&mut self, events: &ActiveEventLoop) {
        let start = Instant::now();
        self.poll_worker(events);
        let (Some(mut gui), Some(worker)) = (self.gui.take(), &self.worker) else { return };
        let snapshot = worker.snapshot();
        let reference = self.settings.reference.as_ref();
        let Choices { look, split, .. } = self.choices;
        self.textures.update(&gui.context, &snapshot, look, split, reference);
        let input = gui.input.take_egui_input(&gui.window);
        let context = gui.context.clone();
        let mut actions = Vec::new();
        let output = context.run_ui(input, |ui| actions = self.interface(ui, &snapshot));
        for action in actions {
            self.act(events, &gui, action);
        }
        self.send_request();
        let delay = output.viewport_output.get(&egui::ViewportId::ROOT).map(|root| root.repaint_delay);
        self.next_frame = delay.and_then(|delay| Instant::now().checked_add(delay));
        if delay == Some(Duration::ZERO) {
            gui.window.request_redraw();
            self.next_frame = None;
        }
        gui.input.handle_platform_output(&gui.window, output.platform_output.clone());
        gui.paint(&self.settings.context, output);
        self.gui = Some(gui);
        self.frames.add(start.elapsed());
    }

    fn interface(&mut self, ui: &mut egui::Ui, snapshot: &Snapshot) -> Vec<Action> {
        let settings = self.settings.clone();
        let mut actions = panel::keys(ui, &mut self.choices, settings.reference.is_some());
        if self.choices.panel {
            let status = Status {
                settings: &settings,
                snapshot,
                frames: self.frames.summary(),
                message: self.message.as_ref().map(|(_, message)| message.as_str()),
            };
            let panel = egui::Panel::right("panel").default_size(panel::WIDTH);
            let shown = panel.show(ui, |ui| panel::show(ui, &status, &mut self.choices));
            actions.extend(shown.inner);
        }
        let beside = self.textures.beside.as_ref().filter(|_| snapshot.view == self.view);
        let canvas = Canvas {
            picture: self.textures.picture.as_ref(),
            waiting: snapshot.figures.activity.as_ref().map_or("", |activity| activity.what.as_str()),
            beside: beside.map(|texture| {
                let name = match self.choices.split {
                    Split::Slot(slot) => METHODS[slot].name,
                    Split::None | Split::Reference => "reference",
                };
                (texture, [METHODS[snapshot.slot].name, name])
            }),
            aspect: settings.options.view.width as f32 / settings.options.view.height as f32,
        };
        let (navigator, divider) = (&mut self.navigator, &mut self.divider);
        let scene = &self.scene;
        let frame = egui::CentralPanel::no_frame();
        let motion = frame.show(ui, |ui| canvas::show(ui, &canvas, navigator, divider, scene)).inner;
        self.held = motion.held;
        if motion.moved {
            self.moving_until = Instant::now() + COASTING;
        }
        actions
    }

    fn act(&mut self, events: &ActiveEventLoop, gui: &Gui, action: Action) {
        match action {
            Action::Close => events.exit(),
            Action::Save => {
                let save = self.save();
                if let Some(worker) = &self.worker {
                    worker.save(save);
                }
            }
            Action::Restart => {
                if let Some(worker) = &self.worker {
                    worker.restart();
                }
            }
            Action::CopyCamera => {
                let flags = self.navigator.flags();
                gui.context.copy_text(flags.clone());
                out!("{flags}");
                self.show_message(format!("copied: {flags}"));
            }
            Action::FrameAll => {
                let options = &self.settings.options;
                self.navigator.frame_all(f64::from(options.view.width) / f64::from(options.view.height));
            }
            Action::ResetCamera => self.navigator.reset(),
        }
    }

    fn save(&self) -> Save {
        Save {
            name: self.settings.output.clone(),
            view: self.choices.look.view,
            exposure: self.choices.look.exposure,
        }
    }

    /// Saves the picture unless it is saved already.
    fn close(mut self) -> Result<(), PreviewError> {
        let Some(worker) = self.worker.take() else {
            return Err(self.end.unwrap_or(PreviewError::NeverOpened));
        };
        // The window is closed first: it no longer answers.
        let save = self.save();
        self.gui = None;
        let snapshot = worker.snapshot();
        let seen = (snapshot.slot, snapshot.view, snapshot.figures.samples);
        let unsaved = snapshot.figures.samples > 0 && self.saved != Some(seen);
        if unsaved && !matches!(self.end, Some(PreviewError::Lost { .. })) {
            worker.save(save.clone());
        }
        let before = self.saved;
        for event in worker.finish() {
            match event {
                Event::Lost(message) => self.end = Some(PreviewError::Lost { message }),
                event => self.report(event),
            }
        }
        // A lost device has no picture any more: the last snapshot is saved in its place.
        if unsaved && self.saved == before {
            for path in saving::save_snapshot(&self.settings, &snapshot, &save)? {
                out!("{}", path.display());
            }
        }
        eprintln!("{}", self.frames.summary());
        self.end.map_or(Ok(()), Err)
    }
}
