//! A stream of random numbers for tests, over the renderer's own generator.

use glam::Vec2;
use halfway::math::rng::{RandomKey, random4, seed_key, uniform_from_word};

pub struct Stream {
    key: RandomKey,
    words: [u32; 4],
    used: usize,
}

impl Stream {
    pub fn new(seed: u64) -> Self {
        Self { key: RandomKey { pixel: 0, sample: 0, seed: seed_key(seed) }, words: [0; 4], used: 4 }
    }

    pub fn word(&mut self) -> u32 {
        if self.used == 4 {
            self.words = random4(self.key, 0).to_array();
            let (sample, wrapped) = self.key.sample.overflowing_add(1);
            self.key.sample = sample;
            self.key.pixel += u32::from(wrapped);
            self.used = 0;
        }
        self.used += 1;
        self.words[self.used - 1]
    }

    /// In [0, 1), as the kernels see it.
    pub fn f32(&mut self) -> f32 {
        uniform_from_word(self.word())
    }

    pub fn vec2(&mut self) -> Vec2 {
        Vec2::new(self.f32(), self.f32())
    }

    /// In [0, 1) with 53 bits.
    pub fn f64(&mut self) -> f64 {
        let bits = u64::from(self.word()) << 32 | u64::from(self.word());
        (bits >> 11) as f64 / (1u64 << 53) as f64
    }
}
