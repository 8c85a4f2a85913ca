//! Depths of texels, in four bytes each: rays mostly wait for these from memory, and so the smaller the better.

use std::sync::Arc;

/// Depth interval in a direction, as shares of the shell's distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Depth of the first surface; infinite if there is none.
    pub front: f32,
    /// Depth of its end behind that; equal to `front` if it is no solid.
    pub back: f32,
}

impl Depth {
    /// The depth of texels that show nothing.
    pub const NOTHING: Self = Self { front: f32::INFINITY, back: f32::INFINITY };
}

/// Depths of texels, texel by texel; each a word of two codes, the front's in the lower half.
///
/// A code counts how far a share's bits are above those of the least, in steps that are a power of two: shares that
/// differ by no more than a factor of 256 are therefore exact to 2^-14 of themselves, and equal shares stay equal.
#[derive(Clone, Debug)]
pub struct Depths {
    words: Arc<[u32]>,
    /// The bits of the least share.
    base: u32,
    /// The steps, as a power of two.
    shift: u32,
}

/// The code of an infinite distance.
const INFINITE: u32 = 0xFFFF;

/// The word of texels that show nothing: both codes.
const NOTHING: u32 = u32::MAX;

impl Depths {
    /// Depths of texels.
    pub fn new(depths: impl ExactSizeIterator<Item = Depth> + Clone) -> Self {
        let shares = depths.clone().flat_map(|depth| [depth.front, depth.back]).filter(|share| share.is_finite());
        let (least, most) = shares.fold((f32::MAX, 0.0f32), |(least, most), share| (least.min(share), most.max(share)));
        // Bits of positive numbers are in the order of these.
        let base = least.max(0.0).to_bits();
        let span = most.to_bits().saturating_sub(base);
        // Rounding up must not reach the last code.
        let shift = (0..16).find(|shift| (span >> shift) + 1 < INFINITE).unwrap_or(16);
        let code = |share: f32| match share.is_finite() {
            true => ((share.max(0.0).to_bits().saturating_sub(base) + ((1 << shift) >> 1)) >> shift).min(INFINITE - 1),
            false => INFINITE,
        };
        Self { words: depths.map(|depth| code(depth.front) | code(depth.back) << 16).collect(), base, shift }
    }

    /// Depths from [`Self::parts`]; `None` where a code is no number.
    pub(crate) fn of_parts(words: Vec<u32>, base: u32, shift: u32) -> Option<Self> {
        if shift > 16 {
            return None;
        }
        let bits = |code: u32| u64::from(base) + (u64::from(code) << shift);
        let is_finite = |code: u32| code == INFINITE || bits(code) <= u64::from(f32::MAX.to_bits());
        let all_are = words.iter().all(|word| is_finite(word & 0xFFFF) && is_finite(word >> 16));
        all_are.then(|| Self { words: words.into(), base, shift })
    }

    /// The word of a texel; beyond the last, that of nothing.
    #[inline(always)] // for the instructions of its caller
    pub fn word(&self, texel: u32) -> u32 {
        self.words.get(texel as usize).copied().unwrap_or(NOTHING)
    }

    /// Words of a texel and the next one.
    #[inline(always)] // for the instructions of its caller
    pub fn words_of_two(&self, texel: u32) -> [u32; 2] {
        let both = self.words.get(texel as usize..).and_then(|words| words.first_chunk::<2>());
        both.copied().unwrap_or([NOTHING; 2])
    }

    /// Front depth of a word.
    #[inline(always)] // for the instructions of its caller
    pub fn front(&self, word: u32) -> f32 {
        self.share(word & 0xFFFF)
    }

    /// Back depth of a word.
    #[inline(always)] // for the instructions of its caller
    pub fn back(&self, word: u32) -> f32 {
        self.share(word >> 16)
    }

    #[inline(always)] // for the instructions of its caller
    fn share(&self, code: u32) -> f32 {
        let share = f32::from_bits(self.base.wrapping_add(code << self.shift));
        if code == INFINITE { f32::INFINITY } else { share }
    }

    /// Depths of texels, as they are stored.
    pub fn iter(&self) -> impl Iterator<Item = Depth> {
        self.words.iter().map(|word| Depth { front: self.front(*word), back: self.back(*word) })
    }

    /// The words, the bits of the least share, and the steps of codes as a power of two.
    pub(crate) fn parts(&self) -> (&[u32], u32, u32) {
        (&self.words, self.base, self.shift)
    }

    /// Memory.
    pub(crate) fn byte_count(&self) -> u64 {
        size_of_val(&self.words[..]) as u64
    }
}

/// Memory of a texel's depth.
pub(crate) const DEPTH_BYTES: usize = size_of::<u32>();
