//! Pictures that are silently white or black: what is said of them, and which exposure shows them.

use halfway::film::tonemap::ViewTransform;
use halfway::film::{Exposure, Lost, Picture};
use halfway::scene::gltf::{LoadOptions, load_slice};
use serde_json::json;

use crate::command::Case;
use crate::gltf_file::GltfFile;

const VIEWS: [ViewTransform; 3] = [ViewTransform::Neutral, ViewTransform::Srgb, ViewTransform::Agx];

/// 1000 pixels with luminances from a quarter to four times the middle one.
fn picture(middle: f32) -> Picture {
    let rgb = (0..1000).map(|i| [middle * (4.0 * (i as f32 + 0.5) / 1000.0 - 2.0).exp2(); 3]).collect();
    Picture::new(100, 10, rgb)
}

#[test]
fn auto_exposure_brings_the_average_to_middle_grey() {
    for (middle, stops) in
        [(0.18, 0.0), (0.36, -1.0), (0.18e-3, 10.0), (1500.0, -13.0), (1e30, -100.0), (1e-38, 100.0)]
    {
        let have = Exposure::Auto.stops(&picture(middle));
        assert_eq!(have, stops, "{middle}");
        assert!(have != 0.0 || have.is_sign_positive(), "-0 would be printed");
    }
    assert_eq!(Exposure::Stops(2.5).stops(&picture(1.0)), 2.5);
    // Neither darkness nor a lamp, nor what light leaves in the dark, counts.
    let mut odd = picture(0.36);
    odd.rgb.extend(vec![[0.0; 3]; 2000]);
    odd.rgb.extend(vec![[1e9; 3]; 50]);
    odd.rgb.extend(vec![[1e-30; 3]; 50]);
    odd.width = 310;
    assert_eq!(Exposure::Auto.stops(&odd), -1.0);
    assert_eq!(Exposure::Auto.stops(&Picture::new(1, 1, vec![[0.0; 3]])), 0.0);
}

#[test]
fn lost_pictures_are_told_with_the_exposure_that_shows_them() {
    for view in VIEWS {
        for middle in [0.05, 0.18, 0.5] {
            assert_eq!(Lost::judge(&picture(middle), view, 0.0), None, "{view:?} {middle}");
        }
        for (middle, color) in [(1e-6, "black"), (1e-30, "black"), (1500.0, "white"), (1e20, "white")] {
            let picture = picture(middle);
            let better = Exposure::Auto.stops(&picture);
            let lost = Lost::judge(&picture, view, 0.0).expect("lost").to_string();
            for phrase in [color, "100 %", &format!("--exposure {better} "), "--exposure auto"] {
                assert!(lost.contains(phrase), "{view:?}: {phrase} not in {lost}");
            }
            assert_eq!(Lost::judge(&picture, view, better), None, "{view:?}: {middle} at {better}");
        }
        // The background that no light comes from does not count.
        let mut small = picture(0.18);
        small.rgb.extend(vec![[0.0; 3]; 99_000]);
        assert_eq!(Lost::judge(&small, view, 0.0), None);
    }
    let black = Picture::new(2, 1, vec![[0.0; 3]; 2]);
    let lost = Lost::judge(&black, ViewTransform::Neutral, 0.0).expect("lost");
    assert_eq!(lost, Lost::Unlit);
    assert!(lost.to_string().contains("camera"));
}

#[test]
fn too_much_light_is_white_in_every_view() {
    for view in VIEWS {
        for (stops, radiance) in [(100.0, 1e30), (100.0, f32::MAX), (0.0, f32::MAX)] {
            let shown = view.display(stops, [radiance; 3]);
            assert!(shown.iter().all(|&value| value > 0.98), "{view:?} {stops} {radiance}: {shown:?}");
        }
    }
}

#[test]
fn r07_exposure_is_a_number_of_stops() {
    let case = Case::new();
    for value in ["nan", "inf", "200", "-100.1", "bright"] {
        for command in ["render builtin:cornell -o DIR/out.png", "compare DIR/a.exr DIR/b.exr"] {
            case.refuse(&format!("{command} --exposure={value}"), &["--exposure", "-100 to 100"]);
        }
    }
}

#[test]
fn white_render_says_so_and_auto_shows_it() {
    let case = Case::new();
    let render = "render builtin:cornell --size 16x16 --spp 8 --max-depth 3 --device cpu -o out.png";
    let white = case.run(&format!("{render} --exposure 20"));
    white.assert(0, &["white at --exposure 20", "--exposure auto"]);
    let auto = case.run(&format!("{render} --exposure auto"));
    auto.assert(0, &["--exposure auto is "]);
    let named = |said: &str, before: &str| {
        let rest = said.split(before).nth(1).expect("the number").trim_start();
        rest.split([' ', ',']).next().expect("a word").to_owned()
    };
    assert_eq!(named(&white.said, "; --exposure"), named(&auto.said, "--exposure auto is"));
    assert!(!auto.said.contains("are shown"), "{}", auto.said);
    let picture = case.picture("out.png");
    let mean = picture.rgb.iter().flatten().sum::<f32>() / (3 * picture.rgb.len()) as f32;
    assert!((0.05..0.6).contains(&mean), "{mean}");
}

#[test]
fn black_vertex_colours_are_told() {
    let warnings = |values: &[f32]| {
        let mut file = GltfFile::triangle();
        let colors = file.floats("VEC3", values);
        file.attribute("COLOR_0", colors);
        file.scene().warnings
    };
    let black = warnings(&[0.0; 9]);
    assert!(
        black.len() == 1
            && black[0].part.contains("meshes[0].primitives[0]")
            && black[0].problem.contains("COLOR_0"),
        "{black:?}"
    );
    assert!(warnings(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0]).is_empty());
}

#[test]
fn gltf_1_is_named_as_such() {
    let message = |json: serde_json::Value| {
        load_slice(json.to_string().as_bytes(), None, &LoadOptions::default()).unwrap_err().to_string()
    };
    let lists = json!({"accessors": {"a": {}}, "meshes": {"m": {"primitives": []}}, "nodes": {"n": {}}});
    for asset in
        [json!({"version": "1.0"}), json!({"version": "1.1"}), json!({"generator": "x"}), json!(null)]
    {
        let mut file = lists.clone();
        file["asset"] = asset;
        let message = message(file);
        assert!(message.contains("glTF 1.") && message.contains("gltf-pipeline"), "{message}");
    }
    let message = message(json!({"asset": {"version": "2.0"}, "nodes": {}}));
    assert!(message.contains("malformed"), "{message}");
}
