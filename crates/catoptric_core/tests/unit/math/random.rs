//! Random numbers.

use catoptric_core::math::random::sobol;
use glam::Vec2;

/// Every run of sixteen has one point in each part of every division of the square into sixteen equal ones.
#[test]
fn runs_of_the_sequence_fill_all_parts() {
    for run in 0..16 {
        for columns_log2 in 0..=4 {
            let cells = Vec2::new((1 << columns_log2) as f32, (16 >> columns_log2) as f32);
            let cell = |index: u32| {
                let at = (sobol(run * 16 + index) * cells).as_uvec2();
                at.y * cells.x as u32 + at.x
            };
            let mut hit: Vec<u32> = (0..16).map(cell).collect();
            hit.sort_unstable();
            assert_eq!(hit, (0..16).collect::<Vec<_>>(), "run {run}, {cells}");
        }
    }
}
