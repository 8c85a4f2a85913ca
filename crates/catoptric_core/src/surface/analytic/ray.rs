//! Helpers for the ray intersections of all kinds.

use glam::DVec3;

/// The part of a ray's `near` to `far` that lies in a box, or none.
#[inline]
pub(super) fn clip(origin: DVec3, direction: DVec3, [min, max]: [DVec3; 2], near: f64, far: f64) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (near, far);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        if d == 0.0 {
            if o < min[axis] || o > max[axis] {
                return None;
            }
            continue;
        }
        let inverse = 1.0 / d;
        let (a, b) = ((min[axis] - o) * inverse, (max[axis] - o) * inverse);
        let (first, last) = if a <= b { (a, b) } else { (b, a) };
        enter = if first > enter { first } else { enter };
        leave = if last < leave { last } else { leave };
    }
    // Written so that a NaN is no meeting; rays without end are bounded by the box.
    (enter <= leave && leave < f64::INFINITY).then_some((enter, leave))
}

/// A box with a little room around it, so that a surface that touches it is surely inside.
pub(super) fn roomy([min, max]: [DVec3; 2]) -> [DVec3; 2] {
    let room = (max - min) * 1e-9;
    [min - room, max + room]
}

/// Bernstein coefficients of degree 4 of a product of two of degree 2.
#[inline]
pub(super) fn product_of_quadratics(a: [f64; 3], b: [f64; 3]) -> [f64; 5] {
    [
        a[0] * b[0],
        0.5 * (a[0] * b[1] + a[1] * b[0]),
        (a[0] * b[2] + 4.0 * a[1] * b[1] + a[2] * b[0]) / 6.0,
        0.5 * (a[1] * b[2] + a[2] * b[1]),
        a[2] * b[2],
    ]
}
