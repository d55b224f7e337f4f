//! What to render.

use std::sync::Arc;

use super::{Budget, SeenLayers};
use crate::integrator::{Method, Strategy, View};
use crate::scene::SceneFeatures;
use crate::subspace::Model;
use crate::training::Training;

/// What to render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderOptions {
    pub view: View,
    /// Index into the scene's cameras.
    pub camera: usize,
    pub method: Method,
    /// Of a bidirectional method, show this strategy only.
    pub strategy: Option<Strategy>,
    pub budget: Budget,
    /// Layers for albedo, normal and depth.
    pub first_hit_layers: bool,
    /// Albedo and normal are those of what is seen in mirrors and through smooth glass, as a denoiser wants them.
    pub through_mirrors: bool,
    /// Keep the samples of every other group apart as well: from these halves the error of the denoised picture is estimated.
    pub halves: bool,
    /// The environment is a light, and not to be seen.
    pub transparent: bool,
    pub seen: SeenLayers,
    /// Time every kernel.
    pub timing: bool,
    /// What `Method::SpcBpt` has learnt before; `None`: it learns from `training` first.
    pub model: Option<Arc<Model>>,
    pub training: Training,
    /// These are [those of a paper](Self::as_published), for reports.
    pub as_published: bool,
    /// Features to compile for; `None` takes those of the scene (tests force others).
    pub features: Option<SceneFeatures>,
}
