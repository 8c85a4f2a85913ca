//! Simple shapes that a surround is taken to have, and where rays meet them.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use glam::Vec3;

/// The shape that a surround is taken to have, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParallaxProxy {
    /// Infinitely far.
    Infinite,
    /// A box.
    Box(Aabb),
    /// A sphere about the map's centre.
    Sphere(f32),
    /// An upright cylinder about the map's centre, with a bottom and a top that are this much higher than that.
    Cylinder {
        /// About the axis through the centre.
        radius: f32,
        /// Below 0: how much lower the bottom is.
        bottom: f32,
        /// How much higher the top is.
        top: f32,
    },
}

impl ParallaxProxy {
    /// The direction of the map (about `center`) that a ray from `position` reads.
    ///
    /// A position outside the shape is met by growing the shape to hold it.
    #[inline(always)] // for the instructions of its caller
    pub fn direction(&self, center: Vec3, position: Vec3, direction: Vec3) -> Vec3 {
        self.directions(center, &Vec3Lanes::one(position), &Vec3Lanes::one(direction)).vector(0)
    }

    /// The same for several rays side by side.
    #[inline(always)] // for the instructions of its caller
    pub fn directions<const LANES: usize>(
        &self,
        center: Vec3,
        positions: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> Vec3Lanes<LANES> {
        let distances = self.distances(center, positions, directions);
        let mut found = *directions;
        let center = center.to_array();
        for lane in 0..LANES {
            let along = |axis: usize| positions[axis][lane] - center[axis] + directions[axis][lane] * distances[lane];
            let [x, y, z] = [along(0), along(1), along(2)];
            // On the shape's own centre every direction is as good as the ray's.
            let is_near = x * x + y * y + z * z > 0.0 && distances[lane] < f32::INFINITY;
            found[0][lane] = if is_near { x } else { directions[0][lane] };
            found[1][lane] = if is_near { y } else { directions[1][lane] };
            found[2][lane] = if is_near { z } else { directions[2][lane] };
        }
        found
    }

    /// By what shares the shape is to be grown about the origin, which is in it, to go through places.
    #[inline(always)] // for the instructions of its caller
    pub fn shares<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> Lanes<LANES> {
        let mut shares = Lanes::ZERO;
        // A quotient of nothing by nothing is no number, and left out.
        let larger = |share: f32, other: f32| if other > share { other } else { share };
        match *self {
            Self::Infinite => {}
            Self::Box(bounds) => {
                let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
                for axis in 0..3 {
                    for lane in 0..LANES {
                        let place = places[axis][lane];
                        let side = if place > 0.0 { max[axis] } else { min[axis] };
                        shares[lane] = larger(shares[lane], place.abs() / side.abs());
                    }
                }
            }
            Self::Sphere(radius) => {
                for lane in 0..LANES {
                    let [x, y, z] = places.components(lane);
                    shares[lane] = larger(0.0, (x * x + y * y + z * z).sqrt() / radius);
                }
            }
            Self::Cylinder { radius, bottom, top } => {
                for lane in 0..LANES {
                    let [x, y, z] = places.components(lane);
                    let end = if y > 0.0 { top } else { bottom };
                    let aside = larger(0.0, (x * x + z * z).sqrt() / radius);
                    shares[lane] = larger(aside, y.abs() / end.abs());
                }
            }
        }
        shares
    }

    /// How far a ray of unit direction from `position` goes until it meets the shape; infinite where it never does.
    #[inline(always)] // for the instructions of its caller
    pub fn distance(&self, center: Vec3, position: Vec3, direction: Vec3) -> f32 {
        self.distances(center, &Vec3Lanes::one(position), &Vec3Lanes::one(direction))[0]
    }

    /// The same for several rays side by side.
    #[inline(always)] // for the instructions of its caller
    pub fn distances<const LANES: usize>(
        &self,
        center: Vec3,
        positions: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> Lanes<LANES> {
        let mut distances = Lanes::splat(f32::INFINITY);
        match *self {
            Self::Infinite => {}
            Self::Box(bounds) => {
                let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
                for axis in 0..3 {
                    for lane in 0..LANES {
                        let (position, direction) = (positions[axis][lane], directions[axis][lane]);
                        let (above, below) = (max[axis].max(position), min[axis].min(position));
                        let exit = if direction > 0.0 { above } else { below };
                        distances[lane] = sooner(distances[lane], (exit - position) / direction);
                    }
                }
            }
            Self::Sphere(radius) => {
                let offset = *positions - center;
                for lane in 0..LANES {
                    let ([ox, oy, oz], [dx, dy, dz]) = (offset.components(lane), directions.components(lane));
                    let along = ox * dx + oy * dy + oz * dz;
                    let beyond = (radius * radius - (ox * ox + oy * oy + oz * oz)).max(0.0);
                    distances[lane] = (along * along + beyond).sqrt() - along;
                }
            }
            Self::Cylinder { radius, bottom, top } => {
                let offset = *positions - center;
                for lane in 0..LANES {
                    let ([ox, oy, oz], [dx, dy, dz]) = (offset.components(lane), directions.components(lane));
                    let along = ox * dx + oz * dz;
                    let beyond = (radius * radius - (ox * ox + oz * oz)).max(0.0);
                    let across2 = dx * dx + dz * dz;
                    let side = ((along * along + across2 * beyond).sqrt() - along) / across2;
                    let (above, below) = (top.max(oy), bottom.min(oy));
                    let end = if dy > 0.0 { above } else { below };
                    distances[lane] = sooner(sooner(f32::INFINITY, side), (end - oy) / dy);
                }
            }
        }
        distances
    }
}

/// The smaller of two distances. A component of zero never leaves a shape; its quotient is infinite or not a number,
/// and is left out.
#[inline(always)] // for the instructions of its caller
fn sooner(distance: f32, other: f32) -> f32 {
    if other.abs() < f32::INFINITY { distance.min(other) } else { distance }
}
