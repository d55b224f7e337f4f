//! Denoising by Open Image Denoise (<https://www.openimagedenoise.org>, Apache-2.0), where that is installed.
//!
//! The colours are filtered by the layers `albedo` and `normal` as they are: these have little noise after a few samples, and
//! filtering them first takes more detail from them than noise (docs/measurements.md, Denoising). The result is biased; what
//! it is made of stays as it is.

mod crash;
mod library;
mod places;
mod range;

use std::ffi::CStr;

use super::halves::Halves;
use super::{Attribute, FilmError, Picture, Region, denoised_error};
use library::{Device, DeviceKind, Job, Library};
use range::Range;

/// The layer with the result.
pub const LAYER: &str = "denoised";

/// Pixels along an edge of what is filtered at a time: with its margins, a gigabyte of images. The library divides that
/// further for its own memory.
const TILE: u32 = 4096;
/// Pixels around a tile that it is filtered with: more than the filter looks at, 174 across.
const MARGIN: u32 = 128;
/// Pixels that a picture is continued by at its edges, mirrored: the library takes for black what it fills up itself, and
/// changes pixels at the edge for it.
const BORDER: u32 = 32;

/// The opened library.
pub struct Denoiser {
    library: Library,
    /// Once it was needed.
    device: Option<Device>,
    /// Pixels along an edge of a tile, a multiple of 16: the filter halves pictures four times.
    pub tile: u32,
}

impl Denoiser {
    /// Opens the library: from `$HALFWAY_OIDN` (itself or its folder), beside the program, where `tools/setup --denoiser`
    /// puts it, or where the system looks.
    ///
    /// # Errors
    /// [`FilmError::NoDenoiser`] with what to do.
    pub fn open() -> Result<Self, FilmError> {
        let mut reasons = Vec::new();
        for place in places::places() {
            match Library::open(&place) {
                Ok(library) => return Ok(Self { library, device: None, tile: TILE }),
                Err(reason) => reasons.push(reason),
            }
        }
        Err(FilmError::NoDenoiser { reason: reasons.join("; ") })
    }

    /// The library and what it computes on.
    ///
    /// # Errors
    /// As [`denoise`](Self::denoise).
    pub fn describe(&mut self) -> Result<String, FilmError> {
        let device = self.device()?;
        let kind = if device.is_cpu() { "CPU" } else { "GPU" };
        Ok(format!("Open Image Denoise {} ({kind})", device.version_text()))
    }

    fn device(&mut self) -> Result<&Device, FilmError> {
        if self.device.is_none() {
            let device = self.library.device(DeviceKind::Fastest);
            let device = device.or_else(|_| self.library.device(DeviceKind::Cpu));
            self.device = Some(device.map_err(|reason| FilmError::Denoiser { reason })?);
        }
        self.device.as_ref().ok_or(FilmError::Denoiser { reason: "there is no device".into() })
    }

    /// The colours of a picture without their noise, all of them finite. Pixels that are not finite take those around them.
    ///
    /// # Errors
    /// [`FilmError::Denoiser`] where the library refuses, on a GPU and on the CPU.
    pub fn denoise(&mut self, picture: &Picture) -> Result<Vec<[f32; 3]>, FilmError> {
        self.denoise_all(&[picture]).map(|mut all| all.swap_remove(0))
    }

    /// As [`denoise`](Self::denoise), and its estimated error, from halves of it that are denoised with its layers and its
    /// exposure; `None` for a black picture.
    ///
    /// # Errors
    /// As [`denoise`](Self::denoise).
    pub fn denoise_halves(
        &mut self,
        picture: &Picture,
        halves: &Halves,
    ) -> Result<(Vec<[f32; 3]>, Option<f64>), FilmError> {
        let [a, b] = &halves.pictures;
        let mut all = self.denoise_all(&[picture, a, b])?;
        let error = denoised_error::estimate(halves, [&all[0], &all[1], &all[2]]);
        Ok((all.swap_remove(0), error))
    }

    /// Pictures with the layers and the exposure of the first.
    fn denoise_all(&mut self, pictures: &[&Picture]) -> Result<Vec<Vec<[f32; 3]>>, FilmError> {
        let denoised = self.denoise_here(pictures);
        // What a GPU has no memory for the CPU may have.
        let on_gpu = self.device.as_ref().is_some_and(|device| !device.is_cpu());
        let denoised = match denoised {
            Err(reason) if on_gpu => {
                log::warn!("the GPU does not denoise this picture ({reason}); the CPU does");
                self.device = Some(
                    self.library.device(DeviceKind::Cpu).map_err(|reason| FilmError::Denoiser { reason })?,
                );
                self.denoise_here(pictures)
            }
            denoised => denoised,
        };
        denoised.map_err(|reason| FilmError::Denoiser { reason })
    }

    /// Adds the layer of the result, and to the metadata what made it. Returns its estimated error, where there are halves of
    /// the picture.
    ///
    /// # Errors
    /// As [`denoise`](Self::denoise), and the picture is as it was.
    pub fn add_to(
        &mut self,
        picture: &mut Picture,
        halves: Option<&Halves>,
    ) -> Result<Option<f64>, FilmError> {
        let (denoised, error) = match halves {
            Some(halves) => self.denoise_halves(picture, halves)?,
            None => (self.denoise(picture)?, None),
        };
        let made_by = self.describe()?;
        picture.layers.retain(|layer| layer.name != LAYER);
        for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
            picture.push_channel(LAYER, name, denoised.iter().map(|pixel| pixel[channel]).collect());
        }
        picture.metadata.retain(|(name, _)| !matches!(name.as_str(), "biased" | "denoiser"));
        picture.metadata.push(("biased".into(), Attribute::Text("denoised".into())));
        picture.metadata.push(("denoiser".into(), Attribute::Text(made_by)));
        Ok(error)
    }

    /// The first of these pictures has the layers.
    fn denoise_here(&mut self, pictures: &[&Picture]) -> Result<Vec<Vec<[f32; 3]>>, String> {
        let picture = pictures[0];
        let layer = |name: &str, channels: [&str; 3]| -> Option<Vec<[f32; 3]>> {
            let [r, g, b] = channels.map(|channel| picture.channel(name, channel));
            let (r, g, b) = (r?, g?, b?);
            Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b].map(finite_or_zero)).collect())
        };
        let layers =
            [(c"albedo", layer("albedo", ["R", "G", "B"])), (c"normal", layer("normal", ["X", "Y", "Z"]))];
        let range = Range::of(picture);
        let colors: Vec<_> = pictures.iter().map(|picture| range.apply(picture)).collect();
        let edge = self.tile;
        let device = self.device().map_err(|error| error.to_string())?;
        let mut results = vec![vec![[0.0; 3]; picture.rgb.len()]; pictures.len()];
        for (tile, wide) in tiles(picture.width, picture.height, edge) {
            let [width, height] = wide.size;
            let cut = |values: &[[f32; 3]]| wide.cut(values, picture.width, picture.height);
            // The color's place is the first.
            let mut images = vec![(c"color", Vec::new())];
            images.extend(layers.iter().filter_map(|(name, values)| Some((*name, cut(values.as_deref()?)))));
            for (colors, result) in colors.iter().zip(&mut results) {
                images[0].1 = cut(colors);
                let views: Vec<(&'static CStr, &[[f32; 3]])> =
                    images.iter().map(|(name, values)| (*name, values.as_slice())).collect();
                let job = Job { width, height, images: &views, input_scale: range.input_scale() };
                let denoised = device.run(&job)?;
                for y in 0..tile.height {
                    let from = wide.index(tile.x, tile.y + y);
                    let to = (tile.y + y) as usize * picture.width as usize + tile.x as usize;
                    let count = tile.width as usize;
                    result[to..to + count].copy_from_slice(&denoised[from..from + count]);
                }
            }
        }
        results.iter_mut().for_each(|result| range.undo(result));
        Ok(results)
    }
}

fn finite_or_zero(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// A part of a picture, or of its mirrored continuation.
struct Window {
    /// Column and row of its first pixel.
    first: [i64; 2],
    size: [usize; 2],
}

impl Window {
    /// The window around `count` pixels from `first` on, of `length` along an axis: where it begins, and its size.
    fn axis(first: u32, count: u32, length: u32) -> (i64, usize) {
        let before = if first == 0 { BORDER } else { MARGIN };
        let after = if first + count == length { BORDER } else { MARGIN };
        (i64::from(first) - i64::from(before), (before + count + after) as usize)
    }

    /// Where it has a pixel of the picture.
    fn index(&self, x: u32, y: u32) -> usize {
        let [column, row] = [i64::from(x) - self.first[0], i64::from(y) - self.first[1]];
        row as usize * self.size[0] + column as usize
    }

    /// Its pixels, of a picture of that size.
    fn cut(&self, values: &[[f32; 3]], width: u32, height: u32) -> Vec<[f32; 3]> {
        let mirrored = |at: i64, length: u32| {
            let length = i64::from(length);
            let at = at.rem_euclid(2 * length);
            (if at < length { at } else { 2 * length - 1 - at }) as usize
        };
        let columns: Vec<usize> =
            (0..self.size[0]).map(|x| mirrored(self.first[0] + x as i64, width)).collect();
        let rows = (0..self.size[1]).map(|y| mirrored(self.first[1] + y as i64, height) * width as usize);
        rows.flat_map(|row| columns.iter().map(move |column| values[row + column])).collect()
    }
}

/// The tiles of a picture, each with the window that it is filtered in.
fn tiles(width: u32, height: u32, edge: u32) -> impl Iterator<Item = (Region, Window)> {
    let starts = move |length: u32| (0..length).step_by(edge as usize);
    starts(height).flat_map(move |y| {
        starts(width).map(move |x| {
            let tile = Region::new(x, y, edge.min(width - x), edge.min(height - y));
            let (left, columns) = Window::axis(x, tile.width, width);
            let (top, rows) = Window::axis(y, tile.height, height);
            (tile, Window { first: [left, top], size: [columns, rows] })
        })
    })
}
