//! Files with random bytes changed: the loader refuses or reads them, and never panics.

use halfway::scene::gltf::{Limits, LoadOptions, load_slice};
use halfway::scene::{LightKind, SceneError};
use image::{DynamicImage, ImageFormat, Rgb, RgbImage};
use serde_json::{Value, json};

use crate::gltf_file::{F32, GltfFile, I8, U8, U16, encode};
use crate::random::Stream;

struct Random(Stream);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0.word() as usize % end
    }

    /// One to four edits: another byte, a flipped bit, a digit, bytes left out or doubled, the end cut off.
    fn mutate(&mut self, original: &[u8]) -> Vec<u8> {
        let mut bytes = original.to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len());
            match self.below(10) {
                0 | 1 => bytes[at] = self.0.word() as u8,
                2 | 3 => bytes[at] ^= 1 << self.below(8),
                4..=6 => {
                    // Numbers are where the loader is most likely to trip.
                    if let Some(digit) = bytes[at..].iter().position(u8::is_ascii_digit) {
                        bytes[at + digit] = b'0' + self.below(10) as u8;
                    }
                }
                7 => {
                    let end = (at + 1 + self.below(8)).min(bytes.len());
                    bytes.drain(at..end);
                }
                8 => {
                    let end = (at + 1 + self.below(8)).min(bytes.len());
                    let copy = bytes[at..end].to_vec();
                    bytes.splice(at..at, copy);
                }
                _ => bytes.truncate(at.max(bytes.len() - bytes.len().min(64))),
            }
            if bytes.is_empty() {
                break;
            }
        }
        bytes
    }
}

/// All numbers of a document, as pointers into it.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.into()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| numbers(item, &format!("{path}/{i}"), found));
        }
        Value::Object(members) => {
            members.iter().for_each(|(key, member)| numbers(member, &format!("{path}/{key}"), found));
        }
        _ => {}
    }
}

/// Small, and with a bit of everything that the loader reads.
fn everything() -> GltfFile {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let uvs = file.accessor(&[0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0], U8, "VEC2", 3);
    file.json["bufferViews"][uvs]["byteStride"] = json!(4);
    file.json["accessors"][uvs]["normalized"] = json!(true);
    let joints = file.accessor(&[0, 1, 0, 0].repeat(3), U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(3));
    let rotations = file.accessor(&[0, 0, 0, 127, 0, 127, 0, 0], I8, "VEC4", 2);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    let indices = file.accessor(&[0, 0, 1, 0, 2, 0], U16, "SCALAR", 3);
    let sparse_indices = file.view(&[1]);
    let sparse_values = file.view(&[0; 12]);
    let sparse = file.push(
        "accessors",
        json!({"componentType": F32, "type": "VEC3", "count": 3, "sparse": {
            "count": 1,
            "indices": {"bufferView": sparse_indices, "componentType": U8},
            "values": {"bufferView": sparse_values},
        }}),
    );
    let texture = file.texture(&encode(&DynamicImage::new_rgb8(2, 2), ImageFormat::Png));
    file.json["textures"][texture]["sampler"] = json!(0);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    let info =
        json!({"index": texture, "extensions": {"KHR_texture_transform": {"scale": [2, 2], "rotation": 1}}});
    file.json["materials"] = json!([
        {"normalTexture": info, "emissiveFactor": [1, 1, 1], "alphaMode": "MASK", "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 3}, "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
        }},
    ]);
    file.json["meshes"] = json!([
        {"weights": [0.5], "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": normals, "TEXCOORD_0": uvs, "JOINTS_0": joints, "WEIGHTS_0": weights},
             "indices": indices, "material": 0, "targets": [{"POSITION": sparse}]},
        ]},
        {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": uvs}, "mode": 5, "material": 0}]},
    ]);
    file.json["skins"] = json!([{"joints": [1, 2]}]);
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.7}}]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 4}]}});
    file.json["nodes"] = json!([
        {"mesh": 0, "skin": 0}, {"children": [2], "scale": [1, 1, -1]}, {"translation": [0, 1, 0]},
        {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": rotations}}}},
        {"camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1],
         "extensions": {"KHR_lights_punctual": {"light": 0}}},
    ]);
    file.json["scenes"] = json!([{"nodes": [0, 1, 3, 4]}]);
    file
}

/// What a mutant asks for is not worth the time of a test.
fn small() -> LoadOptions {
    let limits = Limits {
        vertices: 1 << 16,
        triangles: 1 << 16,
        image_pixels: 1 << 20,
        unbacked_elements: 1 << 16,
        ..Limits::default()
    };
    LoadOptions { limits, ..LoadOptions::default() }
}

/// Loads a mutant; the number of warnings where it was still read, and then it must be consistent.
fn read(bytes: &[u8], mutant: &dyn std::fmt::Display) -> Option<usize> {
    match load_slice(bytes, None, &small()) {
        Ok(scene) => {
            // The decoders are others' work, and a panic in one of them is caught; here it must be seen.
            assert!(!scene.warnings.iter().any(|warning| warning.problem.contains(PANIC)), "mutant {mutant}");
            let textures = scene.materials.iter().flat_map(|material| material.textures());
            for texture in textures.map(|texture| scene.textures[texture.texture as usize]) {
                let image = &scene.images[texture.image as usize];
                assert_eq!(image.texels.len(), (image.width * image.height) as usize, "mutant {mutant}");
            }
            for light in &scene.lights {
                let is_cone = |[inner, outer]: [f32; 2]| 0.0 <= inner && inner <= outer && outer > 0.0;
                assert!(
                    !matches!(light.kind, LightKind::Spot { inner, outer } if !is_cone([inner, outer])),
                    "mutant {mutant}"
                );
            }
            for mesh in &scene.meshes {
                let vertices = mesh.positions.len();
                assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < vertices), "mutant {mutant}");
                assert!(mesh.positions.iter().all(|p| p.is_finite()), "mutant {mutant}");
                assert!(mesh.normals.iter().flatten().all(|n| n.is_normalized()), "mutant {mutant}");
                assert!(
                    mesh.tangents.iter().flatten().all(|t| t.truncate().is_normalized()),
                    "mutant {mutant}"
                );
                assert!((mesh.material as usize) < scene.materials.len(), "mutant {mutant}");
            }
            Some(scene.warnings.len())
        }
        Err(_) => None,
    }
}

/// What the loader makes of a panic in a decoder.
const PANIC: &str = "the decoder failed";

fn count_read(original: &[u8], count: usize, seed: u64) -> usize {
    let mut random = Random(Stream::new(seed));
    (0..count).filter(|mutant| read(&random.mutate(original), mutant).is_some()).count()
}

#[test]
fn r02_gltf_and_glb_mutants() {
    let file = everything();
    let scene = file.scene();
    assert_eq!((scene.meshes.len(), scene.cameras.len(), scene.lights.len()), (3, 1, 1));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let json = count_read(&file.gltf(), 10_000, 1);
    let glb = count_read(&file.glb(), 10_000, 2);
    println!("{json} of 10000 glTF and {glb} of 10000 GLB mutants are still read");
    // Most must fail and some must pass, or the mutants prove nothing.
    assert!((500..7_000).contains(&json) && (500..7_000).contains(&glb), "{json} {glb}");
}

/// Every number of the document in turn becomes each of the numbers at which something ends; the JSON stays well-formed,
/// so these reach deeper than bytes do.
#[test]
fn r02_number_mutants() {
    let file = everything();
    let mut pointers = Vec::new();
    numbers(&file.json, "", &mut pointers);
    let values = [
        json!(0),
        json!(1),
        json!(2),
        json!(3),
        json!(4),
        json!(5),
        json!(255),
        json!(1 << 16),
        json!(1_u64 << 32),
        json!(i64::MAX),
        json!(u64::MAX),
        json!(u64::MAX - 11),
        json!(-1),
        json!(0.5),
        json!(1e-308),
        json!(1e38),
        json!(1e308),
        json!(-1e308),
    ];
    let [mut whole, mut in_part] = [0, 0];
    for pointer in &pointers {
        for value in &values {
            let mut mutant = file.clone();
            *mutant.json.pointer_mut(pointer).unwrap() = value.clone();
            match read(&mutant.gltf(), &format!("{pointer} = {value}")) {
                Some(0) => whole += 1,
                Some(_) => in_part += 1,
                None => {}
            }
        }
    }
    let count = pointers.len() * values.len();
    println!("{whole} of {count} number mutants are read as a whole, {in_part} in part");
    let some = count / 10..count * 9 / 10;
    assert!(count > 2_000 && some.contains(&whole) && some.contains(&in_part), "{whole} {in_part} {count}");
}

#[test]
fn r02_picture_mutants() {
    let picture = DynamicImage::from(RgbImage::from_fn(16, 16, |x, y| Rgb([x as u8 * 16, y as u8 * 16, 99])));
    let mut random = Random(Stream::new(3));
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP] {
        let original = encode(&picture, format);
        let mut read = 0;
        for mutant in 0..1_000 {
            let mut file = GltfFile::triangle();
            let texture = file.texture(&random.mutate(&original));
            let uvs = file.floats("VEC2", &[0.5; 6]);
            file.attribute("TEXCOORD_0", uvs);
            file.material(json!({"emissiveTexture": {"index": texture}}));
            match file.load() {
                Ok(scene) => {
                    read += usize::from(scene.warnings.is_empty());
                    let image = &scene.images[0];
                    assert_eq!(image.texels.len(), (image.width * image.height) as usize);
                    let panicked = scene.warnings.iter().any(|warning| warning.problem.contains(PANIC));
                    assert!(!panicked, "{format:?} mutant {mutant}");
                }
                Err(SceneError::Limit { .. }) => {}
                Err(error) => panic!("{format:?} mutant {mutant}: {error}"),
            }
        }
        println!("{read} of 1000 {format:?} mutants are still read");
    }
}
