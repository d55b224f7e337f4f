//! SplitMix64 (Steele, Lea and Flood 2014): another generator than the renderer's.

use glam::DVec2;

pub struct Random(u64);

impl Random {
    /// Streams of different (seed, stream) are unrelated: both go through the mixing function.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut start = Self(seed);
        Self(start.next() ^ Self(stream ^ 0x5851_f42d_4c95_7f2d).next())
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn uniform2(&mut self) -> DVec2 {
        DVec2::new(self.uniform(), self.uniform())
    }
}
