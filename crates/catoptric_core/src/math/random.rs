//! Random numbers by counter: a value depends on its key alone, never on the order of requests or on threads.

use glam::Vec2;

/// Mixes 64 bits thoroughly (the finaliser of SplitMix64; Steele, Lea, Flood 2014).
#[inline]
pub fn mix(mut key: u64) -> u64 {
    key = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    key = (key ^ (key >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    key = (key ^ (key >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    key ^ (key >> 31)
}

/// Uniform in 0..1 (1 excluded), a function of the three keys.
#[inline]
pub fn unit(a: u64, b: u64, c: u64) -> f32 {
    let bits = mix(mix(mix(a) ^ b) ^ c);
    (bits >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
}

/// The numbers of a sequence that fills the unit square evenly (Roberts 2018: the R2 sequence).
#[inline]
pub fn spread(index: u32) -> Vec2 {
    (Vec2::new(0.754_877_7, 0.569_840_3) * index as f32).fract()
}

/// One of `count` points that fill the unit square evenly (Hammersley 1960), with the second number by all bits of the
/// index.
#[inline(always)] // for the instructions of its caller
pub fn hammersley(index: u32, count: u32) -> Vec2 {
    Vec2::new((index as f32 + 0.5) / count as f32, index.reverse_bits() as f32 * (1.0 / 4_294_967_296.0))
}

/// The numbers of a sequence of which every run of a power of two, from a multiple of it on, has one point in each part
/// of every division of the unit square into so many (the first two of Sobol 1967).
#[inline]
pub fn sobol(index: u32) -> Vec2 {
    let (mut second, mut direction, mut rest) = (0u32, 1u32 << 31, index);
    while rest != 0 {
        if rest & 1 != 0 {
            second ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    Vec2::new(index.reverse_bits() as f32, second as f32) * (1.0 / 4_294_967_296.0)
}

/// A stream of random numbers from a seed.
#[derive(Clone, Debug)]
pub struct Stream {
    seed: u64,
    counter: u64,
}

impl Stream {
    /// The stream of `seed`.
    #[inline]
    pub fn new(seed: u64) -> Self {
        Self { seed, counter: 0 }
    }

    /// The next number, uniform in 0..1 (1 excluded).
    #[inline]
    pub fn next_unit(&mut self) -> f32 {
        self.counter += 1;
        unit(self.seed, self.counter, 0x5eed)
    }

    /// The next number, uniform between `low` and `high`.
    #[inline]
    pub fn next_between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next_unit()
    }
}
