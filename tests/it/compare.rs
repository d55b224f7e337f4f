//! `halfway compare` as a user runs it: what it prints, and how it ends.

use std::io::Read;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Command, Output};

use halfway::film::{Picture, exr, tev::Viewer};

struct Case {
    folder: tempfile::TempDir,
}

impl Case {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A 16 x 16 picture of one value, with or without its variance.
    fn picture(&self, name: &str, value: f32, variance: Option<f32>) {
        let mut picture = Picture::new(16, 16, vec![[value; 3]; 256]);
        for channel in ["R", "G", "B"] {
            if let Some(variance) = variance {
                picture.push_channel("variance", channel, vec![variance; 256]);
            }
        }
        exr::write(&self.path(name), &picture).expect("written");
    }

    fn compare(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfway"));
        command.current_dir(self.folder.path()).arg("compare").args(arguments);
        command.output().expect("halfway runs")
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn compare_prints_a_table_and_ends_well() {
    let case = Case::new();
    case.picture("a.exr", 1.1, Some(1e-4));
    case.picture("b.exr", 1.0, Some(1e-4));
    let output = case.compare(&["a.exr", "b.exr", "--heatmap", "where.png"]);
    let stdout = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // 0.1 / 1.01, and 0.1 / (sqrt(2) 0.01 / 8) standard errors of a tile.
    for expected in ["mape", "0.099010", "1.100000", "+56.5", "dB", "orange 10 %"] {
        assert!(stdout.contains(expected), "{expected} not in\n{stdout}");
    }
    let map = image::open(case.path("where.png")).expect("a PNG");
    assert_eq!((map.width(), map.height()), (16, 16));
}

#[test]
fn compare_ends_with_the_exit_code_of_its_outcome() {
    let case = Case::new();
    case.picture("a.exr", 1.1, None);
    case.picture("b.exr", 1.0, None);
    case.picture("broken.exr", f32::NAN, None);
    exr::write(&case.path("small.exr"), &Picture::new(1, 1, vec![[1.0; 3]])).expect("written");
    for (arguments, code, said) in [
        (&["a.exr", "b.exr", "--fail-above", "mape=0.1"][..], 0, ""),
        (&["a.exr", "b.exr", "--fail-above", "mape=0.09"], 1, "beyond the limit: mape = 0.099010 > 0.09"),
        (
            &["a.exr", "b.exr", "--fail-above", "mape=0.2", "--fail-above", "mean=0.05"],
            1,
            "mean = 0.100000 > 0.05",
        ),
        (&["a.exr", "b.exr", "--fail-above", "tile-z=5"], 2, "variance layers"),
        (&["a.exr", "b.exr", "--fail-above", "speed=1"], 2, "choose one of mape, mape-paper"),
        (&["a.exr", "b.exr", "--fail-above", "mape"], 2, "METRIC=VALUE"),
        (&["a.exr", "b.exr", "--fail-above", "mape=NaN"], 2, "'NaN' is no number"),
        (&["a.exr"], 2, "REFERENCE"),
        (&["a.exr", "gone.exr"], 2, "gone.exr"),
        (&["a.exr", "small.exr"], 2, "--size"),
        (&["broken.exr", "b.exr"], 5, "256 in the picture, 0 in the reference"),
        (&["a.exr", "b.exr", "--heatmap", "no/folder.png"], 1, "no/folder.png"),
    ] {
        let output = case.compare(arguments);
        let all = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {all}");
        assert!(all.contains(said), "{arguments:?}: '{said}' not in {all}");
    }
}

#[test]
fn compare_speaks_json() {
    let case = Case::new();
    case.picture("a.exr", 1.1, None);
    case.picture("b.exr", 1.0, None);
    let output = case.compare(&["a.exr", "b.exr", "--json", "--fail-above", "relmse=0.001"]);
    assert_eq!(output.status.code(), Some(1));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!((report["mean"]["ratio"].as_f64().expect("a number") - 1.1).abs() < 1e-6);
    assert_eq!(report["mean"]["source"], "tile-scatter");
    assert_eq!(report["beyond"][0]["metric"], "relmse");
    assert!(report["tiles"].is_null());
}

#[test]
fn compare_explains_every_metric() {
    let help = text(&Case::new().compare(&["--help"]).stdout);
    for metric in ["mape", "mape-paper", "relmse", "relmse-trimmed", "mean-z", "tile-z", "psnr", "flip"] {
        assert!(help.contains(&format!("\n  {metric} ")), "{metric} not in\n{help}");
    }
}

/// Not even the strictest limit is exceeded.
#[test]
fn compare_of_a_file_with_itself_is_perfect() {
    let case = Case::new();
    case.picture("a.exr", 0.5, Some(0.01));
    let limits = ["mape", "mape-paper", "relmse", "relmse-trimmed", "mean", "mean-z", "tile-z", "flip"];
    let limits: Vec<String> = limits.iter().map(|metric| format!("--fail-above={metric}=0")).collect();
    let mut arguments = vec!["a.exr", "a.exr"];
    arguments.extend(limits.iter().map(String::as_str));
    let output = case.compare(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}{}", text(&output.stdout), text(&output.stderr));
    assert!(text(&output.stdout).contains("inf"));
}

#[test]
fn tev_gets_every_channel() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    let mut picture = Picture::new(3, 2, (0..6).map(|i| [i as f32, 0.0, -1.0]).collect());
    picture.push_channel("depth", "Z", vec![7.5; 6]);
    let received = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().expect("a caller").0.read_to_end(&mut bytes).expect("bytes");
        bytes
    });
    let mut viewer = Viewer::connect(&address).expect("a viewer listens");
    viewer.show("scene", &picture).expect("sent");
    viewer.show("scene", &picture).expect("sent");
    drop(viewer);
    let bytes = received.join().expect("no panic");

    // Packets: length (itself included), kind, content. 4 makes a picture, 6 updates it.
    let mut kinds = Vec::new();
    let mut rest = bytes.as_slice();
    while let Some(length) = rest.first_chunk() {
        let (packet, next) = rest.split_at(u32::from_le_bytes(*length) as usize);
        kinds.push(packet[4]);
        if kinds.len() == 2 {
            let red: Vec<u8> = (0..6).flat_map(|i| (i as f32).to_le_bytes()).collect();
            assert!(packet.ends_with(&red));
        }
        if kinds.len() == 5 {
            assert!(packet.windows(8).any(|part| part == b"depth.Z\0"));
            assert!(packet.ends_with(&7.5f32.to_le_bytes()));
        }
        rest = next;
    }
    assert_eq!(kinds, [4, 6, 6, 6, 6, 6, 6, 6, 6], "made once, four channels each time");
}

#[test]
fn tev_that_does_not_run_is_reported() {
    // A port that was free a moment ago.
    let free = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a port");
    for address in [free.to_string().as_str(), "nonsense"] {
        let message = Viewer::connect(address).err().expect("no viewer listens").to_string();
        assert!(message.contains(address) && message.contains("--tev"), "{message}");
    }
}
