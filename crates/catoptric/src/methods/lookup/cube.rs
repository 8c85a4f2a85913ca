//! Directions on the faces of a cube, and footprints of look-ups.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::lanes::{Lane, Lanes, one, vector};
use glam::{Vec2, Vec3, Vec3A};

/// Right, up and back (against the line of sight) of the six faces: +x, -x, +y, -y, +z, -z.
pub(super) const FACES: [[Vec3A; 3]; 6] = [
    [Vec3A::NEG_Z, Vec3A::Y, Vec3A::NEG_X],
    [Vec3A::Z, Vec3A::Y, Vec3A::X],
    [Vec3A::X, Vec3A::NEG_Z, Vec3A::NEG_Y],
    [Vec3A::X, Vec3A::Z, Vec3A::Y],
    [Vec3A::X, Vec3A::Y, Vec3A::NEG_Z],
    [Vec3A::NEG_X, Vec3A::Y, Vec3A::Z],
];

/// The face that a direction meets, where on it (-1..1, x right, y down), and the squared secant to its middle.
#[inline(always)] // for the instructions of its caller
pub(super) fn locate(direction: Vec3) -> (usize, Vec2, f32) {
    let Located { face, at: [x, y], secant2 } = Located::of(&one(direction));
    (face[0] as usize, Vec2::new(x[0], y[0]), secant2[0])
}

/// Places on a cube, side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located<const LANES: usize> {
    /// The face that a direction meets.
    pub(super) face: [u32; LANES],
    /// Where on it, from -1 to 1: to the right and down.
    pub(super) at: [Lane<LANES>; 2],
    /// The squared secant to its middle.
    pub(super) secant2: Lane<LANES>,
}

impl<const LANES: usize> Located<LANES> {
    /// Where directions meet a cube; that of a vanished vector is as good as any.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn of(directions: &Lanes<LANES>) -> Self {
        let mut found = Self { face: [0; LANES], at: [[0.0; LANES]; 2], secant2: [0.0; LANES] };
        for lane in 0..LANES {
            let [x, y, z] = [directions[0][lane], directions[1][lane], directions[2][lane]];
            let is_x = x.abs() >= y.abs() && x.abs() >= z.abs();
            let is_y = !is_x && y.abs() >= z.abs();
            let along = if is_x {
                x
            } else if is_y {
                y
            } else {
                z
            };
            let is_negative = along < 0.0;
            // As the axes of FACES have it.
            let side_x = if is_negative { z } else { -z };
            let side_z = if is_negative { -x } else { x };
            let right = if is_x {
                side_x
            } else if is_y {
                x
            } else {
                side_z
            };
            let down_y = if is_negative { -z } else { z };
            let down = if is_y { down_y } else { -y };
            let axis = if is_x {
                0
            } else if is_y {
                1
            } else {
                2
            };
            let (u, v) = (right / along.abs(), down / along.abs());
            // What is no number is not: a vector that vanishes, or one with a component that is none.
            let is_known = u.abs() <= 1.0 && v.abs() <= 1.0;
            found.face[lane] = if is_known { axis * 2 + u32::from(is_negative) } else { 4 };
            found.at[0][lane] = if is_known { u } else { 0.0 };
            found.at[1][lane] = if is_known { v } else { 0.0 };
            found.secant2[lane] = 1.0 + found.at[0][lane] * found.at[0][lane] + found.at[1][lane] * found.at[1][lane];
        }
        found
    }
}

/// The look-ups of a footprint, side by side along its longer axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Probes {
    /// How many.
    pub(super) count: u32,
    /// Of what width each one is.
    pub(super) spread: f32,
    axis: Vec3,
}

impl Probes {
    /// Of a footprint whose place changes by this from pixel to pixel: as many as its axes' ratio, and no more than `most`.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn of(changes: [Vec3; 2], most: f32) -> Self {
        let ProbeRows { count, spread, axis } = ProbeRows::of(&changes.map(one), most);
        Self { count: count[0] as u32, spread: spread[0], axis: vector(&axis, 0) }
    }

    /// Where they are, from the footprint's middle.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn offsets(self) -> impl Iterator<Item = Vec3> {
        let step = 1.0 / self.count as f32;
        (0..self.count).map(move |probe| self.axis * ((probe as f32 + 0.5) * step - 0.5))
    }
}

/// The look-ups of several footprints: of each as for [`Probes`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeRows<const LANES: usize> {
    /// How many, a whole number.
    pub(super) count: Lane<LANES>,
    /// Of what width each one is.
    pub(super) spread: Lane<LANES>,
    axis: Lanes<LANES>,
}

impl<const LANES: usize> ProbeRows<LANES> {
    /// Of footprints whose places change by this from pixel to pixel, as [`Probes::of`].
    #[inline(always)] // for the instructions of its caller
    pub(super) fn of(changes: &[Lanes<LANES>; 2], most: f32) -> Self {
        let mut rows = Self { count: [1.0; LANES], spread: [0.0; LANES], axis: [[0.0; LANES]; 3] };
        for lane in 0..LANES {
            let length2 = |change: &Lanes<LANES>| {
                let [x, y, z] = [change[0][lane], change[1][lane], change[2][lane]];
                x * x + y * y + z * z
            };
            let (x2, y2) = (length2(&changes[0]), length2(&changes[1]));
            let is_x = x2 >= y2;
            let (major2, minor2) = if is_x { (x2, y2) } else { (y2, x2) };
            let count = (major2 / minor2.max(1e-20)).sqrt().max(1.0).min(most).ceil();
            let is_row = count > 1.0 && major2 < f32::INFINITY;
            rows.count[lane] = if is_row { count } else { 1.0 };
            rows.spread[lane] = major2.sqrt() / rows.count[lane];
            for axis in 0..3 {
                let long = if is_x { changes[0][axis][lane] } else { changes[1][axis][lane] };
                rows.axis[axis][lane] = if is_row { long } else { 0.0 };
            }
        }
        rows
    }

    /// The places of one look-up of each footprint; those beyond their counts are anywhere.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn places(&self, middles: &Lanes<LANES>, number: u32) -> Lanes<LANES> {
        let mut places = *middles;
        for axis in 0..3 {
            for lane in 0..LANES {
                let share = (number as f32 + 0.5) * (1.0 / self.count[lane]) - 0.5;
                places[axis][lane] += self.axis[axis][lane] * share;
            }
        }
        places
    }
}

/// The direction to a place of a face, not of unit length.
pub(super) fn direction_of(face: usize, at: Vec2) -> Vec3 {
    let [right, up, back] = FACES[face].map(Vec3::from);
    right * at.x - up * at.y - back
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    #[test]
    fn places_of_faces_are_found_again() {
        let mut random = Stream::new(3);
        for number in 0..600 {
            let (face, at) = (number % 6, Vec2::from([0; 2].map(|_| random.next_between(-0.999, 0.999))));
            let direction = direction_of(face, at) * random.next_between(0.1, 10.0);
            let (found, place, secant2) = locate(direction);
            let cosine = -direction.normalize().dot(FACES[face][2].into());
            assert!(found == face && place.distance(at) < 1e-5, "{face} {at}: {found} {place}");
            assert!((secant2 * cosine * cosine - 1.0).abs() < 1e-5);
        }
        for nowhere in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 1.0)] {
            let (face, at, secant2) = locate(nowhere);
            assert!(face < 6 && at.abs().max_element() <= 1.0 && secant2 >= 1.0, "{nowhere}: {face} {at}");
        }
    }
}
