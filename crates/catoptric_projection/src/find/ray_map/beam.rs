//! Beams: planes around a bundle of rays, between which all points near the rays lie, however wide these fan out.

use catoptric_core::math::portable::PortableMath;
use glam::{DVec2, DVec3, Vec3};

/// Planes of a beam.
pub(super) const PLANES: usize = 5;

/// Rounding of a position's distance from a plane in single precision, as a share of the coordinates. About sixteen
/// roundings.
const ROUNDING: f32 = 2e-6;

/// Planes are tilted in this many steps until their side holds all directions; those that do not get there are left
/// out. Chosen, not measured.
const TILTS: usize = 6;

/// Reach of a sample: `origin + origin_change r + t (direction + direction_change r)` for `|r| <= 1` and `t >= 0`.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Origin of its rays.
    pub origin: DVec3,
    /// Their direction.
    pub direction: DVec3,
    /// See above.
    pub origin_change: [DVec3; 2],
    /// See above.
    pub direction_change: [DVec3; 2],
}

impl Reach {
    /// A ray alone.
    pub fn of_ray(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, origin_change: [DVec3::ZERO; 2], direction_change: [DVec3::ZERO; 2] }
    }

    /// The largest component along `normal` of where its rays start.
    fn origins_along(&self, normal: DVec3) -> f64 {
        let [x, y] = self.origin_change.map(|change| change.dot(normal));
        self.origin.dot(normal) + x.hypotenuse(y)
    }

    /// The largest component along `normal` of its rays' directions.
    fn directions_along(&self, normal: DVec3) -> f64 {
        let [x, y] = self.direction_change.map(|change| change.dot(normal));
        self.direction.dot(normal) + x.hypotenuse(y)
    }
}

/// A half-space: all points whose component along `normal` is at most `limit`.
#[derive(Clone, Copy, Debug)]
pub(super) struct BeamPlane {
    pub(super) normal: Vec3,
    pub(super) limit: f32,
}

impl BeamPlane {
    const NOTHING: Self = Self { normal: Vec3::ZERO, limit: f32::NEG_INFINITY };
    const EVERYTHING: Self = Self { normal: Vec3::ZERO, limit: f32::INFINITY };

    /// The plane across `side` that holds all of `reaches`, tilted against their mean `direction` as far as they open.
    fn beside(reaches: &[Reach], side: DVec3, direction: DVec3) -> Self {
        let mut tilt = f64::NEG_INFINITY;
        for reach in reaches {
            tilt = tilt.max(reach.direction.dot(side) / reach.direction.dot(direction).max(1e-3));
        }
        for _ in 0..TILTS {
            let normal = side - direction * tilt;
            let outermost =
                reaches.iter().map(|reach| reach.directions_along(normal)).fold(f64::NEG_INFINITY, f64::max);
            if outermost <= 1e-9 * normal.length() {
                return Self::holding(reaches, normal);
            }
            tilt = reaches.iter().fold(tilt, |tilt: f64, reach| {
                let spread = reach.directions_along(normal) - reach.direction.dot(normal);
                // A little more, as the spread across the tilted plane may be larger.
                tilt.max((reach.direction.dot(side) + 1.02 * spread) / reach.direction.dot(direction).max(1e-3))
            });
        }
        Self::EVERYTHING
    }

    fn holding(reaches: &[Reach], normal: DVec3) -> Self {
        let Some(normal) = normal.try_normalize() else { return Self::EVERYTHING };
        let limit = reaches.iter().map(|reach| reach.origins_along(normal)).fold(f64::NEG_INFINITY, f64::max);
        if !limit.is_finite() {
            return Self::EVERYTHING;
        }
        Self { normal: normal.as_vec3(), limit: limit as f32 + ROUNDING * limit.abs() as f32 }
    }
}

/// Intersection of five half spaces: two across the widest spread of rays, two across the other way, one at their
/// start.
#[derive(Clone, Copy, Debug)]
pub struct Beam(pub(super) [BeamPlane; PLANES]);

impl Beam {
    /// The beam without any point.
    pub const NOTHING: Self = Self([BeamPlane::NOTHING; PLANES]);
    const EVERYTHING: Self = Self([BeamPlane::EVERYTHING; PLANES]);

    /// The beam around all of `reaches`, whose spread is measured at a distance along them.
    pub fn around(reaches: &[Reach], distance: f64) -> Self {
        if reaches.is_empty() {
            return Self::NOTHING;
        }
        let sum: DVec3 = reaches.iter().map(|reach| reach.direction).sum();
        let Some(direction) = sum.try_normalize() else { return Self::EVERYTHING };
        let [wide, narrow] = spread_axes(reaches, direction, distance);
        Self([
            BeamPlane::beside(reaches, wide, direction),
            BeamPlane::beside(reaches, -wide, direction),
            BeamPlane::beside(reaches, narrow, direction),
            BeamPlane::beside(reaches, -narrow, direction),
            if reaches.iter().all(|reach| reach.directions_along(-direction) <= 0.0) {
                BeamPlane::holding(reaches, -direction)
            } else {
                BeamPlane::EVERYTHING
            },
        ])
    }
}

/// Rounding error of a point's distance from a plane in single precision.
#[inline]
pub(super) fn rounding_at(point: Vec3) -> f32 {
    ROUNDING * point.abs().max_element()
}

/// Two unit vectors across `direction`: along which the reaches spread most at a distance, and least.
fn spread_axes(reaches: &[Reach], direction: DVec3, distance: f64) -> [DVec3; 2] {
    let (first, second) = direction.any_orthonormal_pair();
    let lateral = |vector: DVec3| DVec2::new(vector.dot(first), vector.dot(second));
    let places = || reaches.iter().map(|reach| lateral(reach.origin + reach.direction * distance));
    let center = places().sum::<DVec2>() / reaches.len() as f64;
    // The entries of the covariance.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (reach, place) in reaches.iter().zip(places()) {
        let change = |index: usize| lateral(reach.origin_change[index] + reach.direction_change[index] * distance);
        for vector in [place - center, change(0), change(1)] {
            xx += vector.x * vector.x;
            xy += vector.x * vector.y;
            yy += vector.y * vector.y;
        }
    }
    let (sine, cosine) = (0.5 * (2.0 * xy).arc_tangent2(xx - yy)).sine_cosine();
    [first * cosine + second * sine, second * cosine - first * sine]
}
