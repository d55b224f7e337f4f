//! What comes before the first sample: the scene goes to the device, and the method learns.

use std::time::{Duration, Instant};

use super::meanwhile::SAMPLES_A_LESSON;
use super::{Budget, FIRST_HIT_SAMPLES, RenderOptions, Renderer, Report, Stop};
use crate::accel::Accel;
use crate::device::Context;
use crate::device::layout::Camera;
use crate::device::scene::DeviceScene;
use crate::error::{DeviceError, RenderError};
use crate::film::sums::FilmSums;
use crate::integrator::{
    Beginning, Choice, Learning, Lesson, Method, RayCounts, Region, Settings, Trained, Training, When,
    integrator, train,
};
use crate::scene::{Scene, SceneFeatures};

/// A scene on a device, with the settings of a render that has not begun.
pub struct Prepared<'a> {
    context: &'a Context,
    scene_hash: u64,
    options: RenderOptions,
    scene: DeviceScene,
    camera: Camera,
    settings: Settings,
    length_scale: f64,
    report: Report,
}

impl<'a> Prepared<'a> {
    /// Builds the acceleration structure and uploads the scene.
    ///
    /// # Errors
    /// No such camera, a picture without pixels, or what the layers below report.
    pub fn new(context: &'a Context, scene: &Scene, options: RenderOptions) -> Result<Self, RenderError> {
        let camera = scene
            .cameras
            .get(options.camera)
            .ok_or(RenderError::NoCamera { wanted: options.camera, count: scene.cameras.len() })?;
        let region =
            options.crop.unwrap_or(Region { x: 0, y: 0, width: options.width, height: options.height });
        check_region(&region, options.width, options.height)?;
        let accel = Accel::build(scene)?;
        let features = options.features.unwrap_or_else(|| SceneFeatures::of(scene));
        let device_scene = DeviceScene::new(context, scene, &accel, features)?;
        let settings = Settings {
            width: options.width,
            height: options.height,
            region,
            max_depth: options.max_depth,
            seed: options.seed,
            method: options.method,
            strategy: options.strategy,
            first_hit: options.first_hit_layers,
            timing: options.timing,
        };
        let report = Report {
            stop: Stop::Interrupted,
            samples: 0,
            seconds: 0.0,
            accel_seconds: accel.build_time.as_secs_f64(),
            upload_seconds: device_scene.upload_time.as_secs_f64(),
            compile_seconds: 0.0,
            pretracing_seconds: 0.0,
            preprocessing_seconds: 0.0,
            training: None,
            lesson_losses: Vec::new(),
            lesson_samples: Vec::new(),
            choices: Vec::new(),
            estimated_error: None,
            rays: RayCounts::default(),
            non_finite: 0,
            triangles: accel.triangles.len(),
            dropped_triangles: accel.dropped,
            lights: device_scene.light_count,
            features: device_scene.features,
            memory: Vec::new(),
            kernels: Default::default(),
        };
        Ok(Self {
            context,
            scene_hash: scene.content_hash(),
            camera: device_scene.camera(camera, options.width, options.height),
            scene: device_scene,
            settings,
            length_scale: accel.unit.world_length(1.0),
            report,
            options,
        })
    }

    /// The method connects by what it has learnt, there is light to learn from, and no model is there yet: when that
    /// will be made.
    pub fn learns(&self) -> Option<When> {
        let learns = matches!(self.options.method, Method::SpcBpt { .. })
            && self.options.model.is_none()
            && self.scene.light_count > 0;
        learns.then(|| self.options.training.when.unwrap_or(self.suitable().0))
    }

    /// When to learn where nobody says it, and why.
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

    /// Learns what the render then connects by; until `interrupted` says so, which is asked several times a second.
    ///
    /// # Errors
    /// A lost device, no light to learn from, [`RenderError::Interrupted`].
    pub fn learn(&mut self, interrupted: impl FnMut(Learning) -> bool) -> Result<Trained, RenderError> {
        let trained = train(&self.lesson()?, interrupted)?;
        self.report.pretracing_seconds = trained.tracing.as_secs_f64();
        self.report.preprocessing_seconds = (trained.tracing + trained.learning).as_secs_f64();
        self.report.lesson_losses = trained.losses.clone();
        self.say_when(When::First);
        self.report.choices.extend(trained.choices.clone());
        self.options.model = Some(trained.model.clone());
        Ok(trained)
    }

    /// Makes ready to learn while rendering; until there are lessons, connections choose by power.
    fn begin_to_learn(&mut self) -> Result<Beginning, RenderError> {
        let beginning = Beginning::new(self.lesson()?)?;
        self.report.pretracing_seconds = beginning.elapsed().as_secs_f64();
        self.report.preprocessing_seconds = self.report.pretracing_seconds;
        self.say_when(When::Meanwhile);
        self.options.model = Some(beginning.model().clone());
        Ok(beginning)
    }

    fn say_when(&mut self, when: When) {
        if self.options.training.when.is_none() {
            self.report.choices.push(Choice::new("learning", when, self.suitable().1));
        }
    }

    /// With what is known of the render to come.
    fn lesson(&self) -> Result<Lesson, DeviceError> {
        let Budget { samples, time, .. } = self.options.budget;
        let pixels = u64::from(self.settings.region.pixels());
        let training = Training {
            render_paths: samples.map(|samples| u64::from(samples) * pixels),
            render_time: time,
            ..self.options.training.clone()
        };
        Lesson::new(self.context, &self.scene, &self.camera, self.settings, self.scene_hash, &training)
    }

    /// Compiles all that the render needs; learns first where it has to.
    ///
    /// # Errors
    /// As [`learn`](Self::learn), and a kernel that does not compile, a buffer that does not fit.
    pub fn renderer(mut self) -> Result<Renderer<'a>, RenderError> {
        let mut course = None;
        match self.learns() {
            Some(When::First) => {
                self.learn(|_| false)?;
            }
            Some(When::Meanwhile) => course = Some(self.begin_to_learn()?),
            None => {}
        }
        let Self { context, options, scene, camera, settings, length_scale, mut report, .. } = self;
        let radiance_scale = 2f64.powi(scene.radiance_exponent);
        let model = options.model.clone().filter(|_| matches!(options.method, Method::SpcBpt { .. }));
        report.training = model.as_ref().map(|model| model.report.clone());
        let mut integrator = integrator(context, scene, &camera, settings, model.as_deref())?;
        // The driver compiles at the first dispatch: one sample now, thrown away, keeps that out of the clock.
        let warm_up = Instant::now();
        integrator.warm_up(context)?;
        report.choices.extend(integrator.choices());
        let wavefront = integrator.wavefront_mut();
        let first_hits = match options.first_hit_layers {
            true => wavefront.first_hits(context, FIRST_HIT_SAMPLES)?,
            false => Vec::new(),
        };
        wavefront.reset(context)?;
        report.compile_seconds = (wavefront.compile_time + warm_up.elapsed()).as_secs_f64();
        Ok(Renderer {
            context,
            model,
            integrator,
            sums: FilmSums::new(settings.region.width, settings.region.height),
            learning: course.map(Beginning::start).transpose()?,
            next_lesson: SAMPLES_A_LESSON,
            first_hits,
            samples: 0,
            elapsed: Duration::ZERO,
            radiance_scale,
            length_scale,
            report,
            options,
        })
    }
}

fn check_region(region: &Region, width: u32, height: u32) -> Result<(), RenderError> {
    let inside = u64::from(region.x) + u64::from(region.width) <= u64::from(width)
        && u64::from(region.y) + u64::from(region.height) <= u64::from(height);
    if region.width == 0 || region.height == 0 || !inside {
        let part = format!("{},{},{},{}", region.x, region.y, region.width, region.height);
        return Err(RenderError::BadRegion { part, width, height });
    }
    if u64::from(width) * u64::from(height) > u64::from(u32::MAX) {
        return Err(RenderError::TooManyPixels { width, height });
    }
    Ok(())
}
