//! What is learnt from: full paths with their connections, and light vertices. Plain data; positions are in
//! unit space.

use std::ops::Range;

use glam::Vec3;

use super::connections::Connections;
use crate::device::scene::LightSourceInfo;

/// Side of a picture's tiles in pixels; contributions are relative to the brightness of their tile.
pub const TILE_SIZE: u32 = 10;

/// Last vertex of a sub-path: what is classified.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feature {
    pub position: Vec3,
    /// Unit, facing the incoming ray.
    pub normal: Vec3,
    /// Unit, to the previous vertex.
    pub direction: Vec3,
}

impl Feature {
    pub(super) fn is_finite(&self) -> bool {
        self.position.is_finite() && self.normal.is_finite() && self.direction.is_finite()
    }
}

/// Last vertex of a light sub-path. Never a label: labels change with the number of subspaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightEnd {
    Surface(Feature),
    /// A point on the light itself. `at`: barycentrics (b1, b2) of a triangle, coordinates in the equal-area square of
    /// an environment, [0, 0] of a punctual light.
    Source {
        /// Index in the device's list of lights.
        light: u32,
        at: [f32; 2],
    },
}

impl LightEnd {
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Surface(feature) => feature.is_finite(),
            Self::Source { at, .. } => at[0].is_finite() && at[1].is_finite(),
        }
    }
}

/// A connection that could have made a path: one interior edge (x_j, x_{j+1}).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingNode {
    /// At x_j.
    pub eye: Feature,
    /// At x_{j+1}.
    pub light: LightEnd,
    /// Unit, from x_j to x_{j+1}.
    pub towards: Vec3,
    /// S PE(j) |f_y(x_n..x_{j+1})| / p: density of connecting at this edge, times what weights have it times
    /// ([`Connections::scale_at`]), over the density p of the path; before Gamma and 1/Q. Zero where an end is a delta vertex.
    pub mass: f32,
}

/// A full path of at least two edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingPath {
    /// [`TrainingSet::tile_of`] of the pixel.
    pub tile: u32,
    /// What it counts in the picture: |f| times its share, over p. p: density of the path by all ways to find it together,
    /// each times its share.
    pub contribution: f32,
    /// Of the way that found it; positive. So it was found with the density p over this.
    pub share: f32,
    /// What of the mixture's density does not depend on Gamma, over p: H PE(n) / p.
    pub p0: f32,
    /// How many of its nodes, from the eye on, are edges that the eye's side made; the light sub-path that made the others.
    /// Paths with the same one tell the same of them.
    pub eye_edges: u32,
    pub light_path: u64,
}

/// Paths with their nodes, from the eye to the light, in rows of variable length.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingSet {
    paths: Vec<TrainingPath>,
    nodes: Vec<TrainingNode>,
    /// Where each path's nodes begin, and the end of the last.
    offsets: Vec<u32>,
    /// Paths of a group are held out together, or not.
    groups: Vec<u32>,
    /// Pixels of each tile.
    tile_pixels: Vec<u32>,
    /// Tiles along a row of the picture.
    tile_columns: u32,
}

impl TrainingSet {
    /// An empty set for a picture of this size, whose paths begin evenly all over it.
    pub fn new(width: u32, height: u32) -> Self {
        let columns = width.div_ceil(TILE_SIZE).max(1);
        let rows = height.div_ceil(TILE_SIZE).max(1);
        let side = |tile: u32, size: u32| size.saturating_sub(tile * TILE_SIZE).clamp(1, TILE_SIZE);
        let tile_pixels =
            (0..rows).flat_map(|y| (0..columns).map(move |x| side(x, width) * side(y, height))).collect();
        Self {
            paths: Vec::new(),
            nodes: Vec::new(),
            offsets: vec![0],
            groups: Vec::new(),
            tile_pixels,
            tile_columns: columns,
        }
    }

    /// The tile of a pixel of the picture.
    pub fn tile_of(&self, x: u32, y: u32) -> u32 {
        y / TILE_SIZE * self.tile_columns + x / TILE_SIZE
    }

    /// Adds a path. Paths that have much in common share a `group`: one that teaches must not judge another.
    pub fn push_path(&mut self, group: u32, path: TrainingPath, nodes: &[TrainingNode]) {
        self.groups.push(group);
        self.paths.push(path);
        self.nodes.extend_from_slice(nodes);
        self.offsets.push(self.nodes.len() as u32);
    }

    pub fn paths(&self) -> &[TrainingPath] {
        &self.paths
    }

    pub fn nodes(&self) -> &[TrainingNode] {
        &self.nodes
    }

    pub(super) fn group_of(&self, path: usize) -> u32 {
        self.groups[path]
    }

    /// Which of all nodes are those of a path.
    pub fn nodes_of(&self, path: usize) -> Range<usize> {
        self.offsets[path] as usize..self.offsets[path + 1] as usize
    }

    pub(super) fn tile_pixels(&self) -> &[u32] {
        &self.tile_pixels
    }
}

/// A light vertex of the pass that estimates Q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    pub end: LightEnd,
    /// |w|: sum of the channels of throughput over density.
    pub weight: f32,
}

/// What there is to learn from, and what for.
#[derive(Clone, Copy)]
pub struct TrainingInput<'a> {
    pub set: &'a TrainingSet,
    /// Vertices of `light_paths` light paths, for Q.
    pub light_samples: &'a [LightSample],
    pub light_paths: u64,
    /// As the device lists them.
    pub lights: &'a [LightSourceInfo],
    pub scene_hash: u64,
    /// Of the render to come.
    pub connections: Connections,
    pub seed: u64,
}
