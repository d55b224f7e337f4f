//! Pictures of the renderer for tests, and what can be said about their means.

use halfway::device::layout::FilmPixel;
use halfway::device::{BufferTable, Context, Kernel};
use halfway::film::tonemap::ViewTransform;
use halfway::film::{Picture, metric};
use halfway::integrator::View;
use halfway::render::{Budget, RenderError, RenderOptions, Renderer, Report, pixel_sums};
use halfway::scene::Scene;

use crate::gpu;
use crate::stats::FAMILY_ALPHA;

/// A picture with the report of its making.
pub struct Shot {
    pub picture: Picture,
    pub report: Report,
}

/// A mean with its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    pub error: f64,
}

/// A picture of `size` pixels, `samples` samples each, of the scene's first camera.
pub fn options([width, height]: [u32; 2], samples: u32) -> RenderOptions {
    let budget = Budget { samples: Some(samples), ..Budget::default() };
    RenderOptions { view: View { width, height, ..View::default() }, budget, ..RenderOptions::default() }
}

/// Renders; no sample of any test may be other than finite.
pub fn try_render(scene: &Scene, options: RenderOptions) -> Result<Shot, RenderError> {
    try_render_on(gpu::context(), scene, options)
}

/// As [`try_render`], on another device.
pub fn try_render_on(context: &Context, scene: &Scene, options: RenderOptions) -> Result<Shot, RenderError> {
    let mut renderer = Renderer::new(context, scene, options)?;
    renderer.run(|_| false)?;
    let shot = Shot { picture: renderer.picture()?, report: renderer.report()? };
    assert_eq!(shot.report.non_finite, 0, "{}: samples that are not finite", scene.name);
    Ok(shot)
}

/// Renders what must render.
#[track_caller]
pub fn render(scene: &Scene, options: RenderOptions) -> Shot {
    try_render(scene, options).unwrap()
}

impl Shot {
    /// Mean of one channel over the whole picture.
    pub fn channel(&self, channel: usize) -> Estimate {
        self.part(channel, [0, 0], [self.picture.width, self.picture.height])
    }

    /// Mean of one channel over the pixels from `first` (column, row) on, `size` of them.
    pub fn part(&self, channel: usize, first: [u32; 2], size: [u32; 2]) -> Estimate {
        let variance = self.picture.variance().expect("a variance layer");
        let (mut sum, mut noise) = (0.0, 0.0);
        for row in first[1]..first[1] + size[1] {
            for column in first[0]..first[0] + size[0] {
                let pixel = (row * self.picture.width + column) as usize;
                sum += f64::from(self.picture.rgb[pixel][channel]);
                noise += variance.at(channel, pixel);
            }
        }
        let count = f64::from(size[0] * size[1]);
        Estimate { mean: sum / count, error: noise.sqrt() / count }
    }
}

impl Estimate {
    /// Asserts that the mean is `expected` within five standard errors and the rounding of f32, and that the standard
    /// error is at most `max_relative_error` of it: a test that cannot see a fault must not pass.
    #[track_caller]
    pub fn assert_mean(self, what: &str, expected: f64, max_relative_error: f64) {
        let Self { mean, error } = self;
        println!("{what}: {mean:.7e} +- {error:.1e}, expected {expected:.7e}");
        assert!(
            error <= max_relative_error * expected,
            "{what}: standard error {error:e} is too large to judge {expected:e}"
        );
        let tolerance = 5.0 * error + 1e-5 * expected;
        assert!(
            (mean - expected).abs() <= tolerance,
            "{what}: {mean:e} +- {error:.1e} instead of {expected:e}"
        );
    }

    /// How many standard errors two independent means are apart.
    pub fn z(self, other: Self) -> f64 {
        (self.mean - other.mean) / (self.error * self.error + other.error * other.error).sqrt()
    }
}

/// Asserts that noise explains the difference of two pictures from independent samples: every 8x8 tile of every
/// channel, and the mean.
#[track_caller]
pub fn assert_same_light(what: &str, picture: &Picture, reference: &Picture) {
    let comparison = metric::compare(picture, reference, ViewTransform::Srgb, 0.0).unwrap();
    let tiles = comparison.tiles.expect("variance layers");
    let z = comparison.mean.z().expect("noise");
    println!(
        "{what}: mean ratio {:.5}, z = {z:.2}; worst tile z = {:.2}, p = {:.2e}",
        comparison.mean.ratio, tiles.worst_z, tiles.p_value
    );
    assert!(tiles.p_value > FAMILY_ALPHA, "{what}: {tiles:?}");
    assert!(z.abs() < 5.0, "{what}: {:?}", comparison.mean);
}

/// Samples that are not finite are counted and stay out of the sums, whatever is wrong with them.
#[test]
fn r09_non_finite_samples_are_counted_and_left_out() {
    let context = gpu::context();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -f32::NAN];
    // Two pixels, five samples: one bad value in a channel of each of the first pixel's last four samples.
    let mut radiance = [[0.25f32, 0.5, 1.0, 0.0]; 10];
    for (i, bad) in bad.into_iter().enumerate() {
        radiance[2 * (i + 1)][i % 3] = bad;
    }
    let batch = halfway::device::layout::Batch {
        width: 2,
        height: 1,
        crop_width: 2,
        crop_stride: 1,
        pixel_count: 2,
        sample_count: 5,
        max_depth: 1,
        ..Default::default()
    };
    let mut buffers = BufferTable::default();
    buffers.upload(context, "radiance", &radiance).unwrap();
    buffers.upload_uniform(context, "batch", &[batch]).unwrap();
    let bytes = 2 * size_of::<FilmPixel>() as u64;
    buffers.create(context, "film", bytes).unwrap();
    let kernel = Kernel::new(context, "film_accumulate", Default::default(), &[]).unwrap();
    let bound = kernel.bind(context, &buffers).unwrap();
    let mut encoder = context.device.create_command_encoder(&Default::default());
    bound.dispatch(&mut encoder.begin_compute_pass(&Default::default()), 2);
    context.queue.submit([encoder.finish()]);
    let film: Vec<FilmPixel> = buffers.read_elements(context, "film", 2).unwrap();
    let film: Vec<_> = film.iter().map(pixel_sums).collect();
    assert_eq!((film[0].count, film[0].non_finite), (1, 4));
    assert_eq!(film[0].sum, [0.25, 0.5, 1.0]);
    assert_eq!((film[1].count, film[1].non_finite), (5, 0));
    assert_eq!(film[1].sum, [1.25, 2.5, 5.0]);
}
