//! The built-in scenes are what their descriptions promise.

use std::collections::HashMap;

use glam::DVec3;
use halfway::scene::builtin::{NAMES, builtin, closed, lamps, shapes, surfaces};
use halfway::scene::{Mesh, Scene};

/// The area vector (half the cross product) of every triangle with its centroid.
fn area_vectors(mesh: &Mesh) -> Vec<(DVec3, DVec3)> {
    mesh.triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            ((b - a).cross(c - a) / 2.0, (a + b + c) / 3.0)
        })
        .collect()
}

/// Every directed edge once, and its reverse once: closed and consistently wound.
fn assert_closed(mesh: &Mesh) {
    let mut edges = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!(count, 1, "{}: edge {a}-{b} used {count} times in one direction", mesh.name);
        assert!(edges.contains_key(&(b, a)), "{}: edge {a}-{b} is open", mesh.name);
    }
}

fn assert_sound(scene: &Scene) {
    let name = &scene.name;
    assert!(scene.triangle_count() > 0 && !scene.cameras.is_empty(), "{name}: nothing to see");
    assert!(scene.resolution.is_some_and(|[w, h]| w > 0 && h > 0), "{name}: no resolution");
    assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
    let emits = scene.materials.iter().any(|m| m.emission.max_element() > 0.0);
    assert!(emits || !scene.lights.is_empty() || scene.environment.is_some(), "{name}: dark");
    for mesh in &scene.meshes {
        let what = format!("{name}/{}", mesh.name);
        let count = mesh.positions.len();
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "{what}: positions");
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < count), "{what}: indices");
        assert!((mesh.material as usize) < scene.materials.len(), "{what}: material");
        assert!(
            area_vectors(mesh).iter().all(|(area, _)| area.length() > 0.0),
            "{what}: degenerate triangle"
        );
        if let Some(normals) = &mesh.normals {
            assert_eq!(normals.len(), count, "{what}: normals");
            for (normal, triangle) in mesh.triangles.iter().flat_map(|t| t.map(|i| (normals[i as usize], t)))
            {
                assert!((normal.length() - 1.0).abs() < 1e-5, "{what}: normal {normal}");
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                assert!(
                    (b - a).cross(c - a).dot(normal.as_dvec3()) > 0.0,
                    "{what}: normal behind its triangle"
                );
            }
        }
        for uvs in mesh.uvs.iter().flatten() {
            assert_eq!(uvs.len(), count, "{what}: uvs");
        }
        if let Some(tangents) = &mesh.tangents {
            assert_eq!(tangents.len(), count, "{what}: tangents");
        }
        let material = &scene.materials[mesh.material as usize];
        if material.normal_texture.is_some() {
            assert!(mesh.tangents.is_some(), "{what}: a normal map without tangents");
        }
    }
    for texture in &scene.textures {
        let image = &scene.images[texture.image as usize];
        assert_eq!(image.texels.len(), (image.width * image.height) as usize, "{name}: {}", image.name);
    }
    for camera in &scene.cameras {
        let (right, up, forward) = (camera.right, camera.up, camera.forward);
        for (value, expected) in [
            (right.length(), 1.0),
            (up.length(), 1.0),
            (forward.length(), 1.0),
            (right.dot(up), 0.0),
            (up.dot(forward), 0.0),
            (right.cross(up).dot(-forward), 1.0),
        ] {
            assert!(
                (value - expected).abs() < 1e-6,
                "{name}: camera {}: {value} not {expected}",
                camera.name
            );
        }
    }
}

#[test]
fn every_builtin_scene_is_sound() {
    for name in NAMES {
        let scene = builtin(name).expect("listed names exist");
        assert_eq!(scene.name, name);
        assert_sound(&scene);
    }
    assert!(builtin("no-such-scene").is_none());
}

/// Mesh 0 is a closed surface whose front looks inward everywhere (star-shaped about the origin).
fn assert_enclosure(scene: &Scene) {
    let mesh = &scene.meshes[0];
    assert_closed(mesh);
    for (area, centroid) in area_vectors(mesh) {
        assert!(area.dot(centroid) < 0.0, "{}: a triangle looks outward", scene.name);
    }
}

#[test]
fn c04_furnace_encloses_its_camera() {
    assert_enclosure(&closed::furnace_box(0.8, 1.0));
    for subdivisions in 0..4 {
        let scene = closed::furnace_sphere(0.8, 1.0, subdivisions);
        assert_eq!(scene.triangle_count(), 20 * 4_usize.pow(subdivisions));
        assert_enclosure(&scene);
    }
}

/// The divergence theorem over all triangles gives the enclosed volume.
#[test]
fn shapes_have_their_volumes() {
    let volume = |mesh: &Mesh| area_vectors(mesh).iter().map(|(area, at)| area.dot(*at) / 3.0).sum::<f64>();
    let cuboid = shapes::cuboid(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 4.0, 6.0));
    assert_closed(&cuboid);
    assert!((volume(&cuboid) - 6.0).abs() < 1e-12);
    let turned = shapes::turned(cuboid, DVec3::new(0.5, 0.0, -7.0), 33.0);
    assert!((volume(&turned) - 6.0).abs() < 1e-12);
    let sphere = shapes::icosphere(DVec3::new(1.0, 2.0, 3.0), 2.0, 4);
    assert_closed(&sphere);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
    let ratio = volume(&sphere) / exact;
    assert!(ratio > 0.99 && ratio < 1.0, "{ratio}");
}

/// C-05 and C-07 rest on this: unit plates, distance 1, fronts towards each other, emission on the fronts only.
#[test]
fn plates_face_each_other() {
    let scene = closed::plates();
    let [far, near] = [0, 1].map(|i| &scene.meshes[i]);
    for (mesh, z) in [(far, -0.5), (near, 0.5)] {
        let area: DVec3 = area_vectors(mesh).iter().map(|(area, _)| *area).sum();
        assert_eq!(area, DVec3::new(0.0, 0.0, -2.0 * z), "{}", mesh.name);
        assert!(mesh.positions.iter().all(|p| p.z == z && p.x.abs() == 0.5 && p.y.abs() == 0.5));
    }
    assert!(!scene.materials[0].double_sided);
    assert!(scene.cameras.iter().all(|c| c.position == DVec3::ZERO && c.forward == glam::Vec3::NEG_Z));
}

/// N-21 needs the whole range of powers; power = pi * area * radiance.
#[test]
fn n21_many_lights_span_their_powers() {
    let scene = lamps::many_lights(1000, [-10.0, 10.0]);
    let mut exponents: Vec<f64> = scene.meshes[1..]
        .iter()
        .map(|mesh| {
            let area: f64 = area_vectors(mesh).iter().map(|(area, _)| area.length()).sum();
            let radiance = f64::from(scene.materials[mesh.material as usize].emission.x);
            (std::f64::consts::PI * area * radiance).log10()
        })
        .collect();
    exponents.sort_by(f64::total_cmp);
    assert_eq!(exponents.len(), 1000);
    assert!((exponents[0] + 10.0).abs() < 1e-5 && exponents[999] > 9.9 && exponents[999] < 10.0);
    let widest = exponents.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(widest < 0.1, "a gap of {widest} decades");
}

/// The two halves of the bumpy plane have the same normals: the map, decoded in its tangent frame, agrees with the
/// vertices of the other half at the same phase.
#[test]
fn bumpy_plane_halves_agree() {
    let scene = surfaces::bumpy_plane(1.2);
    let (left, right) = (&scene.meshes[0], &scene.meshes[1]);
    let normals = left.normals.as_ref().expect("left half has normals");
    let tilted = normals.iter().filter(|n| n.y < 0.7).count();
    assert!(tilted * 3 > normals.len(), "shading normals are far from the geometric one");

    let map = &scene.images[0];
    let uvs = right.uvs[0].as_ref().expect("right half has texture coordinates");
    let tangent = right.tangents.as_ref().expect("right half has tangents")[0];
    let (t, n) = (tangent.truncate(), right.normals.as_ref().expect("right half has normals")[0]);
    let b = n.cross(t) * tangent.w;
    let corner = |want: DVec3| right.positions.iter().position(|&p| p == want).expect("a corner");
    let (o, x, z) = (
        corner(DVec3::new(0.0, 0.0, -1.0)),
        corner(DVec3::new(1.0, 0.0, -1.0)),
        corner(DVec3::new(0.0, 0.0, 1.0)),
    );
    let mut checked = 0;
    for (position, expected) in left.positions.iter().zip(normals) {
        // One unit is a whole number of waves: the right half at x + 1 repeats the left half.
        let share = DVec3::new(position.x + 1.0, 0.0, (position.z + 1.0) / 2.0).as_vec3();
        let uv = uvs[o] + (uvs[x] - uvs[o]) * share.x + (uvs[z] - uvs[o]) * share.z;
        let texel = |c: f32, size: u32| ((c.rem_euclid(1.0) * size as f32) as u32).min(size - 1);
        let rgba = map.texels[(texel(uv.y, map.height) * map.width + texel(uv.x, map.width)) as usize];
        let [r, g, blue] = [rgba[0], rgba[1], rgba[2]].map(|v| f32::from(v) / 127.5 - 1.0);
        let normal = (t * r + b * g + n * blue).normalize();
        assert!(normal.dot(*expected) > 0.985, "{position}: {normal} against {expected}");
        checked += 1;
    }
    assert_eq!(checked, 97 * 49);
}
