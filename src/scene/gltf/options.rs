//! What a file may ask for.

use crate::scene::Instancing;

/// How a file is read.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Let URIs lead out of the folder of the file.
    pub allow_outside: bool,
    /// Refuse a file with any fault, where it would be shown without the part that has it.
    pub strict: bool,
    /// Name of the variant (`KHR_materials_variants`) whose materials are shown, in place of those of no variant.
    pub variant: Option<String>,
    pub instancing: Instancing,
    pub limits: Limits,
}

/// Sizes beyond which a file is refused before memory is taken for it.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Bytes of one file, and of all buffers together.
    pub file_bytes: u64,
    /// Vertices and triangles of the flattened scene.
    pub vertices: u64,
    pub triangles: u64,
    /// Pixels of one image.
    pub image_pixels: u64,
    /// Elements of an accessor that has no data (all zeros), which costs a file nothing to ask for.
    pub unbacked_elements: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 4 << 30,
            vertices: 1 << 27,
            triangles: 1 << 27,
            image_pixels: 1 << 28,
            unbacked_elements: 1 << 22,
        }
    }
}
