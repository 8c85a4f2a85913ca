//! Surfaces that emit light, sought by rays of their own beside those of lobes.

use super::super::rough::turn;
use super::super::segment::Segment;
use super::super::specular_paths::PathTracer;
use super::lobe::Lobe;
use crate::light::radiance_field::RadianceField;
use crate::optics::step::transmittance;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::{Barycentrics, SurfaceInteraction};
use catoptric_core::scene::{Emitters, Ray, Sky};
use glam::Vec3;

/// Rays to emitters from each place that a path meets.
const RAYS: u32 = 2;

/// The numbers that choose points of emitters.
const POINTS: u64 = 0x9e6c_63d0_876a_3f6b;

impl<F: RadianceField> PathTracer<'_, F> {
    /// The scene's surfaces that emit light, if it has any.
    pub(super) fn emitters(&self) -> Option<&Emitters> {
        self.scene.sky.as_deref().and_then(Sky::emitters)
    }

    /// The light of emitters over a lobe of which so many rays follow parts, as far as those leave it out (the balance
    /// heuristic of Veach, Guibas 1995).
    pub(super) fn of_emitters(
        &self,
        segment: &Segment,
        encounter: &SurfaceInteraction,
        lobe: &Lobe<'_>,
        count: f32,
    ) -> Vec3 {
        let Some(emitters) = self.emitters() else { return Vec3::ZERO };
        let (incoming, position) = (segment.ray.direction, encounter.point.position);
        let mut sum = Vec3::ZERO;
        for index in 0..RAYS {
            let number = turn(self.rough.seed ^ POINTS ^ u64::from(index), incoming, position);
            let towards = self.scene.point_of(emitters, number) - position;
            let Some(direction) = towards.try_normalize() else { continue };
            let Some(facet) = lobe.facet_towards(incoming, direction) else { continue };
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            let Some(hit) = self.tracer.first_hit(self.scene, &ray, 0.0) else { continue };
            let to_emitters = RAYS as f32 * self.density_to_emitters(&hit, direction);
            let of_lobe = lobe.density(incoming, facet);
            let share = of_lobe / (count * of_lobe + to_emitters);
            if to_emitters > 0.0 && share > 0.0 && share.is_finite() {
                let weight = lobe.weight(-incoming.dot(facet)) * lobe.unshadowed_share(incoming, direction);
                let arriving = self.emitted_at(&hit) * transmittance(segment.absorption, hit.distance());
                sum += weight * arriving * share;
            }
        }
        sum
    }

    /// The light of an emitter that a ray meets, as far as others that seek emitters bring it.
    pub(in super::super) fn counted_by_others(&self, segment: &Segment, throughput: Vec3, hit: &Hit) -> Vec3 {
        if segment.density <= 0.0 || !self.scene.material_of(hit.object(self.scene)).emits_light() {
            return Vec3::ZERO;
        }
        let to_emitters = RAYS as f32 * self.density_to_emitters(hit, segment.ray.direction);
        let share = to_emitters / (to_emitters + segment.density);
        throughput * self.emitted_at(hit) * transmittance(segment.absorption, hit.distance()) * share
    }

    /// The density of rays to emitters, a solid angle, in the direction of one.
    fn density_to_emitters(&self, hit: &Hit, direction: Vec3) -> f32 {
        match (self.emitters(), hit) {
            (Some(emitters), Hit::Triangle { triangle, distance, .. }) => {
                self.scene.density_of(emitters, *triangle, direction) * distance * distance
            }
            _ => 0.0,
        }
    }

    fn emitted_at(&self, hit: &Hit) -> Vec3 {
        match hit {
            Hit::Triangle { triangle, barycentrics, .. } => {
                let at = Barycentrics { value: *barycentrics, ..Barycentrics::default() };
                self.scene.emitted_radiance(&self.scene.surface_point(*triangle, &at))
            }
            _ => Vec3::ZERO,
        }
    }
}
