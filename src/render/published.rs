//! Methods as their papers have them, to tell what of a comparison is theirs and what is what has been added here since.

use super::RenderOptions;
use crate::integrator::method::{Given, Setting};
use crate::integrator::{Choice, RecordWeights, View};
use crate::subspace::{self, Optimiser};
use crate::training::{Training, When};

/// Light paths of an iteration, of pictures of so many pixels: Su, Li, Wang 2022. Other pictures have the same share of
/// their pixels.
const LIGHT_PATHS: f64 = 100_000.0;
const PIXELS: f64 = 1920.0 * 1080.0;
/// The same of every eye vertex.
const CONNECTIONS: u32 = 3;
const SUBSPACES: u32 = 1000;
const TRAINING_PATHS: u32 = 1_000_000;

/// Light paths for each pixel.
pub const LIGHT_PATHS_PER_PIXEL: f64 = LIGHT_PATHS / PIXELS;

impl RenderOptions {
    /// The same render by its method as published: light paths and points that belong to one sample alone, as many
    /// connections everywhere, weighed as the balance heuristic does, and learning from paths that path tracing finds. Of a
    /// method that has no connections to light vertices nothing changes. A number of training paths that was asked for stays:
    /// a million take minutes on a CPU.
    pub fn as_published(self) -> Self {
        let descriptor = self.method.descriptor();
        if !descriptor.takes(Setting::Connections) {
            return self;
        }
        let pixels = f64::from(self.view.width) * f64::from(self.view.height);
        let light_paths = (LIGHT_PATHS_PER_PIXEL * pixels).ceil() as u32;
        let given = Given {
            // Methods by records have few, however large the picture is.
            light_paths: (!descriptor.takes(Setting::Records)).then_some(light_paths),
            connections: Some([CONNECTIONS; 3]),
            shares: Some([1.0; 4]),
            no_thinning: true,
            // The form that the paper of spcbpt compares with.
            record_weights: Some(RecordWeights::Simple),
            ..Given::default()
        };
        let settings = subspace::Settings {
            subspaces: Some(SUBSPACES),
            lloyd_steps: 0,
            power_share: 0.0,
            smoothing: Some(0.0),
            optimiser: Optimiser::Softmax,
            light_guide: false,
            ..subspace::Settings::default()
        };
        let training = Training {
            paths: self.training.paths.or(Some(TRAINING_PATHS)),
            settings,
            when: Some(When::First),
            ..Training::default()
        };
        Self {
            view: View { independent: true, ..self.view },
            method: (descriptor.make)(&given),
            training: if descriptor.takes(Setting::Learning) { training } else { self.training },
            as_published: true,
            ..self
        }
    }

    /// What a report says of that.
    pub(super) fn preset(&self) -> Option<Choice> {
        let light_paths =
            format!("{:.4} light paths a pixel, {CONNECTIONS} connections", LIGHT_PATHS_PER_PIXEL);
        let plan = self.method.plan();
        let reason = match (plan.record_share(), plan.learns()) {
            (Some(_), _) => format!("independent samples, {CONNECTIONS} connections, shares of 1"),
            (None, false) => format!("independent samples, {light_paths}, shares of 1"),
            (None, true) => format!(
                "independent samples, {light_paths}, shares of 1, {SUBSPACES} subspaces a side, {} training paths",
                self.training.paths.unwrap_or(TRAINING_PATHS)
            ),
        };
        self.as_published.then(|| Choice::new("settings", "as published", reason))
    }
}
