//! What the command says of a scene with a faulty part.

use halfway::film::Attribute;
use serde_json::json;

use crate::command::Case;
use crate::gltf_file::GltfFile;

/// An emissive triangle with a missing texture, and a camera that cannot be one.
fn case() -> Case {
    let case = Case::new();
    let mut file = GltfFile::triangle();
    file.json["images"] = json!([{"uri": "missing.png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.material(json!({"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1]}));
    let uvs = file.floats("VEC2", &[0.5; 6]);
    file.attribute("TEXCOORD_0", uvs);
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0}}]);
    file.push("nodes", json!({"camera": 0}));
    case.write("scene.gltf", &file);
    case
}

#[test]
fn warnings_are_listed_and_strictly_refused() {
    let case = case();
    let info = case.run("info -q scene.gltf");
    info.assert(0, &[]);
    assert!(info.said.is_empty(), "{}", info.said);
    for phrase in ["warnings: 2", "images[0] \"missing.png\"", "cameras[0]"] {
        assert!(info.printed.contains(phrase), "'{phrase}' not in\n{}", info.printed);
    }
    case.refuse("info --strict DIR/scene.gltf", &["yfov 0"]);
    case.refuse("render --strict DIR/scene.gltf -o DIR/out.exr", &["yfov 0"]);
}

#[test]
fn warnings_are_counted_and_kept_with_the_picture() {
    let case = case();
    let render = "render scene.gltf --spp 1 --size 16x16 -o out.exr";
    let run = case.run(render);
    run.assert(0, &["images[0] \"missing.png\"", "cameras[0]", "2 warnings about the scene"]);
    let picture = case.picture("out.exr");
    assert!(picture.rgb.contains(&[1.0, 0.0, 1.0]), "no magenta");
    let Some(Attribute::Text(warnings)) = picture.attribute("warnings") else { panic!("not kept") };
    assert_eq!(warnings.lines().count(), 2, "{warnings}");
    let quiet = case.run(&format!("{render} -q"));
    quiet.assert(0, &["2 warnings about the scene"]);
    assert_eq!(quiet.said.lines().count(), 1, "{}", quiet.said);
}

/// Radiance beyond f32 is infinite in the picture's files.
#[test]
fn infinite_pictures_are_a_failure() {
    let case = Case::new();
    let mut file = GltfFile::triangle();
    let light = json!({"type": "point", "intensity": 3e38});
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    file.push(
        "nodes",
        json!({"translation": [0.2, 0.2, 0.01], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    );
    case.write("scene.gltf", &file);
    case.run("render scene.gltf --spp 8 --size 16x16 -o out.exr")
        .assert(5, &["infinite", "Make the scene's lights weaker"]);
    assert_eq!(case.files(), ["out.exr", "scene.gltf"]);
}
