//! Portable float maps (`.pfm`).

use super::{PictureFile, check_sample_count, from_rgb};

/// Portable float map: `PF` or `Pf`, width, height, a scale whose sign is the byte order, then rows from the bottom up.
/// Its magnitude is ignored by common readers and so by this one.
pub(super) fn decode(bytes: &[u8]) -> Result<PictureFile, String> {
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
