//! The law of a bounce by its half vector: it lies along the normal where a point appears.

use crate::find::virtual_objects::VertexRays;
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::Vec3;

/// The combination of the directions before and after a bounce into the half vector.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Law {
    /// The side of the surface that is met: 1 is the outer one, -1 the inner one.
    pub(in super::super) side: f32,
    /// The index of refraction before the bounce over that after it.
    pub(in super::super) eta: f32,
    /// Turns the half vector to the side that is met.
    pub(in super::super) sign: f32,
    pub(in super::super) transmits: bool,
}

/// A direction to a point, with the half vector of the law.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Half {
    /// The half vector, of unit length, on the side that is met.
    pub(in super::super) unit: Vec3,
    /// The unit direction to the point, and its distance.
    pub(in super::super) to_point: Vec3,
    pub(in super::super) distance: f32,
    /// The length of the half vector before it was made a unit, with the sign.
    pub(in super::super) length: f32,
}

impl Law {
    pub(in super::super) fn new(rays: &VertexRays) -> Self {
        let transmits = rays.kind == BounceKind::Transmit;
        // Into the denser side the refracted direction weighs more.
        let sign = if transmits && rays.eta < 1.0 { -1.0 } else { 1.0 };
        Self { side: rays.side, eta: rays.eta, sign, transmits }
    }

    /// The half vector at a position; `toward` is the unit direction back along the arriving ray.
    #[inline]
    pub(in super::super) fn half(&self, position: Vec3, toward: Vec3, point: Vec3) -> Half {
        let from = point - position;
        let distance = from.length();
        let to_point = from / distance;
        let sum = toward * self.eta + to_point;
        let length = sum.length() * self.sign;
        Half { unit: sum / length, to_point, distance, length }
    }

    /// The change of a component of the unit half vector, along `tangent`, with the point.
    #[inline]
    pub(in super::super) fn change(&self, half: &Half, tangent: Vec3) -> Vec3 {
        let across = tangent - half.unit * half.unit.dot(tangent);
        let turned = across - half.to_point * half.to_point.dot(across);
        turned / (half.length * half.distance)
    }
}
