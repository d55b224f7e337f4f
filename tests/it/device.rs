//! The device layer: stitching, validation, the start-up check.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex};

use halfway::device::shader::{SOURCES, stitch, stitch_text};
use halfway::device::uuid::{is_uuid, uuid};
use halfway::device::{BufferTable, Context, DeviceChoice, DeviceError, Feature, Features, Kernel};

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

/// All that was created is compiled when the first of it is bound, each once, and computes what it should.
#[test]
fn kernels_are_compiled_when_the_first_is_bound() {
    let told: Arc<Mutex<Vec<(String, usize, usize)>>> = Arc::default();
    let heard = told.clone();
    let context = Context::new(&DeviceChoice::Auto).expect("a device").telling_of_compiling(move |one| {
        heard.lock().expect("no panic").push((one.kernel.to_string(), one.done, one.of));
    });
    let kernel = |factor: u32| {
        let text = format!(
            "@group(0) @binding(0) var<storage, read_write> output: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {{ if id.x < 4u {{ output[id.x] = {factor}u * id.x; }} }}"
        );
        let stitched = stitch_text("test", &text, Features::default()).expect("directives");
        Kernel::from_stitched(&context, &format!("times-{factor}"), &stitched, &[]).expect("a valid kernel")
    };
    let kernels = [2, 3, 5, 3].map(kernel);
    assert_eq!(told.lock().expect("no panic").len(), 0);
    let mut buffers = BufferTable::default();
    buffers.create(&context, "output", 16).expect("create");
    let multiples: Vec<Vec<u32>> = kernels
        .iter()
        .map(|kernel| {
            let bound = kernel.bind(&context, &buffers).expect("all buffers named");
            let mut encoder = context.device.create_command_encoder(&Default::default());
            bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), 4);
            context.queue.submit([encoder.finish()]);
            bytemuck::pod_collect_to_vec(&buffers.read(&context, "output", 16).expect("read"))
        })
        .collect();
    assert_eq!(multiples, [2, 3, 5, 3].map(|factor| [0, factor, 2 * factor, 3 * factor]));
    let mut told = told.lock().expect("no panic").clone();
    told.sort();
    // A GPU's driver compiles what it is given.
    if context.is_cpu() {
        let names: Vec<&str> = told.iter().map(|(name, _, _)| name.as_str()).collect();
        assert_eq!(names, ["times-2", "times-3", "times-5"]);
        let counts: BTreeSet<(usize, usize)> = told.iter().map(|&(_, done, of)| (done, of)).collect();
        assert_eq!(counts, BTreeSet::from([(1, 3), (2, 3), (3, 3)]));
    } else {
        assert!(told.is_empty());
    }
}

#[test]
fn features_keep_and_drop_lines() {
    let text = "#if alpha\nconst A = 1;\n#if unlit\nconst B = 1;\n#else\nconst C = 1;\n#endif\n#endif\n\
        #if !alpha\nconst D = 1;\n#endif\n";
    let with = |features: &[Feature]| {
        stitch_text("t", text, features.iter().copied().collect()).expect("balanced").code
    };
    assert_eq!(with(&[]), "const D = 1;\n");
    assert_eq!(with(&[Feature::Alpha]), "const A = 1;\nconst C = 1;\n");
    assert_eq!(with(&[Feature::Alpha, Feature::Unlit]), "const A = 1;\nconst B = 1;\n");
}

/// Each says where it is; also in a part that is left out.
#[test]
fn directives_that_make_no_sense_are_refused() {
    for (text, line, message) in [
        ("#if alpha\n", 2, "#if without #endif"),
        ("\n#endif\n", 2, "#endif without #if"),
        ("#else\n", 1, "#else without #if"),
        ("#if alpha\n#else\n#else\n#endif\n", 3, "second #else"),
        ("#if alhpa\n#endif\n", 1, "unknown feature 'alhpa'"),
        ("#if alpha\n#if !alhpa\n#endif\n#endif\n", 2, "unknown feature 'alhpa'"),
        ("#import lib/none\n", 1, "no shader file 'lib/none'"),
        ("#include lib/rng\n", 1, "unknown directive"),
    ] {
        let error = stitch_text("t", text, Features::default()).expect_err(text).to_string();
        assert!(error.starts_with(&format!("shaders/t.wgsl:{line}: {message}")), "{text:?}: {error}");
    }
}

#[test]
fn a_shader_error_names_file_and_line() {
    let broken = stitch_text(
        "broken",
        "#import lib/math\nfn f() -> f32 {\n    return missing;\n}\n",
        Features::default(),
    );
    let message = broken.expect("directives").validate().expect_err("missing name").to_string();
    assert!(message.contains("shaders/broken.wgsl:3"), "{message}");
}

/// Shader files below a folder, as [`SOURCES`] names them.
fn shader_files(folder: &Path) -> BTreeSet<String> {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(shaders.join(folder)).expect("a folder of shaders") {
        let path = folder.join(entry.expect("an entry").file_name());
        if shaders.join(&path).is_dir() {
            found.extend(shader_files(&path));
        } else {
            let name = path.to_str().expect("a name in UTF-8");
            found.insert(name.strip_suffix(".wgsl").expect("nothing but WGSL").to_string());
        }
    }
    found
}

#[test]
fn every_file_is_listed_once() {
    let listed: BTreeSet<String> = SOURCES.iter().map(|(name, _)| (*name).to_string()).collect();
    assert_eq!(listed.len(), SOURCES.len());
    assert_eq!(listed, shader_files(Path::new("")), "SOURCES of src/device/shader.rs and the folder shaders");
    for name in listed {
        stitch(&name, Features::default()).expect("directives");
    }
}

/// A feature without an `#if` would compile the same text twice.
#[test]
fn every_feature_is_asked_for() {
    for feature in Feature::ALL {
        assert_eq!(Feature::find(feature.name()), Some(*feature));
        let asks = |line: &str| {
            line.trim()
                .strip_prefix("#if ")
                .is_some_and(|name| name.trim_start_matches('!') == feature.name())
        };
        assert!(SOURCES.iter().any(|(_, text)| text.lines().any(asks)), "no shader asks for {feature}");
    }
}

/// Software devices would end the process: what does not fit is known before.
#[test]
fn memory_that_is_not_there_is_refused_with_its_sum() {
    let mut context = gpu::context().clone();
    assert!(!context.is_cpu() || context.memory.is_some_and(|memory| memory > 1 << 20));
    context.memory = Some(1 << 20);
    let mut buffers = BufferTable::default();
    buffers.create(&context, "first", 3 << 18).unwrap();
    let error = buffers.create(&context, "second", 1 << 19).unwrap_err();
    assert!(
        matches!(error, DeviceError::OutOfMemory { total, memory, .. } if (total, memory) == (5 << 18, 1 << 20))
    );
    // What replaces a buffer does not add to it.
    buffers.create(&context, "first", 1 << 20).unwrap();
}

#[test]
fn a_device_is_found_by_its_uuid() {
    let found = uuid(&gpu::context().adapter).expect("a driver that tells it");
    assert_eq!(found.len(), 36, "{found}");
    let choice: DeviceChoice = format!("uuid:GPU-{}", found.to_uppercase()).parse().unwrap();
    assert_eq!(uuid(&Context::new(&choice).expect("the same device").adapter), Some(found.clone()));
    assert!(!is_uuid(&found, "6d1e3a0c-0000-0000-0000-000000000000"));
    let none: DeviceChoice = "uuid:6d1e3a0c".parse().unwrap();
    let said = Context::new(&none).err().expect("no such device").to_string();
    assert!(said.contains(&format!("uuid:{found}")), "{said}");
}
