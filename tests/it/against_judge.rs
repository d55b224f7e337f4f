//! The renderer's pictures against the judge's (C-08): every tile of every channel, by the variances that both report.

use halfway::integrator::View;
use halfway::render::{Budget, RenderOptions, Renderer};
use halfway::scene::Scene;
use halfway::scene::builtin::{builtin, lamps};

use crate::gpu;
use crate::reference::{Options, render};
use crate::stats::{FAMILY_ALPHA, normal_two_sided, sidak};

const TILE: u32 = 8;

/// Mean and variance of the mean of a tile.
#[derive(Clone, Copy, Default)]
struct Tile {
    mean: f64,
    variance: f64,
    pixels: f64,
}

impl Tile {
    /// Adds a pixel; the tile's mean is over the pixels added.
    fn push(&mut self, mean: f64, variance: f64) {
        let pixels = self.pixels + 1.0;
        let share = self.pixels / pixels;
        self.mean = self.mean * share + mean / pixels;
        self.variance = self.variance * share * share + variance / (pixels * pixels);
        self.pixels = pixels;
    }
}

/// Gathers pixels (mean, variance of the mean), row by row, into tiles; all pixels together are the last one.
fn tiles(pixels: impl Iterator<Item = (f64, f64)>, [width, height]: [u32; 2]) -> Vec<Tile> {
    let columns = width.div_ceil(TILE);
    let count = (columns * height.div_ceil(TILE)) as usize;
    let mut tiles = vec![Tile::default(); count + 1];
    for (index, (mean, variance)) in (0..).zip(pixels) {
        let tile = index / width / TILE * columns + index % width / TILE;
        tiles[tile as usize].push(mean, variance);
        tiles[count].push(mean, variance);
    }
    tiles
}

/// `samples`: per pixel, of the renderer and of the judge.
#[track_caller]
fn assert_agree(scene: &Scene, resolution: [u32; 2], samples: [u32; 2]) {
    let [width, height] = resolution;
    let budget = Budget { samples: Some(samples[0]), ..Budget::default() };
    let options =
        RenderOptions { view: View { width, height, ..View::default() }, budget, ..RenderOptions::default() };
    let mut renderer = Renderer::new(gpu::context(), scene, options).expect("a renderer for the scene");
    renderer.run(|_| false).expect("a render");
    let picture = renderer.picture().expect("a picture");
    assert_eq!(renderer.report().expect("a report").non_finite, 0);
    let variance = picture.layers.iter().find(|layer| layer.name == "variance").expect("a variance layer");

    let options = Options { resolution, samples: samples[1], max_scatterings: 128, ..Options::default() };
    let judged = render(scene, &scene.cameras[0], &options);

    let tiles_a_channel = (width.div_ceil(TILE) * height.div_ceil(TILE) + 1) as usize;
    let level = sidak(FAMILY_ALPHA, 3 * tiles_a_channel);
    for channel in 0..3 {
        let of_picture = picture.rgb.iter().zip(&variance.channels[channel].1);
        let of_picture = of_picture.map(|(rgb, variance)| (f64::from(rgb[channel]), f64::from(*variance)));
        let of_judge = judged.moments.iter().map(|pixel| {
            let moments = pixel[channel];
            (moments.mean, moments.variance() / moments.count as f64)
        });
        let (found, expected) = (tiles(of_picture, resolution), tiles(of_judge, resolution));
        let whole = (found[tiles_a_channel - 1], expected[tiles_a_channel - 1]);
        println!(
            "{}, channel {channel}: mean {:.6e}, ratio {:.6} +- {:.6}",
            scene.name,
            whole.0.mean,
            whole.0.mean / whole.1.mean,
            (whole.0.variance + whole.1.variance).sqrt() / whole.1.mean
        );
        for (tile, (found, expected)) in found.iter().zip(&expected).enumerate() {
            // f32 and its rounding of geometry, where there is no noise.
            let rounding = 1e-5 * expected.mean;
            let error = (found.variance + expected.variance + rounding * rounding).sqrt();
            let z = (found.mean - expected.mean) / error;
            assert!(
                error == 0.0 || normal_two_sided(z) > level,
                "{}, channel {channel}, tile {tile}: {:e} instead of {:e}, z = {z:.2}",
                scene.name,
                found.mean,
                expected.mean
            );
        }
    }
}

fn scene(name: &str) -> Scene {
    builtin(name).expect("a built-in scene")
}

#[test]
fn c08_cornell() {
    assert_agree(&scene("cornell"), [48, 48], [512, 128]);
}

#[test]
fn c08_door() {
    assert_agree(&scene("door"), [40, 30], [1024, 192]);
}

#[test]
fn c08_three_lights() {
    assert_agree(&scene("three-lights"), [48, 32], [512, 128]);
}

#[test]
fn c08_spheres() {
    assert_agree(&scene("spheres"), [56, 24], [512, 128]);
}

#[test]
fn c08_bumpy_plane() {
    assert_agree(&scene("bumpy-plane"), [48, 48], [512, 128]);
}

#[test]
fn c08_glass_slab() {
    assert_agree(&scene("glass-slab"), [48, 48], [512, 64]);
}

#[test]
fn c08_furnaces_and_plates() {
    for name in ["furnace-box", "furnace-sphere", "plates"] {
        assert_agree(&scene(name), [16, 16], [1024, 256]);
    }
}

/// Powers over twenty decades: the faintest lamps still light what only they light.
#[test]
fn c08_many_lights() {
    assert_agree(&lamps::many_lights(64, [-3.0, 3.0]), [32, 32], [1024, 256]);
}
