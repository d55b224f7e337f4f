//! `halfway render` and `halfway bench efficiency` as a user runs them: how they end, what they say and
//! what they leave behind.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use clap::Parser as _;
use halfway::cli::{self, Cli, Exit};
use halfway::film::{Attribute, Picture};
use halfway::integrator::METHODS;
use halfway::integrator::method::Setting;
use serde_json::json;

use crate::gltf_file::GltfFile;

/// A folder to run in.
pub struct Case {
    folder: tempfile::TempDir,
}

impl Case {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(program);
        // Whatever is rescued into the folder of temporary files is the case's own.
        command.current_dir(self.folder.path()).env("TMPDIR", self.folder.path()).env_remove("RUST_LOG");
        command
    }

    /// Runs `halfway` with arguments separated by spaces.
    pub fn run(&self, arguments: &str) -> Run {
        let mut command = self.command(env!("CARGO_BIN_EXE_halfway"));
        Run::of(command.args(arguments.split_whitespace()).output().expect("halfway runs"))
    }

    /// Asserts that arguments are refused as bad input, with every phrase, and that no file comes of them; returns what is
    /// said. `DIR` is the folder. No program is started, since nothing may have been opened by then.
    #[track_caller]
    pub fn refuse(&self, arguments: &str, phrases: &[&str]) -> String {
        let before = self.files();
        let arguments = arguments.replace("DIR", &self.folder.path().to_string_lossy());
        let run = Run::inside(&arguments);
        run.assert(2, phrases);
        assert_eq!(self.files(), before, "after {arguments}");
        run.said
    }

    pub fn write(&self, name: &str, file: &GltfFile) {
        std::fs::write(self.path(name), file.gltf()).expect("a writable folder");
    }

    /// The picture at the default name.
    pub fn picture(&self, name: &str) -> Picture {
        let picture = Picture::read(&self.path(name)).expect("a valid picture");
        assert!(picture.rgb.iter().flatten().all(|value| value.is_finite()));
        picture
    }

    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// How a run ended, what it said on stderr and what it printed on stdout.
pub struct Run {
    pub code: Option<i32>,
    pub said: String,
    pub printed: String,
}

impl Run {
    pub fn of(output: Output) -> Self {
        let [said, printed] =
            [&output.stderr, &output.stdout].map(|text| String::from_utf8_lossy(text).into());
        Self { code: output.status.code(), said, printed }
    }

    /// How `halfway` would end with these arguments, without starting it: for what it says before it opens a device.
    pub fn inside(arguments: &str) -> Self {
        let (code, said) =
            match Cli::try_parse_from(["halfway"].into_iter().chain(arguments.split_whitespace())) {
                Err(error) => (error.exit_code(), error.to_string()),
                Ok(cli) => match cli::run(&cli) {
                    Ok(exit) => (exit as i32, String::new()),
                    Err(error) => (Exit::from(error.fault()) as i32, error.to_string()),
                },
            };
        Self { code: Some(code), said, printed: String::new() }
    }

    /// Asserts the exit code and that every phrase was said, in a message and not in a panic.
    #[track_caller]
    pub fn assert(&self, code: i32, phrases: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.said);
        assert!(!self.said.contains("panicked"), "{}", self.said);
        for phrase in phrases {
            assert!(self.said.contains(phrase), "'{phrase}' not in\n{}", self.said);
        }
    }
}

pub fn is_black(picture: &Picture) -> bool {
    picture.rgb.iter().flatten().all(|&value| value == 0.0)
}

/// The exit codes of the program itself; all else that is refused is asked for inside.
#[test]
fn r07_usage_ends_with_its_exit_code() {
    let case = Case::new();
    case.run("render").assert(2, &["SCENE"]);
    case.run("render missing.glb").assert(2, &["missing.glb"]);
    case.run("render builtin:cornell --size 16x16 --crop 12,0,8,8").assert(2, &["--crop"]);
    case.run("render builtin:cornell --spp 1 --device nosuch").assert(4, &["nosuch", "there are"]);
    assert!(case.files().is_empty(), "left {:?}", case.files());
}

#[test]
fn r07_usage_that_makes_no_sense_is_refused() {
    let case = Case::new();
    for (arguments, phrase) in [
        ("--spp 0", "--spp"),
        ("--max-depth 0", "--max-depth"),
        ("--size 0x4", "size"),
        ("--crop 0,0,8", "a part is"),
        ("--error 0", "--error"),
        ("--camera 7", "no camera 7"),
        ("--fov 180", "below 180"),
        ("--look-from 1,2,3", "--look-at"),
        ("--output picture.jpg", "picture.jpg"),
        ("--output DIR/no/such/place.exr", "no/such"),
        ("--env missing.exr", "missing.exr"),
        ("--trace-error errors.csv", "--reference"),
        ("--reference missing.exr", "missing.exr"),
    ] {
        case.refuse(&format!("render builtin:cornell -o DIR/out.exr {arguments}"), &[phrase]);
    }
    case.refuse("render builtin:nowhere -o DIR/out.exr", &["nowhere", "cornell"]);
}

/// A message holds its cause, and nothing is put behind it.
#[test]
fn r07_causes_are_told_once() {
    let case = Case::new();
    std::fs::write(case.path("cut.gltf"), "{\"asset\": ").expect("a writable folder");
    for (arguments, cause) in [
        ("render DIR/nothere.gltf -o DIR/out.exr", "No such file or directory (os error 2)"),
        ("render DIR/cut.gltf -o DIR/out.exr", "EOF while parsing"),
        ("render builtin:cornell -o DIR/out.exr --env nothere.exr", "No such file or directory (os error 2)"),
        ("compare nothere.png nothere.exr", "No such file or directory (os error 2)"),
        ("info --model nothere.model", "No such file or directory (os error 2)"),
    ] {
        let said = case.refuse(arguments, &[cause]);
        assert_eq!(said.matches(cause).count(), 1, "{arguments}: {said}");
    }
}

/// The integrators that have a setting, as messages list them.
fn having(setting: Setting) -> String {
    let names: Vec<&str> =
        METHODS.into_iter().filter(|method| method.takes(setting)).map(|method| method.name).collect();
    let (last, all) = names.split_last().expect("an integrator that has it");
    format!("{} and {last}", all.join(", "))
}

/// A setting that the chosen integrator does not have may not be ignored.
#[test]
fn r07_settings_of_another_integrator_are_refused() {
    let case = Case::new();
    let [light_paths, light_tracing] = [Setting::LightPaths, Setting::LightTracing].map(having);
    for (arguments, phrases) in [
        ("--connections 4", &["--connections", "lvcbpt", "--integrator"][..]),
        ("-i bdpt --connections 4", &["--connections", "lvcbpt", "--integrator"]),
        ("-i lvcbpt --connections 0", &["--connections", "1 to 64"]),
        ("-i lvcbpt --connections 65", &["--connections", "1 to 64"]),
        ("--light-paths 100", &["--light-paths", &light_paths, "--integrator"]),
        ("-i bdpt --light-paths 100", &["--light-paths", &light_paths, "--integrator"]),
        ("-i light --light-paths 0", &["--light-paths", "at least 1"]),
        ("-i lvcbpt --light-paths 0", &["--light-paths", "at least 1"]),
        ("--light-tracing", &["--light-tracing", &light_tracing, "--integrator"]),
        ("-i path --no-light-tracing", &["--no-light-tracing", &light_tracing, "--integrator"]),
        ("-i light --light-tracing", &["--light-tracing", &light_tracing, "--integrator"]),
        ("--roulette-cap 0", &["--roulette-cap", "above 0 and at most 1"]),
        ("--roulette-cap 1.5", &["--roulette-cap", "above 0 and at most 1"]),
        ("--uniform-share 0.2", &["--uniform-share", "spcbpt", "--integrator"]),
        ("-i spcbpt --uniform-share 0", &["uniform_share", "between 0.000001 and 1"]),
        ("-i spcbpt --power-share 2", &["power_share", "between 0 and 1"]),
        ("--quality draft", &["--quality", "spcbpt", "--integrator"]),
        ("--rounds 2", &["--rounds", "spcbpt", "--integrator"]),
        ("--lessons 2", &["--rounds", "spcbpt", "--integrator"]),
        ("-i spcbpt --rounds 2 --train-paths 9", &["--rounds", "--train-paths", "cannot be used"]),
        ("-i spcbpt --rounds 17", &["--rounds", "1..=16"]),
        ("-i spcbpt --train-paths 9 --quality high", &["--train-paths", "--quality"]),
        ("-i spcbpt --train-paths 9 --learn meanwhile", &["--train-paths", "--learn"]),
        ("--learn first", &["--learn", "spcbpt"]),
        ("-i spcbpt --quality best", &["best", "draft, normal, high"]),
        ("-i photons", &["photons", "bdpt, lvcbpt"]),
        ("--debug subspaces", &["--debug subspaces", "add --integrator spcbpt"]),
        ("--debug nothing", &["subspaces"]),
        ("--strategies out --max-depth 3", &["--strategies", "--integrator bdpt or lvcbpt"]),
        ("--strategies out --max-depth 3 -i light", &["--strategies", "--integrator bdpt or lvcbpt"]),
        ("--strategies out -i bdpt", &["--strategies", "--max-depth N, at most 12"]),
        ("--strategies out -i bdpt --max-depth 13", &["--strategies", "--max-depth N, at most 12"]),
    ] {
        case.refuse(&format!("render builtin:cornell -o DIR/out.exr {arguments}"), phrases);
    }
}

/// A picture for each strategy that paths of up to two surfaces have, and an overview.
#[test]
fn strategies_are_written() {
    let case = Case::new();
    let command = "render builtin:cornell --size 8x8 --spp 2 --max-depth 2 -o out.exr --integrator lvcbpt \
                   --light-tracing --strategies all/strategies";
    case.run(command).assert(0, &[]);
    assert_eq!(case.picture("out.exr").attribute("integrator"), Some(&Attribute::Text("lvcbpt".into())));
    let entries = std::fs::read_dir(case.path("all/strategies")).expect("the folder");
    let mut found: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    found.sort();
    let mut expected = vec!["unweighted.png".to_string(), "weighted.png".to_string()];
    let strategies = ["s0-t2", "s0-t3", "s1-t2", "s2-t1"];
    expected
        .extend(strategies.iter().flat_map(|s| [format!("{s}-unweighted.exr"), format!("{s}-weighted.exr")]));
    expected.sort();
    assert_eq!(found, expected);
    // The weighted ones are the picture.
    let mut sum = vec![0.0; 3 * 64];
    for name in strategies {
        let picture = case.picture(&format!("all/strategies/{name}-weighted.exr"));
        assert_eq!((picture.width, picture.height), (8, 8));
        sum.iter_mut().zip(picture.rgb.as_flattened()).for_each(|(sum, value)| *sum += value);
    }
    for (sum, whole) in sum.iter().zip(case.picture("out.exr").rgb.as_flattened()) {
        assert!((sum - whole).abs() <= 1e-5 * whole.abs().max(1e-3), "{sum} is not {whole}");
    }
}

#[test]
fn r07_scenes_with_nothing_in_them() {
    let case = Case::new();
    let options = "--spp 4 --size 8x8 -o out.exr";
    case.write("empty.gltf", &GltfFile::empty());
    case.run(&format!("render empty.gltf {options}")).assert(0, &["no triangles", "no light", "no camera"]);
    assert!(is_black(&case.picture("out.exr")));

    case.write("dark.gltf", &GltfFile::triangle());
    case.run(&format!("render dark.gltf {options}")).assert(0, &["no light", "no camera"]);
    assert!(is_black(&case.picture("out.exr")));

    let mut bright = GltfFile::triangle();
    bright.material(json!({"emissiveFactor": [1, 0.5, 0.25], "doubleSided": true}));
    case.write("bright.gltf", &bright);
    let run = case.run(&format!("render bright.gltf {options}"));
    run.assert(0, &["no camera"]);
    assert!(!run.said.contains("no light"), "{}", run.said);
    let picture = case.picture("out.exr");
    assert!(picture.rgb.contains(&[1.0, 0.5, 0.25]), "the triangle fills some pixel");

    case.run("render builtin:cornell --spp 4 --size 1x1 -o out.exr").assert(0, &[]);
    let picture = case.picture("out.exr");
    assert_eq!((picture.width, picture.height), (1, 1));
    assert!(!is_black(&picture));
}

#[test]
fn r07_the_same_command_makes_the_same_picture() {
    let case = Case::new();
    let render = |output: &str, seed: u32| {
        let run = case.run(&format!("render builtin:cornell --spp 8 --size 16x16 --seed {seed} -o {output}"));
        run.assert(0, &["device: "]);
    };
    render("a.exr", 0);
    render("b.exr", 0);
    render("c.exr", 1);
    case.run("compare a.exr b.exr --fail-above mape=0").assert(0, &[]);
    case.run("compare a.exr c.exr --fail-above mape=0.001").assert(1, &[]);
    let picture = case.picture("a.exr");
    assert_eq!(picture.attribute("spp"), Some(&Attribute::Number(8.0)));
    assert_eq!(picture.attribute("nonFiniteSamples"), Some(&Attribute::Number(0.0)));
}

#[test]
fn r07_an_error_that_is_not_met_ends_with_3() {
    let case = Case::new();
    let command = "render builtin:cornell --size 8x8 --spp 64 -o out.exr";
    case.run(&format!("{command} --error 1e-6")).assert(3, &["64 spp", "--spp reached"]);
    assert!(!is_black(&case.picture("out.exr")));
    case.run(&format!("{command} --error 0.9")).assert(0, &["--error reached"]);
}

/// A disk that is full, a place that is none, and a file that grows past what is allowed: the reason is told, what was
/// there stays, and nothing is left beside it.
#[test]
#[cfg(target_os = "linux")]
fn r04_a_picture_that_cannot_be_written() {
    let case = Case::new();
    let command = "render builtin:cornell --spp 1 --size 256x256";
    std::os::unix::fs::symlink("/dev/full", case.path("full.exr")).expect("a link");
    // A device is not asked before: it fails at the end, and the picture goes elsewhere.
    let run = case.run(&format!("{command} -o full.exr"));
    run.assert(
        1,
        &["an output failed", "os error 28", "full.exr", "the picture is kept in", "no output was"],
    );
    let rescued = case.files().into_iter().find(|name| name.starts_with("halfway-")).expect("a picture");
    assert!(run.said.contains(&rescued) && !is_black(&case.picture(&rescued)), "{}", run.said);
    std::fs::remove_file(case.path(&rescued)).expect("the picture");
    let run = case.run(&format!("{command} -o full.exr -o good.exr --stats good.json"));
    run.assert(1, &["an output failed", "os error 28", "full.exr", "written: good.exr, good.json"]);
    assert_eq!(run.printed, "good.exr\n");
    assert_eq!(case.files(), ["full.exr", "good.exr", "good.json"]);
    assert!(!is_black(&case.picture("good.exr")));
    // A folder that is not there is seen before hours of rendering.
    case.run(&format!("{command} -o no/such/place.exr")).assert(2, &["no/such", "folder"]);
    std::fs::remove_file(case.path("full.exr")).expect("the link");

    // A file system of 64 KiB of its own; where that is not allowed, the unit test of `film::write` stands alone.
    let script = format!(
        "mount -t tmpfs -o size=64k none . && cd . && printf old > good.exr || exit 99
         \"$0\" {command} -o \"$PWD/good.exr\"; code=$?
         echo \"after: $(cat good.exr), $(ls)\" >&2; exit $code"
    );
    let mut unshare = case.command("unshare");
    let unshare = unshare.args(["-rm", "sh", "-c", &script, env!("CARGO_BIN_EXE_halfway")]).output();
    match unshare.map(Run::of) {
        Ok(run) if run.said.contains("after: ") => run.assert(1, &["os error 28", "after: old, good.exr\n"]),
        Ok(run) => println!("skipped the small file system: {}", run.said),
        Err(error) => println!("skipped the small file system: {error}"),
    }
}

/// Ctrl-C: the picture so far is saved whole, and the exit code says what happened.
#[test]
#[cfg(unix)]
fn r05_an_interrupted_render_is_saved() {
    let case = Case::new();
    let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
    // The first save says that the render has begun.
    let arguments = "render builtin:cornell --size 16x16 --spp 100000000 --save-every 10ms -o out.exr";
    let child = command.args(arguments.split(' ')).stderr(Stdio::piped()).stdout(Stdio::null()).spawn();
    let child = child.expect("halfway runs");
    let start = Instant::now();
    while !case.path("out.exr").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no picture after a minute");
        std::thread::sleep(Duration::from_millis(10));
    }
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    Run::of(child.wait_with_output().expect("an end")).assert(130, &["interrupted"]);
    let picture = case.picture("out.exr");
    assert!(!is_black(&picture));
    let Some(Attribute::Number(samples)) = picture.attribute("spp") else { panic!("no spp") };
    assert!(*samples >= 1.0 && *samples < 1e8, "{samples}");
    let counts = picture.channel("samples", "Y").expect("a sample count");
    assert!(counts.iter().all(|&count| f64::from(count) == *samples), "{counts:?} are not {samples}");
    assert_eq!(case.files(), ["out.exr"]);
}

/// Every number is there and finite: JSON has no other numbers, and `null` where one is missing.
pub fn assert_complete(value: &serde_json::Value, at: &str) {
    match value {
        serde_json::Value::Null => panic!("nothing at {at}"),
        serde_json::Value::Array(values) => {
            assert!(!values.is_empty(), "nothing in {at}");
            values.iter().enumerate().for_each(|(i, value)| assert_complete(value, &format!("{at}/{i}")));
        }
        serde_json::Value::Object(values) => {
            values.iter().for_each(|(name, value)| assert_complete(value, &format!("{at}/{name}")));
        }
        _ => {}
    }
}

#[test]
fn bench_efficiency_measures_and_keeps_its_references() {
    let case = Case::new();
    let command = "bench efficiency builtin:cornell --integrators path,bdpt --rounds 2 --size 8x8 \
                   --references refs --reference-time 500ms --reference-integrator path --reference-stride 2";
    let run = case.run(&format!("{command} --spp 4 --json"));
    run.assert(0, &["a reference by path", "round 2 of 2, bdpt"]);
    let report: serde_json::Value = serde_json::from_str(&run.printed).expect("JSON");
    let scene = &report["scenes"][0];
    let memory = scene["integrators"][1].clone();
    assert!(memory["bytes"].as_u64().is_some_and(|bytes| bytes > 0), "{memory}");
    assert_complete(&report, "");
    let keys =
        ["seconds", "mape", "relmse", "relmse_trimmed", "efficiency", "mean_ratio", "mean_ratio_error"];
    for (index, name) in ["path", "bdpt"].into_iter().enumerate() {
        let result = &scene["integrators"][index];
        assert_eq!(result["name"], name);
        assert_eq!(result["runs"].as_array().map(Vec::len), Some(2));
        assert_eq!(result["summary"]["samples"], 4);
        for key in keys {
            assert!(result["summary"][key].as_f64().is_some_and(|value| value > 0.0), "{key} in {result}");
        }
        assert_eq!(result["summary"]["ratio"]["interval"].as_array().map(Vec::len), Some(2), "{result}");
        let vertices = result["summary"]["iteration"]["light_vertices"].as_f64().expect("a count");
        assert_eq!(vertices > 0.0, name == "bdpt", "{vertices} light vertices of {name}");
    }
    let seeds = |index: usize| scene["integrators"][index]["runs"].as_array().expect("runs").iter();
    let mut seeds: Vec<_> = seeds(0).chain(seeds(1)).filter_map(|run| run["seed"].as_u64()).collect();
    seeds.sort_unstable();
    assert_eq!(seeds, [1, 2, 3, 4]);

    // Again, by time and as a table: the reference is there.
    let kept = scene["reference"]["file"].as_str().expect("a path");
    let bytes = std::fs::read(case.path(kept)).expect("the reference");
    let run = case.run(&format!("{command} --time 10ms"));
    run.assert(0, &["how fast is bdpt"]);
    assert!(!run.said.contains("a reference by"), "{}", run.said);
    assert_eq!(std::fs::read(case.path(kept)).expect("the reference"), bytes);
    assert!(run.printed.contains("`halfway bench efficiency builtin:cornell"), "{}", run.printed);
    let columns =
        run.printed.lines().filter(|line| line.starts_with('|')).map(|line| line.matches('|').count());
    assert_eq!(columns.collect::<Vec<_>>(), [15; 4], "{}", run.printed);

    // One of the user's own goes before, but not that of another scene.
    std::fs::copy(case.path(kept), case.path("refs/cornell.exr")).expect("a copy");
    std::fs::copy(case.path(kept), case.path("refs/door.exr")).expect("a copy");
    let command = command.replace("cornell", "cornell builtin:door").replace("path,bdpt", "path");
    let run = case.run(&format!("{command} --spp 1 --json"));
    run.assert(0, &["door.exr is of another size or scene", "door: a reference by path"]);
    let report: serde_json::Value = serde_json::from_str(&run.printed).expect("JSON");
    assert_eq!(report["scenes"][0]["reference"]["file"], "refs/cornell.exr");
}

#[test]
fn bench_efficiency_refuses_what_makes_no_sense() {
    let case = Case::new();
    for (arguments, phrase) in [
        ("--integrators path,photon", "'photon'"),
        ("--integrators path:connections=2", "--connections"),
        ("--reference-integrator path,bdpt", "'path,bdpt'"),
        ("--rounds 1", "--rounds"),
        ("--spp 0", "--spp"),
        ("--spp 4 --time 1s", "--time"),
    ] {
        case.refuse(&format!("bench efficiency builtin:cornell --size 8x8 {arguments}"), &[phrase]);
    }
    case.refuse("bench efficiency", &["SCENE"]);
    // The device is open by then.
    case.run("bench efficiency builtin:nowhere").assert(2, &["nowhere", "cornell"]);
}

/// `halfway info --builtins | head` is no fault; a full disk is one.
#[test]
fn results_that_nobody_reads_are_dropped() {
    let case = Case::new();
    let mut info = case.command(env!("CARGO_BIN_EXE_halfway"));
    info.args(["info", "--builtins"]);
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let closed = Run::of(info.stdout(writer).output().expect("halfway runs"));
    closed.assert(0, &[]);
    assert!(closed.said.is_empty(), "{}", closed.said);
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
    let full = Run::of(info.stdout(full).output().expect("halfway runs"));
    full.assert(1, &["cannot write results to standard output: No space left"]);
}
