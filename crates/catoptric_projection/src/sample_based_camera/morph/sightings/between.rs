//! Appearances of points between two others, where these tell enough.
//!
//! Along a straight line from one point to another the reflection point follows a cubic curve whose ends and tangents
//! are known (Hermite).

use super::walk::expected_move;
use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
use glam::{Mat3, Vec3};

/// The greatest estimated error of interpolated reflection points, as a share of the mirror's size. Chosen, not
/// measured.
const MOST_ERROR: f32 = 3e-5;

/// The error between two points, as a share of the misfit of the derivatives at both. For points that move as a square
/// root it is from a tenth to a twentieth half-way.
const ERROR_OF_MISFIT: f32 = 0.125;

/// The longest step between two points, as a share of their distance from the mirror: changes beside a point may be
/// missed over longer ones. Chosen, not measured.
const LONGEST: f32 = 0.125;

/// A bound of the error of a first reflection point between two others, at one of the nodes, or of the polynomial
/// between these, in scene units; `None` if it is too large for a mirror of this size.
pub(super) fn error_between(
    one: &[Sighting; MOST_NODES],
    other: &[Sighting; MOST_NODES],
    step: Vec3,
    size: f32,
) -> Option<f32> {
    // The offset of the half-way point from the mean of both ends, at a node.
    let beside = |node: usize| (one[node].change - other[node].change) * (step * 0.125);
    let at_first = beside(0);
    let (mut misfit, mut bent) = (0.0f32, 0.0f32);
    for (node, (one, other)) in one.iter().zip(other).enumerate() {
        let expected = expected_move([one.change, other.change], step);
        misfit = misfit.max((other.first - one.first).distance(expected));
        // If nodes differ in this, so do their derivatives with respect to the eye, of which the mean is taken.
        bent = bent.max(beside(node).distance(at_first));
    }
    let error = (misfit + bent) * ERROR_OF_MISFIT;
    (error <= MOST_ERROR * size).then_some(error)
}

/// The nodes' sightings half-way between two points, in a mirror of this size around this middle; `None` where they
/// have to be searched. Both orders of the points give the same bits: neighbours ask from both sides.
pub fn half_way(
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
            // The true path is the shortest of those near it, so that an error of the point hardly changes the length.
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
