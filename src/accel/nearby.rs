//! Which small triangles are near a large one: a tree over their middles.

use glam::DVec3;

/// A small triangle as its middle.
struct Small {
    middle: DVec3,
    /// A corner in the scene's units.
    place: DVec3,
    /// Length of its longest edge.
    size: f64,
    /// In the order of the scene.
    index: u32,
}

/// A node covers `first..end` of the items; inner ones have their children behind them.
struct Node {
    low: DVec3,
    high: DVec3,
    least: f64,
    items: std::ops::Range<usize>,
    /// Index of the second child; the first one follows its parent. 0 for a leaf.
    second: usize,
}

/// Small triangles by place and size, in unit space.
pub(super) struct Nearby {
    items: Vec<Small>,
    nodes: Vec<Node>,
}

const LEAF: usize = 8;

impl Nearby {
    /// Of triangles: a corner in the scene's units, the corners in unit space, the length of the longest edge.
    pub fn new(triangles: impl Iterator<Item = (DVec3, [DVec3; 3], f64)>) -> Self {
        let items = triangles.enumerate().map(|(index, (place, corners, size))| {
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            Small { middle, place, size, index: index as u32 }
        });
        let mut nearby = Self { items: items.collect(), nodes: Vec::new() };
        if !nearby.items.is_empty() {
            nearby.build(0..nearby.items.len());
        }
        nearby
    }

    fn build(&mut self, range: std::ops::Range<usize>) {
        let items = &mut self.items[range.clone()];
        let (mut low, mut high, mut least) = (DVec3::INFINITY, DVec3::NEG_INFINITY, f64::INFINITY);
        for item in &*items {
            (low, high, least) = (low.min(item.middle), high.max(item.middle), least.min(item.size));
        }
        let node = self.nodes.len();
        self.nodes.push(Node { low, high, least, items: range.clone(), second: 0 });
        if items.len() <= LEAF {
            return;
        }
        let axis = (high - low).max_position();
        let half = items.len() / 2;
        // By index where equal, so that the tree does not depend on the sort.
        items.select_nth_unstable_by(half, |a, b| {
            a.middle[axis].total_cmp(&b.middle[axis]).then(a.index.cmp(&b.index))
        });
        let middle = range.start + half;
        self.build(range.start..middle);
        self.nodes[node].second = self.nodes.len();
        self.build(middle..range.end);
    }

    /// Size (as bits, which are in the same order) and index of the smallest triangle that is smaller than `size` and whose
    /// middle is nearer than `distance` to the triangle of these corners.
    pub fn smallest(&self, corners: &[DVec3; 3], distance: f64, size: f64) -> Option<(u64, u32)> {
        let [a, b, c] = *corners;
        let (low, high) = (a.min(b).min(c) - distance, a.max(b).max(c) + distance);
        let mut best: Option<(u64, u32)> = None;
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let limit = best.map_or(size, |best| f64::from_bits(best.0));
            if node.least > limit || node.low.cmpgt(high).any() || node.high.cmplt(low).any() {
                continue;
            }
            if node.second != 0 {
                stack.extend([node.second, index + 1]);
                continue;
            }
            for item in &self.items[node.items.clone()] {
                let key = (item.size.to_bits(), item.index);
                let is_better = item.size < size && best.is_none_or(|best| key < best);
                if is_better && distance_sq(item.middle, corners) < distance * distance {
                    best = Some(key);
                }
            }
        }
        best
    }

    /// How many triangles are more than `times` their size away from that of an index.
    pub fn count_far_from(&self, index: u32, times: f64) -> usize {
        let Some(from) = self.items.iter().find(|item| item.index == index) else { return 0 };
        let is_far = |item: &&Small| (item.middle - from.middle).abs().max_element() > times * item.size;
        self.items.iter().filter(is_far).count()
    }

    /// A corner of the triangle of that index, in the scene's units.
    pub fn corner(&self, index: u32) -> Option<DVec3> {
        self.items.iter().find(|item| item.index == index).map(|item| item.place)
    }
}

/// Squared distance of a point from a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn distance_sq(point: DVec3, corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *corners;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let area_sq = normal.length_squared();
    let from = point - a;
    if area_sq > 0.0 {
        let v = from.cross(ac).dot(normal);
        let w = ab.cross(from).dot(normal);
        if v >= 0.0 && w >= 0.0 && v + w <= area_sq {
            return from.dot(normal).powi(2) / area_sq;
        }
    }
    let to_edge = |start: DVec3, edge: DVec3| {
        let along = ((point - start).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        (point - start - along * edge).length_squared()
    };
    to_edge(a, ab).min(to_edge(b, c - b)).min(to_edge(a, ac))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_from_a_triangle() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (point, distance) in [
            (DVec3::new(0.25, 0.25, 2.0), 2.0),
            (DVec3::new(0.25, -3.0, 0.0), 3.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5f64.sqrt()),
            (DVec3::new(-3.0, 0.0, 4.0), 5.0),
            (DVec3::new(2.0, 0.0, 0.0), 1.0),
        ] {
            assert!((distance_sq(point, &corners).sqrt() - distance).abs() < 1e-15, "{point}");
        }
    }
}
