//! Primitives under weights of their morph targets.

use super::super::model::Primitive;
use glam::{Vec3, Vec4};
use std::borrow::Cow;

/// Positions, normals and tangents of a primitive after morphing; borrowed where nothing changes.
pub(super) struct PosedPrimitive<'a> {
    pub(super) positions: Cow<'a, [Vec3]>,
    pub(super) normals: Cow<'a, [Vec3]>,
    pub(super) tangents: Cow<'a, [Vec4]>,
}

/// A primitive with so much of each of its morph targets; weights that are no numbers count as 0.
pub(super) fn morphed<'a>(primitive: &'a Primitive, weights: &[f32]) -> PosedPrimitive<'a> {
    let mut shape = PosedPrimitive {
        positions: (&primitive.positions).into(),
        normals: (&primitive.normals).into(),
        tangents: (&primitive.tangents).into(),
    };
    for (target, &weight) in primitive.morph_targets.iter().zip(weights) {
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        for (arrays, offsets) in [(&mut shape.positions, &target.positions), (&mut shape.normals, &target.normals)] {
            if !offsets.is_empty() && !arrays.is_empty() {
                arrays.to_mut().iter_mut().zip(offsets).for_each(|(value, offset)| *value += *offset * weight);
            }
        }
        if !target.tangents.is_empty() && !shape.tangents.is_empty() {
            let tangents = shape.tangents.to_mut().iter_mut().zip(&target.tangents);
            tangents.for_each(|(value, offset)| *value += (*offset * weight).extend(0.0));
        }
    }
    shape
}
