//! The outputs of `halfway render`: each is tried before rendering and saved by itself.

use std::io::Read as _;
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::command::{Case, Run, is_black};

/// What cannot be written is found before the scene is loaded; nothing is left of the trial.
#[test]
fn r04_outputs_are_tried_before_rendering() {
    let case = Case::new();
    std::fs::create_dir(case.path("folder.exr")).expect("a folder");
    std::fs::write(case.path("file"), "").expect("a file");
    let name = |length: usize| format!("DIR/{}.exr", "n".repeat(length - 4));
    for (arguments, phrases) in [
        ("-o DIR/folder.exr", &["folder.exr", "directory"][..]),
        ("-o DIR/a.exr --output DIR/folder.exr", &["folder.exr", "directory"]),
        ("-o DIR/a.exr --stats DIR/none/a.json", &["none", "make it first"]),
        ("-o DIR/a.exr --reference DIR/b.exr --trace-error DIR/none/a.csv", &["none", "make it first"]),
        ("-o DIR/a.exr -i bdpt --max-depth 2 --strategies DIR/file", &["DIR/file", "folder"]),
        (&format!("-o {}", name(256)), &["nnn", "cannot write"]),
        // STEM.eye-subspaces.png is longer.
        (&format!("-o {} -i spcbpt --debug subspaces", name(250)), &["eye-subspaces", "cannot write"]),
    ] {
        let folder = case.path("");
        let folder = folder.to_string_lossy();
        let phrases: Vec<String> = phrases.iter().map(|phrase| phrase.replace("DIR/", &folder)).collect();
        let phrases: Vec<&str> = phrases.iter().map(String::as_str).collect();
        // The scene is not there either.
        case.refuse(&format!("render DIR/missing.gltf {arguments}"), &phrases);
    }
    // Folders that were made for the trial go again.
    case.refuse("render DIR/missing.gltf -o DIR/a.exr --strategies DIR/b/c", &["missing.gltf"]);
    // As long as a name may be.
    let longest = name(255).replace("DIR/", "");
    case.run(&format!("render builtin:cornell --spp 1 --size 8x8 -o {longest}")).assert(0, &[]);
    assert!(!is_black(&case.picture(&longest)));
}

/// A place that goes while the render runs: all else is saved, also on the way.
#[test]
#[cfg(unix)]
fn r04_an_output_that_fails_keeps_no_other_from_being_written() {
    let case = Case::new();
    std::fs::create_dir(case.path("gone")).expect("a folder");
    let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
    let arguments = "render builtin:cornell --size 16x16 --spp 100000000 --save-every 10ms -o gone/a.exr -o b.png \
                     -o c.exr --stats d.json";
    let child =
        command.args(arguments.split_whitespace()).stderr(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let child = child.expect("halfway runs");
    let start = Instant::now();
    let wait_for = |name: &str, done: &dyn Fn() -> bool| {
        while !done() {
            assert!(start.elapsed() < Duration::from_secs(120), "{name} takes two minutes");
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    wait_for("a picture", &|| case.path("c.exr").exists());
    // It may be written to at the moment.
    wait_for("removing", &|| std::fs::remove_dir_all(case.path("gone")).is_ok());
    std::fs::remove_file(case.path("b.png")).expect("a picture");
    wait_for("the next picture", &|| case.path("b.png").exists());
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let run = Run::of(child.wait_with_output().expect("an end"));
    let phrases = ["the render goes on", "an output failed", "gone/a.exr", "written: b.png, c.exr, d.json"];
    run.assert(1, &phrases);
    assert_eq!(run.printed, "b.png\nc.exr\n");
    assert_eq!(case.files(), ["b.png", "c.exr", "d.json"]);
    assert!(!is_black(&case.picture("c.exr")));
}

/// The kernels that a render compiled and the buffers that it made, sorted.
fn made(case: &Case, arguments: &str) -> [Vec<String>; 2] {
    case.run(&format!("render builtin:cornell --size 8x8 --spp 1 --stats stats.json {arguments}"))
        .assert(0, &[]);
    let text = std::fs::read_to_string(case.path("stats.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let list = |key: &str| report[key].as_array().expect("a list").iter();
    let name = |value: &serde_json::Value| value.as_str().expect("a name").to_string();
    let mut made =
        [list("compiled").map(name).collect::<Vec<_>>(), list("memory").map(|m| name(&m[0])).collect()];
    made.iter_mut().for_each(|names| names.sort());
    made
}

/// Albedo, normal and depth take rays, a kernel and 32 bytes per pixel: only where an output has them.
#[test]
fn s04_outputs_choose_what_is_compiled_and_made() {
    let case = Case::new();
    let viewer = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = viewer.local_addr().expect("an address");
    std::thread::spawn(move || viewer.accept().map(|(mut caller, _)| caller.read_to_end(&mut Vec::new())));
    let png = made(&case, "-o a.png");
    let kernels = [
        "camera_rays",
        "closest_hit",
        "film_accumulate",
        "occlusion",
        "path_shade",
        "queue_advance",
        "shadow_advance",
    ];
    assert_eq!(png[0], kernels);
    assert_eq!(made(&case, "-o b.png -o c.png --view srgb"), png);
    let exr = made(&case, "-o a.png -o a.exr");
    let trace = "-o a.png --reference a.exr --trace-error a.csv";
    assert_eq!(made(&case, trace), png, "{trace}");
    let mut whole = png.clone();
    whole[0].push("first_hit".into());
    whole[1].push("first_hits".into());
    whole.iter_mut().for_each(|names| names.sort());
    assert_eq!(exr, whole);
    assert_eq!(made(&case, &format!("-o a.png --tev {address}")), whole);
    assert_eq!(made(&case, "-o a.png --denoise"), whole);
    // Rays that were traced anyway, read back: no kernel, no buffer.
    assert_eq!(made(&case, "-o a.exr --layers position,uv,cryptomatte --transparent --half"), whole);
    assert_eq!(made(&case, "-o a.png --transparent --png-bits 16"), png);
    // Subspaces have shades by the normals.
    for (arguments, first_hits) in [
        ("-i bdpt --max-depth 1 -o a.png", false),
        ("-i bdpt --max-depth 1 -o a.png --strategies all", true),
        ("-i spcbpt --train-paths 2000 -o a.png --debug subspaces", true),
    ] {
        let [kernels, buffers] = made(&case, arguments);
        assert_eq!(kernels.contains(&"first_hit".into()), first_hits, "{arguments}");
        assert_eq!(buffers.contains(&"first_hits".into()), first_hits, "{arguments}");
    }
}
