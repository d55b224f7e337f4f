//! What the host makes of a material once is what the shader makes of it at each hit where textures have a say.

use glam::Vec3;
use halfway::device::scene::microfacet::AlbedoTable;
use halfway::math::ggx_albedo::SIZE;
use halfway::scene::Material;

use super::{Config, Factors, of_surfaces};

const COSINES: [f32; 4] = [1e-6, 0.03, 0.4, 1.0];

/// Mirrors and narrow lobes, indices about that of the surroundings, panes and volumes, reflectances that are cut at one.
fn materials() -> Vec<Material> {
    let mut materials = Vec::new();
    for roughness in [0.0, 1e-3, 0.1, 0.37, 1.0] {
        for ior in [1.0, 1.000_1, 1.02, 1.5, 8.0] {
            for (metallic, transmission, volume) in
                [(0.0, 0.0, false), (1.0, 0.0, false), (0.3, 0.5, true), (0.0, 1.0, true), (0.0, 1.0, false)]
            {
                for (specular, color) in [(0.0, 1.0), (1.0, 1.0), (0.7, 30.0)] {
                    materials.push(Material {
                        roughness,
                        ior,
                        metallic,
                        transmission,
                        volume,
                        specular,
                        specular_color: Vec3::new(color, 0.5, 0.0),
                        ..Material::default()
                    });
                }
            }
        }
    }
    materials
}

#[test]
fn microfacets_are_alike_on_host_and_device() {
    let materials = materials();
    let configs: Vec<Config> = materials
        .iter()
        .map(|material| {
            let factors = Factors {
                base_color: material.base_color.as_dvec3(),
                metallic: material.metallic.into(),
                specular_color: material.specular_color.as_dvec3(),
                specular: material.specular.into(),
                roughness: material.roughness.into(),
                transmission: material.transmission.into(),
                ior: material.ior.into(),
                volume: material.volume && material.transmission > 0.0,
                delta: material.is_delta(),
            };
            Config::new(&factors, Vec3::Z, true)
        })
        .collect();
    let cosines = COSINES.map(|cosine| format!("{cosine:e}")).join(", ");
    let declaration = "struct Found {
        f0: vec3f, f90: f32, alpha: f32, eta: f32, inv_base_average: f32, pad: f32, albedo: array<vec2f, 4>,
    }";
    let statements = format!(
        "var cosines = array<f32, 4>({cosines});
        var one = Found(s.f0, s.f90, s.alpha, s.eta, s.inv_base_average, 0.0, array<vec2f, 4>());
        for (var i = 0u; i < 4u; i++) {{ one.albedo[i] = lobe_albedo(s, cosines[i]); }}
        found[id.x] = one;"
    );
    let found: Vec<[f32; 16]> = of_surfaces(&configs, declaration, &statements);
    let mut table = AlbedoTable::new(false);
    for (material, found) in materials.iter().zip(found) {
        let facets = table.microfacet(material);
        let mut expected = facets.f0.to_array().to_vec();
        expected.extend([facets.f90, facets.alpha, facets.eta, facets.inv_base_average, 0.0]);
        let row = &table.texels[facets.row as usize * SIZE..][..SIZE];
        for cosine in COSINES {
            let position = cosine.powf(0.25) * (SIZE - 1) as f32;
            let index = (position as usize).min(SIZE - 2);
            let weight = position - index as f32;
            expected
                .extend([0, 1].map(|part| row[index][part] * (1.0 - weight) + row[index + 1][part] * weight));
        }
        for (number, (found, expected)) in found.into_iter().zip(expected).enumerate() {
            let near = (found - expected).abs() <= 2e-5 * expected.abs().max(1e-3);
            assert!(near, "number {number}: {found} on the device, {expected} on the host: {material:?}");
        }
    }
    assert!(table.texels.len() < 12 * SIZE, "each alpha has one row");
}
