//! Directions on the faces of a cube, and footprints of look-ups.

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
    let size = direction.abs();
    let axis = size.max_position();
    let face = axis * 2 + usize::from(direction[axis] < 0.0);
    let [right, up, back] = FACES[face].map(Vec3::from);
    let depth = -direction.dot(back);
    if !(depth > 0.0 && direction.is_finite()) {
        return (4, Vec2::ZERO, 1.0); // the direction of a vanished vector is as good as any
    }
    let at = Vec2::new(direction.dot(right), -direction.dot(up)) / depth;
    (face, at, 1.0 + at.length_squared())
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
        let [x2, y2] = changes.map(Vec3::length_squared);
        let (major2, minor2, axis) = if x2 >= y2 { (x2, y2, changes[0]) } else { (y2, x2, changes[1]) };
        let count = (major2 / minor2.max(1e-20)).sqrt().clamp(1.0, most).ceil();
        if !(count > 1.0 && major2.is_finite()) {
            return Self { count: 1, spread: major2.sqrt(), axis: Vec3::ZERO };
        }
        Self { count: count as u32, spread: major2.sqrt() / count, axis }
    }

    /// Where they are, from the footprint's middle.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn offsets(self) -> impl Iterator<Item = Vec3> {
        let step = 1.0 / self.count as f32;
        (0..self.count).map(move |probe| self.axis * ((probe as f32 + 0.5) * step - 0.5))
    }
}

/// The direction to a place of a face, not of unit length.
pub(super) fn direction_of(face: usize, at: Vec2) -> Vec3 {
    let [right, up, back] = FACES[face].map(Vec3::from);
    right * at.x - up * at.y - back
}
