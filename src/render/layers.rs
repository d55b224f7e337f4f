//! What the device hands over, as layers of a picture.

use crate::accel::UnitSpace;
use crate::device::layout::FirstHitPixel;
use crate::film::Layer;

/// Samples that the layers albedo, normal and depth are averaged over.
pub(super) const FIRST_HIT_SAMPLES: u32 = 16;

/// Albedo, normal and depth, from sums over [`FIRST_HIT_SAMPLES`].
pub(super) fn first_hit_layers(hits: &[FirstHitPixel], unit: &UnitSpace) -> [Layer; 3] {
    let samples = FIRST_HIT_SAMPLES as f32;
    let layer = |name: &str, channels: [&str; 3], of: fn(&FirstHitPixel) -> [f32; 3]| Layer {
        name: name.into(),
        channels: (0..3)
            .map(|c| {
                let values = hits.iter().map(|pixel| of(pixel)[c] / samples).collect();
                (channels[c].to_string(), values)
            })
            .collect(),
    };
    // Depth is the mean over the samples that met a surface; infinite where none did.
    let depth = |pixel: &FirstHitPixel| match pixel.hits {
        0 => f32::INFINITY,
        hits => unit.world_length(f64::from(pixel.depth) / f64::from(hits)) as f32,
    };
    let depths = hits.iter().map(depth).collect();
    [
        layer("albedo", ["R", "G", "B"], |pixel| pixel.albedo),
        layer("normal", ["X", "Y", "Z"], |pixel| pixel.normal),
        Layer { name: "depth".into(), channels: vec![("Z".into(), depths)] },
    ]
}
