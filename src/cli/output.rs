//! Where the picture of a render goes, on the way and at the end: files, a viewer, errors against a reference.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::saves::Saves;
use super::trace::Trace;
use crate::bench::trade::Checkpoint;
use crate::film::denoise::Denoiser;
use crate::film::exr::Coding;
use crate::film::png::Depth;
use crate::film::tonemap::ViewTransform;
use crate::film::{Exposure, FilmError, Picture, exr, png, tev};
use crate::render::{Origin, RenderError, Renderer, Report};

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

impl Output {
    /// Something is to be done with the picture of so many samples before the render goes on.
    pub fn is_due(&self, samples: u32) -> bool {
        self.save_is_due()
            || (self.viewer.is_some() && self.last_view.elapsed() >= VIEW_EVERY)
            || self.trace.as_ref().is_some_and(|trace| trace.is_due(samples))
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

    /// Does all of it with the finished picture, each output by itself. Returns the error against the reference, where
    /// there is one.
    pub fn finish(&mut self, picture: Picture, report: &Report) -> Option<Checkpoint> {
        let mut picture = self.described(picture, report);
        self.denoise(&mut picture);
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

    /// Denoises the picture, where that is wanted. It is saved as it is before: a library that crashes takes nothing along.
    fn denoise(&mut self, picture: &mut Picture) {
        let Some(denoiser) = self.denoiser.as_mut() else { return };
        for file in &self.files {
            // What fails here fails once more, and is reported then.
            let _ = write(file, picture, &self.format);
        }
        let start = Instant::now();
        match denoiser.add_to(picture) {
            Ok(()) => log::info!("denoised in {:.2} s", start.elapsed().as_secs_f64()),
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
