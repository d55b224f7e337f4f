//! The bytes behind buffers and buffer views.

use std::borrow::Cow;
use std::path::Path;
#[cfg(feature = "compressed")]
use std::sync::OnceLock;

use gltf::json::{self, Index, buffer};

#[cfg(feature = "compressed")]
use super::document::extension;
use super::document::{Document, at};
#[cfg(feature = "compressed")]
use super::meshopt;
use super::{LoadOptions, uri};
use crate::scene::SceneError;

/// All buffers of a document, loaded.
#[derive(Debug)]
pub struct Buffers<'a> {
    document: &'a Document,
    /// Of each buffer its bytes, or what is wrong with them. `None`: a buffer without bytes of its own (the placeholder of a
    /// compression extension).
    data: Vec<Option<Result<Cow<'a, [u8]>, String>>>,
    /// Of each buffer view that is compressed, once it is asked for: its bytes, or what is wrong with them.
    #[cfg(feature = "compressed")]
    decompressed: Vec<OnceLock<Result<Vec<u8>, String>>>,
}

/// A stretch of a buffer.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    pub bytes: &'a [u8],
    /// Bytes from one element to the next; `None` where elements are packed.
    pub stride: Option<u64>,
}

impl<'a> Buffers<'a> {
    /// Loads every buffer; `bin` is the binary chunk of a GLB and belongs to buffer 0 when that has no URI. One that
    /// cannot be loaded costs what is in it, as long as there is another.
    ///
    /// # Errors
    /// Those of [`uri::fetch`], and a buffer shorter than its `byteLength`, where no buffer is left.
    pub fn load(
        document: &'a Document,
        bin: Option<&'a [u8]>,
        base_dir: Option<&Path>,
        options: &LoadOptions,
    ) -> Result<Self, SceneError> {
        let mut data = Vec::with_capacity(document.buffers.len());
        let mut total = 0_u64;
        let mut first_error = None;
        for (index, buffer) in document.buffers.iter().enumerate() {
            let bytes = match (&buffer.uri, bin) {
                (Some(uri), _) => Some(uri::fetch(uri, base_dir, options).map(Cow::Owned)),
                (None, Some(bin)) if index == 0 => Some(Ok(Cow::Borrowed(bin))),
                (None, _) => None,
            };
            let whole = bytes.map(|bytes| bytes.and_then(|bytes| check_length(buffer, index, bytes)));
            total = total.saturating_add(
                whole
                    .as_ref()
                    .map_or(0, |bytes| bytes.as_ref().map_or(0, |bytes: &Cow<'_, [u8]>| bytes.len() as u64)),
            );
            let limit = options.limits.file_bytes;
            if total > limit {
                return Err(SceneError::Limit { what: "bytes in its buffers", count: total, limit });
            }
            data.push(whole.map(|bytes| {
                bytes.map_err(|error| {
                    let text = error.to_string();
                    first_error.get_or_insert(error);
                    text
                })
            }));
        }
        let any_left = data.iter().flatten().any(Result::is_ok);
        if let Some(error) = first_error.filter(|_| !any_left) {
            return Err(error);
        }
        Ok(Self {
            document,
            data,
            #[cfg(feature = "compressed")]
            decompressed: document.buffer_views.iter().map(|_| OnceLock::new()).collect(),
        })
    }

    /// Buffer view `index`, checked against its buffer and decompressed; `from` names the place of the reference.
    ///
    /// # Errors
    /// Out-of-range references and sizes; damaged compressed bytes.
    pub fn view(&self, index: Index<buffer::View>, from: &str) -> Result<View<'_>, SceneError> {
        let view = self.document.get(index, from)?;
        let place = format!("bufferViews[{}]", index.value());
        let (offset, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
        let bytes = match self.decompressed(view, index.value(), &place)? {
            Some(bytes) => bytes,
            None => self.range(view.buffer, offset, length, &place)?,
        };
        let stride = view.byte_stride.map(|stride| stride.0);
        if let Some(stride) = stride
            && !(buffer::MIN_BYTE_STRIDE..=buffer::MAX_BYTE_STRIDE).contains(&stride)
        {
            let detail = format!("byteStride {stride} is not in 4..=252");
            return Err(SceneError::invalid(place, "VALUE_NOT_IN_RANGE", detail));
        }
        Ok(View { bytes, stride: stride.map(|stride| stride as u64) })
    }

    /// What stands in place of the bytes of a compressed view; `None` where it is none.
    #[cfg(feature = "compressed")]
    fn decompressed(
        &self,
        view: &buffer::View,
        index: usize,
        place: &str,
    ) -> Result<Option<&[u8]>, SceneError> {
        let extensions = view.extensions.as_ref().map(|extensions| &extensions.others);
        for name in meshopt::NAMES {
            let Some(what) = extension::<meshopt::Compressed>(extensions, name, place)? else { continue };
            let bytes = self.range(what.buffer, what.byte_offset, what.byte_length, place)?;
            let decoded = self.decompressed[index].get_or_init(|| meshopt::decode(&what, bytes));
            return decoded.as_ref().map(|bytes| Some(bytes.as_slice())).map_err(|detail| {
                SceneError::invalid(place, "MESHOPT_COMPRESSION", format!("{name}: {detail}"))
            });
        }
        Ok(None)
    }

    #[cfg(not(feature = "compressed"))]
    #[expect(clippy::unused_self, reason = "as where compression is built in")]
    fn decompressed(
        &self,
        _view: &buffer::View,
        _index: usize,
        _place: &str,
    ) -> Result<Option<&[u8]>, SceneError> {
        Ok(None)
    }

    /// A stretch of a buffer, checked against its length.
    fn range(
        &self,
        buffer: Index<json::Buffer>,
        offset: u64,
        length: u64,
        place: &str,
    ) -> Result<&[u8], SceneError> {
        let data = match at(&self.data, buffer, place)? {
            Some(Ok(data)) => data,
            missing => {
                return Err(SceneError::invalid(
                    format!("buffers[{}]", buffer.value()),
                    "BUFFER_MISSING_DATA",
                    match missing {
                        Some(Err(error)) => error.as_str(),
                        _ => "there is neither a uri nor a binary chunk for it",
                    },
                ));
            }
        };
        let end = offset.checked_add(length).filter(|end| *end <= data.len() as u64);
        end.map(|end| &data[offset as usize..end as usize]).ok_or_else(|| {
            SceneError::invalid(
                place,
                "BUFFER_VIEW_TOO_LONG",
                format!(
                    "offset {offset} and length {length} do not fit into the {} bytes of buffers[{}]",
                    data.len(),
                    buffer.value()
                ),
            )
        })
    }
}

/// The bytes of a buffer, if they are all there.
fn check_length<'a>(
    buffer: &json::Buffer,
    index: usize,
    bytes: Cow<'a, [u8]>,
) -> Result<Cow<'a, [u8]>, SceneError> {
    if bytes.len() as u64 >= buffer.byte_length.0 {
        return Ok(bytes);
    }
    Err(SceneError::invalid(
        format!("buffers[{index}]"),
        "BUFFER_BYTE_LENGTH_MISMATCH",
        format!("byteLength is {}, but there are {} bytes", buffer.byte_length.0, bytes.len()),
    ))
}
