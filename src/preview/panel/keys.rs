//! Keys of the window, and the text that lists them.

use egui::{Key, Ui};

use crate::film::tonemap::ViewTransform;
use crate::integrator::{Descriptor, METHODS};
use crate::preview::display::Show;

use super::Choices;

/// What is done once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Save,
    Restart,
    CopyCamera,
    FrameAll,
    ResetCamera,
    Close,
}

/// An action with its key.
pub struct Shortcut {
    pub action: Action,
    pub label: &'static str,
    pub key: Key,
    /// With Ctrl, or the key that takes its place on the desktop.
    pub with_command: bool,
    /// What the action does, where the panel has a button for it.
    pub button: Option<&'static str>,
}

const fn plain(action: Action, label: &'static str, key: Key, button: &'static str) -> Shortcut {
    Shortcut { action, label, key, with_command: false, button: Some(button) }
}

const fn with_command(
    action: Action,
    label: &'static str,
    key: Key,
    button: Option<&'static str>,
) -> Shortcut {
    Shortcut { action, label, key, with_command: true, button }
}

/// Every action.
pub const SHORTCUTS: [Shortcut; 6] = [
    plain(Action::Restart, "Restart", Key::R, "drop all samples"),
    with_command(Action::Save, "Save", Key::S, Some("EXR, PNG, and the trained model")),
    plain(Action::CopyCamera, "Copy camera", Key::C, "as flags of `halfway render`"),
    plain(Action::FrameAll, "Frame all", Key::F, "show the whole scene"),
    plain(Action::ResetCamera, "Reset camera", Key::Home, "to where it began"),
    with_command(Action::Close, "Save and close", Key::Q, None),
];

impl Shortcut {
    /// Its key, for the user.
    pub fn key_name(&self) -> String {
        format!("{}{}", if self.with_command { "Ctrl+" } else { "" }, self.key.name())
    }
}

/// View transforms with their names, in the order in which a key steps through them.
pub const VIEW_TRANSFORMS: [(ViewTransform, &str); 3] =
    [(ViewTransform::Neutral, "neutral"), (ViewTransform::Srgb, "sRGB"), (ViewTransform::Agx, "AgX")];

/// Keys that change what the user has chosen, as [`help`] lists them.
const CHOICES: [(&str, &str); 6] = [
    ("Space", "Pause, resume"),
    ("D", "Denoised"),
    ("H", "Next heat map"),
    ("V", "Next view transform"),
    ("+ and -", "Exposure"),
    ("Tab", "This panel"),
];

/// Movements of the pointer, as [`help`] lists them.
const POINTER: [(&str, &str); 5] = [
    ("Left drag", "Orbit"),
    ("Middle drag, or Shift and left", "Pan"),
    ("Right drag", "Look around"),
    ("Right drag and WASDQE", "Fly (Shift: fast)"),
    ("Wheel", "Dolly"),
];

/// All keys and movements of the pointer, one per line.
pub fn help() -> String {
    let line = |(key, what): (&str, &str)| format!("{key}: {what}");
    let methods = METHODS.into_iter().map(|method| format!("{}: {}", method.key, method.name));
    let actions = SHORTCUTS.iter().map(|shortcut| format!("{}: {}", shortcut.key_name(), shortcut.label));
    let lines = POINTER.map(line).into_iter().chain(methods).chain(CHOICES.map(line)).chain(actions);
    lines.collect::<Vec<_>>().join("\n")
}

/// The key that chooses the method.
fn key(method: &Descriptor) -> Option<Key> {
    Key::from_name(&method.key.to_uppercase().to_string())
}

/// Applies the keys that were pressed since the last frame to the choices, and returns the actions that they ask for.
pub fn keys(ui: &Ui, choices: &mut Choices, has_reference: bool) -> Vec<Action> {
    let mut actions = Vec::new();
    if ui.ctx().text_edit_focused() {
        return actions;
    }
    // Keys are for the picture: none presses the button that Tab has moved the focus to.
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
        if let Some(slot) = METHODS.into_iter().position(|method| key(method).is_some_and(pressed)) {
            choices.slot = slot;
        }
        choices.paused ^= times(Key::Space, false) % 2 == 1;
        choices.panel ^= times(Key::Tab, false) % 2 == 1;
        let steps = times(Key::Plus, false) as f32 + times(Key::Equals, false) as f32;
        choices.look.exposure += 0.5 * (steps - times(Key::Minus, false) as f32);
        // While the camera flies, letters are directions.
        let flying = input.pointer.secondary_down();
        for Shortcut { action, key, with_command, .. } in SHORTCUTS {
            if times(key, with_command) > 0 && (with_command || !flying) {
                actions.push(action);
            }
        }
        if flying {
            return;
        }
        if times(Key::D, false) % 2 == 1 {
            let denoised = choices.look.show == Show::Denoised;
            choices.look.show = if denoised { Show::Radiance } else { Show::Denoised };
        }
        for _ in 0..times(Key::H, false) {
            choices.look.show = next(&Show::ALL, choices.look.show);
            // That has a key of its own, and wants a library.
            if choices.look.show == Show::Denoised || (choices.look.show == Show::Error && !has_reference) {
                choices.look.show = next(&Show::ALL, choices.look.show);
            }
        }
        for _ in 0..times(Key::V, false) {
            choices.look.view = next(&VIEW_TRANSFORMS.map(|(transform, _)| transform), choices.look.view);
        }
    });
    actions
}

fn next<T: Copy + PartialEq>(all: &[T], now: T) -> T {
    let place = all.iter().position(|&one| one == now).unwrap_or(0);
    all[(place + 1) % all.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_a_key_of_its_own() {
        let taken = [Key::Space, Key::Tab, Key::Plus, Key::Equals, Key::Minus, Key::D, Key::H, Key::V];
        let mut seen: Vec<Key> =
            taken.into_iter().chain(SHORTCUTS.iter().map(|shortcut| shortcut.key)).collect();
        for method in METHODS {
            let key = key(method).unwrap_or_else(|| panic!("{}: no key '{}'", method.name, method.key));
            assert!(!seen.contains(&key), "{}: '{}' is taken", method.name, method.key);
            seen.push(key);
            assert!(help().contains(&format!("{}: {}", method.key, method.name)));
        }
    }
}
