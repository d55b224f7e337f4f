//! Textures by `KHR_texture_basisu`: KTX 2.0 files of Basis Universal or plain 8-bit texels.
//!
//! Source: Khronos, KTX File Format 2.0, with its section "BasisLZ Global Data". The transcoder is C++ and knows no KTX
//! here, so what is compressed is handed to it as the `.basis` file that it was made from (`spec/basis_spec.txt` of
//! Basis Universal), and sizes are checked first.

use std::borrow::Cow;

use basis_universal::{TranscodeParameters, Transcoder, TranscoderTextureFormat};
use ktx2::{ColorModel, Format, Reader, SupercompressionScheme};
use ruzstd::decoding::FrameDecoder;

/// The first bytes of a KTX 2.0 file.
pub const MAGIC: [u8; 12] = ktx2::MAGIC;

/// Longest side, which `.basis` files have in 16 bits.
const LONGEST: u32 = 16384;

/// Width, height and texels of the largest picture in a file.
#[derive(Debug)]
pub struct Picture {
    pub size: [u32; 2],
    pub texels: Vec<[u8; 4]>,
}

/// Why there is no picture.
#[derive(Debug)]
pub enum Fault {
    /// So many pixels, more than the limit.
    TooLarge(u64),
    Unreadable(String),
}

/// Decodes the largest picture in a file.
///
/// # Errors
/// Damaged files, more pixels than `limit`, and what glTF does not allow: arrays, cubes, volumes, other formats.
pub fn decode(bytes: &[u8], limit: u64) -> Result<Picture, Fault> {
    let reader = Reader::new(bytes).map_err(|error| Fault::Unreadable(error.to_string()))?;
    let header = reader.header();
    let size @ [width, height] = [header.pixel_width, header.pixel_height];
    let pixels = u64::from(width) * u64::from(height);
    if pixels > limit {
        return Err(Fault::TooLarge(pixels));
    }
    texels(&reader, size).map(|texels| Picture { size, texels }).map_err(Fault::Unreadable)
}

fn texels(reader: &Reader<&[u8]>, size: [u32; 2]) -> Result<Vec<[u8; 4]>, String> {
    let header = reader.header();
    if header.pixel_depth > 1 || header.layer_count > 1 || header.face_count != 1 {
        return Err("it is an array, a cube or a volume, which glTF does not allow".into());
    }
    if size.iter().any(|side| !(1..=LONGEST).contains(side)) {
        return Err(format!(
            "it is {} x {} pixels, and at most {LONGEST} each way are read",
            size[0], size[1]
        ));
    }
    for (key, expected) in [("KTXorientation", "rd"), ("KTXswizzle", "rgba")] {
        let found = reader.key_value_data().find(|(name, _)| *name == key);
        if found.is_some_and(|(_, value)| value.strip_suffix(b"\0").unwrap_or(value) != expected.as_bytes()) {
            return Err(format!("its {key} is not \"{expected}\", which glTF does not allow"));
        }
    }
    let level = reader.levels().next().ok_or("it has no levels")?;
    let (scheme, model) = (header.supercompression_scheme, reader.color_model());
    if scheme == Some(SupercompressionScheme::BasisLZ) && model == Some(ColorModel::ETC1S) {
        let levels = header.level_count.max(1) as usize;
        return Basis::from_global(reader.supercompression_global_data(), levels, level.data)
            .ok_or("its BasisLZ global data is damaged, or of a video")?
            .transcode(size);
    }
    let (lanes, expected) = match header.format {
        None if model == Some(ColorModel::UASTC) => (0, blocks(size).map(u64::from).product::<u64>() * 16),
        format => {
            let lanes = plain_lanes(format).ok_or_else(|| {
                format!(
                    "its format ({format:?}, {model:?}) is neither Basis Universal nor 8 bits per channel"
                )
            })?;
            (lanes, u64::from(size[0]) * u64::from(size[1]) * lanes as u64)
        }
    };
    let data = match scheme {
        None => Cow::Borrowed(level.data),
        Some(SupercompressionScheme::Zstandard) => Cow::Owned(unpack(level.data, expected as usize)?),
        Some(other) => return Err(format!("its supercompression ({other:?}) is none that glTF allows")),
    };
    if (data.len() as u64) < expected {
        return Err(format!("it has {} bytes of {expected}", data.len()));
    }
    if lanes == 0 {
        return Basis { is_uastc: true, slices: vec![&data[..]], ..Basis::default() }.transcode(size);
    }
    Ok(data.chunks_exact(lanes).map(texel).collect())
}

/// Blocks of 4 x 4 texels each way.
fn blocks(size: [u32; 2]) -> std::array::IntoIter<u32, 2> {
    size.map(|side| side.div_ceil(4)).into_iter()
}

/// Channels of a format of 8 bits each.
fn plain_lanes(format: Option<Format>) -> Option<usize> {
    Some(match format? {
        Format::R8_UNORM | Format::R8_SRGB => 1,
        Format::R8G8_UNORM | Format::R8G8_SRGB => 2,
        Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => 3,
        Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => 4,
        _ => return None,
    })
}

/// Channels that a format does not have are 0, alpha is 1.
fn texel(channels: &[u8]) -> [u8; 4] {
    let mut texel = [0, 0, 0, u8::MAX];
    texel[..channels.len()].copy_from_slice(channels);
    texel
}

fn unpack(bytes: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut data = vec![0; size];
    let count = FrameDecoder::new()
        .decode_all(bytes, &mut data)
        .map_err(|error| format!("its Zstandard data is damaged: {error}"))?;
    data.truncate(count);
    Ok(data)
}

/// What a `.basis` file of one picture is made of.
#[derive(Default)]
struct Basis<'a> {
    /// Blocks that say all by themselves (UASTC), in place of codebooks (ETC1S).
    is_uastc: bool,
    endpoint_count: u16,
    selector_count: u16,
    /// Endpoints, selectors, tables.
    codebooks: [&'a [u8]; 3],
    /// Colours, and alpha if it is apart.
    slices: Vec<&'a [u8]>,
}

/// Little-endian numbers off the front of some bytes.
struct Numbers<'a>(&'a [u8]);

impl<'a> Numbers<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn short(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(*self.bytes(2)?.first_chunk()?))
    }

    fn word(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.bytes(4)?.first_chunk()?))
    }
}

impl<'a> Basis<'a> {
    /// From the global data of BasisLZ, which is for `levels` pictures, of which `level` is the first; nothing where
    /// that is damaged, or a frame of a video that builds on the one before.
    fn from_global(global: &'a [u8], levels: usize, level: &'a [u8]) -> Option<Self> {
        let mut numbers = Numbers(global);
        let [endpoint_count, selector_count] = [numbers.short()?, numbers.short()?];
        let lengths = [numbers.word()?, numbers.word()?, numbers.word()?];
        numbers.word()?;
        let flags = numbers.word()?;
        let slices = [[numbers.word()?, numbers.word()?], [numbers.word()?, numbers.word()?]];
        // The header has 24 bits for the lengths of the first two.
        if flags & 2 != 0 || lengths[0].max(lengths[1]) >= 1 << 24 {
            return None;
        }
        numbers.bytes(20_usize.checked_mul(levels.checked_sub(1)?)?)?;
        let [endpoints, selectors, tables] = lengths.map(|length| numbers.bytes(length as usize));
        let has_alpha = slices[1][1] > 0;
        let slices = slices[..1 + usize::from(has_alpha)]
            .iter()
            .map(|&[offset, length]| level.get(offset as usize..)?.get(..length as usize))
            .collect::<Option<_>>()?;
        let codebooks = [endpoints?, selectors?, tables?];
        Some(Self { is_uastc: false, endpoint_count, selector_count, codebooks, slices })
    }

    /// The file. Its checksums are 0, since the transcoder does not look at them.
    fn file(&self, size: [u32; 2]) -> Vec<u8> {
        const HEADER: usize = 77;
        const SLICE: usize = 23;
        let mut end = HEADER + SLICE * self.slices.len();
        let mut place = |part: &&[u8]| {
            let start = end as u64;
            end += part.len();
            (start, part.len() as u64)
        };
        let codebooks = self.codebooks.each_ref().map(&mut place);
        let slices: Vec<(u64, u64)> = self.slices.iter().map(&mut place).collect();
        let alpha_slices = if slices.len() > 1 { 4 } else { 0 };
        let mut file = Vec::with_capacity(end);
        let mut put = |bytes: usize, value: u64| file.extend_from_slice(&value.to_le_bytes()[..bytes]);
        put(2, 0x4273); // "sB"
        put(2, 0x13); // version
        put(2, HEADER as u64);
        put(2, 0);
        put(4, (end - HEADER) as u64);
        put(2, 0);
        put(3, slices.len() as u64);
        put(3, 1); // pictures
        put(1, u64::from(self.is_uastc));
        put(2, u64::from(!self.is_uastc) | alpha_slices);
        put(1, 0); // a picture in two dimensions
        put(3, 0); // that does not move
        put(8, 0); // reserved, user data
        put(4, 0); // user data
        put(2, self.endpoint_count.into());
        put(4, codebooks[0].0);
        put(3, codebooks[0].1);
        put(2, self.selector_count.into());
        put(4, codebooks[1].0);
        put(3, codebooks[1].1);
        put(4, codebooks[2].0);
        put(4, codebooks[2].1);
        put(4, HEADER as u64);
        put(8, 0); // no extension
        for (index, (start, length)) in slices.into_iter().enumerate() {
            put(3, 0); // of picture 0
            put(1, 0); // level 0
            put(1, index as u64); // alpha is the second
            size.iter().for_each(|side| put(2, u64::from(*side)));
            size.iter().for_each(|side| put(2, u64::from(side.div_ceil(4))));
            put(4, start);
            put(4, length);
            put(2, 0);
        }
        self.codebooks.iter().chain(&self.slices).for_each(|part| file.extend_from_slice(part));
        file
    }

    fn transcode(&self, size: [u32; 2]) -> Result<Vec<[u8; 4]>, String> {
        let file = self.file(size);
        let mut transcoder = Transcoder::new();
        transcoder.prepare_transcoding(&file).map_err(|()| "its codebooks are damaged")?;
        let rgba = transcoder
            .transcode_image_level(&file, TranscoderTextureFormat::RGBA32, TranscodeParameters::default())
            .map_err(|error| format!("its blocks are damaged: {error:?}"))?;
        Ok(rgba.as_chunks().0.to_vec())
    }
}
