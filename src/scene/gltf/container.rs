//! Separating .glb from .gltf, and a GLB into its chunks.
//!
//! Layout: glTF 2.0, section 4 "GLB File Format".

use std::borrow::Cow;

use gltf::binary::{ChunkType, Error, Glb};

use crate::scene::SceneError;

const MAGIC: &[u8; 4] = b"glTF";
/// Bytes of the header of a GLB.
const HEADER: usize = 12;

/// The JSON text of a file and, for a GLB, its binary chunk.
#[derive(Debug)]
pub struct Container<'a> {
    pub json: Cow<'a, [u8]>,
    pub bin: Option<Cow<'a, [u8]>>,
}

/// Splits the bytes of a file; anything that does not begin with the GLB magic is taken for JSON.
///
/// # Errors
/// [`SceneError::Container`] for an empty file, a GLB that is truncated, of another version, or without JSON.
pub fn split(bytes: &[u8]) -> Result<Container<'_>, SceneError> {
    if bytes.is_empty() {
        return Err(fault("EMPTY_FILE", "the file is empty".into()));
    }
    if bytes.starts_with(MAGIC) {
        return split_glb(bytes);
    }
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    match json.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container { json: json.into(), bin: None }),
        _ => Err(fault("GLB_INVALID_MAGIC", "the file begins neither with \"glTF\" nor with \"{\"".into())),
    }
}

fn split_glb(bytes: &[u8]) -> Result<Container<'_>, SceneError> {
    let Some(length) = word(bytes, 8) else {
        return Err(fault("GLB_UNEXPECTED_END_OF_HEADER", "the file ends inside the GLB header".into()));
    };
    // `Glb` takes its header's size off the length unseen, and would read on to the end of the file.
    let bytes = bytes.get(..length as usize).filter(|bytes| bytes.len() >= HEADER).ok_or_else(|| {
        fault(
            "GLB_LENGTH_MISMATCH",
            format!("the header promises {length} bytes, the file has {}", bytes.len()),
        )
    })?;
    let error = match Glb::from_slice(bytes) {
        Ok(Glb { json, bin, .. }) => return Ok(Container { json, bin }),
        Err(gltf::Error::Binary(error)) => error,
        Err(error) => return Err(fault("GLB_INVALID", error.to_string())),
    };
    let (code, detail) = match error {
        Error::Version(version) => (
            "GLB_INVALID_VERSION",
            format!("GLB version {version} is not supported, only 2 is; convert the file to glTF 2.0"),
        ),
        Error::ChunkLength { length, .. } => {
            ("GLB_UNEXPECTED_END_OF_CHUNK_DATA", format!("a chunk of {length} bytes runs past the end"))
        }
        // The specification asks clients to ignore chunks they do not know, and BIN may only be the second.
        Error::UnknownChunkType(_) if bytes.get(16..20) == Some(b"JSON") => {
            let end = HEADER + 8 + word(bytes, HEADER).map_or(0, |length| length as usize);
            return Ok(Container { json: bytes.get(HEADER + 8..end).unwrap_or_default().into(), bin: None });
        }
        Error::UnknownChunkType(_) | Error::ChunkType(ChunkType::Bin) => {
            ("GLB_UNEXPECTED_FIRST_CHUNK", "there is no JSON chunk".into())
        }
        Error::ChunkType(ChunkType::Json) => ("GLB_DUPLICATE_CHUNK", "a JSON chunk comes twice".into()),
        Error::Io(_) => ("GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "a chunk header is cut off".into()),
        Error::Magic(_) | Error::Length { .. } => ("GLB_LENGTH_MISMATCH", error.to_string()),
    };
    Err(fault(code, detail))
}

/// The little-endian word at `offset`, if the bytes reach that far.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*word))
}

fn fault(code: &'static str, detail: String) -> SceneError {
    SceneError::Container { code, detail }
}
