//! From sums of samples to pictures on disk, and the comparison of pictures.

/// A linear RGB picture in `f32`, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RgbImage {
    pub width: u32,
    pub height: u32,
    /// `width * height` pixels, scene-linear Rec.709.
    pub pixels: Vec<[f32; 3]>,
}
