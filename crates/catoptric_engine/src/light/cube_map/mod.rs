//! Cube maps: faces, places of directions on them, and footprints of look-ups.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

mod filtered;

use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
pub use filtered::CubeMap;
use glam::{Vec2, Vec3, Vec3A};

/// Right, up and back (against the line of sight) of the six faces: +x, -x, +y, -y, +z, -z.
pub const FACES: [[Vec3A; 3]; 6] = [
    [Vec3A::NEG_Z, Vec3A::Y, Vec3A::NEG_X],
    [Vec3A::Z, Vec3A::Y, Vec3A::X],
    [Vec3A::X, Vec3A::NEG_Z, Vec3A::NEG_Y],
    [Vec3A::X, Vec3A::Z, Vec3A::Y],
    [Vec3A::X, Vec3A::Y, Vec3A::NEG_Z],
    [Vec3A::NEG_X, Vec3A::Y, Vec3A::Z],
];

/// The face that a direction of any length meets, and where on it, from -1 to 1 to the right and down: that of its
/// largest component, of equal ones the first. Vectors without a direction have places that are not numbers.
#[inline(always)] // for the instructions of its caller
pub fn place_on_face([x, y, z]: [f32; 3]) -> (u32, [f32; 2]) {
    let is_x = x.abs() >= y.abs() && x.abs() >= z.abs();
    let is_y = !is_x && y.abs() >= z.abs();
    let (axis, along) = match (is_x, is_y) {
        (true, _) => (0, x),
        (_, true) => (1, y),
        _ => (2, z),
    };
    let is_negative = along < 0.0;
    // By the axes of FACES.
    let side_x = if is_negative { z } else { -z };
    let side_z = if is_negative { -x } else { x };
    let right = match (is_x, is_y) {
        (true, _) => side_x,
        (_, true) => x,
        _ => side_z,
    };
    let down_y = if is_negative { -z } else { z };
    let down = if is_y { down_y } else { -y };
    (axis * 2 + u32::from(is_negative), [right / along.abs(), down / along.abs()])
}

/// The direction to a place of a face, not of unit length.
#[inline]
pub fn direction_of(face: usize, at: Vec2) -> Vec3 {
    let [right, up, back] = FACES[face].map(Vec3::from);
    right * at.x - up * at.y - back
}

/// The face that a direction meets, where on it (-1..1, x right, y down), and the squared secant to its middle.
#[inline(always)] // for the instructions of its caller
pub fn locate(direction: Vec3) -> (usize, Vec2, f32) {
    let Located { face, at: [x, y], secant2 } = Located::of(&Vec3Lanes::one(direction));
    (face[0] as usize, Vec2::new(x[0], y[0]), secant2[0])
}

/// The texels that a footprint of a width (radians) spans on a face of `size` texels a side, by the squared secant of
/// its direction to the face's middle: there a texel spans 2 / size, and its solid angle falls with the cube of the
/// cosine.
#[inline(always)] // for the instructions of its caller
pub fn texels_across(spread: f32, size: u32, secant2: f32) -> f32 {
    spread * size as f32 * 0.5 * (secant2 * secant2.sqrt()).sqrt()
}

/// Places on a cube, side by side.
#[derive(Clone, Copy, Debug)]
pub struct Located<const LANES: usize> {
    /// The face that a direction meets.
    pub face: [u32; LANES],
    /// Place on it, from -1 to 1: to the right and down.
    pub at: [Lanes<LANES>; 2],
    /// The squared secant to its middle.
    pub secant2: Lanes<LANES>,
}

impl<const LANES: usize> Located<LANES> {
    /// Places where directions meet a cube; any place for a vector of zero length.
    #[inline(always)] // for the instructions of its caller
    pub fn of(directions: &Vec3Lanes<LANES>) -> Self {
        let mut found = Self { face: [0; LANES], at: [Lanes::ZERO; 2], secant2: Lanes::ZERO };
        for lane in 0..LANES {
            let (face, [u, v]) = place_on_face(directions.components(lane));
            // Comparisons with no number are false: of a vector that vanishes, or one with a component that is none.
            let is_known = u.abs() <= 1.0 && v.abs() <= 1.0;
            found.face[lane] = if is_known { face } else { 4 };
            found.at[0][lane] = if is_known { u } else { 0.0 };
            found.at[1][lane] = if is_known { v } else { 0.0 };
            found.secant2[lane] = 1.0 + found.at[0][lane] * found.at[0][lane] + found.at[1][lane] * found.at[1][lane];
        }
        found
    }
}

/// The look-ups of a footprint, side by side along its longer axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Probes {
    /// How many.
    pub(crate) count: u32,
    /// Width of each one.
    pub(crate) spread: f32,
    axis: Vec3,
}

impl Probes {
    /// Probes of a footprint whose place changes by this from pixel to pixel: as many as its axes' ratio, and no more
    /// than `most`.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn of(changes: [Vec3; 2], most: f32) -> Self {
        let ProbeRows { count, spread, axis } = ProbeRows::of(&changes.map(Vec3Lanes::one), most);
        Self { count: count[0] as u32, spread: spread[0], axis: axis.vector(0) }
    }

    /// Offsets from the footprint's middle.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn offsets(self) -> impl Iterator<Item = Vec3> {
        let step = 1.0 / self.count as f32;
        (0..self.count).map(move |probe| self.axis * ((probe as f32 + 0.5) * step - 0.5))
    }
}

/// The look-ups of several footprints: of each as for `Probes`.
#[derive(Clone, Copy, Debug)]
pub struct ProbeRows<const LANES: usize> {
    /// How many, a whole number.
    pub count: Lanes<LANES>,
    /// Width of each one.
    pub spread: Lanes<LANES>,
    axis: Vec3Lanes<LANES>,
}

impl<const LANES: usize> ProbeRows<LANES> {
    /// Probes of footprints whose places change by this from pixel to pixel, as `Probes::of`.
    #[inline(always)] // for the instructions of its caller
    pub fn of(changes: &[Vec3Lanes<LANES>; 2], most: f32) -> Self {
        let mut rows = Self { count: Lanes::splat(1.0), spread: Lanes::ZERO, axis: Vec3Lanes::ZERO };
        for lane in 0..LANES {
            let length2 = |change: &Vec3Lanes<LANES>| {
                let [x, y, z] = change.components(lane);
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
    pub fn places(&self, middles: &Vec3Lanes<LANES>, number: u32) -> Vec3Lanes<LANES> {
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
