//! The naive bidirectional renderer: two sub-paths a sample, every way to join them as f/p times w, each from the
//! definitions and from nothing that the sub-paths were made with.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use halfway::scene::{Camera, LightKind, Scene};
use rayon::prelude::*;

use super::camera;
use super::geometry::Ray;
use super::path_space::{End, FullPath, Path, PathSpace, weights};
use super::picks::Lottery;
use super::random::Random;
use super::world::Point;
use crate::stats::Moments;

#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub resolution: [u32; 2],
    /// Passes over the picture, each an eye and a light sub-path per pixel.
    pub samples: u32,
    pub seed: u64,
    /// Scatterings a path may have; light seen directly has none.
    pub max_scatterings: usize,
    /// t = 1, by all light paths of a pass.
    pub light_tracing: bool,
    /// One strategy (s, t) alone.
    pub only: Option<(usize, usize)>,
    /// By the balance heuristic; otherwise every strategy counts in full.
    pub weighted: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            resolution: [16, 16],
            samples: 16,
            seed: 0,
            max_scatterings: 16,
            light_tracing: true,
            only: None,
            weighted: true,
        }
    }
}

/// A picture, row 0 at the top.
pub struct Render {
    /// Mean of each pixel's samples.
    pub mean: Vec<DVec3>,
    /// Statistics over a pixel's samples, by channel. A light path may reach many pixels: they are not independent.
    pub moments: Vec<[Moments; 3]>,
    /// The picture by number of scatterings; its sum is `mean`.
    pub by_scatterings: Vec<Vec<DVec3>>,
    max_vertices: usize,
    by_strategy: Vec<[Moments; 3]>,
}

impl Render {
    /// What a strategy found: the picture's mean by channel, statistics over passes.
    pub fn strategy(&self, s: usize, t: usize) -> &[Moments; 3] {
        &self.by_strategy[index_of(self.max_vertices, s, t)]
    }
}

fn index_of(max_vertices: usize, s: usize, t: usize) -> usize {
    s * (max_vertices + 1) + t
}

/// One strategy's find: where in the picture and how much.
struct Found {
    s: usize,
    t: usize,
    pixel: usize,
    value: DVec3,
}

/// Renders with a box filter of one pixel.
pub fn render_bidirectional(scene: &Scene, view: &Camera, options: &Options) -> Render {
    render_paths(&PathSpace::new(scene, view, options.resolution), options)
}

/// The same with numbers that are not the default.
pub fn render_paths(space: &PathSpace, options: &Options) -> Render {
    assert_eq!(space.resolution, options.resolution);
    let lottery = Lottery::new(&space.picks);
    let [width, height] = space.resolution;
    let pixels = (width * height) as usize;
    let max_vertices = options.max_scatterings + 2;
    let mut moments = vec![[Moments::default(); 3]; pixels];
    let mut by_strategy = vec![[Moments::default(); 3]; (max_vertices + 1).pow(2)];
    let mut by_scatterings = vec![vec![DVec3::ZERO; pixels]; options.max_scatterings + 1];
    for pass in 0..options.samples {
        let found: Vec<Vec<Found>> = (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                let mut found = Vec::new();
                sample(space, &lottery, options, pass, pixel, |one, _| found.push(one));
                found
            })
            .collect();
        let mut picture = vec![DVec3::ZERO; pixels];
        let mut sums = vec![DVec3::ZERO; by_strategy.len()];
        for Found { s, t, pixel, value } in found.into_iter().flatten() {
            picture[pixel] += value;
            by_scatterings[s + t - 2][pixel] += value / f64::from(options.samples);
            sums[index_of(max_vertices, s, t)] += value / pixels as f64;
        }
        moments.iter_mut().zip(picture).for_each(|(moments, value)| push(moments, value));
        by_strategy.iter_mut().zip(sums).for_each(|(moments, value)| push(moments, value));
    }
    Render {
        mean: moments.iter().map(|pixel| DVec3::from(pixel.map(|channel| channel.mean))).collect(),
        moments,
        by_scatterings,
        max_vertices,
        by_strategy,
    }
}

/// Full paths that carry light, found by all strategies, as many as the options' samples make.
pub fn trace_full_paths(space: &PathSpace, options: &Options) -> Vec<FullPath> {
    let pixels = (space.resolution[0] * space.resolution[1]) as usize;
    let lottery = Lottery::new(&space.picks);
    let mut paths = Vec::new();
    for pass in 0..options.samples {
        for pixel in 0..pixels {
            sample(space, &lottery, options, pass, pixel, |_, path| paths.push(path.frozen(space)));
        }
    }
    paths
}

fn push(moments: &mut [Moments; 3], value: DVec3) {
    moments.iter_mut().zip(value.to_array()).for_each(|(moments, value)| moments.push(value));
}

fn sample<'a>(
    space: &PathSpace<'a>,
    lottery: &Lottery,
    options: &Options,
    pass: u32,
    pixel: usize,
    mut visit: impl FnMut(Found, &Path),
) {
    let [width, height] = space.resolution;
    let pixels = (width * height) as usize;
    let mut random = Random::new(options.seed, u64::from(pass) * pixels as u64 + pixel as u64);
    let corner = DVec2::new((pixel % width as usize) as f64, (pixel / width as usize) as f64);
    let ray = camera::ray(&space.view, space.resolution, corner + random.uniform2());
    let limit = options.max_scatterings;
    // The last surface may be an emitter.
    let eye = walk(space, &mut random, ray, limit + 1, true);
    let light = light_subpath(space, lottery, &mut random, limit);
    let mut consider = |s: usize, t: usize, pixel: usize, path: &dyn Fn() -> Path<'a>| {
        if options.only.is_none_or(|only| only == (s, t)) && s + t <= limit + 2 {
            let path = path();
            if let Some(value) = value(space, options, &path, t) {
                visit(Found { s, t, pixel, value }, &path);
            }
        }
    };

    // s = 0: every surface may be an emitter, and what leaves the scene sees the environment.
    for (before, point) in eye.points.iter().enumerate() {
        let path = || space.path(ray.origin, eye.points[..before].to_vec(), End::Emitter(point.clone()));
        consider(0, before + 2, pixel, &path);
    }
    if let Some(direction) = eye.escaped {
        let path = || space.path(ray.origin, eye.points.clone(), End::Environment(direction));
        consider(0, eye.points.len() + 2, pixel, &path);
    }
    let Some((end, light)) = light else { return };
    let joined = |from_eye: &[Point<'a>], from_light: usize| -> Vec<Point<'a>> {
        from_eye.iter().chain(light[..from_light].iter().rev()).cloned().collect()
    };
    for s in 1..=light.len() + 1 {
        for t in 2..=eye.points.len() + 1 {
            consider(s, t, pixel, &|| {
                space.path(ray.origin, joined(&eye.points[..t - 1], s - 1), end.clone())
            });
        }
        let seen =
            if s > 1 { camera::project(&space.view, space.resolution, light[s - 2].position) } else { None };
        if let Some(seen) = seen.filter(|_| options.light_tracing) {
            let at = seen.pixel.floor();
            let size = DVec2::new(width.into(), height.into());
            if at.cmpge(DVec2::ZERO).all() && at.cmplt(size).all() {
                let pixel = at.y as usize * width as usize + at.x as usize;
                consider(s, 1, pixel, &|| space.path(seen.origin, joined(&[], s - 1), end.clone()));
            }
        }
    }
}

/// f/p of the strategy with `t` eye vertices, times its weight; `None` where that is nothing.
fn value(space: &PathSpace, options: &Options, path: &Path, t: usize) -> Option<DVec3> {
    let f = path.unoccluded(space);
    if f.is_zero() {
        return None;
    }
    let [width, height] = space.resolution.map(f64::from);
    let light_paths = if options.light_tracing { width * height } else { 0.0 };
    let strategies = path.densities(space).strategies(|_| 1.0, 1.0, light_paths);
    let ln_pdf = strategies[t - 1].ln_pdf;
    if ln_pdf == f64::NEG_INFINITY {
        return None;
    }
    // What the sub-paths went through, and which of their surfaces were there, is chance that p and f share. Left are the
    // edge that joins them, and the point drawn on the light.
    let through =
        if t > path.edges() { 1.0 } else { path.visibility(space, t - 1) * path.end_opacity(space) };
    if through == 0.0 {
        return None;
    }
    let weight = if options.weighted { weights(&strategies)[t - 1] } else { 1.0 };
    let value = f.over(ln_pdf) * (through * weight);
    assert!(value.is_finite(), "{value} for {:?}", path.frozen(space));
    Some(value)
}

/// Surfaces in the order in which they were found.
struct Walk<'a> {
    points: Vec<Point<'a>>,
    /// Where the walk left the scene.
    escaped: Option<DVec3>,
}

fn walk<'a>(
    space: &PathSpace<'a>,
    random: &mut Random,
    mut ray: Ray,
    limit: usize,
    from_eye: bool,
) -> Walk<'a> {
    let mut points = Vec::new();
    let mut row = 0;
    while points.len() < limit {
        let Some((_, point)) = space.world.trace(&ray, || random.uniform()) else {
            return Walk { points, escaped: Some(ray.direction) };
        };
        points.push(point.clone());
        let world_from = -ray.direction;
        if !point.scatters() || random.uniform() >= point.survival_after(row, space.caught_run) {
            break;
        }
        row = if point.bsdf.delta { row + 1 } else { 0 };
        let u = [(); 3].map(|()| random.uniform());
        let Some(sample) = point.sample(world_from, u, from_eye) else { break };
        ray = Ray { origin: point.position, direction: sample.w };
    }
    Walk { points, escaped: None }
}

/// The light's end and the surfaces that its light comes to.
fn light_subpath<'a>(
    space: &PathSpace<'a>,
    lottery: &Lottery,
    random: &mut Random,
    limit: usize,
) -> Option<(End<'a>, Vec<Point<'a>>)> {
    let end = lottery.draw(&space.world, random)?;
    let from_disc = |random: &mut Random, towards_light: DVec3| {
        let across = towards_light.any_orthonormal_vector();
        let u = random.uniform2();
        let (r, (sin, cos)) = (space.disc_radius * u.x.sqrt(), (TAU * u.y).sin_cos());
        let place = r * cos * across + r * sin * towards_light.cross(across);
        Ray {
            origin: space.centre + 2.0 * space.disc_radius * towards_light + place,
            direction: -towards_light,
        }
    };
    let ray = match &end {
        End::Emitter(point) => {
            let flip = point.material.double_sided && random.uniform() < 0.5;
            let front = if flip { -point.world_ng } else { point.world_ng };
            let r_sq = random.uniform();
            let direction = about(front, (1.0 - r_sq).sqrt(), random);
            Ray { origin: point.position, direction }
        }
        End::Environment(direction) => from_disc(random, direction.normalize()),
        End::Punctual(index) => {
            let light = &space.world.scene.lights[*index];
            let axis = light.direction.as_dvec3().normalize();
            let cos_widest = match light.kind {
                LightKind::Directional => 1.0,
                LightKind::Point => -1.0,
                LightKind::Spot { outer, .. } => f64::from(outer).cos(),
            };
            if light.kind == LightKind::Directional {
                from_disc(random, -axis)
            } else {
                let cos = 1.0 - random.uniform() * (1.0 - cos_widest);
                Ray { origin: light.position, direction: about(axis, cos, random) }
            }
        }
    };
    let points = walk(space, random, ray, limit, false).points;
    Some((end, points))
}

/// A direction at a given cosine to `axis`, the azimuth uniform.
fn about(axis: DVec3, cos: f64, random: &mut Random) -> DVec3 {
    let across = axis.any_orthonormal_vector();
    let (azimuth_sin, azimuth_cos) = (TAU * random.uniform()).sin_cos();
    let r = (1.0 - cos * cos).max(0.0).sqrt();
    (cos * axis + r * azimuth_cos * across + r * azimuth_sin * axis.cross(across)).normalize()
}
