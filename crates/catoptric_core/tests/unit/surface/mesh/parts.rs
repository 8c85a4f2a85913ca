//! Connected parts.

use catoptric_core::surface::mesh::parts::append_parts;

#[test]
fn parts_hang_together_by_vertices() {
    // Two squares, the second given from its far end, and a triangle alone; numbered from vertex 7 on.
    let triangles = [[7, 8, 9], [14, 13, 12], [7, 9, 10], [15, 16, 17], [11, 12, 13]];
    let mut parts = vec![5];
    append_parts(&triangles, 7..18, &mut parts);
    let [before, a, c, b, alone, d] = parts[..] else { panic!("{parts:?}") };
    assert_eq!(before, 5, "what was there stays");
    assert_eq!((a, c), (b, d));
    assert!(a != c && a != alone && c != alone && a * c * alone != 0, "{parts:?}");
    // Parts connected by the last triangle alone.
    let mut chain: Vec<[u32; 3]> = (0..20).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    chain.extend((0..19).map(|k| [3 * k + 2, 3 * k + 3, 3 * k]));
    let mut parts = Vec::new();
    append_parts(&chain, 0..60, &mut parts);
    assert!(parts.iter().all(|part| *part == 1), "{parts:?}");
}
