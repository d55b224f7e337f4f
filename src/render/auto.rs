//! `--integrator auto`: the integrator that will have the least error at the end of this budget.
//!
//! A pilot of a few thousand pixels renders by path tracing, whose kernels compile soonest, and tells how noisy this view is
//! and how fast the device. What SPCBPT would make of the rest is predicted from that: it has first to learn, which takes
//! about as many paths in every scene, and the noise that is left afterwards follows that of path tracing
//! (docs/measurements.md, The integrator by itself). A pilot of its own would have to compile and to learn, which takes longer
//! than a twentieth of most budgets.
//!
//! Where the budget is a number of samples no clock is asked, so that the same seed chooses alike; it then counts as the time
//! that path tracing takes for these samples.

use std::time::{Duration, Instant};

use super::caveats::caveats;
use super::glossy::glossy;
use super::prepared::{camera_of, check_picture};
use super::{Budget, Prepared, RenderError, RenderOptions, SeenLayers, TimeLimit, Uploaded};
use crate::device::Context;
use crate::device::layout::SAMPLES_A_GROUP;
use crate::film::Region;
use crate::integrator::method::{Given, PATH, SPCBPT};
use crate::integrator::{Choice, Method, View};
use crate::scene::{Camera, Scene, SceneFeatures};

/// What was chosen, and what it took.
#[derive(Clone, Debug)]
pub struct Automatic {
    pub method: Method,
    /// What it is and why.
    pub choices: Vec<Choice>,
    /// Of a budget of time this is spent.
    pub pilot: Duration,
}

/// Shorter renders are over before learning would be worth its time, whatever the scene: camera paths, and seconds.
const SHORT_PATHS: u64 = 1 << 21;
const SHORT_TIME: Duration = Duration::from_secs(1);
const TOO_SHORT: &str = "so short a render would be over before learning pays";
/// Pixels of the pilot, at most and at least, and its samples: 2^16 paths; two groups of samples know their variance.
const PILOT_PIXELS: [u32; 2] = [1 << 12, 1 << 8];
const PILOT_SAMPLES: u32 = 16;
/// Share of a budget of time that the pilot may take.
const PILOT_SHARE: f64 = 0.05;
/// Camera paths a second of a slow device, to which the pilot of a short render is cut.
const SLOW_PATHS_PER_SECOND: f64 = 40.0e3;
/// Learning takes about as long as this many camera paths of path tracing, and what the host does meanwhile: what all of it
/// takes that pays, and the least of it.
const LEARNING_PATHS: [f64; 2] = [1.0e6, 0.35e6];
const LEARNING_SECONDS: [f64; 2] = [0.3, 0.2];
/// The same where no clock is asked.
const LEARNING_PATHS_WITHOUT_CLOCK: [f64; 2] = [1.4e6, 0.45e6];
/// A share of the render beyond which learning does not go, unless that is the least of it.
const LEARNING_SHARE: f64 = 1.0 / 3.0;
/// The error of SPCBPT over that of path tracing up to which it is chosen. Where both are expected to be alike, it was at
/// most a little behind, and sometimes far ahead. Of so many samples it has as many, but takes longer for them: there it is to
/// be ahead.
const CHOSEN_UP_TO: f64 = 1.1;
const CHOSEN_UP_TO_WITHOUT_CLOCK: f64 = 0.97;
/// A denoised picture has about this times the root of the error of the picture: .09 to .28 in docs/denoised.md.
const DENOISED_OF_ROOT: f64 = 0.16;
/// A picture of so small an error needs nothing better.
const CLEAN: f64 = 0.002;

impl Automatic {
    /// Chooses for a render of `scene`, which is on the device, seen by `camera`, of which the options say all else. The pilot
    /// does not take part in the picture: that is bit for bit the one of the integrator that was chosen.
    ///
    /// # Errors
    /// As [`Prepared::renderer`].
    pub fn choose(
        uploaded: &Uploaded,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Self, RenderError> {
        let none = Duration::ZERO;
        if !SceneFeatures::of(scene).lights() {
            return Ok(Self::path("there is no light to learn from", none));
        }
        let Budget { samples, time, .. } = options.budget;
        let pixels = f64::from(options.view.region().pixels());
        let time = time.map(|limit| limit.duration());
        let is_short = samples.is_some_and(|samples| f64::from(samples) * pixels < SHORT_PATHS as f64)
            || time.is_some_and(|time| time < SHORT_TIME);
        if is_short {
            return Ok(Self::path(TOO_SHORT, none));
        }
        let pilot = Pilot::within(uploaded, camera, options, time)?;
        if !pilot.is_whole {
            // A device that has no time for the pilot has none for learning.
            return Ok(Self::path(TOO_SHORT, pilot.time));
        }
        let Some(sample_error) = pilot.sample_error else {
            return Ok(Self::spcbpt(scene, "a pilot of path tracing found no light", pilot.time));
        };
        // Camera paths that path tracing would have in the end.
        let limits = [
            samples.map(|samples| f64::from(samples) * pixels),
            time.map(|time| pilot.paths_per_second * time.saturating_sub(pilot.time).as_secs_f64()),
            options
                .budget
                .error
                .map(|error| (sample_error / raw_goal(error, options.halves)).powi(2) * pixels),
        ];
        let paths = limits.into_iter().flatten().reduce(f64::min).unwrap_or(f64::INFINITY);
        let [most, least] = match time {
            Some(_) => [0, 1].map(|i| LEARNING_PATHS[i] + LEARNING_SECONDS[i] * pilot.paths_per_second),
            None => LEARNING_PATHS_WITHOUT_CLOCK,
        };
        let learning = most.min(least.max(LEARNING_SHARE * paths));
        let by_path = sample_error / (paths / pixels).sqrt();
        let left = 1.0 - learning / paths;
        let by_spcbpt = if left > 0.0 { gain(sample_error) * by_path / left.sqrt() } else { f64::INFINITY };
        let percent = |error: f64| match error.is_finite() {
            true => format!("{:.1} %", 100.0 * error),
            false => "no picture".into(),
        };
        let most = if time.is_some() { CHOSEN_UP_TO } else { CHOSEN_UP_TO_WITHOUT_CLOCK };
        let learns = by_path >= CLEAN && by_spcbpt <= most * by_path;
        let alike = match learns && by_spcbpt > by_path {
            true => "; where these are alike spcbpt was hardly ever behind",
            false => "",
        };
        let reason = format!(
            "a pilot expects an error of {} by path and {} by spcbpt, which learns first{alike}",
            percent(by_path),
            percent(by_spcbpt)
        );
        Ok(match learns {
            true => Self::spcbpt(scene, reason, pilot.time),
            false => Self::path(reason, pilot.time),
        })
    }

    /// For a picture that is looked at for as long as one likes.
    pub fn without_end(scene: &Scene) -> Self {
        match SceneFeatures::of(scene).lights() {
            true => Self::spcbpt(scene, "it has the least error in the long run", Duration::ZERO),
            false => Self::path("there is no light to learn from", Duration::ZERO),
        }
    }

    /// SPCBPT, as there is a model of the scene.
    pub fn by_model(scene: &Scene) -> Self {
        Self::spcbpt(scene, "there is a model of the scene", Duration::ZERO)
    }

    fn path(reason: impl Into<String>, pilot: Duration) -> Self {
        let method = (PATH.make)(&Given::default());
        Self { method, choices: vec![Choice::new("integrator", PATH.name, reason)], pilot }
    }

    fn spcbpt(scene: &Scene, reason: impl Into<String>, pilot: Duration) -> Self {
        let mut choices = vec![Choice::new("integrator", SPCBPT.name, reason)];
        let (method, light_tracing) = for_surfaces(scene, SPCBPT.default_method());
        choices.extend(light_tracing);
        Self { method, choices, pilot }
    }
}

/// The method, with light tracing where it can have it and glossy surfaces bring light to others.
pub fn for_surfaces(scene: &Scene, method: Method) -> (Method, Option<Choice>) {
    match method.with_light_tracing().and_then(|with| Some((with, glossy(scene)?))) {
        Some((with, names)) => {
            let reason = format!("glossy surfaces ({names}) bring light to others");
            (with, Some(Choice::new("light tracing", "on", reason)))
        }
        None => (method, None),
    }
}

impl Prepared {
    /// As [`new`](Self::new), by the method that [`Automatic`] chooses, or one that takes the options' model: all else is as the
    /// options say, but that the pilot is taken off a budget of time.
    ///
    /// # Errors
    /// As [`new`](Self::new), and those of the pilot.
    pub fn automatic(
        context: &Context,
        scene: &Scene,
        mut options: RenderOptions,
    ) -> Result<Self, RenderError> {
        let camera = camera_of(scene, options.camera)?;
        check_picture(context, &options)?;
        let uploaded = Uploaded::for_layers(context, scene, options.features, options.seen)?;
        let chosen = match options.model {
            Some(_) => Automatic::by_model(scene),
            None => Automatic::choose(&uploaded, scene, camera, &options)?,
        };
        options.method = chosen.method;
        options.budget.time = options.budget.time.map(|time| time.without(chosen.pilot));
        let mut prepared = Self::of(&uploaded, camera, options)?;
        prepared.report.caveats = caveats(scene, prepared.camera.is_parallel(), &chosen.method.plan());
        prepared.report.choices.extend(chosen.choices);
        Ok(prepared)
    }
}

/// The error of SPCBPT over that of path tracing in the same time, without learning: the noisier path tracing is, the more
/// there is to gain. `sample_error`: of a single sample per pixel.
fn gain(sample_error: f64) -> f64 {
    (1.4 * sample_error.powf(-0.6)).min(0.8)
}

/// The error that a picture has which is met for an error of `goal`; `denoised`: what is to have that is the denoised one.
fn raw_goal(goal: f64, denoised: bool) -> f64 {
    if denoised { goal.max((goal / DENOISED_OF_ROOT).powi(2)) } else { goal }
}

/// What a few pixels tell of path tracing.
struct Pilot {
    /// Estimated error of one sample per pixel; `None` where no light was found.
    sample_error: Option<f64>,
    /// It has the samples that an estimate takes.
    is_whole: bool,
    paths_per_second: f64,
    time: Duration,
}

impl Pilot {
    /// Of as many pixels as there is time for: first of as many as a slow device is through with, then, where that leaves
    /// most of the time, of more. Few of them keep a fast device so little busy that it seems slow.
    fn within(
        uploaded: &Uploaded,
        camera: &Camera,
        options: &RenderOptions,
        time: Option<Duration>,
    ) -> Result<Self, RenderError> {
        let [most, least] = PILOT_PIXELS;
        let Some(time) = time.map(|time| time.mul_f64(PILOT_SHARE)) else {
            return Self::render(uploaded, camera, options, most, None);
        };
        let slow = SLOW_PATHS_PER_SECOND * time.as_secs_f64() / f64::from(PILOT_SAMPLES);
        let pixels = (slow as u32).clamp(least, most);
        let first = Self::render(uploaded, camera, options, pixels, Some(time))?;
        let left = time.saturating_sub(first.time);
        let more = (f64::from(pixels) * 0.5 * left.as_secs_f64() / first.time.as_secs_f64()) as u32;
        if pixels == most || more < 2 * pixels {
            return Ok(first);
        }
        let second = Self::render(uploaded, camera, options, more.min(most), Some(left))?;
        let taken = first.time + second.time;
        Ok(Self { time: taken, ..if second.is_whole { second } else { first } })
    }

    fn render(
        uploaded: &Uploaded,
        camera: &Camera,
        options: &RenderOptions,
        pixels: u32,
        time: Option<Duration>,
    ) -> Result<Self, RenderError> {
        let options = RenderOptions {
            view: View { crop: Some(few_pixels(options.view.region(), pixels)), ..options.view },
            method: (PATH.make)(&Given::default()),
            budget: Budget {
                samples: Some(PILOT_SAMPLES),
                time: time.map(TimeLimit::Rendering),
                error: None,
            },
            first_hit_layers: false,
            seen: SeenLayers::default(),
            timing: false,
            model: None,
            ..options.clone()
        };
        let mut renderer = Prepared::of(uploaded, camera, options)?.renderer()?;
        let start = Instant::now();
        match renderer.run(|_| false) {
            Err(RenderError::NoSampleInTime) => {}
            ended => drop(ended?),
        }
        let samples = f64::from(renderer.samples());
        let report = renderer.report()?;
        Ok(Self {
            is_whole: renderer.samples() > SAMPLES_A_GROUP,
            sample_error: report.estimated_error.map(|error| error * samples.sqrt()),
            paths_per_second: report.rays.paths as f64 / report.seconds,
            time: start.elapsed(),
        })
    }
}

/// A lattice of about so many pixels of a region.
fn few_pixels(region: Region, pixels: u32) -> Region {
    let step = (f64::from(region.pixels()) / f64::from(pixels)).sqrt().ceil().max(1.0) as u32;
    let lattice = Region::lattice(region.width, region.height, step);
    Region {
        x: region.x + lattice.x * region.stride,
        y: region.y + lattice.y * region.stride,
        stride: lattice.stride * region.stride,
        ..lattice
    }
}
