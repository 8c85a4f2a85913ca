//! Patterns of samples.

use catoptric_core::math::lanes::LANES;
use catoptric_engine::raster::{Pattern, SAMPLE_COUNTS, sample_positions};
use glam::Vec2;

#[test]
fn patterns_are_spread_over_the_pixel() {
    for samples in SAMPLE_COUNTS {
        let positions = sample_positions(samples).unwrap();
        assert_eq!(positions.len(), samples as usize);
        let mean = positions.iter().sum::<Vec2>() / samples as f32;
        assert!((mean - Vec2::splat(0.5)).abs().max_element() < 0.05, "{samples}: {mean}");
        for (axis, name) in [(0, "x"), (1, "y")] {
            let mut coordinates: Vec<i32> = positions.iter().map(|p| (p[axis] * 16.0) as i32).collect();
            coordinates.sort_unstable();
            coordinates.dedup();
            assert_eq!(coordinates.len(), samples as usize, "{samples}: two samples share {name}");
        }
    }
}

#[test]
fn other_counts_are_refused_by_name() {
    for samples in [0, 3, 5, 32, u32::MAX] {
        let message = sample_positions(samples).unwrap_err().to_string();
        assert!(message.contains("1, 2, 4, 8 and 16"), "{message}");
    }
}

#[test]
fn lanes_hold_every_sample_of_their_pixels() {
    for samples in SAMPLE_COUNTS {
        let pattern = Pattern::new(samples).unwrap();
        for group in 0..8 * pattern.samples / LANES {
            for lane in 0..LANES {
                let index = group * LANES + lane;
                let (pixel, sample) = (index / pattern.samples, index % pattern.samples);
                let first = group * LANES / pattern.samples;
                let x = first as f32 + pattern.x[group & (pattern.halves - 1)][lane] as f32 / 16.0;
                let y = pattern.y[group & (pattern.halves - 1)][lane] as f32 / 16.0;
                assert_eq!(Vec2::new(x, y), pattern.positions[sample] + Vec2::new(pixel as f32, 0.0));
            }
        }
    }
}
