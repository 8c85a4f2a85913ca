//! Folds: where a scene surface crosses a focal surface, two of its appearances merge and end.

use super::Corner;
use super::edge::EdgeRule;
use crate::methods::projection::Projection;
use glam::Vec2;

/// The gaps between two merging appearances of an edge, as quadrilaterals, where the third corner shows neither.
///
/// Pieces end a little before the focal surface, on each of the two sheets; the strip between closes the picture.
pub(super) fn gaps<'a>(
    rule: &EdgeRule,
    one: &'a Corner,
    other: &'a Corner,
    missing: &Corner,
) -> Vec<[(&'a Projection, Vec2); 4]> {
    let here = one.appearances();
    let mut found = Vec::new();
    if here.len() < 2 || other.appearances().len() < 2 {
        return found;
    }
    let along = other.position - one.position;
    let away = missing.position - one.position;
    let ends = |appearance: &Projection| rule.partner(appearance, here, missing.appearances(), away).is_none();
    let near = |a: &Projection, b: &Projection| a.image_px.distance(b.image_px) < rule.fold_px();
    for (index, first) in here.iter().enumerate() {
        for second in &here[index + 1..] {
            let merge = first.focal_index.abs_diff(second.focal_index) == 1 && near(first, second);
            if !(merge && ends(first) && ends(second)) {
                continue;
            }
            let partner = |appearance| rule.partner(appearance, here, other.appearances(), along);
            if let (Some(third), Some(fourth)) = (partner(second), partner(first))
                && near(third, fourth)
            {
                let (here, there) = (one.weights, other.weights);
                found.push([(first, here), (second, here), (third, there), (fourth, there)]);
            }
        }
    }
    found
}
