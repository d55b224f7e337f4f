//! The page: the paper's two tables with ours beside them.

use super::results::{Paper, SceneResult};
use super::{EQUAL_SAMPLES, MORE_SAMPLES, TARGET};
use crate::bench::trade::Estimate;
use crate::cli::bench::format::{count, level, met, percent, seconds, share_spread, spread, table};
use crate::cli::bench::paper_figures::{self, AfterHundred, Figures, Reached};
use crate::cli::bench::runs::{CandidateResult, Drift};
use crate::cli::text::{grouped, short};

/// The page as Markdown; `stem`: of the names of the pictures beside it.
pub fn page(paper: &Paper, stem: &str) -> String {
    let parts = [
        opening(),
        to_target(paper),
        order(paper),
        at_hundred(paper),
        more(paper),
        insets(paper, stem),
        how(paper),
    ];
    parts.join("\n")
}

fn figures(scene: &SceneResult) -> Option<&'static Figures> {
    paper_figures::figures(&scene.name)
}

fn texts<const N: usize>(heads: [&str; N]) -> Vec<String> {
    heads.map(String::from).into()
}

/// A table with a row for each method of each scene.
fn by_method(
    paper: &Paper,
    heads: Vec<String>,
    row: impl Fn(&SceneResult, &str, [&CandidateResult; 2]) -> Vec<String>,
) -> String {
    let mut rows = Vec::new();
    for scene in &paper.scenes {
        for (index, (name, pair)) in scene.methods().enumerate() {
            let bold = if index == 0 { format!("**{}**", scene.name) } else { String::new() };
            let mut cells = vec![bold, name.to_owned()];
            cells.extend(row(scene, name, pair));
            rows.push(cells);
        }
    }
    table(&heads, 2, &rows)
}

fn opening() -> String {
    "# Beside the paper\n\n\
     The tables of Su, Li, Wang, SPCBPT: Subspace-based Probabilistic Connections for Bidirectional Path Tracing (SIGGRAPH \
     2022), measured here: `lvcbpt` (uniform choice), `risbpt` (by records, Nabata et al. 2020), `spcbpt` (by subspaces), and \
     `pcbpt` (by records, Popov et al. 2015), which the paper does not list. Each once as published (`--as-published`) and \
     once as it is by default. Errors are the paper's MAPE, |a - b| / (b + 0.01), at most 10 a pixel. Scenes have the name in \
     common with the paper's, not the model, nor the size of the picture, nor the device: what can be compared are ratios and \
     orders. This page is made by a command, which is at [its end](#how-it-was-made); what lies behind the differences is in \
     [measurements.md](measurements.md#beside-its-rivals).\n"
        .into()
}

fn to_target(paper: &Paper) -> String {
    let error = level(TARGET);
    let heads = texts([
        "scene",
        "method",
        "paper: seconds",
        "iterations",
        "as published: seconds",
        "of it learning",
        "iterations",
        "as it is: seconds",
        "of it learning",
        "samples",
    ]);
    let rows = by_method(paper, heads, |scene, name, pair| {
        let theirs = figures(scene).and_then(|figures| figures.reached(name));
        let mut row = match theirs {
            Some(Reached { seconds, iterations }) => {
                vec![short(seconds), grouped(f64::from(iterations))]
            }
            None => texts(["-", "-"]),
        };
        for one in pair {
            let sooner = |text: String| match one.summary.target.at_once {
                0 => text,
                _ => format!("< {text}"),
            };
            row.push(sooner(met(one)));
            row.push(short(one.summary.learning_seconds));
            row.push(sooner(count(&one.summary.target.samples)));
        }
        row
    });
    format!(
        "## To {error}\n\nFrom when on the error stays at or below {error}: median of the seeds and its 95 % interval. `~` is \
         continued beyond the end of the render by no more than a factor of four; `not met` is beyond that. `<`: some seeds \
         were there at their first checkpoint.\n\n{rows}"
    )
}

/// Iterations to the target, the fewest first, and whether each is surely fewer than the next.
fn in_order(mut methods: Vec<(&str, Estimate)>) -> String {
    methods.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let mut text = String::new();
    for (index, (name, estimate)) in methods.iter().enumerate() {
        if let Some((_, before)) = index.checked_sub(1).map(|before| methods[before]) {
            text += match before.interval.zip(estimate.interval) {
                _ if before.value.is_infinite() => ", ",
                Some(([_, high], [low, _])) if high < low => " < ",
                _ => " <~ ",
            };
        }
        let value = if estimate.value.is_finite() { count(estimate) } else { "not met".into() };
        text += &format!("{name} {value}");
    }
    text
}

fn order(paper: &Paper) -> String {
    let mut rows = Vec::new();
    for scene in &paper.scenes {
        let theirs: Vec<(&str, Estimate)> = scene
            .methods()
            .filter_map(|(name, _)| {
                let value = f64::from(figures(scene)?.reached(name)?.iterations);
                // The paper has no intervals: as if there were none to either side.
                Some((name, Estimate { value, interval: Some([value; 2]), extrapolated: false }))
            })
            .collect();
        let ours = |place: usize| {
            in_order(scene.methods().map(|(name, pair)| (name, pair[place].summary.target.samples)).collect())
        };
        let theirs = if theirs.is_empty() { "-".into() } else { in_order(theirs) };
        rows.push(vec![format!("**{}**", scene.name), theirs, ours(0), ours(1)]);
    }
    let heads = texts(["scene", "paper", "as published", "as it is"]);
    format!(
        "### The order\n\nBy iterations or samples to {}, the fewest first. `<`: the intervals of the seeds lie apart; `<~`: \
         they do not, or there is but one seed.\n\n{}",
        level(TARGET),
        table(&heads, 4, &rows)
    )
}

fn at_hundred(paper: &Paper) -> String {
    let heads = texts([
        "scene",
        "method",
        "paper: seconds",
        "MAPE",
        "as published: seconds",
        "MAPE",
        "as it is: seconds",
        "MAPE",
    ]);
    let rows = by_method(paper, heads, |scene, name, pair| {
        let theirs = figures(scene).and_then(|figures| figures.after_hundred(name));
        let mut row = match theirs {
            Some(AfterHundred { seconds, mape }) => vec![short(seconds), percent(mape)],
            None => texts(["-", "-"]),
        };
        for one in pair {
            let known = |estimate: &Option<Estimate>, show: fn(&Estimate) -> String| {
                estimate.as_ref().map_or("-".into(), show)
            };
            row.push(known(&one.summary.equal_seconds, spread));
            row.push(known(&one.summary.equal_mape, share_spread));
        }
        row
    });
    format!(
        "## At {EQUAL_SAMPLES} iterations\n\nSeconds with pre-processing, as the paper counts them: of its times to 12 % less \
         pre-processing a hundredth is an iteration to within 3 %.\n\n{rows}"
    )
}

fn more(paper: &Paper) -> String {
    let mut rows = Vec::new();
    for scene in &paper.scenes {
        for (index, more) in scene.more.iter().enumerate() {
            let bold = if index == 0 { format!("**{}**", scene.name) } else { String::new() };
            let mut row = vec![bold, more.method.to_owned(), more.with.clone()];
            row.extend(match more.fits {
                false => texts(["does not fit", "-"]),
                true => vec![
                    more.seconds().map_or("-".into(), |estimate| spread(&estimate)),
                    more.mape().map_or("-".into(), |estimate| share_spread(&estimate)),
                ],
            });
            rows.push(row);
        }
    }
    let heads = texts(["scene", "method", "with", "seconds", "MAPE"]);
    format!(
        "## {MORE_SAMPLES} iterations, more candidates\n\nMethods by records with more light paths to choose from, as the paper \
         tried them, or with more records, in all else as they are by default.\n\n{}",
        table(&heads, 3, &rows)
    )
}

fn insets(paper: &Paper, stem: &str) -> String {
    let whole = paper.scenes.iter().filter(|scene| scene.reference.stride == 1);
    let pictures: Vec<String> = whole
        .map(|scene| format!("![{0}: parts of it by each method]({stem}-{0}.png)\n", scene.name))
        .collect();
    if pictures.is_empty() {
        return String::new();
    }
    format!(
        "## After the same time\n\nAfter {} beside learning, one seed: the two parts of the picture in which the methods' \
         errors are largest. Above as published, below as it is; the captions have the samples and the error of the whole \
         picture.\n\n{}",
        seconds(paper.inset_seconds),
        pictures.join("\n")
    )
}

fn how(paper: &Paper) -> String {
    let longest = paper.longest.map_or(String::new(), |longest| {
        format!(", up to {} on the way to {}", seconds(longest), level(TARGET))
    });
    let drift = paper.drift.map_or(String::new(), |Drift { best, worst, .. }| {
        format!(
            "\nTimes are scaled to the usual speed of the machine, which others share: single renders went at {} to {} times \
             the usual time.\n",
            short(best),
            short(worst)
        )
    });
    let heads = texts(["scene", "size", "reference", "its own MAPE"]);
    let row = |scene: &SceneResult| {
        let [width, height] = scene.size;
        let noise = scene.reference.noise.map_or("unknown".into(), |noise| percent(noise.mape));
        vec![scene.name.clone(), format!("{width}x{height}"), scene.reference.origin.clone(), noise]
    };
    let rows: Vec<Vec<String>> = paper.scenes.iter().map(row).collect();
    format!(
        "## How it was made\n\n{}, {}, Halfway {}. {} of each, {} a render beside learning{longest}.\n\n```\n{}\n```\n{drift}\n{}",
        paper.date,
        paper.device,
        paper.version,
        if paper.seeds == 1 { "One seed".into() } else { format!("{} seeds", paper.seeds) },
        seconds(paper.seconds),
        paper.command,
        table(&heads, 1, &rows)
    )
}
