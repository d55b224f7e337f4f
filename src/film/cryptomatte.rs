//! Cryptomatte: which object, or which material, covers how much of a pixel, as compositing programs read it.
//!
//! Friedman and Jones, Fully automatic ID mattes with support for motion blur and transparency, SIGGRAPH 2015 posters, and
//! the specification 1.2.0, <https://github.com/Psyop/Cryptomatte/tree/master/specification>.

use std::collections::BTreeMap;

use super::{Attribute, Picture};

/// Ids of a pixel at most: the six that cover most of it, two to a layer.
const LEVELS: usize = 3;

/// What has an id: names, and of every pixel which of them cover what share of it, in any order; a name may come more than once.
pub struct Matte<'a> {
    /// Of the layers: `CryptoObject`.
    pub layer: &'a str,
    pub names: &'a [String],
    /// Index into `names`, and share.
    pub coverage: &'a [Vec<(u32, f32)>],
}

impl Picture {
    /// Adds the layers of ids, with the metadata that lead from them to names.
    pub fn push_matte(&mut self, matte: &Matte) {
        let ids: Vec<u32> = matte.names.iter().map(|name| id(name)).collect();
        let ranked: Vec<Vec<(u32, f32)>> = matte.coverage.iter().map(|pixel| ranked(pixel, &ids)).collect();
        for level in 0..LEVELS {
            let layer = format!("{}{level:02}", matte.layer);
            for (channel, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
                let value = |pixel: &Vec<(u32, f32)>| match pixel.get(2 * level + channel / 2) {
                    Some(&(id, _)) if channel % 2 == 0 => f32::from_bits(id),
                    Some(&(_, share)) => share,
                    None => 0.0,
                };
                self.push_channel(&layer, name, ranked.iter().map(value).collect());
            }
        }
        let key = &format!("{:08x}", murmur3(matte.layer.as_bytes()))[..7];
        let manifest: BTreeMap<&str, String> =
            matte.names.iter().zip(&ids).map(|(name, id)| (name.as_str(), format!("{id:08x}"))).collect();
        let manifest = serde_json::Value::from_iter(manifest).to_string();
        for (name, value) in [
            ("name", matte.layer),
            ("hash", "MurmurHash3_32"),
            ("conversion", "uint32_to_float32"),
            ("manifest", manifest.as_str()),
        ] {
            self.metadata.push((format!("{METADATA}{key}/{name}"), Attribute::Text(value.into())));
        }
    }

    /// The metadata that lead from the ids of a layer to names; none where it has no ids.
    pub fn metadata_of_ids(&self, layer: &str) -> impl Iterator<Item = &(String, Attribute)> {
        let is_of = |value: &Attribute| matches!(value, Attribute::Text(name) if layer.strip_prefix(name.as_str()).is_some_and(is_level));
        let named = self.metadata.iter().find_map(|(name, value)| {
            let key = name.strip_prefix(METADATA)?.strip_suffix("/name")?;
            is_of(value).then(|| format!("{METADATA}{key}/"))
        });
        self.metadata
            .iter()
            .filter(move |(name, _)| named.as_ref().is_some_and(|start| name.starts_with(start)))
    }
}

/// What stands behind a matte's name in its layers' names.
fn is_level(rest: &str) -> bool {
    rest.len() == 2 && rest.bytes().all(|byte| byte.is_ascii_digit())
}

/// What entries of [`Picture::metadata`] that tell of ids begin with.
const METADATA: &str = "cryptomatte/";

/// The ids of a pixel, each once, those that cover most of it first.
fn ranked(pixel: &[(u32, f32)], ids: &[u32]) -> Vec<(u32, f32)> {
    let mut shares: Vec<(u32, f32)> = Vec::new();
    for &(name, share) in pixel {
        let id = ids[name as usize];
        match shares.iter_mut().find(|(other, _)| *other == id) {
            Some((_, sum)) => *sum += share,
            None => shares.push((id, share)),
        }
    }
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    shares
}

/// The id of a name: its hash, made a finite float that is not subnormal, as the specification has it.
fn id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ 1 << 23,
        _ => hash,
    }
}

/// `MurmurHash3_x86_32` with seed 0, Austin Appleby, public domain: <https://github.com/aappleby/smhasher>.
fn murmur3(bytes: &[u8]) -> u32 {
    let mix = |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, tail) = bytes.as_chunks::<4>();
    let mut hash = 0u32;
    for block in blocks {
        hash ^= mix(u32::from_le_bytes(*block));
        hash = hash.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let rest = tail.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
    hash ^= mix(rest);
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known vectors of the hash.
    #[test]
    fn hashes_are_those_of_the_specification() {
        for (text, hash) in [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("hello, world", 0x149b_bb7f),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(murmur3(text.as_bytes()), hash, "{text}");
        }
        // The keys of Blender's files.
        assert_eq!(murmur3(b"CryptoObject"), 0x3ae3_9a58);
        assert_eq!(murmur3(b"CryptoMaterial"), 0xbe35_9d67);
    }

    /// Ids are numbers: neither infinite nor NaN nor subnormal.
    #[test]
    fn ids_are_finite() {
        for number in 0..100_000 {
            let value = f32::from_bits(id(&format!("object {number}")));
            assert!(value.is_normal(), "{number}: {value:e}");
        }
    }
}
