//! Where the samples of a pixel lie.

use glam::Vec2;

/// The positions of the samples in a pixel (0..1, y down), for 1, 2, 4, 8 and 16 samples; none for other counts.
///
/// One sample lies in the centre; the others are the standard patterns of Direct3D 11 and Vulkan, on a grid of
/// sixteenths.
pub fn sample_positions(samples: u32) -> Option<&'static [Vec2]> {
    const fn at(x: i32, y: i32) -> Vec2 {
        Vec2::new((x + 8) as f32 / 16.0, (y + 8) as f32 / 16.0)
    }
    const ONE: [Vec2; 1] = [at(0, 0)];
    const TWO: [Vec2; 2] = [at(4, 4), at(-4, -4)];
    const FOUR: [Vec2; 4] = [at(-2, -6), at(6, -2), at(-6, 2), at(2, 6)];
    const EIGHT: [Vec2; 8] = [at(1, -3), at(-1, 3), at(5, 1), at(-3, -5), at(-5, 5), at(-7, -1), at(3, 7), at(7, -7)];
    const SIXTEEN: [Vec2; 16] = [
        at(1, 1),
        at(-1, -3),
        at(-3, 2),
        at(4, -1),
        at(-5, -2),
        at(2, 5),
        at(5, 3),
        at(3, -5),
        at(-2, 6),
        at(0, -7),
        at(-4, -6),
        at(-6, 4),
        at(-8, 0),
        at(7, -4),
        at(6, 7),
        at(-7, -8),
    ];
    match samples {
        1 => Some(&ONE),
        2 => Some(&TWO),
        4 => Some(&FOUR),
        8 => Some(&EIGHT),
        16 => Some(&SIXTEEN),
        _ => None,
    }
}
