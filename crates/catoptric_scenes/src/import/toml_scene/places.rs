//! Points, directions and turns of scene files, checked.

use super::keys::{Located, Text};
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::turn_about;
use glam::{DMat3, DQuat, DVec3, Vec3};

/// A point within the limits of scene files.
pub(super) fn exact_point(source: Text<'_>, field: &str, at: Located<[f64; 3]>) -> Result<DVec3, SceneError> {
    let limit = super::super::key_error::MAX_LENGTH;
    if at.value.iter().any(|number| number.abs() > limit) {
        return Err(source.invalid(
            at.begin,
            field,
            format!("{:?}; allowed is up to {limit:e} from the origin", at.value),
        ));
    }
    Ok(DVec3::from(at.value))
}

/// The same in single precision.
pub(super) fn point(source: Text<'_>, field: &str, at: Located<[f64; 3]>) -> Result<Vec3, SceneError> {
    Ok(exact_point(source, field, at)?.as_vec3())
}

/// A direction of unit length.
pub(super) fn exact_direction(source: Text<'_>, field: &str, at: Located<[f64; 3]>) -> Result<DVec3, SceneError> {
    let vector = DVec3::from(at.value).try_normalize();
    vector.ok_or_else(|| source.invalid(at.begin, field, "must not be zero"))
}

/// The same in single precision.
pub(super) fn direction(source: Text<'_>, field: &str, at: Located<[f64; 3]>) -> Result<Vec3, SceneError> {
    Ok(exact_direction(source, field, at)?.as_vec3())
}

/// Turns about the fixed axes x, then y, then z: Rz Ry Rx.
pub(super) fn rotation_about_fixed_axes(at: Located<[f64; 3]>) -> DQuat {
    // Whole turns are taken off in double precision, so that large angles keep their fraction.
    let [x, y, z] = at.value.map(|angle| (angle % 360.0).to_radians());
    turn_about(DVec3::Z, z) * turn_about(DVec3::Y, y) * turn_about(DVec3::X, x)
}

/// From the frame of a plane (x along its width, y its normal, z down its height) to the world.
pub(super) fn plane_rotation(normal: DVec3) -> DQuat {
    // `y x normal` loses its direction where the normal is parallel to y.
    let across = DVec3::Y.cross(normal);
    let width = if across.length() < 1e-6 { DVec3::X } else { across.normalize() };
    let width = (width - normal * width.dot(normal)).normalize();
    let height = width.cross(normal);
    DQuat::from_mat3(&DMat3::from_cols(width, normal, height))
}
