//! The places of reflectors.

use super::super::reflector;
use catoptric_core::scene::model::LocalTransform;
use glam::{DQuat, DVec3};

fn rotation(kind: &str, lines: &str) -> DQuat {
    let model = reflector(kind, lines).unwrap();
    let LocalTransform::Rigid { rotation, .. } = model.nodes[0].local else { panic!("in single precision") };
    rotation
}

/// The rotation of a sphere by `rotation_deg`.
fn turned(degrees: [f64; 3]) -> DQuat {
    rotation("sphere", &format!("radius = 1\nrotation_deg = {degrees:?}"))
}

#[test]
fn planes_are_wide_along_y_cross_normal() {
    for (normal, width) in [
        (DVec3::Z, DVec3::X),
        (DVec3::X, DVec3::NEG_Z),
        (DVec3::NEG_Z, DVec3::NEG_X),
        (DVec3::Y, DVec3::X),
        (DVec3::NEG_Y, DVec3::X),
        (DVec3::new(1.0, 1.0, 0.0).normalize(), DVec3::NEG_Z),
    ] {
        let [x, y, z] = normal.to_array();
        let rotation = rotation("plane", &format!("size = [1, 1]\nnormal = [{x:?}, {y:?}, {z:?}]"));
        assert!((rotation * DVec3::Y - normal).length() < 1e-12, "{normal}");
        assert!((rotation * DVec3::X - width).length() < 1e-12, "{normal}: {}", rotation * DVec3::X);
    }
}

#[test]
fn rotations_turn_about_x_first() {
    let rotation = turned([90.0, 90.0, 0.0]);
    // y goes to z by x, and on to x by y.
    assert!((rotation * DVec3::Y - DVec3::X).length() < 1e-12);
    let expected = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_y(0.2) * DQuat::from_rotation_x(0.1);
    let angles = [0.1f64, 0.2, 0.3].map(f64::to_degrees);
    assert!(turned(angles).angle_between(expected) < 1e-3);
}
