//! The glTF loader on files that are right.

use std::path::Path;

use halfway::scene::gltf::{LoadOptions, load};

/// The public scenes beside the project, where they are present.
#[test]
fn public_scenes_load() {
    let folder = std::env::var("HALFWAY_SCENES").map_or_else(
        |_| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"),
        |folder| folder.into(),
    );
    let expected = [("cornell_diffuse", 36), ("veach_ajar_diffuse", 23_444), ("veach_ajar_full", 23_444)];
    for (name, triangles) in expected {
        let path = folder.join(name).with_extension("glb");
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let scene = load(&path, &LoadOptions::default()).unwrap();
        println!(
            "{name}: {} triangles, {} meshes, {} materials, {} images, {:?}, {:?}",
            scene.triangle_count(),
            scene.meshes.len(),
            scene.materials.len(),
            scene.images.len(),
            scene.resolution,
            scene.warnings
        );
        assert_eq!(scene.triangle_count(), triangles);
        assert_eq!(scene.cameras.len(), 1);
        assert!(scene.resolution.is_some());
        let emissive = scene
            .meshes
            .iter()
            .filter(|mesh| scene.materials[mesh.material as usize].emission.max_element() > 0.0);
        assert_eq!(emissive.map(|mesh| mesh.triangles.len()).sum::<usize>(), 2);
    }
}
