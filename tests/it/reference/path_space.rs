//! Path space: f, p and w of full paths, from the definitions.
//!
//! A full path is x_0 (camera), x_1 .. x_{n-1} (surfaces), x_n (the light's end). Strategy (s, t) makes t vertices from
//! the camera and s = n + 1 - t from the light; s = 0 is a camera path that finds a light, t = 1 a light path that is
//! seen by the camera, and all others connect x_{t-1} to x_t. Densities are per area; per solid angle where x_n is
//! a direction of the environment; probabilities where it is a punctual light. They follow from the positions of the
//! vertices and from geometric normals, and contain roulette. Neither they nor the weights know about visibility and
//! opacity, which f has.
//!
//! Products of densities leave the range of f64 in small scenes: everything is kept as natural logarithms.

use std::f64::consts::PI;

use glam::DVec3;
use halfway::scene::{Camera, LightKind, Material, Projection, Scene};

use super::camera;
use super::geometry::Hit;
use super::light::punctual;
use super::picks::{Picks, emission_pdf_solid};
use super::tracer::transmittance;
use super::world::{Point, World};
use crate::bsdf_f64::Sample;

/// A vertex on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceVertex {
    pub position: DVec3,
    /// Triangle of the judge's tree.
    pub triangle: usize,
    /// Mesh of the scene and triangle of the mesh.
    pub scene_triangle: (usize, usize),
    /// Barycentrics of the second and third corner, in the scene's order.
    pub b: [f64; 2],
}

/// x_n.
#[derive(Clone, Copy, Debug)]
pub enum LightEnd {
    Emitter(SurfaceVertex),
    /// Unit direction towards the environment.
    Environment(DVec3),
    /// Index into [`Scene::lights`].
    Punctual(usize),
}

/// A full path as plain data.
#[derive(Clone, Debug)]
pub struct FullPath {
    /// x_0: where the camera's ray starts.
    pub camera: DVec3,
    /// x_1 .. x_{n-1}.
    pub surfaces: Vec<SurfaceVertex>,
    pub end: LightEnd,
}

impl FullPath {
    /// n, the number of its edges; x_n is the light's end.
    pub fn edges(&self) -> usize {
        self.surfaces.len() + 1
    }
}

/// [`LightEnd`] with what there is to know about it.
#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "there are few, and not for long")]
pub enum End<'a> {
    Emitter(Point<'a>),
    Environment(DVec3),
    Punctual(usize),
}

/// Where light is asked for by which connections are drawn.
#[derive(Clone, Copy, Debug)]
pub struct JudgesRecord {
    pub vertex: SurfaceVertex,
    /// Light counts that comes to the front, to the back.
    pub sides: [bool; 2],
    /// Light counts that comes at such a cosine or more, by a geometry term of no more than this.
    pub least_cosine: f64,
    pub most_geometry: f64,
}

/// [`FullPath`] with what there is to know about its vertices.
pub(super) struct Path<'a> {
    camera: DVec3,
    /// x_1 first.
    points: Vec<Point<'a>>,
    end: End<'a>,
    /// Unit direction and length of x_i to x_{i+1}.
    segments: Vec<(DVec3, f64)>,
}

/// An RGB value that may be out of the range of f64: `color` exp(`ln_scale`).
#[derive(Clone, Copy, Debug)]
pub struct Scaled {
    /// The largest component is 1, or all are 0.
    pub color: DVec3,
    pub ln_scale: f64,
}

impl Scaled {
    pub const ONE: Self = Self { color: DVec3::ONE, ln_scale: 0.0 };

    #[must_use]
    pub fn times(self, factor: DVec3) -> Self {
        let color = self.color * factor;
        let largest = color.max_element();
        if largest > 0.0 {
            return Self { color: color / largest, ln_scale: self.ln_scale + largest.ln() };
        }
        Self { color: DVec3::ZERO, ln_scale: 0.0 }
    }

    pub fn is_zero(&self) -> bool {
        self.color == DVec3::ZERO
    }

    /// ln of the sum of its channels.
    fn ln_magnitude(&self) -> f64 {
        self.color.element_sum().ln() + self.ln_scale
    }

    /// Divided by exp(`ln_pdf`).
    pub fn over(&self, ln_pdf: f64) -> DVec3 {
        self.color * (self.ln_scale - ln_pdf).exp()
    }
}

/// Densities of every vertex from both sides, as logarithms.
#[derive(Clone, Debug)]
pub struct Densities {
    /// ln pE(i): x_i sampled from x_{i-1}, i = 1 .. n. (Index 0 holds 0.)
    pub ln_eye: Vec<f64>,
    /// ln pL(i): x_i sampled from x_{i+1}, i = 1 .. n, where i = n is the light's own choice. (Index 0 holds 0.)
    pub ln_light: Vec<f64>,
    /// Whether x_i can be the end of a connection: all but mirrors and smooth glass.
    pub connects: Vec<bool>,
}

/// ln p of one strategy.
#[derive(Clone, Copy, Debug)]
pub struct Strategy {
    pub s: usize,
    pub t: usize,
    /// Minus infinity where the strategy cannot make the path.
    pub ln_pdf: f64,
}

impl Densities {
    /// All strategies, t = 1 first, s = 0 last. `connections(i)` is the factor of connecting x_i to x_{i+1}: the number of
    /// connections that one expects, or any other function of the edge. `hits`: the same of light that is hit. `light_paths`:
    /// how many light paths may hit any one pixel, 0 without light tracing.
    pub fn strategies(
        &self,
        connections: impl Fn(usize) -> f64,
        hits: f64,
        light_paths: f64,
    ) -> Vec<Strategy> {
        let n = self.ln_eye.len() - 1;
        let eye = |t: usize| self.ln_eye[1..t].iter().sum::<f64>();
        let light = |t: usize| self.ln_light[t..].iter().sum::<f64>();
        let ln_pdf = |t: usize| match t {
            _ if t == n + 1 => hits.ln() + eye(t),
            // A light that is seen directly has no other strategy.
            _ if n == 1 => f64::NEG_INFINITY,
            1 if self.connects[1] => light_paths.ln() + light(1),
            _ if t > 1 && self.connects[t - 1] && self.connects[t] => {
                connections(t - 1).ln() + eye(t) + light(t)
            }
            _ => f64::NEG_INFINITY,
        };
        (1..=n + 1).map(|t| Strategy { s: n + 1 - t, t, ln_pdf: ln_pdf(t) }).collect()
    }
}

/// The balance heuristic, in the order of the strategies; all zero where no strategy can make the path.
pub fn weights(strategies: &[Strategy]) -> Vec<f64> {
    let largest = strategies.iter().map(|strategy| strategy.ln_pdf).fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return vec![0.0; strategies.len()];
    }
    let shares: Vec<f64> = strategies.iter().map(|strategy| (strategy.ln_pdf - largest).exp()).collect();
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|share| share / sum).collect()
}

/// A scene, its camera, and the numbers that densities depend on.
pub struct PathSpace<'a> {
    pub world: World<'a>,
    pub view: Camera,
    pub resolution: [u32; 2],
    pub picks: Picks,
    /// The disc that paths from infinitely far lights start on turns about `centre` and covers the scene.
    pub centre: DVec3,
    pub disc_radius: f64,
    /// Radiance of the environment, where it is not the judge's own.
    pub sky_radiance: Option<Radiance>,
    /// Delta surfaces in a row that paths pass like any others.
    pub caught_run: usize,
}

/// Radiance from a direction.
pub type Radiance = Box<dyn Fn(DVec3) -> DVec3 + Send + Sync>;

impl<'a> PathSpace<'a> {
    pub fn new(scene: &'a Scene, view: &Camera, resolution: [u32; 2]) -> Self {
        let world = World::new(scene);
        let corners = || (0..world.triangle_count()).flat_map(|triangle| world.corners(triangle));
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let centre = if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO };
        let radius = corners().map(|corner| corner.distance(centre)).fold(0.0, f64::max);
        let picks = Picks::equal_shares(&world);
        // A hair more than the farthest corner, which must not be at the disc's rounded edge.
        let disc_radius = 1.000_001 * radius;
        Self {
            world,
            view: view.clone(),
            resolution,
            picks,
            centre,
            disc_radius,
            sky_radiance: None,
            caught_run: 16,
        }
    }

    /// f: light per pixel (the mean over a pixel's area) and measure of paths, visibility, opacity and absorption
    /// included.
    pub fn contribution(&self, path: &FullPath) -> Scaled {
        let path = self.resolve(path);
        let f = path.unoccluded(self);
        if f.is_zero() {
            return f;
        }
        let through: f64 = (0..path.edges()).map(|edge| path.visibility(self, edge)).product();
        let there: f64 = path.points.iter().map(|point| self.opacity(point)).product();
        f.times(DVec3::splat(through * there * path.end_opacity(self)))
    }

    pub fn densities(&self, path: &FullPath) -> Densities {
        self.resolve(path).densities(self)
    }

    /// ln p of every strategy, see [`Densities::strategies`].
    pub fn strategies(
        &self,
        path: &FullPath,
        connections: impl Fn(usize, &FullPath) -> f64,
        hits: f64,
        light_paths: f64,
    ) -> Vec<Strategy> {
        self.densities(path).strategies(|edge| connections(edge, path), hits, light_paths)
    }

    /// ln |f_y| of the light sub-paths x_n .. x_i, i = 1 .. n, where |.| is the sum of the channels: all that light goes
    /// through on its way to x_i, absorption and the opacity of its source included. (Index 0 holds 0.)
    pub fn ln_light(&self, path: &FullPath) -> Vec<f64> {
        self.resolve(path).ln_light(self)
    }

    /// The same of the light that the sub-path x_n .. x_i brings to a record by way of x_i, with a fiftieth of what the record
    /// does not see.
    pub fn ln_light_at_record(&self, path: &FullPath, i: usize, record: &JudgesRecord) -> f64 {
        let path = self.resolve(path);
        path.light_at_record(self, &path.light(self)[i], i, record).ln_magnitude()
    }

    fn point_of(&self, vertex: &SurfaceVertex) -> Point<'a> {
        self.world.point(&Hit { distance: 0.0, triangle: vertex.triangle, b: vertex.b })
    }

    pub(super) fn resolve(&self, path: &FullPath) -> Path<'a> {
        let point = |vertex: &SurfaceVertex| self.point_of(vertex);
        let end = match &path.end {
            LightEnd::Emitter(vertex) => End::Emitter(point(vertex)),
            LightEnd::Environment(direction) => End::Environment(*direction),
            LightEnd::Punctual(index) => End::Punctual(*index),
        };
        self.path(path.camera, path.surfaces.iter().map(point).collect(), end)
    }

    pub(super) fn path(&self, camera: DVec3, points: Vec<Point<'a>>, end: End<'a>) -> Path<'a> {
        let positions: Vec<DVec3> =
            std::iter::once(camera).chain(points.iter().map(|p| p.position)).collect();
        let span = |from: DVec3, to: DVec3| {
            let span = to - from;
            (span.normalize_or_zero(), span.length())
        };
        let mut segments: Vec<(DVec3, f64)> =
            positions.windows(2).map(|pair| span(pair[0], pair[1])).collect();
        let last = positions[positions.len() - 1];
        segments.push(match &end {
            End::Emitter(point) => span(last, point.position),
            End::Environment(direction) => (*direction, f64::INFINITY),
            End::Punctual(index) => {
                let light = &self.world.scene.lights[*index];
                match light.kind {
                    LightKind::Directional => (-light.direction.as_dvec3().normalize(), f64::INFINITY),
                    _ => span(last, light.position),
                }
            }
        });
        Path { camera, points, end, segments }
    }

    pub(super) fn opacity(&self, point: &Point) -> f64 {
        self.world.opacity(&Hit { distance: 0.0, triangle: point.triangle, b: point.b })
    }

    fn vertex(&self, point: &Point) -> SurfaceVertex {
        SurfaceVertex {
            position: point.position,
            triangle: point.triangle,
            scene_triangle: self.world.scene_triangle(point.triangle),
            b: point.b,
        }
    }
}

impl Path<'_> {
    pub(super) fn edges(&self) -> usize {
        self.segments.len()
    }

    pub(super) fn frozen(&self, space: &PathSpace) -> FullPath {
        FullPath {
            camera: self.camera,
            surfaces: self.points.iter().map(|point| space.vertex(point)).collect(),
            end: match &self.end {
                End::Emitter(point) => LightEnd::Emitter(space.vertex(point)),
                End::Environment(direction) => LightEnd::Environment(*direction),
                End::Punctual(index) => LightEnd::Punctual(*index),
            },
        }
    }

    /// x_i where it is on a surface, the light's end included.
    fn surface(&self, i: usize) -> Option<&Point<'_>> {
        match (i, &self.end) {
            (0, _) => None,
            (i, _) if i <= self.points.len() => Some(&self.points[i - 1]),
            (_, End::Emitter(point)) => Some(point),
            _ => None,
        }
    }

    /// From a density per solid angle at the other end of an edge to the density of x_i.
    fn per_area(&self, edge: usize, i: usize) -> f64 {
        let (direction, distance) = self.segments[edge];
        match self.surface(i) {
            Some(_) if distance == 0.0 => 0.0,
            Some(point) => point.world_ng.dot(direction).abs() / (distance * distance),
            None => 1.0,
        }
    }

    /// pE(1), which is also the camera's factor in f.
    fn camera_pdf(&self, space: &PathSpace) -> f64 {
        let (direction, _) = self.segments[0];
        let pdf = camera::pixel_pdf(&space.view, space.resolution, direction);
        match (space.view.projection, self.surface(1)) {
            // Parallel rays do not spread.
            (Projection::Orthographic { .. }, Some(point)) => pdf * point.world_ng.dot(direction).abs(),
            // One direction only: the film's point is all there is to sample.
            (Projection::Orthographic { .. }, None) => 1.0,
            (Projection::Perspective { .. }, _) => pdf * self.per_area(0, 1),
        }
    }

    /// The medium of an edge: inside where one of its ends is, the one nearer to the camera first.
    fn medium(&self, edge: usize) -> Option<&Material> {
        let (direction, _) = self.segments[edge];
        let near = self.surface(edge).and_then(|point| point.medium_towards(direction));
        near.or_else(|| self.surface(edge + 1).and_then(|point| point.medium_towards(-direction)))
    }

    /// Light that x_n sends to x_{n-1}: radiance, or what becomes irradiance across the direction.
    fn emitted(&self, space: &PathSpace) -> DVec3 {
        let (direction, _) = self.segments[self.edges() - 1];
        match &self.end {
            End::Emitter(point) => point.emitted(-direction),
            End::Environment(direction) => match (&space.sky_radiance, &space.world.lights.sky) {
                (Some(radiance), _) => radiance(*direction),
                (None, Some(sky)) => sky.radiance(*direction),
                (None, None) => DVec3::ZERO,
            },
            // Without surfaces the light is seen directly: it has no size.
            End::Punctual(index) => self
                .points
                .last()
                .map_or(DVec3::ZERO, |point| punctual(&space.world.scene.lights[*index], point.position).0),
        }
    }

    /// f without visibility and opacity.
    pub(super) fn unoccluded(&self, space: &PathSpace) -> Scaled {
        let mut f = Scaled::ONE.times(self.emitted(space));
        for (index, point) in self.points.iter().enumerate().rev() {
            if f.is_zero() {
                return f;
            }
            let (to_eye, to_light) = (-self.segments[index].0, self.segments[index + 1].0);
            let scattered = scattered(point, to_eye, to_light);
            // What `punctual` gives has its 1 / d^2.
            f = f.times(scattered).times(DVec3::splat(self.per_area(index + 1, index + 2)));
        }
        for edge in 0..self.edges() {
            f = f.times(transmittance(self.medium(edge), self.segments[edge].1));
        }
        f.times(DVec3::splat(self.camera_pdf(space)))
    }

    fn ln_light(&self, space: &PathSpace) -> Vec<f64> {
        let mut found: Vec<f64> = self.light(space).iter().map(Scaled::ln_magnitude).collect();
        if let End::Punctual(index) = &self.end {
            // Before any direction, distance and falloff.
            found[self.edges()] = space.world.scene.lights[*index].intensity.as_dvec3().element_sum().ln();
        }
        found
    }

    /// Light that arrives at x_i, i = 1 .. n - 1, and at n what leaves the light's end. (Index 0 holds 1.)
    fn light(&self, space: &PathSpace) -> Vec<Scaled> {
        let n = self.edges();
        let mut found = vec![Scaled::ONE; n + 1];
        let there = DVec3::splat(self.end_opacity(space));
        let mut f = Scaled::ONE.times(self.emitted(space)).times(there);
        found[n] = f;
        for i in (1..n).rev() {
            let (point, to_light) = (&self.points[i - 1], self.segments[i].0);
            let cos = point.world_ng.dot(to_light).abs();
            f = f
                .times(DVec3::splat(self.per_area(i, i + 1) * cos))
                .times(transmittance(self.medium(i), self.segments[i].1));
            found[i] = f;
            f = f.times(scattered(point, -self.segments[i - 1].0, to_light) / cos);
        }
        found
    }

    /// [`PathSpace::ln_light_at_record`], of the light of [`Self::light`] at x_i.
    fn light_at_record(&self, space: &PathSpace, light: &Scaled, i: usize, record: &JudgesRecord) -> Scaled {
        let at = space.point_of(&record.vertex);
        let span = |to: DVec3| ((to - at.position).normalize_or_zero(), (to - at.position).length());
        let source = |index: usize| &space.world.scene.lights[index];
        let (direction, distance) = match (self.surface(i), &self.end) {
            (Some(point), _) => span(point.position),
            (None, End::Environment(direction)) => (*direction, f64::INFINITY),
            (None, End::Punctual(index)) if source(*index).kind == LightKind::Directional => {
                (-source(*index).direction.as_dvec3().normalize(), f64::INFINITY)
            }
            (None, End::Punctual(index)) => span(source(*index).position),
            (None, End::Emitter(_)) => unreachable!("an emitter is a surface"),
        };
        let cos_light = self.surface(i).map_or(1.0, |point| point.world_ng.dot(direction).abs());
        let leaving = match (self.surface(i), &self.end) {
            (Some(point), _) if i < self.edges() => {
                let to_light = self.segments[i].0;
                light.times(scattered(point, -direction, to_light) / point.world_ng.dot(to_light).abs())
            }
            (Some(point), _) => Scaled::ONE.times(point.emitted(-direction) * self.end_opacity(space)),
            (None, End::Punctual(index)) if distance.is_finite() => {
                Scaled::ONE.times(punctual(source(*index), at.position).0 * distance * distance)
            }
            _ => *light,
        };
        let cos = at.world_ng.dot(direction);
        let mut geometry = cos.abs() * cos_light;
        if distance.is_finite() {
            geometry = (geometry / (distance * distance)).min(record.most_geometry);
        }
        if !record.sides[usize::from(cos <= 0.0)] || cos.abs() < record.least_cosine {
            geometry = 0.0;
        }
        let seen = if space.world.visibility(at.position, direction, distance) > 0.5 { 1.0 } else { 0.02 };
        leaving.times(DVec3::splat(geometry * seen))
    }

    /// Share of light that passes along an edge.
    pub(super) fn visibility(&self, space: &PathSpace, edge: usize) -> f64 {
        let (direction, distance) = self.segments[edge];
        let start = if edge == 0 { self.camera } else { self.points[edge - 1].position };
        space.world.visibility(start, direction, distance)
    }

    /// Probability that the light's end is there.
    pub(super) fn end_opacity(&self, space: &PathSpace) -> f64 {
        if let End::Emitter(point) = &self.end { space.opacity(point) } else { 1.0 }
    }

    pub(super) fn densities(&self, space: &PathSpace) -> Densities {
        let n = self.edges();
        let row =
            |points: &mut dyn Iterator<Item = &Point>| points.take_while(|point| point.bsdf.delta).count();
        let survival = |i: usize, row: usize| self.points[i].survival_after(row, space.caught_run);
        let eye = |i: usize| match i {
            0 => 1.0,
            // No direction meets a point.
            _ if i == n && matches!(self.end, End::Punctual(_)) => 0.0,
            1 => self.camera_pdf(space),
            _ => {
                let (from, to) = (-self.segments[i - 2].0, self.segments[i - 1].0);
                let survival = survival(i - 2, row(&mut self.points[..i - 2].iter().rev()));
                scatter_pdf(&self.points[i - 2], from, to) * survival * self.per_area(i - 1, i)
            }
        };
        let light = |i: usize| match i {
            0 => 1.0,
            _ if i == n => space.picks.pdf(&space.world, &self.end),
            _ if i == n - 1 => self.emission_pdf(space),
            _ => {
                let (from, to) = (self.segments[i + 1].0, -self.segments[i].0);
                let survival = survival(i, row(&mut self.points[i + 1..].iter()));
                scatter_pdf(&self.points[i], from, to) * survival * self.per_area(i, i)
            }
        };
        let mut connects = vec![true; n + 1];
        self.points
            .iter()
            .zip(&mut connects[1..])
            .for_each(|(point, connects)| *connects = !point.bsdf.delta);
        Densities {
            ln_eye: (0..=n).map(|i| eye(i).ln()).collect(),
            ln_light: (0..=n).map(|i| light(i).ln()).collect(),
            connects,
        }
    }

    /// pL(n - 1): what the light sends.
    fn emission_pdf(&self, space: &PathSpace) -> f64 {
        let last = self.edges() - 1;
        let along = -self.segments[last].0;
        match emission_pdf_solid(&space.world, &self.end, along) {
            Some(pdf_solid) => pdf_solid * self.per_area(last, last),
            // Uniform on the disc.
            None => {
                let cos = self.points[last - 1].world_ng.dot(along).abs();
                cos / (PI * space.disc_radius * space.disc_radius)
            }
        }
    }
}

/// f times the geometric cosine of the light's direction, for light that goes to the eye.
///
/// Of a delta event: relative to a Dirac delta in n^2 cos dw, the measure that refraction preserves, so that the events
/// of both directions have the same one and their ratio means something.
fn scattered(point: &Point, to_eye: DVec3, to_light: DVec3) -> DVec3 {
    if !point.bsdf.delta {
        return point.scattered(to_eye, to_light);
    }
    delta_event(point, to_eye, to_light)
        .map_or(DVec3::ZERO, |event| event.weight * event.pdf * invariant_cosine(point, to_light))
}

/// Density per solid angle of going on from `from` to `to` (both away from the point) where roulette lets the path. Delta
/// events as in [`scattered`].
fn scatter_pdf(point: &Point, from: DVec3, to: DVec3) -> f64 {
    if !point.scatters() || !point.sides_agree(from) || !point.sides_agree(to) {
        return 0.0;
    }
    if point.bsdf.delta {
        delta_event(point, from, to).map_or(0.0, |event| event.pdf * invariant_cosine(point, to))
    } else {
        point.scatter_pdf(from, to)
    }
}

/// The delta event of `from` that ends on the side of `to`, as an eye path samples it. `None` where that never happens.
fn delta_event(point: &Point, from: DVec3, to: DVec3) -> Option<Sample> {
    if !point.scatters() || !point.sides_agree(from) || !point.sides_agree(to) {
        return None;
    }
    let ((from, _), (to, _)) = (point.to_local(from), point.to_local(to));
    // The first and the last number of the lottery: reflection comes first.
    [0.0, 1.0 - 0.5 * f64::EPSILON]
        .into_iter()
        .filter_map(|u| point.bsdf.sample(from, [0.5, 0.5, u], true))
        .find(|event| event.w.z * to.z > 0.0)
}

/// n^2 |cos| of a direction, for solid angles of the world.
fn invariant_cosine(point: &Point, world: DVec3) -> f64 {
    let cos = point.carried_cosine(world);
    let index = if point.material.volume && cos < 0.0 { f64::from(point.material.ior) } else { 1.0 };
    index * index * cos.abs()
}
