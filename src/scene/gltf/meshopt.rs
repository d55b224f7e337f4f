//! Buffer views compressed by `EXT_meshopt_compression` or `KHR_meshopt_compression`, which agree in all that is read
//! here. The decoders are C++ and trust their caller's sizes, so these are checked first.

use bytemuck::Pod;
use gltf::json::{self, Index};
use meshopt::encoding as codec;
use serde::Deserialize;

/// The two names of the extension, the newer one first.
pub const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension object of a buffer view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    /// Where the compressed bytes lie.
    pub buffer: Index<json::Buffer>,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    /// Bytes of an element once decompressed.
    byte_stride: u64,
    /// Elements.
    count: u64,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// Vertices in a block at most; a block has at least a quarter of an element's bytes.
const BLOCK: u64 = 256;

/// The bytes of the buffer view.
///
/// # Errors
/// What is wrong with the extension object, or with the compressed bytes.
pub fn decode(what: &Compressed, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let (stride, length) = (what.byte_stride, bytes.len() as u64);
    // What the encodings can hold at most: an absurd count must not cost memory.
    let (fits, most) = match what.mode {
        Mode::Attributes => {
            let blocks = (4 * length).checked_div(stride).map_or(0, |blocks| blocks + 1);
            (stride.is_multiple_of(4) && (4..=256).contains(&stride), BLOCK.saturating_mul(blocks))
        }
        Mode::Triangles => (matches!(stride, 2 | 4) && what.count.is_multiple_of(3), 3 * length),
        Mode::Indices => (matches!(stride, 2 | 4), length),
    };
    let filtered = match (what.mode, what.filter) {
        (_, Filter::None) => true,
        (Mode::Attributes, Filter::Octahedral | Filter::Color) => matches!(stride, 4 | 8),
        (Mode::Attributes, Filter::Quaternion) => stride == 8,
        (Mode::Attributes, Filter::Exponential) => true,
        _ => false,
    };
    if !(fits && filtered) {
        let (mode, filter) = (what.mode, what.filter);
        return Err(format!("{} elements of {stride} bytes cannot be {mode:?} with {filter:?}", what.count));
    }
    if what.count > most {
        return Err(format!("{} elements do not fit into {length} compressed bytes", what.count));
    }
    let count = what.count as usize;
    let decoded = match (what.mode, stride) {
        (Mode::Attributes, _) => vertices(bytes, count, stride),
        (Mode::Triangles, 2) => codec::decode_index_buffer(bytes, count).map(|all: Vec<u16>| shorts(&all)),
        (Mode::Triangles, _) => codec::decode_index_buffer(bytes, count).map(|all: Vec<u32>| words(&all)),
        (Mode::Indices, 2) => codec::decode_index_sequence(bytes, count).map(|all: Vec<u16>| shorts(&all)),
        (Mode::Indices, _) => codec::decode_index_sequence(bytes, count).map(|all: Vec<u32>| words(&all)),
    };
    let mut decoded = decoded.map_err(|error| format!("the compressed bytes are damaged: {error}"))?;
    unfilter(&mut decoded, what.filter, stride);
    Ok(decoded)
}

fn shorts(all: &[u16]) -> Vec<u8> {
    all.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn words(all: &[u32]) -> Vec<u8> {
    all.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// A vertex of so many words: the decoder takes its size from the type.
#[derive(Clone, Copy)]
#[repr(transparent)]
struct Vertex<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Default for Vertex<WORDS> {
    fn default() -> Self {
        Self([0; WORDS])
    }
}

/// Bytes come in the order of memory, so words are little-endian whatever the machine.
fn sized<const WORDS: usize>(bytes: &[u8], count: usize) -> meshopt::Result<Vec<u8>> {
    let vertices: Vec<Vertex<WORDS>> = codec::decode_vertex_buffer(bytes, count)?;
    Ok(vertices.iter().flat_map(|vertex| vertex.0).flat_map(u32::to_ne_bytes).collect())
}

macro_rules! by_words {
    ($words:expr, $bytes:expr, $count:expr; $($n:literal)*) => {
        match $words {
            $($n => sized::<$n>($bytes, $count),)*
            _ => Ok(Vec::new()),
        }
    };
}

fn vertices(bytes: &[u8], count: usize, stride: u64) -> meshopt::Result<Vec<u8>> {
    by_words!(stride / 4, bytes, count;
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

/// Undoes the filter in place. Each element is decoded by itself, whatever its bytes are.
fn unfilter(bytes: &mut [u8], filter: Filter, stride: u64) {
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => in_place(bytes, codec::decode_filter_oct::<i8>),
        (Filter::Octahedral, _) => in_place(bytes, codec::decode_filter_oct::<i16>),
        (Filter::Color, 4) => in_place(bytes, codec::decode_filter_color::<u8>),
        (Filter::Color, _) => in_place(bytes, codec::decode_filter_color::<u16>),
        (Filter::Quaternion, _) => in_place(bytes, codec::decode_filter_quat),
        (Filter::Exponential, _) => in_place(bytes, codec::decode_filter_exp::<1>),
    }
}

fn in_place<T: Pod>(bytes: &mut [u8], decode: impl Fn(&mut [T])) {
    let mut elements: Vec<T> = bytemuck::pod_collect_to_vec(bytes);
    decode(&mut elements);
    bytes.copy_from_slice(bytemuck::cast_slice(&elements));
}
