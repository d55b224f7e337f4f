//! Which light a light path starts from: probabilities given from outside, so that they can be the renderer's own.

use std::f64::consts::PI;

use glam::DVec3;
use halfway::scene::LightKind;

use super::geometry::Hit;
use super::light::area_of;
use super::path_space::End;
use super::random::Random;
use super::world::World;

/// A density over directions.
pub type DirectionPdf = Box<dyn Fn(DVec3) -> f64 + Send + Sync>;

/// Probabilities of the lights; they sum to one.
pub struct Picks {
    /// By triangle of the judge's tree.
    pub triangles: Vec<f64>,
    pub environment: f64,
    /// By light of [`halfway::scene::Scene::lights`].
    pub punctual: Vec<f64>,
    /// Density per solid angle of the environment's directions, where it is not the judge's own.
    pub environment_pdf_solid: Option<DirectionPdf>,
}

impl Picks {
    /// Emitting triangles (by area times radiance), the environment, and each punctual light get equal shares.
    pub fn equal_shares(world: &World) -> Self {
        let count = world.triangle_count();
        let mut triangles: Vec<f64> =
            (0..count).map(|t| world.lights.pdf_area(t) * area_of(&world.corners(t))).collect();
        let emitters = triangles.iter().sum::<f64>();
        let groups =
            emitters.round() + f64::from(world.lights.sky.is_some()) + world.scene.lights.len() as f64;
        triangles.iter_mut().for_each(|share| *share /= groups.max(1.0));
        Self {
            triangles,
            environment: f64::from(world.lights.sky.is_some()) / groups.max(1.0),
            punctual: vec![1.0 / groups.max(1.0); world.scene.lights.len()],
            environment_pdf_solid: None,
        }
    }

    /// p of the light's end: per area on a triangle, per solid angle of the environment, a probability of a punctual
    /// light.
    pub fn pdf(&self, world: &World, end: &End) -> f64 {
        match end {
            End::Emitter(point) => self.triangles[point.triangle] / area_of(&world.corners(point.triangle)),
            End::Environment(direction) => self.environment * self.direction_pdf_solid(world, *direction),
            End::Punctual(index) => self.punctual[*index],
        }
    }

    fn direction_pdf_solid(&self, world: &World, direction: DVec3) -> f64 {
        match (&self.environment_pdf_solid, &world.lights.sky) {
            (Some(pdf_solid), _) => pdf_solid(direction),
            (None, Some(sky)) => sky.pdf_solid(direction),
            (None, None) => 0.0,
        }
    }
}

/// Draws lights by [`Picks`].
pub struct Lottery {
    /// Every light that is ever picked, and the running sum of the probabilities.
    tickets: Vec<(Ticket, f64)>,
}

#[derive(Clone, Copy)]
enum Ticket {
    Triangle(usize),
    Environment,
    Punctual(usize),
}

impl Lottery {
    pub fn new(picks: &Picks) -> Self {
        assert!(
            picks.environment_pdf_solid.is_none(),
            "directions of a density from outside cannot be drawn"
        );
        let triangles = picks.triangles.iter().enumerate().map(|(i, &share)| (Ticket::Triangle(i), share));
        let punctual = picks.punctual.iter().enumerate().map(|(i, &share)| (Ticket::Punctual(i), share));
        let all = triangles.chain(punctual).chain([(Ticket::Environment, picks.environment)]);
        let tickets = all.filter(|(_, share)| *share > 0.0).scan(0.0, |sum, (ticket, share)| {
            *sum += share;
            Some((ticket, *sum))
        });
        Self { tickets: tickets.collect() }
    }

    /// A light's end, `None` without lights. The environment's directions are the judge's own.
    pub fn draw<'a>(&self, world: &World<'a>, random: &mut Random) -> Option<End<'a>> {
        let (_, total) = self.tickets.last()?;
        let target = random.uniform() * total;
        let (ticket, _) = self.tickets[self.tickets.partition_point(|(_, sum)| *sum <= target)];
        Some(match ticket {
            Ticket::Triangle(triangle) => {
                // Uniform in the triangle.
                let u = random.uniform2();
                let root = u.x.sqrt();
                let b = [root * (1.0 - u.y), root * u.y];
                End::Emitter(world.point(&Hit { distance: 0.0, triangle, b }))
            }
            Ticket::Environment => {
                let sky = world.lights.sky.as_ref().expect("an environment that is picked exists");
                End::Environment(sky.draw(random.uniform(), random.uniform2()))
            }
            Ticket::Punctual(index) => End::Punctual(index),
        })
    }
}

/// Density per solid angle with which a light that has a place sends a path along `direction`; `None` for those that are
/// infinitely far.
pub fn emission_pdf_solid(world: &World, end: &End, direction: DVec3) -> Option<f64> {
    match end {
        End::Emitter(point) => {
            let cos = point.world_ng.dot(direction);
            Some(if point.material.double_sided { 0.5 * cos.abs() / PI } else { cos.max(0.0) / PI })
        }
        End::Environment(_) => None,
        End::Punctual(index) => {
            let light = &world.scene.lights[*index];
            match light.kind {
                LightKind::Directional => None,
                LightKind::Point => Some(0.25 / PI),
                LightKind::Spot { outer, .. } => {
                    let cos_outer = f64::from(outer).cos();
                    let inside = light.direction.as_dvec3().normalize().dot(direction) > cos_outer;
                    Some(if inside { 0.5 / (PI * (1.0 - cos_outer)) } else { 0.0 })
                }
            }
        }
    }
}
