//! How many connections first eye vertices are worth. More lower what chance in choosing them adds to a pixel's variance, and
//! nothing else of it; each costs the same. Both follow from the paths that learning finds: by how much the light of a pixel
//! differs from one iteration to the next, with all connections of its first vertex, and with every third.

use crate::subspace::FirstConnections;

/// Every so many-th of systematic draws, from a random one of the first on, is a systematic draw of fewer.
const PARTS: usize = 3;
/// Those that there is a choice of: whole rounds of what a vertex of the renderer's default has in flight.
const CANDIDATES: [u32; 5] = [3, 6, 9, 12, 15];
/// A ray of an eye path, with all that is done where it ends, light paths included, takes as much as so many connections.
/// 3.6 to 9 on thirteen scenes (docs/measurements.md, First connections).
const COST_OF_A_RAY: f64 = 5.0;
/// Absolute differences tell less of rare bright light than the variance has: what first connections leave of it was so many
/// times as much, on average of the same scenes.
const RARE_LIGHT: f64 = 1.1;
/// Brightness that is added to every tile's, relative to the picture's mean.
const TILE_FLOOR: f64 = 0.01;

/// The light of an eye path.
#[derive(Clone, Copy, Default)]
pub(super) struct PathLight {
    all: f64,
    /// Of its first vertex's connections, by their number modulo [`PARTS`].
    first: [f64; PARTS],
}

/// Paths that are not finite teach nothing, and are counted as faulty.
fn finite(light: f32) -> f64 {
    if light.is_finite() { f64::from(light) } else { 0.0 }
}

impl PathLight {
    /// Light that was met by chance, or by a connection of a later vertex.
    pub fn add(&mut self, light: f32) {
        self.all += finite(light);
    }

    /// Light by a connection of the first vertex.
    pub fn add_first(&mut self, number: u32, light: f32) {
        self.add(light);
        self.first[number as usize % PARTS] += finite(light);
    }

    /// What it would be with one part of its first connections.
    fn with_part(&self, part: usize) -> f64 {
        self.all - self.first.iter().sum::<f64>() + PARTS as f64 * self.first[part]
    }
}

/// Of the paths of a tile.
#[derive(Clone, Copy, Default)]
struct Tile {
    paths: f64,
    light: f64,
    /// Between two paths of a pixel, the absolute difference, which a few bright paths do not decide: with all first
    /// connections, and with a part of them.
    with_all: f64,
    with_part: f64,
}

/// What iterations told so far.
pub(super) struct FirstConnectionsTrial {
    /// Of each pixel.
    tile_of: Vec<u32>,
    before: Vec<PathLight>,
    tiles: Vec<Tile>,
    rays: f64,
    /// First vertices that connect; of narrow lobes, the part of their connections that is made.
    connecting: f64,
}

impl FirstConnectionsTrial {
    /// Of pixels that lie in these tiles.
    pub fn new(tile_of: Vec<u32>) -> Self {
        let tiles = tile_of.iter().max().map_or(0, |last| *last as usize + 1);
        Self { tile_of, before: Vec::new(), tiles: vec![Tile::default(); tiles], rays: 0.0, connecting: 0.0 }
    }

    /// The light of each pixel's path in the last iteration; `rays`: of these paths.
    pub fn take(&mut self, light: &[PathLight], rays: u64, connecting: f64) {
        for (tile, (before, now)) in self.tile_of.iter().zip(self.before.iter().zip(light)) {
            let tile = &mut self.tiles[*tile as usize];
            tile.paths += 1.0;
            tile.light += now.all;
            tile.with_all += (now.all - before.all).abs();
            // Any with any: a systematic draw of fewer begins anywhere, but a part of more always at the same.
            let parts = (0..PARTS * PARTS)
                .map(|pair| (now.with_part(pair / PARTS) - before.with_part(pair % PARTS)).abs());
            tile.with_part += parts.sum::<f64>() / (PARTS * PARTS) as f64;
        }
        self.before = light.to_vec();
        self.rays += rays as f64;
        self.connecting += connecting;
    }

    /// How many are best, where first vertices had `made`. `None` before two iterations, or where these were all the same.
    pub fn wanted(&self, made: u32) -> Option<FirstConnections> {
        let [paths, light] = [|tile: &Tile| tile.paths, |tile: &Tile| tile.light]
            .map(|of| self.tiles.iter().map(of).sum::<f64>());
        // Relative to brightness, as errors of pictures are.
        let noise = |of: fn(&Tile) -> f64| {
            let relative = |tile: &Tile| of(tile) / (tile.light / tile.paths + TILE_FLOOR * light / paths);
            self.tiles.iter().filter(|tile| tile.paths > 0.0).map(relative).sum::<f64>().powi(2)
        };
        let (with_all, with_part) = (noise(|tile| tile.with_all), noise(|tile| tile.with_part));
        let is_known = with_all > 0.0 && self.connecting > 0.0;
        if !is_known || !made.is_multiple_of(PARTS as u32) {
            return None;
        }
        let made = f64::from(made);
        // with_all = rest + of_one / made, with_part = rest + of_one PARTS / made
        let of_one = RARE_LIGHT * made * (with_part - with_all) / (PARTS as f64 - 1.0);
        let of_one = of_one.clamp(0.0, with_all * made);
        let rest = with_all - of_one / made;
        // In connections of a first vertex.
        let other_cost = COST_OF_A_RAY * self.rays / self.connecting;
        let effort = |count: &u32| (rest + of_one / f64::from(*count)) * (other_cost + f64::from(*count));
        let count = CANDIDATES.into_iter().min_by(|a, b| effort(a).total_cmp(&effort(b)))?;
        let (variance, cost) = (of_one / made / with_all, made / (other_cost + made));
        Some(FirstConnections { count, made: made as u32, variance, cost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::pcg4d;

    /// In 0..1
    fn random(key: [u32; 4]) -> f64 {
        f64::from(pcg4d(key)[0]) / 2f64.powi(32)
    }

    /// Paths with nine connections, each with light of variance `of_one`, and light by chance of variance `rest`.
    fn wanted(of_one: f64, rest: f64, rays: u64) -> FirstConnections {
        let mut trial = FirstConnectionsTrial::new((0..4096).map(|pixel| pixel / 256).collect());
        for iteration in 0..4 {
            let path = |pixel| {
                let mut path = PathLight::default();
                let uniform = |number, variance: f64| {
                    (12.0 * variance).sqrt() * (random([iteration, pixel, number, 7]) - 0.5)
                };
                path.add((1.0 + uniform(9, rest)) as f32);
                (0..9).for_each(|number| {
                    path.add_first(number, ((1.0 + uniform(number, of_one)) / 9.0) as f32)
                });
                path
            };
            let light: Vec<PathLight> = (0..4096).map(path).collect();
            trial.take(&light, rays * 4096, 4096.0);
        }
        trial.wanted(9).expect("there is light")
    }

    #[test]
    fn as_many_as_their_variance_and_cost_call_for() {
        // The root of RARE_LIGHT's ratio of variances times 5 rays: 8.4, 2.9, 24.6, 1.7.
        for (of_one, rest, rays, count) in
            [(6.0, 1.0, 2, 9), (1.5, 1.0, 1, 3), (10.0, 0.2, 1, 15), (0.25, 1.0, 2, 3)]
        {
            let wanted = wanted(of_one, rest, rays);
            assert_eq!(wanted.count, count, "{of_one} {rest} {rays}: {wanted:?}");
            let share = f64::min(1.0, RARE_LIGHT * of_one / 9.0 / (rest + of_one / 9.0));
            assert!((wanted.variance - share).abs() < 0.06, "{share}: {wanted:?}");
            assert!((wanted.cost - 9.0 / (9.0 + 5.0 * rays as f64)).abs() < 1e-9, "{wanted:?}");
        }
    }

    #[test]
    fn nothing_is_said_without_differences_or_of_other_counts() {
        assert!(FirstConnectionsTrial::new(vec![0; 4]).wanted(9).is_none());
        let lit = |light| {
            let mut path = PathLight::default();
            path.add_first(0, light);
            [path; 4]
        };
        let mut trial = FirstConnectionsTrial::new(vec![0; 4]);
        for light in [1.0, 1.0, 2.0] {
            assert!(trial.wanted(9).is_none());
            trial.take(&lit(light), 4, 4.0);
        }
        assert!(trial.wanted(9).is_some());
        assert!(trial.wanted(4).is_none());
    }
}
