//! Floating-point pictures as files hold them: named channels and attributes, from OpenEXR, Radiance HDR and PFM.
//!
//! It stands this low because both the environment light and the film read such files.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{AnyChannels, FlatSamples};
use exr::prelude::{Layer as ExrPart, MetaData, ReadChannels, ReadLayers, Vec2, read};

use thiserror::Error;

use crate::fault::Fault;

/// Reading a picture.
#[derive(Debug, Error)]
pub enum PictureFileError {
    #[error("cannot read {path}: {cause}; check that the file is there and readable")]
    Read { path: PathBuf, cause: std::io::Error },
    /// A file that was read but makes no picture, or not one for its purpose; `reason` ends in what to do.
    #[error("cannot use the picture {path}: {reason}")]
    Unusable { path: PathBuf, reason: String },
}

impl PictureFileError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Read { .. } | Self::Unusable { .. } => Fault::Input,
        }
    }
}

/// The most samples (pixels times channels) that a file may ask for: 4 GiB of `f32`.
const MAX_SAMPLES: u64 = 1 << 30;

/// CIE xy of the Rec.709 primaries and of D65: red, green, blue, white.
pub const REC709: [[f32; 2]; 4] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// How far declared chromaticities may lie from [`REC709`] in x or y; published values have three to four digits.
const CHROMATICITY_TOLERANCE: f32 = 2e-3;

/// A named value beside the pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// UTF-8 text.
    Text(String),
    /// Any of the file's number types.
    Number(f64),
}

/// Named channels of one size, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureFile {
    pub width: u32,
    pub height: u32,
    /// Name (for example `R`, `albedo.G`) and `width * height` samples, in the file's order.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Text and numbers of the header that have no fixed meaning in the format, sorted by name.
    pub attributes: Vec<(String, Attribute)>,
}

impl PictureFile {
    /// Reads a file by its extension: `.exr`, `.hdr` or `.pfm`.
    ///
    /// # Errors
    /// [`PictureFileError::Read`] when the bytes cannot be had, [`PictureFileError::Unusable`] when they make no picture:
    /// unknown extension, damaged, too large, deep or subsampled, or in primaries other than Rec.709.
    pub fn read(path: &Path) -> Result<Self, PictureFileError> {
        let fail = |reason: String| PictureFileError::Unusable { path: path.to_owned(), reason };
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let decode = match extension.as_str() {
            "exr" => decode_exr,
            "hdr" => decode_hdr,
            "pfm" => decode_pfm,
            _ => return Err(fail("its extension is none of .exr, .hdr, .pfm; convert it to OpenEXR".into())),
        };
        let bytes =
            std::fs::read(path).map_err(|cause| PictureFileError::Read { path: path.to_owned(), cause })?;
        let picture = decode(&bytes).map_err(fail)?;
        Ok(picture)
    }

    /// The pixels of the channels `R`, `G`, `B`, or of the single channel `Y` thrice.
    ///
    /// # Errors
    /// A sentence that names the channels there are.
    pub fn rgb(&self) -> Result<Vec<[f32; 3]>, String> {
        let find = |name: &str| self.channels.iter().find(|(other, _)| other == name).map(|(_, data)| data);
        match (find("R"), find("G"), find("B"), find("Y")) {
            (Some(r), Some(g), Some(b), _) => {
                Ok(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect())
            }
            (None, None, None, Some(y)) => Ok(y.iter().map(|&y| [y; 3]).collect()),
            _ => {
                let names: Vec<&str> = self.channels.iter().map(|(name, _)| name.as_str()).collect();
                Err(format!(
                    "it has no channels R, G and B, only {}; export it with plain RGB channels",
                    names.join(", ")
                ))
            }
        }
    }
}

fn decode_exr(bytes: &[u8]) -> Result<PictureFile, String> {
    let damaged =
        |error: exr::error::Error| format!("it is damaged or not OpenEXR ({error}); export it again");
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(damaged)?;
    for header in &meta.headers {
        let samples = header.layer_size.area() as u64 * header.channels.list.len() as u64;
        check_sample_count(samples)?;
        if header.deep {
            return Err("it holds deep data; flatten it first".into());
        }
        if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err("it has subsampled channels; export it with full-size channels".into());
        }
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(damaged)?;
    if let Some(declared) = image.attributes.chromaticities {
        check_chromaticities(&declared)?;
    }

    let size = image.layer_data[0].size;
    let several_parts = image.layer_data.len() > 1;
    let mut picture =
        PictureFile { width: size.width() as u32, height: size.height() as u32, ..Default::default() };
    collect_attributes(&image.attributes.other, &mut picture.attributes);
    for part in image.layer_data {
        if part.size != size {
            return Err("its parts differ in size; keep only the one with the colours".into());
        }
        collect_attributes(&part.attributes.other, &mut picture.attributes);
        append_channels(part, several_parts, &mut picture.channels);
    }
    picture.attributes.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(picture)
}

/// Channels of a part; where a file has several named parts, the part's name stands before the channel's.
fn append_channels(
    part: ExrPart<AnyChannels<FlatSamples>>,
    several_parts: bool,
    channels: &mut Vec<(String, Vec<f32>)>,
) {
    let prefix = match &part.attributes.layer_name {
        Some(name) if several_parts => format!("{}.", utf8(name)),
        _ => String::new(),
    };
    for channel in part.channel_data.list {
        let samples = match channel.sample_data {
            FlatSamples::F32(samples) => samples,
            other => other.values_as_f32().collect(),
        };
        channels.push((format!("{prefix}{}", utf8(&channel.name)), samples));
    }
}

fn collect_attributes<'a>(
    from: impl IntoIterator<Item = (&'a Text, &'a AttributeValue)>,
    into: &mut Vec<(String, Attribute)>,
) {
    for (name, value) in from {
        let value = match value {
            AttributeValue::Text(text) => Attribute::Text(utf8(text)),
            AttributeValue::F64(number) => Attribute::Number(*number),
            AttributeValue::F32(number) => Attribute::Number(f64::from(*number)),
            AttributeValue::I32(number) => Attribute::Number(f64::from(*number)),
            _ => continue,
        };
        into.push((utf8(name), value));
    }
}

/// EXR text has no declared encoding; OpenEXR recommends UTF-8.
fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn check_chromaticities(declared: &Chromaticities) -> Result<(), String> {
    let declared = [declared.red, declared.green, declared.blue, declared.white];
    let off = declared.iter().zip(REC709).any(|(have, want)| {
        !((have.0 - want[0]).abs() <= CHROMATICITY_TOLERANCE
            && (have.1 - want[1]).abs() <= CHROMATICITY_TOLERANCE)
    });
    if off {
        return Err(
            "its chromaticities attribute names primaries other than Rec.709; convert it to linear Rec.709 \
             (for example with oiiotool --colorconvert)"
                .into(),
        );
    }
    Ok(())
}

fn check_sample_count(samples: u64) -> Result<(), String> {
    if samples == 0 {
        return Err("it has no pixels".into());
    }
    if samples > MAX_SAMPLES {
        return Err(format!(
            "it holds {samples} samples, more than the {MAX_SAMPLES} supported; scale it down"
        ));
    }
    Ok(())
}

fn decode_hdr(bytes: &[u8]) -> Result<PictureFile, String> {
    let damaged = |error: image::ImageError| format!("it is damaged or not Radiance HDR ({error})");
    let decoder = image::codecs::hdr::HdrDecoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let size = decoder.metadata();
    check_sample_count(3 * u64::from(size.width) * u64::from(size.height))?;
    let pixels = image::DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f();
    Ok(from_rgb(size.width, size.height, pixels.pixels().map(|pixel| pixel.0)))
}

/// Portable float map: `PF` or `Pf`, width, height, a scale whose sign is the byte order, then rows from the bottom up.
/// Its magnitude is ignored by common readers and so by this one.
fn decode_pfm(bytes: &[u8]) -> Result<PictureFile, String> {
    let damaged = || "it is damaged or not a portable float map".to_owned();
    let mut start = 0;
    let mut words = Vec::with_capacity(4);
    while words.len() < 4 {
        let length = bytes[start..].iter().position(u8::is_ascii_whitespace).ok_or_else(damaged)?;
        words.push(std::str::from_utf8(&bytes[start..start + length]).map_err(|_| damaged())?);
        start += length + 1;
    }
    let channels = match words[0] {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(damaged()),
    };
    let width: u32 = words[1].parse().map_err(|_| damaged())?;
    let height: u32 = words[2].parse().map_err(|_| damaged())?;
    let scale: f32 = words[3].parse().map_err(|_| damaged())?;
    let samples = u64::from(width) * u64::from(height) * channels;
    check_sample_count(samples)?;
    let data = &bytes[start..];
    if data.len() as u64 != 4 * samples {
        return Err(format!("it holds {} bytes of pixels where {} are announced", data.len(), 4 * samples));
    }
    let sample = |index: usize| {
        let bytes = [data[4 * index], data[4 * index + 1], data[4 * index + 2], data[4 * index + 3]];
        if scale < 0.0 { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) }
    };
    let channels = channels as usize;
    let pixels = (0..height as usize).rev().flat_map(|row| {
        (0..width as usize).map(move |column| {
            let first = channels * (row * width as usize + column);
            [sample(first), sample(first + (channels - 1) / 2), sample(first + channels - 1)]
        })
    });
    Ok(from_rgb(width, height, pixels))
}

fn from_rgb(width: u32, height: u32, pixels: impl Iterator<Item = [f32; 3]>) -> PictureFile {
    let mut channels = ["R", "G", "B"].map(|name| (name.to_owned(), Vec::new()));
    for pixel in pixels {
        for (channel, value) in channels.iter_mut().zip(pixel) {
            channel.1.push(value);
        }
    }
    PictureFile { width, height, channels: channels.into(), attributes: Vec::new() }
}
