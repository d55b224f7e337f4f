//! Pictures and how they are sampled.

/// An 8-bit RGBA picture, row 0 at the top (v = 0). Colour space is a matter of the slot that uses it:
/// base colour, emission and specular colour are sRGB, everything else is linear.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// `width * height` texels.
    pub texels: Vec<[u8; 4]>,
}

/// An image with wrap modes and filter. Filtering happens after conversion to linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index into `Scene::images`.
    pub image: u32,
    /// Wrap mode along u and v.
    pub wrap: [Wrap; 2],
    pub filter: Filter,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Wrap {
    #[default]
    Repeat = 0,
    Mirror = 1,
    Clamp = 2,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Filter {
    #[default]
    Linear = 0,
    Nearest = 1,
}
