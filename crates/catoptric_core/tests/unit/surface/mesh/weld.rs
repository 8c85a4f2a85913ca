//! Vertices that are one point.

use catoptric_core::surface::mesh::weld::{NormalRule, WeldedVertices, weld_distance};
use glam::Vec3;

#[test]
fn vertices_are_one_by_position_and_normal() {
    let positions = [Vec3::X, Vec3::new(1.0, -0.0, 0.0), Vec3::Y, Vec3::X, Vec3::X];
    let normals = [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::new(0.0, 1e-4, 1.0), Vec3::Y];
    let welded = |rule| {
        let WeldedVertices { numbers, firsts } = WeldedVertices::new(&positions, &normals, rule, 0.0);
        (numbers, firsts)
    };
    assert_eq!(welded(NormalRule::Any), (vec![0, 0, 1, 0, 0], vec![0, 2]));
    assert_eq!(welded(NormalRule::Equal), (vec![0, 0, 1, 2, 3], vec![0, 2, 3, 4]));
    assert_eq!(welded(NormalRule::Within(1e-3)), (vec![0, 0, 1, 0, 2], vec![0, 2, 4]));
}

#[test]
fn positions_are_one_within_the_distance_wherever_cells_end() {
    // Pairs a tenth of the distance apart, at places all over the grid's cells and on their borders.
    let distance = 1e-3;
    let pairs: Vec<Vec3> = (0..400)
        .flat_map(|k| {
            let place = Vec3::new(k as f32, 0.37 * k as f32, -0.11 * k as f32) * 0.016;
            [place, place + Vec3::new(-1e-4, 1e-4, 1e-4)]
        })
        .collect();
    let normals = vec![Vec3::Z; pairs.len()];
    let welded = WeldedVertices::new(&pairs, &normals, NormalRule::Any, distance);
    assert_eq!(welded.firsts.len(), 400);
    assert!(welded.numbers.chunks(2).all(|pair| pair[0] == pair[1]));
    // Just further apart than the distance they are two.
    let apart = [Vec3::ZERO, Vec3::X * 1.01 * distance, Vec3::X * 0.99 * distance];
    let welded = WeldedVertices::new(&apart, &normals[..3], NormalRule::Any, distance);
    assert_eq!(welded.numbers, [0, 1, 0]);
}

#[test]
fn weld_distances_follow_the_size_and_the_place() {
    let distance = |corners: &[Vec3]| weld_distance(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
    let near = [Vec3::ZERO, Vec3::X * 3.0, Vec3::Y * 4.0];
    assert!((distance(&near) - 5e-5).abs() < 1e-9);
    let far = near.map(|p| p + Vec3::Y * 1e6);
    assert!(distance(&far) > 0.4);
    // A vertex far away does not weld the others.
    let mut outlier = near.repeat(3);
    outlier.extend([Vec3::ZERO, Vec3::X, Vec3::X * 1e5]);
    assert!(distance(&outlier) < 0.1);
    assert_eq!(distance(&[]), 0.0);
    assert_eq!(distance(&[Vec3::NAN; 3]), 0.0);
    assert_eq!(distance(&[Vec3::ONE; 3]), 0.0);
}
