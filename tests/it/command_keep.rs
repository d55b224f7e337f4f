//! `--checkpoint`, `resume`, `--samples` and `merge` as a user runs them.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use halfway::film::checkpoint::SavedRender;
use halfway::film::{Attribute, Picture};

use crate::command::{Case, Run};

const SCENE: &str = "builtin:cornell -i path --size 16x16";

/// Everything but how it was made.
fn pixels(picture: &Picture) -> Picture {
    let layers = picture.layers.iter().filter(|layer| !layer.name.is_empty()).cloned().collect();
    Picture { layers, ..Picture::new(picture.width, picture.height, picture.rgb.clone()) }
}

#[test]
fn r11_usage_that_makes_no_portion_is_refused() {
    let case = Case::new();
    for (arguments, phrases) in [
        ("render builtin:cornell --samples 4..8", ["multiples of 8", "64..128"].as_slice()),
        ("render builtin:cornell --samples 0..8 -o DIR/a.exr", &["name it .part"]),
        ("render builtin:cornell --samples 0..8 -o DIR/a.part -o DIR/b.part", &["one file"]),
        ("render builtin:cornell --samples 0..8 --spp 8", &["--samples", "--spp"]),
        ("render builtin:cornell --samples 0..8 -o DIR/a.part", &["-i path"]),
        ("render builtin:cornell -i path --denoise --samples 0..8 -o DIR/a.part", &["--denoise", "portion"]),
        ("render builtin:cornell -i spcbpt --samples 0..8 -o DIR/a.part", &["halfway train", "--model"]),
        ("render builtin:cornell --checkpoint-every 5s", &["--checkpoint"]),
        ("render builtin:cornell --checkpoint DIR/no/such/place", &["no/such"]),
        ("merge", &["PART"]),
        ("merge DIR/none.part -o DIR/a.exr", &["none.part"]),
        ("merge Cargo.toml -o DIR/a.exr", &["no checkpoint or portion"]),
        ("merge DIR/none.part -o DIR/a.jpg", &["a.jpg", ".part"]),
        ("resume DIR/none", &["none"]),
    ] {
        case.refuse(arguments, phrases);
    }
}

/// Portions by one process each, and the merged picture with its layers and metadata.
#[test]
fn r11_portions_of_processes_are_one_render() {
    let case = Case::new();
    case.run(&format!("render {SCENE} --spp 72 -o once.exr")).assert(0, &[]);
    case.run(&format!("render {SCENE} --samples 0..64")).assert(0, &["64 spp"]);
    case.run(&format!("render {SCENE} --samples 64..72 -o b.part")).assert(0, &["8 spp"]);
    case.run("merge cornell.0-64.part b.part -o merged.exr -o merged.png --spp 72")
        .assert(0, &["72 spp from 2 portions", "estimated error"]);
    let (once, merged) = (case.picture("once.exr"), case.picture("merged.exr"));
    assert!(once.channel("albedo", "R").is_some());
    assert!(pixels(&merged) == pixels(&once), "other bits");
    for name in ["spp", "integrator", "sceneHash", "device", "seed", "nonFiniteSamples", "caveats"] {
        assert_eq!(merged.attribute(name), once.attribute(name), "{name}");
    }
    assert_eq!(merged.attribute("portions"), Some(&Attribute::Text("0..64, 64..72".into())));
    case.run("merge cornell.0-64.part -o merged.exr --spp 72")
        .assert(2, &["samples 64..72", "--allow-missing"]);
    case.run("merge b.part -o part.exr --allow-missing").assert(0, &["no layers albedo"]);
}

fn start(case: &Case, arguments: &str) -> Child {
    let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
    command.args(arguments.split_whitespace()).stderr(Stdio::piped()).stdout(Stdio::piped());
    command.spawn().expect("halfway runs")
}

/// Until there is a checkpoint of more than so many samples.
fn wait_for(path: &Path, samples: u32) {
    let start = Instant::now();
    while SavedRender::read_header(path).map_or(0, |header| header.samples.next) <= samples {
        assert!(start.elapsed() < Duration::from_secs(300), "no checkpoint");
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
}

/// Killed, stopped and warned; the picture is that of a render which was left alone.
#[test]
#[cfg(unix)]
fn r06_a_killed_render_goes_on_bit_for_bit() {
    let case = Case::new();
    let kept = case.path("kept");
    let render = format!("render {SCENE} --spp 1000000 -o out.exr --checkpoint kept --checkpoint-every 0s");
    let mut child = start(&case, &render);
    wait_for(&kept, 0);
    child.kill().expect("a process");
    child.wait().expect("a process");
    let mut samples = SavedRender::read(&kept).expect("a whole file").header.samples.next;
    for name in ["-TERM", "-USR1"] {
        let child = start(&case, "resume kept");
        wait_for(&kept, samples);
        signal(&child, name);
        let run = Run::of(child.wait_with_output().expect("a process"));
        run.assert(130, &[]);
        let now = SavedRender::read(&kept).expect("a whole file").header.samples.next;
        assert!(now > samples, "{now} samples after {samples}");
        samples = now;
    }
    // A killed process may have left a file beside; the next one removes it.
    let all = samples + 7;
    case.run(&format!("resume kept --spp {all}")).assert(0, &["--spp reached"]);
    assert_eq!(case.files(), ["kept", "out.exr"]);
    case.run(&format!("render {SCENE} --spp {all} -o once.exr")).assert(0, &[]);
    assert!(pixels(&case.picture("out.exr")) == pixels(&case.picture("once.exr")), "other bits");
    case.run(&format!("render {SCENE} --spp 8 --seed 3 --resume kept")).assert(2, &["seed 0 there, 3 here"]);
    case.run(&format!("render {SCENE} --spp 8 --transparent --resume kept"))
        .assert(2, &["transparent not given there, yes here"]);
}

/// What goes on without `-i` is not chosen anew: a short render would be path tracing.
#[test]
fn r06_a_resumed_render_keeps_its_integrator() {
    let case = Case::new();
    let render = "render builtin:cornell --size 16x16 -o out.exr";
    case.run(&format!("{render} -i light --spp 8 --checkpoint kept")).assert(0, &[]);
    case.run(&format!("{render} --spp 16 --resume kept")).assert(0, &["16 spp"]);
    let resumed = case.picture("out.exr");
    case.run(&format!("{render} -i light --spp 16")).assert(0, &[]);
    assert!(pixels(&resumed) == pixels(&case.picture("out.exr")), "other bits");
    case.run(&format!("{render} -i path --spp 16 --resume kept")).assert(2, &["light", "path"]);
}

/// The one device that is always full.
#[test]
#[cfg(target_os = "linux")]
fn r04_a_full_disk_does_not_end_a_render() {
    let case = Case::new();
    let run =
        case.run(&format!("render {SCENE} --spp 64 -o out.exr --checkpoint /dev/full --checkpoint-every 0s"));
    run.assert(0, &["/dev/full", "the render goes on"]);
    assert_eq!(run.said.matches("the render goes on").count(), 1, "{}", run.said);
    assert_eq!(case.files(), ["out.exr"]);
}
