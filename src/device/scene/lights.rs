//! Everything that can be sampled as a light, in one alias table by power.

use std::f64::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::Target;
use super::units::{punctual_intensity, scaled};
use crate::accel::{Accel, AccelTriangle};
use crate::device::layout::{
    EnvironmentMap, LIGHT_DIRECTIONAL, LIGHT_ENVIRONMENT, LIGHT_POINT, LIGHT_SPOT, LIGHT_TRIANGLE, Light,
    PunctualLight,
};
use crate::device::{DeviceError, PagedBuffer};
use crate::math::alias::{AliasEntry, AliasTable, alias_entries, defensive_mix};
use crate::math::color::luminance;
use crate::math::scale::scale_by_power_of_two;
use crate::math::shared_exponent;
use crate::scene::environment::EqualAreaMap;
use crate::scene::{self, LightKind, Mesh, Scene, SceneFeatures, TextureRef};

/// Share of the picks that go evenly to all lights: the power of a light is a poor guide to what reaches a point.
const DEFENSIVE_SHARE: f64 = 0.1;
/// Share of the picks within an environment that go evenly to all texels that are not black.
const EVEN_SHARE: f64 = 1.0 / 1024.0;

/// Half angle in radians below which the rounding of directions (2^-24, and what a frame adds) is more than a few
/// percent of a cone's.
const NARROWEST_CONE: f32 = 2e-6;

/// What a light is, in unit space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceKind {
    Triangle {
        position: Vec3,
        normal: Vec3,
        area: f32,
    },
    Environment,
    /// `cone`: 1 - cosine of the half angle that it shines into, 2 for all around; 0 of parallel light.
    Punctual {
        position: Vec3,
        direction: Vec3,
        cone: f32,
    },
}

/// A light of the device's list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSourceInfo {
    pub kind: SourceKind,
    /// In any unit that all lights share.
    pub power: f64,
}

/// The lights of a scene, laid out for the device.
pub(super) struct Lights {
    pub entries: Vec<Light>,
    /// Index plus one into `entries` for every triangle of the BVH; 0 for none.
    pub of_triangle: Vec<u32>,
    punctual: Vec<PunctualLight>,
    environment: Option<DeviceEnvironment>,
}

pub(super) struct DeviceEnvironment {
    map: EnvironmentMap,
    /// Radiance, packed by `shared_exponent`.
    texels: Vec<[u32; 2]>,
    alias: Vec<AliasEntry>,
    power: f64,
}

impl DeviceEnvironment {
    /// `None` where the strongest light is so strong that nothing is left of it.
    ///
    /// # Errors
    /// Radiance that is no number.
    fn new(map: EqualAreaMap, radiance_exponent: i32) -> Result<Option<Self>, DeviceError> {
        let pack =
            |&radiance: &[f32; 3]| shared_exponent::pack(scaled(radiance.into(), radiance_exponent).into());
        let texels: Vec<[u32; 2]> = map.radiance.par_iter().map(pack).collect();
        drop(map.radiance);
        let luminance = |&texel: &[u32; 2]| f64::from(luminance(shared_exponent::unpack(texel).into()));
        let mut weights: Vec<f64> = texels.par_iter().map(luminance).collect();
        let sum: f64 = weights.chunks(4096).map(|block| block.iter().sum::<f64>()).sum();
        if sum == 0.0 {
            return Ok(None);
        }
        // Kernels know a texel's probability by its radiance. A share that all texels have alike keeps the rounding to
        // whole units of the table below that of f32.
        let drawable = weights.iter().filter(|&&weight| weight > 0.0).count() as f64;
        let (scale, floor) = ((1.0 - EVEN_SHARE) / sum, EVEN_SHARE / drawable);
        weights
            .iter_mut()
            .filter(|weight| **weight > 0.0)
            .for_each(|weight| *weight = *weight * scale + floor);
        let count = weights.len() as f64;
        let solid = count / (4.0 * PI);
        Ok(Some(Self {
            map: EnvironmentMap {
                size: map.size,
                light: 0, // `collect` says
                pdf_scale: (scale * solid) as f32,
                pdf_floor: (floor * solid) as f32,
            },
            texels,
            alias: alias_entries(&weights)?,
            // Radiance over all directions, falling on the disc around the unit scene.
            power: sum / count * 4.0 * PI.powi(2),
        }))
    }
}

/// The environment as the device has it; none where it gives no light.
///
/// # Errors
/// An environment whose scaled radiance is no number.
pub(super) fn environment(
    scene: &Scene,
    features: &SceneFeatures,
    radiance_exponent: i32,
) -> Result<Option<DeviceEnvironment>, DeviceError> {
    let environment = scene.environment.as_ref().filter(|_| features.environment);
    match environment.map(EqualAreaMap::new).transpose()?.flatten() {
        Some(map) => DeviceEnvironment::new(map, radiance_exponent),
        None => Ok(None),
    }
}

/// Lists the lights and their probabilities. Lights without power are left out, and so are those that have no area, or
/// that are too weak beside the strongest for f32.
///
/// # Errors
/// An environment whose scaled radiance is no number.
pub(super) fn collect(
    scene: &Scene,
    accel: &Accel,
    features: &SceneFeatures,
    radiance_exponent: i32,
    environment: Option<DeviceEnvironment>,
) -> Result<Lights, DeviceError> {
    let mut lights = Lights {
        entries: Vec::new(),
        of_triangle: vec![0; accel.triangles.len()],
        punctual: Vec::new(),
        environment: None,
    };
    let mut powers: Vec<f64> = Vec::new();
    let mut add = |entries: &mut Vec<Light>, kind: u32, index: usize, power: f64| {
        let drawable = power > 0.0;
        if drawable {
            entries.push(Light { kind, index: index as u32, ..Light::default() });
            powers.push(power);
        }
        drawable
    };
    if features.area_lights {
        // Spatial splits list a triangle more than once; it is one light all the same.
        let mut seen = std::collections::BTreeMap::new();
        let emits: Vec<bool> =
            scene.meshes.iter().map(|mesh| radiance(scene, mesh, radiance_exponent) > 0.0).collect();
        debug_assert!(
            scene.meshes.iter().zip(&emits).all(|(mesh, emits)| !emits || mesh.instances.is_empty())
        );
        let emitting = |(_, triangle): &(usize, &AccelTriangle)| emits[triangle.mesh as usize];
        for (index, triangle) in accel.triangles.iter().enumerate().filter(emitting) {
            let known = seen.get(&(triangle.mesh, triangle.triangle)).copied();
            let light = known.unwrap_or_else(|| {
                let power = triangle_power(scene, triangle, radiance_exponent);
                if add(&mut lights.entries, LIGHT_TRIANGLE, index, power) {
                    lights.entries.len() as u32
                } else {
                    0
                }
            });
            seen.insert((triangle.mesh, triangle.triangle), light);
            lights.of_triangle[index] = light;
        }
    }
    if features.punctual_lights {
        for light in &scene.lights {
            let intensity = punctual_intensity(light, &accel.unit);
            let intensity: Vec3 =
                intensity.to_array().map(|c| scale_by_power_of_two(c, -radiance_exponent) as f32).into();
            let (kind, cone, falloff_scale, solid_angle) = match light.kind {
                LightKind::Point => (LIGHT_POINT, 2.0, 0.0, 4.0 * PI),
                LightKind::Spot { inner, outer } => {
                    warn_of_narrow_cone(light, outer);
                    let (cone, scale) = spot_cone(f64::from(inner), f64::from(outer));
                    (LIGHT_SPOT, cone, scale, 2.0 * PI * cone)
                }
                // What falls on the disc around the unit scene.
                LightKind::Directional => (LIGHT_DIRECTIONAL, 2.0, 0.0, PI),
            };
            let power = f64::from(luminance(intensity)) * solid_angle;
            if add(&mut lights.entries, kind, lights.punctual.len(), power) {
                lights.punctual.push(PunctualLight {
                    position: accel.unit.point(light.position).to_array(),
                    cone: cone as f32,
                    intensity: intensity.to_array(),
                    falloff_scale: falloff_scale as f32,
                    direction: light.direction.to_array(),
                    pad: 0,
                });
            }
        }
    }
    if let Some(mut environment) = environment {
        environment.map.light = lights.entries.len() as u32;
        add(&mut lights.entries, LIGHT_ENVIRONMENT, 0, environment.power);
        lights.environment = Some(environment);
    }
    if !powers.is_empty() {
        let table = AliasTable::new(&defensive_mix(&powers, DEFENSIVE_SHARE)?)?;
        for (index, (light, entry)) in lights.entries.iter_mut().zip(table.entries()).enumerate() {
            light.threshold = entry.threshold;
            light.alias_index = entry.alias;
            light.pdf_select = table.pdf_select(index) as f32;
        }
    }
    Ok(lights)
}

/// The cone and the scale of the falloff (`shaders/bind/lights.wgsl`) of a spot with these half angles.
fn spot_cone(inner: f64, outer: f64) -> (f64, f64) {
    let cone = 2.0 * (0.5 * outer).sin().powi(2);
    // cos(inner) - cos(outer), without the difference of two numbers near one.
    let ramp = 2.0 * (0.5 * (outer + inner)).sin() * (0.5 * (outer - inner)).sin();
    // A hard edge: the ramp is no longer than the last digit of what the kernels subtract.
    (cone, 1.0 / ramp.max(cone * f64::from(f32::EPSILON)))
}

/// Directions have the digits of f32, and so has the edge of a cone.
fn warn_of_narrow_cone(light: &scene::PunctualLight, outer: f32) {
    if outer < NARROWEST_CONE {
        log::warn!(
            "light \"{}\" shines into a cone of {outer:e} rad, narrower than directions can tell \
             ({NARROWEST_CONE:.0e} rad): what it lights may be too bright or too dark; use a wider cone",
            light.name
        );
    }
}

impl Lights {
    /// Uploads what there is.
    pub(super) fn upload(&self, target: &mut Target<'_>) -> Result<(), DeviceError> {
        if !self.entries.is_empty() {
            target.buffers.upload(target.context, "lights", &self.entries)?;
        }
        if !self.punctual.is_empty() {
            target.buffers.upload(target.context, "punctual_lights", &self.punctual)?;
        }
        if let Some(environment) = &self.environment {
            target.upload(PagedBuffer::EnvironmentTexels, &environment.texels)?;
            target.upload(PagedBuffer::EnvironmentAlias, &environment.alias)?;
            target.buffers.upload_uniform(target.context, "environment_map", &[environment.map])?;
        }
        Ok(())
    }

    /// What each entry is, in their order.
    pub(super) fn describe(&self, accel: &Accel) -> Vec<LightSourceInfo> {
        let kind = |light: &Light| match light.kind {
            LIGHT_TRIANGLE => {
                let triangle = &accel.triangles[light.index as usize];
                let [a, b, c] = triangle.vertices;
                let cross = (b - a).as_dvec3().cross((c - a).as_dvec3());
                let flip = if triangle.flipped { -1.0 } else { 1.0 };
                SourceKind::Triangle {
                    position: (a + b + c) / 3.0,
                    normal: (flip * cross.normalize_or_zero()).as_vec3(),
                    area: 0.5 * cross.length() as f32,
                }
            }
            LIGHT_ENVIRONMENT => SourceKind::Environment,
            _ => {
                let punctual = &self.punctual[light.index as usize];
                let cone = if light.kind == LIGHT_DIRECTIONAL { 0.0 } else { punctual.cone };
                let (position, direction) = (punctual.position.into(), punctual.direction.into());
                SourceKind::Punctual { position, direction, cone }
            }
        };
        let info = |light: &Light| LightSourceInfo { kind: kind(light), power: f64::from(light.pdf_select) };
        self.entries.iter().map(info).collect()
    }

    /// Kinds of light that turned out to have no power are features that the kernels can do without.
    pub(super) fn restrict(&self, features: &mut SceneFeatures) {
        features.area_lights &= self.of_triangle.iter().any(|&light| light != 0);
        features.environment &= self.environment.is_some();
        features.punctual_lights &= !self.punctual.is_empty();
    }
}

/// Luminance that a mesh emits where its texture is white.
fn radiance(scene: &Scene, mesh: &Mesh, radiance_exponent: i32) -> f32 {
    let material = &scene.materials[mesh.material as usize];
    luminance(scaled(if material.unlit { material.base_color } else { material.emission }, radiance_exponent))
}

/// Luminous power in unit space, up to a common factor: area times the mean radiance over the triangle.
fn triangle_power(scene: &Scene, triangle: &AccelTriangle, radiance_exponent: i32) -> f64 {
    let mesh = &scene.meshes[triangle.mesh as usize];
    let material = &scene.materials[mesh.material as usize];
    let texture = if material.unlit { material.base_color_texture } else { material.emission_texture };
    let radiance = radiance(scene, mesh, radiance_exponent);
    let [a, b, c] = triangle.vertices.map(|vertex| vertex.as_dvec3());
    let area = 0.5 * (b - a).cross(c - a).length();
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    let mean = texture.map_or(1.0, |texture| {
        mesh.uvs[texture.uv_set as usize].as_ref().map_or(1.0, |uvs| {
            let corners = mesh.triangles[triangle.triangle as usize].map(|vertex| uvs[vertex as usize]);
            mean_luminance(scene, &texture, corners)
        })
    });
    area * f64::from(radiance) * sides * f64::from(mean)
}

/// Mean luminance of a texture over a triangle of texture space, from a fixed pattern of look-ups. It only steers
/// how often the triangle is picked, so coarse is good enough; but never 0 where a texel might shine.
fn mean_luminance(scene: &Scene, reference: &TextureRef, uvs: [Vec2; 3]) -> f32 {
    const STEPS: usize = 12;
    const FLOOR: f32 = 1e-3;
    let texture = scene.textures[reference.texture as usize];
    let image = &scene.images[texture.image as usize];
    let mut sum = 0.0;
    let mut count = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS - i {
            let (b1, b2) = ((i as f32 + 1.0 / 3.0) / STEPS as f32, (j as f32 + 1.0 / 3.0) / STEPS as f32);
            let uv = uvs[0] * (1.0 - b1 - b2) + uvs[1] * b1 + uvs[2] * b2;
            let uv = reference.transform.transform_point2(uv);
            let at = |x: f32, size: u32| ((x.rem_euclid(1.0) * size as f32) as u32).min(size - 1);
            let texel = image.texels[(at(uv.y, image.height) * image.width + at(uv.x, image.width)) as usize];
            // Gamma 2 is near enough to sRGB for a weight.
            let linear = |byte: u8| (f32::from(byte) / 255.0) * (f32::from(byte) / 255.0);
            sum += luminance(Vec3::new(linear(texel[0]), linear(texel[1]), linear(texel[2])));
            count += 1.0;
        }
    }
    (sum / count).max(FLOOR)
}
