//! Convex bodies.

use catoptric_core::surface::mesh::adjacency::neighbours;
use catoptric_core::surface::mesh::convexity::MeshShape;
use glam::Vec3;

/// An octahedron, with its corners at 6 places.
fn octahedron(place: Vec3, first: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let corners = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let sides = (0..4).flat_map(|k| [[k, (k + 1) % 4, 4], [(k + 1) % 4, k, 5]]);
    (corners.map(|corner| corner + place).to_vec(), sides.map(|side| side.map(|k| k + first)).collect())
}

fn is_convex(positions: &[Vec3], middle: Vec3, triangles: &[[u32; 3]]) -> bool {
    let normals: Vec<Vec3> = positions.iter().map(|position| (*position - middle).normalize_or_zero()).collect();
    let neighbours = neighbours(triangles, |vertex| vertex);
    MeshShape { positions, normals: &normals, triangles, neighbours: &neighbours }.is_convex()
}

#[test]
fn closed_bodies_that_bulge_outwards_are_convex() {
    let (positions, triangles) = octahedron(Vec3::ZERO, 0);
    assert!(is_convex(&positions, Vec3::ZERO, &triangles));
    assert!(!is_convex(&positions, Vec3::ZERO, &triangles[1..]), "open");
    let mut dented = positions.clone();
    dented[4] = Vec3::Z * -0.3;
    assert!(!is_convex(&dented, Vec3::NEG_Z * 0.5, &triangles), "dented");
    // Triangles given twice, and without an area, change nothing.
    let mut repeated = triangles.clone();
    repeated.extend([triangles[3], [triangles[0][1], triangles[0][0], triangles[0][2]], [0, 0, 1]]);
    assert!(is_convex(&positions, Vec3::ZERO, &repeated));
    let (mut two, others) = octahedron(Vec3::ZERO, 0);
    let (beside, more) = octahedron(Vec3::X * 3.0, 6);
    two.extend(beside);
    let both: Vec<[u32; 3]> = others.into_iter().chain(more).collect();
    assert!(!is_convex(&two, Vec3::X * 1.5, &both), "two bodies");
    assert!(!is_convex(&[], Vec3::ZERO, &[]));
}
