//! What a material's microfacets do where no texture has a say in it (`shaders/lib/surface.wgsl` says the same of textures).

use std::collections::BTreeMap;

use glam::Vec3;

use crate::math::ggx_albedo::{GgxAlbedo, MIN_ALPHA, SIZE};
use crate::scene::{MIN_REFRACTED_SPREAD, Material};

/// Smallest index of refraction with a finite lobe; at 1 there is no half vector.
const MIN_ROUGH_ETA: f32 = 1.02;

/// The parameters of the BSDF, but for the base colour.
#[derive(Default)]
pub struct Microfacet {
    /// Reflectance of the opaque dielectric's interface at normal incidence, and at grazing incidence.
    pub f0: Vec3,
    pub f90: f32,
    /// GGX width.
    pub alpha: f32,
    /// Index inside over that outside.
    pub eta: f32,
    /// 1 / (1 - average albedo of the interface).
    pub inv_base_average: f32,
    /// Of the table of albedos.
    pub row: u32,
}

/// The table of albedos as kernels have it: all of it, or the rows of the alphas that materials have, each once.
pub struct AlbedoTable {
    pub texels: Vec<[f32; 2]>,
    /// By the bits of alpha; `None`: all of the table.
    rows: Option<BTreeMap<u32, u32>>,
}

impl AlbedoTable {
    pub fn new(is_whole: bool) -> Self {
        match is_whole {
            true => Self { texels: GgxAlbedo::get().texels.clone(), rows: None },
            false => Self { texels: Vec::new(), rows: Some(BTreeMap::new()) },
        }
    }

    /// By the material's factors alone.
    pub fn microfacet(&mut self, material: &Material) -> Microfacet {
        let mut eta = material.ior;
        let mut alpha = (material.roughness * material.roughness).max(MIN_ALPHA as f32);
        if !material.is_delta() && material.volume && material.transmission > 0.0 {
            eta = eta.max(MIN_ROUGH_ETA);
            alpha = alpha.max(MIN_REFRACTED_SPREAD / (eta - 1.0));
        }
        let r = (material.ior - 1.0) / (material.ior + 1.0);
        let f0 = (r * r * material.specular_color).min(Vec3::ONE) * material.specular;
        let f90 = material.specular;
        let [a, b] = GgxAlbedo::get().average(f64::from(alpha));
        let average = f64::from(f0.max_element()) * a + f64::from(f90) * b;
        let inv_base_average = if average < 1.0 { (1.0 / (1.0 - average)) as f32 } else { 0.0 };
        Microfacet { f0, f90, alpha, eta, inv_base_average, row: self.row(alpha) }
    }

    fn row(&mut self, alpha: f32) -> u32 {
        let Some(rows) = &mut self.rows else { return 0 };
        *rows.entry(alpha.to_bits()).or_insert_with(|| {
            let row = self.texels.len() / SIZE;
            self.texels.extend(GgxAlbedo::get().row(f64::from(alpha)));
            row as u32
        })
    }
}
