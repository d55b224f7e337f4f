//! What there is of every pixel: in one buffer each, or in pages where a binding cannot hold it for the whole picture. A
//! batch lies in one page.

use std::ops::Range;

use super::Wavefront;
use crate::device::layout::{FilmPixel, FirstHitPixel, Page};
use crate::device::{Bound, BufferTable, Context, DeviceError, Feature};
use crate::film::sums::BLOCK;

/// Words of a pixel: `shaders/bind/splats.wgsl`.
pub(crate) const SPLAT_WORDS: usize = 7;
/// Buffers with an entry for each pixel.
pub(super) const FILM: &str = "film";
pub(super) const SPLATS: &str = "splats";
pub(super) const FIRST_HITS: &str = "first_hits";

/// How the pixels of a picture are spread over buffers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmPages {
    pixels: u32,
    /// A multiple of [`BLOCK`] where there are several pages.
    a_page: u32,
}

impl FilmPages {
    /// Makes the film for so many pixels, with what light paths bring to it and what the camera sees first where these are
    /// wanted.
    ///
    /// # Errors
    /// Less memory than that.
    pub fn create(
        context: &Context,
        buffers: &mut BufferTable,
        pixels: u32,
        splats: bool,
        first_hits: bool,
    ) -> Result<Self, DeviceError> {
        let film = size_of::<FilmPixel>() as u64;
        let most = context.binding / film;
        let a_page =
            if u64::from(pixels) <= most { pixels } else { most as u32 / BLOCK as u32 * BLOCK as u32 };
        let pages = Self { pixels, a_page };
        let kinds = [
            (FILM, film, true),
            (SPLATS, size_of::<[u32; SPLAT_WORDS]>() as u64, splats),
            (FIRST_HITS, size_of::<FirstHitPixel>() as u64, first_hits),
        ];
        for (kind, bytes, _) in kinds.into_iter().filter(|&(_, _, wanted)| wanted) {
            for page in 0..pages.count() {
                let pixels = pages.range(page).len() as u64;
                buffers.create(context, &pages.name(kind, page), pixels * bytes)?;
            }
        }
        if pages.are_several() {
            for page in 0..pages.count() {
                let Range { start, end } = pages.range(page);
                let page_of = Page { first_pixel: start, pixel_count: end - start, ..Page::default() };
                buffers.upload_uniform(context, &pages.name("page", page), &[page_of])?;
            }
        }
        Ok(pages)
    }

    pub fn are_several(&self) -> bool {
        self.a_page < self.pixels
    }

    /// What kernels that see a page are compiled with.
    pub fn features(&self) -> &'static [Feature] {
        if self.are_several() { &[Feature::FilmPages] } else { &[] }
    }

    fn count(&self) -> u32 {
        self.pixels.div_ceil(self.a_page)
    }

    fn range(&self, page: u32) -> Range<u32> {
        page * self.a_page..(page + 1).saturating_mul(self.a_page).min(self.pixels)
    }

    /// The page in which a pixel lies.
    pub fn of(&self, pixel: u32) -> usize {
        (pixel / self.a_page) as usize
    }

    /// Pixels from this one on that lie in its page.
    pub fn left(&self, pixel: u32) -> u32 {
        self.a_page - pixel % self.a_page
    }

    fn name(&self, kind: &str, page: u32) -> String {
        if self.are_several() { format!("{kind} page {}", page + 1) } else { kind.into() }
    }

    /// Binds something to each of the pages.
    ///
    /// # Errors
    /// What `bind` says.
    pub fn bind(
        &self,
        buffers: &mut BufferTable,
        bind: impl Fn(&mut BufferTable) -> Result<Bound, DeviceError>,
    ) -> Result<Vec<Bound>, DeviceError> {
        if !self.are_several() {
            return Ok(vec![bind(buffers)?]);
        }
        let kinds = [FILM, SPLATS, FIRST_HITS, "page"];
        let mut bound = Vec::new();
        for page in 0..self.count() {
            for kind in kinds {
                if let Ok(buffer) = buffers.get(&self.name(kind, page)).cloned() {
                    buffers.share(kind, buffer);
                }
            }
            bound.push(bind(buffers));
            kinds.iter().for_each(|kind| buffers.unshare(kind));
        }
        bound.into_iter().collect()
    }
}

impl Wavefront {
    /// Sets all that there is of a kind to zero; nothing where there is none of it.
    pub(super) fn clear(&self, kind: &str, encoder: &mut wgpu::CommandEncoder) {
        for page in 0..self.pages.count() {
            if let Ok(buffer) = self.buffers.get(&self.pages.name(kind, page)) {
                encoder.clear_buffer(buffer, 0, None);
            }
        }
    }

    /// Reads what there is of a kind of every pixel, a page at a time: `visit` gets the first pixel, and the entries from
    /// there on. Waits for the device.
    fn read<T: bytemuck::Pod>(
        &self,
        context: &Context,
        kind: &str,
        mut visit: impl FnMut(usize, Vec<T>),
    ) -> Result<(), DeviceError> {
        let pixels = self.settings.view.region().pixels();
        for page in 0..self.pages.count() {
            let Range { start, end } = self.pages.range(page);
            if start < pixels {
                let name = self.pages.name(kind, page);
                let entries = self.buffers.read_elements(context, &name, end.min(pixels) - start)?;
                visit(start as usize, entries);
            }
        }
        Ok(())
    }

    fn read_whole<T: bytemuck::Pod>(&self, context: &Context, kind: &str) -> Result<Vec<T>, DeviceError> {
        let mut whole = Vec::new();
        self.read(context, kind, |_, page| match whole.is_empty() {
            true => whole = page,
            false => whole.extend(page),
        })?;
        Ok(whole)
    }

    /// The film's sums since they were last taken; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn film(&self, context: &Context) -> Result<Vec<FilmPixel>, DeviceError> {
        self.read_whole(context, FILM)
    }

    /// Takes the film's sums, from a first pixel on each time, and sets them to zero; waits for the device.
    ///
    /// # Errors
    /// A lost device.
    pub fn take_film(
        &self,
        context: &Context,
        visit: impl FnMut(usize, Vec<FilmPixel>),
    ) -> Result<(), DeviceError> {
        self.read(context, FILM, visit)?;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        self.clear(FILM, &mut encoder);
        context.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Sets the film's sums.
    ///
    /// # Errors
    /// A film of other pages.
    pub fn write_film(&self, context: &Context, film: &[FilmPixel]) -> Result<(), DeviceError> {
        for (page, pixels) in film.chunks(self.pages.a_page as usize).enumerate() {
            let name = self.pages.name(FILM, page as u32);
            self.buffers.write(context, &name, bytemuck::cast_slice(pixels))?;
        }
        Ok(())
    }

    /// Forgets what light paths have brought to the camera.
    pub(crate) fn clear_splats(&mut self, context: &Context) {
        self.light_at_hand = None;
        let mut encoder = context.device.create_command_encoder(&Default::default());
        self.clear(SPLATS, &mut encoder);
        context.queue.submit([encoder.finish()]);
    }

    /// What light paths have brought to the camera.
    pub(crate) fn read_splats(
        &self,
        context: &Context,
        visit: impl FnMut(usize, Vec<[u32; SPLAT_WORDS]>),
    ) -> Result<(), DeviceError> {
        self.read(context, SPLATS, visit)
    }

    pub(super) fn read_first_hits(&self, context: &Context) -> Result<Vec<FirstHitPixel>, DeviceError> {
        self.read_whole(context, FIRST_HITS)
    }
}
