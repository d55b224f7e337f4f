//! What a render and all that is learnt for it have in common.

use crate::film::Region;

/// Least probability that a path goes on after a surface, where none is asked for.
pub const DEFAULT_ROULETTE_CAP: f32 = 0.3;

/// The picture, where its paths end, and the seed: from the command line to the kernels, the same value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The whole picture, pixels.
    pub width: u32,
    pub height: u32,
    /// The part of it to render; `None`: all.
    pub crop: Option<Region>,
    /// Paths end after this many surfaces; `None` leaves their end to roulette.
    pub max_depth: Option<u32>,
    /// Least probability that Russian roulette lets a path go on after a surface.
    pub roulette_cap: f32,
    /// Every sample has light paths and points of its own, in place of a group's, where light paths are shared at all: as
    /// others count samples.
    pub independent: bool,
    pub seed: u64,
}

impl Default for View {
    fn default() -> Self {
        Self::sized(256, 256)
    }
}

impl View {
    /// A whole picture of that size, by default in all else.
    pub fn sized(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            crop: None,
            max_depth: None,
            roulette_cap: DEFAULT_ROULETTE_CAP,
            independent: false,
            seed: 0,
        }
    }

    /// The part that is rendered.
    pub fn region(&self) -> Region {
        self.crop.unwrap_or(Region::whole(self.width, self.height))
    }

    /// The same, of another part of another picture.
    pub fn of_region(self, region: Region) -> Self {
        Self { width: region.width, height: region.height, crop: Some(region), ..self }
    }
}
