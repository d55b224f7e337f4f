//! From training paths to a model.

use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::centroid::{Centroids, largest_variance, systematic};
use super::gamma::{Neighbours, Problem, ProblemBuilder, Term, optimise};
use super::guide::{GuideInput, LightGuide};
use super::model::{CentroidMove, Counts, Model, Seconds, TrainingReport};
use super::normaliser::Normaliser;
use super::prepare::{PathWeight, check_lights, weigh};
use super::settings::Settings;
use super::sources::{label_of, label_sources, mark_reachable};
use super::training::{Feature, LightEnd, TrainingInput, TrainingNode, TrainingSet};
use super::tree::{Growth, Tree};
use crate::subspace::SubspaceError;

/// Subspaces that points on lights may have in any case, up to half of all: kinds of light that share one are chosen by
/// power, which is a poor guide to the light that arrives from them.
const LEAST_SOURCE_SUBSPACES: u32 = 16;
/// Mean logarithm of how much denser guided light paths are where they are wanted, below which they are not guided: at .3 it
/// gained nothing, at 1.2 half (docs/measurements.md, Connections and shares by depth).
const LEAST_GUIDE_GAIN: f64 = 0.4;
/// Where there are twice as many paths, so many say first whether a guide may be worth it: one that has half of the least gain
/// by them is learnt from all. Most scenes want none, and learning one took a third of what the host does in a round.
const GAUGED_PATHS: usize = 1 << 16;
/// Subspaces that learn from each other, itself counted. Eight gain no more where paths are few, and less where they are
/// many.
const NEIGHBOURS: usize = 4;

/// Learns the classification, Gamma and Q. The result depends on nothing but the arguments: not on the number of
/// threads, and not on the units of light. An empty training set gives one subspace per side, where power alone counts.
///
/// # Errors
/// Settings out of range, names of lights and tiles that do not exist, light samples that carry no light.
pub fn train(input: &TrainingInput, settings: Settings) -> Result<Model, SubspaceError> {
    let &TrainingInput { set, light_samples, light_paths, lights, scene_hash, connections, seed } = input;
    settings.check()?;
    check_lights(light_samples.par_iter().map(|sample| &sample.end), lights.len())?;
    let start = Instant::now();
    let mut clock = Clock { last: start };
    let mut seconds = Seconds::default();
    let weighed = weigh(set, lights.len(), &settings, seed)?;
    let taught: Vec<(u32, f64)> = taught_nodes(set, &weighed.paths);
    seconds.weights = clock.lap();

    let subspaces = settings.subspaces_for(taught.len());
    let budget = (settings.source_share * f64::from(subspaces)).round() as u32;
    // One subspace holds everything; a few separate lamp, sky and sun.
    let budget = budget.max(LEAST_SOURCE_SUBSPACES.min(subspaces / 2)).clamp(1, (subspaces - 1).max(1));
    let (sources, source_count) = label_sources(lights, budget, subspaces);
    let surfaces = (subspaces - source_count).max(1);
    let eye = |node: &TrainingNode| Some(node.eye);
    let light = |node: &TrainingNode| match node.light {
        LightEnd::Surface(feature) => Some(feature),
        LightEnd::Source { .. } => None,
    };
    let ((eye_centroids, eye_tree, eye_moves), (light_centroids, light_tree, light_moves)) = rayon::join(
        || classify(input, &taught, eye, subspaces, &settings),
        || classify(input, &taught, light, surfaces, &settings),
    );
    seconds.trees = clock.lap();

    let labels: Vec<(u32, u32)> = set
        .nodes()
        .par_iter()
        .map(|node| (eye_tree.label(&node.eye), label_of(&sources, &node.light, &light_tree)))
        .collect();
    seconds.labels = clock.lap();

    let normaliser = Normaliser::estimate(light_samples, light_paths, &sources, &light_tree, subspaces);
    let mut active = vec![false; subspaces as usize];
    light_tree.labels().for_each(|label| active[label as usize] = true);
    mark_reachable(lights, &sources, &mut active);
    labels.iter().for_each(|(_, column)| active[*column as usize] = true);
    for (active, q) in active.iter_mut().zip(&normaliser.estimate) {
        *active |= *q > 0.0;
    }
    let q = normaliser.floored(&active);
    let total: f64 = q.iter().zip(&active).filter(|(_, active)| **active).map(|(q, _)| q).sum();
    // Also none: NaN where there were no light paths.
    if !(total > 0.0 && total.is_finite()) {
        return Err(SubspaceError::NoLight { samples: light_samples.len(), paths: light_paths });
    }
    seconds.q = clock.lap();

    let power: Vec<f64> =
        q.iter().zip(&active).map(|(q, active)| if *active { q / total } else { 0.0 }).collect();
    let terms = Terms { set, weights: &weighed.paths, labels: &labels, q: &q };
    let (mut problem, unreachable) = terms.problem(subspaces, &active, &power, &settings);
    let neighbours = neighbours(&eye_centroids, &light_centroids, &active);
    problem.smooth_over(&neighbours, &power, settings.smoothing);
    let optimised = optimise(&problem, settings.optimiser, settings.max_steps);
    let gamma = problem.expand(&optimised.q);
    seconds.gamma = clock.lap();
    let input = GuideInput {
        set,
        weights: &weighed.paths,
        labels: &labels,
        gamma: &gamma,
        q: &q,
        lights,
        sources: &sources,
        subspaces,
    };
    let (guide, guide_gain) = if settings.light_guide { learn_guide(&input) } else { (None, None) };
    seconds.guide = clock.lap();
    seconds.total = start.elapsed().as_secs_f64();

    let counts = Counts {
        paths: set.paths().len() as u64,
        nodes: set.nodes().len() as u64,
        held_out_paths: problem.held_out_paths() as u64,
        faulty_paths: weighed.faulty,
        faulty_light_samples: normaliser.faulty,
        unreachable_paths: unreachable,
        clamped_paths: weighed.clamped,
        light_samples: light_samples.len() as u64,
        learnt_rows: count(problem.learnt()),
        active_columns: count(&active),
        floored_columns: active
            .iter()
            .zip(q.iter().zip(&normaliser.estimate))
            .filter(|(active, (floored, estimate))| **active && floored > estimate)
            .count() as u64,
        source_subspaces: u64::from(source_count),
        eye_tree_nodes: eye_tree.nodes().len() as u64,
        light_tree_nodes: light_tree.nodes().len() as u64,
    };
    let report = TrainingReport {
        counts,
        row_entropy: row_entropy(&gamma, problem.learnt()),
        q_spread: spread(&normaliser.estimate),
        losses: optimised.losses,
        best_step: optimised.best_step,
        tried: optimised.tried,
        guide_gain: guide_gain.unwrap_or_default(),
        seconds,
    };
    let q = q.iter().map(|&q| (q as f32).max(f32::MIN_POSITIVE)).collect();
    Ok(Model {
        scene_hash,
        connections,
        seed,
        settings,
        subspaces,
        eye_tree,
        light_tree,
        centroids: [eye_moves, light_moves],
        sources,
        gamma,
        q,
        guide,
        first_connections: None,
        report,
    })
}

/// The guide of light paths where it is worth it, and what it gains.
fn learn_guide(input: &GuideInput) -> (Option<LightGuide>, Option<f64>) {
    let step = input.weights.len() / GAUGED_PATHS;
    if step >= 2
        && let (_, Some(gain)) = input.learn(step)
        && gain < 0.5 * LEAST_GUIDE_GAIN
    {
        return (None, Some(gain));
    }
    let (guide, gain) = input.learn(1);
    (gain.is_none_or(|gain| gain >= LEAST_GUIDE_GAIN).then_some(guide), gain)
}

/// Measures one part after the other.
struct Clock {
    last: Instant,
}

impl Clock {
    fn lap(&mut self) -> f64 {
        let now = Instant::now();
        (now - std::mem::replace(&mut self.last, now)).as_secs_f64()
    }
}

fn count(flags: &[bool]) -> u64 {
    flags.iter().filter(|flag| **flag).count() as u64
}

/// Nodes that teach, with the weight of their path: those of paths that are not held out, between ends that can be
/// connected.
fn taught_nodes(set: &TrainingSet, weights: &[PathWeight]) -> Vec<(u32, f64)> {
    let paths = weights.iter().enumerate().filter(|(_, path)| path.weight > 0.0 && !path.held_out);
    paths
        .flat_map(|(index, path)| set.nodes_of(index).map(move |node| (node as u32, path.weight)))
        .filter(|(node, _)| set.nodes()[*node as usize].mass > 0.0)
        .collect()
}

/// Draws the centroids of one side, moves them and grows its tree; labels are indices of centroids.
fn classify(
    &TrainingInput { set, seed, .. }: &TrainingInput,
    taught: &[(u32, f64)],
    feature_of: impl Fn(&TrainingNode) -> Option<Feature> + Sync,
    count: u32,
    settings: &Settings,
) -> (Centroids, Tree, Vec<CentroidMove>) {
    let feature = |node: u32| feature_of(&set.nodes()[node as usize]);
    let side: Vec<(u32, f64)> = taught.iter().copied().filter(|(node, _)| feature(*node).is_some()).collect();
    let drawn = systematic(side.iter().map(|(_, weight)| *weight), count, seed);
    let drawn: Vec<Feature> = drawn.iter().filter_map(|&at| feature(side[at as usize].0)).collect();
    let variance = largest_variance(side.iter().filter_map(|(node, _)| feature(*node)).map(|f| f.position));
    let most = settings.tree_samples.max(1) as usize;
    let samples: Vec<(Feature, f64)> = (0..side.len().min(most))
        // Evenly spread where there are more than enough.
        .map(|i| side[if side.len() > most { i * side.len() / most } else { i }])
        .filter_map(|(node, weight)| Some((feature(node)?, weight)))
        .collect();
    let features: Vec<Feature> = samples.iter().map(|(feature, _)| *feature).collect();
    let before: Vec<Vec3> = drawn.iter().map(|feature| feature.position).collect();
    let centroids =
        Centroids::new(drawn, variance, settings.direction_weight).relaxed(&features, settings.lloyd_steps);
    let labels: Vec<u32> = features.par_iter().map(|feature| centroids.nearest(feature)).collect();
    let growth = Growth {
        depth: settings.tree_depth,
        stop: settings.tree_stop,
        direction: settings.direction_weight > 0.0,
    };
    let tree = Tree::grow(&samples, &labels, growth);
    let moves = before.iter().zip(centroids.features());
    let moves = moves.map(|(&drawn, feature)| CentroidMove { drawn, moved: feature.position }).collect();
    (centroids, tree, moves)
}

/// Which of the subspaces are alike. Points on lights have no centroid: the light from one of them is a poor guide
/// to that of another, so they are smoothed over the rows alone.
fn neighbours(eye: &Centroids, light: &Centroids, active: &[bool]) -> Neighbours {
    let alone = |from: usize| (from..active.len()).map(|index| vec![index as u32]);
    let mut rows = eye.neighbours(NEIGHBOURS);
    rows.extend(alone(rows.len()));
    let mut columns = light.neighbours(NEIGHBOURS);
    columns.iter_mut().for_each(|near| near.retain(|&near| active[near as usize]));
    columns.extend(alone(columns.len()));
    Neighbours { rows, columns }
}

/// What the loss is made of.
struct Terms<'a> {
    set: &'a TrainingSet,
    weights: &'a [PathWeight],
    labels: &'a [(u32, u32)],
    q: &'a [f64],
}

impl Terms<'_> {
    /// The problem, and how many paths no strategy makes.
    fn problem(&self, subspaces: u32, active: &[bool], power: &[f64], settings: &Settings) -> (Problem, u64) {
        let mut builder = ProblemBuilder::new(subspaces);
        for (index, path) in self.weights.iter().enumerate().filter(|(_, path)| path.weight > 0.0) {
            let term = Term {
                squared: path.squared,
                start: path.weight,
                p0: f64::from(self.set.paths()[index].p0),
                held_out: path.held_out,
            };
            let node = |at: usize| {
                let (row, column) = self.labels[at];
                // Where it is not finite the whole path counts as unreachable.
                let mass = f64::from(self.set.nodes()[at].mass);
                (row, column, mass / self.q[column as usize])
            };
            builder.push(term, self.set.nodes_of(index).map(node));
        }
        let unreachable = builder.unreachable() as u64;
        (builder.finish(settings.uniform_share, settings.power_share, active, power), unreachable)
    }
}

/// Least, mean and most bits of the learnt rows; zeros if there are none.
fn row_entropy(gamma: &[f32], learnt: &[bool]) -> [f64; 3] {
    let bits = |row: &[f32]| -> f64 {
        row.iter().filter(|p| **p > 0.0).map(|&p| -f64::from(p) * f64::from(p).log2()).sum()
    };
    let rows: Vec<f64> = gamma
        .par_chunks(learnt.len())
        .zip(learnt)
        .filter(|(_, learnt)| **learnt)
        .map(|(row, _)| bits(row))
        .collect();
    if rows.is_empty() {
        return [0.0; 3];
    }
    let (least, most) =
        rows.iter().fold((f64::INFINITY, 0.0f64), |(least, most), &b| (least.min(b), most.max(b)));
    [least, rows.iter().sum::<f64>() / rows.len() as f64, most]
}

fn spread(q: &[f64]) -> f64 {
    let positive = q.iter().copied().filter(|q| *q > 0.0);
    let (least, most) = positive.fold((f64::INFINITY, 0.0f64), |(a, b), q| (a.min(q), b.max(q)));
    if most > 0.0 { most / least } else { 0.0 }
}
