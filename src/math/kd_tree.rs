//! A left-balanced tree over points in space, without pointers: the children of place i are 2i + 1 and 2i + 2, and levels
//! divide x, y and z in turn. `shaders/lib/nearest_records` walks the same tree.

use std::cmp::Ordering;

/// Points in the order of their tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KdTree {
    points: Vec<[f32; 3]>,
}

impl KdTree {
    /// The tree, and for each of its places the index of its point. Points that are alike keep their order.
    pub fn build(points: &[[f32; 3]]) -> (Self, Vec<u32>) {
        let mut items: Vec<u32> = (0..points.len() as u32).collect();
        let mut order = vec![0; points.len()];
        place(points, &mut items, 0, 0, &mut order);
        (Self { points: order.iter().map(|&index| points[index as usize]).collect() }, order)
    }

    pub fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// The places of the three points nearest to `to` with their squared distances, from near to far; fewer where there
    /// are not three.
    pub fn nearest(&self, to: [f32; 3]) -> Vec<(u32, f32)> {
        let mut found = Vec::with_capacity(4);
        self.search(0, 0, to, &mut found);
        found
    }

    fn search(&self, place: usize, axis: usize, to: [f32; 3], found: &mut Vec<(u32, f32)>) {
        let Some(at) = self.points.get(place) else { return };
        let distance_sq = (0..3).map(|axis| (at[axis] - to[axis]).powi(2)).sum::<f32>();
        let rank = found.iter().position(|&(_, other)| distance_sq < other).unwrap_or(found.len());
        found.insert(rank, (place as u32, distance_sq));
        found.truncate(3);
        let offset = to[axis] - at[axis];
        let (near, far) = if offset > 0.0 { (2, 1) } else { (1, 2) };
        let next = (axis + 1) % 3;
        self.search(2 * place + near, next, to, found);
        if found.len() < 3 || found.iter().any(|&(_, other)| offset * offset <= other) {
            self.search(2 * place + far, next, to, found);
        }
    }
}

/// Puts the items of a subtree into their places.
fn place(points: &[[f32; 3]], items: &mut [u32], root: usize, axis: usize, order: &mut [u32]) {
    if items.is_empty() {
        return;
    }
    let left = left_size(items.len());
    let coordinate = |index: u32| points[index as usize][axis];
    let compare =
        |&a: &u32, &b: &u32| -> Ordering { coordinate(a).total_cmp(&coordinate(b)).then(a.cmp(&b)) };
    items.select_nth_unstable_by(left, compare);
    order[root] = items[left];
    let (below, above) = items.split_at_mut(left);
    let next = (axis + 1) % 3;
    place(points, below, 2 * root + 1, next, order);
    place(points, &mut above[1..], 2 * root + 2, next, order);
}

/// Points of the left subtree of a left-balanced tree of `count` points.
fn left_size(count: usize) -> usize {
    let half = 1usize << count.ilog2() >> 1;
    // Of the last level, which is not full, the left half goes first.
    let last = count + 1 - (1 << count.ilog2());
    half.saturating_sub(1) + last.min(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::{RandomKey, uniform4};

    fn points(count: u32, of: u32) -> Vec<[f32; 3]> {
        let point = |pixel| uniform4(RandomKey { pixel, sample: of, seed: 1 }, 0).truncate().to_array();
        (0..count).map(point).collect()
    }

    /// Every place of the tree has a point of its own, and its subtrees lie on either side.
    #[test]
    fn trees_are_ordered() {
        for count in 0..70 {
            let points = points(count, count);
            let (tree, mut order) = KdTree::build(&points);
            for (place, point) in tree.points().iter().enumerate().skip(1) {
                let mut child = place;
                while child > 0 {
                    let above = (child - 1) / 2;
                    let axis = (above + 1).ilog2() as usize % 3;
                    let is_left = child % 2 == 1;
                    assert_eq!(point[axis] < tree.points()[above][axis], is_left, "{count}: {place}");
                    child = above;
                }
            }
            order.sort_unstable();
            assert!(order.iter().enumerate().all(|(index, &point)| index == point as usize));
        }
    }

    #[test]
    fn the_nearest_are_those_of_a_plain_search() {
        for count in [0, 1, 2, 3, 4, 50, 333] {
            let (tree, _) = KdTree::build(&points(count, 0));
            for to in points(100, 1) {
                let distance = |at: &[f32; 3]| (0..3).map(|a| (at[a] - to[a]).powi(2)).sum::<f32>();
                let mut plain: Vec<(u32, f32)> =
                    (0..).zip(tree.points()).map(|(place, at)| (place, distance(at))).collect();
                plain.sort_by(|a, b| a.1.total_cmp(&b.1));
                plain.truncate(3);
                assert_eq!(tree.nearest(to), plain, "{count}");
            }
        }
    }
}
