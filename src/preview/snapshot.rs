//! What the worker publishes for the window.

use std::sync::Arc;

use super::film::Film;
use crate::film::Picture;
use crate::integrator::{Choice, FirstSubspaces};
use crate::render::Report;

/// A picture as it stands, with its figures.
#[derive(Clone, Default)]
pub struct Snapshot {
    /// Radiance, with the layers `variance` and `samples`; smaller than was asked for while the camera moves.
    pub picture: Arc<Picture>,
    /// Of the integrator on the other side of a split: its slot, and its picture.
    pub beside: Option<(usize, Arc<Picture>)>,
    /// The integrator that made the picture.
    pub slot: usize,
    /// The view that it shows, as the request numbered it.
    pub view: u64,
    /// Its camera as flags of `halfway render`.
    pub camera_flags: String,
    /// Counts up with every snapshot.
    pub number: u64,
    /// Denoised, of a moment ago, where requested and as soon as there is one.
    pub denoised: Option<Arc<Picture>>,
    /// Of each pixel, where requested.
    pub subspaces: Option<Arc<Vec<FirstSubspaces>>>,
    /// Samples of each pixel that were not finite, where requested.
    pub non_finite: Option<Arc<Vec<u64>>>,
    pub figures: Figures,
}

/// What the panel shows.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// Samples per pixel, and seconds of rendering them.
    pub samples: u32,
    pub seconds: f64,
    /// Time for one sample of all pixels.
    pub seconds_per_sample: Option<f64>,
    /// The same by kernel, most first.
    pub kernels: Vec<(String, f64)>,
    /// Estimated relative error of the picture.
    pub error: Option<f64>,
    /// Seconds and estimated error, over the course of the render.
    pub errors: Vec<[f64; 2]>,
    /// Bytes on the device by buffer, all integrators together, most first.
    pub memory: Vec<(String, u64)>,
    pub non_finite_samples: u64,
    pub non_finite_vertices: u64,
    pub light_vertices: u64,
    /// Iterations whose light vertices found no room, and were traced again with enough of it.
    pub cache_overflows: u64,
    pub learnt: Option<Learnt>,
    pub choices: Vec<Choice>,
    /// Work in the background.
    pub activity: Option<Activity>,
    /// All that was requested is rendered.
    pub done: bool,
}

/// The model that an integrator uses.
#[derive(Clone, Debug, Default)]
pub struct Learnt {
    pub subspaces: u32,
    /// Eye subspaces with training data.
    pub used: u64,
    /// Training paths.
    pub paths: u64,
    /// The loss after each round over that before it.
    pub losses: Vec<f64>,
    /// The model was trained for the view that is seen.
    pub of_this_view: bool,
}

/// Work in the background.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Activity {
    /// For the user.
    pub what: String,
    /// How much of it is done, from 0 to 1, where that is known.
    pub fraction: Option<f32>,
}

/// The figures of a film that shows that view.
pub(super) fn figures(film: &Film, report: Report, view: u64) -> Figures {
    let samples = f64::from(report.samples.max(1));
    // Times of a small picture say little of those of a whole one.
    let timed = report.kernels.iter().filter(|_| film.divisor == 1);
    let mut kernels: Vec<(String, f64)> =
        timed.map(|(name, (seconds, _))| (name.clone(), seconds / samples)).collect();
    kernels.sort_by(|a, b| b.1.total_cmp(&a.1));
    Figures {
        samples: report.samples,
        seconds: report.seconds,
        seconds_per_sample: film.seconds_per_sample.filter(|_| film.divisor == 1),
        kernels,
        error: film.error(),
        errors: film.errors.clone(),
        non_finite_samples: report.non_finite - report.rays.non_finite_vertices,
        non_finite_vertices: report.rays.non_finite_vertices,
        light_vertices: report.rays.light_vertices,
        cache_overflows: report.rays.cache_overflows,
        learnt: film.renderer.model.as_ref().map(|model| Learnt {
            subspaces: model.subspaces,
            used: model.report.counts.learnt_rows,
            paths: model.report.counts.paths,
            losses: report.round_losses,
            of_this_view: film.trained_view == view,
        }),
        choices: report.choices,
        ..Figures::default()
    }
}

/// Bytes by buffer, of all films. Buffers that films share are in each of their tables, and count once.
pub(super) fn memory<'a>(films: impl Iterator<Item = &'a Film>) -> Vec<(String, u64)> {
    let mut all: Vec<(String, u64)> = Vec::new();
    let mut seen: Vec<&wgpu::Buffer> = Vec::new();
    for film in films {
        for (name, buffer) in film.renderer.buffers() {
            if !seen.contains(&buffer) {
                seen.push(buffer);
                match all.iter_mut().find(|(other, _)| other == name) {
                    Some((_, bytes)) => *bytes += buffer.size(),
                    None => all.push((name.clone(), buffer.size())),
                }
            }
        }
    }
    all.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    all
}
