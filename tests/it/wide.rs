//! Small things on wide grounds, and cameras far away (N-27, N-28).

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DQuat, DVec3, Vec2, Vec3};
use halfway::accel::{Accel, without_wide_triangles};
use halfway::film::Picture;
use halfway::integrator::{Connections, LvcBpt, Method, View};
use halfway::render::RenderOptions;
use halfway::scene::builtin::{builtin, shapes};
use halfway::scene::{LightKind, Mesh, Projection, PunctualLight, Scene};

use crate::judge::{grey, horizontal, lamp, scene};
use crate::shots::{assert_same_light, options, render};
use crate::traversal;

const LVCBPT: Method = Method::LvcBpt(LvcBpt {
    light_paths: Some(256),
    connections: Connections::even(2),
    light_tracing: false,
});

/// A cube of size 1 on a ground of half-size `reach`, lit from the side.
struct Ground {
    reach: f64,
    /// Of the ground with all that is on it, degrees.
    tilt: f64,
    /// Where the cube stands, shares of the ground's half-size.
    place: [f64; 2],
}

impl Ground {
    fn place(&self) -> DVec3 {
        self.reach * DVec3::new(self.place[0], 0.0, self.place[1])
    }

    fn scene(&self) -> Scene {
        let Self { reach, tilt, .. } = *self;
        let place = self.place();
        let ground = Mesh {
            uvs: [None, None],
            ..shapes::quad(DVec3::new(-reach, 0.0, -reach), 2.0 * reach * DVec3::Z, 2.0 * reach * DVec3::X)
        };
        let cube = shapes::cuboid(place - DVec3::new(0.5, 0.0, 0.5), place + DVec3::new(0.5, 1.0, 0.5));
        let mut scene = scene([(grey(0.5), ground), (grey(0.5), cube)]);
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 0.3, 0.7).normalize(), tilt.to_radians());
        scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|p| *p = turn * *p);
        scene.lights = vec![PunctualLight {
            name: "sun".into(),
            kind: LightKind::Directional,
            position: DVec3::ZERO,
            direction: (turn * DVec3::new(-1.0, -1.0, 0.0).normalize()).as_vec3(),
            intensity: Vec3::splat(3.0),
        }];
        let mut camera = shapes::looking_at("near", DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO, 60.0);
        camera.position = turn * (camera.position + place);
        for axis in [&mut camera.right, &mut camera.up, &mut camera.forward] {
            *axis = (turn * axis.as_dvec3()).as_vec3();
        }
        scene.cameras = vec![camera];
        scene
    }
}

fn picture(scene: &Scene, method: Method) -> Picture {
    render(scene, RenderOptions { method, ..options([16, 16], 64) }).picture
}

/// Mean difference of two pictures over the mean of the second.
fn difference(picture: &Picture, reference: &Picture) -> f32 {
    let sum = |values: &mut dyn Iterator<Item = f32>| values.sum::<f32>();
    let differences = picture.rgb.iter().zip(&reference.rgb).map(|(a, b)| (a[0] - b[0]).abs());
    sum(&mut differences.into_iter()) / sum(&mut reference.rgb.iter().map(|rgb| rgb[0]))
}

#[test]
fn n27_a_cube_has_its_shadow_on_any_ground() {
    for method in [Method::Path, LVCBPT] {
        for tilt in [0.0, 20.0] {
            let near = Ground { reach: 1e3, tilt, place: [0.0; 2] };
            let reference = picture(&near.scene(), method);
            for (reach, place) in
                [(1e6, [0.0; 2]), (1e6, [0.37, -0.61]), (1e7, [0.37, -0.61]), (1e8, [-0.9, 0.1])]
            {
                let ground = Ground { reach, tilt, place };
                let what = format!("{}, {reach:e}, turned by {tilt}, at {place:?}", method.name());
                let picture = picture(&ground.scene(), method);
                assert_same_light(&what, &picture, &reference);
                let difference = difference(&picture, &reference);
                println!("{what}: {difference:.5}");
                // Light paths differ with the size of the ground: that is noise.
                let most = if method == Method::Path { 0.005 } else { 0.1 };
                assert!(difference < most, "{what}: {difference}");
            }
        }
    }
}

/// Faces at each edge of meshes, by the places of its ends.
fn edges<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> HashMap<[[u64; 3]; 2], u32> {
    let mut edges = HashMap::new();
    for mesh in meshes {
        for triangle in &mesh.triangles {
            let places = triangle.map(|vertex| mesh.positions[vertex as usize].to_array().map(f64::to_bits));
            for corner in 0..3 {
                let mut edge = [places[corner], places[(corner + 1) % 3]];
                edge.sort_unstable();
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
    }
    edges
}

/// A large box whose faces are meshes of their own, some sides turned, with small cubes on it.
fn studded_box() -> Scene {
    let mut faces: Vec<Mesh> = Vec::new();
    let whole = shapes::cuboid(DVec3::new(-1e6, -3e6, -2e6), DVec3::new(1e6, -1.0, 2e6));
    for pair in whole.triangles.chunks(2) {
        faces.push(Mesh { triangles: pair.to_vec(), ..whole.clone() });
    }
    let cube = |at: DVec3| shapes::cuboid(at - 0.5, at + 0.5);
    let places = [DVec3::new(3e5, -0.5, 1e6), DVec3::new(-1e6, -1.0, 7e5), DVec3::new(1e6, -1e6, -2e6)];
    traversal::scene(faces.into_iter().chain(places.map(cube)))
}

#[test]
fn n27_cut_meshes_stay_closed() {
    let scene = studded_box();
    let cut = without_wide_triangles(&scene);
    let added = cut.triangle_count() - scene.triangle_count();
    println!("{added} triangles more");
    assert!((100..2000).contains(&added), "{added} triangles more");
    for (name, scene) in [("before", &scene), ("after", &*cut)] {
        let open = edges(&scene.meshes[..6]).values().filter(|&&faces| faces != 2).count();
        assert_eq!(open, 0, "edges that are not of two faces, {name}");
    }
    let area = |scene: &Scene| -> f64 {
        let of = |mesh: &Mesh, t: &[u32; 3]| {
            let [a, b, c] = t.map(|vertex| mesh.positions[vertex as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        scene.meshes.iter().flat_map(|mesh| mesh.triangles.iter().map(|t| of(mesh, t))).sum()
    };
    assert!((area(&cut) / area(&scene) - 1.0).abs() < 1e-12);
    // The triangle below each cube is not wide beside it.
    for place in [DVec3::new(3e5, -1.0, 1e6), DVec3::new(-1e6, -1.0, 7e5), DVec3::new(1e6, -1e6, -2e6)] {
        let near = |corners: &[DVec3; 3]| corners.iter().any(|corner| corner.distance(place) < 12_000.0);
        let corners = cut.meshes[..6]
            .iter()
            .flat_map(|mesh| mesh.triangles.iter().map(|t| t.map(|vertex| mesh.positions[vertex as usize])));
        let longest = corners
            .filter(near)
            .map(|[a, b, c]| a.distance(b).max(b.distance(c)).max(c.distance(a)))
            .fold(f64::INFINITY, f64::min);
        assert!(longest < 1.5 * 8192.0, "{longest} at {place}");
    }
    assert!(Accel::build(&cut).unwrap().unit.centre.distance(DVec3::new(3e5, -0.5, 1e6)) < 1.0);
}

#[test]
fn n27_what_vertices_carry_is_as_before() {
    let reach = 1e7;
    let mut ground =
        shapes::quad(DVec3::new(-reach, 0.0, -reach), 2.0 * reach * DVec3::Z, 2.0 * reach * DVec3::X);
    ground.normals = Some(vec![Vec3::Y, Vec3::X, Vec3::Z, Vec3::Y]);
    let scene = traversal::scene([ground, shapes::cuboid(DVec3::ZERO, DVec3::ONE)]);
    let cut = without_wide_triangles(&scene);
    let mesh = &cut.meshes[0];
    assert!(mesh.positions.len() > 20);
    let (uvs, normals) = (mesh.uvs[0].as_ref().unwrap(), mesh.normals.as_ref().unwrap());
    assert_eq!([uvs.len(), normals.len()], [mesh.positions.len(); 2]);
    for ((position, uv), normal) in mesh.positions.iter().zip(uvs).zip(normals) {
        let expected = 0.5 + 0.5 * Vec2::new(position.z as f32, position.x as f32) / reach as f32;
        assert!((*uv - expected).abs().max_element() < 1e-6, "{position}: {uv}");
        // Corners (0, 0), (1, 0), (1, 1), (0, 1); two triangles along the diagonal.
        let (u, v) = (uv.x, uv.y);
        let corners = [Vec3::Y, if u > v { Vec3::X } else { Vec3::Y }, Vec3::Z];
        let (low, high) = (u.min(v), u.max(v));
        let expected = (1.0 - high) * corners[0] + (high - low) * corners[1] + low * corners[2];
        assert!((*normal - expected).abs().max_element() < 1e-6, "{uv}: {normal}, not {expected}");
    }
}

#[test]
fn n27_scenes_without_wide_triangles_are_left_alone() {
    for name in ["cornell", "spheres", "plates", "three-lights"] {
        assert!(matches!(without_wide_triangles(&builtin(name).unwrap()), Cow::Borrowed(_)), "{name}");
    }
    // Wide, but with nothing on it.
    let far = traversal::scene([
        horizontal(1e7, 0.0, true),
        shapes::cuboid(DVec3::splat(1e7), DVec3::splat(1e7 + 1.0)),
    ]);
    assert!(matches!(without_wide_triangles(&far), Cow::Borrowed(_)));
}

/// A scaled or moved scene is cut in the same way, bit for bit (N-06, C-22).
#[test]
fn n27_size_and_place_do_not_count() {
    let scene = studded_box();
    let accel = Accel::build(&without_wide_triangles(&scene)).unwrap();
    let vertices =
        |accel: &Accel| accel.triangles.iter().map(|triangle| triangle.vertices).collect::<Vec<_>>();
    type Change = fn(DVec3) -> DVec3;
    let changes: [(&str, Change); 4] = [
        ("moved", |p| p + DVec3::new(1024.0, -4096.0, 64.0)),
        ("larger", |p| p * 2f64.powi(40)),
        ("huge", |p| p * 2f64.powi(900)),
        ("tiny", |p| p * 2f64.powi(-700)),
    ];
    for (name, change) in changes {
        let mut changed = scene.clone();
        changed.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|p| *p = change(*p));
        let changed = Accel::build(&without_wide_triangles(&changed)).unwrap();
        assert!(vertices(&changed) == vertices(&accel), "{name}");
    }
}

/// From 10^7 times the scene's size away, through a field of view as small as that.
#[test]
fn n28_far_cameras_see_what_parallel_ones_see() {
    let (floor, lamp) = ((grey(0.5), horizontal(2.0, 0.0, true)), (lamp(1.0), horizontal(2.0, 1.0, false)));
    let mut near = scene([floor, lamp]);
    let towards = DVec3::new(1.0, 1.0, 0.0).normalize();
    let target = DVec3::new(0.8, 0.0, 0.0);
    let mut parallel = shapes::looking_at("parallel", target + 3.0 * towards, target, 1.0);
    parallel.projection = Projection::Orthographic { xmag: 0.25, ymag: 0.25 };
    near.cameras = vec![parallel];
    for method in [Method::Path, LVCBPT] {
        let options = RenderOptions { method, first_hit_layers: true, ..options([16, 16], 256) };
        let expected = render(&near, options.clone()).picture;
        for distance in [1e3_f64, 1e5, 1e7, 1e12] {
            let mut far = near.clone();
            let fov = 2.0 * (0.25 / distance).atan();
            far.cameras =
                vec![shapes::looking_at("far", target + distance * towards, target, fov.to_degrees() as f32)];
            let view = View { seed: 1, ..options.view };
            let picture = render(&far, RenderOptions { view, ..options.clone() }).picture;
            assert_same_light(&format!("{}, from {distance:e}", method.name()), &picture, &expected);
            let depth = f64::from(picture.channel("depth", "Z").unwrap()[16 * 8 + 8]);
            assert!((depth / distance - 1.0).abs() < 1.0 / distance + 1e-6, "{depth} from {distance:e}");
        }
    }
}
