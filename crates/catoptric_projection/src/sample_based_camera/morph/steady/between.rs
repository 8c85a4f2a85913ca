//! Appearances of points between two others, where these tell enough.
//!
//! Along a straight line from one point to another the reflection point follows a cubic curve whose ends and tangents
//! are known (Hermite).

use super::super::walk::expected_move;
use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
use glam::{Mat3, Vec3};

/// Reflection points are interpolated where they are off by no more than this share of the mirror's size, as far as
/// derivatives tell. Chosen, not measured.
const MOST_ERROR: f32 = 3e-5;

/// The part of what derivatives at two points miss each other by that is the error between them. For what moves as a
/// root it is from a tenth to a twentieth half-way.
const ERROR_OF_MISFIT: f32 = 0.125;

/// The same where something passes beside a point: not used between points that are farther apart than this share of
/// their distance from the mirror. Chosen, not measured.
const LONGEST: f32 = 0.125;

/// How far a first reflection point between two others may be off at one of the nodes, or of the polynomial between
/// these, in scene units; `None` if it is too far for a mirror of this size.
pub(super) fn error_between(
    one: &[Sighting; MOST_NODES],
    other: &[Sighting; MOST_NODES],
    step: Vec3,
    size: f32,
) -> Option<f32> {
    // What half-way is beside the mean of both ends, at a node.
    let beside = |node: usize| (one[node].change - other[node].change) * (step * 0.125);
    let at_first = beside(0);
    let (mut misfit, mut bent) = (0.0f32, 0.0f32);
    for (node, (one, other)) in one.iter().zip(other).enumerate() {
        let expected = expected_move([one.change, other.change], step);
        misfit = misfit.max((other.first - one.first).distance(expected));
        // Where nodes differ in this, so do their derivatives with the eye, of which the mean is taken.
        bent = bent.max(beside(node).distance(at_first));
    }
    let error = (misfit + bent) * ERROR_OF_MISFIT;
    (error <= MOST_ERROR * size).then_some(error)
}

/// What these nodes see half-way between two points, in a mirror of this size around this middle; `None` where that is
/// to be looked for. The same to the bit for both orders: neighbours ask from both sides.
pub(super) fn half_way(
    nodes: &[Vec3; MOST_NODES],
    (middle, size): (Vec3, f32),
    (from, one): (Vec3, &NodeSightings),
    (to, other): (Vec3, &NodeSightings),
) -> Option<NodeSightings> {
    let (step, point) = (to - from, (from + to) * 0.5);
    if one.focal_index != other.focal_index || step.length() > LONGEST * point.distance(middle) {
        return None;
    }
    let error = error_between(&one.at, &other.at, step, size)?;
    let mut at = [Sighting::default(); MOST_NODES];
    for (node, at) in at.iter_mut().enumerate() {
        let (one, other) = (&one.at[node], &other.at[node]);
        let error = one.error.max(other.error) + error;
        if error > MOST_ERROR * size {
            return None;
        }
        let (one_with_eye, other_with_eye) = one.change_with_eye.zip(other.change_with_eye)?;
        let mean = (one.change + other.change) * 0.5;
        let misfit = other.first - one.first - mean * step;
        let first = (one.first + other.first) * 0.5 + (one.change - other.change) * (step * 0.125);
        let last_segment = first.distance(point);
        // Light stays in one medium. By both ends: the same for both orders, as everything here.
        let way = |end: &Sighting| end.first.distance(nodes[node]) + end.last_segment;
        let medium = (one.length + other.length) / (way(one) + way(other));
        *at = Sighting {
            first,
            // The cubic curve's own tangent along the line.
            change: mean + outer(misfit, step * (1.5 / step.length_squared())),
            change_with_eye: Some((one_with_eye + other_with_eye) * 0.5),
            normal: (one.normal + other.normal) * 0.5,
            // Of all ways near the right one that is the shortest: an error hardly tells.
            length: medium * (first.distance(nodes[node]) + last_segment),
            last_segment,
            error,
        };
    }
    Some(NodeSightings { focal_index: one.focal_index, at })
}

/// The matrix that takes `by` to `to`, times its length squared, and nothing else anywhere.
fn outer(to: Vec3, by: Vec3) -> Mat3 {
    Mat3::from_cols(to * by.x, to * by.y, to * by.z)
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// What is between is where it is to be, within what is said of it, or it is not told.
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

    /// Nothing is told of what is another appearance, far away, or beside a jump.
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
}
