//! From scene-linear radiance to what a screen shows.

/// How radiance becomes display colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ViewTransform {
    /// Khronos PBR Neutral: base colours as they are, highlights compressed.
    #[default]
    Neutral,
    /// Clamped to what sRGB can show.
    Srgb,
    /// AgX: filmic, bright colours fade to white.
    Agx,
}

impl ViewTransform {
    /// Linear Rec.709 radiance to linear Rec.709 display light in [0, 1]; `exposure` counts in stops (factor 2).
    pub fn display(self, exposure: f32, radiance: [f32; 3]) -> [f32; 3] {
        let gain = exposure.exp2();
        // The curves make NaN of infinity.
        let color = radiance.map(|channel| (channel * gain).clamp(-f32::MAX, f32::MAX));
        let shown = match self {
            Self::Neutral => neutral(color.map(|channel| channel.max(0.0))),
            Self::Srgb => color,
            Self::Agx => agx(color.map(|channel| channel.max(0.0))),
        };
        shown.map(|channel| channel.clamp(0.0, 1.0))
    }
}

/// Khronos PBR Neutral tone mapper, the reference code of <https://github.com/KhronosGroup/ToneMapping>.
fn neutral(color: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let lowest = color[0].min(color[1]).min(color[2]);
    let offset = if lowest < 0.08 { lowest - 6.25 * lowest * lowest } else { 0.04 };
    let color = color.map(|channel| channel - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < START {
        return color;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|channel| {
        let compressed = channel * (new_peak / peak);
        compressed + (new_peak - compressed) * white
    })
}

/// AgX base look by Benjamin Wrensch's fit of Troy Sobotka's transform,
/// <https://iolite-engine.com/blog_posts/minimal_agx_implementation> (MIT).
fn agx(color: [f32; 3]) -> [f32; 3] {
    const INSET: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_656, 0.078_433_6, 0.879_143],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_636, -0.098_043_45, 1.151_073_7],
    ];
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    let encoded = multiply(&INSET, color).map(|channel| {
        let stops = channel.log2().clamp(MIN_EV, MAX_EV);
        agx_contrast((stops - MIN_EV) / (MAX_EV - MIN_EV))
    });
    // The fit ends in display values of a pure 2.2 power screen.
    multiply(&OUTSET, encoded).map(|channel| channel.max(0.0).powf(2.2))
}

fn agx_contrast(x: f32) -> f32 {
    let x2 = x * x;
    let x4 = x2 * x2;
    15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.002_32
}

fn multiply(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Linear light in [0, 1] to the sRGB signal (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The sRGB signal in [0, 1] to linear light (IEC 61966-2-1).
pub fn srgb_decode(signal: f32) -> f32 {
    if signal <= 0.040_45 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }
}
