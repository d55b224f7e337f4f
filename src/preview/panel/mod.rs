//! The panel beside the picture: choices, and figures of the render.

mod figures;
mod keys;

use egui::{Color32, DragValue, RichText, ScrollArea, Slider, Ui};

use crate::device::layout::SAMPLES_A_GROUP;
use crate::integrator::{Descriptor, METHODS};

use super::Settings;
use super::display::{Look, Show};
use super::snapshot::Snapshot;

pub use keys::{Action, keys};
use keys::{SHORTCUTS, VIEW_TRANSFORMS};

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

/// What the user has chosen.
pub struct Choices {
    pub look: Look,
    pub slot: usize,
    pub split: Split,
    pub paused: bool,
    /// Samples per pixel after which a picture is complete.
    pub samples: Option<u32>,
    /// The panel is shown.
    pub panel: bool,
}

/// What the panel shows besides.
pub struct Status<'a> {
    pub settings: &'a Settings,
    pub snapshot: &'a Snapshot,
    pub frames: String,
    pub message: Option<&'a str>,
}

/// Draws the panel.
pub fn show(ui: &mut Ui, status: &Status, choices: &mut Choices) -> Vec<Action> {
    let mut actions = Vec::new();
    let Status { settings, snapshot, .. } = status;
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
            let label = if choices.paused { "Resume" } else { "Pause" };
            if ui.button(label).on_hover_text("Space").clicked() {
                choices.paused = !choices.paused;
            }
            for shortcut in SHORTCUTS {
                let Some(what) = shortcut.button else { continue };
                let tooltip = format!("{}: {what}", shortcut.key_name());
                if ui.button(shortcut.label).on_hover_text(tooltip).clicked() {
                    actions.push(shortcut.action);
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
        figures::show(ui, &snapshot.figures);
        ui.separator();
        ui.label(RichText::new(&status.frames).small().weak());
        ui.collapsing("Keys", |ui| {
            ui.label(RichText::new(keys::help()).small());
        });
    });
    actions
}

fn integrators(ui: &mut Ui, status: &Status, choices: &mut Choices) {
    ui.horizontal_wrapped(|ui| {
        for (slot, Descriptor { name, key, help, .. }) in METHODS.into_iter().enumerate() {
            let label = format!("{key} {name}");
            ui.selectable_value(&mut choices.slot, slot, label).on_hover_text(*help);
        }
    });
    if let Some(activity) = &status.snapshot.figures.activity {
        match activity.fraction {
            Some(fraction) => {
                ui.add(egui::ProgressBar::new(fraction).text(&activity.what));
            }
            // No spinner: on a software device each frame of an animation takes time from rendering.
            None => {
                ui.label(format!("{} ...", activity.what));
            }
        }
    }
    let seen = status.snapshot.slot;
    if seen != choices.slot {
        let [seen, chosen] = [seen, choices.slot].map(|slot| METHODS[slot].name);
        ui.label(format!("showing {seen} until {chosen} is ready"));
    }
    ui.horizontal(|ui| {
        ui.label("compare with");
        egui::ComboBox::from_id_salt("split")
            .selected_text(match choices.split {
                Split::None => "nothing",
                Split::Reference => "the reference",
                Split::Slot(slot) => METHODS[slot].name,
            })
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut choices.split, Split::None, "nothing");
                if status.settings.reference.is_some() {
                    ui.selectable_value(&mut choices.split, Split::Reference, "the reference");
                }
                let others = METHODS.iter().enumerate().filter(|(slot, _)| *slot != choices.slot);
                for (slot, method) in others {
                    ui.selectable_value(&mut choices.split, Split::Slot(slot), method.name);
                }
            });
    });
}

fn look(ui: &mut Ui, status: &Status, choices: &mut Choices) {
    let look = &mut choices.look;
    ui.horizontal(|ui| {
        for (view, name) in VIEW_TRANSFORMS {
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
        ui.label(RichText::new(format!("available from {} samples on", 2 * SAMPLES_A_GROUP)).small());
    }
    if matches!(look.show, Show::EyeSubspaces | Show::LightSubspaces) && status.snapshot.subspaces.is_none() {
        let methods = METHODS.into_iter().filter(|method| method.default_method().plan().learns());
        let names: Vec<&str> = methods.map(|method| method.name).collect();
        ui.label(RichText::new(format!("only with {}, once it is trained", names.join(", "))).small());
    }
}
