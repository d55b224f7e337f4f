//! The denoised picture of the window, made anew at intervals that cost at most a fifth of the time.

use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::film::denoise::Denoiser;
use crate::film::{FilmError, Picture};

/// Time between two denoised pictures, over the time that one takes.
const INTERVAL: u32 = 4;

/// See the module.
#[derive(Default)]
pub(super) struct Denoising {
    denoiser: Option<Denoiser>,
    /// It has failed, and is not tried again before it is asked for anew.
    failed: bool,
    /// When it was made last, and how long that took.
    last: Option<(Instant, Duration)>,
    /// What it was made of: slot, view and samples.
    of: Option<(usize, u64, u32)>,
}

impl Denoising {
    /// Another picture of `of` is to be made; `is_last`: no other samples come soon.
    pub fn is_due(&self, of: (usize, u64, u32), is_last: bool) -> bool {
        let rested = self.last.is_none_or(|(end, took)| end.elapsed() >= INTERVAL * took);
        !self.failed && self.of != Some(of) && (rested || is_last)
    }

    /// What was made last shows this view by this slot.
    pub fn shows(&self, slot: usize, view: u64) -> bool {
        self.of.is_some_and(|(its_slot, its_view, _)| (its_slot, its_view) == (slot, view))
    }

    /// Adds the denoised layer to a picture, as [`Denoiser::add_to`].
    ///
    /// # Errors
    /// The library is missing, or refuses.
    pub fn add_to(&mut self, picture: &mut Picture) -> Result<(), FilmError> {
        if self.denoiser.is_none() {
            self.denoiser = Some(Denoiser::open()?);
        }
        self.denoiser.as_mut().map_or(Ok(()), |denoiser| denoiser.add_to(picture, None).map(drop))
    }

    /// The picture with nothing but its denoised colours.
    ///
    /// # Errors
    /// As [`add_to`](Self::add_to), once: it is not due after that.
    pub fn make(&mut self, of: (usize, u64, u32), mut picture: Picture) -> Result<Arc<Picture>, FilmError> {
        let start = Instant::now();
        let made = self.add_to(&mut picture);
        self.failed = made.is_err();
        self.last = Some((Instant::now(), start.elapsed()));
        made?;
        self.of = Some(of);
        Ok(Arc::new(Picture::new(picture.width, picture.height, picture.shown().into_owned())))
    }

    /// It may have been installed meanwhile.
    pub fn try_again(&mut self) {
        self.failed = false;
    }
}
