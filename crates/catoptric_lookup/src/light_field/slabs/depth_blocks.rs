//! Parallaxes in blocks of 4 x 4 pixels: two of them, and for each pixel which of four that lie evenly between.
//!
//! A block is 8 bytes, half a byte a ray, the lowest byte of each number first: the two parallaxes as they are stored
//! elsewhere, then two bits a pixel, row by row from the lowest bit on.

/// Bytes of a block.
pub(crate) const BLOCK_BYTES: usize = 8;

/// Pixels a side of a block.
const SIDE: usize = 4;

/// Times that the two parallaxes of a block are fitted to its pixels. Chosen; more change next to nothing.
const FITS: usize = 3;

/// Bytes of a view of `side` pixels a side.
pub fn byte_count(side: u32) -> usize {
    let across = side.div_ceil(SIDE as u32) as usize;
    across * across * BLOCK_BYTES
}

/// Appends the blocks of a view: `side` pixels a side, row by row.
pub fn compress(side: u32, view: &[i16], bytes: &mut Vec<u8>) {
    let side = side as usize;
    for top in (0..side).step_by(SIDE) {
        for left in (0..side).step_by(SIDE) {
            // Blocks that reach over the view repeat its last pixels.
            let pixels: [i16; 16] = std::array::from_fn(|pixel| {
                let (x, y) = ((left + pixel % SIDE).min(side - 1), (top + pixel / SIDE).min(side - 1));
                view.get(y * side + x).copied().unwrap_or_default()
            });
            bytes.extend(packed_block(&pixels));
        }
    }
}

/// The parallax of a pixel in the blocks of a view of `side` pixels a side; 0 where there is none.
#[inline(always)] // for the instructions of its caller
pub fn at(side: u32, blocks: &[u8], x: u32, y: u32) -> i16 {
    let number = (y / SIDE as u32 * side.div_ceil(SIDE as u32) + x / SIDE as u32) as usize;
    let block = blocks.get(number * BLOCK_BYTES..).and_then(|rest| rest.first_chunk::<BLOCK_BYTES>());
    let bits = block.map_or(0, |block| u64::from_le_bytes(*block));
    let pixel = y % SIDE as u32 * SIDE as u32 + x % SIDE as u32;
    between([bits as i16, (bits >> 16) as i16], (bits >> (32 + 2 * pixel)) as i32 & 3)
}

/// A parallax of a block, by its index among four.
#[inline(always)] // for the instructions of its caller
fn between([one, other]: [i16; 2], index: i32) -> i16 {
    ((i32::from(one) * (3 - index) + i32::from(other) * index) / 3) as i16
}

/// The nearest of the four for each pixel, and the sum of squares of the errors.
fn indices(ends: [i16; 2], pixels: &[i16; 16]) -> ([i32; 16], i64) {
    let four = [0, 1, 2, 3].map(|index| i64::from(between(ends, index)));
    let mut sum = 0;
    let chosen = pixels.map(|pixel| {
        let off = four.map(|value| (value - i64::from(pixel)).pow(2));
        let index = (0..4).fold(0, |best, next| if off[next] < off[best] { next } else { best });
        sum += off[index];
        index as i32
    });
    (chosen, sum)
}

/// The two parallaxes that are nearest to pixels with their indices, by least squares; none where these say nothing.
fn fitted(indices: &[i32; 16], pixels: &[i16; 16]) -> Option<[i16; 2]> {
    let (mut aa, mut ab, mut bb, mut at_a, mut at_b) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (index, pixel) in indices.iter().zip(pixels) {
        let b = f64::from(*index) / 3.0;
        let (a, value) = (1.0 - b, f64::from(*pixel));
        aa += a * a;
        ab += a * b;
        bb += b * b;
        at_a += a * value;
        at_b += b * value;
    }
    let determinant = aa * bb - ab * ab;
    // Casts saturate.
    let solved = |value: f64| (value / determinant).round() as i16;
    (determinant > 1e-6).then(|| [solved(at_a * bb - at_b * ab), solved(at_b * aa - at_a * ab)])
}

fn packed_block(pixels: &[i16; 16]) -> [u8; BLOCK_BYTES] {
    let low = pixels.iter().copied().min().unwrap_or_default();
    let high = pixels.iter().copied().max().unwrap_or_default();
    let mut ends = [low, high];
    let (mut chosen, mut off) = indices(ends, pixels);
    for _ in 0..FITS {
        let Some(next) = fitted(&chosen, pixels).filter(|_| off > 0) else { break };
        let (indices, sum) = indices(next, pixels);
        if sum >= off {
            break;
        }
        (ends, chosen, off) = (next, indices, sum);
    }
    let of_pixels = chosen.iter().rev().fold(0, |bits, index| bits << 2 | *index as u64);
    let [low, high] = ends.map(|end| u64::from(end as u16));
    (low | high << 16 | of_pixels << 32).to_le_bytes()
}
