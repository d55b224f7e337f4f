//! The public scenes beside the project against the references that come with them, where they are present.

use std::path::{Path, PathBuf};

use halfway::film::Picture;
use halfway::film::metric::{self, Comparison};
use halfway::film::tonemap::View;
use halfway::scene::gltf::{LoadOptions, load};

use crate::shots::{options, render};
use crate::stats::FAMILY_ALPHA;

/// The arrays of an `.npz` as NumPy's `savez` writes it: a ZIP archive of stored members, each a header with its
/// shape and then little-endian f32. Returns `img` and `var`, which come in that order.
fn arrays(bytes: &[u8]) -> [Vec<f32>; 2] {
    let mut starts = bytes.windows(6).enumerate().filter(|(_, window)| window == b"\x93NUMPY");
    let mut next = || {
        let (start, _) = starts.next().expect("an array");
        let length = usize::from(u16::from_le_bytes([bytes[start + 8], bytes[start + 9]]));
        let header = String::from_utf8_lossy(&bytes[start + 10..start + 10 + length]);
        assert!(header.contains("'descr': '<f4', 'fortran_order': False"), "{header}");
        let shape = header.split(['(', ')']).nth(1).expect("a shape");
        let count: usize = shape.split(',').filter_map(|n| n.trim().parse::<usize>().ok()).product();
        let data = &bytes[start + 10 + length..][..4 * count];
        data.as_chunks().0.iter().map(|&four| f32::from_le_bytes(four)).collect()
    };
    [next(), next()]
}

/// The reference with its variance.
fn reference(path: &Path, [width, height]: [u32; 2]) -> Picture {
    let [colors, variance] = arrays(&std::fs::read(path).expect("a reference beside its scene"));
    let mut picture = Picture::new(width, height, colors.as_chunks().0.to_vec());
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let samples = variance.iter().skip(channel).step_by(3).copied().collect();
        picture.push_channel("variance", name, samples);
    }
    picture
}

/// Renders a public scene at its own size and compares; `None` without the scene.
fn compare(name: &str, samples: u32) -> Option<Comparison> {
    let folder = std::env::var("HALFWAY_SCENES")
        .map_or_else(|_| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"), PathBuf::from);
    let path = folder.join(format!("{name}.glb"));
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    let scene = load(&path, &LoadOptions::default()).unwrap();
    let size = scene.resolution.expect("a resolution");
    let shot = render(&scene, options(size, samples));
    let reference = reference(&path.with_extension("ref.npz"), size);
    let comparison = metric::compare(&shot.picture, &reference, View::Srgb, 0.0).unwrap();
    println!(
        "{name}, {samples} spp in {:.1} s: {:?}, {:?}",
        shot.report.seconds, comparison.mean, comparison.tiles
    );
    Some(comparison)
}

#[test]
fn public_cornell_agrees_with_its_reference() {
    if let Some(comparison) = compare("cornell_diffuse", 64) {
        assert!((comparison.mean.ratio - 1.0).abs() < 0.01, "{:?}", comparison.mean);
        assert!(comparison.mean.z().expect("noise").abs() < 4.0, "{:?}", comparison.mean);
        let tiles = comparison.tiles.expect("variances");
        assert!(tiles.p_value > FAMILY_ALPHA, "{tiles:?}");
    }
}

/// Little light finds the way through this door in so few samples: the mean has to agree within its noise only.
#[test]
fn public_veach_ajar_agrees_with_its_reference() {
    if let Some(comparison) = compare("veach_ajar_diffuse", 32) {
        assert!((comparison.mean.ratio - 1.0).abs() < 0.2, "{:?}", comparison.mean);
        assert!(comparison.mean.z().expect("noise").abs() < 5.0, "{:?}", comparison.mean);
    }
}
