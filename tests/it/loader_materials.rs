//! Materials, textures, images and tangents as the glTF loader reads them.

use glam::{Vec2, Vec3, Vec4};
use halfway::scene::{AlphaMode, Filter, Material, Scene, Wrap};
use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage, Rgba, RgbaImage};
use serde_json::{Value, json};

use crate::gltf_file::{GltfFile, U8, encode};

fn picture() -> RgbaImage {
    RgbaImage::from_fn(2, 3, |x, y| Rgba([10 * x as u8, 20 * y as u8, 200, 128 + x as u8]))
}

fn png() -> Vec<u8> {
    encode(&picture().into(), ImageFormat::Png)
}

/// A triangle with uvs under a material that may use texture 0.
fn textured(material: Value) -> GltfFile {
    let mut file = GltfFile::triangle();
    let uvs = file.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    file.attribute("TEXCOORD_0", uvs);
    file.texture(&png());
    file.material(material);
    file
}

fn material(material: Value) -> Material {
    textured(material).scene().materials.remove(0)
}

#[test]
fn defaults_are_those_of_gltf() {
    assert_eq!(material(json!({"name": "m"})), Material { name: "m".into(), ..Material::default() });
    assert_eq!(material(json!({"pbrMetallicRoughness": {}})).base_color, Vec3::ONE);
}

#[test]
fn metallic_roughness_and_emission() {
    let found = material(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
            "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0},
        },
        "normalTexture": {"index": 0, "scale": -2}, "emissiveTexture": {"index": 0},
        "occlusionTexture": {"index": 0, "strength": 0.5},
        "emissiveFactor": [1, 0.5, 0.25], "alphaMode": "MASK", "alphaCutoff": 0.7, "doubleSided": true,
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    }));
    assert_eq!(found.base_color, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((found.alpha, found.metallic, found.roughness, found.normal_scale), (0.4, 0.5, 0.6, -2.0));
    assert_eq!(found.emission, Vec3::new(8.0, 4.0, 2.0));
    assert_eq!(found.alpha_mode, AlphaMode::Mask { cutoff: 0.7 });
    assert!(found.double_sided);
    assert_eq!(found.textures().count(), 4);
    assert_eq!(material(json!({"alphaMode": "MASK"})).alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(material(json!({"alphaMode": "BLEND"})).alpha_mode, AlphaMode::Blend);
    assert!(material(json!({"extensions": {"KHR_materials_unlit": {}}})).unlit);
}

#[test]
fn dielectric_extensions() {
    let found = material(json!({"extensions": {
        "KHR_materials_ior": {"ior": 1.33},
        "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": {"index": 0},
            "specularColorFactor": [2, 1, 0], "specularColorTexture": {"index": 0},
        },
        "KHR_materials_transmission": {"transmissionFactor": 0.9, "transmissionTexture": {"index": 0}},
        "KHR_materials_volume": {
            "thicknessFactor": 0.1, "attenuationDistance": 2, "attenuationColor": [0.5, 0.6, 0.7],
        },
    }}));
    assert_eq!((found.ior, found.specular, found.transmission), (1.33, 0.5, 0.9));
    assert_eq!(found.specular_color, Vec3::new(2.0, 1.0, 0.0));
    assert!(found.volume && found.textures().count() == 3);
    assert_eq!((found.attenuation_distance, found.attenuation_color), (2.0, Vec3::new(0.5, 0.6, 0.7)));

    let volume = |volume: Value| material(json!({"extensions": {"KHR_materials_volume": volume}}));
    assert!(!volume(json!({})).volume);
    assert_eq!(volume(json!({})).attenuation_distance, f32::INFINITY);
    assert!(volume(json!({"thicknessTexture": {"index": 0}})).volume);
    // 0 stands for an infinite index: everything is reflected.
    let ior = material(json!({"extensions": {"KHR_materials_ior": {"ior": 0}}})).ior;
    assert!(((ior - 1.0) / (ior + 1.0)).powi(2) > 0.99);
}

#[test]
fn factors_beyond_their_range_are_cut_with_a_warning() {
    let scene =
        textured(json!({"pbrMetallicRoughness": {"metallicFactor": 1.0001, "roughnessFactor": -1}})).scene();
    assert_eq!((scene.materials[0].metallic, scene.materials[0].roughness), (1.0, 0.0));
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
}

/// The example of KHR_texture_transform's text: the lower left quadrant, turned.
#[test]
fn texture_transform() {
    let transform = json!({"offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.5]});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let found = material(json!({"emissiveTexture": info})).emission_texture.unwrap();
    for (uv, expected) in [
        (Vec2::new(0.0, 0.0), Vec2::new(0.0, 1.0)),
        (Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.5)),
        (Vec2::new(0.0, 1.0), Vec2::new(0.5, 1.0)),
        (Vec2::new(1.0, 1.0), Vec2::new(0.5, 0.5)),
    ] {
        assert!((found.transform.transform_point2(uv) - expected).length() < 1e-6, "{uv}");
    }
    // Scale comes before rotation, offset last; texCoord overrides.
    let transform =
        json!({"offset": [10, 20], "rotation": -std::f64::consts::FRAC_PI_2, "scale": [2, 3], "texCoord": 1});
    let info = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": transform}});
    let mut file = textured(json!({"emissiveTexture": info}));
    let uvs = file.floats("VEC2", &[0.0; 6]);
    file.attribute("TEXCOORD_1", uvs);
    let found = file.scene().materials[0].emission_texture.unwrap();
    assert_eq!(found.uv_set, 1);
    assert!((found.transform.transform_point2(Vec2::new(1.0, 1.0)) - Vec2::new(7.0, 22.0)).length() < 1e-5);
}

#[test]
fn samplers_and_sharing() {
    let mut file = textured(json!({
        "emissiveTexture": {"index": 0}, "normalTexture": {"index": 1},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    }));
    file.push("textures", json!({"source": 0, "sampler": 0}));
    file.push("textures", json!({"source": 99}));
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}]);
    let scene = file.scene();
    // Texture 2 is broken, but nothing uses it.
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 2));
    let material = &scene.materials[0];
    assert_eq!(material.emission_texture, material.base_color_texture);
    let texture = |slot: Option<halfway::scene::TextureRef>| scene.textures[slot.unwrap().texture as usize];
    let plain = texture(material.emission_texture);
    assert_eq!((plain.wrap, plain.filter), ([Wrap::Repeat; 2], Filter::Linear));
    let other = texture(material.normal_texture);
    assert_eq!((other.wrap, other.filter), ([Wrap::Clamp, Wrap::Mirror], Filter::Nearest));
}

fn with_picture(picture: &[u8]) -> Scene {
    let mut file = textured(json!({"emissiveTexture": {"index": 1}}));
    file.texture(picture);
    file.scene()
}

#[test]
fn images_of_all_formats() {
    let expected: Vec<[u8; 4]> = picture().pixels().map(|pixel| pixel.0).collect();
    for format in [ImageFormat::Png, ImageFormat::WebP] {
        let scene = with_picture(&encode(&picture().into(), format));
        assert_eq!((scene.images[0].width, scene.images[0].height), (2, 3));
        assert_eq!(scene.images[0].texels, expected, "{format:?}");
        assert!(scene.warnings.is_empty());
    }
    let gray = DynamicImage::from(RgbImage::from_pixel(8, 8, Rgb([77, 77, 77])));
    let scene = with_picture(&encode(&gray, ImageFormat::Jpeg));
    assert!(scene.images[0].texels.iter().all(|texel| texel[..3].iter().all(|c| c.abs_diff(77) <= 1)));
    assert_eq!(scene.images[0].texels[0][3], 255);
    let gray = gray.into_luma8().into();
    assert_eq!(with_picture(&encode(&gray, ImageFormat::Png)).images[0].texels[9], [77, 77, 77, 255]);

    let deep = DynamicImage::from(Rgb32FImage::from_pixel(1, 1, Rgb([0.0, 0.5, 1.0]))).into_rgb16();
    let scene = with_picture(&encode(&deep.into(), ImageFormat::Png));
    assert_eq!(scene.images[0].texels, [[0, 128, 255, 255]]);
    assert!(scene.warnings[0].problem.contains("8 bits"), "{:?}", scene.warnings);
}

/// Four entries with one picture's bytes are decoded once, and are one image.
#[test]
fn images_of_the_same_bytes_are_one() {
    let mut file = textured(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "emissiveTexture": {"index": 1},
        "normalTexture": {"index": 2},
    }));
    let other = encode(&RgbImage::new(5, 5).into(), ImageFormat::Png);
    let [again, unlike] = [png(), other].map(|bytes| file.texture(&bytes));
    assert_eq!((again, unlike), (1, 2));
    let scene = file.scene();
    let images = |scene: &halfway::scene::Scene| {
        scene.textures.iter().map(|texture| scene.images[texture.image as usize].width).collect::<Vec<_>>()
    };
    assert_eq!(
        scene.images.len(),
        2,
        "{:?}",
        scene.images.iter().map(|image| &image.name).collect::<Vec<_>>()
    );
    let mut widths = images(&scene);
    widths.sort_unstable();
    assert_eq!(widths, [2, 2, 5]);
}

#[test]
fn webp_by_extension_before_the_fallback() {
    let mut file = textured(json!({"emissiveTexture": {"index": 1}}));
    let webp = encode(&RgbImage::new(5, 5).into(), ImageFormat::WebP);
    let texture = file.texture(&webp);
    file.json["textures"][texture] = json!({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}});
    file.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    assert_eq!(file.scene().images[0].width, 5);
    // Where an alternative is not understood, the plain source is used.
    file.json["textures"][texture] = json!({"source": 0, "extensions": {"ACME_texture": {"source": 1}}});
    assert_eq!(file.scene().images[0].width, 2);
}

#[test]
fn images_from_files_and_data_uris() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a picture.png"), png()).unwrap();
    let mut file = textured(json!({"emissiveTexture": {"index": 0}}));
    file.json["images"] = json!([{"uri": "a%20picture.png"}]);
    let options = halfway::scene::gltf::LoadOptions::default();
    let scene = halfway::scene::gltf::load(&file.write(folder.path()), &options).unwrap();
    assert_eq!(
        (scene.images[0].name.as_str(), scene.images[0].texels[5]),
        ("a%20picture.png", [10, 40, 200, 129])
    );
    std::fs::remove_file(folder.path().join("a picture.png")).unwrap();
    let strict = halfway::scene::gltf::LoadOptions { strict: true, ..options.clone() };
    let error = halfway::scene::gltf::load(&file.write(folder.path()), &strict).unwrap_err();
    assert!(error.to_string().contains("a picture.png"), "{error}");
    let scene = halfway::scene::gltf::load(&file.write(folder.path()), &options).unwrap();
    assert!(scene.warnings[0].part.contains("a%20picture.png"), "{:?}", scene.warnings);

    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(png());
    // Some exporters leave the padding out.
    for data in [data.as_str(), data.trim_end_matches('=')] {
        file.json["images"] = json!([{"uri": format!("data:image/png;base64,{data}")}]);
        assert_eq!(file.scene().images[0].texels.len(), 6);
    }
}

#[test]
fn ignored_extensions_are_said_once() {
    let ignored = ["clearcoat", "sheen", "iridescence", "anisotropy", "dispersion", "diffuse_transmission"]
        .map(|name| format!("KHR_materials_{name}"));
    let extensions: serde_json::Map<_, _> = ignored.iter().map(|name| (name.clone(), json!({}))).collect();
    let mut file = textured(json!({"extensions": extensions.clone()}));
    file.push("materials", json!({"extensions": extensions}));
    file.json["extensionsUsed"] = json!([ignored[0], "KHR_animation_pointer", "KHR_materials_ior"]);
    let warnings = file.scene().warnings;
    assert_eq!(warnings.len(), 7, "{warnings:?}");
    for name in ignored.iter().map(String::as_str).chain(["KHR_animation_pointer"]) {
        assert_eq!(warnings.iter().filter(|warning| warning.part.contains(name)).count(), 1, "{name}");
    }
}

#[test]
fn texture_coordinates_that_are_missing_are_said() {
    let mut file = textured(json!({"emissiveTexture": {"index": 0, "texCoord": 1}}));
    let warnings = file.scene().warnings;
    assert!(warnings.len() == 1 && warnings[0].problem.contains("TEXCOORD_1"), "{warnings:?}");
    file.json["materials"][0]["emissiveTexture"]["texCoord"] = json!(2);
    let scene = file.scene();
    assert!(scene.warnings[0].problem.contains("TEXCOORD_2"), "{:?}", scene.warnings);
    assert!(scene.materials[0].emission_texture.is_some());
}

/// A quad in the xy plane whose picture stands upright: u along x, v down. glTF's tangent is +x and its
/// bitangent, normal x tangent * w, points up.
#[test]
fn tangents_are_generated_for_normal_maps() {
    let quad = |normals: bool, u_sign: f32| {
        let mut file = GltfFile::triangle();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let uvs = file.floats("VEC2", &[0.0, 1.0, u_sign, 1.0, u_sign, 0.0, 0.0, 0.0]);
        let indices = file.accessor(&[0, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
        file.attribute("POSITION", positions);
        file.attribute("TEXCOORD_0", uvs);
        if normals {
            let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
            file.attribute("NORMAL", normals);
        }
        file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        let texture = file.texture(&png());
        file.material(json!({"normalTexture": {"index": texture}}));
        file.scene().meshes.remove(0)
    };
    for (u_sign, tangent) in [(1.0, Vec4::new(1.0, 0.0, 0.0, 1.0)), (-1.0, Vec4::new(-1.0, 0.0, 0.0, -1.0))] {
        for normals in [true, false] {
            let mesh = quad(normals, u_sign);
            assert_eq!(mesh.normals.as_ref().unwrap()[0], Vec3::Z);
            assert!(
                mesh.tangents.as_ref().unwrap().iter().all(|t| (*t - tangent).length() < 1e-6),
                "{mesh:?}"
            );
            // Vertices stay shared where nothing differs; flat normals are one face's own.
            assert_eq!(mesh.positions.len(), if normals { 4 } else { 6 });
            assert_eq!(mesh.triangles.len(), 2);
            let corners = mesh.triangles.concat().into_iter().map(|v| mesh.positions[v as usize]);
            assert_eq!(corners.map(|p| p.x + p.y).sum::<f64>(), 6.0);
        }
    }
}

/// Two triangles share an edge, but the picture is mirrored across it: its vertices are split, and keep their data.
#[test]
fn tangents_split_vertices_where_the_picture_is_mirrored() {
    let mut file = GltfFile::triangle();
    let positions = file.floats("VEC3", &[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let uvs = file.floats("VEC2", &[1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
    let colors = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.2, 0.0, 0.0, 0.3, 0.0, 0.0]);
    let indices = file.accessor(&[0, 1, 2, 1, 3, 2], U8, "SCALAR", 6);
    for (name, accessor) in
        [("POSITION", positions), ("NORMAL", normals), ("TEXCOORD_0", uvs), ("COLOR_0", colors)]
    {
        file.attribute(name, accessor);
    }
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let texture = file.texture(&png());
    file.material(json!({"normalTexture": {"index": texture}}));
    let mesh = file.scene().meshes.remove(0);
    assert_eq!(mesh.positions.len(), 6);
    let tangents = mesh.tangents.unwrap();
    let colors = mesh.colors.unwrap();
    for (triangle, sign) in mesh.triangles.iter().zip([-1.0, 1.0]) {
        for &vertex in triangle {
            let tangent = tangents[vertex as usize];
            assert!((tangent - Vec4::new(sign, 0.0, 0.0, sign)).length() < 1e-6, "{tangent}");
            let position = mesh.positions[vertex as usize];
            let expected = [(-1.0, 0.0), (0.0, 0.1), (1.0, 0.3)]
                .into_iter()
                .find(|(x, _)| position.y == 0.0 && *x == position.x)
                .map_or(0.2, |(_, color)| color);
            assert_eq!(colors[vertex as usize].x, expected);
        }
    }
}

/// Without texture coordinates, or with degenerate ones, tangents are unit vectors at right angles to the normals.
#[test]
fn tangents_exist_wherever_a_normal_map_does() {
    let mut file = GltfFile::triangle();
    let texture = file.texture(&png());
    file.material(json!({"normalTexture": {"index": texture}}));
    let bare = file.scene();
    assert!(bare.warnings[0].problem.contains("TEXCOORD_0"), "{:?}", bare.warnings);
    let uvs = file.floats("VEC2", &[0.5; 6]);
    file.attribute("TEXCOORD_0", uvs);
    for scene in [bare, file.scene()] {
        let mesh = &scene.meshes[0];
        let (normals, tangents) = (mesh.normals.as_ref().unwrap(), mesh.tangents.as_ref().unwrap());
        for (normal, tangent) in normals.iter().zip(tangents) {
            assert_eq!(*normal, Vec3::Z);
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-6);
            assert!(tangent.truncate().dot(*normal).abs() < 1e-6 && tangent.w.abs() == 1.0);
        }
    }
    // Without a normal map there are none, whatever the file has.
    file.json["materials"][0] = json!({});
    let tangents = file.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    file.attribute("TANGENT", tangents);
    assert_eq!(file.scene().meshes[0].tangents, None);
}
