//! What the files of a picture hold beside it, and how.

use clap::{Args, ValueEnum};

use super::InputError;
use crate::film::exr::{Coding, Compression};
use crate::film::png::Depth;
use crate::render::{RenderOptions, SeenLayers};

/// Layers that are made where they are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExtraLayer {
    /// World position of what the pixel's first sample meets, not averaged (position.X/Y/Z).
    Position,
    /// Its texture coordinates, of the first set (uv.U/V).
    Uv,
    /// Light that comes straight from lights or shows them, and the rest (direct.R/G/B, indirect.R/G/B): their sum is the picture.
    /// Direct light is rendered once more for it.
    Direct,
    /// Ids of objects and materials, for mattes in Blender, Nuke and others (CryptoObject, CryptoMaterial).
    Cryptomatte,
}

/// How an EXR is compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Compress {
    /// Without loss.
    #[default]
    Zip,
    /// Smaller by far, colours with a loss that is hardly seen.
    Dwaa,
}

/// What the files hold.
#[derive(Args, Clone, Debug)]
pub struct OutputArgs {
    /// Denoise the finished picture with Open Image Denoise (`tools/setup --denoiser` installs it): a PNG shows the result, an
    /// EXR has it as the layer denoised beside what was rendered.
    ///
    /// The layers albedo and normal are then those of what is seen in mirrors and through smooth glass. Pictures that are saved
    /// on the way (--save-every) are not denoised. The error that is left is estimated as well, from two halves of the samples
    /// that are denoised apart; --error goes by it.
    #[arg(long)]
    pub denoise: bool,
    /// The environment lights the scene and is not seen: EXR files have the channel A (colours are multiplied by it), PNG
    /// files are transparent there. Seen through glass it stays.
    #[arg(long)]
    pub transparent: bool,
    /// Further layers of EXR files, with commas in between.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    layers: Vec<ExtraLayer>,
    /// A layer for each light (light.NAME.R/G/B): surfaces by the names of their materials, other lights by their own, and the
    /// environment. Each is rendered by itself with --spp, or with its share of --time; the picture is their sum.
    #[arg(long)]
    pub light_groups: bool,
    /// EXR files have 16-bit floats where these are enough: for colours, normals and coverage.
    #[arg(long)]
    half: bool,
    /// How EXR files are compressed.
    #[arg(long, value_enum, value_name = "HOW", default_value_t)]
    compression: Compress,
    /// EXR files have a part for each layer (rgba, albedo, ...), of which Nuke, Blender and others read only what they need.
    /// With --compression dwaa, ids, depth, positions, variance and samples have parts without losses.
    #[arg(long)]
    multi_part: bool,
    /// Bits per channel of PNG files.
    #[arg(long, value_name = "BITS", default_value_t = 8, value_parser = parse_bits)]
    png_bits: u8,
}

fn parse_bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("a PNG has 8 or 16 bits per channel".into()),
    }
}

impl OutputArgs {
    /// The options with what files of a picture need; `linear`: some hold layers.
    ///
    /// # Errors
    /// What does not go together.
    pub fn apply(&self, options: RenderOptions, linear: bool) -> Result<RenderOptions, InputError> {
        let has = |layer: ExtraLayer| self.layers.contains(&layer);
        if has(ExtraLayer::Cryptomatte) && self.compression == Compress::Dwaa && !self.multi_part {
            return Err(InputError::Usage(
                "ids of Cryptomatte do not survive a compression with losses; leave out --compression dwaa, or add \
                 --multi-part, which gives them a part without losses"
                    .into(),
            ));
        }
        if (!self.layers.is_empty() || self.light_groups) && !linear {
            return Err(InputError::Usage(
                "--layers and --light-groups need an .exr to put them in; add -o FILE.exr".into(),
            ));
        }
        Ok(RenderOptions {
            through_mirrors: self.denoise,
            // What is rendered light by light has no halves of its own.
            halves: self.denoise && !self.light_groups,
            transparent: self.transparent,
            seen: SeenLayers {
                alpha: self.transparent,
                position: has(ExtraLayer::Position),
                uv: has(ExtraLayer::Uv),
                ids: has(ExtraLayer::Cryptomatte),
            },
            ..options
        })
    }

    /// Something is wanted that only whole pictures have.
    pub fn of_pictures(&self) -> bool {
        self.denoise || self.transparent || self.light_groups || !self.layers.is_empty()
    }

    /// Direct light is a layer.
    pub fn direct(&self) -> bool {
        self.layers.contains(&ExtraLayer::Direct)
    }

    pub fn coding(&self) -> Coding {
        let compression = match self.compression {
            Compress::Zip => Compression::Zip,
            Compress::Dwaa => Compression::Dwaa,
        };
        Coding { half: self.half, compression, multi_part: self.multi_part }
    }

    pub fn depth(&self) -> Depth {
        if self.png_bits == 16 { Depth::Sixteen } else { Depth::Eight }
    }
}
