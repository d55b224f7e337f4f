//! PNG: display pictures of 8 or 16 bits per channel, out and in.

use std::io::Cursor;
use std::path::Path;

use super::tonemap::{ViewTransform, srgb_decode, srgb_encode};
use super::{Picture, write::write_atomic};
use crate::film::FilmError;
use crate::picture_file::PictureFileError;

/// Bits per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    #[default]
    Eight,
    Sixteen,
}

/// Writes what the picture, [denoised](Picture::shown) where it is, looks like on a screen through `view` at `exposure` stops.
/// Where it has the channel `A`, which colours are multiplied by, so has the file, by which they are not.
///
/// # Errors
/// [`FilmError::NonFinite`] when a pixel has no colour, [`FilmError::Write`] when the file cannot be written.
pub fn write(path: &Path, picture: &Picture, view: ViewTransform, exposure: f32) -> Result<(), FilmError> {
    write_as(path, picture, view, exposure, Depth::Eight)
}

/// As [`write()`], with another number of bits.
///
/// # Errors
/// As [`write()`].
pub fn write_as(
    path: &Path,
    picture: &Picture,
    view: ViewTransform,
    exposure: f32,
    depth: Depth,
) -> Result<(), FilmError> {
    let shown = picture.shown();
    let count = shown.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count();
    if count > 0 {
        return Err(FilmError::NonFinite { path: path.to_owned(), count });
    }
    let alpha = picture.channel("", "A");
    let mut signals = Vec::with_capacity(4 * shown.len());
    for (index, &radiance) in shown.iter().enumerate() {
        let share = alpha.map(|alpha| alpha[index].clamp(0.0, 1.0));
        let radiance = match share {
            Some(share) if share > 0.0 => radiance.map(|value| value / share),
            _ => radiance,
        };
        signals.extend(view.display(exposure, radiance).map(srgb_encode));
        signals.extend(share);
    }
    let bytes: Vec<u8> = match depth {
        Depth::Eight => signals.into_iter().map(to_byte).collect(),
        Depth::Sixteen => signals.into_iter().flat_map(to_bytes).collect(),
    };
    let color = if alpha.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb };
    write_encoded(path, [picture.width, picture.height], color, depth, &bytes)
}

/// The sRGB bytes of a radiance.
pub fn pixel(radiance: [f32; 3], view: ViewTransform, exposure: f32) -> [u8; 3] {
    view.display(exposure, radiance).map(|linear| to_byte(srgb_encode(linear)))
}

/// Writes sRGB bytes, `width * height` pixels.
///
/// # Errors
/// [`FilmError::Write`] when the file cannot be written.
pub fn write_bytes(path: &Path, width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<(), FilmError> {
    write_encoded(path, [width, height], png::ColorType::Rgb, Depth::Eight, pixels.as_flattened())
}

fn write_encoded(
    path: &Path,
    size: [u32; 2],
    color: png::ColorType,
    depth: Depth,
    data: &[u8],
) -> Result<(), FilmError> {
    let bytes = encode(size, color, depth, data)
        .map_err(|error| FilmError::Write { path: path.to_owned(), cause: error.into() })?;
    write_atomic(path, &bytes)
}

fn encode(
    [width, height]: [u32; 2],
    color: png::ColorType,
    depth: Depth,
    data: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(match depth {
        Depth::Eight => png::BitDepth::Eight,
        Depth::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    writer.finish()?;
    Ok(bytes)
}

/// Reads a PNG as linear light; alpha, if any, becomes the channel `A` of the nameless layer.
///
/// # Errors
/// [`FilmError::Input`] when the file cannot be read or decoded.
pub fn read(path: &Path) -> Result<Picture, FilmError> {
    let bytes =
        std::fs::read(path).map_err(|cause| PictureFileError::Read { path: path.to_owned(), cause })?;
    let decoded = image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Png)
        .decode()
        .map_err(|error| PictureFileError::Unusable {
            path: path.to_owned(),
            reason: format!("it is damaged or not PNG ({error}); export it again"),
        })?;
    let has_alpha = decoded.color().has_alpha();
    let pixels = decoded.into_rgba32f();
    let rgb = pixels.pixels().map(|p| [p.0[0], p.0[1], p.0[2]].map(srgb_decode)).collect();
    let mut picture = Picture::new(pixels.width(), pixels.height(), rgb);
    if has_alpha {
        picture.push_channel("", "A", pixels.pixels().map(|p| p.0[3]).collect());
    }
    Ok(picture)
}

/// A value in [0, 1] to the nearest of 256 levels.
pub(super) fn to_byte(signal: f32) -> u8 {
    (255.0 * signal).round() as u8
}

/// To the nearest of 65536 levels, the higher byte first.
fn to_bytes(signal: f32) -> [u8; 2] {
    ((65535.0 * signal).round() as u16).to_be_bytes()
}
