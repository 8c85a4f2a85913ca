//! The bounces of one path of the tree: what pixels are told apart by.

use super::near_plane::NearPlane;
use super::path_model::PathModel;
use super::segment::Segment;
use super::specular_paths::PathTracer;
use crate::light::radiance_field::RadianceField;
use crate::optics::path::bundle::{Bounce, BounceKind};
use crate::optics::step::{LightStep, transmittance};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Role, TurnedEncounter, ViewRays};

impl<F: RadianceField> PathTracer<'_, F> {
    /// The bounces of light that arrives at a position of the picture (in pixels), from the eye on.
    ///
    /// At glass the way through it, if any light takes that, else what it reflects; with the two-path model the one way
    /// that it follows behind the first glass. Rough surfaces count as smooth. Paths end at the highest order, and
    /// where no light goes on.
    pub fn bounces(&mut self, view: &ViewRays, near: &NearPlane, x_px: f32, y_px: f32) -> Vec<Bounce> {
        let start = self.start(view, near, x_px, y_px, 1.0);
        let met = self.met_by(&start);
        self.bounces_of(start, met)
    }

    /// The same of light that arrives along a ray from a surface that it is known to meet.
    pub fn bounces_from(
        &mut self,
        ray: Ray,
        change: Option<RayDifferential>,
        encounter: &SurfaceInteraction,
    ) -> Vec<Bounce> {
        let distance = ray.origin.distance(encounter.point.position);
        let start = self.first(ray, change, 0.0);
        self.bounces_of(start, Some((*encounter, distance)))
    }

    /// The surface that a ray meets first, and how far away it is.
    fn met_by(&mut self, segment: &Segment) -> Option<(SurfaceInteraction, f32)> {
        self.ray_count += 1;
        let hit = self.tracer.first_hit(self.scene, &segment.ray, segment.near)?;
        Some((self.tracer.encounter(self.scene, &segment.ray, &hit, segment.change.as_ref()), hit.distance()))
    }

    fn bounces_of(&mut self, mut segment: Segment, mut met: Option<(SurfaceInteraction, f32)>) -> Vec<Bounce> {
        let mut bounces = Vec::new();
        while let Some((encounter, distance)) = met
            && let Some((bounce, next)) = self.bounce(&segment, &encounter, distance)
        {
            bounces.extend(bounce);
            met = self.met_by(&next);
            segment = next;
        }
        bounces
    }

    /// The bounce at a point of a surface, at this distance, and the ray that goes on from it; no bounce where that
    /// goes straight on, as both sides of the surface are the same. `None`: the path ends.
    fn bounce(
        &mut self,
        segment: &Segment,
        encounter: &SurfaceInteraction,
        distance: f32,
    ) -> Option<(Option<Bounce>, Segment)> {
        let (scene, direction, object) = (self.scene, segment.ray.direction, encounter.point.object);
        let material = scene.material_of(object);
        if !material.role.is_specular() || segment.order >= self.max_order {
            return None;
        }
        let is_lens = material.role == Role::Lens;
        let outside = direction.dot(encounter.point.geometric_normal) <= 0.0;
        let sides = self.sides(segment, &encounter.point, material, outside);
        let throughput = segment.throughput * transmittance(sides.absorption[0], distance);
        if sides.are_same {
            self.pass(segment, throughput, encounter, &sides);
            return self.waiting.pop().map(|next| (None, next));
        }
        let TurnedEncounter { encounter: turned, .. } = &scene.turned_encounter(material, encounter);
        let step = LightStep::at(scene, material, &turned.point, direction);
        let tint = || scene.base_color(material, &turned.point).truncate();
        let step = step.within(sides.eta_factor, material, tint, direction);
        let (mut reflects, mut refracts) = (true, is_lens && step.reflectance < 1.0);
        if is_lens && self.model == PathModel::TwoPath && segment.split {
            reflects = step.prefers_reflection();
            refracts &= !reflects;
        }
        let absorption = sides.absorption[0];
        let segment = Segment { absorption, deferred: None, split: segment.split || is_lens, ..*segment };
        for (kind, is_way) in [(BounceKind::Transmit, refracts), (BounceKind::Reflect, reflects)] {
            if is_way {
                self.push(&segment, kind, throughput, turned, &step, &sides);
            }
            if let Some(next) = self.waiting.pop() {
                return Some((Some(Bounce { object, kind }), next));
            }
        }
        None
    }
}
