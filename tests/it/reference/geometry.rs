//! Rays and triangles in f64: Moeller and Trumbore's test, in a tree of boxes split at the median.

use glam::DVec3;

#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
}

#[derive(Clone, Copy, Debug)]
pub struct Hit {
    pub distance: f64,
    pub triangle: usize,
    /// Barycentrics of the second and third corner.
    pub b: [f64; 2],
}

#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

enum Node {
    Leaf { bounds: Bounds, first: usize, count: usize },
    Inner { bounds: Bounds, children: Box<[Node; 2]> },
}

pub struct Tree {
    corners: Vec<[DVec3; 3]>,
    order: Vec<usize>,
    root: Option<Node>,
    /// Hits nearer than this are the surface that the ray starts on.
    pub nearest: f64,
}

impl Tree {
    pub fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let mut order: Vec<usize> = (0..corners.len()).collect();
        let root = (!corners.is_empty()).then(|| build(&corners, &mut order, 0));
        let reach = root.as_ref().map_or(0.0, |node| {
            let bounds = node.bounds();
            bounds.low.abs().max(bounds.high.abs()).max_element()
        });
        Self { corners, order, root, nearest: 1e-10 * reach }
    }

    /// The hit with the smallest distance in (from, to).
    pub fn closest(&self, ray: &Ray, from: f64, to: f64) -> Option<Hit> {
        let mut best = None;
        if let Some(root) = &self.root {
            self.visit(root, ray, from, to, &mut best);
        }
        best
    }

    fn visit(&self, node: &Node, ray: &Ray, from: f64, to: f64, best: &mut Option<Hit>) {
        let limit = best.map_or(to, |hit| hit.distance);
        if !node.bounds().meets(ray, from, limit) {
            return;
        }
        match node {
            Node::Inner { children, .. } => {
                for child in children.iter() {
                    self.visit(child, ray, from, to, best);
                }
            }
            &Node::Leaf { first, count, .. } => {
                for &triangle in &self.order[first..first + count] {
                    let limit = best.map_or(to, |hit: Hit| hit.distance);
                    let hit = intersect(&self.corners[triangle], ray);
                    if let Some((distance, b)) = hit.filter(|(t, _)| *t > from && *t < limit) {
                        *best = Some(Hit { distance, triangle, b });
                    }
                }
            }
        }
    }
}

impl Node {
    fn bounds(&self) -> &Bounds {
        let (Self::Leaf { bounds, .. } | Self::Inner { bounds, .. }) = self;
        bounds
    }
}

impl Bounds {
    /// Slabs, widened by more than their rounding.
    fn meets(&self, ray: &Ray, from: f64, to: f64) -> bool {
        let inverse = ray.direction.recip();
        let (mut near, mut far) = (from, to);
        for axis in 0..3 {
            if ray.direction[axis] == 0.0 {
                if ray.origin[axis] < self.low[axis] || ray.origin[axis] > self.high[axis] {
                    return false;
                }
                continue;
            }
            let a = (self.low[axis] - ray.origin[axis]) * inverse[axis];
            let b = (self.high[axis] - ray.origin[axis]) * inverse[axis];
            let slack = 1e-12 * a.abs().max(b.abs());
            near = near.max(a.min(b) - slack);
            far = far.min(a.max(b) + slack);
        }
        near <= far
    }
}

fn build(corners: &[[DVec3; 3]], order: &mut [usize], first: usize) -> Node {
    let mut bounds = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
    for corner in order.iter().flat_map(|&triangle| corners[triangle]) {
        bounds.low = bounds.low.min(corner);
        bounds.high = bounds.high.max(corner);
    }
    if order.len() <= 4 {
        return Node::Leaf { bounds, first, count: order.len() };
    }
    let axis = (bounds.high - bounds.low).max_position();
    let centre = |triangle: usize| corners[triangle].iter().map(|corner| corner[axis]).sum::<f64>();
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| centre(a).total_cmp(&centre(b)));
    let (left, right) = order.split_at_mut(middle);
    let children = Box::new([build(corners, left, first), build(corners, right, first + middle)]);
    Node::Inner { bounds, children }
}

/// Distance and barycentrics of the second and third corner. Both sides are hit.
fn intersect([a, b, c]: &[DVec3; 3], ray: &Ray) -> Option<(f64, [f64; 2])> {
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = ray.origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) / determinant;
    // A hair beyond the edges: a ray along a shared edge must not slip between its triangles.
    let inside = u >= -1e-13 && v >= -1e-13 && u + v <= 1.0 + 1e-13;
    inside.then(|| (e2.dot(q) / determinant, [u, v]))
}
