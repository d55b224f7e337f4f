//! One error enum a layer. Every message says what is wrong and what to do next.

use std::path::PathBuf;

use thiserror::Error;

/// Mathematics on the host.
#[derive(Debug, PartialEq, Error)]
pub enum MathError {
    #[error(
        "nothing to draw from: the list of weights is empty; skip the distribution where there is no entry"
    )]
    NoWeights,
    #[error("{count} weights are more than the {max} that a table can hold; merge entries")]
    TooManyWeights { count: usize, max: usize },
    #[error("weight {index} is {weight}; weights must be finite and not negative")]
    BadWeight { index: usize, weight: f64 },
    #[error(
        "all {count} weights are zero, so none can be drawn; skip the distribution where nothing has weight"
    )]
    AllWeightsZero { count: usize },
}

/// Reading a scene. `code` is the name that the Khronos glTF validator gives the fault, where it has one.
#[derive(Debug, Error)]
pub enum SceneError {
    /// A file that the scene names, or the scene itself.
    #[error("cannot read {path}: {source}; check that the file is there and readable")]
    Read { path: PathBuf, source: std::io::Error },
    /// A picture other than a texture, such as an environment.
    #[error("cannot use the picture {path}: {reason}")]
    Picture { path: PathBuf, reason: String },
    #[error(
        "the environment (brightest value {brightest}) cannot be scaled by {scale} and rotated by {rotation}; \
         give --env-scale a finite factor of at least 0, small enough for the product, and --env-rotate a finite angle"
    )]
    EnvironmentScale { scale: f32, rotation: f32, brightest: f32 },
    /// A file that is no glTF, or a damaged GLB.
    #[error("not a readable glTF file: {detail} ({code}); export or download it again")]
    Container { code: &'static str, detail: String },
    /// The JSON does not parse, or has another shape than glTF 2.0 prescribes.
    #[error("the glTF JSON is malformed: {source}; export the file again")]
    Json { source: serde_json::Error },
    /// Another major version of glTF.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version { version: String },
    /// A URI that is refused or cannot be decoded.
    #[error("refused to read \"{uri}\": {reason}")]
    Uri { uri: String, reason: &'static str },
    /// Extensions without which the file cannot be shown; all of them, each with advice.
    #[error("the file requires extensions that are not supported: {names}")]
    Extensions { names: String },
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
    pub(crate) fn invalid(at: impl Into<String>, code: &'static str, detail: impl Into<String>) -> Self {
        Self::Invalid { at: at.into(), code, detail: detail.into() }
    }
}

/// Building the acceleration structure.
#[derive(Debug, Error)]
pub enum AccelError {
    #[error(
        "{count} triangles are more than one acceleration structure holds; split the scene or decimate its meshes"
    )]
    TooManyTriangles { count: usize },
}

/// The device, its shaders and its memory.
#[derive(Debug, Error)]
pub enum DeviceError {
    #[error(
        "no Vulkan device found; install a driver for your GPU, or a software one (Debian: tools/setup does it), \
         and look at the list with `halfway devices`"
    )]
    NoAdapter,
    #[error("no device fits --device {wanted}; there are:{list}")]
    NotFound { wanted: String, list: String },
    #[error("cannot open the device {name}: {message}")]
    Open { name: String, message: String },
    #[error(
        "the driver of {device} cuts loops short (counted {counts:?}, should be {expected:?}): its pictures would be \
         wrong. Mesa before 23 does this; install Mesa 25 or newer (Debian: tools/setup takes it from backports), or \
         choose another device with --device"
    )]
    CutsLoops { device: String, counts: Vec<u32>, expected: Vec<u32> },
    #[error("no shader file '{name}'; this is a defect of Halfway, please report it")]
    UnknownShader { name: String },
    #[error("learning beside the render failed: {message}; try --learn first")]
    Thread { message: String },
    #[error("{location}: {message}")]
    Shader { location: String, message: String },
    #[error("the driver refuses the kernel {kernel}: {message}")]
    Pipeline { kernel: String, message: String },
    #[error(
        "a kernel needs the buffer '{name}', which this scene does not have; this is a defect of Halfway, please report it"
    )]
    MissingBuffer { name: String },
    #[error(
        "{name} needs {bytes} bytes, the device binds at most {limit} at once; use a smaller scene, smaller textures, \
         or another device (`halfway devices`)"
    )]
    BufferTooLarge { name: String, bytes: u64, limit: u64 },
    #[error("out of device memory: {name} needs {bytes} bytes; use a smaller picture or another device")]
    OutOfMemory { name: String, bytes: u64 },
    #[error(
        "the acceleration structure is {depth} levels deep, more than {limit}: the scene's triangles lie in one another; remove duplicates"
    )]
    TreeTooDeep { depth: u32, limit: u32 },
    #[error(transparent)]
    Math(#[from] MathError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Subspace(Box<SubspaceError>),
    /// By those who asked for it; no user sees it.
    #[error("what was being rendered was abandoned")]
    Abandoned,
    #[error("the device was lost ({message}); the picture so far is what was saved last")]
    Lost { message: String },
}

impl From<SubspaceError> for DeviceError {
    fn from(error: SubspaceError) -> Self {
        Self::Subspace(Box::new(error))
    }
}

/// Pictures: reading, writing, comparing.
#[derive(Debug, Error)]
pub enum FilmError {
    #[error(transparent)]
    Input(#[from] SceneError),
    #[error(
        "cannot write {path}: {source}; choose another place or make room (an existing file is left as it was)"
    )]
    Write { path: PathBuf, source: std::io::Error },
    #[error(
        "cannot show {path}: {count} pixels are NaN or infinite; find them in the EXR, they are a bug to report"
    )]
    NonFinite { path: PathBuf, count: usize },
    #[error(
        "the picture has {} x {} pixels, the reference {} x {}; render at the reference's size (--size)",
        picture[0], picture[1], reference[0], reference[1]
    )]
    Sizes { picture: [u32; 2], reference: [u32; 2] },
    #[error(
        "pixels that are NaN or infinite: {picture} in the picture, {reference} in the reference; no metric can judge \
         them, find their cause first"
    )]
    NonFiniteCompared { picture: usize, reference: usize },
    #[error(
        "the reference is black, so no error is relative to it; check that the reference is the second file"
    )]
    BlackReference,
    #[error(
        "{count} pixels of the reference are negative, so no error is relative to them; take a reference that was \
         rendered without a filter of negative lobes"
    )]
    NegativeReference { count: usize },
    #[error(
        "cannot limit {metric}: the pictures do not say how noisy they are; compare EXR files with variance layers, as \
         `halfway render` writes them, or leave that limit out"
    )]
    MetricUnknown { metric: String },
    #[error("cannot write the report: {message}; this is a defect of Halfway, please report it")]
    Report { message: String },
    #[error("tev at {address}: {source}; start the viewer first, or give its address with --tev HOST:PORT")]
    Viewer { address: String, source: std::io::Error },
}

impl FilmError {
    /// True where the user's files or options are at fault, false where writing or a viewer failed.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::Input(_)
            | Self::Sizes { .. }
            | Self::NonFiniteCompared { .. }
            | Self::BlackReference
            | Self::NegativeReference { .. }
            | Self::MetricUnknown { .. } => true,
            Self::Write { .. } | Self::NonFinite { .. } | Self::Report { .. } | Self::Viewer { .. } => false,
        }
    }
}

/// Learning the subspaces, and the file they are kept in.
#[derive(Debug, Error)]
pub enum SubspaceError {
    #[error("the setting {name} is {value}; it must lie between {least} and {most}")]
    Setting { name: &'static str, value: f64, least: f64, most: f64 },
    #[error(
        "a training path is in tile {tile}, but the picture has {count}; this is a defect of Halfway, please report it"
    )]
    UnknownTile { tile: u32, count: usize },
    #[error(
        "a path ends on light {light}, but the scene has {count}; this is a defect of Halfway, please report it"
    )]
    UnknownLight { light: u32, count: usize },
    #[error(
        "none of {samples} vertices of {paths} light paths carries light, so there is nothing to connect to; check that \
         the scene's lights shine into it, or render with the path tracer"
    )]
    NoLight { samples: usize, paths: u64 },
    #[error(transparent)]
    Math(#[from] MathError),
    #[error(transparent)]
    Write(#[from] FilmError),
    #[error(
        "cannot read the model {path}: {source}; check that the file is there and readable, or train again (`halfway \
         train`)"
    )]
    Read { path: PathBuf, source: std::io::Error },
    #[error(
        "{path} is no model of Halfway's subspaces; give a file that `halfway train` wrote, or train again"
    )]
    NotAModel { path: PathBuf },
    #[error(
        "the model {path} has version {found} of the format, this program reads version {expected}; train again \
         (`halfway train`)"
    )]
    Version { path: PathBuf, found: u32, expected: u32 },
    #[error(
        "the model {path} was trained on another scene (or another state of this one, --env included): {found:016x} \
         where this one is {expected:016x}; train again (`halfway train`)"
    )]
    WrongScene { path: PathBuf, found: u64, expected: u64 },
    #[error(
        "the model {path} is cut off: {found} bytes where {expected} are announced; copy it again, or train again \
         (`halfway train`)"
    )]
    Truncated { path: PathBuf, found: u64, expected: u64 },
    #[error("the model {path} is damaged ({what}); copy it again, or train again (`halfway train`)")]
    Damaged { path: PathBuf, what: &'static str },
}

impl SubspaceError {
    /// True where the user's files, options or scene are at fault.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::Setting { .. }
            | Self::NoLight { .. }
            | Self::Read { .. }
            | Self::NotAModel { .. }
            | Self::Version { .. }
            | Self::WrongScene { .. }
            | Self::Truncated { .. }
            | Self::Damaged { .. } => true,
            Self::UnknownTile { .. } | Self::UnknownLight { .. } | Self::Math(_) | Self::Write(_) => false,
        }
    }
}

/// The preview window.
#[cfg(feature = "preview")]
#[derive(Debug, Error)]
pub enum PreviewError {
    #[error(
        "there is no desktop to open a window on ({message}); on a server, render to a file: halfway render SCENE -o \
         out.exr"
    )]
    NoDisplay { message: String },
    #[error(
        "the window cannot be shown ({message}); render to a file in its place: halfway render SCENE -o out.exr"
    )]
    Window { message: String },
    #[error("the window was closed before it had opened; start it again")]
    NeverOpened,
    #[error("the device was lost ({message}); what was seen last is saved, with the samples that it had")]
    Lost { message: String },
    #[error(transparent)]
    Input(#[from] crate::cli::args::InputError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// Rendering a scene to a picture.
#[derive(Debug, Error)]
pub enum RenderError {
    #[error("there is no camera {wanted}: the scene has {count} (numbered from 0); see `halfway info`")]
    NoCamera { wanted: usize, count: usize },
    #[error(
        "the part {part} (left,top,width,height) does not lie in the picture of {width}x{height} pixels; --crop takes \
         X,Y,WIDTH,HEIGHT"
    )]
    BadRegion { part: String, width: u32, height: u32 },
    #[error(
        "{width}x{height} pixels are more than a picture can have; render it in parts with a smaller --size"
    )]
    TooManyPixels { width: u32, height: u32 },
    #[error(
        "interrupted while it learnt, so there is nothing to save yet; start it again, or ask for fewer --train-paths"
    )]
    Interrupted,
    /// Comparing the picture with a reference.
    #[error(transparent)]
    Film(#[from] FilmError),
    #[error(transparent)]
    Accel(#[from] AccelError),
    #[error(transparent)]
    Device(#[from] DeviceError),
}
