//! Pictures from files of any kind.

use std::path::Path;

use super::{Attribute, FilmError, Picture, VARIANCE_SCALE, png};
use crate::picture_file::{PictureFile, PictureFileError};

impl Picture {
    /// Reads `.exr`, `.hdr`, `.pfm`, or `.png` (sRGB decoded to linear).
    ///
    /// # Errors
    /// [`FilmError::Input`] when the file cannot be read, is damaged, or has no colours.
    pub fn read(path: &Path) -> Result<Self, FilmError> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
            return png::read(path);
        }
        let file = PictureFile::read(path)?;
        let rgb =
            file.rgb().map_err(|reason| PictureFileError::Unusable { path: path.to_owned(), reason })?;
        let mut picture = Self::new(file.width, file.height, rgb);
        picture.metadata = file.attributes;
        picture.variance_scale = match picture.attribute(VARIANCE_SCALE) {
            Some(&Attribute::Number(scale)) => Some(scale),
            _ => None,
        };
        picture.metadata.retain(|(name, _)| name != VARIANCE_SCALE);
        for (name, samples) in file.channels {
            if !matches!(name.as_str(), "R" | "G" | "B") {
                let (layer, channel) = name.rsplit_once('.').unwrap_or(("", &name));
                picture.push_channel(layer, channel, samples);
            }
        }
        Ok(picture)
    }
}
