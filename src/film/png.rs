//! PNG: display pictures of 8 bits per channel out, 8 or 16 bits in.

use std::io::Cursor;
use std::path::Path;

use super::tonemap::{ViewTransform, srgb_decode, srgb_encode};
use super::{Picture, write::write_atomic};
use crate::film::FilmError;
use crate::picture_file::PictureFileError;

/// Writes what the picture, [denoised](Picture::shown) where it is, looks like on a screen through `view` at `exposure` stops.
///
/// # Errors
/// [`FilmError::NonFinite`] when a pixel has no colour, [`FilmError::Write`] when the file cannot be written.
pub fn write(path: &Path, picture: &Picture, view: ViewTransform, exposure: f32) -> Result<(), FilmError> {
    let shown = picture.shown();
    let count = shown.iter().filter(|pixel| !pixel.iter().all(|value| value.is_finite())).count();
    if count > 0 {
        return Err(FilmError::NonFinite { path: path.to_owned(), count });
    }
    let pixels: Vec<[u8; 3]> = shown.iter().map(|&radiance| pixel(radiance, view, exposure)).collect();
    write_bytes(path, picture.width, picture.height, &pixels)
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
    let bytes = encode(width, height, pixels.as_flattened())
        .map_err(|error| FilmError::Write { path: path.to_owned(), cause: error.into() })?;
    write_atomic(path, &bytes)
}

fn encode(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
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
