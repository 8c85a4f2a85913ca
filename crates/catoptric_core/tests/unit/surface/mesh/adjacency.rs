//! Neighbours of triangles.

use catoptric_core::surface::mesh::adjacency::{NO_NEIGHBOUR, neighbours};

#[test]
fn repeated_and_degenerate_triangles_separate_nobody() {
    // A square of two triangles; the second once more, turned and the other way round, and slivers on the diagonal.
    let triangles = [[0, 1, 2], [0, 2, 3], [2, 3, 0], [3, 2, 0], [0, 0, 2], [2, 4, 2]];
    let found = neighbours(&triangles, |vertex| vertex);
    let none = NO_NEIGHBOUR;
    assert_eq!(found[..4], [[none, 1, none], [none, none, 0], [none, 0, none], [0, none, none]]);
    assert_eq!(found[4..], [[none; 3]; 2]);
    // Three triangles at one edge are nobody's neighbours there.
    let fan = neighbours(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], |vertex| vertex);
    assert_eq!(fan, [[none; 3]; 3]);
}
