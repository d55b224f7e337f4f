//! What the worker gives away: snapshots for the window, and files.

use std::sync::Arc;
use std::time::Instant;

use crate::device::DeviceError;
use crate::film::Picture;
use crate::preview::film::Film;
use crate::preview::saving;
use crate::preview::snapshot::{Snapshot, figures, memory};
use crate::render::RenderError;

use super::State;
use super::messages::{Event, Saved};

impl State {
    /// Does the saves that were asked for, as soon as the picture is whole.
    pub(super) fn save(&mut self) -> Result<(), RenderError> {
        if self.saves.is_empty() {
            return Ok(());
        }
        let Some(film) = &mut self.films[self.shown] else { return Ok(()) };
        if !film.is_whole(self.request.view) || film.renderer.samples() == 0 {
            return Ok(());
        }
        self.working = self.shown;
        let (slot, view, samples) = (self.shown, self.request.view, film.renderer.samples());
        for save in std::mem::take(&mut self.saves) {
            let (method, flags) = (self.settings.methods[slot], &self.request.camera_flags);
            let denoise = |picture: &mut Picture| self.denoising.add_to(picture);
            let denoise = self.request.denoised.then_some(denoise);
            let event = match saving::save(&self.settings, &mut film.renderer, method, flags, &save, denoise)
            {
                Ok(paths) => Event::Saved(Saved { paths, slot, view, samples }),
                Err(error @ RenderError::Device(DeviceError::Lost { .. })) => return Err(error),
                Err(error) => Event::Failed(format!("not all files were saved: {error}")),
            };
            let _ = self.events.send(event);
        }
        (self.notify)();
        Ok(())
    }

    /// The camera moves on before a save was done: saves the last snapshot.
    pub(super) fn save_last_seen(&mut self) {
        for save in std::mem::take(&mut self.saves) {
            let snapshot = self.shared.latest();
            let whole = snapshot.picture.width == self.settings.options.view.width
                && snapshot.view == self.request.view;
            let event = if whole && snapshot.figures.samples > 0 {
                match saving::save_snapshot(&self.settings, &snapshot, &save) {
                    Ok(paths) => Event::Saved(Saved {
                        paths,
                        slot: snapshot.slot,
                        view: snapshot.view,
                        samples: snapshot.figures.samples,
                    }),
                    Err(error) => Event::Failed(error.to_string()),
                }
            } else {
                let message = "nothing was saved: the camera moved on before there was a picture; save again \
                               once it stands still";
                Event::Failed(message.into())
            };
            self.send(event);
        }
    }

    /// Publishes a snapshot, if one is due.
    pub(super) fn publish(&mut self) -> Result<(), RenderError> {
        if !self.snapshot_is_due() {
            return Ok(());
        }
        let start = Instant::now();
        let snapshot = self.make_snapshot()?;
        if let Ok(mut latest) = self.shared.latest.lock() {
            *latest = Arc::new(snapshot);
        }
        self.snapshots += 1;
        self.last_snapshot = Some((Instant::now(), start.elapsed()));
        self.unpublished = false;
        (self.notify)();
        Ok(())
    }

    /// The denoised picture of what is seen, where it is requested: `last`, or a new one where that is due.
    fn denoised(&mut self, last: Option<Arc<Picture>>) -> Result<Option<Arc<Picture>>, RenderError> {
        let (slot, view, is_last) = (self.shown, self.request.view, self.next_film().is_none());
        let is_there =
            |film: &&mut Film| film.view() == Some(view) && film.divisor == 1 && film.renderer.samples() > 0;
        let Some(film) = self.films[slot].as_mut().filter(|film| self.request.denoised && is_there(film))
        else {
            return Ok(None);
        };
        let of = (slot, view, film.renderer.samples());
        if !self.denoising.is_due(of, is_last) {
            return Ok(last.filter(|_| self.denoising.shows(slot, view)));
        }
        match self.denoising.make(of, film.renderer.picture()?) {
            Ok(picture) => Ok(Some(picture)),
            Err(error) => {
                self.send(Event::Failed(error.to_string()));
                Ok(None)
            }
        }
    }

    /// The last snapshot, with what there is of the requested view in place of what it had.
    fn make_snapshot(&mut self) -> Result<Snapshot, RenderError> {
        let mut snapshot = Snapshot { number: self.snapshots + 1, ..(*self.shared.latest()).clone() };
        snapshot.denoised = self.denoised(snapshot.denoised.take())?;
        let is_there = |film: &Film| film.view() == Some(self.request.view) && film.renderer.samples() > 0;
        if let Some(film) = self.films[self.shown].as_mut().filter(|film| is_there(film)) {
            self.working = self.shown;
            snapshot.slot = self.shown;
            snapshot.view = self.request.view;
            snapshot.camera_flags.clone_from(&self.request.camera_flags);
            let (picture, report) = film.renderer.glance()?;
            snapshot.picture = Arc::new(picture);
            snapshot.figures = figures(film, report, self.request.view);
            snapshot.subspaces = match self.request.subspaces && film.divisor == 1 {
                true => film.renderer.first_subspaces()?.map(Arc::new),
                false => None,
            };
            snapshot.non_finite = match self.request.non_finite {
                true => Some(Arc::new(film.renderer.non_finite()?)),
                false => None,
            };
        }
        snapshot.beside = match self.request.beside.and_then(|slot| Some((slot, self.films[slot].as_ref()?)))
        {
            Some((slot, film)) if is_there(film) && film.divisor == 1 => {
                self.working = slot;
                Some((slot, Arc::new(film.renderer.radiance()?)))
            }
            _ => None,
        };
        snapshot.figures.activity = self.activity.clone();
        snapshot.figures.done = self.next_film().is_none() && self.builder.is_none() && !self.request.paused;
        snapshot.figures.memory = memory(self.films.iter().flatten());
        Ok(snapshot)
    }
}
