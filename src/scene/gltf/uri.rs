//! Which bytes a URI may name: a glTF file is not trusted, so it reads only what lies beside it.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::LoadOptions;
use crate::scene::SceneError;

/// Longest path that a URI may spell, in bytes (PATH_MAX of Linux).
const MAX_PATH_BYTES: usize = 4096;

/// Exporters differ in whether they pad.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes that `uri` names: a `data:` URI, or a file under `base_dir` (the folder of the glTF file).
///
/// # Errors
/// [`SceneError::Uri`] for anything that leads out of the folder, directly or by symbolic link (unless
/// `allow_outside`), for other schemes and malformed URIs; [`SceneError::Read`] when the file cannot be read;
/// [`SceneError::Limit`] when it is too large.
pub fn fetch(uri: &str, base_dir: Option<&Path>, options: &LoadOptions) -> Result<Vec<u8>, SceneError> {
    if let Some(data) = strip_scheme(uri, "data:") {
        return decode_data(uri, data);
    }
    read_limited(&resolve(uri, base_dir, options)?, options)
}

/// Reads a whole regular file; refuses pipes and devices, and files larger than the limit.
pub fn read_limited(path: &Path, options: &LoadOptions) -> Result<Vec<u8>, SceneError> {
    let read_error = |cause| SceneError::Read { path: path.to_path_buf(), cause };
    // Looked at before it is opened: opening a pipe would wait for its writer.
    if !fs::metadata(path).map_err(read_error)?.is_file() {
        return Err(read_error(std::io::Error::other("not a regular file")));
    }
    let limit = options.limits.file_bytes;
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(read_error)?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(read_error)?;
    if bytes.len() as u64 > limit {
        return Err(SceneError::Limit { what: "bytes in one file", count: bytes.len() as u64, limit });
    }
    Ok(bytes)
}

fn resolve(uri: &str, base_dir: Option<&Path>, options: &LoadOptions) -> Result<PathBuf, SceneError> {
    let refuse = |reason: &'static str| SceneError::Uri { uri: shorten(uri), reason };
    let outside = || refuse("it leads out of the folder of the scene; --allow-outside permits that");

    let path = match strip_scheme(uri, "file:") {
        Some(path) if options.allow_outside => path.strip_prefix("//").unwrap_or(path),
        Some(_) => return Err(outside()),
        None if has_scheme(uri) => return Err(refuse("only data: and relative paths are read")),
        None => uri,
    };
    let path = percent_decode_str(path).decode_utf8().map_err(|_| refuse("it is not UTF-8"))?;
    if path.is_empty() || path.contains('\0') || path.len() > MAX_PATH_BYTES {
        return Err(refuse("it is empty, too long, or has a NUL in it"));
    }
    // Decoding may have brought a scheme to light ("file%3A..."); a backslash separates folders on Windows.
    if !options.allow_outside && (has_scheme(&path) || path.split(['/', '\\']).any(|part| part == "..")) {
        return Err(outside());
    }
    let path = Path::new(path.as_ref());
    let base_dir =
        base_dir.ok_or_else(|| refuse("the scene has no folder; embed the file as a data: URI"))?;
    let joined = base_dir.join(path);
    if options.allow_outside {
        return Ok(joined);
    }
    if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err(outside());
    }
    let canonical = |path: &Path| {
        path.canonicalize().map_err(|cause| SceneError::Read { path: path.to_path_buf(), cause })
    };
    let target = canonical(&joined)?;
    if !target.starts_with(canonical(base_dir)?) {
        return Err(outside());
    }
    Ok(target)
}

fn decode_data(uri: &str, data: &str) -> Result<Vec<u8>, SceneError> {
    let refuse = |reason| SceneError::Uri { uri: shorten(uri), reason };
    let (header, payload) = data.split_once(',').ok_or_else(|| refuse("a data: URI needs a comma"))?;
    if header.ends_with(";base64") {
        BASE64.decode(payload).map_err(|_| refuse("its base64 is malformed"))
    } else {
        Ok(percent_decode_str(payload).collect())
    }
}

/// The rest after `scheme`, compared without case as RFC 3986 has it.
fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let head = uri.get(..scheme.len())?;
    head.eq_ignore_ascii_case(scheme).then(|| &uri[scheme.len()..])
}

/// RFC 3986, 3.1: ALPHA *( ALPHA / DIGIT / "+" / "-" / "." ) before the first ":". A drive letter counts too.
fn has_scheme(uri: &str) -> bool {
    uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// Enough of a URI to recognise it in a message.
fn shorten(uri: &str) -> String {
    const LONGEST: usize = 120;
    if uri.chars().count() <= LONGEST {
        return uri.into();
    }
    uri.chars().take(LONGEST).chain("...".chars()).collect()
}
