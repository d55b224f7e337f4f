//! The glTF loader on files that are right.

use std::path::Path;

use glam::{DVec3, Vec2, Vec3, Vec4};
use halfway::scene::gltf::{LoadOptions, load, load_slice};
use halfway::scene::{LightKind, Material, Mesh, Projection};
use image::{DynamicImage, ImageFormat};
use serde_json::json;

use crate::gltf_file::{F32, GltfFile, I8, I16, U8, U16, U32, encode};

/// The public scenes beside the project, where they are present.
#[test]
fn public_scenes_load() {
    let folder = std::env::var("HALFWAY_SCENES").map_or_else(
        |_| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        |folder| folder.into(),
    );
    let expected = [("cornell_diffuse", 36), ("veach_ajar_diffuse", 23_444), ("veach_ajar_full", 23_444)];
    for (name, triangles) in expected {
        let path = folder.join(name).with_extension("glb");
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let scene = load(&path, &LoadOptions::default()).unwrap();
        println!(
            "{name}: {} triangles, {} meshes, {} materials, {} images, {:?}, {:?}",
            scene.triangle_count(),
            scene.meshes.len(),
            scene.materials.len(),
            scene.images.len(),
            scene.resolution,
            scene.warnings
        );
        assert_eq!(scene.triangle_count(), triangles);
        assert_eq!(scene.cameras.len(), 1);
        assert!(scene.resolution.is_some());
        let emissive = scene
            .meshes
            .iter()
            .filter(|mesh| scene.materials[mesh.material as usize].emission.max_element() > 0.0);
        assert_eq!(emissive.map(|mesh| mesh.triangles.len()).sum::<usize>(), 2);
    }
}

fn close(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-6 * b.length().max(1.0)
}

fn triangle_normal(mesh: &Mesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.triangles[triangle].map(|vertex| mesh.positions[vertex as usize]);
    (b - a).cross(c - a).normalize()
}

/// One component per element, every type, normalised or not, packed and strided.
#[test]
fn accessors_of_all_kinds() {
    // The same corner as each type writes it; positions may be any of these (KHR_mesh_quantization).
    let cases: [(u64, bool, &[u8], [f64; 3]); 9] = [
        (I8, false, &[0x80, 0x7f, 0xff], [-128.0, 127.0, -1.0]),
        (I8, true, &[0x80, 0x7f, 0xff], [-1.0, 1.0, -1.0 / 127.0]),
        (U8, false, &[0, 1, 255], [0.0, 1.0, 255.0]),
        (U8, true, &[0, 51, 255], [0.0, 0.2, 1.0]),
        (I16, false, &[0, 0x80, 0xff, 0x7f, 0xff, 0xff], [-32768.0, 32767.0, -1.0]),
        (I16, true, &[0, 0x80, 0xff, 0x7f, 0xff, 0xff], [-1.0, 1.0, -1.0 / 32767.0]),
        (U16, false, &[0, 0, 1, 2, 255, 255], [0.0, 513.0, 65535.0]),
        (U16, true, &[0, 0, 0x33, 0x33, 255, 255], [0.0, 0.2, 1.0]),
        (F32, false, &[0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3e], [1.0, -2.0, 0.125]),
    ];
    for (component, normalized, bytes, expected) in cases {
        for stride in [None, Some(bytes.len().next_multiple_of(4)), Some(52), Some(252)] {
            let mut file = GltfFile::triangle();
            let step = stride.unwrap_or(bytes.len());
            // The last element ends with its own bytes, not with its stride.
            let mut data = vec![0xAA_u8; 4 + 2 * step + bytes.len()];
            for element in 0..3 {
                data[4 + element * step..][..bytes.len()].copy_from_slice(bytes);
            }
            let accessor = file.accessor(&data, component, "VEC3", 3);
            file.json["accessors"][accessor]["byteOffset"] = json!(4);
            file.json["accessors"][accessor]["normalized"] = json!(normalized);
            if let Some(stride) = stride {
                file.json["bufferViews"][accessor]["byteStride"] = json!(stride);
            }
            file.attribute("POSITION", accessor);
            for position in &file.scene().meshes[0].positions {
                assert_eq!(*position, DVec3::from(expected), "{component} {normalized} {stride:?}");
            }
        }
    }
}

#[test]
fn accessors_sparse_and_without_data() {
    for (component, indices) in
        [(U8, vec![0, 2]), (U16, vec![0, 0, 2, 0]), (U32, vec![0, 0, 0, 0, 2, 0, 0, 0])]
    {
        let mut file = GltfFile::triangle();
        let indices = file.view(&indices);
        let bytes: Vec<u8> =
            [7.0_f32, 8.0, 9.0, -1.0, -2.0, -3.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let values = file.view(&bytes);
        let sparse = json!({
            "count": 2,
            "indices": {"bufferView": indices, "componentType": component},
            "values": {"bufferView": values},
        });
        file.json["accessors"][0]["sparse"] = sparse.clone();
        let expected = [DVec3::new(7.0, 8.0, 9.0), DVec3::X, DVec3::new(-1.0, -2.0, -3.0)];
        assert_eq!(file.scene().meshes[0].positions, expected);
        // Without a buffer view the rest is zero.
        file.json["accessors"][0] =
            json!({"componentType": F32, "type": "VEC3", "count": 3, "sparse": sparse});
        assert_eq!(file.scene().meshes[0].positions, [expected[0], DVec3::ZERO, expected[2]]);
    }
}

#[test]
fn triangles_from_all_modes_and_index_types() {
    let mut file = GltfFile::triangle();
    let corners: Vec<f32> = (0..6).flat_map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    let positions = file.floats("VEC3", &corners);
    file.attribute("POSITION", positions);
    let triangles = |file: &GltfFile| file.scene().meshes[0].triangles.clone();
    assert_eq!(triangles(&file), [[0, 1, 2], [3, 4, 5]]);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    assert_eq!(triangles(&file), [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(6);
    assert_eq!(triangles(&file), [[1, 2, 0], [2, 3, 0], [3, 4, 0], [4, 5, 0]]);
    file.json["meshes"][0]["primitives"][0]["mode"] = json!(4);
    let u16s = [5_u16, 4, 3].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>();
    let u32s = [5_u32, 4, 3].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>();
    for (component, bytes) in [(U8, vec![5, 4, 3]), (U16, u16s), (U32, u32s)] {
        let indices = file.accessor(&bytes, component, "SCALAR", 3);
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert_eq!(triangles(&file), [[5, 4, 3]]);
    }
}

#[test]
fn points_and_lines_are_counted() {
    let mut file = GltfFile::triangle();
    let primitive = |mode: u64| json!({"attributes": {"POSITION": 0}, "mode": mode});
    file.json["meshes"][0]["primitives"] =
        (0..=4).map(primitive).chain([json!({"attributes": {}})]).collect();
    let scene = file.scene();
    assert_eq!(scene.triangle_count(), 1);
    let problems: Vec<&str> = scene.warnings.iter().map(|warning| warning.problem.as_str()).collect();
    assert_eq!(
        problems,
        ["1 primitives of points", "3 primitives of lines", "1 primitives without POSITION"]
    );
}

#[test]
fn containers_agree() {
    let mut file = GltfFile::triangle();
    file.json["extras"] = json!({"resolution": [320, 200]});
    let embedded = file.scene();
    let glb = load_slice(&file.glb(), None, &LoadOptions::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let beside = load(&file.write(folder.path()), &LoadOptions::default()).unwrap();
    assert_eq!(beside.name, "scene");
    for scene in [embedded, glb, beside] {
        assert_eq!(scene.meshes[0].positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
        assert_eq!(scene.resolution, Some([320, 200]));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!(scene.materials, [Material { name: "default".into(), ..Material::default() }]);
    }
    file.json["extras"] = json!({"resolution": [0, "a"]});
    let scene = file.scene();
    assert_eq!((scene.resolution, scene.warnings.len()), (None, 1));
}

#[test]
fn nodes_in_double_precision() {
    let mut file = GltfFile::triangle();
    // 2^24 + 1/3 needs more than single precision; a quarter turn about z and a scale on top.
    let far = f64::from(1 << 24) + 1.0 / 3.0;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.json["nodes"] = json!([
        {"translation": [far, 0, 0], "children": [1]},
        {"rotation": [0, 0, half, half], "scale": [2, 3, 4], "mesh": 0},
    ]);
    let mesh = &file.scene().meshes[0];
    let expected = [DVec3::new(far, 0.0, 0.0), DVec3::new(far, 2.0, 0.0), DVec3::new(far - 3.0, 0.0, 0.0)];
    for (position, expected) in mesh.positions.iter().zip(expected) {
        assert!((*position - expected).length() <= 1e-8, "{position} {expected}");
    }
    // The same as matrices, columns first.
    file.json["nodes"] = json!([
        {"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, far,0,0,1], "children": [1]},
        {"matrix": [0,2,0,0, -3,0,0,0, 0,0,4,0, 0,0,0,1], "mesh": 0},
    ]);
    assert_eq!(file.scene().meshes[0].positions, expected);
}

#[test]
fn scene_choice() {
    let mut file = GltfFile::triangle();
    file.json["nodes"] =
        json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b"}, {"mesh": 0, "name": "c"}]);
    let names =
        |file: &GltfFile| file.scene().meshes.iter().map(|mesh| mesh.name.clone()).collect::<String>();
    assert_eq!(names(&file), "abc");
    file.json["scenes"] = json!([{"nodes": [1]}, {"nodes": [2, 0]}]);
    assert_eq!(names(&file), "b");
    file.json["scene"] = json!(1);
    assert_eq!(names(&file), "ca");
}

#[test]
fn nothing_to_see_is_said() {
    let scene = GltfFile::empty().scene();
    assert_eq!((scene.meshes.len(), scene.cameras.len(), scene.lights.len()), (0, 0, 0));
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].problem.contains("no mesh to see"), "{}", scene.warnings[0]);
    assert_eq!(
        load_slice(br#"{"asset":{"version":"2.0"}}"#, None, &LoadOptions::default()).unwrap().meshes.len(),
        0
    );
}

/// Fronts stay fronts and normals stay on their side under a mirroring transform; tangent space keeps its hand.
#[test]
fn negative_scale_turns_winding() {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let tangents = file.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    file.attribute("NORMAL", normals);
    file.attribute("TANGENT", tangents);
    let picture = encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png);
    let texture = file.texture(&picture);
    let uvs = file.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    file.attribute("TEXCOORD_0", uvs);
    file.material(json!({"normalTexture": {"index": texture}}));
    let cases = [
        ([1.0, 1.0, 1.0], [0, 1, 2], DVec3::Z, Vec4::new(1.0, 0.0, 0.0, 1.0)),
        ([-2.0, 1.0, 1.0], [0, 2, 1], DVec3::Z, Vec4::new(-1.0, 0.0, 0.0, -1.0)),
        ([1.0, 1.0, -3.0], [0, 2, 1], DVec3::NEG_Z, Vec4::new(1.0, 0.0, 0.0, -1.0)),
        ([-1.0, -1.0, 1.0], [0, 1, 2], DVec3::Z, Vec4::new(-1.0, 0.0, 0.0, 1.0)),
        ([-1.0, -1.0, -1.0], [0, 2, 1], DVec3::NEG_Z, Vec4::new(-1.0, 0.0, 0.0, -1.0)),
    ];
    for (scale, triangle, normal, tangent) in cases {
        file.json["nodes"][0]["scale"] = json!(scale);
        let mesh = &file.scene().meshes[0];
        assert_eq!(mesh.triangles, [triangle], "{scale:?}");
        assert_eq!(mesh.normals.as_ref().unwrap()[0].as_dvec3(), normal, "{scale:?}");
        assert_eq!(triangle_normal(mesh, 0), normal, "{scale:?}");
        assert_eq!(mesh.tangents.as_ref().unwrap()[0], tangent, "{scale:?}");
    }
}

#[test]
fn normals_by_inverse_transpose() {
    let mut file = GltfFile::triangle();
    // The plane x + y = 1 squeezed by 100 in x: its normal leans towards x. Once more at a scale where plain
    // cofactors would overflow.
    let positions = file.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
    let normals = file.floats("VEC3", &[1.0, 1.0, 0.0].repeat(3));
    file.attribute("POSITION", positions);
    file.attribute("NORMAL", normals);
    for scale in [[0.01, 1.0, 1.0], [1e198, 1e200, 1e200]] {
        file.json["nodes"][0]["scale"] = json!(scale);
        let mesh = &file.scene().meshes[0];
        let normal = mesh.normals.as_ref().unwrap()[0];
        assert!((normal.length() - 1.0).abs() < 1e-6);
        assert!(close(normal.as_dvec3(), DVec3::new(100.0, 1.0, 0.0).normalize()), "{normal}");
    }
    // A flattened mesh keeps the normal of the plane it was flattened into.
    file.json["nodes"][0]["scale"] = json!([1, 0, 1]);
    assert_eq!(file.scene().meshes[0].normals.as_ref().unwrap()[0], Vec3::Y);
}

#[test]
fn normals_without_length_are_replaced() {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 1.0]);
    file.attribute("NORMAL", normals);
    // Turned so that z becomes x, which nothing falls back to.
    file.json["nodes"][0]["matrix"] = json!([0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1]);
    let scene = file.scene();
    assert_eq!(scene.meshes[0].normals.as_deref().unwrap(), [Vec3::X; 3]);
    assert!(scene.warnings[0].problem.starts_with("1 normals"), "{:?}", scene.warnings);
}

#[test]
fn quantised_attributes() {
    let mut file = GltfFile::triangle();
    let bytes: Vec<u8> =
        [0_i16, 0, 0, 0, 1000, 0, 0, 0, 0, 2000, 0, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let positions = file.accessor(&bytes, I16, "VEC3", 3);
    file.json["bufferViews"][positions]["byteStride"] = json!(8);
    let normals = file.accessor(&[0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0], I8, "VEC3", 3);
    file.json["bufferViews"][normals]["byteStride"] = json!(4);
    file.json["accessors"][normals]["normalized"] = json!(true);
    let uvs = file.accessor(&[0, 0, 255, 255, 0, 0, 255, 127, 0, 0, 0, 0], U16, "VEC2", 3);
    file.json["accessors"][uvs]["normalized"] = json!(true);
    let colors = file.accessor(&[255, 0, 51, 255, 0, 0, 0, 0, 255, 255, 255, 255], U8, "VEC4", 3);
    file.json["accessors"][colors]["normalized"] = json!(true);
    for (name, accessor) in
        [("POSITION", positions), ("NORMAL", normals), ("TEXCOORD_0", uvs), ("COLOR_0", colors)]
    {
        file.attribute(name, accessor);
    }
    file.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    file.json["nodes"][0]["scale"] = json!([0.001, 0.001, 0.001]);
    let scene = file.scene();
    let mesh = &scene.meshes[0];
    assert!(close(mesh.positions[1], DVec3::X) && close(mesh.positions[2], 2.0 * DVec3::Y));
    assert_eq!(mesh.normals.as_deref().unwrap(), [Vec3::Z; 3]);
    let uvs = mesh.uvs[0].as_ref().unwrap();
    assert_eq!(uvs[0], Vec2::new(0.0, 1.0));
    assert_eq!(uvs[1], Vec2::new(0.0, (f64::from(0x7fff) / 65535.0) as f32));
    assert_eq!(mesh.colors.as_ref().unwrap()[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn colors_without_alpha_are_opaque() {
    let mut file = GltfFile::triangle();
    let colors = file.floats("VEC3", &[0.25, 0.5, 1.5].repeat(3));
    file.attribute("COLOR_0", colors);
    assert_eq!(file.scene().meshes[0].colors.as_deref().unwrap(), [Vec4::new(0.25, 0.5, 1.5, 1.0); 3]);
}

#[test]
fn instancing_is_flattened() {
    let mut file = GltfFile::triangle();
    let translations = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
    let rotations = file.accessor(&[0, 0, 0, 127, 0, 127, 0, 0], I8, "VEC4", 2);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = file.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, -2.0]);
    file.json["nodes"][0] = json!({
        "mesh": 0,
        "translation": [10, 0, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {
            "attributes": {"TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": 0},
        }},
    });
    let scene = file.scene();
    assert_eq!(scene.meshes.len(), 2);
    assert_eq!(scene.meshes[0].positions[1], DVec3::new(11.0, 0.0, 0.0));
    // Half a turn about y takes x to -x; the mirrored copy is wound the other way.
    assert!(
        close(scene.meshes[1].positions[1], DVec3::new(8.0, 0.0, 5.0)),
        "{}",
        scene.meshes[1].positions[1]
    );
    assert_eq!(scene.meshes[1].triangles, [[0, 2, 1]]);
}

/// Two joints: one stands still, the other has moved up by 3 since it was bound at height 1.
#[test]
fn skins_are_posed() {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let joints = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 9, 1, 0, 0, 0], U8, "VEC4", 3);
    // The second vertex hangs on both; weights are normalised; joint 9 has no weight.
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let identity = |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -y, 0.0, 1.0];
    let binds = file.floats("MAT4", &[identity(0.0), identity(1.0)].concat());
    for (name, accessor) in [("NORMAL", normals), ("JOINTS_0", joints), ("WEIGHTS_0", weights)] {
        file.attribute(name, accessor);
    }
    file.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    file.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [99, 99, 99]},
        {"children": [2]},
        {"translation": [0, 4, 0]},
    ]);
    let scene = file.scene();
    let expected = [DVec3::ZERO, DVec3::new(1.0, 1.5, 0.0), DVec3::new(0.0, 4.0, 0.0)];
    for (position, expected) in scene.meshes[0].positions.iter().zip(expected) {
        assert!(close(*position, expected), "{position} {expected}");
    }
    assert_eq!(scene.meshes[0].normals.as_deref().unwrap(), [Vec3::Z; 3]);
    // Joints that mirror everything turn the triangle over, and the normal with them.
    file.json["nodes"][1] = json!({"children": [2], "scale": [1, 1, -1]});
    let mesh = &file.scene().meshes[0];
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    assert_eq!(mesh.normals.as_deref().unwrap(), [Vec3::NEG_Z; 3]);
    assert!(triangle_normal(mesh, 0).z < 0.0);
}

#[test]
fn morph_targets_at_default_weights() {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    file.attribute("NORMAL", normals);
    let up = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let lean = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}, {"NORMAL": lean}]);
    let corner = |file: &GltfFile| file.scene().meshes[0].positions[0];
    assert_eq!(corner(&file), DVec3::ZERO);
    file.json["meshes"][0]["weights"] = json!([0.5, 1.0]);
    assert_eq!(corner(&file), DVec3::Z);
    let normal = file.scene().meshes[0].normals.as_ref().unwrap()[0];
    assert!(close(normal.as_dvec3(), DVec3::new(1.0, 0.0, 1.0).normalize()), "{normal}");
    // The weights of a node come before those of its mesh; a second node keeps the mesh's.
    file.json["nodes"] = json!([{"mesh": 0, "weights": [-1.0, 0.0]}, {"mesh": 0}]);
    let scene = file.scene();
    assert_eq!(scene.meshes[0].positions[0], -2.0 * DVec3::Z);
    assert_eq!(scene.meshes[1].positions[0], DVec3::Z);
}

#[test]
fn cameras() {
    let mut file = GltfFile::triangle();
    file.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 3, "znear": 0.1}, "name": "wide"},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0, "zfar": 9}},
    ]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    file.push(
        "nodes",
        json!({"camera": 0, "translation": [1, 2, 3], "rotation": [0, half, 0, half], "scale": [5, 5, 5]}),
    );
    // Sheared and mirrored: the axes are made orthonormal and right-handed again.
    file.push("nodes", json!({"camera": 1, "name": "flat", "matrix": [-1,0,0,0, 0,2,1,0, 0,0,3,0, 0,0,0,1]}));
    let cameras = file.scene().cameras;
    assert_eq!((cameras[0].name.as_str(), cameras[1].name.as_str()), ("wide", "flat"));
    assert_eq!(cameras[0].projection, Projection::Perspective { yfov: 0.7 });
    assert_eq!(cameras[1].projection, Projection::Orthographic { xmag: 2.0, ymag: 1.0 });
    assert_eq!(cameras[0].position, DVec3::new(1.0, 2.0, 3.0));
    // A quarter turn about y: -z becomes -x, x becomes -z.
    let expected = [[Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z], [Vec3::NEG_Z, Vec3::Y, Vec3::X]];
    for (camera, [forward, up, right]) in cameras.iter().zip(expected) {
        assert!((camera.forward - forward).length() < 1e-6, "{camera:?}");
        assert!((camera.up - up).length() < 1e-6, "{camera:?}");
        assert!((camera.right - right).length() < 1e-6, "{camera:?}");
    }
}

#[test]
fn punctual_lights() {
    let mut file = GltfFile::triangle();
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "name": "bulb", "color": [1, 0.5, 0], "intensity": 40, "range": 10},
        {"type": "spot", "intensity": 2, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
        {"type": "directional"},
        {"type": "spot", "spot": {}},
    ]}});
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for light in 0..4 {
        file.push(
            "nodes",
            json!({
                "translation": [light, 0, 0], "scale": [3, 3, 3], "rotation": [half, 0, 0, half],
                "extensions": {"KHR_lights_punctual": {"light": light}},
            }),
        );
    }
    let scene = file.scene();
    let [bulb, spot, sun, default] = scene.lights.as_slice() else { panic!("four lights") };
    assert_eq!((bulb.name.as_str(), bulb.kind), ("bulb", LightKind::Point));
    assert_eq!(bulb.intensity, Vec3::new(40.0, 20.0, 0.0));
    assert_eq!(spot.kind, LightKind::Spot { inner: 0.1, outer: 0.2 });
    assert_eq!((spot.intensity, spot.position), (Vec3::splat(2.0), DVec3::X));
    // A quarter turn about x takes -z to y.
    assert!((spot.direction - Vec3::Y).length() < 1e-6 && (sun.direction - Vec3::Y).length() < 1e-6);
    assert_eq!((sun.kind, sun.intensity), (LightKind::Directional, Vec3::ONE));
    assert_eq!(default.kind, LightKind::Spot { inner: 0.0, outer: std::f32::consts::FRAC_PI_4 });
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].problem.contains("range"), "{:?}", scene.warnings);
}
