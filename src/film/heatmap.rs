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
    relative_error.iter().map(|&error| color(&INFERNO, (error / SCALE[0]).ln() / span)).collect()
}

/// Three polynomials in t, in [0, 1].
pub type ColorMap = [[f64; 7]; 3];

/// matplotlib's colour maps, dark to light evenly for the eye, as Matt Zucker's polynomials,
/// <https://www.shadertoy.com/view/WlfXRN> (CC0).
pub const INFERNO: ColorMap = [
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
/// See [`INFERNO`]; its darkest colour is no black.
pub const VIRIDIS: ColorMap = [
    [
        0.277_727_327_223_417_7,
        0.105_093_043_108_577_4,
        -0.330_861_828_725_556_3,
        -4.634_230_498_983_486,
        6.228_269_936_347_081,
        4.776_384_997_670_288,
        -5.435_455_855_934_631,
    ],
    [
        0.005_407_344_544_966_578,
        1.404_613_529_898_575,
        0.214_847_559_468_213,
        -5.799_100_973_351_585,
        14.179_933_366_805_09,
        -13.745_145_377_746_01,
        4.645_852_612_178_535,
    ],
    [
        0.334_099_805_335_306_1,
        1.384_590_162_594_685,
        0.095_095_163_028_236_59,
        -19.332_440_956_279_87,
        56.690_552_600_681_05,
        -65.353_032_633_372_34,
        26.312_435_249_583_2,
    ],
];

/// The sRGB colour at `t`, which is held in [0, 1].
pub fn color(map: &ColorMap, t: f64) -> [u8; 3] {
    let t = t.clamp(0.0, 1.0);
    map.map(|polynomial| {
        let value = polynomial.iter().rev().fold(0.0, |sum, &coefficient| sum * t + coefficient);
        to_byte(value.clamp(0.0, 1.0) as f32)
    })
}
