//! Labels of the points on lights: the top ids of the light subspaces. Lights are grouped by position, normal and power
//! until there are as few groups as ids; where ids are left over, large and strong lights are cut into cells.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::training::LightEnd;
use crate::device::scene::{LightSourceInfo, SourceKind};

/// The labels of one light: `divisions` x `divisions` cells of its two coordinates from `first` on. The shaders
/// read it as vec2u.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct SourceLabels {
    pub first: u32,
    pub divisions: u32,
}

impl SourceLabels {
    /// The label of a point; mirrors `source_cell` of `lib/tree.wgsl`.
    pub fn label(&self, at: [f32; 2]) -> u32 {
        let d = self.divisions;
        let cell = |x: f32| ((x * d as f32) as u32).min(d - 1);
        self.first + cell(at[0]) * d + cell(at[1])
    }
}

/// Most cells along a side of a light.
const MOST_DIVISIONS: u32 = 64;
/// A light of less than this priority, relative to the highest of any single light, is not cut.
const LEAST_PRIORITY: f64 = 1e-3;
/// Extent of the environment, where the unit scene has about 1: light from another side lights other surfaces.
const ENVIRONMENT_EXTENT: f64 = 4.0;

/// Labels for all lights, at most `budget` of them and at least one if there is a light, ending below `end`. Returns
/// them with the number of ids that they take.
pub fn label_sources(lights: &[LightSourceInfo], budget: u32, end: u32) -> (Vec<SourceLabels>, u32) {
    if lights.is_empty() {
        return (Vec::new(), 0);
    }
    let mut open: BinaryHeap<Group> = kinds(lights).into_iter().map(|of| Group::new(lights, of)).collect();
    if open.len() as u32 > budget {
        // One label for everything.
        let labels = SourceLabels { first: end.saturating_sub(1), divisions: 1 };
        return (vec![labels; lights.len()], 1);
    }
    let mut left = budget - open.len() as u32;
    let priorities = (0..lights.len() as u32).map(|i| Group::new(lights, vec![i]).priority);
    let least = LEAST_PRIORITY * priorities.fold(0.0, f64::max);
    let mut done = Vec::new();
    // The group of highest priority is cut next, as long as labels are left for it.
    while let Some(group) = open.pop() {
        match group.cut(lights, least) {
            Some((parts, labels)) if labels <= left => {
                left -= labels;
                open.extend(parts);
            }
            _ => done.push(group),
        }
    }
    done.sort_by_key(|group| group.lights.iter().min().copied());
    let used: u32 = done.iter().map(|group| group.divisions * group.divisions).sum();
    let mut labels = vec![SourceLabels::default(); lights.len()];
    let mut first = end - used;
    for group in done {
        for light in group.lights {
            labels[light as usize] = SourceLabels { first, divisions: group.divisions };
        }
        first += group.divisions * group.divisions;
    }
    (labels, used)
}

/// Which of the K light subspaces a point on a light can lie in: cells beyond a triangle's diagonal hold no point.
pub(super) fn mark_reachable(lights: &[LightSourceInfo], labels: &[SourceLabels], reachable: &mut [bool]) {
    for (light, of) in lights.iter().zip(labels) {
        let d = of.divisions;
        for cell in 0..d * d {
            if !matches!(light.kind, SourceKind::Triangle { .. }) || cell / d + cell % d < d {
                reachable[(of.first + cell) as usize] = true;
            }
        }
    }
}

pub(super) fn label_of(labels: &[SourceLabels], end: &LightEnd, tree: &super::Tree) -> u32 {
    match end {
        LightEnd::Surface(feature) => tree.label(feature),
        LightEnd::Source { light, at } => labels[*light as usize].label(*at),
    }
}

/// Indices of the triangles, the environments and the punctual lights, as far as there are any.
fn kinds(lights: &[LightSourceInfo]) -> Vec<Vec<u32>> {
    let mut kinds = vec![Vec::new(); 3];
    for (index, light) in lights.iter().enumerate() {
        let kind = match light.kind {
            SourceKind::Triangle { .. } => 0,
            SourceKind::Environment => 1,
            SourceKind::Punctual { .. } => 2,
        };
        kinds[kind].push(index as u32);
    }
    kinds.retain(|kind| !kind.is_empty());
    kinds
}

/// Lights that share labels.
struct Group {
    lights: Vec<u32>,
    divisions: u32,
    /// Power times how much its points differ: what is gained by cutting it.
    priority: f64,
    /// Coordinate of [`coordinates`] that varies most.
    widest: usize,
}

impl Group {
    fn new(lights: &[LightSourceInfo], of: Vec<u32>) -> Self {
        let power: f64 = of.iter().map(|&i| weight(&lights[i as usize])).sum();
        let (mut variances, mut mean) = ([0.0; 7], [0.0; 7]);
        for &i in &of {
            let (x, w) = (coordinates(&lights[i as usize]), weight(&lights[i as usize]) / power);
            (0..7).for_each(|k| mean[k] += w * x[k]);
        }
        for &i in &of {
            let (x, w) = (coordinates(&lights[i as usize]), weight(&lights[i as usize]) / power);
            (0..7).for_each(|k| variances[k] += w * (x[k] - mean[k]) * (x[k] - mean[k]));
        }
        let widest = (0..7).fold(0, |best, k| if variances[k] > variances[best] { k } else { best });
        let extent = if let [only] = of[..] {
            match lights[only as usize].kind {
                SourceKind::Triangle { area, .. } => f64::from(area.max(0.0)).sqrt(),
                SourceKind::Environment => ENVIRONMENT_EXTENT,
                SourceKind::Punctual { .. } => 0.0,
            }
        } else {
            variances.iter().sum::<f64>().sqrt()
        };
        Self { lights: of, divisions: 1, priority: power * extent, widest }
    }

    /// What takes the group's place when it is cut, and how many more labels that needs. A single light must have
    /// a priority above `least`.
    fn cut(&self, lights: &[LightSourceInfo], least: f64) -> Option<(Vec<Self>, u32)> {
        if let [_] = self.lights[..] {
            let d = self.divisions;
            if self.priority <= least || d == MOST_DIVISIONS {
                return None;
            }
            let finer = Self {
                lights: self.lights.clone(),
                divisions: d + 1,
                priority: self.priority * f64::from(d) / f64::from(d + 1),
                widest: self.widest,
            };
            return Some((vec![finer], 2 * d + 1));
        }
        // Halves of equal power along the widest coordinate; each keeps at least one light.
        let mut sorted = self.lights.clone();
        let along = |i: u32| coordinates(&lights[i as usize])[self.widest];
        sorted.sort_by(|&a, &b| along(a).total_cmp(&along(b)).then(a.cmp(&b)));
        let power: f64 = sorted.iter().map(|&i| weight(&lights[i as usize])).sum();
        let mut below = 0.0;
        let half = sorted.iter().position(|&i| {
            below += weight(&lights[i as usize]);
            below >= 0.5 * power
        });
        let at = (half.unwrap_or(0) + 1).clamp(1, sorted.len() - 1);
        let upper = sorted.split_off(at);
        Some((vec![Self::new(lights, sorted), Self::new(lights, upper)], 1))
    }
}

/// Lights without power keep a place.
fn weight(light: &LightSourceInfo) -> f64 {
    if light.power.is_finite() { light.power.max(f64::MIN_POSITIVE) } else { 1.0 }
}

/// Where lights differ: position, normal and, less, the logarithm of the power.
fn coordinates(light: &LightSourceInfo) -> [f64; 7] {
    let (position, normal) = match light.kind {
        SourceKind::Triangle { position, normal, .. } => (position, normal),
        SourceKind::Environment => (Vec3::ZERO, Vec3::ZERO),
        SourceKind::Punctual { position, direction, .. } => (position, direction),
    };
    let [x, y, z] = position.as_dvec3().to_array();
    let [nx, ny, nz] = (0.5 * normal.as_dvec3()).to_array();
    [x, y, z, nx, ny, nz, 0.05 * weight(light).log2()]
}

impl PartialEq for Group {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Group {}

impl PartialOrd for Group {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Group {
    /// By priority; equal ones by their first light, so that the order is the same everywhere.
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority.total_cmp(&other.priority).then(other.lights[0].cmp(&self.lights[0]))
    }
}
