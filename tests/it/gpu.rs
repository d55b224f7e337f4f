//! Runs a small kernel of a test on the device: WGSL text that imports `shaders/lib`, buffers in, buffers out.

use std::sync::{Mutex, OnceLock, PoisonError};

use clap::ValueEnum;
use halfway::device::context::adapter;
use halfway::device::shader::stitch_text;
use halfway::device::traversal::no_ray_queries;
use halfway::device::{BufferTable, Context, DeviceChoice, Feature, Kernel, Traversal};

/// Devices that no test has now.
static FREE: Mutex<Vec<&'static Context>> = Mutex::new(Vec::new());

/// A device for as long as a thread lives, which is as long as its test.
struct Lease(&'static Context);

impl Drop for Lease {
    fn drop(&mut self) {
        FREE.lock().unwrap_or_else(PoisonError::into_inner).push(self.0);
    }
}

thread_local! {
    static LEASE: Lease = {
        let free = FREE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Lease(free.unwrap_or_else(|| Box::leak(Box::new(open(traversal())))))
    };
}

/// How tests trace rays that do not say so: by kernels, or as `HALFWAY_TEST_TRAVERSAL` has it.
fn traversal() -> Traversal {
    match std::env::var("HALFWAY_TEST_TRAVERSAL") {
        Ok(name) => Traversal::from_str(&name, true).expect("auto, compute or hardware"),
        Err(_) => Traversal::Compute,
    }
}

fn open(traversal: Traversal) -> Context {
    Context::tracing(&DeviceChoice::Auto, traversal).expect("a Vulkan device that computes rightly")
}

/// A device with ray queries; `None` where there is none.
pub fn hardware() -> Option<&'static Context> {
    static HARDWARE: OnceLock<Option<Context>> = OnceLock::new();
    let has_queries = || no_ray_queries(&adapter(&DeviceChoice::Auto).expect("a device")).is_none();
    HARDWARE.get_or_init(|| has_queries().then(|| open(Traversal::Hardware))).as_ref()
}

/// The device of this test. Tests that run at the same time have one each: a software device compiles kernels on its only
/// queue, where others would wait for it.
pub fn context() -> &'static Context {
    LEASE.with(|lease| lease.0)
}

/// Runs `kernel` (entry point `main`, workgroup size as it says) with at least `invocations` invocations.
/// `inputs`: buffers by the names of the kernel's storage variables. `outputs`: zeroed buffers by name and size
/// in bytes; their contents come back in the same order.
pub fn run(
    kernel: &str,
    features: &[Feature],
    inputs: &[(&str, &[u8])],
    outputs: &[(&str, usize)],
    invocations: u32,
) -> Vec<Vec<u8>> {
    let context = context();
    let features = features.iter().copied().collect();
    let stitched = stitch_text("test kernel", kernel, features).expect("directives");
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

/// Runs a function of WGSL over inputs. `imports` are shader files; `body` declares
/// `fn twin(x: array<u32, I>) -> array<u32, O>`. Floats travel as bits.
pub fn map<const I: usize, const O: usize>(
    imports: &[&str],
    body: &str,
    inputs: &[[u32; I]],
) -> Vec<[u32; O]> {
    let imports: String = imports.iter().map(|name| format!("#import {name}\n")).collect();
    let kernel = format!(
        "{imports}
        @group(0) @binding(0) var<storage, read> inputs: array<array<u32, {I}>>;
        @group(0) @binding(1) var<storage, read_write> outputs: array<array<u32, {O}>>;
        {body}
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = id.x + id.y * 65535u * 64u;
            if index < {count}u {{
                outputs[index] = twin(inputs[index]);
            }}
        }}",
        count = inputs.len()
    );
    let bytes = bytemuck::cast_slice(inputs.as_flattened());
    let output =
        run(&kernel, &[], &[("inputs", bytes)], &[("outputs", inputs.len() * O * 4)], inputs.len() as u32);
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(&output[0]);
    words.as_chunks().0.to_vec()
}
