//! `halfway train` and what its models are for, as a user meets them.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use halfway::film::Picture;

use crate::command::{Case, Run};
use crate::gltf_file::GltfFile;

/// A render of next to nothing that connects by subspaces.
const RENDER: &str = "render builtin:cornell --size 32x32 --spp 1 --integrator spcbpt --seed 3";
const TRAIN: &str = "train builtin:cornell --size 32x32 --train-paths 2000 --seed 3";

/// A case with `cornell.model`, at the default name.
fn trained() -> Case {
    let case = Case::new();
    let run = case.run(&format!("{TRAIN} --stats train.json"));
    run.assert(0, &["device: ", "learnt in", "eye and", "held-out loss"]);
    assert_eq!(run.printed, "cornell.model\n");
    assert_eq!(case.files(), ["cornell.model", "train.json"]);
    case
}

/// Learning first, or before: the same picture, bit for bit, and so is the model.
#[test]
fn a_model_stands_for_its_training() {
    let case = trained();
    case.run(&format!("{RENDER} --model cornell.model -o by-model.exr")).assert(0, &["learnt before from"]);
    let command = format!("{RENDER} --train-paths 2000 -o by-itself.exr --stats render.json");
    case.run(&command).assert(0, &["learnt in", "of them tracing"]);
    assert_eq!(case.picture("by-model.exr").rgb, case.picture("by-itself.exr").rgb);

    let json = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(case.path(name)).expect("a report")).expect("JSON")
    };
    let (train, render) = (json("train.json"), json("render.json"));
    for key in ["counts", "losses", "best_step", "row_entropy", "q_spread"] {
        assert_eq!(train["training"][key], render["training"][key], "{key}");
    }
    for report in [&train, &render] {
        let seconds = |key: &str| report[key].as_f64().expect("seconds");
        assert!(seconds("pretracing_seconds") > 0.0);
        assert!(seconds("preprocessing_seconds") > seconds("pretracing_seconds"));
    }
    assert!(train["camera_paths"].as_u64().is_some_and(|paths| paths >= 1000), "{train}");
    assert_eq!(train["connections"]["counts"], serde_json::json!([9, 2, 1]));

    case.run(&format!("{TRAIN} -o again.model")).assert(0, &[]);
    case.run("info --model again.model").assert(0, &[]);
    case.run(&format!("{RENDER} --model again.model -o again.exr")).assert(0, &[]);
    assert_eq!(case.picture("again.exr").rgb, case.picture("by-model.exr").rgb);
    // Unbiased with another number of connections, so allowed, and said to who asks for more.
    case.run(&format!("{RENDER} --connections 2 --model cornell.model -v"))
        .assert(0, &["trained for 9,2,1 connections with shares 3,2,1,4, this render has 2 connections"]);
}

/// What was chosen for this scene is said with its reason; what was asked for is not.
#[test]
fn choices_are_said() {
    let case = Case::new();
    let run = case.run(&format!("{RENDER} --rounds 2 --stats render.json"));
    run.assert(
        0,
        &[
            "chosen: learning first (the same seed makes the same picture)",
            "rounds 2 (as many as wanted)",
            "subspaces ",
            "light paths at a time 2048 (0.25 for each sample",
        ],
    );
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(case.path("render.json")).expect("a report")).expect("JSON");
    assert_eq!(report["choices"].as_array().map(Vec::len), Some(7), "{report}");
    assert_eq!(report["round_losses"].as_array().map(Vec::len), Some(1), "{report}");
    let run = case.run(&format!("{RENDER} --train-paths 900 --light-paths 99 --subspaces 5"));
    run.assert(0, &["samples that share light paths 8 ("]);
    assert_eq!(run.said.matches("chosen: ").count(), 4, "{}", run.said);
    // The number of rounds makes a render's own learning that of `train`, whatever its budget.
    case.run("train builtin:cornell --size 32x32 --rounds 2 --seed 3").assert(0, &["chosen: rounds 2"]);
    let unsaid = "connections 9,2,1 (the model does not say how many are worth it: it takes two rounds and paths that \
                  judge them)";
    case.run(&format!("{RENDER} --model cornell.model -o by-model.exr")).assert(0, &[unsaid]);
    case.run(&format!("{RENDER} --rounds 2 -o by-itself.exr")).assert(0, &[]);
    assert_eq!(case.picture("by-model.exr").rgb, case.picture("by-itself.exr").rgb);
    // Three rounds tell how many connections first vertices are worth. None are chosen where a number is named.
    let worth = "9 of each first vertex leave ";
    case.run("train builtin:cornell --size 32x32 --rounds 3 --seed 3").assert(0, &["chosen: rounds 3"]);
    let info = case.run("info builtin:cornell --model cornell.model").printed;
    assert!(info.contains("first connections") && info.contains(worth), "{info}");
    case.run(&format!("{RENDER} --model cornell.model")).assert(0, &["chosen: connections ", worth]);
    let run = case.run(&format!("{RENDER} --model cornell.model --connections 9,2,1"));
    run.assert(0, &[]);
    assert!(!run.said.contains("chosen: connections"), "{}", run.said);
}

#[test]
fn models_that_do_not_fit_end_with_2() {
    let case = trained();
    let refuse = |arguments: &str, phrases: &[&str]| {
        case.refuse(&format!("render {arguments} --size 8x8 --spp 1 -o DIR/out.exr"), phrases);
    };
    let spcbpt = "builtin:cornell -i spcbpt --model DIR";
    // Where no integrator is named, a model chooses its own.
    let chosen = case.run("render builtin:cornell --model cornell.model --size 8x8 --spp 1 -o chosen.exr");
    chosen.assert(0, &["chosen: integrator spcbpt (there is a model of the scene)"]);
    refuse("builtin:cornell -i lvcbpt --model DIR/cornell.model", &["--model", "add --integrator spcbpt"]);
    for (setting, flag) in [
        ("--train-paths 9", "--train-paths"),
        ("--subspaces 9", "--subspaces"),
        ("--rounds 2", "--rounds"),
        ("--learn first", "--learn"),
        ("--uniform-share 0.2", "--uniform-share"),
        ("--power-share 0.2", "--power-share"),
        ("--quality draft", "--quality"),
    ] {
        refuse(&format!("{spcbpt}/cornell.model {setting}"), &["--model", flag]);
    }
    refuse("builtin:door -i spcbpt --model DIR/cornell.model", &["another scene", "halfway train"]);
    refuse(&format!("{spcbpt}/none.model"), &["none.model", "check that the file is there"]);
    refuse(&format!("{spcbpt}/train.json"), &["train.json is no model", "halfway train"]);

    let whole = std::fs::read(case.path("cornell.model")).expect("the model");
    let changed = |change: fn(&mut Vec<u8>)| {
        let mut bytes = whole.clone();
        change(&mut bytes);
        std::fs::write(case.path("cornell.model"), bytes).expect("a writable folder");
    };
    changed(|bytes| bytes.truncate(1000));
    refuse(&format!("{spcbpt}/cornell.model"), &["cut off", "copy it again, or train again"]);
    changed(|bytes| bytes[500] ^= 1);
    refuse(&format!("{spcbpt}/cornell.model"), &["damaged", "copy it again, or train again"]);
    case.refuse("info --model DIR/cornell.model", &["damaged"]);
    changed(|bytes| bytes[8] += 1);
    refuse(&format!("{spcbpt}/cornell.model"), &["version", "train again"]);
}

#[test]
fn train_refuses_what_makes_no_sense() {
    let case = Case::new();
    case.write("dark.gltf", &GltfFile::triangle());
    for (arguments, phrase) in [
        ("builtin:cornell -o DIR/out.exr", ".model"),
        ("builtin:cornell -o DIR/no/such/out.model", "no/such"),
        ("builtin:cornell --uniform-share 0", "uniform_share"),
        ("builtin:cornell --tree-depth 99", "tree_depth"),
        ("builtin:cornell --connections 65", "--connections"),
        ("builtin:cornell --connections 4,3,2,1", "one to three"),
        ("builtin:cornell --shares 1,1,0,1", "four numbers"),
        ("builtin:cornell --max-depth 0", "--max-depth"),
        ("builtin:cornell --optimiser adam", "softmax"),
        ("builtin:cornell --camera 7", "no camera 7"),
        ("builtin:nowhere", "nowhere"),
        ("DIR/dark.gltf", "no light"),
    ] {
        case.refuse(&format!("train {arguments}"), &[phrase]);
    }
    let command = format!("{TRAIN} --optimiser softmax --uniform-share 0.2 --tree-depth 4 --subspaces 6 -q");
    let run = case.run(&command);
    run.assert(0, &[]);
    assert_eq!((run.said.as_str(), run.printed.as_str()), ("", "cornell.model\n"));
    let info = case.run("info --model cornell.model").printed;
    for phrase in ["6 eye, 6 light: as asked for", "(softmax)", "uniform share 0.2"] {
        assert!(info.contains(phrase), "'{phrase}' not in\n{info}");
    }
}

#[test]
fn info_tells_what_was_learnt() {
    let case = trained();
    let run = case.run("info --model cornell.model");
    run.assert(0, &[]);
    for phrase in [
        "model cornell.model",
        "subspaces",
        "learnt",
        "in use",
        "entropy",
        "bits",
        "held-out paths",
        "9,2,1 connections",
        "light paths",
    ] {
        assert!(run.printed.contains(phrase), "'{phrase}' not in\n{}", run.printed);
    }
    assert!(!run.printed.contains("fits the scene") && !run.printed.contains("NaN"), "{}", run.printed);
    let fits = |scene: &str| {
        let run = case.run(&format!("info {scene} --model cornell.model"));
        run.assert(0, &[]);
        run.printed.lines().last().expect("a line").to_owned()
    };
    assert!(fits("builtin:cornell").ends_with("yes"));
    assert!(fits("builtin:door").contains("no, "));
    // Neither needs a scene.
    assert!(case.run("info --builtins").printed.contains("builtin:door\n"));
    case.refuse("info", &["--model", "--builtins"]);
}

#[test]
fn debug_shows_the_subspaces() {
    let case = trained();
    let run = case.run(&format!("{RENDER} --model cornell.model -o out.exr --debug subspaces"));
    run.assert(0, &[]);
    let names = ["out.exr", "out.eye-subspaces.png", "out.light-subspaces.png", "out.gamma.png"];
    assert_eq!(run.printed.lines().collect::<Vec<_>>(), names);
    // More hues than shades could make, dark where the lamp is.
    let hues = |picture: &Picture| {
        let mut found: Vec<[u8; 2]> = Vec::new();
        for [r, g, b] in picture.rgb.iter().copied().filter(|pixel| *pixel != [0.0; 3]) {
            let sum = r + g + b;
            let hue = [r, g].map(|channel| (16.0 * channel / sum) as u8);
            if !found.contains(&hue) {
                found.push(hue);
            }
        }
        found.len()
    };
    for name in &names[1..3] {
        let picture = case.picture(name);
        assert_eq!((picture.width, picture.height), (32, 32));
        assert!(picture.rgb.contains(&[0.0; 3]), "{name} has no lamp");
        assert!(picture.rgb.contains(&[1.0; 3]), "{name} has no centroid");
        assert!(hues(&picture) > 4, "{name} has {} hues", hues(&picture));
    }
    let gamma = case.picture("out.gamma.png");
    assert!(gamma.width == gamma.height && (300..600).contains(&gamma.width), "{}", gamma.width);
    assert!(hues(&gamma) > 4);
}

/// A square of directions for each light subspace, in one picture; and how far what is seen first guides light.
#[test]
fn debug_shows_the_guides() {
    let case = Case::new();
    case.run("train builtin:three-lights --size 32x32 --rounds 2 --seed 3 -o m.model").assert(0, &[]);
    let render = "render builtin:three-lights --size 32x32 --spp 1 -i spcbpt --debug guides";
    let run = case.run(&format!("{render} --model m.model -o out.exr"));
    run.assert(0, &[]);
    let names = ["out.exr", "out.guides.png", "out.guided.png"];
    assert!(names.iter().all(|name| run.printed.contains(name)), "{}", run.printed);
    let guided = case.picture("out.guided.png");
    assert_eq!((guided.width, guided.height), (32, 32));
    let seen: Vec<[f32; 3]> = guided.rgb.iter().copied().filter(|pixel| *pixel != [0.0; 3]).collect();
    assert!(seen.len() > 300 && seen.iter().any(|pixel| *pixel != seen[0]), "{} pixels", seen.len());
    let squares = case.picture("out.guides.png");
    assert!(squares.width == squares.height && squares.width >= 300, "{}", squares.width);
    // Says what the picture shows.
    let info = case.run("info --model m.model").printed;
    let line = info.lines().find(|line| line.contains("light paths")).expect("a line");
    assert!(line.contains("guided; ") && line.contains("of 64 cells"), "{line}");
    case.run(&format!("{render} --train-paths 500 --no-light-guide -o none.exr"))
        .assert(0, &["no guide to show"]);
    assert!(!case.files().contains(&"none.guides.png".to_string()), "{:?}", case.files());
}

/// Ctrl-C while it learns: nothing is there to save, which is said.
#[test]
#[cfg(unix)]
fn r05_learning_can_be_interrupted() {
    let start = |arguments: &str| {
        let case = Case::new();
        let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
        let arguments = format!("{arguments} --size 64x64 --train-paths 1000000000");
        let said = std::fs::File::create(case.path("said")).expect("a file");
        let child = command.args(arguments.split(' ')).stderr(said).stdout(Stdio::null()).spawn();
        (case, child.expect("halfway runs"))
    };
    // The first line about the progress comes after ten seconds: of both at once.
    let runs = ["train builtin:cornell", "render builtin:cornell --integrator spcbpt"].map(start);
    for (case, mut child) in runs {
        let said = || std::fs::read_to_string(case.path("said")).expect("the file");
        let start = Instant::now();
        while !said().contains("learning: training paths") {
            assert!(start.elapsed() < Duration::from_secs(120), "no progress:\n{}", said());
            std::thread::sleep(Duration::from_millis(100));
        }
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(kill.expect("kill runs").success());
        let status = child.wait().expect("an end");
        let run = Run { code: status.code(), said: said(), printed: String::new() };
        run.assert(130, &["interrupted while it learnt", "nothing to save"]);
        assert_eq!(case.files(), ["said"]);
    }
}
