//! OpenEXR in: any parts, layers, number types and compressions of flat pictures.

use std::io::Cursor;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{AnyChannels, FlatSamples, Layer as Part, MetaData, ReadChannels, ReadLayers, Vec2, read};

use super::{Attribute, MAIN_PART, PictureFile, REC709, channel_name, check_sample_count};

/// How far declared chromaticities may lie from [`REC709`] in x or y; published values have three to four digits.
const CHROMATICITY_TOLERANCE: f32 = 2e-3;

/// `layer`: what the size is that of, where parts differ.
pub(super) fn decode(bytes: &[u8], layer: Option<&str>) -> Result<PictureFile, String> {
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

    let several = image.layer_data.len() > 1;
    let size = image.layer_data[part_with_colors(&image.layer_data, layer)].size;
    let mut picture =
        PictureFile { width: size.width() as u32, height: size.height() as u32, ..PictureFile::default() };
    collect_attributes(&image.attributes.other, &mut picture.attributes);
    for part in image.layer_data.into_iter().filter(|part| part.size == size) {
        collect_attributes(&part.attributes.other, &mut picture.attributes);
        let names = full_names(&part, several);
        for (name, channel) in names.into_iter().zip(part.channel_data.list) {
            let samples = match channel.sample_data {
                FlatSamples::F32(samples) => samples,
                other => other.values_as_f32().collect(),
            };
            picture.channels.push((name, samples));
        }
    }
    picture.attributes.sort_by(|a, b| a.0.cmp(&b.0));
    // Parts may say the same.
    picture.attributes.dedup();
    Ok(picture)
}

/// The names of a part's channels. Where a file has several named parts, the part's name comes first, unless the
/// channels have it in front themselves, or it is that of the [`MAIN_PART`].
fn full_names(part: &Part<AnyChannels<FlatSamples>>, several: bool) -> Vec<String> {
    let part_name = match &part.attributes.layer_name {
        Some(name) if several && name.as_slice() != MAIN_PART.as_bytes() => utf8(name),
        _ => String::new(),
    };
    let in_front = format!("{part_name}.");
    let full_name =
        |name: String| if name.starts_with(&in_front) { name } else { channel_name(&part_name, &name) };
    part.channel_data.list.iter().map(|channel| full_name(utf8(&channel.name))).collect()
}

/// The first part that has the red channel of the layer, by default of any; the first one where none has.
fn part_with_colors(parts: &[Part<AnyChannels<FlatSamples>>], layer: Option<&str>) -> usize {
    let several = parts.len() > 1;
    let red = |name: &String| match layer {
        Some(layer) => *name == channel_name(layer, "R"),
        None => name == "R" || name.ends_with(".R"),
    };
    parts.iter().position(|part| full_names(part, several).iter().any(red)).unwrap_or(0)
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
