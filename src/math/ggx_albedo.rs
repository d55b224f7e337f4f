//! How much a GGX lobe reflects in all directions together, tabulated for the diffuse layer below it (`shaders/lib/ggx_albedo.wgsl`).

use std::f64::consts::TAU;

/// Nodes along each side of the table.
pub const SIZE: usize = 32;

/// Directional albedo of the single-scattering GGX lobe (Smith, height-correlated) under Schlick's reflectance:
/// E(cos, alpha) = f0 a + f90 b.
#[derive(Clone, Debug)]
pub struct GgxAlbedo {
    /// (a, b): [`SIZE`] rows by sqrt(alpha) of [`SIZE`] columns by sqrt(cos), both on [0, 1], then one row by
    /// sqrt(alpha) with the averages over the cosine-weighted hemisphere of the rows' linear interpolants.
    pub texels: Vec<[f32; 2]>,
}

impl Default for GgxAlbedo {
    fn default() -> Self {
        Self::new()
    }
}

impl GgxAlbedo {
    /// Integrates the table in f64; a few ten milliseconds.
    pub fn new() -> Self {
        let node = |index: usize| index as f64 / (SIZE - 1) as f64;
        let mut texels = Vec::with_capacity((SIZE + 1) * SIZE);
        let mut averages = Vec::with_capacity(SIZE);
        for row in 0..SIZE {
            let alpha = node(row) * node(row);
            let entries: Vec<[f64; 2]> = (0..SIZE)
                .map(|column| directional_albedo(node(column) * node(column), alpha, NODES))
                .collect();
            averages.push([0, 1].map(|part| hemisphere_average(&entries, part) as f32));
            texels.extend(entries.iter().map(|entry| entry.map(|x| x as f32)));
        }
        texels.extend(averages);
        Self { texels }
    }

    /// (a, b) at a cosine and an alpha in [0, 1]: the twin of the shader's bilinear look-up.
    pub fn directional(&self, cos_theta: f64, alpha: f64) -> [f64; 2] {
        let (row, weight) = cell(alpha);
        let [low, high] = [row, row + 1].map(|row| self.along(row, cos_theta));
        [0, 1].map(|part| lerp(low[part], high[part], weight))
    }

    /// The cosine-weighted average of [`Self::directional`] over the hemisphere.
    pub fn average(&self, alpha: f64) -> [f64; 2] {
        self.along(SIZE, alpha)
    }

    fn along(&self, row: usize, x: f64) -> [f64; 2] {
        let (index, weight) = cell(x);
        let [low, high] = [index, index + 1].map(|column| self.texels[row * SIZE + column]);
        [0, 1].map(|part| lerp(low[part].into(), high[part].into(), weight))
    }
}

fn cell(x: f64) -> (usize, f64) {
    let position = x.sqrt() * (SIZE - 1) as f64;
    let index = (position as usize).min(SIZE - 2);
    (index, position - index as f64)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Quadrature points in each dimension of the visible normals.
const NODES: usize = 64;

/// (a, b) by the midpoint rule over the unit square that maps to visible normals (Heitz 2018, listing 3, whose
/// integrand is then just Schlick's weight times G2 / G1).
fn directional_albedo(cos_theta: f64, alpha: f64, nodes: usize) -> [f64; 2] {
    // At the horizon itself, the limit.
    let cos_theta = cos_theta.max(1e-9);
    let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
    let stretched = (alpha * alpha * sin_theta * sin_theta + cos_theta * cos_theta).sqrt();
    let (x, z) = (alpha * sin_theta / stretched, cos_theta / stretched);
    let mut sum = [0.0; 2];
    for i in 0..nodes {
        let u = (i as f64 + 0.5) / nodes as f64;
        let radius = u.sqrt();
        for j in 0..nodes {
            let phi = TAU * (j as f64 + 0.5) / nodes as f64;
            let across = radius * phi.cos();
            let disk = (1.0 - across * across).max(0.0).sqrt();
            let along = 0.5 * ((1.0 - z) * disk + (1.0 + z) * radius * phi.sin());
            let height = (1.0 - across * across - along * along).max(0.0).sqrt();
            // About the stretched direction (x, 0, z): axes (0, 1, 0) and (-z, 0, x); then unstretched.
            let normal = [alpha * (height * x - along * z), alpha * across, height * z + along * x];
            let inv_length = 1.0 / normal.iter().map(|c| c * c).sum::<f64>().sqrt();
            let cos_h = (normal[0] * sin_theta + normal[2] * cos_theta) * inv_length;
            let out_z = 2.0 * cos_h * normal[2] * inv_length - cos_theta;
            if out_z > 0.0 && cos_h > 0.0 {
                let lengths =
                    [cos_theta, out_z].map(|c| (alpha * alpha * (1.0 - c * c).max(0.0) + c * c).sqrt() / c);
                let shadowing = (1.0 + lengths[0]) / (lengths[0] + lengths[1]);
                let grazing = (1.0 - cos_h).max(0.0).powi(5);
                sum[0] += (1.0 - grazing) * shadowing;
                sum[1] += grazing * shadowing;
            }
        }
    }
    sum.map(|s| s / (nodes * nodes) as f64)
}

/// 2 * integral of E cos d(cos) with E linear in sqrt(cos) between the entries: with s = sqrt(cos) the integral
/// of 4 E s^3 ds, in closed form for each piece.
fn hemisphere_average(entries: &[[f64; 2]], part: usize) -> f64 {
    let node = |index: usize| index as f64 / (SIZE - 1) as f64;
    (0..SIZE - 1)
        .map(|i| {
            let (s0, s1) = (node(i), node(i + 1));
            let slope = (entries[i + 1][part] - entries[i][part]) / (s1 - s0);
            let constant = entries[i][part] - slope * s0;
            constant * (s1.powi(4) - s0.powi(4)) + 0.8 * slope * (s1.powi(5) - s0.powi(5))
        })
        .sum()
}
