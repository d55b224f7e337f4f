//! `halfway bench trade` and `halfway bench reference`: reading off curves, fronts, going on where it was.

use std::collections::BTreeSet;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use halfway::bench::reference::{AccumulatedReference, Pass, Reference, check};
use halfway::bench::speed::SpeedProbe;
use halfway::bench::trade::{Checkpoint, Goal, Plan, Typical, measure, summary, time_to, typical};
use halfway::film::average::average;
use halfway::film::metric::{self, ReferenceNoise};
use halfway::film::{Attribute, Layer, Picture, Region};
use halfway::math::curve::{self, Crossing, front};
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::builtin::builtin;
use serde_json::Value;

use crate::command::{Case, Run, assert_complete};
use crate::gpu;
use crate::shots::options;

fn assert_close(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-12, "{value} is not {expected}");
}

/// y = 0.5 x^-1/2.
fn power_law(xs: &[f64]) -> Vec<[f64; 2]> {
    xs.iter().map(|&x| [x, 0.5 * x.powf(-0.5)]).collect()
}

/// Crossings of a power law are exact between points and beyond the ends, as far as the curve is continued.
#[test]
fn crossings_of_a_power_law_are_exact() {
    let points = power_law(&[1.0, 2.0, 4.0, 8.0, 16.0]);
    for (x, expected) in [(3.0f64, "measured"), (16.0, "measured"), (50.0, "beyond"), (0.5, "beyond")] {
        let y = 0.5 * x.powf(-0.5);
        match (curve::crossing(&points, y), expected) {
            (Crossing::Measured(found), "measured") | (Crossing::Extrapolated(found), "beyond") => {
                assert_close(found, x);
            }
            (other, _) => panic!("{other:?} at {x}"),
        }
    }
    assert_eq!(curve::crossing(&points, 0.5 * 65f64.powf(-0.5)), Crossing::Never, "four times as far is 64");
    assert_eq!(curve::crossing(&points, 2.0), Crossing::AtMost(1.0), "0.0625 is too far");
    assert_eq!(curve::crossing(&points[..1], 0.1), Crossing::Never, "a point is no line");
    assert_eq!(curve::crossing(&[], 0.1), Crossing::Never);
}

/// A render that comes down to an error by chance, and goes up again, has not met it; one that goes up is not
/// continued.
#[test]
fn an_error_is_met_when_it_stays_met() {
    let points = [[1.0, 0.4], [2.0, 0.1], [4.0, 0.2], [16.0, 0.05]];
    // From 0.2 at 4 to 0.05 at 16 the slope is -1: 0.1 at 8.
    let Crossing::Measured(x) = curve::crossing(&points, 0.1) else { panic!("not measured") };
    assert_close(x, 8.0);
    assert_eq!(curve::crossing(&[[1.0, 0.2], [2.0, 0.3], [4.0, 0.4]], 0.1), Crossing::Never);
}

#[test]
fn values_of_a_power_law_are_exact() {
    let points = power_law(&[1.0, 2.0, 4.0, 8.0]);
    for (x, extrapolated) in [(1.0, false), (3.0, false), (8.0, false), (0.3, true), (31.0, true)] {
        let found = curve::value(&points, x).expect("within reach");
        assert_close(found.value, 0.5 * f64::powf(x, -0.5));
        assert_eq!(found.extrapolated, extrapolated, "at {x}");
    }
    assert_eq!(curve::value(&points, 33.0), None);
    assert_eq!(curve::value(&points, 0.2), None);
    assert_eq!(curve::value(&points, -1.0), None, "before the render began");
    assert_eq!(curve::value(&points[..1], 2.0), None);
}

/// Only the points that no other curve beats, at its points and between them.
#[test]
fn a_front_is_what_nothing_beats() {
    let points = [[4.0, 1.0], [1.0, 4.0], [2.0, 3.0], [2.0, 5.0], [3.0, 3.0], [5.0, 1.0]];
    let single: Vec<Vec<[f64; 2]>> = points.map(|point| vec![point]).into();
    assert_eq!(front(&single), [vec![0], vec![0], vec![0], vec![], vec![], vec![]]);
    // The second is lower at first, the first has 0.2 at 4, halfway between its points, and goes on.
    let curves =
        [vec![[1.0, 0.4], [16.0, 0.1]], vec![[1.0, 0.3], [4.0, 0.21]], vec![[0.5, 0.5], [4.0, 0.19]]];
    assert_eq!(front(&curves), [vec![1], vec![0], vec![0, 1]]);
    assert_eq!(front(&[]), Vec::<Vec<usize>>::new());
}

#[test]
fn checkpoints_double_and_take_in_the_equal_samples_and_the_end() {
    let plan = Plan { equal_samples: 100, ..Plan::default() };
    assert_eq!(plan.checkpoints().take(8).collect::<Vec<_>>(), [8, 16, 32, 64, 100, 128, 256, 512]);
    let plan = Plan { samples: Some(40), equal_samples: 8, ..plan };
    assert_eq!(plan.checkpoints().collect::<Vec<_>>(), [8, 16, 32, 40]);
    let plan = Plan { samples: Some(4), equal_samples: 1, ..plan };
    assert_eq!(plan.checkpoints().collect::<Vec<_>>(), [1, 4]);
}

/// A render whose error is 0.8 / sqrt(samples), and whose samples take 1 s.
fn render(preprocessing_seconds: f64, seconds_per_unit: f64, checkpoints: &[u32]) -> Vec<Checkpoint> {
    let checkpoint = |&samples: &u32| {
        let mape = 0.8 / f64::from(samples).sqrt();
        Checkpoint {
            samples,
            seconds: seconds_per_unit * f64::from(samples),
            preprocessing_seconds,
            work: 10.0 * seconds_per_unit * f64::from(samples),
            preprocessing_work: 10.0 * preprocessing_seconds,
            mape,
            relmse: mape * mape + 0.01,
            relmse_trimmed: mape * mape,
            mean_ratio: 1.0,
            flip: None,
            estimated_error: (samples >= 16).then_some(0.5 * mape),
            non_finite: 0,
        }
    };
    checkpoints.iter().map(checkpoint).collect()
}

/// Everything that a table tells, of renders that are power laws: time by rendering and with learning before it.
#[test]
fn a_summary_of_power_laws() {
    let checkpoints = [8, 16, 32, 64];
    let slow = [render(0.0, 4.0, &checkpoints), render(0.0, 4.0, &checkpoints)];
    let fast = [render(6.0, 1.0, &checkpoints), render(6.0, 1.0, &checkpoints)];
    let slices = |runs: &'static [Vec<Checkpoint>; 2]| [runs[0].as_slice(), &runs[1]];
    let (slow, fast) = (slices(Box::leak(Box::new(slow))), slices(Box::leak(Box::new(fast))));
    let noise = ReferenceNoise { relmse: 0.01, mape: 0.1, mean: 0.0 };
    // 0.16 = 0.8 / sqrt(25).
    let own = summary(&fast, &slow, Some(noise), 0.16, &[22.0, 70.0, 150.0, 300.0, 6.0], 100);
    assert_eq!(own.learning_seconds, 6.0);
    assert_close(own.target.rendering_seconds.value, 25.0);
    assert_close(own.target.seconds.value, 31.0);
    assert_close(own.target.samples.value, 25.0);
    assert!(!own.target.seconds.extrapolated);
    assert_eq!((own.target.met, own.target.at_once), (2, 0));
    assert_close(own.target.rendering_speedup.expect("both met").median, 4.0);
    assert_close(own.target.speedup.expect("both met").median, 100.0 / 31.0);

    let expected: Vec<_> = own.expected.iter().map(|e| e.map(|e| (e.value, e.extrapolated))).collect();
    let [at_22, at_70, at_150, at_300, at_6] = expected[..] else { panic!("five times") };
    assert_close(at_22.expect("measured").0, 0.2);
    assert_eq!(at_22.map(|(_, extrapolated)| extrapolated), Some(false));
    assert_eq!(at_70, Some((0.1, false)), "the last checkpoint");
    assert_close(at_150.expect("continued").0, 0.8 / 12.0);
    assert_eq!(at_150.map(|(_, extrapolated)| extrapolated), Some(true));
    assert_eq!((at_300, at_6), (None, None), "too far, and still learning");

    assert_close(own.equal_mape.expect("continued").value, 0.08);
    assert_close(own.equal_seconds.expect("continued").value, 106.0);
    // 1 / (0.01 x 64 s), the reference's noise subtracted; with learning 70 s.
    assert_close(own.efficiency.efficiency.expect("known"), 1.0 / 0.64);
    assert_close(own.efficiency_with_learning.efficiency.expect("known"), 1.0 / 0.7);
    assert_close(own.efficiency.ratio.expect("known").median, 4.0);

    let calibration = own.calibration.expect("from 16 samples on");
    assert_eq!((calibration.median, calibration.worst, calibration.checkpoints), (0.5, 0.5, 6));

    let never = summary(&fast, &slow, None, 0.001, &[], 8);
    assert!(never.target.seconds.value.is_infinite() && never.target.speedup.is_none());
    assert_eq!(never.target.met, 0);
    let at_once = summary(&fast, &slow, None, 0.9, &[], 8);
    assert_eq!((at_once.target.at_once, at_once.target.seconds.value), (2, 14.0));
    assert!(matches!(time_to(fast[0], 0.16), Crossing::Measured(_)));
}

/// Times are those of the work at a seconds_per_unit, whatever the clock said; nothing else changes.
#[test]
fn times_are_scaled_to_a_speed() {
    let points = render(6.0, 2.0, &[8, 16]);
    let scaled: Vec<Checkpoint> = points.iter().map(|point| point.at_speed(0.05)).collect();
    for (point, scaled) in points.iter().zip(&scaled) {
        // Ten units of work per second.
        assert_close(scaled.seconds, 0.5 * point.seconds);
        assert_close(scaled.total_seconds(), 0.5 * point.total_seconds());
        let back = Checkpoint {
            seconds: point.seconds,
            preprocessing_seconds: point.preprocessing_seconds,
            ..*scaled
        };
        assert_eq!(back, *point);
    }
}

/// The clock of work goes on where the device does, and does not count its own checkpoints.
#[test]
fn a_clock_tells_work() {
    let mut probe = SpeedProbe::new(gpu::context()).expect("a probe");
    let seconds_per_unit = probe.seconds_per_unit().expect("a seconds_per_unit");
    let mut clock = probe.clock().expect("a clock");
    assert!(!clock.is_due(1.9) && clock.is_due(2.1));
    let first = clock.work(10.0).expect("work");
    assert!(!clock.is_due(11.9) && clock.is_due(12.1));
    assert_eq!(clock.work(10.0).expect("the same"), first, "no time has passed");
    let second = clock.work(30.0).expect("more");
    // Twice the time; the device may have become much faster or slower meanwhile.
    let ratio = (second - first) / first;
    assert!((0.2..20.0).contains(&ratio), "{ratio}");
    assert!(
        (0.1..10.0).contains(&(first * seconds_per_unit / 10.0)),
        "{first} of {seconds_per_unit} s in 10 s"
    );
}

/// A render goes on where it will soon be at its goal, not where it is there or will not be.
#[test]
fn renders_go_on_to_a_goal_that_is_near() {
    let checkpoints = [8, 16, 32, 64];
    // 0.1 after 64 s, 0.05 after 256 s.
    let points = render(0.0, 1.0, &checkpoints);
    let goal = |error: f64, seconds: u64| Goal { error, longest: Duration::from_secs(seconds) };
    for (goal, near) in [
        (goal(0.05, 65), true),
        (goal(0.05, 63), false),
        (goal(0.1001, 100), false),
        (goal(0.0999, 100), true),
        (goal(0.0, 100), false),
    ] {
        assert_eq!(goal.is_near(&points), near, "{goal:?}");
    }
    assert!(!goal(0.05, 100).is_near(&points[..1]), "a point is no line");
    assert!(!goal(0.05, 100).is_near(&[]));
}

/// A render that is on its way checkpoints more often, and ends when it is there or at the longest time.
#[test]
fn a_render_goes_on_to_its_goal() {
    let scene = builtin("cornell").expect("a built-in scene");
    let shot = |samples| {
        let options = options([8, 8], samples);
        Renderer::new(gpu::context(), &scene, RenderOptions { budget: Budget::default(), ..options })
            .expect("a renderer")
    };
    let mut renderer = shot(0);
    renderer.set_budget(Budget { samples: Some(20_000), ..Budget::default() });
    renderer.run(|_| false).expect("a render");
    let reference = renderer.picture().expect("a picture");
    // The checkpoints compare every other pixel of every other row.
    let region = Region::lattice(8, 8, 2);
    let reference = Reference { picture: &reference.part(&region), region };
    let mut probe = SpeedProbe::new(gpu::context()).expect("a probe");
    let mut run = |time: Duration, goal: Option<Goal>| {
        let mut clock = probe.clock().expect("a clock");
        let plan = Plan { time: Some(time), equal_samples: 8, goal, ..Plan::default() };
        measure(&mut shot(1), &plan, &reference, &mut clock, None, |_| false)
            .expect("a render")
            .expect("its end")
    };
    // Long enough for a few checkpoints, however slow the device. Where others take it away in the second run, that has fewer of
    // them when it looks how far the goal is: then both take longer, some times.
    let mut times = (0..6).map(|doubled| Duration::from_millis(200 << doubled)).peekable();
    let (time, error, on) = loop {
        let time = times.next().expect("checkpoints within seconds");
        let first = run(time, None);
        if first.len() < 4 {
            continue;
        }
        // About ten times the samples: more than the device can be faster by, meanwhile, when other programs leave it.
        let error = 0.3 * first.last().expect("a checkpoint").mape;
        let on = run(time, Some(Goal { error, longest: Duration::from_secs(600) }));
        if on.len() > first.len() || times.peek().is_none() {
            break (time, error, on);
        }
    };
    let (last, rest) = on.split_last().expect("checkpoints");
    assert!(last.mape <= error && rest.iter().all(|point| point.mape > error), "{error}: {on:?}");
    let steps: Vec<f64> =
        on.windows(2).map(|pair| f64::from(pair[1].samples) / f64::from(pair[0].samples)).collect();
    assert!(steps.last().is_some_and(|&step| step < 1.7), "{steps:?}");
    // That is too far: it ends by the clock.
    let short = run(time, Some(Goal { error: 0.05 * error, longest: 2 * time }));
    assert!(short.last().is_some_and(|last| last.mape > 0.05 * error), "{short:?}");
}

/// Renders that end by the clock at different samples: checkpoints in common, then the ends.
#[test]
fn the_typical_render_ends_where_renders_end() {
    let runs = [render(1.0, 1.0, &[8, 16, 32, 40]), render(3.0, 1.0, &[8, 16, 20])];
    let curve = typical(&[&runs[0], &runs[1]]);
    let column = |of: fn(&Typical) -> f64| curve.iter().map(of).collect::<Vec<_>>();
    assert_eq!(column(|checkpoint| checkpoint.samples), [8.0, 16.0, 30.0]);
    assert_eq!(column(|checkpoint| checkpoint.total_seconds), [10.0, 18.0, 32.0]);
    assert_eq!(curve[0].estimated_over_measured, None);
    assert_eq!(curve[1].estimated_over_measured, Some(0.5));
}

fn picture(value: f32, variance: f32, samples: f32) -> Picture {
    let mut picture = Picture::new(2, 1, vec![[value; 3], [2.0 * value; 3]]);
    let channel = |name: &str, value: f32| (name.to_string(), vec![value; 2]);
    let channels = ["R", "G", "B"].map(|name| channel(name, variance));
    picture.layers.push(Layer { name: "variance".into(), channels: channels.into() });
    picture.layers.push(Layer { name: "samples".into(), channels: vec![channel("Y", samples)] });
    picture
}

#[test]
fn a_reference_grows_by_the_weighted_mean() {
    let (a, b) = (picture(1.0, 0.25, 30.0), picture(3.0, 0.5, 10.0));
    let both = average([&a, &b], [30.0, 10.0]).expect("one size");
    assert_eq!(both.rgb, [[1.5; 3], [3.0; 3]]);
    // 9/16 of 1/4 and 1/16 of 1/2.
    assert_eq!(both.channel("variance", "G"), Some(&[0.171_875; 2][..]));
    assert_eq!(both.channel("samples", "Y"), Some(&[40.0; 2][..]));
    assert!(average([&a, &Picture::new(1, 1, vec![[0.0; 3]])], [1.0; 2]).is_err());
}

/// Two integrators judge each other by how their passes scatter.
#[test]
fn a_check_is_as_certain_as_passes_scatter() {
    let accumulated = |means: [f64; 2]| AccumulatedReference {
        picture: picture(1.0, 0.25, 16.0),
        samples: 16,
        seconds: 1.0,
        non_finite: 0,
        passes: means.map(|mean| Pass { samples: 8, mean }).into(),
    };
    let found = check(&accumulated([0.9, 1.1]), &accumulated([2.1, 2.1])).expect("comparable");
    assert_close(found.mean_ratio, 2.1);
    // Of the reference: sqrt(2 x 0.01 / 1) / sqrt 2 = 0.1 of its mean; of the other none.
    assert_close(found.mean_ratio_error.expect("two passes"), 0.21);
    assert_close(found.z().expect("known"), 1.1 / 0.21);
    assert_eq!(found.tiles.map(|tiles| tiles.worst_z), Some(0.0));
}

const SMOKE: &str = "bench trade builtin:cornell --size 16x16 --integrators lvcbpt,spcbpt:rounds=1 \
                     --sweep lvcbpt:connections=1 --time 1500ms --at 3s --target 0.3 --equal-samples 16 --seeds 2 \
                     --reference-time 5s --reference-stride 2 --output out --markdown page.md";

/// The whole command on next to nothing: every file is there, every figure is there and finite, and nothing is done
/// twice, also after it was cut off while it wrote.
#[test]
fn bench_trade_has_every_figure_and_goes_on_where_it_was() {
    let case = Case::new();
    let run = case.run(SMOKE);
    run.assert(0, &["seed 2 of 2, spcbpt:rounds=1", "a reference by spcbpt"]);
    assert_eq!(run.printed, "page.md\n");
    let [file] = &std::fs::read_dir(case.path("target/references")).unwrap().collect::<Vec<_>>()[..] else {
        panic!("one reference")
    };
    let reference = Picture::read(&file.as_ref().unwrap().path()).expect("a picture");
    assert_eq!([reference.width, reference.height], [8, 8], "every other pixel of every other row");
    let read = |name: &str| std::fs::read_to_string(case.path(name)).expect(name);

    let trade: Value = serde_json::from_str(&read("out/trade.json")).expect("JSON");
    let mut figures = trade.clone();
    // Not known before two groups of samples, that is at the first checkpoint.
    for value in figures.pointer_mut("/scenes/0").into_iter().flat_map(candidates) {
        let summary = value["summary"]["curve"][0].as_object_mut().expect("a checkpoint");
        assert_eq!(summary.remove("estimated_over_measured"), Some(Value::Null));
        for run in value["runs"].as_array_mut().expect("runs") {
            let first = run[0].as_object_mut().expect("a checkpoint");
            assert_eq!(first.remove("estimated_error"), Some(Value::Null));
        }
    }
    // A value that is never the best has no place on the front.
    figures["scenes"][0]["sweeps"][0].as_object_mut().expect("a sweep").remove("front");
    assert_complete(&figures, "");
    let scene = &trade["scenes"][0];
    assert_eq!(scene["integrators"].as_array().map(Vec::len), Some(2));
    assert_eq!(scene["sweeps"][0]["values"].as_array().map(Vec::len), Some(2));
    let learnt = &scene["integrators"][1]["summary"]["learning_seconds"];
    assert!(learnt.as_f64().is_some_and(|seconds| seconds > 0.0), "{learnt}");

    let csv = read("out/trade.csv");
    let columns: BTreeSet<usize> = csv.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(columns, BTreeSet::from([16]), "{csv}");
    assert!(csv.lines().count() > 3 * 2 * 2, "{csv}");
    let page = read("page.md");
    for phrase in [
        "`-i spcbpt --rounds 1`",
        "## Time to 30 %",
        "## At 16 samples per pixel",
        "### cornell: connections of lvcbpt",
        "`-i lvcbpt --connections 1`",
        "halfway bench trade builtin:cornell",
        "spp of every 4th pixel",
        "compared at the pixels that the reference has",
    ] {
        assert!(page.contains(phrase), "'{phrase}' not in\n{page}");
    }
    // The last column of a sweep's table says `-` of a value that is never the best.
    let rows: Vec<&str> = page.lines().map(|line| line.strip_suffix(" - |").unwrap_or(line)).collect();
    for missing in ["NaN", "inf", "| - ", "not met"] {
        assert!(rows.iter().all(|line| !line.contains(missing)), "'{missing}' in\n{page}");
    }
    let links: Vec<&str> = page.split("](page").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert_eq!(links, [".svg", ".svg"], "the picture, and where sweeps refer to it");
    let svg = read("page.svg");
    assert!(svg.starts_with("<svg") && !svg.contains("NaN"), "{svg}");
    for text in
        ["seconds, learning included", "samples per pixel", "spcbpt:rounds=1", "connections of lvcbpt"]
    {
        assert!(svg.contains(text), "'{text}' not in\n{svg}");
    }
    assert_eq!(svg.matches(">cornell, 16x16<").count(), 3, "by time, by samples, and the sweep");

    // Nothing is left to do.
    let runs = read("out/runs.jsonl");
    assert_eq!(runs.lines().count(), 6);
    let again = case.run(SMOKE);
    again.assert(0, &["6 renders are there already, 0 to go"]);
    assert!(!again.said.contains("a reference by"), "{}", again.said);
    assert_eq!(read("out/runs.jsonl"), runs);

    // Cut off in the last line.
    let whole = runs.trim_end().rfind('\n').expect("lines") + 1;
    std::fs::write(case.path("out/runs.jsonl"), &runs[..whole + 100]).expect("the file");
    case.run(SMOKE).assert(0, &["out/runs.jsonl is cut off", "5 renders are there already, 1 to go"]);
    let mended = read("out/runs.jsonl");
    assert_eq!(mended[..whole], runs[..whole], "what was there stays");
    let key = |line: &str| {
        let mut record: Value = serde_json::from_str(line).expect("a record");
        record.as_object_mut().expect("a record").remove("checkpoints");
        record.to_string()
    };
    let keys = |text: &str| text.lines().map(key).collect::<Vec<_>>();
    assert_eq!(keys(&mended), keys(&runs), "the same renders, each once");
    assert_eq!(keys(&runs).into_iter().collect::<BTreeSet<_>>().len(), 6);
}

fn candidates(scene: &mut Value) -> Vec<&mut Value> {
    let scene = scene.as_object_mut().expect("a scene");
    let mut found = Vec::new();
    for (name, value) in scene.iter_mut() {
        match name.as_str() {
            "integrators" => found.extend(value.as_array_mut().expect("a list")),
            "sweeps" => found.extend(value[0]["values"].as_array_mut().expect("a list")),
            _ => {}
        }
    }
    found
}

#[test]
fn bench_trade_refuses_what_makes_no_sense() {
    let case = Case::new();
    for (arguments, phrase) in [
        ("--integrators path,photon", "'photon'"),
        ("--integrators path,path", "'path' twice"),
        ("--sweep connections", "--connections"),
        ("--sweep path:connections=1", "--connections"),
        ("--target 0", "--target"),
        ("--seeds 0", "--seeds"),
        ("--at soon", "--at"),
        ("--time 30s --longest 20s", "--longest"),
        ("--reference-error 0", "--reference-error"),
        ("--integrators spcbpt:learn=meanwhile", "learn=meanwhile"),
    ] {
        let run = case.run(&format!("bench trade builtin:cornell --size 8x8 {arguments}"));
        run.assert(2, &[phrase]);
        assert!(run.printed.is_empty() && case.files().is_empty(), "{arguments} left {:?}", case.files());
    }
    case.run("bench trade").assert(2, &["SCENE"]);
}

/// One render's own errors: by doubling samples to the last, which are those that `compare` finds in the file.
#[test]
fn render_traces_its_error() {
    let case = Case::new();
    let render = "render builtin:cornell --size 16x16";
    case.run(&format!("{render} --spp 512 --seed 1 -o ref.exr")).assert(0, &[]);
    let run = case.run(&format!("{render} --spp 100 -o a.exr --reference ref.exr --trace-error error.csv"));
    run.assert(0, &["against the reference: MAPE"]);
    let text = std::fs::read_to_string(case.path("error.csv")).expect("a file");
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("names").split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|value| value.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>())
        .collect();
    let column = |name: &str| -> Vec<f64> {
        let index = names.iter().position(|&other| other == name).expect(name);
        rows.iter().map(|row| row[index]).collect()
    };
    let (samples, seconds, mape) = (column("samples"), column("total_seconds"), column("mape"));
    assert!(samples.len() >= 3 && samples.last() == Some(&100.0), "{text}");
    let middle = &samples[..samples.len() - 1];
    assert!(middle.windows(2).all(|pair| pair[1] >= 2.0 * pair[0]), "{text}");
    assert!(seconds.windows(2).all(|pair| pair[1] > pair[0]), "{text}");
    assert!(mape[0] > *mape.last().expect("rows"), "{text}");
    let found = metric::errors(&case.picture("a.exr"), &case.picture("ref.exr")).expect("comparable");
    assert_close(*mape.last().expect("rows"), found.mape);

    let refuse = |arguments: &str, phrase: &str| {
        let run = case.run(&format!("{render} --spp 1 -o b.exr {arguments}"));
        run.assert(2, &[phrase]);
        assert!(!case.path("b.exr").exists(), "{arguments}");
    };
    refuse("--trace-error b.csv", "--reference");
    refuse("--reference missing.exr", "missing.exr");
    refuse("--reference ref.exr --crop 0,0,8,8", "16x16");
    refuse("--reference ref.exr --trace-error nowhere/b.csv", "nowhere/b.csv");
}

/// A denoised curve stands beside the raw one, with what is seen of both.
#[test]
fn bench_trade_denoises() {
    let case = Case::new();
    case.run(
        "bench trade builtin:cornell --size 16x16 --integrators path --denoise --spp 8 --seeds 1 --equal-samples 8 \
         --reference-time 2s --output out",
    )
    .assert(0, &["path:denoise"]);
    let read = |name: &str| std::fs::read_to_string(case.path(name)).expect(name);
    let trade: Value = serde_json::from_str(&read("out/trade.json")).expect("JSON");
    let [raw, denoised] = [0, 1].map(|place| {
        let end = &trade["scenes"][0]["integrators"][place]["runs"][0][0];
        assert!(end["flip"].as_f64().is_some_and(|flip| flip > 0.0 && flip < 1.0), "{end}");
        end["mape"].as_f64().expect("a number")
    });
    assert!(denoised < raw, "{denoised} {raw}");
    let page = read("out/trade.md");
    for phrase in ["`-i path --denoise`", "## What is seen", "| FLIP |"] {
        assert!(page.contains(phrase), "'{phrase}' not in\n{page}");
    }
    case.run("bench efficiency builtin:cornell --integrators path:denoise").assert(2, &["bench trade"]);
}

/// Ctrl-C ends it after the round and says how to go on.
#[test]
#[cfg(unix)]
fn r05_an_interrupted_bench_says_how_to_go_on() {
    let case = Case::new();
    let mut command = case.command(env!("CARGO_BIN_EXE_halfway"));
    let arguments = "bench trade builtin:cornell --size 8x8 --integrators path --time 10m --seeds 1 \
                     --reference-time 100ms --reference-integrator path --references refs";
    let child =
        command.args(arguments.split_whitespace()).stderr(Stdio::piped()).stdout(Stdio::null()).spawn();
    let child = child.expect("halfway runs");
    let start = Instant::now();
    while !case.path("refs").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no reference after a minute");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_secs(1));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let run = Run::of(child.wait_with_output().expect("an end"));
    run.assert(130, &["0 renders are kept", "the same command goes on from there"]);
}

/// References grow until they are exact enough, or had their time, and are checked by a second integrator.
#[test]
fn bench_reference_grows_and_checks() {
    let case = Case::new();
    let command = "bench reference builtin:cornell --size 8x8 --integrator path --references refs";
    let run = case.run(&format!("{command} --time 1s"));
    run.assert(0, &["a reference by path", "lvcbpt checks it"]);
    assert!(run.printed.contains("own MAPE") && run.printed.contains("lvcbpt with"), "{}", run.printed);
    let [file] = &std::fs::read_dir(case.path("refs")).unwrap().collect::<Vec<_>>()[..] else {
        panic!("one reference")
    };
    let file = file.as_ref().unwrap().path();
    let bytes = std::fs::read(&file).unwrap();
    let variance = |path| -> f64 {
        let picture = Picture::read(path).expect("a picture");
        picture.channel("variance", "G").expect("a variance").iter().map(|&value| f64::from(value)).sum()
    };
    let before = variance(&file);
    let Some(Attribute::Text(passes)) = Picture::read(&file).unwrap().attribute("passes").cloned() else {
        panic!("no passes")
    };
    let means: BTreeSet<&str> = passes.split(' ').filter_map(|pass| pass.split(':').nth(1)).collect();
    assert!(means.len() >= 3 && means.len() == passes.split(' ').count(), "not all differ: {passes}");

    let again = case.run(&format!("{command} --time 1s"));
    again.assert(0, &[]);
    assert_eq!(std::fs::read(&file).unwrap(), bytes);
    assert_eq!(again.printed, run.printed);

    case.run(&format!("{command} --time 4s")).assert(0, &["a reference by path", "lvcbpt checks it"]);
    let after = variance(&file);
    assert!(after < 0.6 * before, "{before} to {after} in four times the time");

    case.run(&format!("{command} --error 0.9")).assert(0, &[]);
    let other = format!("{command} --error 0.9 --check-integrator bdpt --check-time 1s");
    let run = case.run(&other);
    run.assert(0, &["bdpt checks it"]);
    assert!(run.printed.contains("bdpt with") && !run.printed.contains("lvcbpt with"), "{}", run.printed);
    let again = case.run(&other);
    assert!(again.printed == run.printed && !again.said.contains("checks it"), "{}", again.said);
    case.run(&format!("{command} --error 1e-6 --time 1s")).assert(3, &["--time ended before --error"]);
    case.run(&format!("{command} --error 0")).assert(2, &["--error"]);
}
