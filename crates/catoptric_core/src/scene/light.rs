//! Punctual lights, as in KHR_lights_punctual.

use super::Ray;
use glam::Vec3;

/// A light placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The kind and its parameters.
    pub kind: LightKind,
    /// Linear colour times intensity: candela for points and spots, lux for directional lights.
    pub intensity: Vec3,
    /// The position in the world (points and spots).
    pub position: Vec3,
    /// The direction of the light, unit length (directional lights and spots).
    pub direction: Vec3,
}

/// The kinds of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// Shines in all directions from a point.
    Point {
        /// The distance at which the light ends, infinite if it does not.
        range: f32,
    },
    /// Shines into a cone.
    Spot {
        /// The distance at which the light ends, infinite if it does not.
        range: f32,
        /// Cosine of the angle at which the light begins to fade.
        inner_cos: f32,
        /// Cosine of the angle at which it is gone.
        outer_cos: f32,
    },
}

impl Light {
    /// The ray from a point to the light, and how far that is; `None` at the light itself.
    #[inline]
    pub fn way_from(&self, point: Vec3) -> Option<(Ray, f32)> {
        if self.kind == LightKind::Directional {
            return Some((Ray { origin: point, direction: -self.direction }, f32::INFINITY));
        }
        let step = self.position - point;
        let distance = step.length();
        (distance >= f32::MIN_POSITIVE).then(|| (Ray { origin: point, direction: step / distance }, distance))
    }

    /// The direction towards the light and the irradiance on a surface that faces it, at `point`.
    #[inline]
    pub fn arriving(&self, point: Vec3) -> (Vec3, Vec3) {
        let range = match self.kind {
            LightKind::Directional => return (-self.direction, self.intensity),
            LightKind::Point { range } | LightKind::Spot { range, .. } => range,
        };
        let offset = self.position - point;
        let distance2 = offset.length_squared().max(1e-12);
        let towards = offset / distance2.sqrt();
        let mut strength = 1.0 / distance2;
        if range.is_finite() {
            // The window of KHR_lights_punctual.
            let ratio2 = distance2 / (range * range);
            strength *= (1.0 - ratio2 * ratio2).clamp(0.0, 1.0);
        }
        if let LightKind::Spot { inner_cos, outer_cos, .. } = self.kind {
            let cos = -towards.dot(self.direction);
            let fade = ((cos - outer_cos) / (inner_cos - outer_cos).max(1e-4)).clamp(0.0, 1.0);
            strength *= fade * fade;
        }
        (towards, self.intensity * strength)
    }
}
