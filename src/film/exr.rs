//! OpenEXR: `f32`, ZIP, scene-linear Rec.709 with its chromaticities.

use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, LayerAttributes, LineOrder,
    Vec2, WritableImage,
};

use super::write::{write_atomic, write_new};
use super::{Attribute, Picture, VARIANCE_SCALE};
use crate::film::FilmError;
use crate::picture_file::REC709;

/// Writes a picture with all its layers and metadata, see [`write_atomic`] for how.
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn write(path: &Path, picture: &Picture) -> Result<(), FilmError> {
    write_atomic(path, &bytes(path, picture)?)
}

/// As [`write()`], where there is no such file yet, see [`write_new`].
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn create(path: &Path, picture: &Picture) -> Result<(), FilmError> {
    write_new(path, &bytes(path, picture)?)
}

/// The file that goes to `path`.
fn bytes(path: &Path, picture: &Picture) -> Result<Vec<u8>, FilmError> {
    encode(picture)
        .map_err(|error| FilmError::Write { path: path.to_owned(), cause: std::io::Error::other(error) })
}

fn encode(picture: &Picture) -> exr::error::Result<Vec<u8>> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let mut channels = Vec::new();
    for (index, name) in ["R", "G", "B"].into_iter().enumerate() {
        let samples = picture.rgb.iter().map(|pixel| pixel[index]).collect();
        channels.push(AnyChannel::new(name, FlatSamples::F32(samples)));
    }
    for layer in &picture.layers {
        for (name, samples) in &layer.channels {
            channels.push(AnyChannel::new(text(&layer.full_name(name)), FlatSamples::F32(samples.clone())));
        }
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
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
    Ok(bytes.into_inner())
}

/// UTF-8 as it is; the crate's own conversion knows Latin-1 only.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}
