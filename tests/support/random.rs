//! Numbers that look random and are the same everywhere: splitmix64. [Steele, Lea, Flood 2014]
#![allow(dead_code, reason = "each user has its own part of this module")]

/// A state that numbers are drawn from.
#[derive(Clone, Debug)]
pub struct Draw(pub u64);

impl Draw {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// One of so many.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// Below `count`, by what is left of a division.
    pub fn remainder(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    /// Does what happens so often happen?
    pub fn chance(&mut self, of: f64) -> bool {
        self.unit() < of
    }

    /// A place of a triangle, as the weights of its last two corners.
    pub fn in_triangle(&mut self) -> [f64; 2] {
        let (s, t) = (self.unit(), self.unit());
        if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] }
    }
}
