//! What comes before the first sample: the scene goes to the device, and the method learns.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::caveats::caveats;
use super::halves::HalvesInProgress;
use super::meanwhile::SAMPLES_PER_ROUND;
use super::seen::{Seen, SeenLayers, Surfaces};
use super::tracing::settle;
use super::{Budget, LearningTime, PictureMemory, RenderOptions, Renderer, Report, Stop, TimeLimit};
use crate::accel::{Accel, arranged};
use crate::device::layout::Camera;
use crate::device::scene::{DeviceScene, SceneMemory};
use crate::device::{Context, DeviceError};
use crate::film::Region;
use crate::film::sums::FilmSums;
use crate::integrator::{Choice, RayCounts, Settings, integrator};
use crate::render::RenderError;
use crate::scene::{self, Material, Repeated, Scene, SceneFeatures};
use crate::training::{
    PreparedTrainer, Training, TrainingProgress, TrainingResult, TrainingTask, WarmStart, When, train,
};

/// A scene on a device: what all its renders share. Clones are the same one.
#[derive(Clone)]
pub struct Uploaded {
    context: Context,
    scene: DeviceScene,
    /// Of the scene's content.
    pub hash: u64,
    /// Of the scene's loader.
    warnings: Vec<String>,
    /// There are mirrors or smooth glass.
    has_mirrors: bool,
    triangles: usize,
    dropped_triangles: usize,
    accel_seconds: f64,
    /// How meshes are held that are shown in many places.
    choices: Vec<Choice>,
    /// Where layers need them.
    surfaces: Option<Arc<Surfaces>>,
}

impl Uploaded {
    /// Builds the acceleration structure and uploads the scene; for other `features` than its own only in tests.
    ///
    /// # Errors
    /// What the layers below report.
    pub fn new(
        context: &Context,
        scene: &Scene,
        features: Option<SceneFeatures>,
    ) -> Result<Self, RenderError> {
        Self::for_layers(context, scene, features, SeenLayers::default())
    }

    /// As [`new`](Self::new), with what pictures with such layers need.
    ///
    /// # Errors
    /// What the layers below report.
    pub fn for_layers(
        context: &Context,
        scene: &Scene,
        features: Option<SceneFeatures>,
        layers: SeenLayers,
    ) -> Result<Self, RenderError> {
        let features = features.unwrap_or_else(|| SceneFeatures::of(scene));
        SceneMemory::of(scene, &features).check(context)?;
        let cut = arranged(scene);
        if cut.triangle_count() != scene.triangle_count() || cut.meshes.len() != scene.meshes.len() {
            // Copies that were not foretold.
            SceneMemory::of(&cut, &features).check(context)?;
        }
        let accel = Accel::build(&cut)?;
        let mut device_scene = DeviceScene::new(context, &cut, &accel, features)?;
        let traversal = settle(context, &mut device_scene, &cut, &accel)?;
        Ok(Self {
            context: context.clone(),
            scene: device_scene,
            hash: scene.content_hash(),
            warnings: scene.warnings.iter().map(ToString::to_string).collect(),
            has_mirrors: scene.materials.iter().any(Material::is_delta),
            triangles: accel.numbers().count(),
            dropped_triangles: accel.dropped,
            accel_seconds: accel.build_time.as_secs_f64(),
            choices: cut.repeated.iter().map(held).chain(traversal).collect(),
            surfaces: layers.any().then(|| Arc::new(Surfaces::new(&cut, &accel, layers))),
        })
    }

    /// There is something to sample as a light.
    pub fn has_lights(&self) -> bool {
        !self.scene.lights.is_empty()
    }
}

fn held(repeated: &Repeated) -> Choice {
    let Repeated { mesh, triangles, places, reason, .. } = repeated;
    Choice::new(
        "mesh",
        repeated.held(),
        format!("\"{mesh}\", {triangles} triangles in {places} places: {reason}"),
    )
}

/// A scene on a device, with the settings of a render that has not begun.
pub struct Prepared {
    context: Context,
    scene_hash: u64,
    options: RenderOptions,
    scene: DeviceScene,
    pub(super) camera: Camera,
    settings: Settings,
    warm_start: Option<WarmStart>,
    surfaces: Option<Arc<Surfaces>>,
    learning_time: LearningTime,
    pub(super) report: Report,
}

impl Prepared {
    /// Uploads the scene for one render.
    ///
    /// # Errors
    /// No such camera, a picture without pixels, or what the layers below report.
    pub fn new(context: &Context, scene: &Scene, options: RenderOptions) -> Result<Self, RenderError> {
        let camera = camera_of(scene, options.camera)?;
        check_picture(context, &options)?;
        let plan = options.method.plan();
        let mut prepared = Self::of(
            &Uploaded::for_layers(context, scene, options.features, options.seen)?,
            camera,
            options,
        )?;
        prepared.report.caveats = caveats(scene, prepared.camera.is_parallel(), &plan);
        Ok(prepared)
    }

    /// What is to be rendered, and how.
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// A render of a scene that is on the device, from `camera`, whatever the options say of cameras.
    ///
    /// # Errors
    /// A picture without pixels.
    pub fn of(
        uploaded: &Uploaded,
        camera: &scene::Camera,
        options: RenderOptions,
    ) -> Result<Self, RenderError> {
        let region = options.view.region();
        check_region(&region, options.view.width, options.view.height)?;
        let device_scene = &uploaded.scene;
        let settings = Settings {
            view: options.view,
            method: options.method,
            strategy: options.strategy,
            first_hit: options.first_hit_layers,
            transparent: options.transparent,
            through_mirrors: options.through_mirrors
                && uploaded.has_mirrors
                && !device_scene.features.lambert_only,
            timing: options.timing,
        };
        let report = Report {
            stop: Stop::Interrupted,
            samples: 0,
            seconds: 0.0,
            accel_seconds: uploaded.accel_seconds,
            upload_seconds: device_scene.upload_time.as_secs_f64(),
            environment_seconds: device_scene.environment_time.as_secs_f64(),
            compile_seconds: 0.0,
            pretracing_seconds: 0.0,
            preprocessing_seconds: 0.0,
            training: None,
            round_losses: Vec::new(),
            round_samples: Vec::new(),
            choices: uploaded.choices.iter().cloned().chain(options.preset()).collect(),
            estimated_error: None,
            denoised_error: None,
            denoised_error_unknown: None,
            rays: RayCounts::default(),
            non_finite: 0,
            triangles: uploaded.triangles,
            dropped_triangles: uploaded.dropped_triangles,
            lights: device_scene.lights.len(),
            features: device_scene.features,
            traversal: device_scene.traversal(),
            compiled: Vec::new(),
            warnings: uploaded.warnings.clone(),
            caveats: Vec::new(),
            memory: Vec::new(),
            kernels: Default::default(),
        };
        Ok(Self {
            context: uploaded.context.clone(),
            scene_hash: uploaded.hash,
            camera: Camera::new(&device_scene.unit, camera, options.view.width, options.view.height),
            scene: device_scene.clone(),
            settings,
            warm_start: None,
            surfaces: uploaded.surfaces.clone(),
            learning_time: LearningTime::default(),
            report,
            options,
        })
    }

    /// The method connects by what it has learnt, there is light to learn from, and no model is there yet: when that
    /// will be made.
    pub fn learns(&self) -> Option<When> {
        let learns = self.options.method.plan().learns()
            && self.options.model.is_none()
            && !self.scene.lights.is_empty();
        learns.then(|| self.options.training.when.unwrap_or(self.suitable().0))
    }

    /// When to learn unless the options say so, and why.
    fn suitable(&self) -> (When, &'static str) {
        if self.options.training.paths.is_some() {
            (When::First, "as published")
        } else if self.options.budget.samples.is_some() {
            (When::First, "the same seed makes the same picture")
        } else if self.context.is_cpu() {
            (When::First, "a software device has no time to spare while the host learns")
        } else {
            (When::Meanwhile, "the host learns while the device renders")
        }
    }

    /// What was done so far.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Something that was chosen for this render, as its report tells.
    pub fn with_choice(mut self, choice: Option<Choice>) -> Self {
        self.report.choices.extend(choice);
        self
    }

    /// Learns with what is known of the scene, however it was seen.
    pub fn starting_from(self, warm_start: Option<WarmStart>) -> Self {
        Self { warm_start, ..self }
    }

    /// Learns what the render then connects by; until `interrupted` says so, which is asked several times per second.
    ///
    /// # Errors
    /// A lost device, no light to learn from, [`RenderError::Interrupted`].
    pub fn learn(
        &mut self,
        interrupted: impl FnMut(TrainingProgress) -> bool,
    ) -> Result<TrainingResult, RenderError> {
        let trained = train(&self.task(), interrupted)?;
        self.learning_time =
            LearningTime { tracing: trained.tracing, total: trained.tracing + trained.learning };
        self.report.round_losses = trained.losses.clone();
        self.say_when(When::First);
        self.report.choices.extend(trained.choices.clone());
        self.options.model = Some(trained.model.clone());
        Ok(trained)
    }

    /// Makes ready to learn while rendering; until there are rounds, connections choose by power.
    fn begin_to_learn(&mut self) -> Result<PreparedTrainer, RenderError> {
        let trainer = PreparedTrainer::new(self.task())?;
        let elapsed = trainer.elapsed();
        self.learning_time = LearningTime { tracing: elapsed, total: elapsed };
        self.say_when(When::Meanwhile);
        self.options.model = Some(trainer.model().clone());
        Ok(trainer)
    }

    fn say_when(&mut self, when: When) {
        if self.options.training.when.is_none() {
            self.report.choices.push(Choice::new("learning", when, self.suitable().1));
        }
    }

    /// With what is known of the render to come.
    fn task(&self) -> TrainingTask {
        let Budget { samples, time, .. } = self.options.budget;
        let pixels = u64::from(self.settings.view.region().pixels());
        let training = Training {
            render_paths: samples.map(|samples| u64::from(samples) * pixels),
            render_time: time.map(TimeLimit::duration),
            ..self.options.training.clone()
        };
        let task = TrainingTask::new(
            &self.context,
            &self.scene,
            &self.camera,
            self.settings,
            self.scene_hash,
            &training,
        );
        task.starting_from(self.warm_start.clone())
    }

    /// Compiles all that the render needs; learns first where it has to.
    ///
    /// # Errors
    /// As [`learn`](Self::learn), and a kernel that does not compile, a buffer that does not fit.
    pub fn renderer(mut self) -> Result<Renderer, RenderError> {
        let mut trainer = None;
        match self.learns() {
            Some(When::First) => {
                self.learn(|_| false)?;
            }
            Some(When::Meanwhile) => trainer = Some(self.begin_to_learn()?),
            None => {}
        }
        let Self {
            context,
            scene_hash,
            options,
            scene,
            camera,
            settings,
            surfaces,
            learning_time,
            mut report,
            ..
        } = self;
        let (unit, radiance_scale) = (scene.unit, 2f64.powi(scene.radiance_exponent));
        let model = options.model.clone().filter(|_| options.method.plan().learns());
        report.training = model.as_ref().map(|model| model.report.clone());
        let abandoned = |error| match error {
            DeviceError::Abandoned => RenderError::InterruptedAtOnce,
            error => error.into(),
        };
        let start = Instant::now();
        let mut integrator =
            integrator(&context, scene, &camera, settings, model.as_deref()).map_err(abandoned)?;
        // Drivers may compile at the first dispatch: one sample now, thrown away, keeps that out of the clock.
        integrator.warm_up(&context).map_err(abandoned)?;
        report.choices.extend(integrator.choices());
        report.caveats.extend(integrator.caveats());
        let wavefront = integrator.wavefront_mut();
        wavefront.reset(&context)?;
        report.compile_seconds = start.elapsed().as_secs_f64();
        Ok(Renderer {
            context,
            scene_hash,
            model,
            integrator,
            sums: FilmSums::new(settings.view.region().width, settings.view.region().height),
            learning: trainer.map(PreparedTrainer::start).transpose()?,
            next_round: SAMPLES_PER_ROUND,
            first_hits: None,
            seen: surfaces.map(Seen::new),
            samples: 0,
            first: 0,
            groups: BTreeMap::new(),
            halves: HalvesInProgress::begin(&options, settings.view.region().pixels() as usize),
            rays_before: RayCounts::default(),
            elapsed: Duration::ZERO,
            longest_sample: Duration::ZERO,
            was_cut: false,
            learning_time,
            radiance_scale,
            unit,
            report,
            options,
        })
    }
}

impl Renderer {
    /// Builds everything that the scene requires, and learns where the method has to and nothing is learnt yet;
    /// [`Prepared`] does so in steps.
    ///
    /// # Errors
    /// No such camera, a picture without pixels, or what the layers below report.
    pub fn new(context: &Context, scene: &Scene, options: RenderOptions) -> Result<Self, RenderError> {
        Prepared::new(context, scene, options)?.renderer()
    }
}

pub(super) fn camera_of(scene: &Scene, wanted: usize) -> Result<&scene::Camera, RenderError> {
    scene.cameras.get(wanted).ok_or(RenderError::NoCamera { wanted, count: scene.cameras.len() })
}

/// What can be said of a picture before the scene is built.
pub(super) fn check_picture(context: &Context, options: &RenderOptions) -> Result<(), RenderError> {
    check_region(&options.view.region(), options.view.width, options.view.height)?;
    PictureMemory::of(options).check(context, options)
}

fn check_region(region: &Region, width: u32, height: u32) -> Result<(), RenderError> {
    let end = |first: u32, count: u32| {
        u64::from(first) + u64::from(count.saturating_sub(1)) * u64::from(region.stride) + 1
    };
    let inside =
        end(region.x, region.width) <= u64::from(width) && end(region.y, region.height) <= u64::from(height);
    if region.width == 0 || region.height == 0 || region.stride == 0 || !inside {
        let part = format!("{},{},{},{}", region.x, region.y, region.width, region.height);
        return Err(RenderError::BadRegion { part, width, height });
    }
    if u64::from(width) * u64::from(height) > u64::from(u32::MAX) {
        return Err(RenderError::TooManyPixels { width, height });
    }
    Ok(())
}
