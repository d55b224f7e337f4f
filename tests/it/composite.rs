//! What people composite with: coverage, ids, positions, texture coordinates, and how files store them.

use std::collections::BTreeMap;

use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use glam::Vec2;
use halfway::film::exr::{self, Coding, Compression};
use halfway::film::{Attribute, Picture, png};
use halfway::integrator::Method;
use halfway::integrator::method::{Given, LVCBPT};
use halfway::render::{RenderOptions, SeenLayers};
use halfway::scene::Scene;
use halfway::scene::builtin::{builtin, surfaces};

use crate::command::Case;
use crate::shots::{options, render};

const SIZE: [u32; 2] = [24, 24];

/// A slab over a floor under a bright sky, which the camera sees too.
fn scene() -> Scene {
    let mut scene = surfaces::glass_slab(1.5);
    scene.cameras[0].position.y = 0.3;
    scene.cameras[0].forward = -glam::Vec3::Z;
    scene.cameras[0].up = glam::Vec3::Y;
    scene
}

fn seen(scene: &Scene, seen: SeenLayers, transparent: bool, samples: u32) -> Picture {
    render(scene, RenderOptions { seen, transparent, ..options(SIZE, samples) }).picture
}

fn channel<'a>(picture: &'a Picture, layer: &str, name: &str) -> &'a [f32] {
    picture.channel(layer, name).unwrap_or_else(|| panic!("no {layer}.{name}"))
}

/// The picture with the sky is the picture without it, over the sky: R = R' + (1 - A) sky, sample by sample.
#[test]
fn alpha_is_what_the_sky_shows_through() {
    let scene = scene();
    let alpha = SeenLayers { alpha: true, ..SeenLayers::default() };
    for method in [Method::Path, (LVCBPT.make)(&Given::default())] {
        let shot = |transparent| {
            let seen = if transparent { alpha } else { SeenLayers::default() };
            render(&scene, RenderOptions { method, seen, transparent, ..options(SIZE, 16) }).picture
        };
        let (whole, cut) = (shot(false), shot(true));
        assert_eq!(whole.channel("", "A"), None);
        let shares = channel(&cut, "", "A");
        assert!(shares.contains(&0.0) && shares.contains(&1.0));
        assert!(shares.iter().any(|&a| a > 0.0 && a < 1.0), "edges are covered in part");
        for (index, &share) in shares.iter().enumerate() {
            // The sky has a radiance of 1.
            let over = cut.rgb[index][0] + 1.0 - share;
            assert!((over - whole.rgb[index][0]).abs() < 1e-4, "{index}: {over} {:?}", whole.rgb[index]);
        }
    }
}

/// Positions lie on the surfaces that were hit, texture coordinates are theirs.
#[test]
fn points_are_those_of_the_first_surface() {
    let mut scene = builtin("cornell").unwrap();
    for mesh in &mut scene.meshes {
        // Texture coordinates that tell where a vertex is.
        let uvs = mesh.positions.iter().map(|p| Vec2::new(p.x as f32, (p.y + 10.0 * p.z) as f32)).collect();
        mesh.uvs[0] = Some(uvs);
    }
    let layers = SeenLayers { position: true, uv: true, ..SeenLayers::default() };
    let options = RenderOptions { seen: layers, first_hit_layers: true, ..options(SIZE, 2) };
    let picture = render(&scene, options).picture;
    let bounds = scene.bounds();
    let size = (bounds.high - bounds.low).max_element();
    for pixel in 0..picture.rgb.len() {
        let [x, y, z] = ["X", "Y", "Z"].map(|axis| f64::from(channel(&picture, "position", axis)[pixel]));
        let [u, v] = ["U", "V"].map(|axis| f64::from(channel(&picture, "uv", axis)[pixel]));
        if !channel(&picture, "depth", "Z")[pixel].is_finite() {
            continue;
        }
        let point = glam::DVec3::new(x, y, z);
        assert!((point.clamp(bounds.low, bounds.high) - point).length() < 1e-5 * size, "{pixel}: {point}");
        assert!((u - x).abs() < 1e-4 && (v - (y + 10.0 * z)).abs() < 1e-3, "{pixel}: {u} {v} at {point}");
    }
}

/// Every pixel's shares add up to its coverage, and ids lead to names through the manifest.
#[test]
fn mattes_name_what_covers_a_pixel() {
    let scene = scene();
    let picture = seen(&scene, SeenLayers { alpha: true, ids: true, ..SeenLayers::default() }, true, 32);
    for (layer, key, names) in [
        ("CryptoObject", "3ae39a5", scene.meshes.iter().map(|mesh| mesh.name.clone()).collect::<Vec<_>>()),
        ("CryptoMaterial", "be359d6", scene.materials.iter().map(|material| material.name.clone()).collect()),
    ] {
        let text = |name: &str| match picture.attribute(&format!("cryptomatte/{key}/{name}")) {
            Some(Attribute::Text(text)) => text.clone(),
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(text("name"), layer);
        assert_eq!([text("hash"), text("conversion")], ["MurmurHash3_32", "uint32_to_float32"]);
        let manifest: std::collections::BTreeMap<String, String> =
            serde_json::from_str(&text("manifest")).unwrap();
        assert!(names.iter().all(|name| manifest.contains_key(name)), "{manifest:?}");
        let mut found = std::collections::BTreeSet::new();
        for pixel in 0..picture.rgb.len() {
            let mut sum = 0.0;
            let mut last = 1.0;
            for level in 0..3 {
                for [id, share] in [["R", "G"], ["B", "A"]] {
                    let layer = format!("{layer}{level:02}");
                    let share = channel(&picture, &layer, share)[pixel];
                    assert!(share <= last, "ranks go down");
                    last = share;
                    sum += share;
                    if share > 0.0 {
                        found.insert(format!("{:08x}", channel(&picture, &layer, id)[pixel].to_bits()));
                    }
                }
            }
            assert!((sum - channel(&picture, "", "A")[pixel]).abs() < 1e-5, "{layer} {pixel}: {sum}");
        }
        assert!(
            found.len() >= 2 && found.iter().all(|id| manifest.values().any(|value| value == id)),
            "{found:?}"
        );
    }
}

/// The command's files: straight alpha of 16 bits in the PNG, half floats and their exceptions in the EXR, with the same values
/// when they are read.
#[test]
fn files_hold_what_was_asked_for() {
    let case = Case::new();
    let arguments = "render builtin:glass-slab --look-from 0,0.3,3 --look-at 0,0.3,0 --size 24x24 --spp 8";
    case.run(&format!("{arguments} -o full.exr")).assert(0, &[]);
    let extras = "--transparent --layers position,cryptomatte --half --png-bits 16";
    case.run(&format!("{arguments} {extras} -o a.exr -o a.png")).assert(0, &[]);
    let (linear, screen) = (case.picture("a.exr"), Picture::read(&case.path("a.png")).unwrap());
    let (shares, shown) = (channel(&linear, "", "A"), channel(&screen, "", "A"));
    for (a, b) in shares.iter().zip(shown) {
        // Half floats have 11 bits.
        assert!((a - b).abs() < 5e-4, "{a} {b}");
    }
    let levels = screen.rgb.iter().flatten().filter(|&&value| {
        let byte = 255.0 * halfway::film::tonemap::srgb_encode(value);
        (byte - byte.round()).abs() > 0.01
    });
    assert!(levels.count() > 100, "more levels than 8 bits have");
    let size = |name: &str| std::fs::metadata(case.path(name)).unwrap().len();
    assert!(size("full.exr") > 0);
    for (name, usage) in [
        ("--layers uv -o a.png", ".exr"),
        ("--layers cryptomatte --compression dwaa -o a.exr", "dwaa"),
        ("--png-bits 12", "8 or 16"),
    ] {
        case.refuse(&format!("render builtin:cornell {name}"), &[usage]);
    }
}

/// Half floats and DWAA store the colours, and neither depth nor ids lose a bit to halves.
#[test]
fn halves_and_dwaa_keep_what_matters() {
    let case = Case::new();
    let layers = SeenLayers { position: true, ids: true, ..SeenLayers::default() };
    let options = RenderOptions { seen: layers, first_hit_layers: true, ..options([64, 64], 8) };
    let mut picture = render(&builtin("cornell").unwrap(), options).picture;
    picture.rgb[7] = [1e6, 0.5, f32::INFINITY];
    let read = |coding: Coding| {
        let path = case.path("a.exr");
        exr::write_as(&path, &picture, &coding).unwrap();
        (Picture::read(&path).unwrap(), std::fs::metadata(&path).unwrap().len())
    };
    let (full, full_size) = read(Coding::default());
    assert_eq!(full.rgb, picture.rgb);
    let (half, half_size) = read(Coding { half: true, ..Coding::default() });
    assert!(half_size < full_size);
    assert_eq!(half.rgb[7], [65504.0, 0.5, f32::INFINITY]);
    for (a, b) in
        half.rgb.iter().zip(&picture.rgb).enumerate().filter(|(index, _)| *index != 7).map(|(_, pair)| pair)
    {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-3 * b.abs() + 1e-6, "{a} {b}");
        }
    }
    for (layer, name) in [("depth", "Z"), ("position", "X"), ("variance", "R"), ("CryptoObject00", "R")] {
        let bits =
            |picture: &Picture| channel(picture, layer, name).iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&half), bits(&picture), "{layer}");
    }
    picture.rgb[7] = [0.5; 3];
    let path = case.path("dwaa.exr");
    exr::write_as(
        &path,
        &picture,
        &Coding { half: true, compression: Compression::Dwaa, ..Coding::default() },
    )
    .unwrap();
    let dwaa = Picture::read(&path).unwrap();
    let difference: f32 =
        dwaa.rgb.iter().flatten().zip(picture.rgb.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
    let total: f32 = picture.rgb.iter().flatten().sum();
    assert!(difference < 0.05 * total, "{}", difference / total);
    assert!(std::fs::metadata(&path).unwrap().len() < half_size);
}

/// A PNG of a picture that is multiplied by its coverage has the colours without it.
#[test]
fn png_has_straight_alpha() {
    let case = Case::new();
    let mut picture = Picture::new(2, 1, vec![[0.1, 0.05, 0.2], [0.0; 3]]);
    picture.push_channel("", "A", vec![0.5, 0.0]);
    let path = case.path("a.png");
    png::write_as(&path, &picture, halfway::film::tonemap::ViewTransform::Srgb, 0.0, png::Depth::Sixteen)
        .unwrap();
    let read = Picture::read(&path).unwrap();
    for (a, b) in read.rgb[0].iter().zip([0.2, 0.1, 0.4]) {
        assert!((a - b).abs() < 1e-4, "{:?}", read.rgb);
    }
    assert!((channel(&read, "", "A")[0] - 0.5).abs() < 1e-4);
}

/// The lights of a scene one by one: their layers add up to the picture, which is that of all lights together.
#[test]
fn light_groups_add_up() {
    let case = Case::new();
    let arguments = "render builtin:three-lights --size 16x16 --spp 64 -i path";
    case.run(&format!("{arguments} -o whole.exr")).assert(0, &[]);
    case.run(&format!("{arguments} --light-groups --layers direct -o a.exr")).assert(0, &[]);
    let (whole, picture) = (case.picture("whole.exr"), case.picture("a.exr"));
    let groups: Vec<&str> = picture
        .layers
        .iter()
        .map(|layer| layer.name.as_str())
        .filter(|name| name.starts_with("light."))
        .collect();
    assert!(groups.len() >= 2, "{groups:?}");
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        for (pixel, rgb) in picture.rgb.iter().enumerate() {
            let sum: f32 = groups.iter().map(|group| channel(&picture, group, name)[pixel]).sum();
            assert!((sum - rgb[c]).abs() <= 1e-5 * rgb[c], "{sum} {rgb:?}");
            let [direct, rest] = ["direct", "indirect"].map(|layer| channel(&picture, layer, name)[pixel]);
            assert!((direct + rest - rgb[c]).abs() <= 1e-5 * rgb[c].max(1e-6));
        }
        for group in &groups {
            assert!(channel(&picture, group, name).iter().sum::<f32>() >= 0.0);
        }
    }
    let ratio = halfway::film::metric::mean_ratio(&picture, &whole);
    assert!(ratio.z().unwrap().abs() < 4.0, "{ratio:?}");
    for (flag, phrase) in [("--save-every 1s", "--save-every"), ("--error 0.1", "--error")] {
        let run = case.run(&format!("{arguments} --light-groups {flag} -o b.exr"));
        run.assert(2, &[phrase]);
    }
}

/// Path tracing with the same seed finds the same direct light: what is left is not negative.
#[test]
fn direct_light_is_a_part_of_the_picture() {
    let case = Case::new();
    case.run("render builtin:cornell --size 16x16 --spp 8 -i path --layers direct -o a.exr").assert(0, &[]);
    let picture = case.picture("a.exr");
    let sum = |layer: &str| channel(&picture, layer, "G").iter().sum::<f32>();
    let total: f32 = picture.rgb.iter().map(|pixel| pixel[1]).sum();
    assert!(
        sum("direct") > 0.1 * total && sum("indirect") > 0.1 * total,
        "{} {}",
        sum("direct"),
        sum("indirect")
    );
    assert!(channel(&picture, "indirect", "G").iter().all(|&value| value > -1e-5));
}

/// A part for each layer, with and without half floats and losses: what is read back is the picture of a file of one part.
#[test]
fn parts_hold_what_one_part_holds() {
    let case = Case::new();
    let layers = SeenLayers { alpha: true, position: true, ids: true, ..SeenLayers::default() };
    let options = RenderOptions { seen: layers, first_hit_layers: true, ..options([64, 64], 8) };
    let mut picture = render(&builtin("cornell").unwrap(), options).picture;
    picture.variance_scale = Some(0.25);
    let read = |name: &str, coding: Coding| {
        let path = case.path(name);
        exr::write_as(&path, &picture, &coding).unwrap();
        Picture::read(&path).unwrap()
    };
    // Bits, as ids are no numbers.
    let bits = |picture: &Picture, exact: bool| {
        let layers = picture.layers.iter().filter(|layer| {
            !exact
                || ["depth", "position", "variance", "samples"].contains(&layer.name.as_str())
                || layer.name.starts_with("Crypto")
        });
        let channels = layers
            .flat_map(|layer| layer.channels.iter().map(|(name, values)| (layer.full_name(name), values)));
        channels
            .map(|(name, values)| (name, values.iter().map(|value| value.to_bits()).collect()))
            .collect::<BTreeMap<String, Vec<u32>>>()
    };
    for half in [false, true] {
        let one = read("one.exr", Coding { half, ..Coding::default() });
        let parts = read("parts.exr", Coding { half, multi_part: true, ..Coding::default() });
        assert_eq!(parts.rgb, one.rgb);
        assert_eq!(bits(&parts, false), bits(&one, false), "half: {half}");
        assert_eq!((&parts.metadata, parts.variance_scale), (&one.metadata, one.variance_scale));
        let dwaa = Coding { half, compression: Compression::Dwaa, multi_part: true };
        let losses = read("dwaa.exr", dwaa);
        assert_eq!(bits(&losses, true), bits(&one, true), "half: {half}");
        assert_ne!(losses.rgb, one.rgb);
    }
    let names = |name: &str| -> Vec<String> {
        let meta = MetaData::read_from_file(case.path(name), false).unwrap();
        let name = |header: &Header| header.own_attributes.layer_name.as_ref().map(|name| name.to_string());
        meta.headers.iter().map(|header| name(header).unwrap_or_default()).collect()
    };
    assert_eq!(names("one.exr"), [""]);
    let parts = names("parts.exr");
    assert_eq!(parts[0], "rgba");
    for layer in
        ["albedo", "normal", "depth", "variance", "samples", "position", "CryptoObject00", "CryptoMaterial02"]
    {
        assert!(parts.iter().any(|part| part == layer), "{layer} of {parts:?}");
    }
    // Ids name what they stand for, where they are and in the first part.
    let meta = MetaData::read_from_file(case.path("parts.exr"), false).unwrap();
    for (index, header) in meta.headers.iter().enumerate() {
        let keys = header
            .own_attributes
            .other
            .keys()
            .filter(|key| key.to_string().starts_with("cryptomatte/"))
            .count();
        let expected = if index == 0 {
            8
        } else if parts[index].starts_with("Crypto") {
            4
        } else {
            0
        };
        assert_eq!(keys, expected, "{}", parts[index]);
    }
    case.run("render builtin:cornell -i path --size 8x8 --spp 1 --layers cryptomatte --compression dwaa --multi-part -o a.exr")
        .assert(0, &[]);
}
