//! Separating .glb from .gltf, and a GLB into its chunks.
//!
//! Layout: glTF 2.0, section 4 "GLB File Format".

use crate::scene::SceneError;

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// The JSON text of a file and, for a GLB, its binary chunk.
#[derive(Debug)]
pub struct Container<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
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
        Some(b'{') => Ok(Container { json, bin: None }),
        _ => Err(fault("GLB_INVALID_MAGIC", "the file begins neither with \"glTF\" nor with \"{\"".into())),
    }
}

fn split_glb(bytes: &[u8]) -> Result<Container<'_>, SceneError> {
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(fault("GLB_UNEXPECTED_END_OF_HEADER", "the file ends inside the GLB header".into()));
    };
    if version != 2 {
        return Err(fault(
            "GLB_INVALID_VERSION",
            format!("GLB version {version} is not supported, only 2 is; convert the file to glTF 2.0"),
        ));
    }
    let bytes = bytes.get(..length as usize).ok_or_else(|| {
        fault(
            "GLB_LENGTH_MISMATCH",
            format!("the header promises {length} bytes, the file has {}", bytes.len()),
        )
    })?;

    let mut json = None;
    let mut bin = None;
    let mut offset = 12;
    while offset < bytes.len() {
        let (Some(chunk_length), Some(kind)) = (word(bytes, offset), word(bytes, offset + 4)) else {
            return Err(fault("GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "a chunk header is cut off".into()));
        };
        let start = offset + 8;
        let chunk =
            bytes.get(start..).and_then(|rest| rest.get(..chunk_length as usize)).ok_or_else(|| {
                fault(
                    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
                    format!("a chunk of {chunk_length} bytes runs past the end"),
                )
            })?;
        match kind {
            CHUNK_JSON if json.is_none() => json = Some(chunk),
            CHUNK_BIN if bin.is_none() => bin = Some(chunk),
            CHUNK_JSON | CHUNK_BIN => {
                return Err(fault("GLB_DUPLICATE_CHUNK", "a JSON or BIN chunk comes twice".into()));
            }
            // The specification asks clients to ignore chunks they do not know.
            _ => {}
        }
        offset = start + chunk_length as usize;
    }
    let json = json.ok_or_else(|| fault("GLB_UNEXPECTED_FIRST_CHUNK", "there is no JSON chunk".into()))?;
    Ok(Container { json, bin })
}

/// The little-endian word at `offset`, if the bytes reach that far.
fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*word))
}

fn fault(code: &'static str, detail: String) -> SceneError {
    SceneError::Container { code, detail }
}
