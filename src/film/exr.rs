//! OpenEXR, scene-linear Rec.709 with its chromaticities: `f32` and ZIP, unless otherwise asked for.

use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, LayerAttributes, LineOrder, Vec2,
    WritableImage, f16,
};

use super::write::{write_atomic, write_new};
use super::{Attribute, Picture, VARIANCE_SCALE};
use crate::film::FilmError;
use crate::picture_file::REC709;

/// How samples are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coding {
    /// 16-bit floats where they are enough: not for numbers of any size, such as depth, nor for ids.
    pub half: bool,
    pub compression: Compression,
}

/// What is made of the samples' bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Without loss.
    #[default]
    Zip,
    /// With losses in the colours, at the usual level.
    Dwaa,
}

/// Layers of numbers that half floats are too small or too coarse for.
const FULL: [&str; 5] = ["depth", "variance", "samples", "position", "uv"];
const IDS: &str = "Crypto";

/// Writes a picture with all its layers and metadata, see [`write_atomic`] for how.
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> Result<(), FilmError> {
    write_as(path, picture, &Coding::default())
}

/// As [`write()`], stored in another way. Values beyond the largest half float become that, with a warning.
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn write_as(path: &Path, picture: &Picture, coding: &Coding) -> Result<(), FilmError> {
    write_atomic(path, &bytes(path, picture, coding)?)
}

/// As [`write()`], where there is no such file yet, see [`write_new`].
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn create(path: &Path, picture: &Picture) -> Result<(), FilmError> {
    write_new(path, &bytes(path, picture, &Coding::default())?)
}

/// The file that goes to `path`.
fn bytes(path: &Path, picture: &Picture, coding: &Coding) -> Result<Vec<u8>, FilmError> {
    let (bytes, cut) = encode(picture, coding)
        .map_err(|error| FilmError::Write { path: path.to_owned(), cause: std::io::Error::other(error) })?;
    if cut > 0 {
        log::warn!(
            "{}: {cut} values are larger than half floats can be ({}), and are written as that; leave out --half to keep them",
            path.display(),
            f16::MAX
        );
    }
    Ok(bytes)
}

/// The samples of a channel of a layer; adds to `cut` those that are too large.
fn samples(layer: &str, values: Vec<f32>, coding: &Coding, cut: &mut usize) -> FlatSamples {
    if !coding.half || FULL.contains(&layer) || layer.starts_with(IDS) {
        return FlatSamples::F32(values);
    }
    let most = f16::MAX.to_f32();
    let half = |value: f32| {
        let too_large = value.is_finite() && value.abs() > most;
        *cut += usize::from(too_large);
        f16::from_f32(if too_large { most.copysign(value) } else { value })
    };
    FlatSamples::F16(values.into_iter().map(half).collect())
}

/// The file's bytes, and how many values did not fit.
fn encode(picture: &Picture, coding: &Coding) -> exr::error::Result<(Vec<u8>, usize)> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let mut channels = Vec::new();
    let mut cut = 0;
    for (index, name) in ["R", "G", "B"].into_iter().enumerate() {
        let values = picture.rgb.iter().map(|pixel| pixel[index]).collect();
        channels.push(AnyChannel::new(name, samples("", values, coding, &mut cut)));
    }
    for layer in &picture.layers {
        for (name, values) in &layer.channels {
            let values = samples(&layer.name, values.clone(), coding, &mut cut);
            channels.push(AnyChannel::new(text(&layer.full_name(name)), values));
        }
    }
    let encoding = Encoding {
        compression: match coding.compression {
            Compression::Zip => exr::prelude::Compression::ZIP16,
            Compression::Dwaa => exr::prelude::Compression::DWAA(None),
        },
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let part = exr::image::Layer::new(
        size,
        LayerAttributes::default(),
        encoding,
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let mut image = Image::from_layer(part);
    let [red, green, blue, white] = REC709.map(|xy| Vec2(xy[0], xy[1]));
    image.attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
    for (name, value) in &picture.metadata {
        let value = match value {
            Attribute::Text(value) => AttributeValue::Text(text(value)),
            Attribute::Number(value) => AttributeValue::F64(*value),
        };
        image.layer_data.attributes.other.insert(text(name), value);
    }
    if let Some(scale) = picture.variance_scale {
        image.layer_data.attributes.other.insert(text(VARIANCE_SCALE), AttributeValue::F64(scale));
    }
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes)?;
    Ok((bytes.into_inner(), cut))
}

/// UTF-8 as it is; the crate's own conversion knows Latin-1 only.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}
