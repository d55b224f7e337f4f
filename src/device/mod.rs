//! The device: which one, what it can do, its shaders, its memory, its clock.

pub mod buffer;
pub mod context;
mod error;
pub mod features;
pub mod host_memory;
pub mod kernels;
pub mod layout;
pub mod pages;
pub mod scene;
pub mod shader;
pub mod structure;
pub mod timing;
pub mod traversal;
pub mod uuid;

mod compiling;
mod pipelines;
mod probe;

pub use buffer::BufferTable;
pub use context::{Context, DeviceChoice};
pub use error::DeviceError;
pub use features::{Feature, Features};
pub use kernels::{Bound, Kernel};
pub use pages::{PagedBuffer, Pages};
pub use pipelines::Compiling;
pub use traversal::Traversal;
