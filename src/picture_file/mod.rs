//! Floating-point pictures as files hold them: named channels and attributes, from OpenEXR, Radiance HDR and PFM.
//!
//! It stands this low because both the environment light and the film read such files.

mod exr;
mod hdr;
mod pfm;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::fault::Fault;

/// Reading a picture.
#[derive(Debug, Error)]
pub enum PictureFileError {
    #[error("cannot read {path}: {cause}; check that the file is there and readable")]
    Read { path: PathBuf, cause: std::io::Error },
    /// A file that was read but makes no picture, or not one for its purpose; `reason` ends in what to do.
    #[error("cannot use the picture {path}: {reason}")]
    Unusable { path: PathBuf, reason: String },
}

impl PictureFileError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Read { .. } | Self::Unusable { .. } => Fault::Input,
        }
    }
}

/// The most samples (pixels times channels) that a file may ask for: 4 GiB of `f32`.
const MAX_SAMPLES: u64 = 1 << 30;

/// CIE xy of the Rec.709 primaries and of D65: red, green, blue, white.
pub const REC709: [[f32; 2]; 4] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// Nuke's name for the part of an OpenEXR file with what stands in no layer.
pub const MAIN_PART: &str = "rgba";

/// A named value beside the pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Attribute {
    /// UTF-8 text.
    Text(String),
    /// Any of the file's number types.
    Number(f64),
}

/// Named channels of one size, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureFile {
    pub width: u32,
    pub height: u32,
    /// Name (for example `R`, `albedo.G`) and `width * height` samples, in the file's order. In a file of several parts
    /// the name of the part comes first.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Text and numbers of the header that have no fixed meaning in the format, sorted by name.
    pub attributes: Vec<(String, Attribute)>,
    /// What of the file could not be honoured, one sentence each, already worded for the user.
    pub notes: Vec<String>,
}

/// The colours of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Colors {
    /// `width * height` pixels.
    pub rgb: Vec<[f32; 3]>,
    /// The layer that they were taken from; empty for channels that stand in none.
    pub layer: String,
    /// All layers that could be meant, in the file's order, where the file leaves that open; empty where it is clear.
    pub candidates: Vec<String>,
}

/// Separates `FILE#LAYER`: the file, and the layer if one is named. The whole is a file where there is one of that name.
pub fn split_layer(path: &Path) -> (PathBuf, Option<String>) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match name.rsplit_once('#') {
        Some((file, layer)) if !path.exists() => (path.with_file_name(file), Some(layer.to_owned())),
        _ => (path.to_owned(), None),
    }
}

impl PictureFile {
    /// Reads a file by its extension: `.exr`, `.hdr` or `.pfm`.
    ///
    /// Parts of an OpenEXR file may differ in size. What is read are those as large as the one with the colours of
    /// `layer`, or by default with the first that has colours.
    ///
    /// # Errors
    /// [`PictureFileError::Read`] when the bytes cannot be had, [`PictureFileError::Unusable`] when they make no picture:
    /// unknown extension, damaged, too large, deep or subsampled, or in primaries other than Rec.709.
    pub fn read(path: &Path, layer: Option<&str>) -> Result<Self, PictureFileError> {
        let fail = |reason: String| PictureFileError::Unusable { path: path.to_owned(), reason };
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if !matches!(extension.as_str(), "exr" | "hdr" | "pfm") {
            return Err(fail("its extension is none of .exr, .hdr, .pfm; convert it to OpenEXR".into()));
        }
        let bytes =
            std::fs::read(path).map_err(|cause| PictureFileError::Read { path: path.to_owned(), cause })?;
        let picture = match extension.as_str() {
            "exr" => exr::decode(&bytes, layer),
            "hdr" => hdr::decode(&bytes),
            _ => pfm::decode(&bytes),
        };
        picture.map_err(fail)
    }

    /// The channels `R`, `G` and `B` of a layer, or its channel `Y` thrice.
    ///
    /// Without a `layer` they are the channels that stand in none, else those of the only layer with the three, else of
    /// the only one called `Combined`, Blender's name for the finished picture, else of the first.
    ///
    /// # Errors
    /// A sentence that names the layers or channels that there are.
    pub fn colors(&self, layer: Option<&str>) -> Result<Colors, String> {
        if let Some(rgb) = self.rgb_of(layer.unwrap_or_default()) {
            return Ok(Colors { rgb, layer: layer.unwrap_or_default().to_owned(), candidates: Vec::new() });
        }
        let layers = self.color_layers();
        if let Some(wanted) = layer {
            return Err(match layers.is_empty() {
                true => format!("it has no layer '{wanted}', only the channels {}", self.channel_names()),
                false => {
                    format!("it has no layer '{wanted}' with R, G and B; those with are {}", quoted(&layers))
                }
            });
        }
        let combined = |name: &&&str| name.rsplit('.').next() == Some("Combined");
        let finished: Vec<&&str> = layers.iter().filter(combined).collect();
        let (chosen, clear) = match (layers.as_slice(), finished.as_slice()) {
            (&[only], _) | (_, &[&only]) => (only, true),
            (&[first, ..], _) => (first, false),
            ([], _) => {
                return Err(format!(
                    "it has no channels R, G and B, only {}; export it with plain RGB channels",
                    self.channel_names()
                ));
            }
        };
        Ok(Colors {
            rgb: self.rgb_of(chosen).unwrap_or_default(),
            layer: chosen.to_owned(),
            candidates: if clear { Vec::new() } else { layers.into_iter().map(str::to_owned).collect() },
        })
    }

    fn rgb_of(&self, layer: &str) -> Option<Vec<[f32; 3]>> {
        let find = |channel: &str| {
            let name = channel_name(layer, channel);
            self.channels.iter().find(|(other, _)| *other == name).map(|(_, data)| data)
        };
        match (find("R"), find("G"), find("B"), find("Y")) {
            (Some(r), Some(g), Some(b), _) => {
                Some(r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect())
            }
            (None, None, None, Some(y)) => Some(y.iter().map(|&y| [y; 3]).collect()),
            _ => None,
        }
    }

    /// Named layers with R, G and B.
    fn color_layers(&self) -> Vec<&str> {
        let has = |layer: &str, channel: &str| {
            let name = channel_name(layer, channel);
            self.channels.iter().any(|(other, _)| *other == name)
        };
        let layers = self.channels.iter().filter_map(|(name, _)| name.strip_suffix(".R"));
        layers.filter(|layer| has(layer, "G") && has(layer, "B")).collect()
    }

    fn channel_names(&self) -> String {
        self.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ")
    }
}

impl Colors {
    /// A channel of this name is one of the three that the colours were taken from.
    pub fn come_from(&self, name: &str) -> bool {
        ["R", "G", "B"].iter().any(|channel| channel_name(&self.layer, channel) == name)
    }

    /// What to tell where the file leaves open which layer is meant.
    pub fn note(&self) -> Option<String> {
        (!self.candidates.is_empty()).then(|| {
            format!(
                "it has several layers with colours: {}; '{}' is used",
                quoted(&self.candidates),
                self.layer
            )
        })
    }
}

/// The full name of a channel of a layer: `albedo.R`, or the channel's own where the layer has no name.
fn channel_name(layer: &str, channel: &str) -> String {
    if layer.is_empty() { channel.to_owned() } else { format!("{layer}.{channel}") }
}

fn quoted(names: &[impl AsRef<str>]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("'{}'", name.as_ref())).collect();
    names.join(", ")
}

fn check_sample_count(samples: u64) -> Result<(), String> {
    if samples == 0 {
        return Err("it has no pixels".into());
    }
    if samples > MAX_SAMPLES {
        return Err(format!(
            "it holds {samples} samples, more than the {MAX_SAMPLES} supported; scale it down"
        ));
    }
    Ok(())
}

fn from_rgb(width: u32, height: u32, pixels: impl Iterator<Item = [f32; 3]>) -> PictureFile {
    let count = width as usize * height as usize;
    let mut channels = ["R", "G", "B"].map(|name| (name.to_owned(), Vec::with_capacity(count)));
    for pixel in pixels {
        for (channel, value) in channels.iter_mut().zip(pixel) {
            channel.1.push(value);
        }
    }
    PictureFile { width, height, channels: channels.into(), ..PictureFile::default() }
}
