//! OpenEXR, scene-linear Rec.709 with its chromaticities: `f32` and ZIP, unless otherwise asked for.

use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds,
    LayerAttributes, LineOrder, Vec2, WritableImage, f16,
};

use super::write::{write_atomic, write_new};
use super::{Attribute, Picture, VARIANCE_SCALE};
use crate::film::FilmError;
use crate::picture_file::{MAIN_PART, REC709};

/// How samples are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coding {
    /// 16-bit floats where they are enough: not for numbers of any size, such as depth, nor for ids.
    pub half: bool,
    pub compression: Compression,
    /// A part of the file for each layer, so that programs read only those that they need.
    pub multi_part: bool,
}

/// What is made of the samples' bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// Without loss.
    #[default]
    Zip,
    /// With losses in the colours, at the usual level; a part of its own that is to stay as it is has none.
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

/// A layer of numbers that are to stay as they are.
fn is_exact(layer: &str) -> bool {
    FULL.contains(&layer) || layer.starts_with(IDS)
}

/// The samples of a channel of a layer; adds to `cut` those that are too large.
fn samples(layer: &str, values: Vec<f32>, coding: &Coding, cut: &mut usize) -> FlatSamples {
    if !coding.half || is_exact(layer) {
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

/// A layer of the file: its name, and its channels by their full names.
type FileLayer<'a> = (&'a str, Vec<AnyChannel<FlatSamples>>);

/// The layers of a picture, its colours first, with what else stands in none; adds to `cut` the values that are too large.
fn layers<'a>(picture: &'a Picture, coding: &Coding, cut: &mut usize) -> Vec<FileLayer<'a>> {
    let colors = ["R", "G", "B"].into_iter().enumerate().map(|(index, name)| {
        let values = picture.rgb.iter().map(|pixel| pixel[index]).collect();
        AnyChannel::new(name, samples("", values, coding, cut))
    });
    let mut layers = vec![("", colors.collect::<Vec<_>>())];
    for layer in &picture.layers {
        let channels = layer.channels.iter().map(|(name, values)| {
            let values = samples(&layer.name, values.clone(), coding, cut);
            AnyChannel::new(text(&layer.full_name(name)), values)
        });
        let channels: Vec<_> = channels.collect();
        match layer.name.is_empty() {
            true => layers[0].1.extend(channels),
            false => layers.push((&layer.name, channels)),
        }
    }
    layers
}

/// The file's bytes, and how many values did not fit.
fn encode(picture: &Picture, coding: &Coding) -> exr::error::Result<(Vec<u8>, usize)> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let mut cut = 0;
    let layers = layers(picture, coding, &mut cut);
    let encoding = |lossless: bool| Encoding {
        compression: match coding.compression {
            Compression::Dwaa if !lossless => exr::prelude::Compression::DWAA(None),
            _ => exr::prelude::Compression::ZIP16,
        },
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let part = |attributes: LayerAttributes, channels: Vec<AnyChannel<FlatSamples>>, encoding: Encoding| {
        exr::image::Layer::new(size, attributes, encoding, AnyChannels::sort(channels.into_iter().collect()))
    };
    let mut parts: Vec<_> = match coding.multi_part {
        true => layers
            .into_iter()
            .map(|(name, channels)| {
                let name = if name.is_empty() { MAIN_PART } else { name };
                let mut attributes = LayerAttributes::named(text(name));
                // Some programs look for the names of ids where the ids are.
                attributes.other.extend(picture.metadata_of_ids(name).map(attribute));
                part(attributes, channels, encoding(is_exact(name)))
            })
            .collect(),
        false => {
            let all = layers.into_iter().flat_map(|(_, channels)| channels).collect();
            vec![part(LayerAttributes::default(), all, encoding(false))]
        }
    };
    let first = &mut parts[0].attributes.other;
    first.extend(picture.metadata.iter().map(attribute));
    if let Some(scale) = picture.variance_scale {
        first.insert(text(VARIANCE_SCALE), AttributeValue::F64(scale));
    }
    let bounds = IntegerBounds::from_dimensions(size);
    let [red, green, blue, white] = REC709.map(|xy| Vec2(xy[0], xy[1]));
    let chromaticities = Some(Chromaticities { red, green, blue, white });
    let attributes = ImageAttributes { chromaticities, ..ImageAttributes::new(bounds) };
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(attributes, parts).write().to_buffered(&mut bytes)?;
    Ok((bytes.into_inner(), cut))
}

/// An entry of a picture's metadata as the file has it.
fn attribute((name, value): &(String, Attribute)) -> (Text, AttributeValue) {
    let value = match value {
        Attribute::Text(value) => AttributeValue::Text(text(value)),
        Attribute::Number(value) => AttributeValue::F64(*value),
    };
    (text(name), value)
}

/// UTF-8 as it is; the crate's own conversion knows Latin-1 only.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}
