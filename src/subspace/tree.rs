//! The classification tree: stands in for the search of the nearest centroid, three comparisons per level.
//!
//! Eight-ary. Even depths split by position, odd ones by normal; after four splits by normal always by position. Where
//! the incident direction counts, depths 7 and 9 split by it. Boxes are halved, as in an octree.

use glam::Vec3;

use super::training::Feature;
use crate::device::layout::{
    TREE_CHILD, TREE_DIRECTION, TREE_KIND, TREE_LEAF, TREE_NORMAL, TREE_POSITION, TreeNode,
};

/// No tree is deeper.
pub const MAX_DEPTH: u32 = 24;

/// A frozen map from features to labels; root first, eight children in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    nodes: Vec<TreeNode>,
}

/// When to stop growing.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    pub depth: u32,
    /// Share of the weight that has to be labelled rightly.
    pub stop: f64,
    /// Directions count.
    pub direction: bool,
}

/// Most splits by normal on a way down.
const NORMAL_SPLITS: u32 = 4;

/// What a split at this depth compares.
fn kind_at(depth: u32, direction: bool) -> u32 {
    let by_direction = |d: u32| direction && (d == 7 || d == 9);
    if by_direction(depth) {
        TREE_DIRECTION
    } else if depth % 2 == 1
        && (0..depth).filter(|&d| d % 2 == 1 && !by_direction(d)).count() < NORMAL_SPLITS as usize
    {
        TREE_NORMAL
    } else {
        TREE_POSITION
    }
}

fn vector_of(feature: &Feature, kind: u32) -> Vec3 {
    match kind {
        TREE_POSITION => feature.position,
        TREE_NORMAL => feature.normal,
        _ => feature.direction,
    }
}

/// Which of eight children; NaN counts as below.
fn octant(at: Vec3, split: [f32; 3]) -> u32 {
    u32::from(at.x >= split[0]) + 2 * u32::from(at.y >= split[1]) + 4 * u32::from(at.z >= split[2])
}

/// A box as centre and half the lengths of its sides.
#[derive(Clone, Copy)]
struct Bounds {
    centre: Vec3,
    half: Vec3,
}

impl Bounds {
    const DIRECTIONS: Self = Self { centre: Vec3::ZERO, half: Vec3::ONE };

    fn of(samples: &[(Feature, f64)]) -> Self {
        let empty = (Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY));
        let (low, high) = samples.iter().fold(empty, |(l, h), (f, _)| (l.min(f.position), h.max(f.position)));
        Self { centre: 0.5 * low + 0.5 * high, half: 0.5 * high - 0.5 * low }
    }

    fn octant(&self, octant: u32) -> Self {
        let half = 0.5 * self.half;
        let sign = |bit: u32| if octant & bit == 0 { -1.0 } else { 1.0 };
        Self { centre: self.centre + half * Vec3::new(sign(1), sign(2), sign(4)), half }
    }
}

/// A leaf that may still be split.
struct Open {
    node: usize,
    depth: u32,
    /// By position, normal, direction.
    bounds: [Bounds; 3],
    /// Its samples, a part of the order.
    samples: std::ops::Range<usize>,
    /// Weight of the samples whose label it has.
    right: f64,
}

impl Tree {
    /// A tree that knows one label only.
    pub fn single(label: u32) -> Self {
        Self { nodes: vec![leaf(label)] }
    }

    /// Grows a tree breadth first over samples with weights and the labels they should get.
    pub fn grow(samples: &[(Feature, f64)], labels: &[u32], growth: Growth) -> Self {
        if samples.is_empty() {
            return Self::single(0);
        }
        let label_count = labels.iter().max().map_or(0, |most| *most as usize + 1);
        let mut votes = Votes::new(label_count);
        let mut order: Vec<u32> = (0..samples.len() as u32).collect();
        let total: f64 = samples.iter().map(|(_, weight)| weight).sum();
        let root = votes.count(&order, samples, labels).unwrap_or_default();
        let mut nodes = vec![leaf(root.label)];
        let mut right = root.weight;
        let bounds = [Bounds::of(samples), Bounds::DIRECTIONS, Bounds::DIRECTIONS];
        let all = 0..samples.len();
        let mut open = std::collections::VecDeque::new();
        if root.mixed {
            open.push_back(Open { node: 0, depth: 0, bounds, samples: all, right: root.weight });
        }
        let mut sorted = Vec::new();
        while let Some(split) = open.pop_front() {
            // Breadth first: all that follow are as deep.
            if right >= growth.stop * total || split.depth >= growth.depth {
                break;
            }
            let kind = kind_at(split.depth, growth.direction);
            let which = match kind {
                TREE_POSITION => 0,
                TREE_NORMAL => 1,
                _ => 2,
            };
            let at = split.bounds[which].centre.to_array();
            let own = &mut order[split.samples.clone()];
            let octants =
                sort_by_octant(own, &mut sorted, |i| octant(vector_of(&samples[i as usize].0, kind), at));
            let base = nodes.len() as u32;
            let inherited = nodes[split.node].child_kind;
            nodes[split.node] = TreeNode { split: at, child_kind: kind | base };
            right -= split.right;
            for (child, range) in octants.into_iter().enumerate() {
                let range = split.samples.start + range.start..split.samples.start + range.end;
                let Some(vote) = votes.count(&order[range.clone()], samples, labels) else {
                    nodes.push(leaf(inherited));
                    continue;
                };
                nodes.push(leaf(vote.label));
                right += vote.weight;
                if vote.mixed {
                    let mut bounds = split.bounds;
                    bounds[which] = bounds[which].octant(child as u32);
                    let (node, depth) = (nodes.len() - 1, split.depth + 1);
                    open.push_back(Open { node, depth, bounds, samples: range, right: vote.weight });
                }
            }
        }
        Self { nodes }
    }

    /// As it is uploaded.
    pub fn nodes(&self) -> &[TreeNode] {
        &self.nodes
    }

    /// The label of a feature; mirrors `tree_label` of `lib/tree.wgsl`, comparison by comparison.
    pub fn label(&self, feature: &Feature) -> u32 {
        let mut node = &self.nodes[0];
        while node.child_kind & TREE_KIND != TREE_LEAF {
            let at = vector_of(feature, node.child_kind & TREE_KIND);
            node = &self.nodes[((node.child_kind & TREE_CHILD) + octant(at, node.split)) as usize];
        }
        node.child_kind & TREE_CHILD
    }

    /// Labels that a leaf has.
    pub fn labels(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().filter(|node| node.child_kind & TREE_KIND == TREE_LEAF).map(|node| node.child_kind)
    }

    /// A tree of nodes from elsewhere, if every walk through it ends, no deeper than `depth`, at a label below
    /// `labels`.
    pub fn from_nodes(nodes: Vec<TreeNode>, depth: u32, labels: u32) -> Option<Self> {
        let mut depths = vec![u32::MAX; nodes.len()];
        *depths.first_mut()? = 0;
        for (index, node) in nodes.iter().enumerate() {
            let child = node.child_kind & TREE_CHILD;
            if node.child_kind & TREE_KIND == TREE_LEAF {
                if child >= labels {
                    return None;
                }
                continue;
            }
            // Children stand behind their parents, so there are no cycles.
            let children = child as usize..child as usize + 8;
            if children.start <= index || children.end > nodes.len() || depths[index] >= depth {
                return None;
            }
            let below = depths[index] + 1;
            depths[children].fill(below);
        }
        Some(Self { nodes })
    }
}

fn leaf(label: u32) -> TreeNode {
    TreeNode { split: [0.0; 3], child_kind: TREE_LEAF | label }
}

/// Brings equal octants together, keeping the order within each; returns where each lies.
fn sort_by_octant(
    own: &mut [u32],
    sorted: &mut Vec<(u32, u32)>,
    octant_of: impl Fn(u32) -> u32,
) -> [std::ops::Range<usize>; 8] {
    sorted.clear();
    sorted.extend(own.iter().map(|&i| (octant_of(i), i)));
    let mut ends = [0usize; 8];
    sorted.iter().for_each(|(octant, _)| ends[*octant as usize] += 1);
    for octant in 1..8 {
        ends[octant] += ends[octant - 1];
    }
    let ranges = std::array::from_fn(|octant| if octant == 0 { 0 } else { ends[octant - 1] }..ends[octant]);
    let mut next: [usize; 8] = std::array::from_fn(|octant| if octant == 0 { 0 } else { ends[octant - 1] });
    for (octant, i) in sorted.iter() {
        own[next[*octant as usize]] = *i;
        next[*octant as usize] += 1;
    }
    ranges
}

/// The label with the largest weight among some samples.
#[derive(Clone, Copy, Default)]
struct Vote {
    label: u32,
    weight: f64,
    /// There are several labels.
    mixed: bool,
}

/// Weights by label, cleared after each count.
struct Votes {
    weights: Vec<f64>,
    seen: Vec<u32>,
    is_seen: Vec<bool>,
}

impl Votes {
    fn new(labels: usize) -> Self {
        Self { weights: vec![0.0; labels], seen: Vec::new(), is_seen: vec![false; labels] }
    }

    /// `None` without samples.
    fn count(&mut self, of: &[u32], samples: &[(Feature, f64)], labels: &[u32]) -> Option<Vote> {
        for &i in of {
            let label = labels[i as usize];
            if !std::mem::replace(&mut self.is_seen[label as usize], true) {
                self.seen.push(label);
            }
            self.weights[label as usize] += samples[i as usize].1;
        }
        let mut best = Vote { label: *self.seen.first()?, weight: -1.0, mixed: self.seen.len() > 1 };
        for label in self.seen.drain(..) {
            let weight = std::mem::take(&mut self.weights[label as usize]);
            self.is_seen[label as usize] = false;
            if weight > best.weight || (weight == best.weight && label < best.label) {
                best = Vote { label, weight, ..best };
            }
        }
        Some(best)
    }
}
