//! The light from infinitely far away.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::{DVec3, Vec3, Vec3A};
use rayon::prelude::*;

use super::warning::Warning;
use crate::picture_file::{PictureFile, PictureFileError, split_layer};
use crate::scene::SceneError;

/// The most texels along an edge of an [`EqualAreaMap`].
const MAX_SIZE: u32 = 4096;
/// The fewest: even a coarse picture is a smooth function of direction, since it is interpolated.
const MIN_SIZE: u32 = 256;
/// Edge of a texel, in radians, of maps with more than 1024 texels along theirs.
const SMALL_EDGE: f64 = 3e-3;

/// A latitude-longitude picture of radiance, interpolated bilinearly between texel centres.
///
/// Seen from inside: the middle of the picture (u = 1/2) looks along -z, u = 3/4 along +x, the two ends along +z;
/// row 0 is at +y. The direction of azimuth a = 2 pi (u - 1/2) and polar angle t = pi v is
/// (sin t sin a, cos t, -sin t cos a).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Environment {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// Linear radiance, `width * height` texels, row 0 at the top.
    pub texels: Vec<[f32; 3]>,
    /// Factor on all texels (`--env-scale`).
    pub scale: f32,
    /// Rotation of the surroundings about +y in radians, counter-clockwise seen from above (`--env-rotate`).
    pub rotation: f32,
}

impl Environment {
    /// Reads `.exr`, `.hdr` or `.pfm`, or one layer of it as `FILE#LAYER`; scale 1, no rotation. Texels that are no
    /// radiance are replaced, see [`repair`].
    ///
    /// What could not be honoured is added to `warnings`.
    ///
    /// # Errors
    /// [`SceneError::Picture`]: no such file, no picture, no colours, or infinite texels with nothing finite beside.
    pub fn load(path: &Path, warnings: &mut Vec<Warning>) -> Result<Self, SceneError> {
        let (file, layer) = split_layer(path);
        let fail = |reason| SceneError::from(PictureFileError::Unusable { path: file.clone(), reason });
        let mut picture = PictureFile::read(&file, layer.as_deref())?;
        let mut colors = picture.colors(layer.as_deref()).map_err(fail)?;
        // Gives the memory back: large panoramas are hundreds of megabytes.
        picture.channels = Vec::new();
        let choice = colors.note().map(|note| (note, "choose another with --env FILE#LAYER"));
        let repaired = repair(&mut colors.rgb, picture.width).map_err(fail)?;
        let repaired = repaired.map(|note| (note, "mend the picture if that matters"));
        let notes = picture.notes.into_iter().map(|note| (note, "export it again if that matters"));
        let part = format!("the environment {}", file.display());
        let notes = notes.chain(choice).chain(repaired);
        warnings.extend(notes.map(|(problem, remedy)| Warning::new(&part, problem, remedy)));
        Ok(Self {
            name: file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            width: picture.width,
            height: picture.height,
            texels: colors.rgb,
            scale: 1.0,
            rotation: 0.0,
        })
    }

    /// The largest channel of any texel, before it is scaled.
    pub fn brightest(&self) -> f32 {
        self.texels.as_flattened().iter().fold(0.0, |a: f32, &b| a.max(b))
    }

    /// Radiance from a world direction (towards the environment, any length), scaled and rotated.
    pub fn radiance(&self, world_direction: DVec3) -> DVec3 {
        let d = world_direction.normalize();
        // atan2 keeps the digits near the poles that acos loses.
        let polar = (d.x * d.x + d.z * d.z).sqrt().atan2(d.y);
        let azimuth = d.x.atan2(-d.z) + f64::from(self.rotation).rem_euclid(TAU);
        let turns = azimuth * (1.0 / TAU) + 0.5;
        // Whole columns from the left of the picture before.
        let u = (turns - turns.floor()) * f64::from(self.width) + (f64::from(self.width) - 0.5);
        let texel = |row: u32, column: u32| self.texels[row as usize * self.width as usize + column as usize];
        Between::new(self.height, polar).bilinear(self.width, u, texel).as_dvec3() * f64::from(self.scale)
    }
}

/// Replaces what is no radiance: negative values and NaN by 0, infinite ones by the largest finite value that their
/// channel has anywhere in the picture (of all channels, where it has none above 0). Neighbours would not do: a sun beyond
/// the range of half floats is infinite over many texels. Returns what was done, if anything was.
///
/// # Errors
/// Infinite values and none above 0 that is finite.
fn repair(texels: &mut [[f32; 3]], width: u32) -> Result<Option<String>, String> {
    let negative = |value: &f32| value.is_nan() || *value < 0.0;
    let infinite = |value: &f32| *value == f32::INFINITY;
    let bad = |texel: &[f32; 3]| texel.iter().any(|value| negative(value) || infinite(value));
    let Some(first) = texels.iter().position(bad) else { return Ok(None) };
    let place = format!("the first in column {}, row {}", first % width as usize, first / width as usize);
    let said = texels[first];
    let count = |kind: &dyn Fn(&f32) -> bool| texels.iter().filter(|texel| texel.iter().any(kind)).count();
    let (negatives, infinites) = (count(&negative), count(&infinite));

    let finite =
        texels.iter().flat_map(|texel| texel.iter().copied().enumerate()).filter(|(_, v)| v.is_finite());
    let mut largest = finite.fold([0.0f32; 3], |mut largest, (channel, value)| {
        largest[channel] = largest[channel].max(value);
        largest
    });
    let overall = largest.into_iter().fold(0.0, f32::max);
    largest = largest.map(|value| if value > 0.0 { value } else { overall });
    if infinites > 0 && overall == 0.0 {
        return Err(format!(
            "{infinites} texels are infinite, {place}, and none is finite and above 0; export it again"
        ));
    }
    for texel in texels {
        for (value, largest) in texel.iter_mut().zip(largest) {
            if negative(value) {
                *value = 0.0;
            } else if infinite(value) {
                *value = largest;
            }
        }
    }
    let mut kinds = Vec::new();
    if negatives > 0 {
        kinds.push(format!("{negatives} texels are negative or NaN and count as 0"));
    }
    if infinites > 0 {
        kinds.push(format!(
            "{infinites} texels are infinite and count as the largest finite values, {largest:?}"
        ));
    }
    Ok(Some(format!("{}; {place}: {said:?}", kinds.join("; "))))
}

/// Radiance as a piecewise constant function over the equal-area square of [`crate::math::equal_area`]: the texels'
/// own solid angles are all 4 pi / size^2, so drawing a texel in proportion to its value and a point in it uniformly
/// is an exact importance sampling.
#[derive(Clone, Debug, PartialEq)]
pub struct EqualAreaMap {
    /// Texels along each edge, a power of two.
    pub size: u32,
    /// Radiance, scale and rotation included: `size * size` texels; row y holds the points with y <= size * t < y + 1
    /// of the square's (s, t).
    pub radiance: Vec<[f32; 3]>,
}

impl EqualAreaMap {
    /// Averages the environment over every texel. `None` where it gives no light at all.
    ///
    /// # Errors
    /// [`SceneError::EnvironmentScale`] when scale or rotation is not finite, the scale negative, or the scaled
    /// radiance beyond `f32`.
    pub fn new(environment: &Environment) -> Result<Option<Self>, SceneError> {
        Self::with_size(environment, Self::size_for(environment))
    }

    /// Texels along the edge of the map of an environment: the power of two that gives every texel of the picture about
    /// one of its own, also where the picture's two resolutions differ, as far as 4096 allows.
    pub fn size_for(environment: &Environment) -> u32 {
        let (width, height) = (f64::from(environment.width), f64::from(environment.height));
        let edge = (4.0 * PI).sqrt();
        let wanted = (width * height).sqrt().max(edge * width / TAU).max(edge * height / PI);
        (wanted.ceil() as u32).clamp(MIN_SIZE, MAX_SIZE).next_power_of_two()
    }

    /// As [`EqualAreaMap::new`], with so many texels along each edge, a power of two from 2: a smaller map is blurred.
    ///
    /// # Errors
    /// Those of [`EqualAreaMap::new`].
    pub fn with_size(environment: &Environment, size: u32) -> Result<Option<Self>, SceneError> {
        let Environment { scale, rotation, .. } = *environment;
        let brightest = environment.brightest();
        if !(scale >= 0.0 && rotation.is_finite() && (brightest * scale).is_finite()) {
            return Err(SceneError::EnvironmentScale { scale, rotation, brightest });
        }
        if brightest * scale == 0.0 {
            return Ok(None);
        }
        let rows = widen_polar_texels(environment, edge_of(size));
        let rings = Rings::new(environment, &rows, size);
        // Whole turns of the picture from its left edge to where the azimuth of each quadrant of the square begins, and which
        // way it runs: the square's azimuth runs from +x towards -z, the picture's from -z towards +x.
        let turned = f64::from(rotation).rem_euclid(TAU) / TAU + 0.75;
        let quadrants = [(0.5, -1.0), (0.0, 1.0), (0.5, 1.0), (0.0, -1.0)];
        let quadrants = quadrants.map(|(start, way)| ((turned - start) % 1.0, way));
        let half = size / 2;
        let texel = |index: u32| {
            let [x, y] = [index % size, index / size];
            // From the centre outwards.
            let [x, y] = [(x >= half, x), (y >= half, y)]
                .map(|(outer, at)| (outer, if outer { at - half } else { half - 1 - at }));
            let (start, way) = quadrants[usize::from(x.0) + 2 * usize::from(y.0)];
            rings.mean([x.1, y.1], start, way).map(|channel| (channel * f64::from(scale)) as f32)
        };
        let radiance = (0..size * size).into_par_iter().map(texel).collect();
        Ok(Some(Self { size, radiance }))
    }
}

/// Samples of a picture at one distance from the middle of the equal-area square: they share their polar angle.
#[derive(Clone, Copy, Default)]
struct Ring {
    /// Turns by which the azimuth changes from one sample to the next.
    step: f64,
    rows: Between,
}

/// The rows of a picture between which a polar angle lies, and how near to the second.
#[derive(Clone, Copy, Default)]
struct Between {
    rows: [u32; 2],
    share: f32,
}

impl Between {
    /// The polar angle in [0, pi] is held beyond the centres of the first and last row.
    fn new(height: u32, polar: f64) -> Self {
        let v = (polar * (f64::from(height) / PI) - 0.5).clamp(0.0, f64::from(height - 1));
        let row = v as u32;
        Self { rows: [row, (row + 1).min(height - 1)], share: (v - f64::from(row)) as f32 }
    }

    /// Interpolated value at a column `u`, less than two whole turns from the left; `texel` by row and column.
    fn bilinear(self, width: u32, u: f64, texel: impl Fn(u32, u32) -> [f32; 3]) -> Vec3A {
        let column = u as u32;
        let share = (u - f64::from(column)) as f32;
        // The first and the last column are neighbours.
        let wrap = |column: u32| if column >= width { column - width } else { column };
        let left = wrap(wrap(column));
        let right = wrap(left + 1);
        let along = |row| Vec3A::from(texel(row, left)).lerp(texel(row, right).into(), share);
        let [upper, lower] = self.rows.map(along);
        upper.lerp(lower, self.share)
    }
}

/// The picture as the texels of a map see it, by their distance from the middle of the square, |x| + |y|: what is equal in
/// all of a ring is computed once.
struct Rings<'a> {
    width: u32,
    rows: Vec<&'a [[f32; 3]]>,
    /// Samples along each edge of the texels of each distance.
    samples: Vec<u32>,
    /// By samples along an edge: the first ring, and the rings.
    of: BTreeMap<u32, (u32, Vec<Ring>)>,
}

impl<'a> Rings<'a> {
    fn new(environment: &Environment, rows: &'a [Cow<'_, [[f32; 3]]>], size: u32) -> Self {
        let edge = edge_of(size);
        let samples: Vec<u32> = (0..size.max(2) - 1)
            .map(|distance| {
                let r = ring_r(2.0 * f64::from(distance + 1) / f64::from(size));
                samples_along_edge(environment, edge, r.abs())
            })
            .collect();
        let mut of: BTreeMap<u32, (u32, Vec<Ring>)> = BTreeMap::new();
        for (distance, &count) in samples.iter().enumerate() {
            let (first, rings) = of.entry(count).or_insert((distance as u32 * count, Vec::new()));
            let end = distance as u32 * count + 2 * count - 1;
            while *first + (rings.len() as u32) < end {
                let at = *first + rings.len() as u32;
                rings.push(Ring::new(
                    environment,
                    2.0 * f64::from(at + 1) / f64::from(size * count),
                    size * count,
                ));
            }
        }
        Self { width: environment.width, rows: rows.iter().map(|row| &**row).collect(), samples, of }
    }

    /// Mean over a texel of a quadrant, `x` and `y` counted from the middle of the square. `start`: turns from the left of
    /// the picture to where the quadrant's azimuth begins; `way`: the sign by which it runs.
    fn mean(&self, [x, y]: [u32; 2], start: f64, way: f64) -> [f64; 3] {
        let count = self.samples[(x + y) as usize];
        let (first, rings) = &self.of[&count];
        let width = f64::from(self.width);
        let mut sum = DVec3::ZERO;
        for row in y * count..(y + 1) * count {
            for column in x * count..(x + 1) * count {
                let ring = &rings[(row + column - first) as usize];
                let turns = start + way * (0.125 + ring.step * f64::from(row as i32 - column as i32));
                // Whole columns from the left of the picture before.
                sum += self.bilinear(turns * width + (width - 0.5), ring).as_dvec3();
            }
        }
        (sum / f64::from(count * count)).to_array()
    }

    fn bilinear(&self, u: f64, ring: &Ring) -> Vec3A {
        ring.rows.bilinear(self.width, u, |row, column| self.rows[row as usize][column as usize])
    }
}

/// Edge of a texel, in radians, of a map with so many along its own.
fn edge_of(size: u32) -> f64 {
    (4.0 * PI).sqrt() / f64::from(size)
}

/// r of the equal-area map (with the sign of y) at |x| + |y| = `distance` of the square of [-1, 1].
fn ring_r(distance: f64) -> f64 {
    let height = 1.0 - distance;
    (1.0 - height.abs()).copysign(height)
}

impl Ring {
    /// `distance` as for [`ring_r`]; `cells` of them lie along an edge of the square.
    fn new(environment: &Environment, distance: f64, cells: u32) -> Self {
        let r = ring_r(distance);
        let polar = polar_angle(r.abs());
        let polar = if r < 0.0 { PI - polar } else { polar };
        // An eighth of a turn for r, which is two cells for each of these.
        Self { step: 0.25 / (f64::from(cells) * r.abs()), rows: Between::new(environment.height, polar) }
    }
}

/// Samples along an edge of the map's texel at this r: eight along each texel of the picture, which keeps the
/// energy of a lone bright texel within 0.2 %, or four (0.4 %) in large maps, where eight take seconds; at least a quarter
/// of that in a texel of the map, however little of the picture is in it; more near the poles, where the picture's texels are wedges, though no more than what [`widen_polar_texels`] leaves to do.
fn samples_along_edge(environment: &Environment, edge: f64, r: f64) -> u32 {
    let sin_polar = r * (2.0 - r * r).sqrt();
    let column = TAU / f64::from(environment.width);
    let finest = (PI / f64::from(environment.height)).min(column);
    let wedges = edge / (column * sin_polar);
    let base = if edge < SMALL_EDGE { 4.0 } else { 8.0 };
    let texels = if wedges > 1.0 {
        wedges.min(16.0).sqrt() * (edge / finest).max(1.0)
    } else {
        (edge / finest).max(wedges).max(0.25)
    };
    (base * texels).ceil() as u32
}

/// The picture's rows, those near the poles averaged along the row, as wide as a quarter of a texel of the map: there
/// many texels of the picture fall into one of the map, and point samples would miss some of them. A row keeps its
/// sum.
fn widen_polar_texels(environment: &Environment, edge: f64) -> Vec<Cow<'_, [[f32; 3]]>> {
    let (width, height) = (environment.width as usize, environment.height as usize);
    let rows = environment.texels.par_chunks_exact(width).enumerate();
    let rows = rows.map(|(row, source)| {
        let sin_polar = (PI * (row as f64 + 0.5) / height as f64).sin();
        let reach = (0.25 * edge / (TAU / width as f64 * sin_polar) / 2.0).round() as usize;
        let reach = reach.min((width - 1) / 2);
        if reach == 0 {
            return Cow::Borrowed(source);
        }
        // Sums in f64 of values whose f32 neighbours may be 1e38 times as large; recomputing is exact, running
        // sums would leave the large one's rounding error behind.
        let count = 2 * reach + 1;
        let mean = |column: usize| {
            let first = column + width - reach;
            let sum: DVec3 = (first..first + count).map(|c| Vec3::from(source[c % width]).as_dvec3()).sum();
            (sum / count as f64).as_vec3().to_array()
        };
        Cow::Owned((0..width).map(mean).collect())
    });
    rows.collect()
}

/// The polar angle 2 asin(r / sqrt 2) of r = sqrt(1 - cos) in [0, 1], within 4e-9: `acos` is most of a lookup's time.
fn polar_angle(r: f64) -> f64 {
    const COEFFICIENTS: [f64; 9] = [
        1.414_213_595_55,
        0.117_849_240_327,
        0.026_547_936_962_1,
        0.007_655_875_299_48,
        0.003_633_472_891_78,
        -0.001_205_312_719_79,
        0.003_346_805_785_93,
        -0.002_062_896_429_89,
        0.000_817_607_319_145,
    ];
    r * COEFFICIENTS.iter().rev().fold(0.0, |sum, coefficient| sum * r * r + coefficient)
}
