//! device

use thiserror::Error;

use crate::fault::Fault;
use crate::math::MathError;
use crate::scene::SceneError;

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
    #[error(
        "--traversal hardware cannot be had on {device}: {reason}; update its driver, choose another device (`halfway \
         devices` says which have ray queries), or let kernels trace: --traversal compute"
    )]
    NoRayQueries { device: String, reason: String },
    #[error(
        "--traversal hardware cannot be had for this scene: {reason}; let kernels trace it: --traversal compute, or auto"
    )]
    NoHardwareTraversal { reason: String },
    #[error(
        "the driver builds no acceleration structure for --traversal hardware: {message}; let kernels trace: --traversal \
         compute"
    )]
    AccelerationStructure { message: String },
    #[error("no shader file '{name}'; this is a defect of Halfway, please report it")]
    UnknownShader { name: String },
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
    #[error(
        "{records} records with a table of {vertices} light vertices each need {bytes} bytes, the device binds at most {limit} \
         at once; take fewer records (--record-share), fewer light paths (--light-paths), or a smaller picture"
    )]
    RecordsTooLarge { records: u32, vertices: u32, bytes: u64, limit: u64 },
    #[error(
        "the scene's buffers take {needed} bindings of {page_bytes} bytes at most in a kernel, {pages} more than small ones, and \
         this device has {limit}; use fewer or smaller textures, fewer triangles, or another device (`halfway devices`)"
    )]
    TooManyPages { pages: u32, page_bytes: u64, needed: u32, limit: u32 },
    #[error(
        "the scene needs {needed} of memory, and {free} are free (of the device: {largest}); {advice}, or use another \
         machine or device (`halfway devices`)"
    )]
    SceneTooLarge { needed: String, free: String, largest: String, advice: &'static str },
    #[error(
        "out of device memory: {name} needs {bytes} bytes, and all buffers together {total}, where {memory} are free; use a \
         smaller picture, a smaller scene, or another device"
    )]
    OutOfMemory { name: String, bytes: u64, total: u64, memory: u64 },
    #[error(
        "the acceleration structure is {depth} levels deep, more than {limit}: the scene's triangles lie in one another; remove duplicates"
    )]
    TreeTooDeep { depth: u32, limit: u32 },
    #[error(transparent)]
    Math(#[from] MathError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The caller asked for it; users do not see it.
    #[error("what was being rendered was abandoned")]
    Abandoned,
    #[error("the device was lost ({message}); the picture so far is what was saved last")]
    Lost { message: String },
}

impl DeviceError {
    /// Whose fault it is.
    pub fn fault(&self) -> Fault {
        match self {
            Self::NoAdapter
            | Self::NotFound { .. }
            | Self::Open { .. }
            | Self::CutsLoops { .. }
            | Self::NoRayQueries { .. }
            | Self::AccelerationStructure { .. } => Fault::Device,
            Self::UnknownShader { .. }
            | Self::Shader { .. }
            | Self::Pipeline { .. }
            | Self::MissingBuffer { .. } => Fault::Defect,
            Self::BufferTooLarge { .. }
            | Self::RecordsTooLarge { .. }
            | Self::TooManyPages { .. }
            | Self::SceneTooLarge { .. }
            | Self::OutOfMemory { .. }
            | Self::Lost { .. } => Fault::Machine,
            Self::TreeTooDeep { .. } | Self::NoHardwareTraversal { .. } => Fault::Input,
            Self::Math(error) => error.fault(),
            Self::Scene(error) => error.fault(),
            Self::Abandoned => Fault::Interrupted,
        }
    }
}
