//! Made-up training sets: a box in which light goes from every place to the opposite one, mostly.

use glam::Vec3;
use halfway::device::scene::{LightSourceInfo, SourceKind};
use halfway::subspace::{
    Connections, Feature, LightEnd, LightSample, Settings, SubspaceError, TrainingInput, TrainingNode,
    TrainingPath, TrainingSet,
};

use crate::random::Stream;

pub struct Data {
    pub set: TrainingSet,
    pub light_samples: Vec<LightSample>,
    pub light_paths: u64,
    pub lights: Vec<LightSourceInfo>,
    /// Connections of each path.
    pub path_lengths: Vec<usize>,
}

impl Data {
    pub fn train(&self, settings: &Settings) -> halfway::subspace::Model {
        self.try_train(settings).expect("a model")
    }

    pub fn try_train(&self, settings: &Settings) -> Result<halfway::subspace::Model, SubspaceError> {
        let input = TrainingInput {
            set: &self.set,
            light_samples: &self.light_samples,
            light_paths: self.light_paths,
            lights: &self.lights,
            scene_hash: 7,
            connections: Connections::even(3),
            seed: 0,
        };
        halfway::subspace::train(&input, settings.clone())
    }
}

pub fn unit(stream: &mut Stream) -> Vec3 {
    loop {
        let v = 2.0 * Vec3::new(stream.f32(), stream.f32(), stream.f32()) - 1.0;
        if v.length_squared() > 0.01 && v.length_squared() <= 1.0 {
            return v.normalize();
        }
    }
}

/// A point on a wall of the unit cube, facing inwards.
pub fn feature(stream: &mut Stream) -> Feature {
    let mut position = Vec3::new(stream.f32(), stream.f32(), stream.f32());
    let (axis, upper) = (stream.word() as usize % 3, stream.word().is_multiple_of(2));
    let mut normal = Vec3::ZERO;
    position[axis] = if upper { 1.0 } else { 0.0 };
    normal[axis] = if upper { -1.0 } else { 1.0 };
    Feature { position, normal, direction: unit(stream) }
}

/// Two halves of a quad, a small triangle, an environment and a point light.
pub fn lights() -> Vec<LightSourceInfo> {
    let triangle = |x: f32, area: f32, power: f64| LightSourceInfo {
        kind: SourceKind::Triangle { position: Vec3::new(x, 1.0, 0.5), normal: Vec3::NEG_Y, area },
        power,
    };
    let punctual = SourceKind::Punctual { position: Vec3::splat(0.5), direction: Vec3::NEG_Y, cone: 2.0 };
    vec![
        triangle(0.4, 0.1, 2.0),
        triangle(0.6, 0.1, 2.0),
        triangle(0.9, 1e-4, 0.1),
        LightSourceInfo { kind: SourceKind::Environment, power: 3.0 },
        LightSourceInfo { kind: punctual, power: 1.0 },
    ]
}

fn light_end(stream: &mut Stream, eye: Option<&Feature>, lights: u32) -> LightEnd {
    if stream.f32() < 0.4 {
        let light = stream.word() % lights;
        // Twice as far as the diagonal is reflected.
        let (b1, b2) = (stream.f32(), stream.f32());
        let at = if b1 + b2 > 1.0 { [1.0 - b1, 1.0 - b2] } else { [b1, b2] };
        return LightEnd::Source { light, at: if light == 4 { [0.0; 2] } else { at } };
    }
    let mut feature = feature(stream);
    if let Some(eye) = eye {
        feature.position = 0.3 * feature.position + 0.7 * (Vec3::ONE - eye.position);
    }
    LightEnd::Surface(feature)
}

/// So many training paths of one to three connections, and half as many light vertices.
pub fn data(paths: usize, seed: u64) -> Data {
    let mut stream = Stream::new(seed);
    let lights = lights();
    let mut set = TrainingSet::new(64, 48);
    let mut path_lengths = Vec::new();
    for _ in 0..paths {
        let tile = set.tile_of(stream.word() % 64, stream.word() % 48);
        let count = 1 + stream.word() % 3;
        let nodes: Vec<TrainingNode> = (0..count)
            .map(|_| {
                let eye = feature(&mut stream);
                let light = light_end(&mut stream, Some(&eye), lights.len() as u32);
                TrainingNode { eye, light, towards: Vec3::Y, mass: stream.f32() }
            })
            .collect();
        let p0 = if stream.f32() < 0.3 { 0.0 } else { stream.f32() };
        let contribution = 0.1 + stream.f32() * stream.f32();
        path_lengths.push(nodes.len());
        let path = TrainingPath { tile, contribution, share: 1.0, p0, eye_edges: count, light_path: 0 };
        set.push_path(set.paths().len() as u32, path, &nodes);
    }
    let light_samples = (0..paths / 2)
        .map(|_| LightSample { end: light_end(&mut stream, None, lights.len() as u32), weight: stream.f32() })
        .collect();
    Data { set, light_samples, light_paths: paths as u64 / 4 + 1, lights, path_lengths }
}
