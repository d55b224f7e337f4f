//! Where the picture of a render goes, on the way and at the end: files, a viewer, errors against a reference.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::CliError;
use super::trace::Trace;
use crate::bench::trade::Checkpoint;
use crate::film::tonemap::ViewTransform;
use crate::film::{Exposure, Picture, exr, png, tev};
use crate::render::{Origin, Renderer, Report};

/// Between two pictures for a viewer.
const VIEW_EVERY: Duration = Duration::from_secs(1);

/// All that is to be done with a picture.
pub struct Output {
    /// .exr or .png.
    pub files: Vec<PathBuf>,
    /// How the files came to be.
    pub origin: Origin,
    pub view: ViewTransform,
    pub exposure: Exposure,
    pub save_every: Option<Duration>,
    pub viewer: Option<tev::Viewer>,
    /// In the viewer.
    pub title: String,
    pub trace: Option<Trace>,
    /// When files were written, and when the viewer got a picture; at first, the beginning.
    pub last_save: Instant,
    pub last_view: Instant,
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

    /// Does what is due on the way.
    ///
    /// # Errors
    /// A lost device, files that cannot be written, a viewer that has gone.
    pub fn update(&mut self, renderer: &mut Renderer) -> Result<(), CliError> {
        let picture = renderer.picture()?;
        if let Some(trace) = self.trace.as_mut().filter(|trace| trace.is_due(renderer.samples())) {
            trace.add(&renderer.report()?, &picture)?;
        }
        if let Some(viewer) = &mut self.viewer {
            viewer.show(&self.title, &picture)?;
            self.last_view = Instant::now();
        }
        if self.save_is_due() {
            self.write(picture, &renderer.report()?)?;
            self.last_save = Instant::now();
        }
        Ok(())
    }

    /// Does all of it with the finished picture. Returns the error against the reference, where there is one.
    ///
    /// # Errors
    /// As [`Output::update`].
    pub fn finish(&mut self, picture: Picture, report: &Report) -> Result<Option<Checkpoint>, CliError> {
        if let Some(viewer) = &mut self.viewer {
            viewer.show(&self.title, &picture)?;
        }
        let judged = self.trace.as_mut().map(|trace| trace.add(report, &picture)).transpose();
        self.write(picture, report)?;
        // A disk too full for the errors is reported after the picture is safe.
        judged
    }

    fn write(&self, mut picture: Picture, report: &Report) -> Result<(), CliError> {
        picture.metadata = report.metadata(&self.origin);
        for file in &self.files {
            if file.extension().is_some_and(|extension| extension == "png") {
                png::write(file, &picture, self.view, self.exposure.stops(&picture))
            } else {
                exr::write(file, &picture)
            }?;
        }
        Ok(())
    }
}
