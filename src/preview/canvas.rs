//! The picture in the window, and what pointer and keys do to it.

use egui::{Color32, CursorIcon, Key, PointerButton, Pos2, Rect, Sense, Stroke, TextureHandle, Ui, Vec2};

use super::controls::Navigator;
use super::display::in_own_threads;
use crate::scene::Scene;

/// Points beside the divider of a split that take hold of it.
const GRIP: f32 = 6.0;

/// What is shown.
pub struct Canvas<'a> {
    pub picture: Option<&'a TextureHandle>,
    /// The right side of a split, with the names of both sides.
    pub beside: Option<(&'a TextureHandle, [&'a str; 2])>,
    /// Shown in place of the picture, as long as there is none.
    pub waiting: &'a str,
    /// Width over height.
    pub aspect: f32,
}

/// What the pointer and keys did.
#[derive(Default)]
pub struct Motion {
    pub moved: bool,
    /// A button is held: the camera will move again.
    pub held: bool,
}

/// Shows the picture as large as there is room, and moves the camera. `divider` is a fraction of the picture's width.
pub fn show(
    ui: &mut Ui,
    canvas: &Canvas,
    navigator: &mut Navigator,
    divider: &mut f32,
    scene: &Scene,
) -> Motion {
    let room = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(room, Sense::CLICK | Sense::DRAG);
    let size = match room.width() / room.height() > canvas.aspect {
        true => Vec2::new(room.height() * canvas.aspect, room.height()),
        false => Vec2::new(room.width(), room.width() / canvas.aspect),
    };
    let rect = Rect::from_center_size(room.center(), size);
    let painter = ui.painter_at(room);
    painter.rect_filled(room, 0.0, Color32::from_gray(24));
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    let Some(picture) = canvas.picture else {
        let font = egui::FontId::proportional(16.0);
        painter.text(room.center(), egui::Align2::CENTER_CENTER, canvas.waiting, font, Color32::GRAY);
        return Motion::default();
    };
    painter.image(picture.id(), rect, whole, Color32::WHITE);
    let mut dragging_divider = false;
    if let Some((beside, names)) = &canvas.beside {
        let x = rect.left() + *divider * rect.width();
        let right = Rect::from_min_max(Pos2::new(x, rect.top()), rect.max);
        let uv = Rect::from_min_max(Pos2::new(*divider, 0.0), Pos2::new(1.0, 1.0));
        painter.image(beside.id(), right, uv, Color32::WHITE);
        painter.vline(x, rect.y_range(), Stroke::new(1.5, Color32::WHITE));
        let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
        let handle = ui.interact(grip, ui.scope_id().with("divider"), Sense::drag());
        if handle.hovered() || handle.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        dragging_divider = handle.dragged();
        *divider = (*divider + handle.drag_delta().x / rect.width()).clamp(0.0, 1.0);
        let font = egui::FontId::proportional(13.0);
        for (name, x, align) in
            [(names[0], x - 8.0, egui::Align2::RIGHT_TOP), (names[1], x + 8.0, egui::Align2::LEFT_TOP)]
        {
            let place = Pos2::new(x, rect.top() + 6.0);
            painter.text(place + Vec2::splat(1.0), align, name, font.clone(), Color32::BLACK);
            painter.text(place, align, name, font.clone(), Color32::WHITE);
        }
    }
    if dragging_divider {
        return Motion::default();
    }
    if response.drag_started() {
        // The camera turns about what is in the middle of the picture.
        let ahead = navigator.pivot() - navigator.from();
        if let Some(distance) = in_own_threads(|| scene.distance_along(navigator.from(), ahead)) {
            navigator.set_pivot_distance(distance);
        }
    }
    navigate(ui, &response, navigator, rect.height())
}

/// Left: orbit; middle, or left with shift: pan; right: look around, and fly with WASDQE; wheel: dolly.
fn navigate(ui: &Ui, response: &egui::Response, navigator: &mut Navigator, height: f32) -> Motion {
    let mut motion = Motion::default();
    let delta = response.drag_delta() / height;
    let [dx, dy] = [f64::from(delta.x), f64::from(delta.y)];
    let (shift, seconds, scroll) =
        ui.input(|input| (input.modifiers.shift, input.stable_dt, input.smooth_scroll_delta.y));
    let dragged = delta != Vec2::ZERO;
    let by = |button| response.dragged_by(button);
    if dragged && (by(PointerButton::Middle) || by(PointerButton::Primary) && shift) {
        navigator.pan(dx, dy);
        motion.moved = true;
    } else if dragged && by(PointerButton::Primary) {
        navigator.orbit(dx, dy);
        motion.moved = true;
    }
    if by(PointerButton::Secondary) {
        if dragged {
            navigator.look(dx, dy);
            motion.moved = true;
        }
        let axis = |plus: Key, minus: Key| {
            ui.input(|input| {
                f64::from(u8::from(input.key_down(plus))) - f64::from(u8::from(input.key_down(minus)))
            })
        };
        let [right, up, forward] = [axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S)];
        if [right, up, forward] != [0.0; 3] {
            navigator.fly(right, up, forward, f64::from(seconds.min(0.1)), shift);
            motion.moved = true;
            ui.ctx().request_repaint();
        }
    }
    motion.held = response.dragged();
    // A notch of a wheel is about 50 points.
    if response.hovered() && scroll != 0.0 {
        navigator.dolly(f64::from(scroll) / 50.0);
        motion.moved = true;
    }
    motion
}
