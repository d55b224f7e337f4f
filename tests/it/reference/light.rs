//! Lights, and drawing points on them.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use halfway::scene::{Environment, LightKind, Material, PunctualLight, Scene};

/// Triangles that emit, and the environment. Punctual lights are summed, not drawn.
pub struct Lights {
    emitters: Distribution,
    corners: Vec<[DVec3; 3]>,
    /// Triangle of the tree of every emitter, and the other way round.
    triangles: Vec<usize>,
    emitter_of: Vec<Option<usize>>,
    pub sky: Option<Sky>,
}

impl Lights {
    pub fn new<'a>(scene: &Scene, corners: &[[DVec3; 3]], material: impl Fn(usize) -> &'a Material) -> Self {
        let brightness = |triangle: usize| {
            let material = material(triangle);
            f64::from((if material.unlit { material.base_color } else { material.emission }).max_element())
        };
        let triangles: Vec<usize> = (0..corners.len()).filter(|&t| brightness(t) > 0.0).collect();
        let weights = triangles.iter().map(|&t| brightness(t) * area_of(&corners[t])).collect();
        let mut emitter_of = vec![None; corners.len()];
        for (emitter, &triangle) in triangles.iter().enumerate() {
            emitter_of[triangle] = Some(emitter);
        }
        Self {
            emitters: Distribution::new(weights),
            corners: triangles.iter().map(|&t| corners[t]).collect(),
            triangles,
            emitter_of,
            sky: scene.environment.as_ref().and_then(Sky::new),
        }
    }

    /// A triangle and the barycentrics of its second and third corner; `None` without emitters.
    pub fn draw_emitter(&self, u: f64, v: DVec2) -> Option<(usize, [f64; 2])> {
        let emitter = self.emitters.draw(u)?;
        let root = v.x.sqrt();
        Some((self.triangles[emitter], [root * (1.0 - v.y), root * v.y]))
    }

    /// Density per area of [`Self::draw_emitter`], 0 where nothing emits.
    pub fn pdf_area(&self, triangle: usize) -> f64 {
        self.emitter_of[triangle]
            .map_or(0.0, |emitter| self.emitters.probability(emitter) / area_of(&self.corners[emitter]))
    }
}

pub(super) fn area_of([a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

/// Irradiance on a plane across the light's direction at `point`, the unit direction towards the light, and the
/// distance to it.
pub fn punctual(light: &PunctualLight, point: DVec3) -> (DVec3, DVec3, f64) {
    let intensity = light.intensity.as_dvec3();
    let axis = light.direction.as_dvec3();
    if light.kind == LightKind::Directional {
        return (intensity, -axis, f64::INFINITY);
    }
    let to_light = light.position - point;
    let distance = to_light.length();
    let direction = to_light / distance;
    let falloff = match light.kind {
        LightKind::Spot { inner, outer } => {
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            ((axis.dot(-direction) - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2)
        }
        _ => 1.0,
    };
    (intensity * falloff / (distance * distance), direction, distance)
}

/// The environment: half of the directions are drawn by its texels' power, half uniformly.
pub struct Sky {
    environment: Environment,
    texels: Distribution,
}

impl Sky {
    /// `None` where it is black.
    fn new(environment: &Environment) -> Option<Self> {
        let weight = |index: usize| {
            let [r, g, b] = environment.texels[index].map(f64::from);
            (r + g + b) * row_solid_angle(environment.height, index / environment.width as usize)
        };
        let texels = Distribution::new((0..environment.texels.len()).map(weight).collect());
        (texels.total() * f64::from(environment.scale) > 0.0)
            .then(|| Self { environment: environment.clone(), texels })
    }

    /// Radiance from a direction: bilinear between texel centres, see [`Environment`].
    pub fn radiance(&self, world: DVec3) -> DVec3 {
        let [u, v] = self.coordinates(world);
        let (width, height) = (i64::from(self.environment.width), i64::from(self.environment.height));
        let texel = |column: i64, row: i64| {
            let row = row.clamp(0, height - 1);
            let index = row * width + column.rem_euclid(width);
            DVec3::from(self.environment.texels[index as usize].map(f64::from))
        };
        let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
        let (column, row) = (x.floor() as i64, y.floor() as i64);
        let along = |row: i64| texel(column, row).lerp(texel(column + 1, row), x - x.floor());
        along(row).lerp(along(row + 1), y - y.floor()) * f64::from(self.environment.scale)
    }

    pub fn draw(&self, u: f64, v: DVec2) -> DVec3 {
        if u < 0.5 {
            let z = 1.0 - 2.0 * v.x;
            let (sin, cos) = (TAU * v.y).sin_cos();
            let r = (1.0 - z * z).sqrt();
            return DVec3::new(r * cos, z, r * sin);
        }
        let texel = self.texels.draw(2.0 * u - 1.0).expect("the sky is not black");
        let (column, row) =
            (texel % self.environment.width as usize, texel / self.environment.width as usize);
        let height = f64::from(self.environment.height);
        let [top, bottom] = [row, row + 1].map(|edge| (PI * edge as f64 / height).cos());
        let y = top + (bottom - top) * v.y;
        let azimuth = TAU * ((column as f64 + v.x) / f64::from(self.environment.width) - 0.5)
            - f64::from(self.environment.rotation);
        let r = (1.0 - y * y).max(0.0).sqrt();
        DVec3::new(r * azimuth.sin(), y, -r * azimuth.cos())
    }

    pub fn pdf_solid(&self, world: DVec3) -> f64 {
        let [u, v] = self.coordinates(world);
        let (width, height) = (self.environment.width as usize, self.environment.height as usize);
        let column = ((u * width as f64) as usize).min(width - 1);
        let row = ((v * height as f64) as usize).min(height - 1);
        let solid_angle = row_solid_angle(self.environment.height, row) / width as f64;
        0.5 / (4.0 * PI) + 0.5 * self.texels.probability(row * width + column) / solid_angle
    }

    /// Picture coordinates in [0, 1]: the middle looks along -z, u = 3/4 along +x, v = 0 is +y.
    fn coordinates(&self, world: DVec3) -> [f64; 2] {
        let azimuth = world.x.atan2(-world.z) + f64::from(self.environment.rotation);
        let polar = world.x.hypot(world.z).atan2(world.y);
        [(azimuth / TAU + 0.5).rem_euclid(1.0), polar / PI]
    }
}

/// Solid angle of a whole row of texels.
fn row_solid_angle(height: u32, row: usize) -> f64 {
    let edge = |row: usize| (PI * row as f64 / f64::from(height)).cos();
    TAU * (edge(row) - edge(row + 1))
}

/// A discrete distribution by running sums and bisection.
struct Distribution {
    sums: Vec<f64>,
}

impl Distribution {
    fn new(weights: Vec<f64>) -> Self {
        let running = weights.into_iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        Self { sums: running.collect() }
    }

    fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    fn draw(&self, u: f64) -> Option<usize> {
        let target = u * self.total();
        let index = self.sums.partition_point(|&sum| sum <= target);
        (index < self.sums.len()).then_some(index)
    }

    fn probability(&self, index: usize) -> f64 {
        let before = if index == 0 { 0.0 } else { self.sums[index - 1] };
        (self.sums[index] - before) / self.total()
    }
}
