//! An outgoing ray of the dense ray map.

use glam::DVec3;

/// An outgoing ray, without the path that led to it.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct GridRay {
    /// Place of its view ray, in cells: those of the regular map are at whole numbers.
    pub(in super::super) place: [f32; 2],
    /// The first bounce point, and the unit normal there, on the side of the eye.
    pub(in super::super) first: DVec3,
    pub(in super::super) normal: DVec3,
    /// The tail, which is the last bounce point, and the unit direction.
    pub(in super::super) tail: DVec3,
    pub(in super::super) direction: DVec3,
    /// Optical length from the eye (its plane) to the tail.
    pub(in super::super) length: f64,
    /// Index of refraction of the medium that it runs through.
    pub(in super::super) medium: f64,
}
