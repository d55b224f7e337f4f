//! How often eye vertices are connected, and how far weights trust that.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

/// Connections that an eye vertex may have.
pub const MAX_CONNECTIONS: u32 = 64;
/// Connections in flight at once, each with a slot of its own; more take several rounds.
const MOST_IN_FLIGHT: u32 = 4;

/// Connections of eye vertices to light vertices, and how far weights trust what they find; by the number of the eye
/// vertex: 1, 2, 3 and beyond. Whatever these are, pictures are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Connections {
    /// N of each such vertex, 1 to [`MAX_CONNECTIONS`].
    pub counts: [u32; 3],
    /// Factors on the densities of what these find, in weights only; the last is that of light which is hit. Positive.
    pub shares: [f32; 4],
    /// Vertices of narrow lobes make a part of them only: `shaders/lib/thinning.wgsl`.
    pub thinning: bool,
    /// First vertices have as many as a model says that is worth it, in place of `counts[0]`.
    pub adapts: bool,
}

/// How many connections of first vertices are worth it, as learning found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FirstConnections {
    pub count: u32,
    /// As many as first vertices had while it was learnt; then their connections have this share of a sample's variance, and
    /// of its work.
    pub made: u32,
    pub variance: f64,
    pub cost: f64,
}

impl FirstConnections {
    /// The variance of a sample with so many, over that with as many as were made.
    pub fn variance_with(&self, count: u32) -> f64 {
        1.0 + self.variance * (f64::from(self.made) / f64::from(count) - 1.0)
    }

    /// Why there are so many.
    pub fn reason(&self) -> String {
        format!(
            "{} of each first vertex leave {:.0} % of the variance and are {:.0} % of the work",
            self.made,
            100.0 * self.variance,
            100.0 * self.cost
        )
    }
}

impl Connections {
    /// As many everywhere, as the balance heuristic weighs them.
    pub const fn even(count: u32) -> Self {
        Self { counts: [count; 3], shares: [1.0; 4], thinning: true, adapts: false }
    }

    /// Connections in flight at once.
    pub fn in_flight(&self) -> u32 {
        let most = self.counts.into_iter().fold(1, u32::max);
        most.div_ceil(most.div_ceil(MOST_IN_FLIGHT))
    }

    /// In weights, the densities of the connections of each vertex are times this: N times the share.
    pub fn scales(&self) -> [f32; 3] {
        std::array::from_fn(|vertex| self.counts[vertex] as f32 * self.shares[vertex])
    }

    /// The shares of connections alone.
    pub fn connection_shares(&self) -> [f32; 3] {
        let [first, second, deep, _] = self.shares;
        [first, second, deep]
    }

    /// The same of light that is hit.
    pub fn hit_scale(&self) -> f32 {
        self.shares[3]
    }

    /// Of an eye vertex at this depth; 0 is what the camera sees.
    pub fn scale_at(&self, depth: usize) -> f32 {
        self.scales()[depth.min(2)]
    }

    /// `9,2,1`; one number where it holds for all.
    pub fn counts_text(&self) -> String {
        let [first, second, deep] = self.counts;
        match first == second && second == deep {
            true => first.to_string(),
            false => format!("{first},{second},{deep}"),
        }
    }

    /// `3,2,1,4`
    pub fn shares_text(&self) -> String {
        self.shares.map(|share| share.to_string()).join(",")
    }
}

/// `9,2,1 connections with shares 3,2,1,4`; shares of 1 go without saying.
impl Display for Connections {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{} connections", self.counts_text())?;
        match self.shares == [1.0; 4] {
            true => Ok(()),
            false => write!(f, " with shares {}", self.shares_text()),
        }
    }
}
