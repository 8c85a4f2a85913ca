//! The mean of the appearances at the nodes.

use crate::find::node_sightings::{MOST_NODES, Sighting};
use crate::find::tetrahedron_form::{FormWeights, PlaceAndLength, TetrahedronForm};
use glam::{DVec3, Mat3, Vec3};

/// The mean for an eye.
pub(super) struct Mean {
    pub(super) first: DVec3,
    pub(super) change: Mat3,
    pub(super) normal: Vec3,
    pub(super) length: f32,
    pub(super) last_segment: f32,
    pub(super) error: f32,
}

impl Mean {
    /// The mean with these weights of the nodes.
    pub(super) fn of(form: &TetrahedronForm, weights: &FormWeights, at: &[Sighting]) -> Self {
        let (first, length) = form.at(weights);
        let mut mean = Self { first, change: Mat3::ZERO, normal: Vec3::ZERO, length, last_segment: 0.0, error: 0.0 };
        for (weight, seen) in weights.of_nodes().into_iter().zip(at) {
            mean.change += seen.change * weight;
            mean.normal += seen.normal * weight;
            mean.last_segment += weight * seen.last_segment;
            mean.error += weight * seen.error;
        }
        mean
    }
}

/// The paper's mean of the nodes' sightings.
pub(super) fn plain_form_of(at: &[Sighting]) -> TetrahedronForm {
    TetrahedronForm::new(corners_of(at), |_, _| PlaceAndLength::default())
}

/// The reflection point and length at each node; missing nodes repeat the first one.
fn corners_of(at: &[Sighting]) -> [PlaceAndLength; MOST_NODES] {
    let none = Sighting::default();
    std::array::from_fn(|node| {
        let seen = at.get(node).or(at.first()).unwrap_or(&none);
        PlaceAndLength { place: seen.first, length: seen.length }
    })
}

/// The first reflection point and the path's length while the eye moves among nodes at these places.
///
/// Where derivatives with respect to the eye are known, half of their prediction for the way from each node is added:
/// this is exact for quadratic changes (the mean alone, as in the paper, is exact for linear ones). Lengths change by
/// the way along the ray (Fermat). Elsewhere the mean of points of a curved surface lies below it, by half of what
/// their tangent planes say.
pub(super) fn form_of(nodes: &[Vec3; MOST_NODES], at: &[Sighting]) -> TetrahedronForm {
    let knows_all = at.iter().all(|seen| seen.change_with_eye.is_some());
    let none = Sighting::default();
    let seen = |node: usize| at.get(node).or(at.first()).unwrap_or(&none);
    let ray = |node: usize| (seen(node).first - nodes[node]).normalize_or_zero();
    let rays = [ray(0), ray(1), ray(2), ray(3)];
    TetrahedronForm::new(corners_of(at), |from, to| {
        let (one, other, way) = (seen(from), seen(to), nodes[to] - nodes[from]);
        let apart = one.first - other.first;
        let below = |seen: &Sighting| seen.normal * apart.dot(seen.normal);
        let moved = |seen: &Sighting| seen.change_with_eye.unwrap_or_default() * way;
        let place = if knows_all { moved(one) - moved(other) } else { below(one) - below(other) };
        let length = (rays[to] - rays[from]).dot(way);
        PlaceAndLength { place: place * 0.5, length: length * 0.5 }
    })
}
