//! Renders on disk: what their samples have come to, and what they belong to. Checkpoints and portions are such files.
//! Little endian:
//!
//! ```text
//! magic 8 bytes | version u32 | records
//! record: length of the name u32 | length of the data u64 | name | data
//! ```
//!
//! The first record, `header`, is JSON; the last, `end`, is the checksum of all bytes before it. In between are arrays, cut
//! into chunks of [`CHUNK`] numbers, each behind a byte that says how it is kept: the same number throughout (once), or in
//! half its bytes where that loses nothing, or as it is. Nothing is rounded.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::halves::{HalfPixel, HalfSums};
use super::state::{FilmState, GroupPixel};
use super::sums::{BLOCK, Earlier, FilmSums, PixelSums};
use super::write::write_atomic_with;
use super::{Attribute, FilmError, Layer};
use crate::device::layout::FilmPixel;
use crate::math::fnv::Fnv;

const MAGIC: &[u8; 8] = b"halfwayC";
/// Of the format and of what its numbers mean: raised when either changes.
const VERSION: u32 = 2;
/// Numbers that are kept alike.
const CHUNK: usize = 4096;
/// How a chunk is kept.
const SAME: u8 = 0;
const HALF: u8 = 1;
const WHOLE: u8 = 2;
/// Bytes that are written or read at once.
const BUFFER: usize = 1 << 20;
/// The longest name and header that are believed.
const LONGEST_NAME: u64 = 256;
const LONGEST_HEADER: u64 = 1 << 24;

/// Which samples of each pixel a file has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Samples {
    pub first: u32,
    /// The one after the last.
    pub next: u32,
    /// Of a portion: where it ends once it is whole.
    pub end: Option<u32>,
}

/// What a file says beside its arrays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// What the picture is of and how it is made, by name: samples of the same picture agree in all of it.
    pub picture: BTreeMap<String, String>,
    pub samples: Samples,
    /// Of the part that is rendered, pixels.
    pub size: [u32; 2],
    /// Sums times two to this are radiances.
    pub radiance_exponent: i32,
    /// What made the samples.
    pub devices: Vec<String>,
    /// The command that renders it, word by word, and the folder that it was given in.
    pub command: Vec<String>,
    pub folder: String,
    /// For the files of pictures, without what samples say themselves.
    pub metadata: Vec<(String, Attribute)>,
    /// What a render needs to go on, beside the arrays.
    pub run: serde_json::Value,
}

/// All of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedRender {
    pub header: Header,
    pub film: FilmState,
    /// Of a render that keeps halves.
    pub half: Option<HalfSums>,
    /// Layers that do not depend on samples, where this file has them.
    pub layers: Vec<Layer>,
    /// A model's file, where the method learns.
    pub model: Option<Vec<u8>>,
}

/// Bytes that a file of so many pixels takes at most, with those of `halves`, but for what noise adds to rounding (as much as
/// the sums), layers and a model.
pub fn most_bytes(pixels: u64, halves: bool) -> u64 {
    // Six sums of eight bytes; nine words of an open block, and its counts. Of a half three sums.
    pixels * (6 * 8 + 9 * 4 + 3 + if halves { 3 * 8 } else { 0 })
}

impl Header {
    /// Says in what this picture (there) and another one (here) differ, by the names of [`Header::picture`].
    pub fn differences(&self, other: &BTreeMap<String, String>) -> Vec<String> {
        let of = |picture: &BTreeMap<String, String>, name: &String| {
            picture.get(name).cloned().unwrap_or_else(|| "not given".into())
        };
        let names = self.picture.keys().chain(other.keys().filter(|name| !self.picture.contains_key(*name)));
        names
            .map(|name| (name, of(&self.picture, name), of(other, name)))
            .filter(|(_, there, here)| there != here)
            .map(|(name, there, here)| format!("{name} {there} there, {here} here"))
            .collect()
    }
}

impl SavedRender {
    /// Writes the file, or leaves an existing one as it was.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), FilmError> {
        write_atomic_with(path, |file| {
            let mut out = Writer { out: BufWriter::with_capacity(BUFFER, file), sum: Fnv::default() };
            out.bytes(MAGIC)?;
            out.bytes(&VERSION.to_le_bytes())?;
            let header = serde_json::to_vec_pretty(&self.header).map_err(io::Error::other)?;
            out.record("header", &header)?;
            self.write_arrays(&mut out)?;
            let sum = out.sum.0;
            out.record("end", &sum.to_le_bytes())?;
            out.out.flush()
        })
    }

    /// Reads the header alone, whose checksum is not looked at.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_header(path: &Path) -> Result<Header, FilmError> {
        Reader::open(path).map(|(_, header)| header)
    }

    /// Reads the whole file.
    ///
    /// # Errors
    /// A file that cannot be read, is none of these, is of another version, cut off or damaged.
    pub fn read(path: &Path) -> Result<Self, FilmError> {
        let (mut from, header) = Reader::open(path)?;
        let mut records = BTreeMap::new();
        loop {
            let sum = from.sum.0;
            let (name, data) = from.record()?;
            if name == "end" {
                match data == sum.to_le_bytes() {
                    true => break,
                    false => return Err(damaged(path, "its checksum does not fit")),
                }
            }
            records.insert(name, data);
        }
        Self::from_records(header, records).ok_or_else(|| damaged(path, "its arrays do not fit together"))
    }

    fn write_arrays(&self, out: &mut Writer<impl Write>) -> io::Result<()> {
        let FilmState { sums, open, groups } = &self.film;
        let pixels = sums.pixels.len();
        for c in 0..3 {
            out.floats(&format!("sum {c}"), pixels, |i| sums.pixels[i].sum[c])?;
            out.floats(&format!("squares {c}"), pixels, |i| sums.pixels[i].sum_sq[c])?;
        }
        out.counts("count", pixels, |i| sums.pixels[i].count)?;
        out.counts("groups", pixels, |i| sums.pixels[i].groups)?;
        out.counts("non-finite", pixels, |i| sums.pixels[i].non_finite)?;
        out.counts("rest levels", sums.rests.len(), |i| sums.rests[i].len() as u64)?;
        let levels: Vec<&[f64]> = sums.rests.iter().flatten().map(|level| level.as_flattened()).collect();
        const LEVEL: usize = 6 * BLOCK;
        out.floats("rests", levels.len() * LEVEL, |i| levels[i / LEVEL][i % LEVEL])?;
        if !sums.earlier.is_empty() {
            let earlier = &sums.earlier;
            let count = |e: &Earlier, i: usize| [e.count, e.groups, e.non_finite][i];
            out.counts("earlier counts", 3 * pixels, |i| count(&earlier[i / 3], i % 3))?;
            let sum = |e: &Earlier, i: usize| {
                let ([a, b, c], [va, vb, vc]) = (e.sum, e.variance);
                [e.weight, a, b, c, va, vb, vc][i]
            };
            out.floats("earlier sums", 7 * pixels, |i| sum(&earlier[i / 7], i % 7))?;
        }
        // Plane by plane: what is the same in all pixels takes no room.
        for (block, film) in open {
            let value = |pixel: &FilmPixel, i: usize| [pixel.sum, pixel.sum_sq, pixel.open][i / 3][i % 3];
            let values = |i: usize| f64::from(value(&film[i % pixels], i / pixels));
            out.floats(&format!("open {block} sums"), 9 * pixels, values)?;
            let count = |pixel: &FilmPixel, i: usize| [pixel.count, pixel.non_finite, pixel.open_groups][i];
            let counts = |i: usize| u64::from(count(&film[i % pixels], i / pixels));
            out.counts(&format!("open {block} counts"), 3 * pixels, counts)?;
        }
        for (index, group) in groups {
            let values = |i: usize| f64::from(group[i % pixels].sum[i / pixels]);
            out.floats(&format!("group {index} sums"), 3 * pixels, values)?;
            let count = |pixel: &GroupPixel, i: usize| [pixel.count, pixel.non_finite][i];
            let counts = |i: usize| u64::from(count(&group[i % pixels], i / pixels));
            out.counts(&format!("group {index} counts"), 2 * pixels, counts)?;
        }
        for (name, half) in
            self.half.iter().flat_map(|half| [("half", &half.pixels), ("half earlier", &half.earlier)])
        {
            let value = |pixel: &HalfPixel, i: usize| if i < 3 { pixel.sum[i] } else { pixel.weight };
            let room = half.len();
            out.floats(name, 4 * room, |i| value(&half[i % room], i / room))?;
        }
        for (layer, (name, values)) in
            self.layers.iter().flat_map(|layer| layer.channels.iter().map(move |channel| (layer, channel)))
        {
            let name = format!("layer {}.{name}", layer.name);
            out.floats(&name, values.len(), |i| f64::from(values[i]))?;
        }
        self.model.iter().try_for_each(|model| out.record("model", model))
    }

    /// `None` where the arrays do not have the lengths that they should have.
    fn from_records(header: Header, mut records: BTreeMap<String, Vec<u8>>) -> Option<Self> {
        let [width, height] = header.size;
        let pixels = (width as usize).checked_mul(height as usize)?;
        let sums_of_pixels = sums_of_pixels(&mut records, pixels)?;
        let mut take = |name: &str, count: usize| counts(&records.remove(name)?, count);
        let levels = take("rest levels", pixels.div_ceil(BLOCK))?;
        let total =
            levels.iter().try_fold(0usize, |sum, levels| sum.checked_add(usize::try_from(*levels).ok()?))?;
        let rests = self::floats(&records.remove("rests")?, total.checked_mul(6 * BLOCK)?)?;
        let mut rests =
            rests.as_chunks::<6>().0.chunks(BLOCK).map(|level| <[_; BLOCK]>::try_from(level).map(Box::new));
        let rests = levels
            .iter()
            .map(|levels| (0..*levels).map(|_| rests.next()?.ok()).collect())
            .collect::<Option<Vec<_>>>()?;
        let mut sums = FilmSums { width, height, pixels: sums_of_pixels, rests, earlier: Vec::new() };
        if let Some(data) = records.remove("earlier counts") {
            let counts = counts(&data, 3 * pixels)?;
            let values = self::floats(&records.remove("earlier sums")?, 7 * pixels)?;
            let earlier = counts.as_chunks().0.iter().zip(values.as_chunks().0);
            let earlier = earlier.map(|(&[count, groups, non_finite], &[weight, a, b, c, va, vb, vc])| {
                Earlier { count, groups, non_finite, weight, sum: [a, b, c], variance: [va, vb, vc] }
            });
            sums.earlier = earlier.collect();
        }
        let mut half = None;
        if let Some(data) = records.remove("half") {
            let earlier = records.remove("half earlier")?;
            let pixels_earlier = if earlier.is_empty() { 0 } else { pixels };
            half = Some(HalfSums {
                pixels: half_pixels(&data, pixels)?,
                earlier: half_pixels(&earlier, pixels_earlier)?,
            });
        }
        let mut film = FilmState { sums, ..FilmState::default() };
        let (mut layers, mut model) = (Vec::<Layer>::new(), None);
        for (name, data) in &records {
            match name.split(' ').collect::<Vec<_>>().as_slice() {
                ["open", block, "sums"] => {
                    let counts = counts(records.get(&format!("open {block} counts"))?, 3 * pixels)?;
                    let open = open_block(&self::floats(data, 9 * pixels)?, &counts)?;
                    film.open.insert(block.parse().ok()?, open);
                }
                ["group", index, "sums"] => {
                    let counts = counts(records.get(&format!("group {index} counts"))?, 2 * pixels)?;
                    let group = group(&self::floats(data, 3 * pixels)?, &counts)?;
                    film.groups.insert(index.parse().ok()?, group);
                }
                ["open" | "group", _, "counts"] => {}
                ["model"] => model = Some(data.clone()),
                _ => {
                    let (layer, channel) = name.strip_prefix("layer ")?.rsplit_once('.')?;
                    let values = self::floats(data, pixels)?.into_iter().map(|value| value as f32).collect();
                    let channel = (channel.to_owned(), values);
                    match layers.iter_mut().find(|other| other.name == layer) {
                        Some(layer) => layer.channels.push(channel),
                        None => layers.push(Layer { name: layer.to_owned(), channels: vec![channel] }),
                    }
                }
            }
        }
        Some(Self { header, film, half, layers, model })
    }
}

/// The planes of sums put together, without any of them being there as a whole: memory that is new each time takes longer
/// than what is done with it.
fn sums_of_pixels(records: &mut BTreeMap<String, Vec<u8>>, pixels: usize) -> Option<Vec<PixelSums>> {
    let of_channel = |name: &'static str| (0..3).map(move |c| format!("{name} {c}"));
    let names = of_channel("sum").chain(of_channel("squares"));
    let names = names.chain(["count", "groups", "non-finite"].map(String::from));
    let planes: Vec<Vec<u8>> = names.map(|name| records.remove(&name)).collect::<Option<_>>()?;
    let planes: Vec<Vec<Kept>> = planes.iter().map(|plane| kept(plane, pixels)).collect::<Option<_>>()?;
    let mut sums = vec![PixelSums::default(); pixels];
    sums.par_chunks_mut(CHUNK).enumerate().for_each(|(index, sums)| {
        let mut values = [0.0; CHUNK];
        let mut floats = |plane: usize, put: fn(&mut PixelSums) -> &mut f64| {
            planes[plane][index].fill(&mut values[..sums.len()], from_half, f64::from_bits);
            sums.iter_mut().zip(&values).for_each(|(sums, value)| *put(sums) = *value);
        };
        floats(0, |sums| &mut sums.sum[0]);
        floats(1, |sums| &mut sums.sum[1]);
        floats(2, |sums| &mut sums.sum[2]);
        floats(3, |sums| &mut sums.sum_sq[0]);
        floats(4, |sums| &mut sums.sum_sq[1]);
        floats(5, |sums| &mut sums.sum_sq[2]);
        let mut values = [0; CHUNK];
        let mut counts = |plane: usize, put: fn(&mut PixelSums) -> &mut u64| {
            planes[plane][index].fill(&mut values[..sums.len()], u64::from, |whole| whole);
            sums.iter_mut().zip(&values).for_each(|(sums, value)| *put(sums) = *value);
        };
        counts(6, |sums| &mut sums.count);
        counts(7, |sums| &mut sums.groups);
        counts(8, |sums| &mut sums.non_finite);
    });
    Some(sums)
}

/// An open block's pixels.
fn open_block(values: &[f64], counts: &[u64]) -> Option<Vec<FilmPixel>> {
    let pixels = values.len() / 9;
    (0..pixels)
        .map(|pixel| {
            let three = |first: usize| std::array::from_fn(|c| values[(first + c) * pixels + pixel] as f32);
            let word = |i: usize| u32::try_from(counts[i * pixels + pixel]).ok();
            Some(FilmPixel {
                sum: three(0),
                sum_sq: three(3),
                open: three(6),
                count: word(0)?,
                non_finite: word(1)?,
                open_groups: word(2)?,
            })
        })
        .collect()
}

fn half_pixels(data: &[u8], pixels: usize) -> Option<Vec<HalfPixel>> {
    let values = floats(data, 4 * pixels)?;
    let pixel = |i: usize| HalfPixel {
        sum: std::array::from_fn(|c| values[c * pixels + i]),
        weight: values[3 * pixels + i],
    };
    Some((0..pixels).map(pixel).collect())
}

fn group(values: &[f64], counts: &[u64]) -> Option<Vec<GroupPixel>> {
    let pixels = values.len() / 3;
    (0..pixels)
        .map(|pixel| {
            let word = |i: usize| u32::try_from(counts[i * pixels + pixel]).ok();
            let sum = std::array::from_fn(|c| values[c * pixels + pixel] as f32);
            Some(GroupPixel { sum, count: word(0)?, non_finite: word(1)? })
        })
        .collect()
}

fn damaged(path: &Path, what: &'static str) -> FilmError {
    FilmError::SavedDamaged { path: path.to_owned(), what }
}

struct Writer<W> {
    out: W,
    sum: Fnv,
}

impl<W: Write> Writer<W> {
    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sum.bytes(bytes);
        self.out.write_all(bytes)
    }

    fn record(&mut self, name: &str, data: &[u8]) -> io::Result<()> {
        self.bytes(&(name.len() as u32).to_le_bytes())?;
        self.bytes(&(data.len() as u64).to_le_bytes())?;
        self.bytes(name.as_bytes())?;
        self.bytes(data)
    }

    /// So many numbers, each asked for once, by any thread.
    fn floats(&mut self, name: &str, count: usize, value: impl Fn(usize) -> f64 + Sync) -> io::Result<()> {
        let half = |bits: u64| {
            let value = f64::from_bits(bits);
            let half = value as f32;
            (f64::from(half).to_bits() == bits).then(|| half.to_bits())
        };
        self.record(name, &chunks(count, |i| value(i).to_bits(), half))
    }

    /// As [`floats`](Self::floats).
    fn counts(&mut self, name: &str, count: usize, value: impl Fn(usize) -> u64 + Sync) -> io::Result<()> {
        self.record(name, &chunks(count, value, |value| u32::try_from(value).ok()))
    }
}

/// Numbers as they are kept. `half`: in half the bytes, where nothing is lost.
fn chunks(
    count: usize,
    value: impl Fn(usize) -> u64 + Sync,
    half: impl Fn(u64) -> Option<u32> + Sync,
) -> Vec<u8> {
    let kept = (0..count.div_ceil(CHUNK)).into_par_iter().map(|index| {
        let values: Vec<u64> = (index * CHUNK..count.min((index + 1) * CHUNK)).map(&value).collect();
        if values.iter().all(|value| *value == values[0]) {
            return [&[SAME][..], &values[0].to_le_bytes()].concat();
        }
        let halves: Vec<u32> = values.iter().map_while(|value| half(*value)).collect();
        let mut data = Vec::with_capacity(1 + 8 * values.len());
        if halves.len() == values.len() {
            data.push(HALF);
            halves.iter().for_each(|half| data.extend(half.to_le_bytes()));
        } else {
            data.push(WHOLE);
            values.iter().for_each(|value| data.extend(value.to_le_bytes()));
        }
        data
    });
    kept.collect::<Vec<_>>().concat()
}

fn floats(data: &[u8], count: usize) -> Option<Vec<f64>> {
    numbers(data, count, from_half, f64::from_bits)
}

fn counts(data: &[u8], count: usize) -> Option<Vec<u64>> {
    numbers(data, count, u64::from, |whole| whole)
}

fn from_half(half: u32) -> f64 {
    f64::from(f32::from_bits(half))
}

/// A chunk as it is kept.
struct Kept<'a> {
    how: u8,
    bytes: &'a [u8],
}

impl Kept<'_> {
    fn fill<T: Copy>(&self, numbers: &mut [T], half: impl Fn(u32) -> T, whole: impl Fn(u64) -> T) {
        let wholes = self.bytes.as_chunks().0.iter().map(|bytes| whole(u64::from_le_bytes(*bytes)));
        match self.how {
            SAME => wholes.take(1).for_each(|same| numbers.fill(same)),
            HALF => {
                let halves = self.bytes.as_chunks().0.iter().map(|bytes| half(u32::from_le_bytes(*bytes)));
                numbers.iter_mut().zip(halves).for_each(|(number, half)| *number = half);
            }
            _ => numbers.iter_mut().zip(wholes).for_each(|(number, whole)| *number = whole),
        }
    }
}

/// Where the chunks of so many numbers are, each behind the one before; what is in them any thread may read.
fn kept(mut data: &[u8], count: usize) -> Option<Vec<Kept<'_>>> {
    let mut chunks = Vec::new();
    let mut left = count;
    while left > 0 {
        let length = CHUNK.min(left);
        let (how, rest) = data.split_first()?;
        let bytes = match *how {
            SAME => 8,
            HALF => 4 * length,
            WHOLE => 8 * length,
            _ => return None,
        };
        let (bytes, rest) = rest.split_at_checked(bytes)?;
        chunks.push(Kept { how: *how, bytes });
        (data, left) = (rest, left - length);
    }
    data.is_empty().then_some(chunks)
}

/// Numbers from what [`chunks`] has made of them; memory is asked for only when all bytes are there.
fn numbers<T: Copy + Default + Send>(
    data: &[u8],
    count: usize,
    half: impl Fn(u32) -> T + Sync,
    whole: impl Fn(u64) -> T + Sync,
) -> Option<Vec<T>> {
    let kept = kept(data, count)?;
    let mut numbers = vec![T::default(); count];
    numbers.par_chunks_mut(CHUNK).zip(kept).for_each(|(numbers, kept)| kept.fill(numbers, &half, &whole));
    Some(numbers)
}

struct Reader<'a> {
    path: &'a Path,
    from: BufReader<File>,
    /// Bytes that are left.
    left: u64,
    sum: Fnv,
}

impl<'a> Reader<'a> {
    /// Opens the file and reads its header.
    fn open(path: &'a Path) -> Result<(Self, Header), FilmError> {
        let cause = |cause| FilmError::SavedRead { path: path.to_owned(), cause };
        let file = File::open(path).map_err(cause)?;
        let left = file.metadata().map_err(cause)?.len();
        let mut reader =
            Self { path, from: BufReader::with_capacity(BUFFER, file), left, sum: Fnv::default() };
        if left < 8 || reader.bytes(8)? != MAGIC {
            return Err(FilmError::NotSaved { path: path.to_owned() });
        }
        let version = reader.number(4)? as u32;
        if version != VERSION {
            return Err(FilmError::SavedVersion { path: path.to_owned(), found: version, expected: VERSION });
        }
        let no_header = || damaged(path, "its header cannot be read");
        let (name, data) = reader.record()?;
        if name != "header" || data.len() as u64 > LONGEST_HEADER {
            return Err(no_header());
        }
        let header = serde_json::from_slice(&data).map_err(|_| no_header())?;
        Ok((reader, header))
    }

    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, FilmError> {
        if count > self.left {
            return Err(damaged(self.path, "it is cut off"));
        }
        let mut bytes = vec![0; count as usize];
        let read = self.from.read_exact(&mut bytes);
        read.map_err(|cause| FilmError::SavedRead { path: self.path.to_owned(), cause })?;
        self.left -= count;
        self.sum.bytes(&bytes);
        Ok(bytes)
    }

    /// A little-endian number of so many bytes, eight at most.
    fn number(&mut self, bytes: u64) -> Result<u64, FilmError> {
        Ok(self.bytes(bytes)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn record(&mut self) -> Result<(String, Vec<u8>), FilmError> {
        let [length, bytes] = [self.number(4)?, self.number(8)?];
        if length > LONGEST_NAME {
            return Err(damaged(self.path, "a name in it is too long"));
        }
        let name = self.bytes(length)?;
        let name = String::from_utf8(name).map_err(|_| damaged(self.path, "a name in it is no text"))?;
        Ok((name, self.bytes(bytes)?))
    }
}
