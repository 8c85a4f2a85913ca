//! Sites of analytic surfaces: on the zero set of an implicit function.

use super::vertex::{ManifoldFrame, ManifoldVertex};
use catoptric_core::surface::patch::tangent_frame;
use catoptric_core::surface::{PlacedSurface, Taylor2};
use glam::{DVec2, DVec3};

/// More Newton steps than this onto a surface mean that it was lost.
const MAX_LANDING_STEPS: usize = 24;

/// A landing step of this share of the radius of curvature is the last: the error left is its square, below rounding.
const LAST_STEP: f64 = 1e-8;

/// The least cosine between the normals before and after a step: beyond it the step has reached another sheet, such
/// as the back of a thin wall.
const MIN_TURN_COSINE: f64 = -0.5;

/// The frame of a surface at a point on it.
#[inline]
pub(super) fn frame(position: DVec3, taylor: &Taylor2) -> Option<ManifoldFrame> {
    let normal = taylor.gradient.try_normalize()?;
    let inverse_length = 1.0 / taylor.gradient.dot(normal);
    let tangents = tangent_frame(normal);
    let normal_change = tangents.map(|tangent| {
        let change = taylor.hessian * tangent * inverse_length;
        change - normal * normal.dot(change)
    });
    let finite = position.is_finite() && normal_change[0].is_finite() && normal_change[1].is_finite();
    finite.then_some(ManifoldFrame { position, normal, tangents, normal_change })
}

/// Follows the gradient to the surface, by at most `reach`.
#[inline]
pub(super) fn landed(surface: &PlacedSurface, start: DVec3, reach: f64) -> Option<(ManifoldVertex, ManifoldFrame)> {
    let (position, taylor) = landing(surface, start, reach)?;
    Some((ManifoldVertex::on_surface(position), frame(position, &taylor)?))
}

/// The point where [`landed`] ends, and the function there.
#[inline]
fn landing(surface: &PlacedSurface, start: DVec3, reach: f64) -> Option<(DVec3, Taylor2)> {
    let mut position = start;
    for _ in 0..MAX_LANDING_STEPS {
        let mut taylor = surface.taylor2(position);
        let slope2 = taylor.gradient.length_squared();
        let change = taylor.gradient * (-taylor.value / slope2);
        let moved = position + change;
        // A vanishing gradient ends here, too: nothing is finite then.
        if !moved.is_finite() || moved.distance_squared(start) > reach * reach {
            return None;
        }
        let bend = taylor.hessian * change;
        let rounding = 4.0 * f64::EPSILON * position.abs().max_element();
        let is_last = bend.length_squared() <= LAST_STEP * LAST_STEP * slope2;
        if is_last || change.length_squared() <= rounding * rounding {
            taylor.gradient += bend;
            return Some((moved, taylor));
        }
        position = moved;
    }
    None
}

/// A step along the tangents and back onto the surface.
#[inline]
pub(super) fn stepped(
    surface: &PlacedSurface,
    from: &ManifoldFrame,
    step: DVec2,
) -> Option<(ManifoldVertex, ManifoldFrame)> {
    let along = from.tangents[0] * step.x + from.tangents[1] * step.y;
    // The surface falls away from its tangent plane: to second order the landing is done before it starts.
    let turned = from.normal_change[0] * step.x + from.normal_change[1] * step.y;
    let fall = 0.5 * turned.dot(along);
    let length = along.length();
    if !length.is_finite() {
        return None;
    }
    let start = from.position + along - from.normal * fall.clamp(-length, length);
    let (site, frame) = landed(surface, start, length + 1e-12 * from.position.abs().max_element())?;
    (frame.normal.dot(from.normal) > MIN_TURN_COSINE).then_some((site, frame))
}

/// The hit of a ray with the surface near a distance along it; `direction` is of unit length.
pub(super) fn intersection(
    surface: &PlacedSurface,
    origin: DVec3,
    direction: DVec3,
    near_distance: f64,
) -> Option<DVec3> {
    Some(landed_hit(surface, origin, direction, near_distance)?.0)
}

/// The same, with the unit normal on the outer side.
#[inline]
pub(super) fn arrival(
    surface: &PlacedSurface,
    origin: DVec3,
    direction: DVec3,
    near_distance: f64,
) -> Option<(DVec3, DVec3)> {
    let (position, taylor) = landed_hit(surface, origin, direction, near_distance)?;
    Some((position, taylor.gradient.try_normalize()?))
}

#[inline]
fn landed_hit(
    surface: &PlacedSurface,
    origin: DVec3,
    direction: DVec3,
    near_distance: f64,
) -> Option<(DVec3, Taylor2)> {
    let mut distance = near_distance;
    let leeway = 1e-4 * near_distance.abs();
    // A distance in single precision takes two steps, an exact one none; where the ray grazes they shrink more slowly.
    for _ in 0..MAX_LANDING_STEPS {
        let mut taylor = surface.taylor2(origin + direction * distance);
        let slope = taylor.gradient.dot(direction);
        let change = -taylor.value / slope;
        if !change.is_finite() {
            break;
        }
        distance += change;
        // The error after a step is its square times this: steps end when that is lost in rounding.
        let turn = taylor.hessian * direction;
        let bend = 0.5 * direction.dot(turn) / slope;
        let rounding = 4.0 * f64::EPSILON * (distance.abs() + origin.abs().max_element());
        if change.abs() <= rounding || (bend * change * change).abs() <= 0.25 * rounding {
            if (distance - near_distance).abs() > leeway {
                break;
            }
            taylor.gradient += turn * change;
            return Some((origin + direction * distance, taylor));
        }
    }
    // A grazing ray may not meet the surface at all in double precision: its nearest point does.
    let distance = distance.clamp(near_distance - leeway, near_distance + leeway);
    landing(surface, origin + direction * distance, f64::INFINITY)
}

/// Returns true if a point on the surface or its continuation lies within the surface's borders.
pub(super) fn is_within(surface: &PlacedSurface, point: DVec3) -> bool {
    let place = &surface.world_from_surface;
    let local = place.matrix3.transpose() * (point - place.translation);
    let bounds = surface.surface.bounds();
    let (low, high) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let leeway = DVec3::splat(1e-9 * (high - low).length());
    local.cmpge(low - leeway).all() && local.cmple(high + leeway).all()
}
