//! Extensions that choose what is shown: variants, visibility, specular-glossiness, further texture coordinates.

use glam::{Vec2, Vec3};
use halfway::scene::gltf::{LoadOptions, load_slice};
use halfway::scene::{Image, Scene, SceneError, TextureRef};
use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
use serde_json::{Value, json};

use crate::gltf_file::{GltfFile, encode};

const GLOSSY: &str = "KHR_materials_pbrSpecularGlossiness";

fn load(file: &GltfFile, variant: Option<&str>) -> Result<Scene, SceneError> {
    let options = LoadOptions { variant: variant.map(String::from), ..LoadOptions::default() };
    load_slice(&file.gltf(), None, &options)
}

/// A triangle that is red, or what two variants have it, of which the second leaves a second triangle as it is.
fn with_variants() -> GltfFile {
    let mut file = GltfFile::triangle();
    let color = |color: [f64; 4]| json!({"pbrMetallicRoughness": {"baseColorFactor": color}});
    file.json["materials"] =
        json!([color([1.0, 0.0, 0.0, 1.0]), color([0.0, 1.0, 0.0, 1.0]), color([0.0, 0.0, 1.0, 1.0])]);
    let mappings = json!([{"material": 1, "variants": [1]}, {"material": 2, "variants": [0, 7]}]);
    file.json["meshes"][0]["primitives"] = json!([
        {"attributes": {"POSITION": 0}, "material": 0, "extensions": {"KHR_materials_variants": {"mappings": mappings}}},
        {"attributes": {"POSITION": 0}, "material": 0, "extensions": {"KHR_materials_variants":
            {"mappings": [{"material": 2, "variants": [0]}]}}},
    ]);
    file.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "night"}, {"name": "day"}]}});
    file.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    file.json["extensionsRequired"] = json!(["KHR_materials_variants"]);
    file
}

#[test]
fn a_variant_is_shown_by_its_name() {
    let file = with_variants();
    let colors = |variant| {
        let scene = load(&file, variant).unwrap();
        assert!(scene.warnings.is_empty() && scene.variants == ["night", "day"], "{:?}", scene.warnings);
        scene.meshes.iter().map(|mesh| scene.materials[mesh.material as usize].base_color).collect::<Vec<_>>()
    };
    assert_eq!(colors(None), [Vec3::X, Vec3::X]);
    assert_eq!(colors(Some("night")), [Vec3::Z, Vec3::Z]);
    assert_eq!(colors(Some("day")), [Vec3::Y, Vec3::X]);

    let error = load(&file, Some("Day")).unwrap_err().to_string();
    assert!(error.contains("'Day'") && error.contains("night, day"), "{error}");
    let error = load(&GltfFile::triangle(), Some("day")).unwrap_err().to_string();
    assert!(error.contains("none") && error.contains("--variant"), "{error}");
}

#[test]
fn faulty_variants_cost_themselves() {
    let red = |mut file: GltfFile, pointer: &str, value: Value, part: &str| {
        *file.json.pointer_mut(pointer).unwrap() = value;
        let scene = file.tolerated(part);
        assert!(scene.materials.iter().all(|material| material.base_color == Vec3::X), "{part}");
        assert_eq!(scene.meshes.len(), 2);
    };
    let mappings = "/meshes/0/primitives/1/extensions/KHR_materials_variants/mappings";
    red(with_variants(), mappings, json!(3), "meshes[0].primitives[1]");
    red(with_variants(), mappings, json!([{"variants": [0]}]), "meshes[0].primitives[1]");
    red(with_variants(), "/extensions/KHR_materials_variants/variants", json!([5]), "KHR_materials_variants");
    // A material that is not there.
    let mut file = with_variants();
    file.json.pointer_mut(mappings).unwrap()[0]["material"] = json!(1_u64 << 32);
    let scene = load(&file, Some("night")).unwrap();
    assert!(scene.warnings[0].part.starts_with("meshes[0].primitives[1]"), "{:?}", scene.warnings);
}

#[test]
fn invisible_nodes_hide_what_is_below_them() {
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    let mut file = GltfFile::triangle();
    file.json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    let light = json!({"KHR_lights_punctual": {"light": 0}});
    file.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "extensions": hidden},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}, "KHR_lights_punctual": light["KHR_lights_punctual"]}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {}}},
        {"mesh": 0, "name": "plain", "extensions": light},
    ]);
    let scene = file.scene();
    assert_eq!((scene.meshes.len(), scene.lights.len(), scene.warnings.len()), (2, 1, 0));
    // A joint that is hidden moves what hangs from it all the same.
    file.json["nodes"][2]["extensions"] = json!({"KHR_node_visibility": {"visible": "no"}});
    assert_eq!(file.tolerated("nodes[2]").meshes.len(), 2);
}

#[test]
fn specular_glossiness_is_a_dielectric_of_that_reflectance() {
    let glossy = |glossy: Value, beside: Option<Value>| {
        let mut file = GltfFile::triangle();
        let uvs = file.floats("VEC2", &[0.5; 6]);
        file.attribute("TEXCOORD_0", uvs);
        let texels = [[10, 20, 30, 0], [10, 20, 30, 51], [10, 20, 30, 255], [10, 20, 30, 128]];
        let picture = RgbaImage::from_fn(4, 1, |x, _| Rgba(texels[x as usize]));
        file.texture(&encode(&DynamicImage::from(picture), ImageFormat::Png));
        let mut material = json!({"extensions": {GLOSSY: glossy}});
        if let Some(beside) = beside {
            material["pbrMetallicRoughness"] = beside;
        }
        file.material(material);
        file.json["extensionsUsed"] = json!([GLOSSY]);
        file.scene()
    };
    let factors = json!({
        "diffuseFactor": [0.5, 0.25, 0.125, 0.75], "specularFactor": [0.25, 0.5, 1], "glossinessFactor": 0.75,
    });
    for beside in [None, Some(json!({})), Some(json!({"metallicFactor": 1}))] {
        let scene = glossy(factors.clone(), beside);
        let found = &scene.materials[0];
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!((found.base_color, found.alpha), (Vec3::new(0.5, 0.25, 0.125), 0.75));
        assert_eq!((found.metallic, found.roughness), (0.0, 0.25));
        let normal = ((found.ior - 1.0) / (found.ior + 1.0)).powi(2);
        let reflectance = normal * found.specular * found.specular_color;
        assert!((reflectance - Vec3::new(0.25, 0.5, 1.0)).abs().max_element() < 0.005, "{reflectance}");
    }
    let info = json!({"index": 0});
    let scene = glossy(
        json!({"diffuseTexture": info, "specularGlossinessTexture": info, "glossinessFactor": 0.5}),
        None,
    );
    let found = &scene.materials[0];
    let image = |slot: Option<TextureRef>| -> &Image {
        &scene.images[scene.textures[slot.unwrap().texture as usize].image as usize]
    };
    assert_eq!(image(found.base_color_texture).texels, image(found.specular_color_texture).texels);
    // Roughness is 1 - 0.5 * alpha.
    let rough: Vec<u8> =
        image(found.metallic_roughness_texture).texels.iter().map(|texel| texel[1]).collect();
    assert_eq!((rough, found.roughness), (vec![255, 230, 128, 191], 1.0));
    assert_eq!(scene.images.len(), 2, "the picture is there once");
    assert_eq!(scene.images[1].width, 4);

    let scene = glossy(factors, Some(json!({"metallicFactor": 0.5})));
    assert!(scene.materials[0].metallic == 0.5 && scene.warnings.len() == 1, "{:?}", scene.warnings);
}

#[test]
fn any_two_sets_of_texture_coordinates_are_read() {
    let file = |sets: &[u32]| {
        let mut file = GltfFile::triangle();
        for set in 0..10 {
            let uvs = file.floats("VEC2", &[set as f32; 6]);
            file.attribute(&format!("TEXCOORD_{set}"), uvs);
        }
        file.texture(&encode(&DynamicImage::new_rgb8(1, 1), ImageFormat::Png));
        let info = |slot: usize| json!({"index": 0, "texCoord": sets[slot.min(sets.len() - 1)]});
        file.material(json!({
            "emissiveTexture": info(2), "normalTexture": info(1), "pbrMetallicRoughness": {"baseColorTexture": info(0)},
        }));
        file
    };
    let seen = |scene: &Scene| {
        let (mesh, material) = (&scene.meshes[0], &scene.materials[0]);
        let slots = [material.base_color_texture, material.normal_texture, material.emission_texture];
        slots.map(|slot| {
            let uvs: &Vec<Vec2> = mesh.uvs[slot?.uv_set as usize].as_ref()?;
            Some(uvs[0].x)
        })
    };
    for sets in
        [[0, 1, 1], [1, 1, 0], [0, 2, 2], [1, 2, 1], [2, 1, 2], [2, 2, 2], [3, 2, 3], [9, 4, 4], [7, 0, 7]]
    {
        let scene = file(&sets).scene();
        assert!(scene.warnings.is_empty(), "{sets:?}: {:?}", scene.warnings);
        assert_eq!(seen(&scene), sets.map(|set| Some(set as f32)), "{sets:?}");
    }
    // A third set is said, and its texture left out.
    let scene = file(&[0, 2, 3]).scene();
    assert_eq!(seen(&scene), [Some(0.0), Some(2.0), None]);
    assert!(scene.warnings.len() == 1 && scene.warnings[0].problem.contains("TEXCOORD_3"));
}
