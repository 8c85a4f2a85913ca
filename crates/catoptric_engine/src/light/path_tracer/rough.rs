//! Rays that leave rough mirrors: by facets that are seen, as the distribution of Trowbridge and Reitz has them.

use super::path_model::{MIN_THROUGHPUT, RoughRays};
use super::segment::Segment;
use super::specular_paths::PathTracer;
use crate::light::bumps::{BumpyMeeting, LeavingPart};
use crate::light::radiance_field::RadianceField;
use crate::light::sides::Sides;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{HIDDEN_LOBE, LightStep, lobe_width, reflect};
use catoptric_core::math::random;
use catoptric_core::scene::microfacets::{extent_of_sample, unshadowed_share, visible_facet};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Material, Ray, RayDifferential};
use glam::{Vec2, Vec3};

impl<F> PathTracer<'_, F> {
    /// The same with so many rays where a path first meets a rough mirror, chosen by numbers of this seed, for paths
    /// that stand for a pixel's part of this side.
    #[must_use]
    pub fn with_rough_rays(self, count: u32, seed: u64, footprint_scale: f32) -> Self {
        Self { rough: RoughRays { count: count.max(1), seed, footprint_scale, ..self.rough }, ..self }
    }

    /// Has so many rays leave where each of the next paths first meets a rough mirror; so many paths of a pixel follow
    /// each other.
    pub fn set_rough_rays(&mut self, count: u32, parts: u32) {
        self.rough = RoughRays { count: count.max(1), part: 0, parts: parts.max(1), ..self.rough };
    }

    /// The same for so many paths of a pixel, one after the other.
    #[must_use]
    pub fn with_parts(self, parts: u32) -> Self {
        Self { rough: RoughRays { part: 0, parts: parts.max(1), ..self.rough }, ..self }
    }
}

impl<F: RadianceField> PathTracer<'_, F> {
    /// True if facets of a mirror spread light over more than the cone that a path stands for; `encounter` is the one
    /// before the mirror's map turns the normal: what bumps do from path to path says nothing of it.
    pub(super) fn shows_lobe(
        &self,
        segment: &Segment,
        alpha: f32,
        encounter: &SurfaceInteraction,
        step: &LightStep,
    ) -> bool {
        let Some(change) = &segment.change else { return false };
        let change = step.outgoing_change(BounceKind::Reflect, segment.ray.direction, change, encounter);
        lobe_width(alpha) > HIDDEN_LOBE * change.solid_angle().sqrt()
    }

    /// Adds the children of a path, by events of these kinds, at a smooth mirror or lens whose bumps are smaller than
    /// the path's footprint: each of a part of it. `encounter` is that before its map turns the normal.
    pub(super) fn push_parts(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        (material, sides): (&Material, &Sides),
        kinds: impl Iterator<Item = BounceKind> + Clone,
    ) {
        let Some(change) = &segment.change else { return };
        let RoughRays { count, seed, .. } = self.rough;
        let count = if segment.is_cone { 1 } else { count };
        let turns = [0, 1].map(|pair| turn(seed ^ pair << 32, segment.ray.direction, encounter.point.position));
        let (scene, tracer) = (self.scene, self.tracer);
        let meeting = BumpyMeeting { scene, tracer, ray: &segment.ray, change, encounter };
        meeting.for_each_part(material, count, turns, |part| {
            for kind in kinds.clone() {
                let Some(LeavingPart { ray, change, weight }) = part.leaving(kind) else { continue };
                self.push_cone(&segment.after(kind, sides), ray, Some(change), throughput * weight, count);
            }
        });
    }

    /// Adds one of so many children of a path, if it carries enough light.
    pub(super) fn push_cone(
        &mut self,
        segment: &Segment,
        ray: Ray,
        change: Option<RayDifferential>,
        throughput: Vec3,
        count: u32,
    ) {
        let throughput = throughput / count as f32;
        let is_faint = throughput.max_element() < MIN_THROUGHPUT;
        let takes_away = segment.counted.is_some_and(|light| light.max_element() >= MIN_THROUGHPUT);
        if is_faint && segment.deferred.is_none() && !takes_away {
            return;
        }
        let (order, deferred) = (segment.order + 1, segment.deferred.map(|deferred| deferred.shared_by(count)));
        self.waiting.push(Segment { ray, change, near: 0.0, throughput, order, is_cone: true, deferred, ..*segment });
    }

    /// Adds the children of a path that a mirror of such facets reflects.
    ///
    /// The same path always has the same children: they are chosen by numbers that its direction makes.
    pub(super) fn push_rough(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        step: &LightStep,
        material: &Material,
        alpha: f32,
    ) {
        let (incoming, normal) = (segment.ray.direction, step.facing.normal);
        let RoughRays { count, seed, footprint_scale, .. } = self.rough;
        let count = if segment.is_cone { 1 } else { count };
        let (across, along) = normal.any_orthonormal_pair();
        let towards_viewer = -Vec3::new(incoming.dot(across), incoming.dot(along), incoming.dot(normal));
        let turn = turn(seed, incoming, encounter.point.position);
        for index in 0..count {
            let number = (random::hammersley(index, count) + turn).fract();
            let facet = visible_facet(alpha, towards_viewer, number);
            let facet = across * facet.x + along * facet.y + normal * facet.z;
            let direction = reflect(incoming, facet);
            let share = unshadowed_share(alpha, direction.dot(normal), towards_viewer.z);
            // Light that goes on below the surface would meet another facet: it is lost, as masking has it.
            if share <= 0.0 || direction.dot(step.facing.geometric) <= 0.0 {
                continue;
            }
            let reflected = LightStep::reflected_by_facet(material, step.reflected, normal, facet, incoming);
            // A ray of several stands for so much of the lobe as there is to each of them.
            let width = extent_of_sample(alpha, facet.dot(normal), towards_viewer.z, self.rough.count).sqrt();
            let change = segment.change.as_ref().map(|change| {
                let step = step.at_facet(facet);
                step.outgoing_change(BounceKind::Reflect, incoming, change, encounter)
                    .widened(direction, width * footprint_scale)
            });
            let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
            self.push_cone(segment, ray, change, throughput * reflected * share, count);
        }
    }
}

/// How far a path's numbers are moved: by its direction and where it is.
pub(super) fn turn(seed: u64, incoming: Vec3, at: Vec3) -> Vec2 {
    let bits = |a: f32, b: f32| u64::from(a.to_bits()) << 32 | u64::from(b.to_bits());
    let key = [bits(incoming.x, incoming.y), bits(incoming.z, at.x), bits(at.y, at.z)];
    let turn = |axis: u64| random::unit(seed ^ axis, random::mix(key[0] ^ random::mix(key[1])), key[2]);
    Vec2::new(turn(0), turn(1))
}
