//! Where the picture of a render goes, on the way and at the end: files, a viewer, errors against a reference.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::saves::Saves;
use super::trace::Trace;
use crate::bench::trade::Checkpoint;
use crate::film::denoise::Denoiser;
use crate::film::exr::Coding;
use crate::film::halves::Halves;
use crate::film::png::Depth;
use crate::film::tonemap::ViewTransform;
use crate::film::{Attribute, Exposure, FilmError, Picture, exr, png, tev};
use crate::render::{DENOISED_ERROR, Estimate, MIN_SAMPLES_FOR_ERROR, Origin, RenderError, Renderer, Report};

/// Between two pictures for a viewer.
const VIEW_EVERY: Duration = Duration::from_secs(1);

/// How pictures are written.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Of .exr files.
    pub coding: Coding,
    /// Of .png files.
    pub depth: Depth,
    pub view: ViewTransform,
    pub exposure: Exposure,
}

/// All that is to be done with a picture.
pub struct Output {
    /// .exr or .png.
    pub files: Vec<PathBuf>,
    /// How the files came to be.
    pub origin: Origin,
    pub format: Format,
    pub save_every: Option<Duration>,
    /// For the finished picture.
    pub denoiser: Option<Denoiser>,
    /// The error of the denoised picture at which the render ends.
    pub goal: Option<Goal>,
    pub viewer: Option<tev::Viewer>,
    /// In the viewer.
    pub title: String,
    pub trace: Option<Trace>,
    /// When files were written, and when the viewer got a picture; at first, the beginning.
    pub last_save: Instant,
    pub last_view: Instant,
    /// Saving on the way failed the last time.
    pub unsaved: bool,
    /// What became of it all.
    pub saves: Saves,
}

/// An error of the denoised picture that is good enough.
pub struct Goal {
    wanted: f64,
    estimate: Estimate,
}

impl Goal {
    pub fn new(wanted: f64) -> Self {
        Self { wanted, estimate: Estimate::denoised() }
    }
}

impl Output {
    /// Something is to be done with the picture of so many samples before the render goes on.
    pub fn is_due(&self, samples: u32) -> bool {
        self.save_is_due()
            || self.goal_is_due(samples)
            || (self.viewer.is_some() && self.last_view.elapsed() >= VIEW_EVERY)
            || self.trace.as_ref().is_some_and(|trace| trace.is_due(samples))
    }

    /// The denoised picture is to be looked at.
    fn goal_is_due(&self, samples: u32) -> bool {
        samples >= MIN_SAMPLES_FOR_ERROR && self.goal.as_ref().is_some_and(|goal| goal.estimate.is_due())
    }

    /// What is known of the denoised picture's error on the way.
    pub fn denoised_error(&self) -> Option<f64> {
        self.goal.as_ref()?.estimate.error
    }

    /// The denoised picture is good enough.
    pub fn has_met_goal(&self) -> bool {
        self.goal.as_ref().is_some_and(|goal| goal.estimate.error.is_some_and(|error| error <= goal.wanted))
    }

    fn save_is_due(&self) -> bool {
        self.save_every.is_some_and(|every| self.last_save.elapsed() >= every)
    }

    /// Does what is due on the way. What fails here is no reason to end: files are tried again, a viewer that has gone is
    /// reported at the end.
    ///
    /// # Errors
    /// A lost device.
    pub fn update(&mut self, renderer: &mut Renderer) -> Result<(), RenderError> {
        let picture = renderer.picture()?;
        if self.trace.as_ref().is_some_and(|trace| trace.is_due(renderer.samples())) {
            self.judge(&renderer.report()?, &picture);
        }
        self.show(&picture);
        if self.goal_is_due(renderer.samples()) {
            self.look_at_goal(&picture, renderer)?;
        }
        if self.save_is_due() {
            let picture = self.described(picture, &renderer.report()?);
            let written = self.files.iter().map(|file| self.write(file, &picture));
            let failed: Vec<FilmError> = written.filter_map(Result::err).collect();
            // Once, not every time.
            for error in failed.iter().filter(|_| !self.unsaved) {
                log::warn!("{error}; the render goes on");
            }
            self.unsaved = !failed.is_empty();
            self.last_save = Instant::now();
        }
        Ok(())
    }

    /// Estimates the error of the denoised picture. Where the library refuses, the goal is none any more: the failure is
    /// reported at the end.
    fn look_at_goal(&mut self, picture: &Picture, renderer: &Renderer) -> Result<(), RenderError> {
        let (Some(goal), Some(denoiser)) = (self.goal.as_mut(), self.denoiser.as_mut()) else {
            return Ok(());
        };
        let Ok(halves) = renderer.halves()? else { return Ok(()) };
        let (files, format) = (&self.files, &self.format);
        let renewed = goal.estimate.renew(|| {
            save_before(files, picture, format);
            denoiser.denoise_halves(picture, &halves).map(|(_, error)| error)
        });
        if let Err(error) = renewed {
            log::warn!("{error}; --error cannot be looked at");
            self.goal = None;
        }
        Ok(())
    }

    /// Does all of it with the finished picture, each output by itself; the report then has the error of the denoised one.
    /// Returns the error against the reference, where there is one.
    pub fn finish(
        &mut self,
        picture: Picture,
        halves: Result<Halves, String>,
        report: &mut Report,
    ) -> Option<Checkpoint> {
        let mut picture = self.described(picture, report);
        self.denoise(&mut picture, halves, report);
        let (mut failed, mut linear) = (false, false);
        for file in &self.files {
            let written = self.write(file, &picture);
            failed |= written.is_err();
            linear |= written.is_ok() && !is_png(file);
            self.saves.picture(file, written);
        }
        if failed && !linear {
            let path = std::env::temp_dir().join(format!("halfway-{}.exr", std::process::id()));
            match exr::create(&path, &picture) {
                Ok(()) => self.saves.rescue(&path),
                Err(error) => self.saves.fail(error),
            }
        }
        self.show(&picture);
        let judged = self.judge(report, &picture);
        if let Some((path, ended)) = self.trace.take().and_then(Trace::end) {
            self.saves.report(&path, ended);
        }
        judged
    }

    /// Denoises the picture, where that is wanted, and estimates what error is left.
    fn denoise(&mut self, picture: &mut Picture, halves: Result<Halves, String>, report: &mut Report) {
        let Some(denoiser) = self.denoiser.as_mut() else { return };
        save_before(&self.files, picture, &self.format);
        let start = Instant::now();
        match denoiser.add_to(picture, halves.as_ref().ok()) {
            Ok(error) => {
                log::info!("denoised in {:.2} s", start.elapsed().as_secs_f64());
                report.denoised_error = error;
                report.denoised_error_unknown = halves.err();
                let attribute = |error| (DENOISED_ERROR.to_owned(), Attribute::Number(error));
                picture.metadata.extend(error.map(attribute));
            }
            Err(error) => self.saves.fail(error),
        }
    }

    /// With what its file says of how it was made.
    fn described(&self, mut picture: Picture, report: &Report) -> Picture {
        picture.metadata.extend(report.metadata(&self.origin));
        picture
    }

    /// Shows the picture, until the viewer goes.
    fn show(&mut self, picture: &Picture) {
        if let Some(viewer) = &mut self.viewer {
            if let Err(error) = viewer.show(&self.title, picture) {
                log::warn!("{error}; all else goes on");
                self.saves.fail(error);
                self.viewer = None;
            }
            self.last_view = Instant::now();
        }
    }

    /// Compares the picture, until that fails.
    fn judge(&mut self, report: &Report, picture: &Picture) -> Option<Checkpoint> {
        match self.trace.as_mut()?.add(report, picture) {
            Ok(point) => Some(point),
            Err(error) => {
                log::warn!("{error}; all else goes on");
                self.saves.fail(error);
                // What there is of its file stays.
                self.trace = None;
                None
            }
        }
    }

    fn write(&self, file: &Path, picture: &Picture) -> Result<(), FilmError> {
        write(file, picture, &self.format)
    }
}

/// Saves the picture as it is before it is denoised: a library that crashes takes nothing along.
fn save_before(files: &[PathBuf], picture: &Picture, format: &Format) {
    for file in files {
        // What fails here fails once more, and is reported then.
        let _ = write(file, picture, format);
    }
}

fn write(file: &Path, picture: &Picture, format: &Format) -> Result<(), FilmError> {
    match is_png(file) {
        true => png::write_as(file, picture, format.view, format.exposure.stops(picture), format.depth),
        false => exr::write_as(file, picture, &format.coding),
    }
}

/// A portion of a render.
pub fn is_part(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "part")
}

/// Not linear, and without layers.
pub fn is_png(file: &Path) -> bool {
    file.extension().is_some_and(|extension| extension == "png")
}
