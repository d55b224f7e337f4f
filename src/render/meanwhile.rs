//! Rendering while the method still learns.

use std::sync::Arc;

use super::Renderer;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::render::RenderError;
use crate::subspace::Model;
use crate::training::TrainingEvent;

/// Samples by one model, at least: two groups know their variance.
pub(super) const SAMPLES_PER_ROUND: u32 = 2 * SAMPLES_A_GROUP;

impl Renderer {
    /// Hears what was learnt in the meantime. Samples weigh by the inverse of their model's loss: the variance of a
    /// path's estimate is that loss, less the same for all models. What is known of losses is from paths that are in no
    /// picture, so that weights do not depend on what they weigh.
    pub(super) fn poll_training(&mut self) -> Result<(), RenderError> {
        while let Some(learning) = &self.learning {
            if self.samples < self.next_round || !self.samples.is_multiple_of(SAMPLES_A_GROUP) {
                break;
            }
            match learning.poll()? {
                None => break,
                Some(TrainingEvent::Round(model)) => {
                    self.connect_by(model)?;
                    self.next_round = self.samples + SAMPLES_PER_ROUND;
                }
                Some(TrainingEvent::Loss(loss)) => self.weigh_earlier(loss),
                Some(TrainingEvent::End(trained)) => {
                    // Paths that judged the last round may want other first connections.
                    if self.model.as_ref() != Some(&trained.model) {
                        self.set_model(trained.model)?;
                    }
                    self.report.choices.extend(trained.choices);
                    self.learning = None;
                }
            }
        }
        Ok(())
    }

    /// Connects by another model from now on. Between groups only: samples of a group are of one kind.
    ///
    /// # Errors
    /// A lost device, a buffer that does not fit.
    pub fn connect_by(&mut self, model: Arc<Model>) -> Result<(), RenderError> {
        self.set_model(model)?;
        self.report.round_samples.push(self.samples);
        Ok(())
    }

    /// The same, where no round is over.
    fn set_model(&mut self, model: Arc<Model>) -> Result<(), RenderError> {
        self.flush()?;
        self.sums.settle();
        if let Some(halves) = &mut self.halves {
            halves.first.settle();
        }
        if let Some(factor) = self.variance_by_first_connections(&model) {
            self.weigh_samples(factor);
        }
        self.integrator.set_model(&self.context, &model)?;
        let choices = self.integrator.choices();
        self.report.choices.retain(|old| choices.iter().all(|new| new.what != old.what));
        self.report.choices.extend(choices);
        self.report.training = Some(model.report.clone());
        self.model = Some(model);
        Ok(())
    }

    /// The loss by the model of now, over that by the one before.
    pub fn weigh_earlier(&mut self, loss: f64) {
        self.weigh_samples(loss);
        self.report.round_losses.push(loss);
    }

    /// The variance of a sample from now on over that of those before is so much.
    fn weigh_samples(&mut self, factor: f64) {
        self.sums.weigh_earlier(factor);
        if let Some(halves) = &mut self.halves {
            halves.first.weigh_earlier(factor);
        }
    }

    /// What another number of first vertices' connections does to the variance, beside the loss, which is of one number.
    fn variance_by_first_connections(&self, model: &Model) -> Option<f64> {
        let adapts = self.options.method.plan().connections.adapts;
        let now = model.first_connections.filter(|_| adapts)?;
        let before = self.model.as_ref().and_then(|model| model.first_connections);
        let before = before.map_or(now.made, |first| first.count);
        Some(now.variance_with(now.count) / now.variance_with(before))
    }
}
