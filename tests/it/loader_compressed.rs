//! Compressed glTF files: each says what its plain twin says, and damage to it costs the part that is damaged.

use basis_universal::{BasisTextureFormat, ColorSpace, Compressor, CompressorParams};
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh as DracoMesh,
    MeshEncoder, PointAttribute, PointIndex,
};
use halfway::scene::gltf::{LoadOptions, load_slice};
use halfway::scene::{Mesh, Scene, SceneError};
use meshopt::EncodeExpMode;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use serde_json::{Value, json};

use crate::gltf_file::{F32, GltfFile, I8, U16, U32};
use crate::random::Stream;

/// Vertices of a grid each way.
const SIDE: u32 = 12;

struct Grid {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

/// A bumpy square.
fn grid() -> Grid {
    let at = |i: u32| [(i % SIDE) as f32, (i / SIDE) as f32].map(|x| x / 8.0);
    let height = |[x, y]: [f32; 2]| (x * 3.0 + y).sin() * 0.25;
    let positions = (0..SIDE * SIDE).map(|i| [at(i)[0], at(i)[1], height(at(i))]).collect();
    let normals = (0..SIDE * SIDE).map(|i| {
        let slope = (at(i)[0] * 3.0 + at(i)[1]).cos() * 0.25;
        let [x, y, z] = [-3.0 * slope, -slope, 1.0];
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    });
    let cells = (0..(SIDE - 1) * (SIDE - 1)).map(|i| i % (SIDE - 1) + i / (SIDE - 1) * SIDE);
    let indices = cells.flat_map(|i| [i, i + 1, i + SIDE, i + SIDE, i + 1, i + SIDE + 1]).collect();
    Grid { positions, normals: normals.collect(), indices }
}

/// A file with the grid: accessors 0 positions, 1 normals, 2 indices.
fn plain() -> GltfFile {
    let Grid { positions, normals, indices } = grid();
    let mut file = GltfFile::empty();
    file.floats("VEC3", positions.as_flattened());
    file.floats("VEC3", normals.as_flattened());
    let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    file.accessor(&bytes, U32, "SCALAR", indices.len());
    let attributes = json!({"POSITION": 0, "NORMAL": 1});
    file.push("meshes", json!({"primitives": [{"attributes": attributes, "indices": 2}]}));
    file.push("nodes", json!({"mesh": 0}));
    file
}

/// Puts compressed bytes in the place of buffer view `view`; the plain ones are gone.
fn compress(file: &mut GltfFile, name: &str, view: usize, bytes: &[u8], what: Value) {
    let compressed = file.view(bytes);
    let place = file.json["bufferViews"].as_array_mut().unwrap().remove(compressed);
    let mut what = what;
    for key in ["buffer", "byteOffset", "byteLength"] {
        what[key] = place[key].clone();
    }
    file.json["bufferViews"][view]["buffer"] = json!(1);
    file.json["bufferViews"][view]["byteOffset"] = json!(0);
    file.json["bufferViews"][view]["extensions"] = json!({name: what});
}

/// The document with its bytes, and the buffer that stands for what was compressed.
fn finish(mut file: GltfFile, name: &str) -> GltfFile {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&file.bin);
    let uri = format!("data:;base64,{data}");
    file.json["buffers"] = json!([
        {"byteLength": file.bin.len(), "uri": uri},
        {"byteLength": 1 << 20, "extensions": {name: {"fallback": true}}},
    ]);
    file.json["extensionsRequired"] = json!([name]);
    file
}

fn meshopted(name: &str) -> GltfFile {
    let grid = grid();
    let mut file = plain();
    let count = grid.positions.len();
    let bytes = meshopt::encode_vertex_buffer(&grid.positions).unwrap();
    compress(&mut file, name, 0, &bytes, json!({"byteStride": 12, "count": count, "mode": "ATTRIBUTES"}));
    let bytes = meshopt::encode_vertex_buffer(&grid.normals).unwrap();
    let what = json!({"byteStride": 12, "count": count, "mode": "ATTRIBUTES", "filter": "NONE"});
    compress(&mut file, name, 1, &bytes, what);
    let bytes = meshopt::encode_index_buffer(&grid.indices, count).unwrap();
    let what = json!({"byteStride": 4, "count": grid.indices.len(), "mode": "TRIANGLES"});
    compress(&mut file, name, 2, &bytes, what);
    finish(file, name)
}

/// Corners of all triangles, each triangle beginning at its least corner, in order.
fn corners(mesh: &Mesh) -> Vec<[[f64; 3]; 3]> {
    let mut all: Vec<_> = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let corners = triangle.map(|v| mesh.positions[v as usize].to_array());
            let least = (0..3).min_by(|a, b| corners[*a].partial_cmp(&corners[*b]).unwrap()).unwrap();
            [corners[least], corners[(least + 1) % 3], corners[(least + 2) % 3]]
        })
        .collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

#[test]
fn meshopt_views_hold_the_bytes_of_plain_ones() {
    let expected = plain().scene();
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let scene = meshopted(name).scene();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let [mesh, plain] = [&scene, &expected].map(|scene| &scene.meshes[0]);
        assert!(mesh.positions == plain.positions && mesh.normals == plain.normals);
        // The codec turns triangles about, and keeps their order.
        assert_eq!(corners(mesh), corners(plain));
    }
}

#[test]
fn meshopt_modes_and_filters() {
    let name = "EXT_meshopt_compression";
    let grid = grid();
    let count = grid.positions.len();
    let mut file = plain();
    // Sequences of 16-bit indices, positions with exponents, normals of 8 bits.
    let bytes = meshopt::encode_index_sequence(&grid.indices, count).unwrap();
    let what = json!({"byteStride": 2, "count": grid.indices.len(), "mode": "INDICES"});
    compress(&mut file, name, 2, &bytes, what);
    file.json["accessors"][2]["componentType"] = json!(U16);
    let exponents = meshopt::encode_filter_exp(&grid.positions, 20, EncodeExpMode::SharedVector);
    let bytes = meshopt::encode_vertex_buffer(&exponents).unwrap();
    let what = json!({"byteStride": 12, "count": count, "mode": "ATTRIBUTES", "filter": "EXPONENTIAL"});
    compress(&mut file, name, 0, &bytes, what);
    let normals: Vec<[f32; 4]> = grid.normals.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
    let octahedral = meshopt::encode_filter_oct::<i8>(&normals, 8);
    let bytes = meshopt::encode_vertex_buffer(&octahedral).unwrap();
    let what = json!({"byteStride": 4, "count": count, "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL"});
    compress(&mut file, name, 1, &bytes, what);
    file.json["bufferViews"][1]["byteStride"] = json!(4);
    file.json["accessors"][1] =
        json!({"bufferView": 1, "componentType": I8, "normalized": true, "type": "VEC3", "count": count});
    let scene = finish(file, name).scene();
    let (mesh, plain) = (&scene.meshes[0], &plain().scene().meshes[0]);
    assert_eq!(mesh.triangles, plain.triangles);
    for (a, b) in mesh.positions.iter().zip(&plain.positions) {
        assert!((*a - *b).length() < 1e-5, "{a} {b}");
    }
    let normals = mesh.normals.as_ref().unwrap().iter().zip(plain.normals.as_ref().unwrap());
    normals.for_each(|(a, b)| assert!((*a - *b).length() < 0.03, "{a} {b}"));
}

#[test]
fn faulty_meshopt_views_cost_their_mesh() {
    let name = "EXT_meshopt_compression";
    let spoilt = |key: &str, value: Value| {
        let mut file = meshopted(name);
        file.json["bufferViews"][0]["extensions"][name][key] = value;
        file.push("nodes", json!({"name": "another"}));
        file
    };
    for (key, value) in [
        ("byteStride", json!(13)),
        ("byteStride", json!(0)),
        ("byteStride", json!(512)),
        ("byteStride", json!(8)),
        ("count", json!(7)),
        ("count", json!(145)),
        ("count", json!(u64::MAX)),
        ("byteLength", json!(5)),
        ("byteLength", json!(u64::MAX)),
        ("byteOffset", json!(8)),
        ("buffer", json!(9)),
        ("mode", json!("TRIANGLES")),
        ("mode", json!("POINTS")),
        ("filter", json!("OCTAHEDRAL")),
        ("filter", json!("QUATERNION")),
    ] {
        let scene = spoilt(key, value.clone()).tolerated("meshes[0].primitives[0]");
        assert!(scene.meshes.is_empty(), "{key} {value}");
    }
}

/// The grid compressed by Draco; which vertex is which is lost, so corners are compared.
fn dracoed(speed: i32) -> GltfFile {
    let grid = grid();
    let mut mesh = DracoMesh::new();
    let count = grid.positions.len();
    for (kind, values) in
        [(GeometryAttributeType::Position, &grid.positions), (GeometryAttributeType::Normal, &grid.normals)]
    {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, 3, DataType::Float32, false, count);
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        attribute.buffer_mut().write(0, &bytes);
        mesh.add_attribute(attribute);
    }
    mesh.set_num_faces(grid.indices.len() / 3);
    for (face, corners) in grid.indices.as_chunks::<3>().0.iter().enumerate() {
        mesh.set_face(FaceIndex(face as u32), corners.map(PointIndex));
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut options = EncoderOptions::new();
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    let mut out = EncoderBuffer::new();
    encoder.encode(&options, &mut out).unwrap();

    let mut file = GltfFile::empty();
    let view = file.view(out.data());
    for (kind, component, count) in
        [("VEC3", F32, count), ("VEC3", F32, count), ("SCALAR", U32, grid.indices.len())]
    {
        file.push("accessors", json!({"componentType": component, "type": kind, "count": count}));
    }
    let what = json!({"bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1}});
    file.push(
        "meshes",
        json!({"primitives": [{
            "attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2,
            "extensions": {"KHR_draco_mesh_compression": what},
        }]}),
    );
    file.push("nodes", json!({"mesh": 0}));
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file
}

#[test]
fn draco_meshes_hold_what_plain_ones_do() {
    let expected = corners(&plain().scene().meshes[0]);
    for speed in [10, 5, 0] {
        let scene = dracoed(speed).scene();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let mesh = &scene.meshes[0];
        let found = corners(mesh);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().flatten().flatten().zip(expected.iter().flatten().flatten()) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
        // Normals stay with their vertices.
        for (position, normal) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()) {
            let slope = (position.x * 3.0 + position.y).cos() as f32 * 0.25;
            assert!((normal.x / normal.z + 3.0 * slope).abs() < 0.05, "{normal} at {position}");
        }
    }
}

#[test]
fn faulty_draco_meshes_cost_themselves() {
    let spoilt = |pointer: &str, value: Value| {
        let mut file = dracoed(5);
        *file.json.pointer_mut(pointer).unwrap() = value;
        file
    };
    let draco = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    for (pointer, value) in [
        (format!("{draco}/bufferView"), json!(4)),
        (format!("{draco}/attributes"), json!({"POSITION": 5})),
        (draco.to_string(), json!({})),
        ("/bufferViews/0/byteLength".into(), json!(60)),
        ("/accessors/0/count".into(), json!(5)),
        ("/accessors/0/type".into(), json!("VEC2")),
    ] {
        let scene = spoilt(&pointer, value).tolerated("meshes[0].primitives[0]");
        assert!(scene.meshes.is_empty(), "{pointer}");
    }
}

/// A KTX 2.0 file of one level. `model` is its colour model; `format` a `VkFormat`.
fn ktx(
    format: u32,
    model: u8,
    scheme: u32,
    size: [u32; 2],
    global: &[u8],
    level: &[u8],
    length: u64,
) -> Vec<u8> {
    let mut descriptor = vec![0_u8; 44];
    descriptor[0] = 44;
    descriptor[8] = 2; // version
    descriptor[10] = 40; // bytes of the block
    descriptor[12] = model;
    descriptor[13] = 1; // primaries of BT.709
    descriptor[14] = 2; // sRGB
    descriptor[20] = 16;
    let start = 80 + 24;
    let global_start = start + descriptor.len();
    let level_start = (global_start + global.len()).next_multiple_of(16);
    let mut file = ktx2_magic();
    for word in [format, 1, size[0], size[1], 0, 0, 1, 1, scheme, start as u32, descriptor.len() as u32, 0, 0]
    {
        file.extend(word.to_le_bytes());
    }
    let global_place = if global.is_empty() { 0 } else { global_start as u64 };
    for long in [global_place, global.len() as u64, level_start as u64, level.len() as u64, length] {
        file.extend(long.to_le_bytes());
    }
    file.extend(descriptor);
    file.extend(global);
    file.resize(level_start, 0);
    file.extend(level);
    file
}

fn ktx2_magic() -> Vec<u8> {
    b"\xABKTX 20\xBB\r\n\x1A\n".to_vec()
}

const SRGBA: u32 = 43;
const SRGB: u32 = 29;
const PLAIN: u8 = 1;
const ETC1S: u8 = 163;
const UASTC: u8 = 166;

/// A file that shows `picture` by `KHR_texture_basisu` alone.
fn textured(picture: &[u8]) -> GltfFile {
    let mut file = GltfFile::triangle();
    let uvs = file.floats("VEC2", &[0.5; 6]);
    file.attribute("TEXCOORD_0", uvs);
    let texture = file.texture(picture);
    file.json["textures"][texture] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    file.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    file.material(json!({"emissiveTexture": {"index": texture}, "emissiveFactor": [1, 1, 1]}));
    file
}

/// A smooth picture with alpha; its sides are no multiples of four.
const SIZE: [u32; 2] = [18, 10];

fn texels() -> Vec<[u8; 4]> {
    let texel = |i: u32| {
        let [x, y] = [i % SIZE[0], i / SIZE[0]];
        [40 + 8 * x as u8, 200 - 10 * y as u8, 90, 120 + 6 * x as u8]
    };
    (0..SIZE[0] * SIZE[1]).map(texel).collect()
}

/// The bytes of a `.basis` file.
#[allow(unsafe_code)]
fn basis(format: BasisTextureFormat, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut params = CompressorParams::new();
    params.set_basis_format(format);
    params.set_print_status_to_stdout(false);
    params.set_color_space(ColorSpace::Srgb);
    params.set_etc1s_quality_level(basis_universal::ETC1S_QUALITY_MAX);
    params.source_image_mut(0).init(texels.as_flattened(), SIZE[0], SIZE[1], 4);
    let mut compressor = Compressor::new(1);
    // SAFETY: the parameters outlive both calls, and nothing else compresses.
    unsafe {
        compressor.init(&params);
        compressor.process().unwrap();
    }
    compressor.basis_file().to_vec()
}

fn number(bytes: &[u8], at: usize, length: usize) -> usize {
    bytes[at..at + length].iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte))
}

/// A `.basis` file as KTX 2.0, by the layouts of both.
fn ktx_of(basis: &[u8], model: u8, scheme: u32) -> Vec<u8> {
    let slices = number(basis, 14, 3);
    let at = number(basis, 65, 4);
    let slice = |index: usize| {
        let start = number(basis, at + 23 * index + 13, 4);
        &basis[start..start + number(basis, at + 23 * index + 17, 4)]
    };
    if model == UASTC {
        let (level, length) = (slice(0), slice(0).len() as u64);
        return match scheme {
            0 => ktx(0, model, 0, SIZE, &[], level, length),
            _ => ktx(0, model, 2, SIZE, &[], &compress_to_vec(level, CompressionLevel::Fastest), length),
        };
    }
    let part = |at: usize, size: usize, bytes: usize| {
        let start = number(basis, at, 4);
        &basis[start..start + number(basis, size, bytes)]
    };
    let parts = [part(41, 45, 3), part(50, 54, 3), part(57, 61, 4)];
    let mut global = [&basis[39..41], &basis[48..50]].concat();
    let lengths = parts.map(|part| part.len() as u32);
    let level: Vec<u8> = (0..slices).flat_map(slice).copied().collect();
    let first = slice(0).len() as u32;
    let second = if slices > 1 { [first, slice(1).len() as u32] } else { [0, 0] };
    let words = [lengths[0], lengths[1], lengths[2], 0, 0, 0, first, second[0], second[1]];
    global.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    parts.iter().for_each(|part| global.extend(*part));
    ktx(0, model, 1, SIZE, &global, &level, 0)
}

fn image(scene: &Scene) -> &halfway::scene::Image {
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    &scene.images[0]
}

/// Root of the mean squared difference of two pictures.
fn difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let squares =
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / (4 * a.len()) as f64).sqrt()
}

#[test]
fn plain_ktx_textures() {
    let all = texels();
    let bytes = all.as_flattened();
    let packed = compress_to_vec(bytes, CompressionLevel::Fastest);
    let length = bytes.len() as u64;
    for file in
        [ktx(SRGBA, PLAIN, 0, SIZE, &[], bytes, length), ktx(SRGBA, PLAIN, 2, SIZE, &[], &packed, length)]
    {
        let scene = textured(&file).scene();
        let image = image(&scene);
        assert_eq!(([image.width, image.height], &image.texels), (SIZE, &all));
    }
    let rgb: Vec<u8> = all.iter().flat_map(|texel| &texel[..3]).copied().collect();
    let scene = textured(&ktx(SRGB, PLAIN, 0, SIZE, &[], &rgb, rgb.len() as u64)).scene();
    assert!(image(&scene).texels.iter().zip(&all).all(|(a, b)| a[..3] == b[..3] && a[3] == 255));
}

#[test]
fn basis_textures_look_like_their_originals() {
    let all = texels();
    let opaque: Vec<[u8; 4]> = all.iter().map(|&[r, g, b, _]| [r, g, b, 255]).collect();
    for texels in [&all, &opaque] {
        for (format, model, scheme, limit) in [
            (BasisTextureFormat::UASTC4x4, UASTC, 0, 2.0),
            (BasisTextureFormat::UASTC4x4, UASTC, 2, 2.0),
            (BasisTextureFormat::ETC1S, ETC1S, 1, 12.0),
        ] {
            let scene = textured(&ktx_of(&basis(format, texels), model, scheme)).scene();
            let image = image(&scene);
            assert_eq!([image.width, image.height], SIZE);
            let found = difference(&image.texels, texels);
            assert!(found < limit, "{model} {scheme}: {found}");
        }
    }
}

#[test]
fn faulty_ktx_textures_are_magenta() {
    let all = texels();
    let bytes = all.as_flattened();
    let length = bytes.len() as u64;
    let etc1s = ktx_of(&basis(BasisTextureFormat::ETC1S, &all), ETC1S, 1);
    let uastc = ktx_of(&basis(BasisTextureFormat::UASTC4x4, &all), UASTC, 0);
    let mut wide = uastc.clone();
    wide[20..24].copy_from_slice(&4000_u32.to_le_bytes());
    for file in [
        ktx(SRGBA, PLAIN, 0, SIZE, &[], &bytes[1..], length),
        ktx(SRGBA, PLAIN, 2, SIZE, &[], bytes, length),
        ktx(SRGBA, PLAIN, 3, SIZE, &[], bytes, length),
        ktx(SRGBA, PLAIN, 0, [SIZE[0], 0], &[], bytes, length),
        ktx(97, PLAIN, 0, SIZE, &[], &[0; 18 * 10 * 8], 18 * 10 * 8),
        ktx(0, ETC1S, 1, SIZE, &[0; 10], bytes, length),
        ktx(0, ETC1S, 1, SIZE, &[0; 40], bytes, length),
        etc1s[..etc1s.len() - 20].to_vec(),
        wide,
        ktx2_magic(),
    ] {
        let scene = textured(&file).tolerated("images[0]");
        assert_eq!(scene.images[0].texels, [[255, 0, 255, 255]]);
    }
}

/// Bytes of compressed data changed: what is read is consistent, and nothing panics or aborts.
#[test]
fn r02_compressed_mutants() {
    let all = texels();
    let originals = [
        meshopted("EXT_meshopt_compression"),
        dracoed(10),
        dracoed(5),
        dracoed(0),
        textured(&ktx_of(&basis(BasisTextureFormat::ETC1S, &all), ETC1S, 1)),
        textured(&ktx_of(&basis(BasisTextureFormat::UASTC4x4, &all), UASTC, 2)),
    ];
    let count: u64 = std::env::var("MUTANTS").map_or(300, |count| count.parse().unwrap());
    for (index, original) in originals.iter().enumerate() {
        let mut random = Stream::new(index as u64 + 40);
        let (mut read, mut refused) = (0, 0);
        for mutant in 0..count {
            let mut file = original.clone();
            for _ in 0..=random.word() % 3 {
                let at = random.word() as usize % file.bin.len();
                file.bin[at] = match random.word() % 3 {
                    0 => random.word() as u8,
                    1 => file.bin[at] ^ 1 << (random.word() % 8),
                    _ => 255,
                };
            }
            if file.json.get("buffers").is_some() {
                file = finish(file, "EXT_meshopt_compression");
            }
            let mut options = LoadOptions::default();
            options.limits.image_pixels = 1 << 20;
            let scene = match load_slice(&file.gltf(), None, &options) {
                Ok(scene) => scene,
                Err(SceneError::Limit { .. }) => {
                    refused += 1;
                    continue;
                }
                Err(error) => panic!("mutant {mutant} of {index}: {error}"),
            };
            let panicked =
                scene.warnings.iter().any(|warning| warning.problem.contains("the decoder failed"));
            assert!(!panicked, "mutant {mutant} of {index}");
            for mesh in &scene.meshes {
                let vertices = mesh.positions.len();
                assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < vertices));
                assert!(mesh.positions.iter().all(|p| p.is_finite()));
            }
            for image in &scene.images {
                assert_eq!(image.texels.len(), (image.width * image.height) as usize);
            }
            if scene.warnings.is_empty() { read += 1 } else { refused += 1 }
        }
        println!("original {index}: {read} of {count} mutants are read whole, {refused} are not");
        assert!(refused > 0, "{index}");
    }
}
