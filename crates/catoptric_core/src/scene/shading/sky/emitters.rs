//! Surfaces that emit light.

use glam::Vec3;
use std::f32::consts::PI;

/// A triangle that emits light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Emitter {
    pub(super) triangle: u32,
    pub(super) area: f32,
    pub(super) radiance: Vec3,
    pub(super) is_two_sided: bool,
    /// The power of all triangles up to this one: radiance times area.
    power_so_far: f32,
}

impl Emitter {
    pub(super) fn new(triangle: u32, area: f32, radiance: Vec3, is_two_sided: bool) -> Self {
        Self { triangle, area, radiance, is_two_sided, power_so_far: 0.0 }
    }

    fn power(&self) -> f32 {
        self.radiance.element_sum() * self.area
    }
}

/// A part of an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmitterPoint {
    /// Above its surface.
    pub(super) position: Vec3,
    pub(super) normal: Vec3,
    pub(super) radiance: Vec3,
    pub(super) area: f32,
}

impl EmitterPoint {
    /// The irradiance of a surface of this normal at a position, if it is seen: as of a disc of its area (Wallace,
    /// Elmquist, Haines 1989, section 4), so that near ones do not blind.
    pub(super) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        let step = self.position - position;
        let distance2 = step.length_squared();
        let cosines = (step.dot(normal) * -step.dot(self.normal)).max(0.0);
        let faces = step.dot(normal) > 0.0 && step.dot(self.normal) < 0.0;
        let share = self.area * cosines / (distance2 * (PI * distance2 + self.area)).max(f32::MIN_POSITIVE);
        if faces { self.radiance * (PI * share) } else { Vec3::ZERO }
    }
}

/// The triangles of a scene that emit light, in their order.
#[derive(Debug)]
pub struct Emitters(Vec<Emitter>);

impl Emitters {
    /// The emitters of a list that emit anything; `None` if none does.
    pub(super) fn new(found: impl Iterator<Item = Emitter>) -> Option<Self> {
        let (mut emitters, mut power_so_far) = (Vec::new(), 0.0);
        for emitter in found {
            let power = emitter.power();
            if power > 0.0 && power.is_finite() {
                power_so_far += power;
                emitters.push(Emitter { power_so_far, ..emitter });
            }
        }
        (!emitters.is_empty() && power_so_far.is_finite()).then_some(Self(emitters))
    }

    /// The power of all of them.
    pub(super) fn power(&self) -> f32 {
        self.0.last().map_or(0.0, |last| last.power_so_far)
    }

    /// The triangle that a number between 0 and 1 chooses, by power, and what is left of the number, from 0 to 1 again.
    pub(super) fn chosen(&self, number: f32) -> (&Emitter, f32) {
        let wanted = number * self.power();
        let index = self.0.partition_point(|emitter| emitter.power_so_far <= wanted).min(self.0.len() - 1);
        let emitter = &self.0[index];
        (emitter, (1.0 - (emitter.power_so_far - wanted) / emitter.power()).clamp(0.0, 1.0))
    }

    /// The density of chosen points on a triangle, an area; 0 if it emits nothing.
    pub(super) fn density(&self, triangle: u32) -> f32 {
        let found = self.0.binary_search_by_key(&triangle, |emitter| emitter.triangle);
        found.map_or(0.0, |index| self.0[index].radiance.element_sum() / self.power())
    }
}
