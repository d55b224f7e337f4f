//! Pictures from files of any kind.

use std::path::Path;

use super::{Attribute, FilmError, Picture, VARIANCE_SCALE, png};
use crate::picture_file::{PictureFile, PictureFileError, split_layer};

impl Picture {
    /// Reads `.exr`, `.hdr`, `.pfm`, or `.png` (sRGB decoded to linear). Of several layers with colours in an EXR, the
    /// one that [`PictureFile::colors`] prefers becomes the picture, with a warning in the log where that is not clear;
    /// `FILE#LAYER` takes the named one, without the variance, which is not of that layer.
    ///
    /// # Errors
    /// [`FilmError::Input`] when the file cannot be read, is damaged, or has no colours.
    pub fn read(path: &Path) -> Result<Self, FilmError> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return png::read(path);
        }
        let (path, layer) = split_layer(path);
        let path = path.as_path();
        let file = PictureFile::read(path, layer.as_deref())?;
        let colors = file
            .colors(layer.as_deref())
            .map_err(|reason| PictureFileError::Unusable { path: path.to_owned(), reason })?;
        for note in file.notes.iter().cloned().chain(colors.note()) {
            log::warn!("{}: {note}", path.display());
        }
        let others: Vec<_> = file.channels.into_iter().filter(|(name, _)| !colors.come_from(name)).collect();
        let mut picture = Self::new(file.width, file.height, colors.rgb);
        picture.metadata = file.attributes;
        picture.variance_scale = match picture.attribute(VARIANCE_SCALE) {
            Some(&Attribute::Number(scale)) => Some(scale),
            _ => None,
        };
        picture.metadata.retain(|(name, _)| name != VARIANCE_SCALE);
        for (name, samples) in others {
            let (layer, channel) = name.rsplit_once('.').unwrap_or(("", &name));
            picture.push_channel(layer, channel, samples);
        }
        picture.layers.retain(|other| layer.is_none() || other.name != "variance");
        Ok(picture)
    }
}
