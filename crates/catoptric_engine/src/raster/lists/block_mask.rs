//! Choices of the blocks of a picture.

use super::super::kernel::BLOCK;
use glam::Vec2;

/// Some of the blocks of 8 x 8 pixels that a picture is divided into from its top left corner; none by default.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BlockMask {
    /// Blocks in a row, and rows.
    size: [usize; 2],
    /// Row by row, 64 blocks a word; each row begins with a new one.
    bits: Vec<u64>,
}

impl BlockMask {
    /// None of the blocks of a picture, by its width and height in pixels.
    pub fn new(picture: [usize; 2]) -> Self {
        Self { size: picture.map(|pixels| pixels.div_ceil(BLOCK)), bits: Vec::new() }
    }

    fn words_a_row(&self) -> usize {
        self.size[0].div_ceil(64)
    }

    /// True if no block is chosen.
    pub fn is_empty(&self) -> bool {
        self.bits.is_empty()
    }

    /// Adds the blocks that a box of pixels touches; coordinates that are not finite add all blocks on their side.
    pub fn add_box(&mut self, low_px: Vec2, high_px: Vec2) {
        let last = self.size.map(|blocks| blocks as f32 - 1.0);
        // `max` and `min` pass over what is not a number.
        let low = [low_px.x, low_px.y].map(|px| (px / BLOCK as f32).floor().max(0.0));
        let high = [0, 1].map(|axis: usize| ([high_px.x, high_px.y][axis] / BLOCK as f32).floor().min(last[axis]));
        if low[0] > high[0] || low[1] > high[1] {
            return;
        }
        let words = self.words_a_row();
        if self.bits.is_empty() {
            self.bits.resize(words * self.size[1], 0);
        }
        for row in low[1] as usize..=high[1] as usize {
            for column in low[0] as usize..=high[0] as usize {
                self.bits[row * words + column / 64] |= 1 << (column % 64);
            }
        }
    }

    /// Chooses all blocks that are not chosen, and no others.
    pub fn invert(&mut self) {
        let words = self.words_a_row();
        self.bits.resize(words * self.size[1], 0);
        for (index, word) in self.bits.iter_mut().enumerate() {
            let left = self.size[0] - index % words.max(1) * 64;
            *word = !*word & if left < 64 { (1 << left) - 1 } else { u64::MAX };
        }
    }

    /// Adds the blocks of another choice for the same picture.
    pub fn add(&mut self, other: &Self) {
        if self.is_empty() {
            self.clone_from(other);
        } else {
            self.bits.iter_mut().zip(&other.bits).for_each(|(own, other)| *own |= other);
        }
    }

    /// True if the block is chosen that lies so many blocks from the left and from the top.
    #[inline]
    pub fn has(&self, column: usize, row: usize) -> bool {
        let word = self.bits.get(row * self.words_a_row() + column / 64).copied().unwrap_or_default();
        column < self.size[0] && word >> (column % 64) & 1 != 0
    }

    /// A bit for each block, row by row, 64 a word; each row begins with a new word. Empty if no block is chosen.
    pub fn words(&self) -> &[u64] {
        &self.bits
    }

    /// The number of blocks.
    pub fn count(&self) -> u64 {
        self.bits.iter().map(|word| u64::from(word.count_ones())).sum()
    }
}
