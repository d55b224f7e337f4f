//! The glTF loader on files of which one part is faulty: the rest is shown, and one warning names the part. Read strictly,
//! each of them is refused.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use halfway::scene::{LightKind, Scene};
use image::{DynamicImage, ImageFormat};
use serde_json::{Value, json};

use crate::gltf_file::{F32, GltfFile, U8, U16, encode};

/// Two nodes with a triangle each, of which the second mesh may be spoiled.
fn two_meshes(change: impl FnOnce(&mut GltfFile)) -> GltfFile {
    let mut file = GltfFile::triangle();
    file.push("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}}]}));
    file.push("nodes", json!({"mesh": 1}));
    change(&mut file);
    file
}

fn primitive(file: &mut GltfFile) -> &mut Value {
    &mut file.json["meshes"][1]["primitives"][0]
}

fn triangle_counts(scene: &Scene) -> Vec<usize> {
    scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect()
}

#[test]
fn a_faulty_mesh_is_left_out() {
    let indices = |component: u64, bytes: &[u8], count: usize| {
        two_meshes(|file| {
            let indices = file.accessor(bytes, component, "SCALAR", count);
            primitive(file)["indices"] = json!(indices);
        })
    };
    let positions = |bad: f32| {
        two_meshes(|file| {
            let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, bad, 0.0, 0.0, 1.0, 0.0]);
            primitive(file)["attributes"]["POSITION"] = json!(positions);
        })
    };
    for file in [
        indices(U8, &[0, 1, 3], 3),
        indices(U8, &[0, 1, 255], 3),
        indices(U16, &[0, 0, 1, 0, 0, 1], 3),
        indices(U8, &[0, 1], 2),
        positions(f32::NAN),
        positions(f32::INFINITY),
        two_meshes(|file| primitive(file)["indices"] = json!(77)),
        two_meshes(|file| primitive(file)["mode"] = json!(9)),
        two_meshes(|file| primitive(file)["attributes"]["POSITION"] = json!("0")),
    ] {
        assert_eq!(triangle_counts(&file.tolerated("meshes[1].primitives[0]")), [1]);
    }
    let nowhere = two_meshes(|file| file.json["nodes"][1]["mesh"] = json!(2));
    assert_eq!(triangle_counts(&nowhere.tolerated("nodes[1]")), [1]);
}

/// One of several buffers that is missing or cut short costs what is in it.
#[test]
fn a_missing_buffer_costs_what_is_in_it() {
    for buffer in [
        json!({"byteLength": 36, "uri": "not-there.bin"}),
        json!({"byteLength": 36, "uri": "http://example.com/a.bin"}),
        json!({"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAA"}),
    ] {
        let file = two_meshes(|file| {
            let whole: Value = serde_json::from_slice(&file.gltf()).unwrap();
            file.json["buffers"] = whole["buffers"].clone();
            file.push("buffers", buffer);
            let view = file.push("bufferViews", json!({"buffer": 1, "byteLength": 36}));
            let lost = json!({"bufferView": view, "componentType": F32, "type": "VEC3", "count": 3});
            let lost = file.push("accessors", lost);
            primitive(file)["attributes"]["POSITION"] = json!(lost);
        });
        assert_eq!(triangle_counts(&file.tolerated("meshes[1].primitives[0]")), [1]);
    }
}

/// However often a mesh is shown or posed, what is wrong with it is said once.
#[test]
fn a_fault_is_said_once() {
    let mut file = two_meshes(|file| primitive(file)["mode"] = json!(9));
    for weight in 0..3 {
        file.push("nodes", json!({"mesh": 1, "weights": [weight]}));
    }
    file.tolerated("meshes[1].primitives[0]");
}

#[test]
fn indices_beyond_the_last_whole_triangle_are_left_out() {
    let mut file = GltfFile::triangle();
    let indices = file.accessor(&[0, 1, 2, 0, 2, 1, 0], U8, "SCALAR", 7);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert_eq!(file.tolerated("meshes[0].primitives[0]").meshes[0].triangles, [[0, 1, 2], [0, 2, 1]]);
}

#[test]
fn normals_and_tangents_that_are_not_finite_are_computed() {
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.6, 0.0, 0.8, f32::NAN, 0.0, 1.0, 0.6, 0.0, 0.8]);
    file.attribute("NORMAL", normals);
    let scene = file.tolerated("meshes[0].primitives[0]");
    let normals = scene.meshes[0].normals.as_ref().unwrap();
    assert_eq!((normals[0], normals[1]), (Vec3::new(0.6, 0.0, 0.8), Vec3::Z));

    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let uvs = file.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let tangents = file.floats("VEC4", &[f32::NAN, 0.0, 0.0, 1.0].repeat(3));
    file.attribute("NORMAL", normals);
    file.attribute("TEXCOORD_0", uvs);
    file.attribute("TANGENT", tangents);
    let texture = file.texture(&encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png));
    file.material(json!({"normalTexture": {"index": texture}}));
    let scene = file.tolerated("meshes[0].primitives[0]");
    let tangents = scene.meshes[0].tangents.as_ref().unwrap();
    assert!(tangents.iter().all(|tangent| tangent.truncate() == Vec3::X), "{tangents:?}");
}

#[test]
fn other_attributes_are_left_out_alone() {
    for (name, kind, lanes) in [("TEXCOORD_0", "VEC2", 2), ("COLOR_0", "VEC4", 4)] {
        let mut file = GltfFile::triangle();
        let values = file.floats(kind, &vec![f32::NAN; 3 * lanes]);
        file.attribute(name, values);
        let scene = file.tolerated("meshes[0].primitives[0]");
        let mesh = &scene.meshes[0];
        assert!(mesh.triangles.len() == 1 && mesh.uvs[0].is_none() && mesh.colors.is_none(), "{name}");
    }
    let mut file = GltfFile::triangle();
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0]);
    file.attribute("NORMAL", normals);
    assert!(file.tolerated("meshes[0].primitives[0]").meshes[0].normals.is_none());
}

#[test]
fn vertices_without_weight_go_with_their_first_joint() {
    let mut file = GltfFile::triangle();
    let joints = file.accessor(&[1, 0, 0, 0].repeat(3), U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0]);
    file.attribute("JOINTS_0", joints);
    file.attribute("WEIGHTS_0", weights);
    file.push("nodes", json!({"translation": [0, 0, 5]}));
    file.json["skins"] = json!([{"joints": [0, 1]}]);
    file.json["nodes"][0]["skin"] = json!(0);
    let scene = file.tolerated("meshes[0].primitives[0]");
    let up = 5.0 * DVec3::Z;
    assert_eq!(scene.meshes[0].positions, [up, DVec3::X + up, DVec3::Y + up]);
}

#[test]
fn a_scene_that_lists_a_child_shows_it_once() {
    let mut file = GltfFile::triangle();
    file.json["nodes"] =
        json!([{"children": [1], "translation": [0, 0, 1]}, {"mesh": 0, "children": [2]}, {"mesh": 0}]);
    for listed in [json!([0, 1, 2]), json!([2, 1, 0]), json!([2, 0])] {
        file.json["scenes"] = json!([{"nodes": listed}]);
        let scene = file.tolerated("nodes[");
        assert_eq!(triangle_counts(&scene), [1, 1], "{listed}");
        assert!(scene.meshes.iter().all(|mesh| mesh.positions[0] == DVec3::Z), "{listed}");
    }
    // The child alone, where its parent puts it.
    file.json["scenes"] = json!([{"nodes": [1]}]);
    let scene = file.tolerated("nodes[1]");
    assert!(scene.meshes.len() == 2 && scene.meshes[0].positions[0] == DVec3::Z);
}

#[test]
fn faulty_nodes_are_left_out_or_mended() {
    let nodes = |nodes: Value| {
        let mut file = GltfFile::triangle();
        file.json["nodes"] = nodes;
        file
    };
    let shown = |nodes: GltfFile, part| nodes.tolerated(part).meshes.len();
    let loops =
        json!([{"mesh": 0}, {"mesh": 0, "children": [2]}, {"mesh": 0, "children": [1, 3]}, {"mesh": 0}]);
    assert_eq!(shown(nodes(loops.clone()), "nodes[1]"), 1);
    let mut listed = nodes(loops);
    listed.json["scenes"] = json!([{"nodes": [0, 1]}]);
    assert_eq!(shown(listed, "nodes[1]"), 1);
    assert_eq!(shown(nodes(json!([{"mesh": 0, "children": [7]}])), "nodes[0]"), 1);
    let twice = json!([{"children": [2]}, {"children": [2]}, {"mesh": 0}]);
    assert_eq!(shown(nodes(twice), "nodes[2]"), 1);
    let huge =
        json!([{"scale": [1e308, 1, 1], "children": [1]}, {"scale": [1e308, 1, 1], "mesh": 0}, {"mesh": 0}]);
    assert_eq!(shown(nodes(huge), "nodes[1]"), 1);
    let mut elsewhere = GltfFile::triangle();
    elsewhere.json["scenes"] = json!([{"nodes": [0]}]);
    elsewhere.json["scene"] = json!(3);
    assert_eq!(shown(elsewhere, "scene"), 1);

    let unrotated = nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0], "translation": [0, 0, 1]}]));
    assert_eq!(unrotated.tolerated("nodes[0]").meshes[0].positions[0], DVec3::Z);
    let projective = nodes(json!([{"mesh": 0, "matrix": [1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,1,1]}]));
    assert_eq!(projective.tolerated("nodes[0]").meshes[0].positions[1], DVec3::new(1.0, 0.0, 1.0));
}

#[test]
fn a_faulty_camera_is_left_out() {
    for faulty in [
        json!({"type": "perspective", "perspective": {"yfov": 0}}),
        json!({"type": "perspective", "perspective": {}}),
        json!({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}}),
        json!({"type": "fisheye"}),
    ] {
        let mut file = GltfFile::triangle();
        file.json["cameras"] = json!([faulty, {"type": "perspective", "perspective": {"yfov": 1}}]);
        file.push("nodes", json!({"camera": 0}));
        file.push("nodes", json!({"camera": 1, "name": "right"}));
        let scene = file.tolerated("nodes[1]");
        assert!(scene.cameras.len() == 1 && scene.cameras[0].name == "right");
    }
}

#[test]
fn faulty_lights_are_left_out_or_cut() {
    let lights = |light: Value| {
        let mut file = GltfFile::triangle();
        file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light, {"type": "point"}]}});
        for light in 0..2 {
            file.push("nodes", json!({"extensions": {"KHR_lights_punctual": {"light": light}}}));
        }
        file
    };
    for light in [
        json!({"type": "area"}),
        json!({}),
        json!({"type": "point", "intensity": "1"}),
        json!({"type": "spot", "spot": {"outerConeAngle": 0}}),
    ] {
        let kinds = lights(light).tolerated("light 0 at nodes[1]").lights;
        assert!(kinds.len() == 1 && kinds[0].kind == LightKind::Point);
    }
    let cone = |inner: f64, outer: f64| {
        let cone = json!({"innerConeAngle": inner, "outerConeAngle": outer});
        match lights(json!({"type": "spot", "spot": cone})).tolerated("light 0 at nodes[1]").lights[0].kind {
            LightKind::Spot { inner, outer } => [inner, outer],
            kind => panic!("{kind:?}"),
        }
    };
    assert_eq!(cone(0.5, 0.5), [0.5, 0.5]);
    assert_eq!(cone(0.75, 0.5), [0.5, 0.5]);
    assert_eq!(cone(0.25, 1.5709), [0.25, FRAC_PI_2]);
    assert_eq!(cone(-0.1, 0.5), [0.0, 0.5]);
    // Pi/2 as single precision rounds it is right.
    let half = f64::from(FRAC_PI_2);
    let right = lights(json!({"type": "spot", "spot": {"outerConeAngle": half}})).scene();
    assert!(right.warnings.is_empty() && right.lights.len() == 2);
}

/// Every slot of a material, with one texture.
fn all_slots(texture: usize) -> Value {
    let info = json!({"index": texture});
    json!({
        "pbrMetallicRoughness": {"baseColorTexture": info, "metallicRoughnessTexture": info},
        "normalTexture": info, "emissiveTexture": info, "emissiveFactor": [1, 1, 1],
        "extensions": {
            "KHR_materials_specular": {"specularTexture": info, "specularColorTexture": info},
            "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": info},
        },
    })
}

#[test]
fn a_missing_texture_is_magenta_or_not_used() {
    let with = |image: Value, texture: Value, picture: &[u8]| {
        let mut file = GltfFile::triangle();
        let uvs = file.floats("VEC2", &[0.5; 6]);
        file.attribute("TEXCOORD_0", uvs);
        let whole = file.texture(&encode(&DynamicImage::new_rgb8(2, 2), ImageFormat::Png));
        assert_eq!((whole, file.view(picture)), (0, 3));
        file.push("images", image);
        file.push("textures", texture);
        file.material(all_slots(1));
        file
    };
    let png = encode(&DynamicImage::new_rgb8(2, 2), ImageFormat::Png);
    let embedded = json!({"bufferView": 3});
    let source = json!({"source": 1});
    for (image, picture) in [
        (json!({"uri": "missing.png"}), png.as_slice()),
        (json!({"uri": "data:image/png;base64,AA!A"}), &png),
        (json!({}), &png),
        (json!({"bufferView": 99}), &png),
        (embedded.clone(), &png[..40]),
        (embedded.clone(), b"nothing"),
        (embedded.clone(), b"GIF89a\x01\0\x01\0\0\0\0;"),
    ] {
        let scene = with(image, source.clone(), picture).tolerated("images[1]");
        let material = &scene.materials[0];
        let colors =
            [material.base_color_texture, material.emission_texture, material.specular_color_texture];
        for texture in colors.map(Option::unwrap) {
            let image = &scene.images[scene.textures[texture.texture as usize].image as usize];
            assert_eq!(image.texels, [[255, 0, 255, 255]]);
        }
        assert_eq!(material.textures().count(), 3, "normals, roughness and the like cannot be magenta");
    }
    // A texture that leads to no image is named by what uses it, once.
    for (texture, part) in [(json!({}), "materials[0]"), (json!({"source": 7}), "materials[0]")] {
        let mut file = with(embedded.clone(), texture, &png);
        file.material(json!({"emissiveTexture": {"index": 1}, "emissiveFactor": [1, 1, 1]}));
        let scene = file.tolerated(part);
        let texture = scene.materials[0].emission_texture.unwrap();
        let image = &scene.images[scene.textures[texture.texture as usize].image as usize];
        assert_eq!(image.texels, [[255, 0, 255, 255]]);
    }
    let sampled = with(embedded, json!({"source": 1, "sampler": 0}), &png);
    assert_eq!(sampled.tolerated("textures[1]").materials[0].textures().count(), 7);
}

#[test]
fn a_faulty_material_is_magenta() {
    let mut file = two_meshes(|file| primitive(file)["material"] = json!(0));
    for faulty in [json!({"alphaMode": "DITHER"}), json!({"extensions": {"KHR_materials_ior": {"ior": "x"}}})]
    {
        file.json["materials"] = json!([faulty]);
        let scene = file.tolerated("materials[0]");
        let color = scene.materials[scene.meshes[1].material as usize].base_color;
        assert_eq!((scene.meshes.len(), color), (2, Vec3::new(1.0, 0.0, 1.0)));
    }
    file.json["materials"] = json!([]);
    assert_eq!(file.tolerated("meshes[1].primitives[0]").meshes.len(), 2);
}

/// Every integer of a document, written with a fraction.
#[test]
fn integers_may_be_written_with_a_fraction() {
    fn spoil(value: &mut Value) {
        match value {
            Value::Number(number) => *value = json!(number.as_f64().unwrap()),
            Value::Array(items) => items.iter_mut().for_each(spoil),
            Value::Object(members) => members.values_mut().for_each(spoil),
            _ => {}
        }
    }
    let mut file = GltfFile::triangle();
    let indices = file.accessor(&[0, 2, 1], U8, "SCALAR", 3);
    let targets = file.push("accessors", json!({"componentType": F32, "type": "VEC3", "count": 3}));
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["indices"] = json!(indices);
    primitive["targets"] = json!([{"POSITION": targets}]);
    let texture = file.texture(&encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png));
    file.material(json!({"emissiveTexture": {"index": texture, "texCoord": 0}, "alphaCutoff": 1}));
    let uvs = file.floats("VEC2", &[0.5; 6]);
    file.attribute("TEXCOORD_0", uvs);
    file.json["scenes"] = json!([{"nodes": [0]}]);
    file.json["scene"] = json!(0);
    file.json["extras"] = json!({"resolution": [4, 2], "count": 3});
    let mut spoilt = file.clone();
    for (name, member) in spoilt.json.as_object_mut().unwrap() {
        if name != "extras" {
            spoil(member);
        }
    }
    let scene = spoilt.tolerated("accessors[0].");
    let whole = file.scene();
    assert!(scene.content_hash() == whole.content_hash() && scene.resolution == Some([4, 2]));
    assert!(whole.warnings.is_empty());
    // A number that is no integer at all stays an error.
    file.json["nodes"][0]["mesh"] = json!(0.5);
    assert!(file.load().is_err());
}

/// A part of the document whose shape is not glTF's.
#[test]
fn a_malformed_part_is_one_faulty_part() {
    let spoiled = |pointer: &str, value: Value| {
        let mut file = two_meshes(|file| primitive(file)["material"] = json!(0));
        let uvs = file.floats("VEC2", &[0.5; 6]);
        primitive(&mut file)["attributes"]["TEXCOORD_0"] = json!(uvs);
        let texture = file.texture(&encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png));
        file.json["materials"] = json!([{"emissiveTexture": {"index": texture}}]);
        file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1}}]);
        file.push("nodes", json!({"camera": 0}));
        *file.json.pointer_mut(pointer).unwrap() = value;
        file
    };
    let shown = |file: GltfFile, part: &str| {
        let scene = file.tolerated(part);
        (scene.meshes.len(), scene.cameras.len())
    };
    assert_eq!(shown(spoiled("/meshes/1/primitives/0", json!(5)), "meshes[1].primitives[0]"), (1, 1));
    assert_eq!(shown(spoiled("/meshes/1", json!({"primitives": 5})), "nodes[1]"), (1, 1));
    assert_eq!(shown(spoiled("/accessors/1/count", json!("3")), "meshes[1].primitives[0]"), (2, 1));
    assert_eq!(shown(spoiled("/bufferViews/1/byteLength", json!("3")), "meshes[1].primitives[0]"), (2, 1));
    assert_eq!(shown(spoiled("/cameras/0/perspective/yfov", json!("1")), "nodes[2]"), (2, 0));
    assert_eq!(shown(spoiled("/materials/0", json!({"doubleSided": 1})), "materials[0]"), (2, 1));
    assert_eq!(shown(spoiled("/textures/0", json!({"source": "0"})), "materials[0]"), (2, 1));
    assert_eq!(shown(spoiled("/images/0", json!({"bufferView": -1})), "images[0]"), (2, 1));
}

/// The document's reader has types for more than is looked at here, and falls over what they do not hold.
#[test]
fn what_is_not_read_costs_nothing() {
    let mut file = two_meshes(|file| primitive(file)["material"] = json!(0));
    let uvs = file.floats("VEC2", &[0.5; 6]);
    primitive(&mut file)["attributes"]["TEXCOORD_0"] = json!(uvs);
    let texture = file.texture(&encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png));
    file.json["textures"][texture]["sampler"] = json!(0);
    file.json["samplers"] = json!([{}]);
    file.json["materials"] = json!([{"emissiveTexture": {"index": texture}}]);
    file.json["skins"] = json!([{"joints": [0]}]);
    file.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    file.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1}},
    ]);
    file.push("nodes", json!({"camera": 0}));
    file.push("nodes", json!({"camera": 1}));
    let plain = file.scene();
    assert!(plain.warnings.is_empty() && plain.cameras.len() == 2, "{:?}", plain.warnings);
    for (pointer, name, value) in [
        ("", "animations", json!([{"channels": 5}])),
        ("/asset", "version", json!(2.0)),
        ("/accessors/0", "min", json!("low")),
        ("/accessors/0", "name", json!(1)),
        ("/bufferViews/0", "target", json!(-1)),
        ("/cameras/0/perspective", "znear", json!("0.1")),
        ("/cameras/1/orthographic", "zfar", json!("100")),
        ("/images/0", "mimeType", json!(1)),
        ("/materials/0", "occlusionTexture", json!({"index": "x"})),
        ("/materials/0", "pbrMetallicRoughness", json!(null)),
        ("/materials/0", "name", json!(null)),
        ("/meshes/0", "extras", json!([{"a": null}])),
        ("/nodes/0", "camera", json!(null)),
        ("/samplers/0", "minFilter", json!("x")),
        ("/skins/0", "skeleton", json!(-1)),
    ] {
        let mut other = file.clone();
        other.json.pointer_mut(pointer).unwrap()[name] = value;
        let scene = other.scene();
        assert!(scene.warnings.is_empty(), "{pointer}/{name}: {:?}", scene.warnings);
        assert_eq!(scene.content_hash(), plain.content_hash(), "{pointer}/{name}");
    }
}

/// Numbers that single precision does not hold, where the document's reader has it.
#[test]
fn transforms_and_weights_are_in_double_precision() {
    let mut file = GltfFile::triangle();
    let deltas = file.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": deltas}]);
    let exact = 1.0 / 3.0;
    file.json["meshes"][0]["weights"] = json!([exact]);
    file.json["nodes"] = json!([{"mesh": 0, "translation": [0, exact, 0]}]);
    let position = |file: &GltfFile| file.scene().meshes[0].positions[0];
    assert_eq!(position(&file), DVec3::new(exact, exact, 0.0));
    file.json["nodes"][0]["weights"] = json!([0.1]);
    assert_eq!(position(&file), DVec3::new(0.1, exact, 0.0));
}
