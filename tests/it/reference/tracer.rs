//! The path tracer.

use glam::{DVec2, DVec3};
use halfway::scene::{Camera, Material, Scene};
use rayon::prelude::*;

use super::camera;
use super::geometry::{Hit, Ray};
use super::light::punctual;
use super::random::Random;
use super::world::{Point, World};
use crate::stats::Moments;

#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub resolution: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    pub seed: u64,
    /// Scatterings a path may have; light seen directly has none.
    pub max_scatterings: usize,
    /// Draw points on lights too. Without, directions drawn from the BSDF alone find lights, and never punctual ones.
    pub connect: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { resolution: [16, 16], samples: 16, seed: 0, max_scatterings: 16, connect: true }
    }
}

/// A picture, row 0 at the top.
pub struct Render {
    /// Mean of each pixel's samples.
    pub mean: Vec<DVec3>,
    /// Statistics over a pixel's samples, by channel.
    pub moments: Vec<[Moments; 3]>,
    /// The picture by number of scatterings; its sum is `mean`.
    pub by_scatterings: Vec<Vec<DVec3>>,
}

impl Render {
    /// Statistics over the samples of all pixels of one channel.
    pub fn channel(&self, channel: usize) -> Moments {
        self.moments.iter().fold(Moments::default(), |all, pixel| all.merge(pixel[channel]))
    }

    /// Mean grey value of light scattered `scatterings` times.
    pub fn grey_of(&self, scatterings: usize) -> f64 {
        let picture = &self.by_scatterings[scatterings];
        picture.iter().map(|pixel| pixel.element_sum() / 3.0).sum::<f64>() / picture.len() as f64
    }
}

/// Renders with a box filter of one pixel.
pub fn render(scene: &Scene, view: &Camera, options: &Options) -> Render {
    let world = World::new(scene);
    let [width, height] = options.resolution;
    let pixels: Vec<(Vec<DVec3>, [Moments; 3])> = (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let mut random = Random::new(options.seed, u64::from(pixel));
            let mut sums = vec![DVec3::ZERO; options.max_scatterings + 1];
            let mut moments = [Moments::default(); 3];
            let corner = DVec2::new(f64::from(pixel % width), f64::from(pixel / width));
            for _ in 0..options.samples {
                let ray = camera::ray(view, options.resolution, corner + random.uniform2());
                let mut path = Path {
                    world: &world,
                    random: &mut random,
                    connect: options.connect,
                    found: vec![DVec3::ZERO; sums.len()],
                };
                path.trace(ray);
                let light: DVec3 = path.found.iter().sum();
                moments.iter_mut().zip(light.to_array()).for_each(|(moments, light)| moments.push(light));
                sums.iter_mut().zip(path.found).for_each(|(sum, light)| *sum += light);
            }
            (sums.into_iter().map(|sum| sum / f64::from(options.samples)).collect(), moments)
        })
        .collect();
    Render {
        mean: pixels.iter().map(|(by_scatterings, _)| by_scatterings.iter().sum()).collect(),
        moments: pixels.iter().map(|(_, moments)| *moments).collect(),
        by_scatterings: (0..=options.max_scatterings)
            .map(|k| pixels.iter().map(|(by_scatterings, _)| by_scatterings[k]).collect())
            .collect(),
    }
}

struct Path<'a, 'w> {
    world: &'a World<'w>,
    random: &'a mut Random,
    connect: bool,
    /// Light by number of scatterings.
    found: Vec<DVec3>,
}

/// The last vertex before the current ray, as far as weights need it.
struct Origin {
    position: DVec3,
    /// Density (solid angle, roulette included) of the ray's direction; `None` where only this ray can find a light:
    /// from the camera, after delta events, without connections.
    pdf_solid: Option<f64>,
}

impl<'w> Path<'_, 'w> {
    fn trace(&mut self, mut ray: Ray) {
        let mut origin = Origin { position: ray.origin, pdf_solid: None };
        let mut throughput = DVec3::ONE;
        let mut medium: Option<&Material> = None;
        for scatterings in 0.. {
            let draw = || self.random.uniform();
            let Some((distance, point)) = self.world.trace(&ray, draw) else {
                self.add_sky(scatterings, throughput, &origin, &ray);
                return;
            };
            throughput *= transmittance(medium, distance);
            self.add_emission(scatterings, throughput, &origin, &point, ray.direction);
            if scatterings + 1 == self.found.len() || !point.scatters() {
                return;
            }
            let world_eye = -ray.direction;
            self.add_connections(scatterings + 1, throughput, &point, world_eye, medium);

            let q = point.roulette();
            if self.random.uniform() >= q {
                return;
            }
            let u = [(); 3].map(|()| self.random.uniform());
            let Some(sample) = point.sample(world_eye, u, true) else { return };
            let direction = sample.w;
            throughput *= sample.weight / q;
            if throughput == DVec3::ZERO {
                return;
            }
            if point.material.volume && point.world_ng.dot(direction) * point.world_ng.dot(world_eye) < 0.0 {
                medium = (point.world_ng.dot(direction) < 0.0).then_some(point.material);
            }
            origin = Origin {
                position: point.position,
                pdf_solid: (self.connect && !point.bsdf.delta).then_some(sample.pdf * q),
            };
            ray = Ray { origin: point.position, direction };
        }
    }

    /// Emission of the surface that the path came to.
    fn add_emission(
        &mut self,
        scatterings: usize,
        throughput: DVec3,
        origin: &Origin,
        point: &Point,
        along: DVec3,
    ) {
        let emitted = point.emitted(-along);
        if emitted == DVec3::ZERO {
            return;
        }
        let weight = origin.pdf_solid.map_or(1.0, |pdf_solid| {
            let distance_sq = (point.position - origin.position).length_squared();
            let pdf_area = pdf_solid * point.world_ng.dot(along).abs() / distance_sq;
            pdf_area / (pdf_area + self.world.lights.pdf_area(point.triangle))
        });
        self.found[scatterings] += throughput * emitted * weight;
    }

    /// The sky behind everything.
    fn add_sky(&mut self, scatterings: usize, throughput: DVec3, origin: &Origin, ray: &Ray) {
        let Some(sky) = &self.world.lights.sky else { return };
        let weight =
            origin.pdf_solid.map_or(1.0, |pdf_solid| pdf_solid / (pdf_solid + sky.pdf_solid(ray.direction)));
        self.found[scatterings] += throughput * sky.radiance(ray.direction) * weight;
    }

    /// One point of the emitters, one direction of the sky, and all punctual lights, as they light the point.
    fn add_connections(
        &mut self,
        scatterings: usize,
        throughput: DVec3,
        point: &Point<'w>,
        world_eye: DVec3,
        medium: Option<&Material>,
    ) {
        if !self.connect || point.bsdf.delta {
            return;
        }
        let (world, q) = (self.world, point.roulette());
        let pdf_bsdf = |direction: DVec3| q * point.scatter_pdf(world_eye, direction);
        let lit = |direction: DVec3, distance: f64, light: DVec3| {
            let scattered = point.scattered(world_eye, direction) * light;
            if scattered == DVec3::ZERO {
                return DVec3::ZERO;
            }
            let visible = world.visibility(point.position, direction, distance);
            throughput * scattered * visible * transmittance(medium, distance)
        };
        if let Some((triangle, b)) = world.lights.draw_emitter(self.random.uniform(), self.random.uniform2())
        {
            let light = world.point(&Hit { distance: 0.0, triangle, b });
            let to_light = light.position - point.position;
            let distance = to_light.length();
            let direction = to_light / distance;
            let cos_light = light.world_ng.dot(direction).abs();
            let per_area = cos_light / (distance * distance);
            let pdf_area = world.lights.pdf_area(triangle) + pdf_bsdf(direction) * per_area;
            if distance > 0.0 && cos_light > 0.0 {
                let share = opacity(world, triangle, b) * per_area / pdf_area;
                self.found[scatterings] += lit(direction, distance, light.emitted(-direction) * share);
            }
        }
        if let Some(sky) = &world.lights.sky {
            let direction = sky.draw(self.random.uniform(), self.random.uniform2());
            let pdf_solid = sky.pdf_solid(direction) + pdf_bsdf(direction);
            self.found[scatterings] += lit(direction, f64::INFINITY, sky.radiance(direction) / pdf_solid);
        }
        for light in &world.scene.lights {
            let (irradiance, direction, distance) = punctual(light, point.position);
            self.found[scatterings] += lit(direction, distance, irradiance);
        }
    }
}

/// Probability that the drawn point of an emitter is there.
fn opacity(world: &World, triangle: usize, b: [f64; 2]) -> f64 {
    world.opacity(&Hit { distance: 0.0, triangle, b })
}

/// Beer and Lambert's law inside a volume; infinitely far, only what absorbs nothing passes.
pub(super) fn transmittance(medium: Option<&Material>, distance: f64) -> DVec3 {
    let Some(medium) = medium else { return DVec3::ONE };
    let reach = f64::from(medium.attenuation_distance);
    if reach.is_infinite() {
        return DVec3::ONE;
    }
    let color = medium.attenuation_color.as_dvec3();
    DVec3::new(color.x.powf(distance / reach), color.y.powf(distance / reach), color.z.powf(distance / reach))
}
