//! Radiance HDR (`.hdr`, `.pic`).
//!
//! Format: Greg Ward, Radiance reference manual, "File Formats", section "Picture File Format (.hdr suffix)".

use std::io::Cursor;

use image::codecs::hdr::HdrDecoder;

use super::{PictureFile, check_sample_count, from_rgb};

/// Begins every file. What follows on the line is the name of a program or format: `RADIANCE`, `RGBE`.
const SIGNATURE: &[u8] = b"#?";

/// Pixels are what the header says they are: the file's values divided by the product of its `EXPOSURE` lines and, for
/// each channel, of its `COLORCORR` lines.
pub(super) fn decode(bytes: &[u8]) -> Result<PictureFile, String> {
    let damaged = |error: image::ImageError| {
        format!("it is damaged or not Radiance HDR ({error}); export it again, or as OpenEXR")
    };
    if !bytes.starts_with(SIGNATURE) {
        return Err(
            "it is damaged or not Radiance HDR (it does not begin with \"#?\"); export it again".into()
        );
    }
    // The strict decoder takes one signature only, and refuses a file for any odd line of its header.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(damaged)?;
    let header = decoder.metadata();
    check_sample_count(3 * u64::from(header.width) * u64::from(header.height))?;
    let mut notes = Vec::new();
    let divisor = divisor(&header.custom_attributes, &mut notes);
    let pixels = image::DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb32f();
    let radiance = |value: f32, divisor: f64| (f64::from(value) / divisor) as f32;
    let pixels = pixels.pixels().map(|pixel| std::array::from_fn(|i| radiance(pixel.0[i], divisor[i])));
    Ok(PictureFile { notes, ..from_rgb(header.width, header.height, pixels) })
}

/// What the values of each channel were multiplied by. A line that is no number above zero is left out, with a note.
fn divisor(header: &[(String, String)], notes: &mut Vec<String>) -> [f64; 3] {
    let mut divisor = [1.0; 3];
    for (key, value) in header {
        let wanted = match key.as_str() {
            "EXPOSURE" => 1,
            "COLORCORR" => 3,
            _ => continue,
        };
        let numbers: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let usable = |number: &f64| number.is_finite() && *number > 0.0;
        if numbers.len() != wanted || !numbers.iter().all(usable) {
            notes.push(format!("its header line {key}={value} is no factor and is ignored"));
            continue;
        }
        for (factor, number) in divisor.iter_mut().zip(numbers.iter().cycle()) {
            *factor *= number;
        }
    }
    divisor
}
