//! The built-in scenes are what their descriptions say.

use std::collections::HashMap;

use glam::DVec3;
use halfway::scene::builtin::{builtin, closed, names};
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
    for name in names() {
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
}
