//! Renders that are kept on disk and go on from there, and renders of a portion of the samples.
//!
//! A render that goes on makes the picture of one that was never stopped, bit for bit, but for one that learns while it
//! renders: which sample uses which round is up to the clock there, so that goes on by the model that it had. (What goes on
//! within a group traces its light paths again, and counts their rays.)

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::halves::HalvesInProgress;
use super::{LearningTime, Origin, RenderError, RenderOptions, Renderer, made_by, maker};
use crate::device::Traversal;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::Layer;
use crate::film::checkpoint::{Header, Samples, SavedRender};
use crate::film::state::FilmState;
use crate::film::sums::SAMPLES_A_FLUSH;
use crate::integrator::{Choice, RayCounts};
use crate::math::fnv::fnv;
use crate::scene::Camera;
use crate::subspace::{Model, TrainingReport};

/// What files of a render say that the render itself does not know.
#[derive(Clone, Debug)]
pub struct Keeping {
    /// As [`picture_of`] has it.
    pub picture: BTreeMap<String, String>,
    pub origin: Origin,
    /// See [`Header`].
    pub command: Vec<String>,
    pub folder: String,
    /// Of a portion: the sample after its last.
    pub end: Option<u32>,
}

/// Where a render stands, beside its film.
#[derive(Debug, Serialize, Deserialize)]
struct Run {
    elapsed_ns: u64,
    tracing_ns: u64,
    learning_ns: u64,
    next_round: u32,
    rays: RayCounts,
    /// Bits: JSON may round.
    round_losses: Vec<u64>,
    round_samples: Vec<u32>,
    choices: Vec<Choice>,
}

/// What a picture is of and how it is made, by name: all that its samples depend on but the device.
pub fn picture_of(scene_hash: u64, camera: &Camera, options: &RenderOptions) -> BTreeMap<String, String> {
    let view = options.view;
    let region = view.region();
    let mut picture = BTreeMap::new();
    let mut say = |name: &str, value: String| drop(picture.insert(name.to_owned(), value));
    say("program", concat!("Halfway ", env!("CARGO_PKG_VERSION")).into());
    say("scene", format!("{scene_hash:016x}"));
    say("size", format!("{}x{}", view.width, view.height));
    let part = [region.x, region.y, region.width, region.height, region.stride].map(|n| n.to_string());
    say("part", part.join(","));
    let Camera { name: _, position, right, up, forward, projection } = camera;
    say("camera", format!("{position} {right} {up} {forward} {projection:?}"));
    say("integrator", serde_json::to_string(&options.method).unwrap_or_default());
    say("maximum depth", view.max_depth.map_or("none".into(), |depth| depth.to_string()));
    say("roulette cap", view.roulette_cap.to_string());
    say("seed", view.seed.to_string());
    if view.independent {
        say("samples", "independent".into());
    }
    if let Some(strategy) = options.strategy {
        say("strategy", format!("{strategy:?}"));
    }
    if options.transparent {
        say("transparent", "yes".into());
    }
    if options.method.plan().learns() {
        say(
            "model",
            match &options.model {
                Some(model) => hash(model),
                None => serde_json::to_string(&options.training).unwrap_or_default(),
            },
        );
    }
    picture
}

/// Of all that a model says of the scene, not of how long it took to learn.
fn hash(model: &Arc<Model>) -> String {
    let model = Model { report: TrainingReport::default(), ..Model::clone(model) };
    format!("{:016x}", fnv(&model.to_bytes()))
}

/// Says how the picture of a file differs from that of the options, and the device.
fn differences(header: &Header, keeping: &Keeping) -> Vec<String> {
    let mut found = header.differences(&keeping.picture);
    // What traces the scene is known once it is there: `go_on_from` looks at that.
    if !header.devices.iter().map(|made_by| maker(made_by).0).eq([keeping.origin.device.as_str()]) {
        found.push(format!("device {} there, {} here", header.devices.join(" and "), keeping.origin.device));
    }
    if header.samples.end != keeping.end {
        let end =
            |end: Option<u32>| end.map_or("no portion".into(), |end| format!("a portion up to sample {end}"));
        found.push(format!("{} there, {} here", end(header.samples.end), end(keeping.end)));
    }
    found
}

impl Renderer {
    /// Begins with this sample, which is the first of a group, in place of the first. Before the render has begun.
    pub fn begin_at(&mut self, sample: u32) {
        debug_assert!(self.samples == 0 && sample.is_multiple_of(SAMPLES_A_GROUP));
        (self.samples, self.first) = (sample, sample);
    }

    /// The next sample is in a block whose first groups are not this render's: its groups are kept one by one.
    pub(super) fn is_apart(&self) -> bool {
        !self.first.is_multiple_of(SAMPLES_A_FLUSH)
            && self.samples / SAMPLES_A_FLUSH == self.first / SAMPLES_A_FLUSH
    }

    /// All samples so far, wherever they lie.
    ///
    /// # Errors
    /// A lost device.
    pub fn film_state(&self) -> Result<FilmState, RenderError> {
        let by_groups = self.is_apart() || self.halves.is_some();
        let unit = if by_groups { SAMPLES_A_GROUP } else { SAMPLES_A_FLUSH };
        let mut open = BTreeMap::new();
        if !self.samples.is_multiple_of(unit) {
            open.insert(self.samples / SAMPLES_A_FLUSH, self.integrator.wavefront().film(&self.context)?);
        }
        if let Some(halves) = &self.halves {
            halves.add_block_to(open.entry(self.samples / SAMPLES_A_FLUSH).or_default());
            open.retain(|_, film| !film.is_empty());
        }
        Ok(FilmState { sums: self.sums.clone(), open, groups: self.groups.clone() })
    }

    /// What a file needs for the render to go on from here; with all `layers` of its picture, for a portion.
    ///
    /// # Errors
    /// A lost device.
    pub fn saved(&mut self, keeping: &Keeping, layers: Vec<Layer>) -> Result<SavedRender, RenderError> {
        let film = self.film_state()?;
        let report = self.status(film.non_finite())?;
        let nanoseconds = |time: Duration| time.as_nanos() as u64;
        let run = Run {
            elapsed_ns: nanoseconds(self.elapsed),
            tracing_ns: nanoseconds(self.learning_time.tracing),
            learning_ns: nanoseconds(self.learning_time.total),
            next_round: self.next_round,
            rays: report.rays,
            round_losses: report.round_losses.iter().map(|loss| loss.to_bits()).collect(),
            round_samples: report.round_samples.clone(),
            choices: self.report.choices.clone(),
        };
        let header = Header {
            picture: keeping.picture.clone(),
            samples: Samples { first: self.first, next: self.samples, end: keeping.end },
            size: [self.sums.width, self.sums.height],
            // A power of two.
            radiance_exponent: self.radiance_scale.log2().round() as i32,
            devices: vec![made_by(&keeping.origin.device, self.report.traversal)],
            command: keeping.command.clone(),
            folder: keeping.folder.clone(),
            metadata: report.metadata(&keeping.origin),
            run: serde_json::to_value(run).unwrap_or_default(),
        };
        let model = self.model.as_ref().map(|model| model.to_bytes());
        let half = self.halves.as_ref().map(|halves| halves.first.clone());
        Ok(SavedRender { header, film, half, layers, model })
    }

    /// Goes on from there. The options are those of the render that wrote it, its model among them. Before the render has
    /// begun.
    ///
    /// # Errors
    /// A lost device, a file that does not say where its render stood, or whose rays were traced otherwise.
    pub fn go_on_from(&mut self, path: &Path, saved: SavedRender) -> Result<(), RenderError> {
        let what = "where it stood";
        let unknown = |_| RenderError::UnknownRun { path: path.to_owned(), what };
        let run: Run = serde_json::from_value(saved.header.run).map_err(unknown)?;
        let traced = saved.header.devices.iter().map(|made_by| maker(made_by).1);
        if !traced.eq([self.report.traversal]) {
            let [there, here] = match self.report.traversal {
                Traversal::Hardware => ["kernels", "hardware"],
                Traversal::Compute | Traversal::Auto => ["hardware", "kernels"],
            };
            let differences = format!("rays were traced by {there} there, by {here} here (--traversal)");
            return Err(RenderError::OtherRender { path: path.to_owned(), differences });
        }
        let SavedRender {
            film: FilmState { sums, mut open, groups },
            header: Header { samples, .. },
            half,
            ..
        } = saved;
        (self.first, self.samples) = (samples.first, samples.next);
        // Of samples that were not kept in halves there are none.
        self.halves = half.filter(|_| self.options.halves).map(HalvesInProgress::going_on);
        let is_apart = self.is_apart();
        if let Some(halves) = self.halves.as_mut().filter(|_| !is_apart) {
            open.values_mut().for_each(|film| halves.take_block(film));
        }
        if let Some(film) = open.remove(&(self.samples / SAMPLES_A_FLUSH)) {
            self.integrator.wavefront().write_film(&self.context, &film)?;
        }
        (self.sums, self.groups) = (sums, groups);
        self.elapsed = Duration::from_nanos(run.elapsed_ns);
        self.learning_time = LearningTime {
            tracing: Duration::from_nanos(run.tracing_ns),
            total: Duration::from_nanos(run.learning_ns),
        };
        self.next_round = run.next_round;
        self.rays_before = run.rays;
        self.report.round_losses = run.round_losses.into_iter().map(f64::from_bits).collect();
        self.report.round_samples = run.round_samples;
        self.report.choices = run.choices;
        Ok(())
    }
}

/// What the rays of a file's samples came to, from its [`Header::run`].
pub fn rays_of(run: &serde_json::Value) -> RayCounts {
    let parts = run.as_array().into_iter().flatten().map(rays_of);
    let whole = serde_json::from_value(run["rays"].clone()).unwrap_or_default();
    parts.fold(whole, |sum, rays| sum + rays)
}

/// Checks that a file is of the render that is asked for, and adds its model to the options.
///
/// # Errors
/// Another render, with all that is different; a model that cannot be read.
pub fn take_up(
    path: &Path,
    saved: &SavedRender,
    keeping: &Keeping,
    options: &mut RenderOptions,
) -> Result<(), RenderError> {
    let differences = differences(&saved.header, keeping);
    if !differences.is_empty() {
        return Err(RenderError::OtherRender { path: path.to_owned(), differences: differences.join("; ") });
    }
    if let Some(model) = &saved.model {
        options.model = Some(Arc::new(Model::from_bytes(path, model)?));
    }
    Ok(())
}
