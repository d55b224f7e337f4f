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
use super::display::{self, Look, Show};
use super::frames::Frames;
use super::gui::Gui;
use super::panel::{self, Action, Choices, Split, Status};
use super::snapshot::Snapshot;
use super::watch::Watch;
use super::worker::{Event, Request, Save, Worker};
use super::{Settings, saving};
use crate::preview::PreviewError;
use crate::scene::Scene;

/// Between two looks at files, at the terminal, and at how far work in the background is.
const TICK: Duration = Duration::from_millis(250);
/// A message is seen for so long.
const MESSAGE: Duration = Duration::from_secs(8);
/// After the last movement of a wheel or a key the camera counts as moving for so long.
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

/// Shows the window until it is closed, or `interrupted` says so; then saves the picture, and returns what to say.
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
        wish: None,
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
    // The library panics where its window is destroyed by others: what there is to be seen is saved all the same.
    let shown = catch_unwind(AssertUnwindSafe(|| display.0.run_app(&mut app)));
    let problem = match shown {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(error.to_string()),
        Err(_) => Some("it was destroyed by others".into()),
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
    /// What the worker was told last.
    wish: Option<Request>,
    worker: Option<Worker>,
    gui: Option<Gui>,
    textures: Textures,
    frames: Frames,
    message: Option<(Instant, String)>,
    /// Which picture was saved last: integrator, view, samples.
    saved: Option<(usize, u64, u32)>,
    watch: Watch,
    next_tick: Instant,
    /// When the interface wants to be drawn again.
    next_frame: Option<Instant>,
    end: Option<PreviewError>,
}

/// Pictures on the device, with what they were made of.
#[derive(Default)]
struct Textures {
    picture: Option<egui::TextureHandle>,
    beside: Option<egui::TextureHandle>,
    made_of: Option<(u64, Look, Split)>,
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
        self.hear(events);
        self.redraw();
    }

    fn new_events(&mut self, events: &ActiveEventLoop, _: StartCause) {
        if (self.interrupted)() {
            events.exit();
        }
        // Whatever it was that woke the loop: while it renders, something always does.
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
        let wish = self.wanted();
        let proxy = self.proxy.clone();
        // A window that is gone hears nothing.
        let notify = move || {
            let _ = proxy.send_event(Wake);
        };
        self.worker = Some(Worker::new(self.settings.clone(), wish.clone(), notify)?);
        self.wish = Some(wish);
        Ok(())
    }

    fn redraw(&self) {
        if let Some(gui) = &self.gui {
            gui.window.request_redraw();
        }
    }

    fn say(&mut self, message: String) {
        self.message = Some((Instant::now(), message));
    }

    /// What happens now and then.
    fn tick(&mut self) {
        if self.watch.has_changed() {
            self.say("the scene has changed on disk: it is loaded anew".into());
            if let Some(worker) = &self.worker {
                worker.reload();
            }
        }
        self.tell();
        if self.message.as_ref().is_some_and(|(since, _)| since.elapsed() > MESSAGE) {
            self.message = None;
            self.redraw();
        }
    }

    /// Takes what the worker says.
    fn hear(&mut self, events: &ActiveEventLoop) {
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
                let method = self.settings.methods[saved.slot].name();
                names.iter().for_each(|name| println!("{name}"));
                eprintln!("saved: {method}, {} spp", saved.samples);
                self.say(format!("saved: {method}, {} spp: {}", saved.samples, names.join(", ")));
            }
            Event::Failed(message) => {
                eprintln!("error: {message}");
                self.say(message);
            }
            Event::Loaded(_) | Event::Lost(_) => {}
        }
    }

    /// Looks at a scene that was loaded anew from where one looked at the last.
    fn take_scene(&mut self, loaded: Arc<Scene>) {
        if Arc::ptr_eq(&loaded, &self.scene) {
            return;
        }
        let same = Navigator::new(&loaded, &self.navigator.viewpoint());
        match same.or_else(|_| Navigator::new(&loaded, &self.settings.camera)) {
            Ok(navigator) => self.navigator = navigator,
            Err(error) => self.say(error.to_string()),
        }
        log::info!("{} is loaded anew", loaded.name);
        self.scene = loaded;
        self.saved = None;
        self.tell();
    }

    fn wanted(&mut self) -> Request {
        let camera = self.navigator.camera();
        if self.wish.as_ref().is_some_and(|wish| wish.camera != camera) {
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
            subspaces: matches!(self.choices.look.show, Show::EyeSubspaces | Show::LightSubspaces),
            non_finite: self.choices.look.show == Show::NonFinite,
        }
    }

    /// Tells the worker what is wanted, where that has changed.
    fn tell(&mut self) {
        let wish = self.wanted();
        let Some(worker) = &self.worker else { return };
        let moved = self.wish.as_ref().is_some_and(|old| old.view != wish.view);
        if self.wish.as_ref() != Some(&wish) {
            worker.wish(wish.clone(), moved);
            self.wish = Some(wish);
        }
    }

    fn frame(&mut self, events: &ActiveEventLoop) {
        let start = Instant::now();
        self.hear(events);
        let (Some(mut gui), Some(worker)) = (self.gui.take(), &self.worker) else { return };
        let snapshot = worker.snapshot();
        self.update_textures(&gui, &snapshot);
        let input = gui.input.take_egui_input(&gui.window);
        let context = gui.context.clone();
        let mut actions = Vec::new();
        let output = context.run_ui(input, |ui| actions = self.interface(ui, &snapshot));
        for action in actions {
            self.act(events, &gui, action);
        }
        self.tell();
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
        let names = settings.methods.map(|method| method.name());
        let beside = self.textures.beside.as_ref().filter(|_| snapshot.view == self.view);
        let canvas = Canvas {
            picture: self.textures.picture.as_ref(),
            waiting: snapshot.figures.making.as_ref().map_or("", |making| making.what.as_str()),
            beside: beside.map(|texture| {
                let name = match self.choices.split {
                    Split::Slot(slot) => names[slot],
                    Split::None | Split::Reference => "reference",
                };
                (texture, [names[snapshot.slot].to_string(), name.to_string()])
            }),
            aspect: settings.options.width as f32 / settings.options.height as f32,
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
                println!("{flags}");
                self.say(format!("copied: {flags}"));
            }
            Action::FrameAll => {
                let options = &self.settings.options;
                self.navigator.frame_all(f64::from(options.width) / f64::from(options.height));
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

    fn update_textures(&mut self, gui: &Gui, snapshot: &Snapshot) {
        let made_of = (snapshot.number, self.choices.look, self.choices.split);
        if self.textures.made_of == Some(made_of) || snapshot.picture.rgb.is_empty() {
            return;
        }
        let look = &self.choices.look;
        let reference = self.settings.reference.as_ref();
        let shown = || {
            display::image(snapshot, look, reference).or_else(|| display::radiance(&snapshot.picture, look))
        };
        let image = display::in_own_threads(shown);
        let beside = match self.choices.split {
            Split::None => None,
            Split::Reference => reference.and_then(|picture| display::radiance(picture, look)),
            Split::Slot(slot) => {
                let beside = snapshot.beside.as_ref().filter(|(other, _)| *other == slot);
                beside.and_then(|(_, picture)| display::radiance(picture, look))
            }
        };
        let textures = &mut self.textures;
        for (texture, image, name) in
            [(&mut textures.picture, image, "picture"), (&mut textures.beside, beside, "beside")]
        {
            let options = egui::TextureOptions {
                magnification: egui::TextureFilter::Nearest,
                ..egui::TextureOptions::LINEAR
            };
            match (texture.as_mut(), image) {
                (Some(texture), Some(image)) => texture.set(image, options),
                (None, Some(image)) => *texture = Some(gui.context.load_texture(name, image, options)),
                (_, None) => *texture = None,
            }
        }
        textures.made_of = Some(made_of);
    }

    /// Saves what is not saved yet, and says how it went.
    fn close(mut self) -> Result<(), PreviewError> {
        let Some(worker) = self.worker.take() else {
            return Err(self.end.unwrap_or(PreviewError::NeverOpened));
        };
        // The window goes first: nobody has to look at one that does not answer.
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
        // A device that is lost cannot be asked for its picture any more: what was seen last is still here.
        if unsaved && self.saved == before {
            for path in saving::rescue(&self.settings, &snapshot, &save)? {
                println!("{}", path.display());
            }
        }
        eprintln!("{}", self.frames.summary());
        self.end.map_or(Ok(()), Err)
    }
}
