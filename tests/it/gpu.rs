//! Running small kernels on the device.

use std::sync::OnceLock;

use bytemuck::Pod;
use halfway::device::{BufferTable, Context, DeviceChoice, Kernel, shader};

/// The device all tests share.
pub fn context() -> &'static Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(|| {
        let context = Context::new(&DeviceChoice::Auto).expect("tests need a Vulkan device");
        println!("tests run on {}", context.describe());
        context
    })
}

/// Runs a function of WGSL over inputs. `imports` are shader files; `body` is WGSL that declares
/// `fn twin(input: array<u32, I>) -> array<u32, O>`. Floats travel as bits.
pub fn map<const I: usize, const O: usize>(imports: &[&str], body: &str, inputs: &[[u32; I]]) -> Vec<[u32; O]>
where
    [u32; I]: Pod,
    [u32; O]: Pod,
{
    let imports: String = imports.iter().map(|name| format!("#import {name}\n")).collect();
    let code = format!(
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
    let context = context();
    let stitched = shader::stitch_text("twin", &code, &Default::default()).unwrap();
    let kernel = Kernel::from_stitched(context, "twin", &stitched, &[]).unwrap();
    let mut buffers = BufferTable::default();
    buffers.upload(context, "inputs", inputs).unwrap();
    let bytes = (inputs.len() * O * 4) as u64;
    buffers.create(context, "outputs", bytes).unwrap();
    let bound = kernel.bind(context, &buffers).unwrap();
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    bound.dispatch(&mut pass, inputs.len() as u32);
    drop(pass);
    context.queue.submit([encoder.finish()]);
    bytemuck::pod_collect_to_vec(&buffers.read(context, "outputs", bytes).unwrap())
}
