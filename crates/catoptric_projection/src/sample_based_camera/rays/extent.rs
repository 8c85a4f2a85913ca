//! Where boxes appear in a field of rays.

use crate::find::ray_map::RayField;
use catoptric_core::math::Aabb;
use glam::DVec3;

/// The rectangle of the field that a box appears in; returns `None` if some of it is beside or behind the eye.
pub(in super::super) fn extent(bounds: &Aabb, field: &dyn RayField) -> Option<[[f64; 2]; 2]> {
    let mut found = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for corner in 0..8 {
        let axis = |axis: usize| f64::from(if corner >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] });
        let place = field.place_of(DVec3::new(axis(0), axis(1), axis(2)))?;
        for (axis, place) in place.into_iter().enumerate() {
            found[0][axis] = found[0][axis].min(place);
            found[1][axis] = found[1][axis].max(place);
        }
    }
    Some(found)
}
