//! Quadratic forms over a tetrahedron of nodes.

use catoptric_core::math::lanes::LANES;
use catoptric_projection::parts::{FormBlock, FormWeights, PlaceAndLength, TetrahedronForm};
use glam::Vec3;

/// A quadratic function of the eye, given at the nodes with its derivatives there, is found again everywhere.
#[test]
fn quadratic_functions_are_found_again() {
    let nodes = [Vec3::ZERO, Vec3::new(1.0, 0.1, 0.0), Vec3::new(0.9, 1.0, -0.2), Vec3::new(1.1, 0.8, 1.0)];
    let place = |eye: Vec3| Vec3::new(eye.x * eye.y, eye.z * eye.z - eye.x, 0.5 * eye.y * eye.z + 3.0);
    let change = |eye: Vec3, step: Vec3| {
        let z = 0.5 * (eye.y * step.z + eye.z * step.y);
        Vec3::new(eye.x * step.y + eye.y * step.x, 2.0 * eye.z * step.z - step.x, z)
    };
    let corners = nodes.map(|node| PlaceAndLength { place: place(node), length: node.length_squared() });
    let form = TetrahedronForm::new(corners, |one, other| {
        let way = nodes[other] - nodes[one];
        let place = (change(nodes[one], way) - change(nodes[other], way)) * 0.5;
        PlaceAndLength { place, length: (nodes[one] - nodes[other]).dot(way) }
    });
    for weights in [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.25; 4], [0.1, 0.2, 0.3, 0.4]] {
        let eye: Vec3 = nodes.iter().zip(weights).map(|(node, weight)| *node * weight).sum();
        let (found, length) = form.at(&FormWeights::new(weights));
        // Bows are kept to half a percent.
        assert!(found.distance(place(eye).as_dvec3()) < 1e-3, "{found}, {}", place(eye));
        assert!((length - eye.length_squared()).abs() < 2e-3, "{length}");
        let (all, lengths) = FormBlock::new(&[form]).at(&FormWeights::new(weights));
        assert_eq!((all.map(|axis| axis[LANES - 1]), lengths[0]), (found.to_array(), length));
    }
}
