//! scene

use std::path::PathBuf;

use thiserror::Error;

use crate::fault::Fault;
use crate::picture_file::PictureFileError;

/// Reading a scene. `code` is the name that the Khronos glTF validator gives the fault, where it has one.
#[derive(Debug, Error)]
pub enum SceneError {
    /// A file that the scene names, or the scene itself.
    #[error("cannot read {path}: {cause}; check that the file is there and readable")]
    Read { path: PathBuf, cause: std::io::Error },
    /// A picture other than a texture, such as an environment.
    #[error(transparent)]
    Picture(#[from] PictureFileError),
    #[error(
        "the environment (brightest value {brightest}) cannot be scaled by {scale} and rotated by {rotation}; \
         give --env-scale a finite factor of at least 0, small enough for the product, and --env-rotate a finite angle"
    )]
    EnvironmentScale { scale: f32, rotation: f32, brightest: f32 },
    /// A file that is no glTF, or a damaged GLB.
    #[error("not a readable glTF file: {detail} ({code}); export or download it again")]
    Container { code: &'static str, detail: String },
    /// The JSON does not parse, or has another shape than glTF 2.0 prescribes.
    #[error("the glTF JSON is malformed: {cause}; export the file again")]
    Json { cause: serde_json::Error },
    /// Another major version of glTF.
    #[error(
        "this is glTF {version}, and only 2.0 is supported; export it again, or convert a file of 1.0 with \
         `gltf-pipeline -i in.gltf -o out.gltf`"
    )]
    Version { version: String },
    /// A URI that is refused or cannot be decoded.
    #[error("refused to read \"{uri}\": {reason}")]
    Uri { uri: String, reason: &'static str },
    /// Extensions without which the file cannot be shown; all of them, each with advice.
    #[error("the file requires extensions that are not supported: {names}")]
    Extensions { names: String },
    /// `list`: what there is.
    #[error("no variant '{wanted}'; {list}")]
    UnknownVariant { wanted: String, list: String },
    /// More than the loader is willing to hold.
    #[error("the scene has {count} {what}, more than the limit of {limit}; split or simplify it")]
    Limit { what: &'static str, count: u64, limit: u64 },
    /// A picture that cannot be decoded.
    #[error("cannot decode image {name}: {detail}; save it again as PNG, JPEG or WebP")]
    Image { name: String, detail: String },
    /// Anything in the document that breaks glTF's rules.
    #[error("{at}: {detail} ({code}); export the file again, the Khronos glTF validator shows all faults")]
    Invalid { at: String, code: &'static str, detail: String },
}

impl SceneError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Picture(error) => error.fault(),
            Self::Read { .. }
            | Self::EnvironmentScale { .. }
            | Self::Container { .. }
            | Self::Json { .. }
            | Self::Version { .. }
            | Self::Uri { .. }
            | Self::Extensions { .. }
            | Self::UnknownVariant { .. }
            | Self::Limit { .. }
            | Self::Image { .. }
            | Self::Invalid { .. } => Fault::Input,
        }
    }

    pub(crate) fn invalid(at: impl Into<String>, code: &'static str, detail: impl Into<String>) -> Self {
        Self::Invalid { at: at.into(), code, detail: detail.into() }
    }
}

/// A camera that the scene does not have, or that cannot be moved as asked for.
#[derive(Debug, Error)]
pub enum ViewpointError {
    #[error("--camera {wanted}: the scene has no camera; leave the option out to have one placed")]
    NoCamera { wanted: String },
    /// `list`: the number and name of each that there is.
    #[error("no camera {wanted}; the scene has: {list}")]
    UnknownCamera { wanted: String, list: String },
    #[error(
        "--fov is for perspective cameras, and '{camera}' is orthographic; give --ortho-height, or another --camera"
    )]
    NotPerspective { camera: String },
    #[error(
        "--ortho-height is for orthographic cameras, and '{camera}' is perspective; give --fov, or another --camera"
    )]
    NotOrthographic { camera: String },
    #[error("--fov {degrees}: give degrees above 0 and below 180, such as 40")]
    FieldOfView { degrees: f64 },
    #[error("--ortho-height {height}: give a positive height in scene units, such as 2.5")]
    Height { height: f64 },
    #[error("--look-from and --look-at are the same point; move one of them")]
    SamePoint,
    /// Points and directions as `X,Y,Z`.
    #[error(
        "no picture has {up} upright when it looks from {from} at {at}; give another direction by --look-up"
    )]
    NoUpright { up: String, from: String, at: String },
}

impl ViewpointError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::NoCamera { .. }
            | Self::UnknownCamera { .. }
            | Self::NotPerspective { .. }
            | Self::NotOrthographic { .. }
            | Self::FieldOfView { .. }
            | Self::Height { .. }
            | Self::SamePoint
            | Self::NoUpright { .. } => Fault::Input,
        }
    }
}
