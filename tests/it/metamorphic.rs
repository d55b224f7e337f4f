//! Changes of a scene that must not change its picture, or must change it in a known way.

use glam::{DVec3, Vec3};
use halfway::film::Picture;
use halfway::integrator::View;
use halfway::render::RenderOptions;
use halfway::scene::builtin::{builtin, closed, shapes};
use halfway::scene::{Camera, LightKind, Material, Mesh, Projection, Scene};

use crate::shots::{Shot, assert_same_light, options, render};

const SIZE: [u32; 2] = [16, 16];

fn scene(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

/// The picture with all layers; `samples` is not a multiple of the film's period, so both of its levels take part.
fn picture(scene: &Scene) -> Picture {
    render(scene, RenderOptions { first_hit_layers: true, ..options(SIZE, 24) }).picture
}

fn power(k: i32) -> f32 {
    2f32.powi(k)
}

/// Glass that absorbs, so that a length enters the light's transport.
fn absorbing_spheres() -> Scene {
    let mut scene = scene("spheres");
    for material in scene.materials.iter_mut().filter(|material| material.volume) {
        material.attenuation_distance = 0.7;
        material.attenuation_color = Vec3::new(0.9, 0.5, 0.2);
    }
    scene
}

/// The parallel camera first: its width is a length too.
fn parallel_plates() -> Scene {
    let mut scene = closed::plates();
    scene.cameras.swap(0, 1);
    scene
}

/// All lengths times a power of two; light of points with them, so that as much arrives.
pub fn scaled(scene: &Scene, k: i32) -> Scene {
    let mut scene = scene.clone();
    let factor = 2f64.powi(k);
    for light in &mut scene.lights {
        light.position *= factor;
        if light.kind != LightKind::Directional {
            light.intensity *= power(2 * k);
        }
    }
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|position| *position *= factor);
    for camera in &mut scene.cameras {
        camera.position *= factor;
        if let Projection::Orthographic { xmag, ymag } = &mut camera.projection {
            *xmag *= power(k);
            *ymag *= power(k);
        }
    }
    scene.materials.iter_mut().for_each(|material| material.attenuation_distance *= power(k));
    scene
}

#[test]
fn c20_scale_changes_no_bit() {
    for scene in [
        scene("cornell"),
        absorbing_spheres(),
        scene("bumpy-plane"),
        parallel_plates(),
        scene("three-lights"),
    ] {
        let original = picture(&scene);
        for k in [-60, -20, 20, 60] {
            let picture = picture(&scaled(&scene, k));
            assert_eq!(picture.rgb, original.rgb, "{} times 2^{k}", scene.name);
            let depth = |picture: &Picture| picture.channel("depth", "Z").expect("a depth layer").to_vec();
            let expected: Vec<f32> = depth(&original).iter().map(|z| z * power(k)).collect();
            assert_eq!(depth(&picture), expected, "depth of {} times 2^{k}", scene.name);
        }
    }
}

pub fn brightened(scene: &Scene, k: i32) -> Scene {
    let mut scene = scene.clone();
    scene.materials.iter_mut().for_each(|material| material.emission *= power(k));
    scene.lights.iter_mut().for_each(|light| light.intensity *= power(k));
    if let Some(environment) = &mut scene.environment {
        environment.texels.as_flattened_mut().iter_mut().for_each(|texel| *texel *= power(k));
    }
    scene
}

#[test]
fn c21_exposure_changes_no_bit() {
    for scene in [scene("cornell"), absorbing_spheres(), scene("three-lights")] {
        let shot = |scene: &Scene| render(scene, options(SIZE, 24));
        let Shot { picture: original, report } = shot(&scene);
        let estimated = report.estimated_error.expect("three groups");
        assert!((0.01..10.0).contains(&estimated), "{estimated}");
        for k in [-100, -60, -1, 1, 60, 100] {
            let Shot { picture, report } = shot(&brightened(&scene, k));
            assert_eq!(report.estimated_error, Some(estimated), "{} times 2^{k}", scene.name);
            let [known, expected] = [&picture, &original].map(|p| p.variance().expect("a layer"));
            for (pixel, channel) in (0..known.pixels()).flat_map(|pixel| (0..3).map(move |c| (pixel, c))) {
                let expected = expected.at(channel, pixel) * 2f64.powi(2 * k);
                assert_eq!(known.at(channel, pixel), expected, "{} times 2^{k}", scene.name);
            }
            let expected: Vec<[f32; 3]> = original.rgb.iter().map(|rgb| rgb.map(|c| c * power(k))).collect();
            assert!(expected.iter().flatten().all(|&c| c == 0.0 || c.is_normal()), "f32 can hold it");
            assert_eq!(picture.rgb, expected, "{} times 2^{k}", scene.name);
        }
    }
}

/// A lamp that lights nothing in sight makes all else dim beside it: so are squares, but the error stays what it is.
#[test]
fn c21_a_sealed_lamp_changes_no_estimate() {
    let estimate = |k: i32| {
        let report = render(&sealed_lamp(12.0 * power(k)), options(SIZE, 64)).report;
        report.estimated_error.expect("eight groups")
    };
    let estimated = estimate(40);
    assert!((0.01..10.0).contains(&estimated), "{estimated}");
    for k in [60, 80, 100] {
        let other = estimate(k);
        println!("2^{k}: {other}, not {estimated}");
        assert!((other / estimated - 1.0).abs() < 1e-3, "2^{k}: {other} is not {estimated}");
    }
}

/// On multiples of `grid`, a power of two, so that moving by a multiple of that is exact in f64.
pub fn snapped(mut scene: Scene, grid: f64) -> Scene {
    let snap = |point: &mut DVec3| *point = (*point / grid).round() * grid;
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(snap);
    scene.cameras.iter_mut().for_each(|camera| snap(&mut camera.position));
    scene.lights.iter_mut().for_each(|light| snap(&mut light.position));
    scene
}

pub fn moved(scene: &Scene, by: DVec3) -> Scene {
    let mut scene = scene.clone();
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|position| *position += by);
    scene.cameras.iter_mut().for_each(|camera| camera.position += by);
    scene.lights.iter_mut().for_each(|light| light.position += by);
    scene
}

#[test]
fn c22_place_changes_no_bit() {
    for scene in [scene("cornell"), scene("three-lights")].map(|scene| snapped(scene, power(-20).into())) {
        let original = picture(&scene);
        for by in [DVec3::X * 2f64.powi(10), DVec3::new(-1.0, 0.75, 3.0) * 2f64.powi(20)] {
            let picture = picture(&moved(&scene, by));
            assert_eq!(picture.rgb, original.rgb, "{} moved by {by}", scene.name);
        }
    }
    // Where the move rounds the vertices, to 2^-33 of the scene's size, paths may part ways, but not in the mean.
    let cornell = scene("cornell");
    let far = render(&moved(&cornell, DVec3::splat(1e6)), options([32, 32], 64)).picture;
    let near = render(
        &cornell,
        RenderOptions { view: View { seed: 1, ..options([32, 32], 64).view }, ..options([32, 32], 64) },
    )
    .picture;
    assert_same_light("cornell 1e6 away", &far, &near);
}

/// Cornell's box without texture coordinates, which nothing there reads; seen from below its lamp, whose edge would
/// be most of the noise.
fn cornell() -> Scene {
    let mut scene = scene("cornell");
    scene.meshes.iter_mut().for_each(|mesh| mesh.uvs = [None, None]);
    let (eye, target) = (DVec3::new(0.0, 0.8, 4.4), DVec3::new(0.0, 0.75, 0.0));
    scene.cameras = vec![shapes::looking_at("low", eye, target, 22.0)];
    scene
}

/// The same with a lamp inside the tall block.
fn sealed_lamp(emission: f32) -> Scene {
    let mut scene = cornell();
    let material = scene.materials.len() as u32;
    let lambert = Material::lambert("sealed", Vec3::splat(0.5));
    scene.materials.push(Material { emission: Vec3::splat(emission), ..lambert });
    let corner = DVec3::new(-0.44, 0.6, -0.44);
    let quad = shapes::quad(corner, DVec3::X * 0.2, DVec3::Z * 0.2);
    scene.meshes.push(Mesh { name: "sealed".into(), material, ..quad });
    scene
}

/// Meshes, triangles and their corners in another order.
pub fn reordered(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.meshes.reverse();
    for mesh in &mut scene.meshes {
        mesh.triangles.reverse();
        mesh.triangles.iter_mut().for_each(|triangle| triangle.rotate_left(1));
    }
    scene
}

/// Every triangle in four, at the middles of its edges.
fn in_four(mesh: &Mesh) -> Mesh {
    let mut split = Mesh { triangles: Vec::new(), positions: Vec::new(), ..mesh.clone() };
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let first = split.positions.len() as u32;
        split.positions.extend([a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]);
        let triangles = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
        split.triangles.extend(triangles.map(|triangle| triangle.map(|corner| corner + first)));
    }
    split
}

/// The coordinates in another order, which is a rotation.
fn axes_permuted(mut scene: Scene) -> Scene {
    scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|p| *p = DVec3::new(p.z, p.x, p.y));
    for Camera { position, right, up, forward, .. } in &mut scene.cameras {
        *position = DVec3::new(position.z, position.x, position.y);
        for axis in [right, up, forward] {
            *axis = Vec3::new(axis.z, axis.x, axis.y);
        }
    }
    scene
}

#[test]
fn c23_rearranged_scenes_have_the_same_light() {
    let original = render(&cornell(), options([32, 32], 192)).picture;
    let again = |what: &str, scene: &Scene| {
        let options =
            RenderOptions { view: View { seed: 1, ..options([32, 32], 192).view }, ..options([32, 32], 192) };
        assert_same_light(what, &render(scene, options).picture, &original);
    };
    again("another seed", &cornell());

    again("triangles in another order", &reordered(&cornell()));

    let mut split = cornell();
    split.meshes.iter_mut().for_each(|mesh| *mesh = in_four(mesh));
    again("every triangle in four", &split);

    let mut lamp_in_four = cornell();
    let lamp = lamp_in_four.meshes.iter_mut().find(|mesh| mesh.name == "lamp").expect("a lamp");
    *lamp = in_four(lamp);
    again("the lamp in four", &lamp_in_four);

    // As strong as the lamp that is seen.
    again("a lamp that is not seen", &sealed_lamp(12.0));

    again("axes in another order", &axes_permuted(cornell()));
}
