//! The public scenes beside the project against the references that come with them, where they are present.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use halfway::film::Picture;
use halfway::film::metric::{self, Comparison};
use halfway::film::tonemap::ViewTransform;
use halfway::integrator::{Bdpt, LvcBpt, Method, SpcBpt};
use halfway::render::RenderOptions;
use halfway::scene::Scene;
use halfway::scene::gltf::{LoadOptions, load};
use halfway::subspace::Settings;
use halfway::training::Training;

use crate::bidirectional::renders;
use crate::shots::{options, render};
use crate::stats::{FAMILY_ALPHA, Moments, student_two_sided, tile_means};

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

/// A public scene with its reference.
struct Public {
    scene: Scene,
    size: [u32; 2],
    reference: Picture,
}

impl Public {
    /// `None` without the scene.
    fn load(name: &str) -> Option<Self> {
        let folder = std::env::var("HALFWAY_SCENES")
            .map_or_else(|_| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes"), PathBuf::from);
        let path = folder.join(format!("{name}.glb"));
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            return None;
        }
        let scene = load(&path, &LoadOptions::default()).unwrap();
        let size = scene.resolution.expect("a resolution");
        let reference = reference(&path.with_extension("ref.npz"), size);
        Some(Self { scene, size, reference })
    }

    /// A render at the scene's own size against the reference. For integrators whose pixels are independent.
    fn compare(&self, method: Method, samples: u32) -> Comparison {
        let shot = render(&self.scene, RenderOptions { method, ..options(self.size, samples) });
        let comparison = metric::compare(&shot.picture, &self.reference, ViewTransform::Srgb, 0.0).unwrap();
        println!(
            "{method:?}, {samples} spp in {:.1} s: {:?}, {:?}",
            shot.report.seconds, comparison.mean, comparison.tiles
        );
        comparison
    }

    /// Independent renders against the reference, for integrators whose pixels share light paths: what they share is
    /// in the spread of the means. The ratio of the means with its standard error, and the probability that noise
    /// alone brings any tile so far off.
    fn compare_runs(&self, method: Method, samples: u32, runs: u64) -> ([f64; 2], f64) {
        let options = RenderOptions { method, training: quick_training(), ..options(self.size, samples) };
        let pictures = renders(&self.scene, &options, 0..runs);
        let pixels = self.reference.rgb.len();
        let layers = ["R", "G", "B"].map(|c| self.reference.channel("variance", c).expect("a variance"));
        // Channels of a pixel come from the same paths: taken as fully correlated.
        let variance = |pixel: usize| {
            (layers.iter().map(|layer| f64::from(layer[pixel]).sqrt()).sum::<f64>() / 3.0).powi(2)
        };
        let noise: Vec<DVec3> = (0..pixels).map(|pixel| DVec3::splat(variance(pixel))).collect();
        let grey: Vec<DVec3> = self.reference.rgb.iter().map(|&rgb| Vec3::from(rgb).as_dvec3()).collect();
        let means = |edge: u32| -> (Vec<Moments>, Vec<[f64; 2]>) {
            let expected = tile_means(&grey, self.size, edge);
            let noise = tile_means(&noise, self.size, edge);
            let columns = self.size[0].div_ceil(edge);
            let pixels = |tile: usize| {
                let [x, y] = [tile as u32 % columns * edge, tile as u32 / columns * edge];
                f64::from((self.size[0] - x).min(edge) * (self.size[1] - y).min(edge))
            };
            let known =
                (0..expected.len()).map(|tile| [expected[tile], noise[tile] / pixels(tile)]).collect();
            let mut found = vec![Moments::default(); expected.len()];
            for picture in &pictures {
                let values = tile_means(picture, self.size, edge);
                found.iter_mut().zip(values).for_each(|(moments, value)| moments.push(value));
            }
            (found, known)
        };
        let (found, known) = means(u32::MAX);
        let [expected, noise] = known[0];
        let mean = [found[0].mean / expected, found[0].standard_error().hypot(noise.sqrt()) / expected];
        let (found, known) = means(metric::TILE);
        let worst = found.iter().zip(&known).map(|(found, [expected, noise])| {
            // Welch and Satterthwaite; the reference's variance counts as known.
            let own = found.standard_error().powi(2);
            let t = (found.mean - expected) / (own + noise).sqrt();
            let degrees = (found.count - 1) as f64 * ((own + noise) / own).powi(2);
            if t == 0.0 { 1.0 } else { student_two_sided(t, degrees.min(1e6)) }
        });
        let worst = worst.fold(1.0, f64::min);
        let p_value = -(found.len() as f64 * (-worst).ln_1p()).exp_m1();
        println!(
            "{method:?}, {runs} x {samples} spp: {:.5} +- {:.5}, tiles' p {p_value:.1e}",
            mean[0], mean[1]
        );
        (mean, p_value)
    }
}

/// Few paths teach enough for pictures of a few samples.
fn quick_training() -> Training {
    Training { paths: Some(20_000), settings: Settings::default(), ..Training::default() }
}

const SPCBPT: Method = Method::SpcBpt(SpcBpt {
    light_paths: Some(4000),
    connections: SpcBpt::CONNECTIONS,
    light_tracing: false,
});
const BDPT: Method = Method::Bdpt(Bdpt { light_tracing: false });
const LVCBPT: Method =
    Method::LvcBpt(LvcBpt { light_paths: None, connections: LvcBpt::CONNECTIONS, light_tracing: false });

fn assert_cornell(comparison: &Comparison) {
    assert!((comparison.mean.ratio - 1.0).abs() < 0.01, "{:?}", comparison.mean);
    assert!(comparison.mean.z().expect("noise").abs() < 4.0, "{:?}", comparison.mean);
    let tiles = comparison.tiles.expect("variances");
    assert!(tiles.p_value > FAMILY_ALPHA, "{tiles:?}");
}

#[test]
fn public_cornell_agrees_with_its_reference() {
    if let Some(public) = Public::load("cornell_diffuse") {
        assert_cornell(&public.compare(Method::Path, 64));
    }
}

#[test]
fn public_cornell_by_bdpt() {
    if let Some(public) = Public::load("cornell_diffuse") {
        assert_cornell(&public.compare(BDPT, 32));
    }
}

#[track_caller]
fn assert_cornell_runs(method: Method) {
    if let Some(public) = Public::load("cornell_diffuse") {
        let ([ratio, error], p_value) = public.compare_runs(method, 4, 16);
        assert!((ratio - 1.0).abs() < 0.01 && (ratio - 1.0).abs() < 4.0 * error, "{ratio} +- {error}");
        assert!(p_value > FAMILY_ALPHA, "{p_value}");
    }
}

#[test]
fn public_cornell_by_lvcbpt() {
    assert_cornell_runs(LVCBPT);
}

#[test]
fn public_cornell_by_spcbpt() {
    assert_cornell_runs(SPCBPT);
}

/// Little light finds the way through this door in so few samples: the mean has to agree within its noise only.
fn assert_door(ratio: f64, z: f64) {
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
    assert!(z.abs() < 5.0, "{ratio}, z = {z}");
}

#[test]
fn public_veach_ajar_agrees_with_its_reference() {
    if let Some(public) = Public::load("veach_ajar_diffuse") {
        let comparison = public.compare(Method::Path, 32);
        assert_door(comparison.mean.ratio, comparison.mean.z().expect("noise"));
    }
}

#[test]
fn public_veach_ajar_by_bdpt() {
    if let Some(public) = Public::load("veach_ajar_diffuse") {
        let comparison = public.compare(BDPT, 10);
        assert_door(comparison.mean.ratio, comparison.mean.z().expect("noise"));
    }
}

#[test]
fn public_veach_ajar_by_lvcbpt() {
    if let Some(public) = Public::load("veach_ajar_diffuse") {
        let ([ratio, error], _) = public.compare_runs(LVCBPT, 2, 12);
        assert_door(ratio, (ratio - 1.0) / error);
    }
}

#[test]
fn public_veach_ajar_by_spcbpt() {
    if let Some(public) = Public::load("veach_ajar_diffuse") {
        let ([ratio, error], _) = public.compare_runs(SPCBPT, 2, 12);
        assert_door(ratio, (ratio - 1.0) / error);
    }
}
