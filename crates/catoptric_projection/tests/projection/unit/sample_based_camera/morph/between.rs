//! Appearances half way between two points.

use catoptric_projection::parts::{MOST_NODES, NodeSightings, Sighting, half_way};
use glam::{Mat3, Vec3};

const SIZE: f32 = 1.0;

/// A smooth function of a point and a node, with its derivatives, in place of reflection points.
fn sighting(point: Vec3, node: Vec3, bend: f32) -> Sighting {
    let both = point * 0.3 + node * 0.2;
    let first = both + bend * Vec3::new(both.x * both.y, both.y * both.y * both.z, both.x * both.x * both.x);
    let by_both = Mat3::IDENTITY
        + bend
            * Mat3::from_cols(
                Vec3::new(both.y, 0.0, 3.0 * both.x * both.x),
                Vec3::new(both.x, 2.0 * both.y * both.z, 0.0),
                Vec3::new(0.0, both.y * both.y, 0.0),
            );
    Sighting {
        first,
        change: by_both * 0.3,
        change_with_eye: Some(by_both * 0.2),
        normal: Vec3::Y,
        length: first.distance(node) + first.distance(point),
        last_segment: first.distance(point),
        error: 0.0,
    }
}

const NODES: [Vec3; MOST_NODES] =
    [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.0), Vec3::new(0.3, 0.3, 0.0), Vec3::new(0.3, 0.3, 0.3)];

fn seen(point: Vec3, bend: f32) -> NodeSightings {
    NodeSightings { focal_index: 0, at: NODES.map(|node| sighting(point, node, bend)) }
}

/// Half-way sightings are within the error that is given for them, or `None`.
#[test]
fn what_is_said_of_errors_holds() {
    let from = Vec3::new(1.0, 2.0, -0.5);
    let mut told = [0; 2];
    for (number, bend) in [0.1, 5.0, 50.0].into_iter().enumerate() {
        for length in [0.02, 0.05, 0.1, 0.2] {
            for direction in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.6, -0.5, 0.7)] {
                let to = from + direction.normalize() * length;
                let ends = [(from, &seen(from, bend)), (to, &seen(to, bend))];
                let found = half_way(&NODES, (Vec3::ZERO, SIZE), ends[0], ends[1]);
                told[usize::from(found.is_some())] += 1;
                let swapped = half_way(&NODES, (Vec3::ZERO, SIZE), ends[1], ends[0]);
                assert!(found == swapped, "{number} {length} {direction}: not the same from the other side");
                let Some(found) = found else { continue };
                let expected = seen((from + to) * 0.5, bend);
                for (found, expected) in found.at.iter().zip(expected.at) {
                    let off = found.first.distance(expected.first);
                    assert!(off <= found.error + 1e-6, "{number} {length} {direction}: {off}, not {}", found.error);
                    assert!((found.length - expected.length).abs() < 1e-5);
                    let step = to - from;
                    let of_change = |change: Mat3, other: Mat3| ((change - other) * step).length();
                    assert!(of_change(found.change, expected.change) < 1e-4);
                    let with_eye = found.change_with_eye.zip(expected.change_with_eye);
                    let (found, expected) = with_eye.expect("both are known");
                    assert!(of_change(found, expected) < 1e-3);
                }
            }
        }
    }
    assert!(told.iter().all(|count| *count > 5), "{told:?}");
}

/// There is no half-way sighting of another appearance, far away, or beside a jump.
#[test]
fn not_everything_is_between() {
    let (from, to) = (Vec3::new(1.0, 2.0, -0.5), Vec3::new(1.05, 2.0, -0.5));
    let (one, other) = (seen(from, 0.01), seen(to, 0.01));
    let tell = |one: &NodeSightings, other: &NodeSightings, middle: Vec3| {
        half_way(&NODES, (middle, SIZE), (from, one), (to, other)).is_some()
    };
    assert!(tell(&one, &other, Vec3::ZERO));
    assert!(!tell(&one, &other, from + Vec3::splat(0.1)));
    assert!(!tell(&one, &NodeSightings { focal_index: 1, ..other }, Vec3::ZERO));
    let mut jumped = other;
    jumped.at[2].first.y += 0.001;
    assert!(!tell(&one, &jumped, Vec3::ZERO));
    let mut bent = other;
    bent.at[3].change *= 1.1;
    assert!(!tell(&one, &bent, Vec3::ZERO));
    let mut unknown = other;
    unknown.at[1].change_with_eye = None;
    assert!(!tell(&one, &unknown, Vec3::ZERO));
    let mut uncertain = other;
    uncertain.at[0].error = 1e-4;
    assert!(!tell(&one, &uncertain, Vec3::ZERO));
}
