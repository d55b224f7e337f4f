//! What lies on a line, asked once in a while: no tree is built for it.

use glam::DVec3;
use rayon::prelude::*;

use super::{Instance, Mesh, Scene};

/// Triangles per task.
const CHUNK: usize = 1 << 14;

impl Scene {
    /// The distance, in scene units, from `origin` to the nearest triangle in the direction of `direction`, which need not
    /// be a unit vector. Both sides count, but for backs that the camera looks through, and what is cut out of them by alpha
    /// does too. `None`: nothing is there, or the direction is none.
    pub fn distance_along(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let line = Line::new(origin, direction)?;
        let culled =
            |mesh: &Mesh| self.materials.get(mesh.material as usize).is_some_and(|material| material.culled);
        let places = self
            .meshes
            .par_iter()
            .flat_map_iter(|mesh| mesh.shown_at().map(move |instance| (mesh, instance)));
        let nearest = |mesh: &Mesh, instance: Option<&Instance>, triangles: &[[u32; 3]]| {
            let distances = triangles
                .iter()
                .map(mesh.corners_at(instance))
                .filter(|[a, b, c]| !culled(mesh) || (b - a).cross(c - a).dot(direction) <= 0.0)
                .filter_map(|corners| line.distance(corners));
            distances.min_by(f64::total_cmp)
        };
        places
            .flat_map(|(mesh, instance)| {
                mesh.triangles
                    .par_chunks(CHUNK)
                    .filter_map(move |triangles| nearest(mesh, instance, triangles))
            })
            .min_by(f64::total_cmp)
    }
}

/// A half line, with what shears space so that it becomes the z axis: Woop et al., Watertight Ray/Triangle Intersection,
/// JCGT 2(1), 2013. No line slips through between two triangles with a common edge.
struct Line {
    origin: DVec3,
    /// Axes of the scene that become x, y and z; z is the one that the direction is longest along.
    axes: [usize; 3],
    shear: DVec3,
}

impl Line {
    fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let size = direction.abs().max_element();
        let direction = (direction / size).try_normalize()?;
        let z = direction.abs().max_position();
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let [x, y, z] = axes.map(|axis| direction[axis]);
        Some(Self { origin, axes, shear: DVec3::new(x / z, y / z, 1.0 / z) })
    }

    fn distance(&self, corners: [DVec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|corner| {
            let [x, y, z] = self.axes.map(|axis| (corner - self.origin)[axis]);
            DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
        let weights = DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let determinant = weights.element_sum();
        // Seen from its edge, or without an area.
        if determinant == 0.0 {
            return None;
        }
        let distance = (weights / determinant).dot(DVec3::new(a.z, b.z, c.z));
        (distance > 0.0 && distance.is_finite()).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::scene::builtin::shapes;

    fn scene(meshes: Vec<Mesh>) -> Scene {
        Scene { meshes, ..Scene::default() }
    }

    #[test]
    fn the_nearest_side_counts_from_both_sides() {
        let wall = |z: f64| shapes::quad(DVec3::new(-1.0, -1.0, z), DVec3::X * 2.0, DVec3::Y * 2.0);
        let scene = scene(vec![wall(-3.0), wall(-7.0), wall(2.0)]);
        let at = DVec3::new(0.25, 0.5, 0.0);
        assert_eq!(scene.distance_along(at, DVec3::NEG_Z), Some(3.0));
        assert_eq!(scene.distance_along(at, DVec3::Z * 1e-200), Some(2.0));
        assert_eq!(scene.distance_along(at - DVec3::Z * 5.0, DVec3::Z), Some(2.0));
        assert_eq!(scene.distance_along(at, DVec3::X), None);
        assert_eq!(scene.distance_along(at + DVec3::X * 2.0, DVec3::Z), None);
        assert_eq!(scene.distance_along(at, DVec3::ZERO), None);
        assert_eq!(scene.distance_along(at, DVec3::NAN), None);
    }

    proptest! {
        /// The point that is aimed at is where the distance says, whatever the scene's size and place, and the diagonal of
        /// the two triangles is no gap.
        #[test]
        fn points_of_a_quad_are_found(
            scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
            away in -100.0..100.0f64,
            s in 0.0..1.0f64,
            t in 0.0..1.0f64,
            on_diagonal in any::<bool>(),
            from in prop::array::uniform3(-4.0..4.0f64),
        ) {
            let corner = DVec3::new(away, -1.0, 0.5) * scale;
            let (right, up) = (DVec3::new(2.0, 0.1, 0.3) * scale, DVec3::new(0.2, 2.0, -0.4) * scale);
            let t = if on_diagonal { s } else { t };
            let point = corner + right * s + up * t;
            let origin = point + DVec3::from(from) * scale;
            let facing = right.cross(up).normalize().dot((point - origin).normalize()).abs();
            prop_assume!(facing > 0.01 && s.min(t) > 1e-6 && s.max(t) < 1.0 - 1e-6);
            let found = scene(vec![shapes::quad(corner, right, up)]).distance_along(origin, point - origin);
            let expected = origin.distance(point);
            prop_assert!(found.is_some_and(|found| (found / expected - 1.0).abs() < 1e-9), "{found:?} {expected}");
        }
    }
}
