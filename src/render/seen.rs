//! What the camera sees first, for layers that people composite by: coverage, ids, positions and texture coordinates. The
//! rays are those of the picture's own samples, traced once more; the host knows what they met.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2};

use super::RenderError;
use crate::accel::{Accel, AccelTriangle, Instances};
use crate::device::Context;
use crate::device::layout::Hit;
use crate::film::Picture;
use crate::film::cryptomatte::Matte;
use crate::integrator::Wavefront;
use crate::scene::{Instance, Mesh, Scene};

/// Layers beside the picture that only an output with them pays for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SeenLayers {
    /// The share of a pixel that surfaces cover: the channel `A`.
    pub alpha: bool,
    /// World position and texture coordinates (the first set) of the first sample of a pixel that meets a surface, as they
    /// are, not averaged; zero where there is none.
    pub position: bool,
    pub uv: bool,
    /// Objects and materials as Cryptomatte.
    pub ids: bool,
}

/// Samples of the picture that coverage and ids are made of, at most: more change no level of 8 bits, and of the ids' shares
/// little that is seen.
const MOST_FOR_ALPHA: u32 = 256;
const MOST_FOR_IDS: u32 = 64;
/// Samples in which a pixel's point is looked for.
const MOST_FOR_POINTS: u32 = 8;

impl SeenLayers {
    pub fn any(self) -> bool {
        self != Self::default()
    }

    /// Samples that are looked at, of those that the picture has.
    fn samples(self, picture: u32) -> u32 {
        let most = [
            if self.alpha { MOST_FOR_ALPHA } else { 0 },
            if self.ids { MOST_FOR_IDS } else { 0 },
            if self.position || self.uv { MOST_FOR_POINTS } else { 0 },
        ];
        picture.min(most.into_iter().max().unwrap_or(0))
    }
}

/// What the host has to know of the scene's triangles, in the order of the device's.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    layers: SeenLayers,
    instances: Instances,
    /// Of each instance: its transform to world space, and its name.
    places: Vec<(DAffine3, u32)>,
    /// Of the stored vertices.
    positions: Vec<[DVec3; 3]>,
    uvs: Vec<[Vec2; 3]>,
    /// Indices into the names.
    ids: Vec<[u32; 2]>,
    names: [Vec<String>; 2],
}

impl Surfaces {
    pub fn new(scene: &Scene, accel: &Accel, layers: SeenLayers) -> Self {
        let mesh = |triangle: &AccelTriangle| &scene.meshes[triangle.mesh as usize];
        let corners = |triangle: &AccelTriangle| {
            let corners = mesh(triangle).triangles[triangle.triangle as usize];
            triangle.corners.map(|corner| corners[corner as usize] as usize)
        };
        let triangles = accel.triangles.iter();
        let mut surfaces = Self { layers, ..Self::default() };
        if layers.position {
            let place = |triangle| corners(triangle).map(|corner| mesh(triangle).positions[corner]);
            surfaces.positions = triangles.clone().map(place).collect();
        }
        if layers.uv {
            let place = |triangle| match &mesh(triangle).uvs[0] {
                Some(uvs) => corners(triangle).map(|corner| uvs[corner]),
                None => [Vec2::ZERO; 3],
            };
            surfaces.uvs = triangles.clone().map(place).collect();
        }
        if layers.ids {
            surfaces.ids = triangles.map(|triangle| [triangle.mesh, mesh(triangle).material]).collect();
            let object = |(index, mesh): (usize, &Mesh)| named(&mesh.name, "object", index);
            let materials = scene.materials.iter().enumerate();
            surfaces.names = [
                scene.meshes.iter().enumerate().map(object).collect(),
                materials.map(|(index, material)| named(&material.name, "material", index)).collect(),
            ];
        }
        surfaces.add_places(scene, accel);
        surfaces
    }

    /// Instances of one name have one id.
    fn add_places(&mut self, scene: &Scene, accel: &Accel) {
        let mut known: BTreeMap<&str, u32> = BTreeMap::new();
        for placed in &accel.instances.list {
            let Instance { transform, name } =
                &scene.meshes[placed.mesh as usize].instances[placed.place as usize];
            let id = match known.get(&**name) {
                Some(&id) => id,
                None => {
                    let id = self.names[0].len() as u32;
                    self.names[0].push(named(name, "object", placed.mesh as usize));
                    known.insert(name, id);
                    id
                }
            };
            self.places.push((*transform, id));
        }
        self.instances = accel.instances.clone();
    }

    /// The index of the triangle of a number, and the place that shows it where it is one of an instance.
    fn resolve(&self, number: u32) -> (usize, Option<&(DAffine3, u32)>) {
        let (instance, stored) = self.instances.resolve(number);
        (stored as usize, instance.map(|index| &self.places[index]))
    }
}

/// What has no name is called by its number.
fn named(name: &str, kind: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind} {index}") } else { name.to_owned() }
}

/// What was seen so far.
pub(super) struct Seen {
    surfaces: Arc<Surfaces>,
    /// Samples looked at.
    samples: u32,
    /// Of each pixel, those that met a surface.
    covered: Vec<u32>,
    positions: Vec<Option<DVec3>>,
    uvs: Vec<Option<Vec2>>,
    /// Of each pixel, samples by object and material.
    ids: Vec<BTreeMap<[u32; 2], u32>>,
}

impl Seen {
    pub fn new(surfaces: Arc<Surfaces>) -> Self {
        Self {
            surfaces,
            samples: 0,
            covered: Vec::new(),
            positions: Vec::new(),
            uvs: Vec::new(),
            ids: Vec::new(),
        }
    }

    /// Forgets all: another view, or another seed.
    pub fn forget(&mut self) {
        *self = Self::new(self.surfaces.clone());
    }

    /// Adds the layers to a picture of `samples` samples, after a look at those that were not looked at yet.
    ///
    /// # Errors
    /// A lost device.
    pub fn add_to(
        &mut self,
        picture: &mut Picture,
        samples: u32,
        wavefront: &mut Wavefront,
        context: &Context,
    ) -> Result<(), RenderError> {
        let layers = self.surfaces.layers;
        let pixels = picture.rgb.len();
        let make = |wanted: bool| if wanted { pixels } else { 0 };
        self.covered.resize(make(layers.alpha), 0);
        self.positions.resize(make(layers.position), None);
        self.uvs.resize(make(layers.uv), None);
        self.ids.resize_with(make(layers.ids), BTreeMap::new);
        let wanted = layers.samples(samples);
        if wanted > self.samples {
            let mut sample_of = vec![self.samples; pixels];
            wavefront.camera_hits(context, self.samples, wanted - self.samples, |pixel, hit| {
                self.take(pixel, sample_of[pixel], hit);
                sample_of[pixel] += 1;
            })?;
            self.samples = wanted;
        }
        self.push(picture);
        Ok(())
    }

    fn take(&mut self, pixel: usize, sample: u32, hit: Option<&Hit>) {
        let Some(hit) = hit else { return };
        let (triangle, place) = self.surfaces.resolve(hit.triangle);
        let weights = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        if let Some(covered) = self.covered.get_mut(pixel) {
            *covered += 1;
        }
        if let Some(position @ None) = self.positions.get_mut(pixel) {
            let corners = self.surfaces.positions[triangle];
            let corners =
                place.map_or(corners, |(transform, _)| corners.map(|c| transform.transform_point3(c)));
            *position = Some((0..3).map(|i| f64::from(weights[i]) * corners[i]).sum());
        }
        if let Some(uv @ None) = self.uvs.get_mut(pixel) {
            let corners = self.surfaces.uvs[triangle];
            *uv = Some((0..3).map(|i| weights[i] * corners[i]).sum());
        }
        if let Some(ids) = self.ids.get_mut(pixel).filter(|_| sample < MOST_FOR_IDS) {
            let [object, material] = self.surfaces.ids[triangle];
            let object = place.map_or(object, |&(_, object)| object);
            *ids.entry([object, material]).or_default() += 1;
        }
    }

    fn push(&self, picture: &mut Picture) {
        let layers = self.surfaces.layers;
        let share = |count: u32, most: u32| count as f32 / self.samples.min(most).max(1) as f32;
        if layers.alpha {
            let alpha = self.covered.iter().map(|&covered| share(covered, MOST_FOR_ALPHA)).collect();
            picture.push_channel("", "A", alpha);
        }
        if layers.position {
            for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                let value = |place: &Option<DVec3>| place.map_or(0.0, |place| place[axis] as f32);
                picture.push_channel("position", name, self.positions.iter().map(value).collect());
            }
        }
        if layers.uv {
            for (axis, name) in ["U", "V"].into_iter().enumerate() {
                let value = |place: &Option<Vec2>| place.map_or(0.0, |place| place[axis]);
                picture.push_channel("uv", name, self.uvs.iter().map(value).collect());
            }
        }
        if layers.ids {
            for (kind, layer) in ["CryptoObject", "CryptoMaterial"].into_iter().enumerate() {
                let pixel = |ids: &BTreeMap<[u32; 2], u32>| {
                    ids.iter().map(|(id, &count)| (id[kind], share(count, MOST_FOR_IDS))).collect()
                };
                let coverage: Vec<Vec<(u32, f32)>> = self.ids.iter().map(pixel).collect();
                picture.push_matte(&Matte { layer, names: &self.surfaces.names[kind], coverage: &coverage });
            }
        }
    }
}
