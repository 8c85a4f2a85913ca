//! Cells of directions from which searches start.

use catoptric_core::math::random::Stream;
use catoptric_projection::parts::starts::{SIDE, around, cell_of, middle_of};
use glam::Vec3;

#[test]
fn directions_lie_near_the_middle_of_their_cell() {
    let mut random = Stream::new(11);
    for _ in 0..10_000 {
        let direction = Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)));
        let turn = middle_of(cell_of(direction)).distance(direction.normalize());
        // Half a cell's diagonal is longer in space by the root of three, and by that in the middle of a face.
        assert!(turn < 3.0 * std::f32::consts::SQRT_2 / SIDE as f32, "{direction}: {turn}");
    }
}

#[test]
fn the_middle_of_a_cell_lies_in_it() {
    assert!((0..SIDE * SIDE).all(|cell| cell_of(middle_of(cell)) == cell));
}

#[test]
fn cells_beside_each_other_have_directions_beside_each_other() {
    // A step in the square is longer in space by the root of two, and by that of three in the middle of a face.
    let most = 2.0 / SIDE as f32 * 6.0_f32.sqrt();
    for cell in 0..SIDE * SIDE {
        for beside in around(cell) {
            let turn = middle_of(cell).distance(middle_of(beside));
            assert!(turn < most, "{cell}, {beside}: {turn}");
            assert!(around(beside).contains(&cell));
        }
    }
}
