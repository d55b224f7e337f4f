//! The glTF loader on files that are wrong: read strictly, each is refused with a named fault.

use std::fs;

use halfway::scene::SceneError;
use halfway::scene::gltf::{LoadOptions, load, load_slice};
use serde_json::{Value, json};

use crate::gltf_file::{F32, GltfFile, I16, U8, U16, U32, code, encode, strict};

fn bytes_fault(bytes: &[u8]) -> &'static str {
    code(load_slice(bytes, None, &strict()))
}

/// A triangle with one thing about it changed.
fn spoiled(change: impl FnOnce(&mut GltfFile)) -> &'static str {
    let mut file = GltfFile::triangle();
    change(&mut file);
    file.fault()
}

fn with_indices(component: u64, bytes: &[u8], count: usize) -> &'static str {
    spoiled(|file| {
        let indices = file.accessor(bytes, component, "SCALAR", count);
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    })
}

#[test]
fn r01_containers() {
    let glb = GltfFile::triangle().glb();
    assert_eq!(bytes_fault(&glb), "no fault");
    assert_eq!(bytes_fault(b""), "EMPTY_FILE");
    assert_eq!(bytes_fault(b"\x89PNG\r\n\x1a\n"), "GLB_INVALID_MAGIC");
    assert_eq!(bytes_fault(b"glTF\x02\0\0\0"), "GLB_UNEXPECTED_END_OF_HEADER");
    assert_eq!(bytes_fault(&glb[..glb.len() - 1]), "GLB_LENGTH_MISMATCH");
    let word = |offset: usize, value: u32| {
        let mut glb = glb.clone();
        glb[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        bytes_fault(&glb)
    };
    assert_eq!(word(4, 1), "GLB_INVALID_VERSION");
    assert_eq!(word(12, u32::MAX), "GLB_UNEXPECTED_END_OF_CHUNK_DATA");
    assert_eq!(word(8, 16), "GLB_UNEXPECTED_END_OF_CHUNK_HEADER");
    assert_eq!(word(16, 7), "GLB_UNEXPECTED_FIRST_CHUNK");
    assert_eq!(word(8, 11), "GLB_LENGTH_MISMATCH");
    assert_eq!(word(8, 0), "GLB_LENGTH_MISMATCH");
    // A chunk of another kind is left alone, and so is what it holds; a second JSON chunk is no such thing.
    let second = 20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let kind = |kind: &[u8; 4]| {
        let mut glb = glb.clone();
        glb[second + 4..second + 8].copy_from_slice(kind);
        bytes_fault(&glb)
    };
    assert_eq!(kind(b"XXXX"), "BUFFER_MISSING_DATA");
    assert_eq!(kind(b"JSON"), "GLB_DUPLICATE_CHUNK");
    assert_eq!(bytes_fault(b"{\"asset\": {\"version\": \"2.0\"}"), "json");
    assert_eq!(bytes_fault(b"{\"asset\": {\"version\": \"1.0\"}}"), "version");
    // glTF 1.0 has objects where 2.0 has lists, and need not name its version.
    assert_eq!(bytes_fault(b"{\"scene\": \"s\", \"nodes\": {}}"), "version");
    assert_eq!(bytes_fault(b"{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {\"n\": {}}}"), "version");
    assert_eq!(bytes_fault(b"{\"asset\": {}}"), "UNDEFINED_PROPERTY");
    assert_eq!(bytes_fault(b"{\"asset\": {\"version\": \"2.1\", \"minVersion\": \"2.1\"}}"), "version");
    // A document that nests without end must not overflow the stack.
    let deep = format!("{{\"extras\": {}", "[".repeat(100_000));
    assert_eq!(bytes_fault(deep.as_bytes()), "json");
}

#[test]
fn r01_accessors() {
    let accessor = |key: &str, value: Value| spoiled(|file| file.json["accessors"][0][key] = value);
    assert_eq!(accessor("count", json!(4)), "ACCESSOR_TOO_LONG");
    assert_eq!(accessor("count", json!(0)), "VALUE_NOT_IN_RANGE");
    assert_eq!(accessor("count", json!(u64::MAX)), "limit");
    assert_eq!(accessor("count", json!(u32::MAX / 12)), "ACCESSOR_TOO_LONG");
    assert_eq!(accessor("byteOffset", json!(4)), "ACCESSOR_TOO_LONG");
    assert_eq!(accessor("byteOffset", json!(u64::MAX - 15)), "ACCESSOR_TOO_LONG");
    assert_eq!(accessor("componentType", json!(5127)), "VALUE_NOT_IN_LIST");
    assert_eq!(accessor("bufferView", json!(1)), "UNRESOLVED_REFERENCE");
    // 2^32, which 32-bit indices take for 0.
    assert_eq!(accessor("bufferView", json!(1_u64 << 32)), "UNRESOLVED_REFERENCE");
    let mut file = GltfFile::triangle();
    file.json["accessors"][0]["bufferView"] = json!((1_u64 << 32) + 1);
    let message = load_slice(&file.gltf(), None, &strict()).unwrap_err().to_string();
    assert!(message.contains("32 bits"), "{message}");
    let format = "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT";
    assert_eq!(accessor("type", json!("VEC4")), format);
    assert_eq!(accessor("type", json!("VEC9")), format);
    assert_eq!(accessor("componentType", json!(U32)), format);
    let unbacked = |count: u64| {
        spoiled(|file| {
            file.json["accessors"][0] = json!({"componentType": F32, "type": "VEC3", "count": count});
        })
    };
    assert_eq!(unbacked(3), "no fault");
    assert_eq!(unbacked(100_000_000), "limit");

    let view = |key: &str, value: Value| spoiled(|file| file.json["bufferViews"][0][key] = value);
    assert_eq!(view("byteLength", json!(37)), "BUFFER_VIEW_TOO_LONG");
    assert_eq!(view("byteOffset", json!(u64::MAX - 3)), "BUFFER_VIEW_TOO_LONG");
    assert_eq!(view("buffer", json!(1)), "UNRESOLVED_REFERENCE");
    assert_eq!(view("byteStride", json!(8)), "ACCESSOR_TOTAL_OFFSET_ALIGNMENT");
    assert_eq!(view("byteStride", json!(0)), "VALUE_NOT_IN_RANGE");
    assert_eq!(view("byteStride", json!(1_u64 << 40)), "VALUE_NOT_IN_RANGE");
    assert_eq!(spoiled(|file| file.json["buffers"] = json!([])), "UNRESOLVED_REFERENCE");
    assert_eq!(spoiled(|file| file.json["buffers"] = json!([{"byteLength": 36}])), "BUFFER_MISSING_DATA");
    let short = json!([{"byteLength": 40, "uri": "data:;base64,AAAA"}]);
    assert_eq!(spoiled(|file| file.json["buffers"] = short), "BUFFER_BYTE_LENGTH_MISMATCH");
}

#[test]
fn r01_sparse() {
    let sparse = |count: usize, indices: &[u8]| {
        spoiled(|file| {
            let indices = file.view(indices);
            let values = file.view(&[0; 24]);
            file.json["accessors"][0]["sparse"] = json!({
                "count": count,
                "indices": {"bufferView": indices, "componentType": U8},
                "values": {"bufferView": values},
            });
        })
    };
    assert_eq!(sparse(2, &[0, 2]), "no fault");
    assert_eq!(sparse(2, &[0, 3]), "ACCESSOR_SPARSE_INDEX_OOB");
    assert_eq!(sparse(2, &[1, 1]), "ACCESSOR_SPARSE_INDICES_NON_INCREASING");
    assert_eq!(sparse(4, &[0, 1, 2, 3]), "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE");
    assert_eq!(sparse(3, &[0, 1, 2]), "ACCESSOR_TOO_LONG");
}

#[test]
fn r01_meshes() {
    assert_eq!(with_indices(U8, &[0, 1, 2], 3), "no fault");
    assert_eq!(with_indices(U8, &[0, 1, 3], 3), "ACCESSOR_INDEX_OOB");
    assert_eq!(with_indices(U8, &[0, 1, 2, 0], 4), "MESH_PRIMITIVE_INCOMPATIBLE_MODE");
    assert_eq!(with_indices(U8, &[0, 1, 255], 3), "ACCESSOR_INDEX_PRIMITIVE_RESTART");
    assert_eq!(with_indices(U16, &[0, 0, 1, 0, 255, 255], 3), "ACCESSOR_INDEX_PRIMITIVE_RESTART");
    assert_eq!(
        with_indices(U32, &[0, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255], 3),
        "ACCESSOR_INDEX_PRIMITIVE_RESTART"
    );
    assert_eq!(with_indices(I16, &[0; 6], 3), "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for attribute in ["POSITION", "NORMAL"] {
            let fault = spoiled(|file| {
                let accessor = file.floats("VEC3", &[0.0, 0.0, 1.0, 1.0, bad, 0.0, 0.0, 1.0, 0.0]);
                file.attribute(attribute, accessor);
            });
            assert_eq!(fault, "ACCESSOR_INVALID_FLOAT", "{attribute} {bad}");
        }
    }
    let unequal = spoiled(|file| {
        let normals = file.floats("VEC3", &[0.0, 0.0, 1.0]);
        file.attribute("NORMAL", normals);
    });
    assert_eq!(unequal, "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT");
    let primitive =
        |key: &str, value: Value| spoiled(|file| file.json["meshes"][0]["primitives"][0][key] = value);
    assert_eq!(primitive("mode", json!(7)), "VALUE_NOT_IN_LIST");
    assert_eq!(primitive("mode", json!(5)), "no fault");
    assert_eq!(primitive("material", json!(0)), "UNRESOLVED_REFERENCE");
    assert_eq!(primitive("indices", json!(9)), "UNRESOLVED_REFERENCE");
    assert_eq!(primitive("attributes", json!({"POSITION": "0"})), "TYPE_MISMATCH");
    assert_eq!(
        spoiled(|file| file.json["meshes"][0]["weights"] = json!([1.0])),
        "MESH_INVALID_WEIGHTS_COUNT"
    );
}

#[test]
fn r01_nodes() {
    let nodes = |nodes: Value| spoiled(|file| file.json["nodes"] = nodes);
    assert_eq!(nodes(json!([{"children": [1]}, {"children": [0]}])), "NODE_LOOP");
    assert_eq!(nodes(json!([{"children": [0]}])), "NODE_LOOP");
    assert_eq!(nodes(json!([{"children": [2]}, {"children": [2]}, {}])), "NODE_PARENT_OVERRIDE");
    assert_eq!(nodes(json!([{"children": [1]}])), "UNRESOLVED_REFERENCE");
    assert_eq!(nodes(json!([{"mesh": 1}])), "UNRESOLVED_REFERENCE");
    assert_eq!(nodes(json!([{"camera": 0}])), "UNRESOLVED_REFERENCE");
    assert_eq!(nodes(json!([{"mesh": 0, "skin": 0}])), "UNRESOLVED_REFERENCE");
    assert_eq!(nodes(json!([{"mesh": -1}])), "json");
    assert_eq!(nodes(json!([{"rotation": [0, 0, 0, 0]}])), "ROTATION_NON_UNIT");
    assert_eq!(nodes(json!([{"matrix": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]}])), "NODE_MATRIX_NON_TRS");
    let huge = json!({"scale": [1e308, 1, 1], "children": [1]});
    assert_eq!(nodes(json!([huge, {"scale": [1e308, 1, 1]}])), "VALUE_NOT_IN_RANGE");
    let chain = |length: usize| -> Value {
        (0..length).map(|i| if i + 1 < length { json!({"children": [i + 1]}) } else { json!({}) }).collect()
    };
    assert_eq!(nodes(chain(1024)), "no fault");
    assert_eq!(nodes(chain(1025)), "NODE_DEPTH");
    assert_eq!(nodes(chain(50_000)), "NODE_DEPTH");
    assert_eq!(spoiled(|file| file.json["scene"] = json!(0)), "UNRESOLVED_REFERENCE");
    assert_eq!(spoiled(|file| file.json["scenes"] = json!([{"nodes": [1]}])), "UNRESOLVED_REFERENCE");
    let child_as_root = spoiled(|file| {
        file.json["nodes"] = json!([{"children": [1]}, {}]);
        file.json["scenes"] = json!([{"nodes": [1]}]);
    });
    assert_eq!(child_as_root, "SCENE_NON_ROOT_NODE");
}

#[test]
fn r01_cameras_and_lights() {
    let camera = |camera: Value| {
        spoiled(|file| {
            file.json["cameras"] = json!([camera]);
            file.push("nodes", json!({"camera": 0}));
        })
    };
    let perspective = |yfov: f64| camera(json!({"type": "perspective", "perspective": {"yfov": yfov}}));
    assert_eq!(perspective(1.0), "no fault");
    assert_eq!(perspective(0.0), "VALUE_NOT_IN_RANGE");
    assert_eq!(perspective(3.2), "VALUE_NOT_IN_RANGE");
    assert_eq!(camera(json!({"type": "perspective"})), "UNDEFINED_PROPERTY");
    let parallel = json!({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}});
    assert_eq!(camera(parallel), "VALUE_NOT_IN_RANGE");

    let light = |index: usize, light: Value| {
        spoiled(|file| {
            file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
            file.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": index}}}));
        })
    };
    assert_eq!(light(0, json!({"type": "point"})), "no fault");
    assert_eq!(light(1, json!({"type": "point"})), "UNRESOLVED_REFERENCE");
    assert_eq!(light(0, json!({"type": "area"})), "VALUE_NOT_IN_RANGE");
    assert_eq!(light(0, json!({"type": "point", "intensity": -1})), "VALUE_NOT_IN_RANGE");
    assert_eq!(light(0, json!({"type": "point", "intensity": "1"})), "TYPE_MISMATCH");
    let cones = json!({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}});
    assert_eq!(light(0, cones), "VALUE_NOT_IN_RANGE");
}

#[test]
fn r01_skins() {
    let skinned = |joint: u8, weight: f32, binds: usize| {
        spoiled(|file| {
            let joints = file.accessor(&[joint, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], U8, "VEC4", 3);
            let weights =
                file.floats("VEC4", &[weight, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
            file.attribute("JOINTS_0", joints);
            file.attribute("WEIGHTS_0", weights);
            let binds = file.floats("MAT4", &vec![0.0; 16 * binds]);
            file.json["skins"] = json!([{"joints": [0, 0], "inverseBindMatrices": binds}]);
            file.json["nodes"][0]["skin"] = json!(0);
        })
    };
    assert_eq!(skinned(1, 1.0, 2), "no fault");
    assert_eq!(skinned(2, 1.0, 2), "ACCESSOR_JOINTS_INDEX_OOB");
    assert_eq!(skinned(0, 0.0, 2), "ACCESSOR_WEIGHTS_NON_NORMALIZED");
    assert_eq!(skinned(0, -1.0, 2), "ACCESSOR_WEIGHTS_NON_NORMALIZED");
    assert_eq!(skinned(1, 1.0, 1), "INVALID_IBM_ACCESSOR_COUNT");
}

#[test]
fn r01_materials_and_images() {
    let material = |material: Value| spoiled(|file| file.material(material));
    assert_eq!(material(json!({"alphaMode": "DITHER"})), "VALUE_NOT_IN_RANGE");
    assert_eq!(material(json!({"emissiveFactor": [-1, 0, 0]})), "VALUE_NOT_IN_RANGE");
    assert_eq!(material(json!({"emissiveFactor": [1e39, 0, 0]})), "VALUE_NOT_IN_RANGE");
    assert_eq!(material(json!({"normalTexture": {"index": 0}})), "UNRESOLVED_REFERENCE");
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})), "VALUE_NOT_IN_RANGE");
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": "x"}}})), "TYPE_MISMATCH");
    let volume = json!({"thicknessFactor": 1, "attenuationDistance": 0});
    assert_eq!(material(json!({"extensions": {"KHR_materials_volume": volume}})), "VALUE_NOT_IN_RANGE");

    let image = |image: Value, picture: &[u8]| {
        spoiled(|file| {
            file.view(picture);
            file.json["images"] = json!([image]);
            file.json["textures"] = json!([{"source": 0}]);
            file.material(json!({"emissiveTexture": {"index": 0}}));
        })
    };
    let embedded = json!({"bufferView": 1});
    let png = encode(&image::DynamicImage::new_rgb8(2, 2), image::ImageFormat::Png);
    assert_eq!(image(embedded.clone(), &png), "no fault");
    assert_eq!(image(embedded.clone(), &png[..40]), "image");
    assert_eq!(image(embedded.clone(), b"nothing"), "image");
    assert_eq!(image(embedded.clone(), b"GIF89a\x01\0\x01\0\0\0\0;"), "image");
    assert_eq!(image(json!({"bufferView": 2}), &png), "UNRESOLVED_REFERENCE");
    assert_eq!(image(json!({}), &png), "ONE_OF_MISMATCH");
    assert_eq!(image(json!({"uri": "missing.png"}), &png), "uri");
    // A header that promises 0 x 2 or four billion squared pixels.
    let resized = |width: u32, height: u32| {
        let mut png = png.clone();
        png[16..20].copy_from_slice(&width.to_be_bytes());
        png[20..24].copy_from_slice(&height.to_be_bytes());
        let checksum = crc32(&png[12..29]);
        png[29..33].copy_from_slice(&checksum.to_be_bytes());
        image(embedded.clone(), &png)
    };
    assert_eq!(resized(2, 2), "no fault");
    assert_eq!(resized(0, 2), "image");
    assert_eq!(resized(1 << 20, 1 << 20), "limit");
    let texture = |texture: Value| {
        spoiled(|file| {
            file.json["textures"] = json!([texture]);
            file.material(json!({"emissiveTexture": {"index": 0}}));
        })
    };
    assert_eq!(texture(json!({})), "UNDEFINED_PROPERTY");
    assert_eq!(texture(json!({"source": 0})), "UNRESOLVED_REFERENCE");
    let sampler = spoiled(|file| {
        let texture = file.texture(&png);
        file.json["textures"][texture]["sampler"] = json!(0);
        file.json["samplers"] = json!([{"wrapS": 1}]);
        file.material(json!({"emissiveTexture": {"index": texture}}));
    });
    assert_eq!(sampler, "VALUE_NOT_IN_LIST");
}

/// CRC-32 of PNG chunks (ISO 3309).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn r01_required_extensions_are_named_together() {
    let mut file = GltfFile::triangle();
    file.json["extensionsRequired"] =
        json!(["ACME_more", "KHR_mesh_quantization", "ACME_magic", "ACME_magic"]);
    let message = file.load().unwrap_err().to_string();
    for name in ["ACME_more", "ACME_magic", "export without it"] {
        assert!(message.contains(name), "{message}");
    }
    assert_eq!(message.matches("ACME_magic").count(), 1);
    assert!(!message.contains("KHR_mesh_quantization"));
}

/// A build without decoders says so, and what to do.
#[cfg(not(feature = "compressed"))]
#[test]
fn r01_absent_fallbacks_are_refused() {
    let mut file = GltfFile::triangle();
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression", "KHR_texture_basisu"]);
    let message = file.load().unwrap_err().to_string();
    for name in ["KHR_draco_mesh_compression", "KHR_texture_basisu", "gltf-transform", "`compressed`"] {
        assert!(message.contains(name), "{message}");
    }
    let draco = spoiled(|file| {
        file.json["accessors"][0] = json!({"componentType": F32, "type": "VEC3", "count": 3});
        file.json["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    });
    assert_eq!(draco, "extensions");
    let basis = spoiled(|file| {
        file.json["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
        file.material(json!({"emissiveTexture": {"index": 0}}));
    });
    assert_eq!(basis, "extensions");
}

#[test]
fn r01_totals_are_limited_before_flattening() {
    let mut file = GltfFile::triangle();
    let zeros = json!({"componentType": F32, "type": "VEC3", "count": 1_000_000});
    let translations = file.push("accessors", zeros);
    file.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translations}}});
    let mut options = LoadOptions::default();
    options.limits.vertices = 1000;
    let error = load_slice(&file.gltf(), None, &options).unwrap_err();
    assert!(matches!(error, SceneError::Limit { what: "vertices", count: 3_000_000, limit: 1000 }));
}

const CANARY: &str = "the canary sings outside";

/// Every URI that leads out of the folder is refused, as a buffer and as an image, and nothing of the file outside
/// shows up in the message.
#[test]
fn r03_uris_stay_in_the_folder() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("scene");
    fs::create_dir_all(folder.join("inside")).unwrap();
    let canary = outer.path().join("canary.bin");
    fs::write(&canary, CANARY.repeat(4)).unwrap();
    let absolute = canary.to_str().unwrap();
    let mut attacks = vec![
        "../canary.bin".into(),
        "inside/../../canary.bin".into(),
        "./../canary.bin".into(),
        "%2e%2e/canary.bin".into(),
        "%2E%2E%2Fcanary.bin".into(),
        "..%2fcanary.bin".into(),
        "..\\canary.bin".into(),
        absolute.to_string(),
        absolute.replace('/', "%2f"),
        format!("/{absolute}"),
        format!("file://{absolute}"),
        format!("FILE:{absolute}"),
        format!("file%3A{absolute}"),
        "http://127.0.0.1/canary.bin".into(),
        "c:/canary.bin".into(),
        "inside.bin\0".into(),
        "inside.bin%00".into(),
        format!("{}canary.bin", "./".repeat(5000)),
        "%ff.bin".into(),
        String::new(),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&canary, folder.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(outer.path(), folder.join("way")).unwrap();
        attacks.extend(["link.bin".into(), "way/canary.bin".into()]);
    }
    let mut file = GltfFile::triangle();
    for uri in attacks {
        let as_buffer = file.with_buffer(Some(uri.clone()));
        file.json["images"] = json!([{"uri": uri}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.material(json!({"emissiveTexture": {"index": 0}}));
        let uvs = file.floats("VEC2", &[0.5; 6]);
        file.attribute("TEXCOORD_0", uvs);
        let as_image = file.gltf();
        for (bytes, options) in
            [(&as_buffer, LoadOptions::default()), (&as_buffer, strict()), (&as_image, strict())]
        {
            let error = load_slice(bytes, Some(&folder), &options).unwrap_err();
            assert!(matches!(error, SceneError::Uri { .. }), "{uri}: {error}");
            assert!(!format!("{error} {error:?}").contains(CANARY), "{uri}");
        }
        // An image that is refused is one that is missing.
        let scene = load_slice(&as_image, Some(&folder), &LoadOptions::default()).unwrap();
        let [warning] = scene.warnings.as_slice() else { panic!("{uri}: {:?}", scene.warnings) };
        assert!(warning.problem.starts_with("refused to read"), "{uri}: {warning}");
        assert!(!format!("{warning:?}").contains(CANARY), "{uri}");
        assert_eq!(scene.images[0].texels, [[255, 0, 255, 255]], "{uri}");
        file = GltfFile::triangle();
    }
}

#[test]
fn r03_uris_inside_are_read() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("a scene");
    fs::create_dir_all(folder.join("in side")).unwrap();
    let file = GltfFile::triangle();
    fs::write(folder.join("in side/a%b.bin"), &file.bin).unwrap();
    for uri in ["in%20side/a%25b.bin", "in side/a%25b.bin", "./in%20side/a%25b.bin"] {
        let bytes = file.with_buffer(Some(uri.into()));
        assert_eq!(code(load_slice(&bytes, Some(&folder), &LoadOptions::default())), "no fault", "{uri}");
    }
    assert_eq!(bytes_fault(&file.with_buffer(Some("in side/a%25b.bin".into()))), "uri");

    fs::write(outer.path().join("outside.bin"), &file.bin).unwrap();
    let outside = LoadOptions { allow_outside: true, ..LoadOptions::default() };
    let absolute = format!("file://{}", outer.path().join("outside.bin").display());
    for uri in ["../outside.bin", &absolute] {
        let bytes = file.with_buffer(Some(uri.into()));
        assert_eq!(code(load_slice(&bytes, Some(&folder), &outside)), "no fault", "{uri}");
    }
    assert_eq!(
        code(load_slice(&file.with_buffer(Some("http://a/b".into())), Some(&folder), &outside)),
        "uri"
    );
}

#[test]
fn r01_missing_and_unreadable_files() {
    let folder = tempfile::tempdir().unwrap();
    let options = LoadOptions::default();
    assert_eq!(code(load(&folder.path().join("none.glb"), &options)), "read");
    assert_eq!(code(load(folder.path(), &options)), "read");
    let path = GltfFile::triangle().write(folder.path());
    assert_eq!(code(load(&path, &options)), "no fault");
    fs::remove_file(folder.path().join("scene.bin")).unwrap();
    let error = load(&path, &options).unwrap_err();
    assert!(error.to_string().contains("scene.bin"), "{error}");
    // A device or a pipe instead of a file would never end.
    #[cfg(unix)]
    assert_eq!(code(load(std::path::Path::new("/dev/zero"), &options)), "read");
    let mut small = LoadOptions::default();
    small.limits.file_bytes = 10;
    assert_eq!(code(load(&path, &small)), "limit");
    let bad_base64 = GltfFile::triangle().with_buffer(Some("data:;base64,AA!A".into()));
    assert_eq!(bytes_fault(&bad_base64), "uri");
    assert_eq!(bytes_fault(&GltfFile::triangle().with_buffer(Some("data:base64".into()))), "uri");
}
