//! From sums of samples to pictures on disk, and the comparison of pictures.

pub mod average;
pub mod checkpoint;
pub mod contact_sheet;
pub mod cryptomatte;
pub mod denoise;
mod denoised_error;
mod error;
mod estimate;
mod exposure;
pub mod exr;
pub mod false_color;
pub mod flip;
pub mod halves;
pub mod heatmap;
pub mod merge;
pub mod metric;
pub mod png;
mod read;
pub mod state;
pub mod sums;
pub mod tev;
pub mod tonemap;
mod variance;
pub mod write;

use std::borrow::Cow;

pub use crate::picture_file::Attribute;
pub use error::FilmError;
pub use exposure::{Exposure, Lost, MAX_STOPS};
pub use variance::Variance;

/// Pixels of a picture: a rectangle of them, or a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first column and row.
    pub x: u32,
    pub y: u32,
    /// How many columns and rows.
    pub width: u32,
    pub height: u32,
    /// From one column or row to the next: 1 for a rectangle without gaps.
    pub stride: u32,
}

impl Region {
    /// A rectangle without gaps.
    pub fn new(x: u32, y: u32, width: u32, height: u32) -> Self {
        Self { x, y, width, height, stride: 1 }
    }

    /// A whole picture.
    pub fn whole(width: u32, height: u32) -> Self {
        Self::new(0, 0, width, height)
    }

    /// One pixel, about the middle one, of every square of `stride` times `stride` in a picture that has pixels.
    pub fn lattice(width: u32, height: u32, stride: u32) -> Self {
        let first = |length: u32| (stride / 2).min(length.saturating_sub(1));
        let count = |length: u32| (length - first(length)).div_ceil(stride);
        Self { x: first(width), y: first(height), width: count(width), height: count(height), stride }
    }

    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// The rectangle without gaps that holds it.
    pub fn hull(&self) -> Self {
        let extent = |count: u32| count.saturating_sub(1) * self.stride + count.min(1);
        Self::new(self.x, self.y, extent(self.width), extent(self.height))
    }
}

/// Attribute of files whose layer `variance` is scaled, see [`Picture::variance_scale`].
pub const VARIANCE_SCALE: &str = "varianceScale";

/// A scene-linear Rec.709 picture in `f32` with what belongs to it, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Radiance, `width * height` pixels.
    pub rgb: Vec<[f32; 3]>,
    /// Further data per pixel, see [`Layer`].
    pub layers: Vec<Layer>,
    /// What the values of the layer `variance` are to be multiplied by, a power of two; `None`: they are as they are. Files
    /// have it as their attribute [`VARIANCE_SCALE`].
    pub variance_scale: Option<f64>,
    /// Name and value, written as attributes of the file. Names are unique and no attribute names of OpenEXR.
    pub metadata: Vec<(String, Attribute)>,
}

/// Named data per pixel beside the radiance.
///
/// The names in use: `albedo` (R, G, B), `normal` (X, Y, Z), `depth` (Z), `samples` (Y), `denoised` (R, G, B), and
/// `variance` (R, G, B):
/// the estimated variance of the pixel's *mean*, that is the square of its standard error, in the units of
/// [`Picture::variance_scale`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// The part of a channel's name before its last dot; empty for a channel without one, such as `A`.
    pub name: String,
    /// Short name (`R`, `X`) and `width * height` samples.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Layer {
    /// The name of a channel of this layer in a file: `albedo.R`, or the channel's own in the nameless layer.
    pub fn full_name(&self, channel: &str) -> String {
        if self.name.is_empty() { channel.to_owned() } else { format!("{}.{channel}", self.name) }
    }
}

impl Picture {
    /// A picture without layers or metadata; `rgb` has `width * height` pixels.
    pub fn new(width: u32, height: u32, rgb: Vec<[f32; 3]>) -> Self {
        Self { width, height, rgb, ..Self::default() }
    }

    /// Values of its colours that are infinite or NaN.
    pub fn non_finite_values(&self) -> usize {
        self.rgb.iter().flatten().filter(|value| !value.is_finite()).count()
    }

    /// The colours of some of its pixels, which all lie in it, without layers and metadata.
    pub fn part(&self, region: &Region) -> Self {
        let rows = (0..region.height).map(|row| region.y + row * region.stride);
        let columns = |y: u32| {
            (0..region.width).map(move |column| (y * self.width + region.x + column * region.stride) as usize)
        };
        Self::new(region.width, region.height, rows.flat_map(columns).map(|pixel| self.rgb[pixel]).collect())
    }

    /// Adds a channel to the layer of that name, which is made if there is none. `samples` has `width * height` values.
    pub fn push_channel(&mut self, layer: &str, channel: &str, samples: Vec<f32>) {
        let index = self.layers.iter().position(|other| other.name == layer).unwrap_or_else(|| {
            self.layers.push(Layer { name: layer.to_owned(), channels: Vec::new() });
            self.layers.len() - 1
        });
        self.layers[index].channels.push((channel.to_owned(), samples));
    }

    /// The samples of a channel, for example `("variance", "R")`.
    pub fn channel(&self, layer: &str, channel: &str) -> Option<&[f32]> {
        let layer = self.layers.iter().find(|other| other.name == layer)?;
        layer.channels.iter().find(|(name, _)| name == channel).map(|(_, samples)| samples.as_slice())
    }

    /// What is to be looked at: the denoised colours, where there are any, else those that were rendered.
    pub fn shown(&self) -> Cow<'_, [[f32; 3]]> {
        match ["R", "G", "B"].map(|channel| self.channel(denoise::LAYER, channel)) {
            [Some(r), Some(g), Some(b)] => {
                r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect::<Vec<_>>().into()
            }
            _ => self.rgb.as_slice().into(),
        }
    }

    /// The value of a metadata entry.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.metadata.iter().find(|(other, _)| other == name).map(|(_, value)| value)
    }
}
