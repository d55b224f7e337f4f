//! `--denoise`, with Open Image Denoise itself, which `tools/setup --tests` installs; and with libraries that fail.

use std::path::Path;
use std::process::Command;

use halfway::film::denoise::{Denoiser, LAYER};
use halfway::film::png::pixel;
use halfway::film::tonemap::ViewTransform;
use halfway::film::{Attribute, Picture};
use halfway::render::RenderOptions;
use halfway::scene::builtin::{builtin, surfaces};

use crate::command::{Case, Run};
use crate::random::Stream;
use crate::shots::{options, render};

fn denoiser() -> Denoiser {
    Denoiser::open().unwrap_or_else(|error| panic!("{error}"))
}

fn mean(rgb: &[[f32; 3]]) -> f64 {
    rgb.as_flattened().iter().map(|&value| f64::from(value)).sum::<f64>() / rgb.len() as f64
}

/// Root of the mean squared distance from a picture of one colour, over that colour.
fn noise(rgb: &[[f32; 3]], color: f64) -> f64 {
    let squares = rgb.as_flattened().iter().map(|&value| (f64::from(value) / color - 1.0).powi(2));
    (squares.sum::<f64>() / (3 * rgb.len()) as f64).sqrt()
}

/// A picture of one colour with noise as wide as the colour itself.
fn grain(width: u32, height: u32, color: f32) -> Picture {
    let mut random = Stream::new(1);
    let rgb = (0..width * height).map(|_| [2.0 * color * random.f32(); 3]).collect();
    Picture::new(width, height, rgb)
}

#[test]
fn a_constant_picture_stays_constant() {
    let mut denoiser = denoiser();
    for [width, height] in [[1, 1], [7, 3], [64, 48]] {
        let picture = Picture::new(width, height, vec![[0.5, 0.25, 2.0]; (width * height) as usize]);
        let denoised = denoiser.denoise(&picture).unwrap();
        for pixel in &denoised {
            for (value, wanted) in pixel.iter().zip([0.5, 0.25, 2.0]) {
                assert!((value / wanted - 1.0).abs() < 0.02, "{width}x{height}: {pixel:?}");
            }
        }
    }
    let black = Picture::new(16, 16, vec![[0.0; 3]; 256]);
    let denoised = denoiser.denoise(&black).unwrap();
    assert!(denoised.as_flattened().iter().all(|&value| value.abs() < 1e-4), "{:?}", denoised[0]);
}

/// Scaled by powers of two far beyond what the filter knows, the result is scaled alike.
#[test]
fn any_brightness_is_denoised_alike() {
    let mut denoiser = denoiser();
    let denoised = denoiser.denoise(&grain(96, 64, 0.5)).unwrap();
    assert!(noise(&denoised, 0.5) < 0.1 * noise(&grain(96, 64, 0.5).rgb, 0.5), "{}", noise(&denoised, 0.5));
    assert!((mean(&denoised) / mean(&grain(96, 64, 0.5).rgb) - 1.0).abs() < 0.01);
    for exponent in [-110, -30, 30, 110] {
        let factor = 2f32.powi(exponent);
        let scaled = denoiser.denoise(&grain(96, 64, 0.5 * factor)).unwrap();
        for (pixel, other) in denoised.iter().zip(&scaled) {
            assert_eq!(pixel.map(|value| value * factor), *other, "2^{exponent}");
        }
    }
}

/// NaN, infinite and enormous pixels neither spread nor remain.
#[test]
fn pixels_that_are_no_colours_are_filled() {
    let mut denoiser = denoiser();
    let mut picture = grain(64, 64, 0.5);
    for (index, value) in [(0, f32::NAN), (2080, f32::INFINITY), (3000, f32::NEG_INFINITY), (4095, -1.0)] {
        picture.rgb[index] = [value; 3];
    }
    let denoised = denoiser.denoise(&picture).unwrap();
    assert!(denoised.as_flattened().iter().all(|value| (0.0..2.0).contains(value)), "all of them are finite");
    assert!(noise(&denoised, 0.5) < 0.15, "{}", noise(&denoised, 0.5));
    picture.rgb[2080] = [1e30; 3];
    let denoised = denoiser.denoise(&picture).unwrap();
    assert!(denoised.as_flattened().iter().all(|value| value.is_finite()));
    let corner = &denoised[..64 * 8];
    assert!(noise(corner, 0.5) < 0.2, "far from a firefly: {}", noise(corner, 0.5));
}

/// What is filtered in tiles is what is filtered whole.
#[test]
fn tiles_have_no_seams() {
    let picture = grain(400, 200, 0.5);
    let whole = denoiser().denoise(&picture).unwrap();
    let mut tiled = denoiser();
    tiled.tile = 160;
    let tiled = tiled.denoise(&picture).unwrap();
    let largest =
        whole.as_flattened().iter().zip(tiled.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(largest < 0.01, "{largest}");
}

/// The whole path: the picture stays what it is, the EXR has the result as a layer, the PNG shows it.
#[test]
fn s04_denoised_beside_the_picture() {
    let case = Case::new();
    let arguments = "render builtin:cornell --size 48x48 --spp 8";
    case.run(&format!("{arguments} -o raw.exr")).assert(0, &[]);
    case.run(&format!("{arguments} --denoise -o a.exr -o a.png")).assert(0, &[]);
    let (raw, both) = (case.picture("raw.exr"), case.picture("a.exr"));
    assert_eq!(raw.rgb, both.rgb);
    assert_eq!(raw.attribute("biased"), Some(&Attribute::Text("no".into())));
    assert_eq!(both.attribute("biased"), Some(&Attribute::Text("denoised".into())));
    let made_by = format!("{:?}", both.attribute("denoiser"));
    assert!(made_by.contains("Open Image Denoise 2."), "{made_by}");
    let denoised = both.shown();
    assert_ne!(*denoised, *both.rgb);
    assert!((mean(&denoised) / mean(&raw.rgb) - 1.0).abs() < 0.01, "{} {}", mean(&denoised), mean(&raw.rgb));
    let screen = Picture::read(&case.path("a.png")).unwrap();
    let byte = |value: f32| (255.0 * halfway::film::tonemap::srgb_encode(value)).round() as u8;
    for (shown, radiance) in screen.rgb.iter().zip(denoised.iter()) {
        assert_eq!(shown.map(byte), pixel(*radiance, ViewTransform::Neutral, 0.0));
    }
    // Closer to a long render than the picture is.
    case.run("render builtin:cornell -i path --size 48x48 --spp 1024 -o reference.exr").assert(0, &[]);
    let mape = |name: &str| {
        let run = case.run(&format!("compare {name} reference.exr --json"));
        run.assert(0, &[]);
        let value: serde_json::Value = serde_json::from_str(&run.printed).expect("JSON");
        value["mape"].as_f64().expect("a number")
    };
    let (before, after) = (mape("a.exr"), mape(&format!("a.exr#{LAYER}")));
    assert!(after < 0.6 * before, "{after} after {before}");
}

/// The floor seen through clear glass is in the albedo: the pane itself would be white. Depth is that of the glass.
#[test]
fn layers_show_what_is_behind_glass() {
    let scene = surfaces::glass_slab(1.5);
    let layers = |through_mirrors: bool| {
        let options = RenderOptions { first_hit_layers: true, through_mirrors, ..options([24, 24], 1) };
        render(&scene, options).picture
    };
    let (first, through) = (layers(false), layers(true));
    assert_eq!(first.rgb, through.rgb);
    assert_eq!(first.channel("depth", "Z"), through.channel("depth", "Z"));
    let spread = |picture: &Picture| {
        // Pixels of the slab's middle.
        let albedo = picture.channel("albedo", "R").unwrap();
        let values: Vec<f32> =
            (9..15).flat_map(|y| (9..15).map(move |x| y * 24 + x)).map(|i| albedo[i]).collect();
        let [low, high] = [f32::min, f32::max].map(|pick| values.iter().copied().reduce(pick).unwrap());
        high - low
    };
    assert!(spread(&first) < 0.01, "glass alone: {}", spread(&first));
    assert!(spread(&through) > 0.1, "a checkerboard: {}", spread(&through));
    // Nothing to follow, nothing to compile.
    let matte = RenderOptions { first_hit_layers: true, through_mirrors: true, ..options([8, 8], 1) };
    let compiled = render(&builtin("cornell").unwrap(), matte).report.compiled;
    assert!(!compiled.contains(&"mirror_follow".to_string()), "{compiled:?}");
}

/// A missing library is found before anything is rendered.
#[test]
fn a_missing_denoiser_is_said_at_once() {
    let case = Case::new();
    let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
    command.env("HALFWAY_OIDN", case.path("nowhere"));
    let run = Run::of(command.args(["render", "missing.gltf", "--denoise"]).output().unwrap());
    run.assert(1, &["Open Image Denoise", "tools/setup --denoiser", "HALFWAY_OIDN", "nowhere"]);
    assert_eq!(case.files(), [""; 0]);
}

/// The library's functions, of which `execute` does something unexpected.
const FAKE: &str = r#"
#include <stddef.h>
#include <stdlib.h>
static int failed = 0;
void *oidnNewDevice(int type) { return &failed; }
void oidnCommitDevice(void *device) {}
int oidnGetDeviceInt(void *device, const char *name) { return name[0] == 'v' ? 20500 : 1; }
int oidnGetDeviceError(void *device, const char **message) {
    *message = failed ? "the filter is tired" : NULL;
    return failed ? 4 : 0;
}
void oidnReleaseDevice(void *device) {}
void *oidnNewBuffer(void *device, size_t size) { return malloc(size); }
void oidnWriteBuffer(void *buffer, size_t offset, size_t size, const void *data) {}
void oidnReadBuffer(void *buffer, size_t offset, size_t size, void *data) {}
void oidnReleaseBuffer(void *buffer) { free(buffer); }
void *oidnNewFilter(void *device, const char *type) { return &failed; }
void oidnSetFilterImage(void *f, const char *n, void *b, int t, size_t w, size_t h, size_t o, size_t p, size_t r) {}
void oidnSetFilterBool(void *filter, const char *name, _Bool value) {}
void oidnSetFilterFloat(void *filter, const char *name, float value) {}
void oidnCommitFilter(void *filter) {}
void oidnExecuteFilter(void *filter) { EXECUTE; }
void oidnReleaseFilter(void *filter) {}
"#;

fn fake(folder: &Path, execute: &str) {
    let source = folder.join("fake.c");
    std::fs::write(&source, FAKE.replace("EXECUTE", execute)).unwrap();
    let library = folder.join("libOpenImageDenoise.so.2");
    let status = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&library, &source]).status();
    assert!(status.expect("a C compiler").success());
}

/// A refusal and a crash both end in exit code 1, with the reason and with the picture.
#[test]
#[cfg(target_os = "linux")]
fn a_denoiser_that_fails_loses_nothing() {
    for (execute, phrase) in
        [("failed = 1", "the filter is tired"), ("abort()", "crashed"), ("*(int *)0 = 1", "crashed")]
    {
        let (case, library) = (Case::new(), Case::new());
        fake(&library.path(""), execute);
        let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
        command.env("HALFWAY_OIDN", library.path(""));
        let arguments = "render builtin:cornell --size 8x8 --spp 2 --denoise -o a.exr -o a.png";
        let run = Run::of(command.args(arguments.split(' ')).output().unwrap());
        run.assert(1, &[phrase]);
        assert_eq!(case.files(), ["a.exr", "a.png"]);
        let picture = case.picture("a.exr");
        assert_eq!(picture.channel(LAYER, "R"), None);
        assert_eq!(picture.attribute("biased"), Some(&Attribute::Text("no".into())));
        assert!(mean(&picture.rgb) > 0.0);
    }
}
