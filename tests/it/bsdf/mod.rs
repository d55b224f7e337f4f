//! The BSDF of the shaders: energy, densities, reciprocity, numbers at the extremes, and its f64 twin.

mod bent;
mod density;
mod energy;
mod materials;
mod numbers;

use glam::{DVec3, Vec3};

use halfway::device::Feature;

use crate::bsdf_f64::{Bsdf, Factors, albedo_table};
use crate::gpu;

/// Features of a scene with everything; parameters are those of textures, each configuration its own.
pub const ALL_FEATURES: [Feature; 3] =
    [Feature::Transmission, Feature::RoughTransmission, Feature::SurfaceTextures];

/// Imports, the albedo table as a storage buffer, and a configuration: what is sampled and from where.
const HEADER: &str = "
#import lib/shading
#if !lambert_only
@group(0) @binding(7) var<storage, read> albedo_table: array<vec2f>;
fn ggx_albedo_texel(index: u32) -> vec2f { return albedo_table[index]; }
#endif
";

const CONFIG: &str = "
struct Config { factors: SurfaceFactors, w_from: vec3f, from_eye: u32 }
@group(0) @binding(0) var<storage, read> configs: array<Config>;
fn invocation(id: vec3u) -> u32 { return id.x + id.y * 65535u * 64u; }
";

/// `SurfaceFactors`, then a direction and a word.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Config {
    base_color: Vec3,
    metallic: f32,
    specular_color: Vec3,
    specular: f32,
    roughness: f32,
    transmission: f32,
    ior: f32,
    flags: u32,
    pub w_from: Vec3,
    from_eye: u32,
}

impl Config {
    pub fn new(m: &Factors, w_from: Vec3, from_eye: bool) -> Self {
        Self {
            base_color: m.base_color.as_vec3(),
            metallic: m.metallic as f32,
            specular_color: m.specular_color.as_vec3(),
            specular: m.specular as f32,
            roughness: m.roughness as f32,
            transmission: m.transmission as f32,
            ior: m.ior as f32,
            flags: u32::from(m.delta) | u32::from(m.volume) << 1,
            w_from,
            from_eye: from_eye.into(),
        }
    }

    pub fn is_from_eye(&self) -> bool {
        self.from_eye == 1
    }

    /// The twin of exactly these f32 parameters.
    pub fn twin(&self) -> Bsdf {
        Bsdf::new(&Factors {
            base_color: self.base_color.as_dvec3(),
            metallic: self.metallic.into(),
            specular_color: self.specular_color.as_dvec3(),
            specular: self.specular.into(),
            roughness: self.roughness.into(),
            transmission: self.transmission.into(),
            ior: self.ior.into(),
            volume: self.flags & 2 != 0,
            delta: self.flags & 1 != 0,
        })
    }
}

/// A `BsdfSample` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Sample {
    pub w: Vec3,
    pub pdf_solid: f32,
    pub weight: Vec3,
    pub event: u32,
}

/// Every configuration with every u, configurations outermost.
pub fn sample(configs: &[Config], us: &[Vec3]) -> Vec<Sample> {
    let kernel = format!(
        "{HEADER}{CONFIG}
        @group(0) @binding(1) var<storage, read> us: array<vec4f>;
        @group(0) @binding(2) var<storage, read_write> samples: array<BsdfSample>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = invocation(id);
            if index >= {}u {{ return; }}
            let config = configs[index / {count}u];
            let s = surface_from_factors(config.factors);
            samples[index] = bsdf_sample(s, config.w_from, us[index % {count}u].xyz, config.from_eye == 1u);
        }}",
        configs.len() * us.len(),
        count = us.len(),
    );
    let us: Vec<_> = us.iter().map(|u| u.extend(0.0)).collect();
    let total = configs.len() * us.len();
    let output = gpu::run(
        &kernel,
        &ALL_FEATURES,
        &[
            ("configs", bytemuck::cast_slice(configs)),
            ("us", bytemuck::cast_slice(&us)),
            ("albedo_table", bytemuck::cast_slice(&albedo_table().texels)),
        ],
        &[("samples", total * size_of::<Sample>())],
        total as u32,
    );
    bytemuck::pod_collect_to_vec(&output[0])
}

/// What `statements` make of the surface `s` of each configuration: a `Found`, which `declaration` declares.
pub fn of_surfaces<T: bytemuck::Pod>(configs: &[Config], declaration: &str, statements: &str) -> Vec<T> {
    let kernel = format!(
        "{HEADER}{CONFIG}
        {declaration}
        @group(0) @binding(1) var<storage, read_write> found: array<Found>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            if id.x >= arrayLength(&configs) {{ return; }}
            let s = surface_from_factors(configs[id.x].factors);
            {statements}
        }}"
    );
    let output = gpu::run(
        &kernel,
        &ALL_FEATURES,
        &[
            ("configs", bytemuck::cast_slice(configs)),
            ("albedo_table", bytemuck::cast_slice(&albedo_table().texels)),
        ],
        &[("found", configs.len() * size_of::<T>())],
        configs.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&output[0])
}

/// `bsdf_eval(w_from as the eye, w_to)`, and the density of going from `w_from` to `w_to`.
pub fn evaluate(queries: &[(Config, Vec3)]) -> Vec<(Vec3, f32)> {
    let kernel = format!(
        "{HEADER}{CONFIG}
        @group(0) @binding(1) var<storage, read> ws: array<vec4f>;
        @group(0) @binding(2) var<storage, read_write> values: array<vec4f>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3u) {{
            let index = invocation(id);
            if index >= {}u {{ return; }}
            let config = configs[index];
            let s = surface_from_factors(config.factors);
            let w = ws[index].xyz;
            values[index] = vec4f(bsdf_eval(s, config.w_from, w), bsdf_pdf_solid(s, config.w_from, w));
        }}",
        queries.len(),
    );
    let configs: Vec<Config> = queries.iter().map(|(config, _)| *config).collect();
    let ws: Vec<_> = queries.iter().map(|(_, w)| w.extend(0.0)).collect();
    let output = gpu::run(
        &kernel,
        &ALL_FEATURES,
        &[
            ("configs", bytemuck::cast_slice(&configs)),
            ("ws", bytemuck::cast_slice(&ws)),
            ("albedo_table", bytemuck::cast_slice(&albedo_table().texels)),
        ],
        &[("values", queries.len() * 16)],
        queries.len() as u32,
    );
    let values: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&output[0]);
    values.into_iter().map(|[r, g, b, pdf]| (Vec3::new(r, g, b), pdf)).collect()
}

/// A white opaque dielectric.
const DIELECTRIC: Factors = Factors {
    base_color: DVec3::ONE,
    metallic: 0.0,
    specular_color: DVec3::ONE,
    specular: 1.0,
    roughness: 0.5,
    transmission: 0.0,
    ior: 1.5,
    volume: false,
    delta: false,
};

/// White materials with finite lobes, each kind of lobe and mixture at least once.
pub fn white_materials() -> Vec<(&'static str, Factors)> {
    let metal = Factors { metallic: 1.0, ..DIELECTRIC };
    let pane = Factors { transmission: 1.0, ..DIELECTRIC };
    let glass = Factors { volume: true, ..pane };
    vec![
        ("lambert", Factors { specular: 0.0, ..DIELECTRIC }),
        ("dielectric", DIELECTRIC),
        ("polished dielectric", Factors { roughness: 0.1, ..DIELECTRIC }),
        ("chalky dielectric", Factors { roughness: 1.0, ior: 2.0, ..DIELECTRIC }),
        ("metal", metal),
        ("rough metal", Factors { roughness: 1.0, ..metal }),
        ("narrow metal", Factors { roughness: 0.032, ..metal }),
        ("half metal", Factors { metallic: 0.5, ..DIELECTRIC }),
        ("pane", pane),
        ("half pane", Factors { transmission: 0.5, roughness: 0.7, ..pane }),
        ("glass", glass),
        ("rough glass", Factors { roughness: 0.9, ..glass }),
        ("half glass", Factors { transmission: 0.5, metallic: 0.3, ..glass }),
        ("narrow glass", Factors { roughness: 0.032, ..glass }),
        ("faint glass", Factors { ior: 1.0, transmission: 0.6, ..glass }),
    ]
}

/// The same with colours everywhere.
pub fn coloured_materials() -> Vec<(&'static str, Factors)> {
    let colours = |(name, white)| {
        let coloured = Factors {
            base_color: DVec3::new(0.9, 0.5, 0.1),
            specular_color: DVec3::new(0.3, 1.0, 2.0),
            specular: if name == "lambert" { 0.0 } else { 0.8 },
            ..white
        };
        (name, coloured)
    };
    white_materials().into_iter().map(colours).collect()
}

/// A unit direction by its cosine and azimuth, rounded to f32.
pub fn direction(cos: f64, azimuth: f64) -> Vec3 {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos).as_vec3()
}

/// Evenly spread points of the unit cube: Hammersley's.
pub fn even_points(count: usize) -> Vec<DVec3> {
    let radical_inverse = |mut i: usize, base: usize| {
        let (mut value, mut scale) = (0.0, 1.0);
        while i > 0 {
            scale /= base as f64;
            value += (i % base) as f64 * scale;
            i /= base;
        }
        value
    };
    let point = |i| DVec3::new((i as f64 + 0.5) / count as f64, radical_inverse(i, 2), radical_inverse(i, 3));
    (0..count).map(point).collect()
}

/// The albedo in f64: the mean weight of the twin's own sampler.
pub fn twin_albedo(bsdf: &Bsdf, w: DVec3, from_eye: bool, points: usize) -> DVec3 {
    let sum: DVec3 = even_points(points)
        .into_iter()
        .filter_map(|u| bsdf.sample(w, u.to_array(), from_eye))
        .map(|sample| sample.weight)
        .sum();
    sum / points as f64
}
