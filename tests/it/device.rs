//! The device layer: stitching, validation, the start-up check.

use halfway::device::shader::{Features, SOURCES, stitch, stitch_text};

use crate::gpu;

#[test]
fn n01_loops_run_to_their_end() {
    // Opening the shared context runs `loop_check.wgsl`; a driver that cuts loops fails here.
    gpu::context();
}

#[test]
fn a_kernel_of_a_test_runs() {
    let kernel = "
#import lib/math
@group(0) @binding(0) var<storage, read> input: array<f32>;
@group(0) @binding(1) var<storage, read_write> output: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&input) { output[id.x] = select(0.0, 2.0 * input[id.x], is_finite(input[id.x])); }
}";
    let input = [1.0f32, f32::INFINITY, f32::NAN, -3.0];
    let output = gpu::run(kernel, &[], &[("input", bytemuck::cast_slice(&input))], &[("output", 16)], 4);
    let output: Vec<f32> = bytemuck::pod_collect_to_vec(&output[0]);
    assert_eq!(output, [2.0, 0.0, 0.0, -6.0]);
}

#[test]
fn features_keep_and_drop_lines() {
    let text = "#if a\nconst A = 1;\n#if b\nconst B = 1;\n#else\nconst C = 1;\n#endif\n#endif\n#if !a\nconst D = 1;\n#endif\n";
    let with = |features: &[&'static str]| {
        stitch_text("t", text, &features.iter().copied().collect()).expect("balanced").code
    };
    assert_eq!(with(&[]), "const D = 1;\n");
    assert_eq!(with(&["a"]), "const A = 1;\nconst C = 1;\n");
    assert_eq!(with(&["a", "b"]), "const A = 1;\nconst B = 1;\n");
    assert!(stitch_text("t", "#if a\n", &Features::new()).is_err());
    assert!(stitch_text("t", "#endif\n", &Features::new()).is_err());
    assert!(stitch_text("t", "#import lib/none\n", &Features::new()).is_err());
}

#[test]
fn a_shader_error_names_file_and_line() {
    let broken = stitch_text(
        "broken",
        "#import lib/math\nfn f() -> f32 {\n    return missing;\n}\n",
        &Features::new(),
    );
    let message = broken.expect("directives").validate().expect_err("missing name").to_string();
    assert!(message.contains("shaders/broken.wgsl:3"), "{message}");
}

#[test]
fn every_file_is_listed_once() {
    let mut names: Vec<&str> = SOURCES.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), SOURCES.len());
    for name in names {
        stitch(name, &Features::new()).expect("directives");
    }
}
