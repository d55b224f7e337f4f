//! A picture of where a picture is wrong.

use super::png::to_byte;

/// The relative errors at the two ends of the colours.
pub const SCALE: [f64; 2] = [1e-3, 1.0];

/// What the colours mean, for the user.
pub const LEGEND: &str =
    "black 0.1 % or less, violet 1 %, orange 10 %, pale yellow 100 % or more (logarithmic)";

/// sRGB colours of relative errors by their logarithm between the ends of [`SCALE`].
pub fn colors(relative_error: &[f64]) -> Vec<[u8; 3]> {
    let span = (SCALE[1] / SCALE[0]).ln();
    relative_error.iter().map(|&error| inferno((error / SCALE[0]).ln() / span)).collect()
}

/// matplotlib's colour map `inferno`, dark to light evenly for the eye: Matt Zucker's polynomial,
/// <https://www.shadertoy.com/view/WlfXRN> (CC0). `t` is held in [0, 1].
fn inferno(t: f64) -> [u8; 3] {
    const COEFFICIENTS: [[f64; 7]; 3] = [
        [
            0.000_218_940_369_119_226_5,
            0.106_513_419_485_611_6,
            11.602_493_082_471_87,
            -41.703_996_131_394_59,
            77.162_935_699_427,
            -71.319_428_244_992_14,
            25.131_126_224_773_41,
        ],
        [
            0.001_651_004_631_001_012,
            0.563_956_436_788_409_1,
            -3.972_853_965_665_698,
            17.436_398_882_053_13,
            -33.402_358_942_100_92,
            32.626_064_263_977_23,
            -12.242_668_952_385_67,
        ],
        [
            -0.019_480_898_437_091_84,
            3.932_712_388_889_277,
            -15.942_394_106_291_4,
            44.354_145_198_728_13,
            -81.807_309_257_389_93,
            73.209_519_858_032_02,
            -23.070_325_002_871_72,
        ],
    ];
    let t = t.clamp(0.0, 1.0);
    COEFFICIENTS.map(|polynomial| {
        let value = polynomial.iter().rev().fold(0.0, |sum, &coefficient| sum * t + coefficient);
        to_byte(value.clamp(0.0, 1.0) as f32)
    })
}
