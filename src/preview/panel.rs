//! The panel beside the picture: what one can choose, and how things stand.

use egui::{Color32, DragValue, Grid, Pos2, RichText, ScrollArea, Sense, Slider, Stroke, Ui, Vec2};

use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::tonemap::ViewTransform;
use crate::math::curve;

use super::display::{Look, Show};
use super::snapshot::{Figures, Snapshot};
use super::{SLOTS, Settings};

/// Points.
pub const WIDTH: f32 = 300.0;

/// What is seen in the right part of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Split {
    #[default]
    None,
    Reference,
    Slot(usize),
}

/// What one can choose.
pub struct Choices {
    pub look: Look,
    pub slot: usize,
    pub split: Split,
    pub paused: bool,
    pub samples: Option<u32>,
    pub panel: bool,
}

/// What is to be done once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Save,
    Restart,
    CopyCamera,
    FrameAll,
    ResetCamera,
    Close,
}

/// What the panel tells besides.
pub struct Status<'a> {
    pub settings: &'a Settings,
    pub snapshot: &'a Snapshot,
    pub frames: String,
    pub message: Option<&'a str>,
}

/// The keys that need no pointer.
pub fn keys(ui: &Ui, choices: &mut Choices, has_reference: bool) -> Vec<Action> {
    use egui::Key;
    let mut actions = Vec::new();
    if ui.ctx().text_edit_focused() {
        return actions;
    }
    // Keys are for the picture: none is to press the button that Tab has come to.
    ui.memory_mut(|memory| {
        if let Some(id) = memory.focused() {
            memory.surrender_focus(id);
        }
    });
    ui.input(|input| {
        // A slow frame has several presses of a key, and the modifiers that were held with each are gone by its end.
        let times = |wanted: Key, with_command: bool| {
            let is_it = |event: &&egui::Event| {
                matches!(event, egui::Event::Key { key, pressed: true, modifiers, .. }
                    if *key == wanted && modifiers.command == with_command)
            };
            input.events.iter().filter(is_it).count()
        };
        let pressed = |key| times(key, false) > 0;
        let digits = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5];
        if let Some(slot) = digits.into_iter().position(pressed) {
            choices.slot = slot;
        }
        for (key, action) in [(Key::S, Action::Save), (Key::Q, Action::Close)] {
            if times(key, true) > 0 {
                actions.push(action);
            }
        }
        choices.paused ^= times(Key::Space, false) % 2 == 1;
        choices.panel ^= times(Key::Tab, false) % 2 == 1;
        let steps = times(Key::Plus, false) as f32 + times(Key::Equals, false) as f32;
        choices.look.exposure += 0.5 * (steps - times(Key::Minus, false) as f32);
        // While one flies, letters are directions.
        if input.pointer.secondary_down() {
            return;
        }
        for (key, action) in [
            (Key::R, Action::Restart),
            (Key::F, Action::FrameAll),
            (Key::Home, Action::ResetCamera),
            (Key::C, Action::CopyCamera),
        ] {
            if pressed(key) {
                actions.push(action);
            }
        }
        for _ in 0..times(Key::H, false) {
            choices.look.show = next(&Show::ALL, choices.look.show);
            if choices.look.show == Show::Error && !has_reference {
                choices.look.show = next(&Show::ALL, choices.look.show);
            }
        }
        for _ in 0..times(Key::V, false) {
            choices.look.view =
                next(&[ViewTransform::Neutral, ViewTransform::Srgb, ViewTransform::Agx], choices.look.view);
        }
    });
    actions
}

fn next<T: Copy + PartialEq>(all: &[T], now: T) -> T {
    let place = all.iter().position(|&one| one == now).unwrap_or(0);
    all[(place + 1) % all.len()]
}

/// Draws the panel.
pub fn show(ui: &mut Ui, status: &Status, choices: &mut Choices) -> Vec<Action> {
    let mut actions = Vec::new();
    let Status { settings, snapshot, .. } = status;
    let figures = &snapshot.figures;
    ScrollArea::vertical().show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.heading(&settings.title);
        ui.label(RichText::new(settings.context.describe()).small().weak());
        if let Some(message) = status.message {
            ui.label(RichText::new(message).color(Color32::LIGHT_YELLOW));
        }
        ui.separator();
        integrators(ui, status, choices);
        ui.separator();
        look(ui, status, choices);
        ui.separator();
        ui.horizontal_wrapped(|ui| {
            let label = if choices.paused { "Go on" } else { "Pause" };
            if ui.button(label).on_hover_text("Space").clicked() {
                choices.paused = !choices.paused;
            }
            for (label, keys, action) in [
                ("Restart", "R", Action::Restart),
                ("Save", "Ctrl+S: EXR, PNG, and what was learnt", Action::Save),
                ("Copy camera", "C: as flags of `halfway render`", Action::CopyCamera),
                ("Frame all", "F", Action::FrameAll),
                ("Reset camera", "Home", Action::ResetCamera),
            ] {
                if ui.button(label).on_hover_text(keys).clicked() {
                    actions.push(action);
                }
            }
        });
        ui.horizontal(|ui| {
            let mut limited = choices.samples.is_some();
            ui.checkbox(&mut limited, "stop after");
            let mut samples = choices.samples.unwrap_or(256);
            ui.add_enabled(limited, DragValue::new(&mut samples).range(1..=1_000_000).suffix(" samples"));
            choices.samples = limited.then_some(samples);
        });
        ui.separator();
        progress(ui, figures);
        learning(ui, figures);
        kernels(ui, figures);
        memory(ui, figures);
        ui.separator();
        ui.label(RichText::new(&status.frames).small().weak());
        ui.collapsing("Keys", |ui| {
            ui.label(RichText::new(KEYS).small());
        });
    });
    actions
}

const KEYS: &str = "left drag: orbit\nmiddle drag, or shift and left: pan\nwheel: dolly\nright drag: look around, and fly by \
                    WASDQE (shift: fast)\nF: frame all, Home: the scene's camera\n1 to 5: integrator\nH: next heat map\nV: \
                    next view transform\n+ and -: exposure\nspace: pause, R: restart\nCtrl+S: save, C: copy the camera\nTab: \
                    this panel, Ctrl+Q: save and close";

fn integrators(ui: &mut Ui, status: &Status, choices: &mut Choices) {
    let names: [&str; SLOTS] = status.settings.methods.map(|method| method.name());
    ui.horizontal_wrapped(|ui| {
        for (slot, name) in names.iter().enumerate() {
            ui.selectable_value(&mut choices.slot, slot, format!("{} {name}", slot + 1));
        }
    });
    if let Some(making) = &status.snapshot.figures.making {
        match making.share {
            Some(share) => {
                ui.add(egui::ProgressBar::new(share).text(&making.what));
            }
            // Nothing that turns: on a software device each frame is taken from the light.
            None => {
                ui.label(format!("{} ...", making.what));
            }
        }
    }
    let seen = status.snapshot.slot;
    if seen != choices.slot {
        ui.label(format!("{} is seen until {} is ready", names[seen], names[choices.slot]));
    }
    ui.horizontal(|ui| {
        ui.label("beside it");
        egui::ComboBox::from_id_salt("split")
            .selected_text(match choices.split {
                Split::None => "nothing",
                Split::Reference => "the reference",
                Split::Slot(slot) => names[slot],
            })
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut choices.split, Split::None, "nothing");
                if status.settings.reference.is_some() {
                    ui.selectable_value(&mut choices.split, Split::Reference, "the reference");
                }
                for (slot, name) in names.iter().enumerate().filter(|(slot, _)| *slot != choices.slot) {
                    ui.selectable_value(&mut choices.split, Split::Slot(slot), *name);
                }
            });
    });
}

fn look(ui: &mut Ui, status: &Status, choices: &mut Choices) {
    let look = &mut choices.look;
    ui.horizontal(|ui| {
        for (view, name) in
            [(ViewTransform::Neutral, "neutral"), (ViewTransform::Srgb, "sRGB"), (ViewTransform::Agx, "AgX")]
        {
            ui.selectable_value(&mut look.view, view, name);
        }
    });
    ui.add(Slider::new(&mut look.exposure, -10.0..=10.0).text("EV").clamping(egui::SliderClamping::Never));
    egui::ComboBox::from_id_salt("show").selected_text(look.show.name()).show_ui(ui, |ui| {
        for show in Show::ALL {
            if show != Show::Error || status.settings.reference.is_some() {
                ui.selectable_value(&mut look.show, show, show.name());
            }
        }
    });
    if !look.show.legend().is_empty() {
        ui.label(RichText::new(look.show.legend()).small().weak());
    }
    if look.show == Show::Variance && status.snapshot.figures.samples < 2 * SAMPLES_A_GROUP {
        ui.label(RichText::new(format!("known from {} samples on", 2 * SAMPLES_A_GROUP)).small());
    }
    if matches!(look.show, Show::EyeSubspaces | Show::LightSubspaces) && status.snapshot.subspaces.is_none() {
        ui.label(RichText::new("only spcbpt has subspaces, once it has learnt").small());
    }
}

fn progress(ui: &mut Ui, figures: &Figures) {
    Grid::new("progress").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        };
        row("samples", figures.samples.to_string() + if figures.done { ", done" } else { "" });
        row("time", format!("{:.1} s", figures.seconds));
        row("a sample takes", figures.seconds_a_sample.map_or("-".into(), time));
        row("estimated error", figures.error.map_or("-".into(), |error| format!("{:.2} %", 100.0 * error)));
        let slope = slope(&figures.errors);
        row("its log-log slope", slope.map_or("-".into(), |slope| format!("{slope:.2} (-0.5 is due)")));
        row(
            "non-finite",
            format!("{} samples, {} vertices", figures.non_finite_samples, figures.non_finite_vertices),
        );
        row("light vertices", figures.light_vertices.to_string());
        row("cache overflows", format!("{}, traced anew", figures.cache_overflows));
    });
    plot(ui, &figures.errors);
}

/// Of the error against time, in logarithms, over the last seven eighths of the time.
fn slope(errors: &[[f64; 2]]) -> Option<f64> {
    let from = errors.last()?[0] / 8.0;
    let late: Vec<[f64; 2]> =
        errors.iter().copied().filter(|point| point[0] >= from && point[1] > 0.0).collect();
    if late.len() < 3 { None } else { curve::slope(&late) }
}

/// Error against time, both by logarithm.
fn plot(ui: &mut Ui, errors: &[[f64; 2]]) {
    let points: Vec<[f64; 2]> = errors
        .iter()
        .filter(|point| point[0] > 0.0 && point[1] > 0.0)
        .map(|point| point.map(f64::ln))
        .collect();
    if points.len() < 2 {
        return;
    }
    let (response, painter) = ui.allocate_painter(Vec2::new(ui.available_width(), 70.0), Sense::hover());
    let rect = response.rect.shrink(3.0);
    painter.rect_filled(response.rect, 2.0, Color32::from_gray(16));
    let range = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        [low, (high - low).max(1e-9)]
    };
    let [[x0, width], [y0, height]] = [range(0), range(1)];
    let place = |point: &[f64; 2]| {
        let x = rect.left() + rect.width() * ((point[0] - x0) / width) as f32;
        Pos2::new(x, rect.bottom() - rect.height() * ((point[1] - y0) / height) as f32)
    };
    painter.line(points.iter().map(place).collect(), Stroke::new(1.5, Color32::LIGHT_GREEN));
    response.on_hover_text("estimated error against time, both logarithmic");
}

fn learning(ui: &mut Ui, figures: &Figures) {
    let Some(learnt) = &figures.learnt else { return };
    ui.separator();
    ui.label(format!(
        "learnt from {} paths: {} of {} eye subspaces in use{}",
        learnt.paths,
        learnt.used,
        learnt.subspaces,
        if learnt.of_this_view { "" } else { ", for another view" }
    ));
    if !learnt.losses.is_empty() {
        let losses: Vec<String> = learnt.losses.iter().map(|loss| format!("{loss:.2}")).collect();
        ui.label(format!("loss after each lesson, over that before it: {}", losses.join(", ")));
    }
}

fn kernels(ui: &mut Ui, figures: &Figures) {
    if figures.kernels.is_empty() {
        return;
    }
    ui.collapsing("Kernels, time a sample", |ui| {
        Grid::new("kernels").num_columns(2).striped(true).show(ui, |ui| {
            for (name, seconds) in &figures.kernels {
                ui.label(RichText::new(name).small());
                ui.label(RichText::new(time(*seconds)).small());
                ui.end_row();
            }
        });
    });
}

fn memory(ui: &mut Ui, figures: &Figures) {
    let total: u64 = figures.memory.iter().map(|(_, bytes)| bytes).sum();
    ui.collapsing(format!("Device memory {}", bytes(total)), |ui| {
        Grid::new("memory").num_columns(2).striped(true).show(ui, |ui| {
            for (name, size) in &figures.memory {
                ui.label(RichText::new(name).small());
                ui.label(RichText::new(bytes(*size)).small());
                ui.end_row();
            }
        });
    });
    for choice in &figures.choices {
        let line = format!("{}: {} ({})", choice.what, choice.value, choice.reason);
        ui.label(RichText::new(line).small().weak());
    }
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{s:.2} s"),
        s if s >= 1e-3 => format!("{:.1} ms", 1e3 * s),
        s => format!("{:.0} us", 1e6 * s),
    }
}

fn bytes(size: u64) -> String {
    match size as f64 {
        b if b >= 1e9 => format!("{:.2} GB", b * 1e-9),
        b if b >= 1e6 => format!("{:.1} MB", b * 1e-6),
        b => format!("{:.1} kB", b * 1e-3),
    }
}
