//! How much a GGX lobe reflects in all directions together, tabulated for the diffuse layer below it
//! (`shaders/lib/ggx_albedo.wgsl`).

use std::f64::consts::PI;
use std::sync::OnceLock;

use rayon::prelude::*;

/// Nodes along each side of the table.
pub const SIZE: usize = 32;
/// Narrowest finite GGX lobe: the table begins there, and everything narrower is a delta lobe or widened.
pub const MIN_ALPHA: f64 = 1e-3;
/// The table is this much above the integral. Interpolation falls below it by at most 0.52 %, and where a
/// table is too low the layers together would reflect more than arrives.
pub const MARGIN: f64 = 1.006;

/// Directional albedo of the single-scattering GGX lobe (Smith, height-correlated) under Schlick's reflectance:
/// E(cos, alpha) = f0 a + f90 b.
#[derive(Clone, Debug)]
pub struct GgxAlbedo {
    /// (a, b): [`SIZE`] rows by the fourth root of alpha, from [`MIN_ALPHA`] to 1, of [`SIZE`] columns by the
    /// fourth root of the cosine, from 0 to 1; then one row by alpha with the averages over the cosine-weighted
    /// hemisphere of the rows' interpolants. Fourth roots because albedos change quickly where the cosine is
    /// about alpha, at every alpha.
    pub texels: Vec<[f32; 2]>,
}

impl GgxAlbedo {
    /// The table, integrated when it is first asked for, by all threads: not for the first time from within a job of rayon's.
    pub fn get() -> &'static Self {
        static TABLE: OnceLock<GgxAlbedo> = OnceLock::new();
        TABLE.get_or_init(Self::integrate)
    }

    /// In f64; some ten milliseconds.
    fn integrate() -> Self {
        let rows: Vec<Vec<[f64; 2]>> = (0..SIZE)
            .into_par_iter()
            .map(|row| {
                let root = lerp(MIN_ALPHA.powf(0.25), 1.0, node(row));
                (0..SIZE).map(|column| directional_albedo(node(column).powi(4), root.powi(4))).collect()
            })
            .collect();
        let averages = rows.iter().map(|row| [0, 1].map(|part| hemisphere_average(row, part)));
        let texels = rows.iter().flatten().copied().chain(averages);
        Self { texels: texels.map(|texel| texel.map(|x| (MARGIN * x) as f32)).collect() }
    }

    /// (a, b) at a cosine in [0, 1] and an alpha in [[`MIN_ALPHA`], 1]: the twin of the shader's look-up.
    pub fn directional(&self, cos_theta: f64, alpha: f64) -> [f64; 2] {
        let (row, weight) = cell(alpha_position(alpha));
        let [low, high] = [row, row + 1].map(|row| self.along(row, cos_theta.powf(0.25)));
        [0, 1].map(|part| lerp(low[part], high[part], weight))
    }

    /// What [`Self::directional`] is at the nodes of the cosine, for one alpha.
    pub fn row(&self, alpha: f64) -> Vec<[f32; 2]> {
        let (row, weight) = cell(alpha_position(alpha));
        let nodes = self.texels[row * SIZE..][..SIZE].iter().zip(&self.texels[(row + 1) * SIZE..]);
        nodes
            .map(|(low, high)| [0, 1].map(|part| lerp(low[part].into(), high[part].into(), weight) as f32))
            .collect()
    }

    /// The cosine-weighted average of [`Self::directional`] over the hemisphere.
    pub fn average(&self, alpha: f64) -> [f64; 2] {
        self.along(SIZE, alpha_position(alpha))
    }

    fn along(&self, row: usize, position: f64) -> [f64; 2] {
        let (index, weight) = cell(position);
        let [low, high] = [index, index + 1].map(|column| self.texels[row * SIZE + column]);
        [0, 1].map(|part| lerp(low[part].into(), high[part].into(), weight))
    }
}

fn node(index: usize) -> f64 {
    index as f64 / (SIZE - 1) as f64
}

/// From [`MIN_ALPHA`]..1 to 0..1.
fn alpha_position(alpha: f64) -> f64 {
    let lowest = MIN_ALPHA.powf(0.25);
    (alpha.powf(0.25) - lowest) / (1.0 - lowest)
}

/// The node below a position in [0, 1] and how far beyond it lies.
fn cell(position: f64) -> (usize, f64) {
    let position = position * (SIZE - 1) as f64;
    let index = (position as usize).min(SIZE - 2);
    (index, position - index as f64)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Quadrature points: heights of the cap, and azimuths of half a turn (the other half is its mirror image).
const HEIGHTS: usize = 64;
const AZIMUTHS: usize = 32;

/// (a, b), integrated over the visible normals: the integrand is then Schlick's weight times G2 / G1.
/// Normals come from the spherical cap of Dupuy and Benyoub 2023; the error is below 1e-3.
fn directional_albedo(cos_theta: f64, alpha: f64) -> [f64; 2] {
    // At the horizon itself, the limit.
    let cos_theta = cos_theta.max(1e-9);
    let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
    let length = |cos: f64| (alpha * alpha * (1.0 - cos * cos).max(0.0) + cos * cos).sqrt();
    let (x, z) = (alpha * sin_theta / length(cos_theta), cos_theta / length(cos_theta));
    let mut sum = [0.0; 2];
    for i in 0..HEIGHTS {
        // Nodes crowd at both ends, where the integrand has kinks: u = s^2 (3 - 2 s).
        let s = (i as f64 + 0.5) / HEIGHTS as f64;
        let (u, weight) = (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s));
        let below_top = u * (1.0 + z);
        let radius = (below_top * (2.0 - below_top)).sqrt();
        for j in 0..AZIMUTHS {
            let (sin_phi, cos_phi) = (PI * (j as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
            let normal = [alpha * (radius * cos_phi + x), alpha * radius * sin_phi, (1.0 - u) * (1.0 + z)];
            let inv_length = 1.0 / normal.iter().map(|c| c * c).sum::<f64>().sqrt();
            let cos_h = (normal[0] * sin_theta + normal[2] * cos_theta) * inv_length;
            let out_z = 2.0 * cos_h * normal[2] * inv_length - cos_theta;
            if out_z > 0.0 {
                let [towards, away] = [cos_theta, out_z].map(|cos| length(cos) / cos);
                let shadowing = (1.0 + towards) / (towards + away);
                let grazing = (1.0 - cos_h).max(0.0).powi(5);
                sum[0] += weight * (1.0 - grazing) * shadowing;
                sum[1] += weight * grazing * shadowing;
            }
        }
    }
    sum.map(|s| s / (HEIGHTS * AZIMUTHS) as f64)
}

/// 2 * integral of E cos d(cos) with E linear in s = cos^(1/4) between the entries: the integral of 8 E s^7 ds, in
/// closed form for each piece.
fn hemisphere_average(entries: &[[f64; 2]], part: usize) -> f64 {
    (0..SIZE - 1)
        .map(|i| {
            let (s0, s1) = (node(i), node(i + 1));
            let slope = (entries[i + 1][part] - entries[i][part]) / (s1 - s0);
            let constant = entries[i][part] - slope * s0;
            constant * (s1.powi(8) - s0.powi(8)) + 8.0 / 9.0 * slope * (s1.powi(9) - s0.powi(9))
        })
        .sum()
}
