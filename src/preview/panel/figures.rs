//! The lower part of the panel: figures of the render.

use egui::{Color32, Grid, Pos2, RichText, Sense, Stroke, Ui, Vec2};

use crate::math::curve;
use crate::preview::snapshot::Figures;

/// Draws them.
pub fn show(ui: &mut Ui, figures: &Figures) {
    progress(ui, figures);
    training(ui, figures);
    kernels(ui, figures);
    memory(ui, figures);
    choices(ui, figures);
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
        row("time per sample", figures.seconds_per_sample.map_or("-".into(), time));
        row("estimated error", figures.error.map_or("-".into(), |error| format!("{:.2} %", 100.0 * error)));
        let slope = slope(&figures.errors);
        row("its log-log slope", slope.map_or("-".into(), |slope| format!("{slope:.2} (-0.5 is due)")));
        row(
            "non-finite",
            format!("{} samples, {} vertices", figures.non_finite_samples, figures.non_finite_vertices),
        );
        row("light vertices", figures.light_vertices.to_string());
        row("cache overflows", format!("{}, traced again", figures.cache_overflows));
    });
    plot(ui, &figures.errors);
}

/// Slope of the error against time, both logarithmic, over the last seven eighths of the time.
fn slope(errors: &[[f64; 2]]) -> Option<f64> {
    let from = errors.last()?[0] / 8.0;
    let late: Vec<[f64; 2]> =
        errors.iter().copied().filter(|point| point[0] >= from && point[1] > 0.0).collect();
    if late.len() < 3 { None } else { curve::slope(&late) }
}

/// Curve of the error against time, both logarithmic.
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

fn training(ui: &mut Ui, figures: &Figures) {
    let Some(learnt) = &figures.learnt else { return };
    ui.separator();
    ui.label(format!(
        "trained with {} paths: {} of {} eye subspaces in use{}",
        learnt.paths,
        learnt.used,
        learnt.subspaces,
        if learnt.of_this_view { "" } else { ", for another view" }
    ));
    if !learnt.losses.is_empty() {
        let losses: Vec<String> = learnt.losses.iter().map(|loss| format!("{loss:.2}")).collect();
        ui.label(format!("loss after each round, over that before it: {}", losses.join(", ")));
    }
}

fn kernels(ui: &mut Ui, figures: &Figures) {
    if figures.kernels.is_empty() {
        return;
    }
    let rows = figures.kernels.iter().map(|(name, seconds)| (name, time(*seconds)));
    ui.collapsing("Kernels, time per sample", |ui| table(ui, "kernels", rows));
}

fn memory(ui: &mut Ui, figures: &Figures) {
    let total: u64 = figures.memory.iter().map(|(_, bytes)| bytes).sum();
    let rows = figures.memory.iter().map(|(name, size)| (name, bytes(*size)));
    ui.collapsing(format!("Device memory {}", bytes(total)), |ui| table(ui, "memory", rows));
}

fn table<'a>(ui: &mut Ui, id: &str, rows: impl Iterator<Item = (&'a String, String)>) {
    Grid::new(id).num_columns(2).striped(true).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(RichText::new(name).small());
            ui.label(RichText::new(value).small());
            ui.end_row();
        }
    });
}

/// What was chosen for the user, and why.
fn choices(ui: &mut Ui, figures: &Figures) {
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
