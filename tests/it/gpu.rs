//! Runs a small kernel of a test on the device: WGSL text that imports `shaders/lib`, buffers in, buffers out.

use std::sync::OnceLock;

use halfway::device::shader::{Features, stitch_text};
use halfway::device::{BufferTable, Context, DeviceChoice, Kernel};

/// The device all tests share.
pub fn context() -> &'static Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(|| Context::new(&DeviceChoice::Auto).expect("a Vulkan device that computes rightly"))
}

/// Runs `kernel` (entry point `main`, workgroup size as it says) with at least `invocations` invocations.
/// `inputs`: buffers by the names of the kernel's storage variables. `outputs`: zeroed buffers by name and size
/// in bytes; their contents come back in the same order.
pub fn run(
    kernel: &str,
    features: &[&'static str],
    inputs: &[(&str, &[u8])],
    outputs: &[(&str, usize)],
    invocations: u32,
) -> Vec<Vec<u8>> {
    let context = context();
    let features: Features = features.iter().copied().collect();
    let stitched = stitch_text("test kernel", kernel, &features).expect("directives");
    let kernel = Kernel::from_stitched(context, "test kernel", &stitched, &[]).expect("a valid kernel");
    let mut buffers = BufferTable::default();
    for (name, bytes) in inputs {
        buffers.upload(context, name, bytes).expect("upload");
    }
    for (name, bytes) in outputs {
        buffers.create(context, name, *bytes as u64).expect("create");
    }
    let bound = kernel.bind(context, &buffers).expect("all buffers named");
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), invocations);
    context.queue.submit([encoder.finish()]);
    outputs.iter().map(|(name, bytes)| buffers.read(context, name, *bytes as u64).expect("read")).collect()
}
