//! What the worker lets out: files and snapshots.

use std::sync::Arc;
use std::time::Instant;

use crate::device::DeviceError;
use crate::preview::film::Film;
use crate::preview::saving;
use crate::preview::snapshot::{Snapshot, figures, memory};
use crate::render::RenderError;

use super::{Event, SNAPSHOTS_APART, Saved, Work};

impl Work {
    /// Saves what was asked for, as soon as the picture is whole.
    pub(super) fn save(&mut self) -> Result<(), RenderError> {
        if self.saves.is_empty() {
            return Ok(());
        }
        let Some(film) = &mut self.films[self.shown] else { return Ok(()) };
        if !film.is_whole(self.wish.view) || film.renderer.samples() == 0 {
            return Ok(());
        }
        self.working = self.shown;
        for save in std::mem::take(&mut self.saves) {
            let (method, flags) = (self.settings.methods[self.shown], &self.wish.camera_flags);
            match saving::save(&self.settings, &mut film.renderer, method, flags, &save) {
                Ok(paths) => {
                    let samples = film.renderer.samples();
                    let saved = Saved { paths, slot: self.shown, view: self.wish.view, samples };
                    let _ = self.events.send(Event::Saved(saved));
                }
                Err(error @ RenderError::Device(DeviceError::Lost { .. })) => return Err(error),
                Err(error) => {
                    let _ = self.events.send(Event::Failed(format!("not all is saved: {error}")));
                }
            }
        }
        (self.notify)();
        Ok(())
    }

    /// The camera moves on, and something was still to be saved: what was seen last is.
    pub(super) fn save_what_was_seen(&mut self) {
        for save in std::mem::take(&mut self.saves) {
            let snapshot = self.latest.lock().map(|latest| latest.clone()).unwrap_or_default();
            let whole =
                snapshot.picture.width == self.settings.options.view.width && snapshot.view == self.wish.view;
            if !whole || snapshot.figures.samples == 0 {
                self.tell(Event::Failed(
                    "nothing was saved: the camera moved on before there was a picture".into(),
                ));
                continue;
            }
            let saved = saving::rescue(&self.settings, &snapshot, &save);
            self.tell(match saved {
                Ok(paths) => Event::Saved(Saved {
                    paths,
                    slot: snapshot.slot,
                    view: snapshot.view,
                    samples: snapshot.figures.samples,
                }),
                Err(error) => Event::Failed(error.to_string()),
            });
        }
    }

    /// Tells how things stand, but for a part of the time only.
    pub(super) fn publish(&mut self) -> Result<(), RenderError> {
        let due = self.last_snapshot.is_none_or(|(end, took)| end.elapsed() >= SNAPSHOTS_APART * took);
        let idle = self.next_film().is_none();
        if !self.news || !(due || idle) {
            return Ok(());
        }
        let start = Instant::now();
        let mut snapshot = Snapshot {
            number: self.snapshots + 1,
            ..self.latest.lock().map(|latest| (**latest).clone()).unwrap_or_default()
        };
        let is_there = |film: &Film| film.view() == Some(self.wish.view) && film.renderer.samples() > 0;
        if let Some(film) = self.films[self.shown].as_mut().filter(|film| is_there(film)) {
            self.working = self.shown;
            snapshot.slot = self.shown;
            snapshot.view = self.wish.view;
            snapshot.camera_flags.clone_from(&self.wish.camera_flags);
            let (picture, report) = film.renderer.glance()?;
            snapshot.picture = Arc::new(picture);
            snapshot.figures = figures(film, report, self.wish.view);
            snapshot.subspaces = match self.wish.subspaces && film.divisor == 1 {
                true => film.renderer.first_subspaces()?.map(Arc::new),
                false => None,
            };
            snapshot.non_finite = match self.wish.non_finite {
                true => Some(Arc::new(film.renderer.non_finite()?)),
                false => None,
            };
        }
        snapshot.beside = match self.wish.beside.and_then(|slot| Some((slot, self.films[slot].as_ref()?))) {
            Some((slot, film)) if is_there(film) && film.divisor == 1 => {
                self.working = slot;
                Some((slot, Arc::new(film.renderer.radiance()?)))
            }
            _ => None,
        };
        snapshot.figures.making = self.making.clone();
        snapshot.figures.done = idle && self.builder.is_none() && !self.wish.paused;
        snapshot.figures.memory = memory(self.films.iter().flatten());
        self.snapshots += 1;
        if let Ok(mut latest) = self.latest.lock() {
            *latest = Arc::new(snapshot);
        }
        self.last_snapshot = Some((Instant::now(), start.elapsed()));
        self.news = false;
        (self.notify)();
        Ok(())
    }
}
