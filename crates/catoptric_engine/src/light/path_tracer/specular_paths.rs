//! The tracer of specular paths: ray by ray, from the eye on.

use super::lobe_light::{LOBES, LobeLight};
use super::near_plane::NearPlane;
use super::path_model::{LEAST_SHARE, MIN_THROUGHPUT, MOST_PASSAGES, PathModel, RoughRays};
use super::segment::{Segment, Waves};
use crate::light::bodies::Bodies;
use crate::light::radiance_field::{RadianceField, SceneBackground};
use crate::light::sides::Sides;
use crate::light::tracer::Tracer;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{LightStep, transmittance};
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::{SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Material, Ray, RayDifferential, Role, Scene, TurnedEncounter, ViewRays};
use glam::Vec3;

/// Follows specular paths; one a thread.
pub struct PathTracer<'a, F = SceneBackground> {
    pub(super) scene: &'a Scene,
    pub(super) field: F,
    pub(super) tracer: &'a Tracer,
    pub(super) model: PathModel,
    pub(super) max_order: u32,
    pub(super) waiting: Vec<Segment>,
    pub(super) waves: Waves,
    pub(super) ray_count: u64,
    pub(super) ended_count: u64,
    pub(super) rough: RoughRays,
    /// The light over lobes of the surface that is met next, where it is known.
    pub(super) known: [Option<LobeLight>; LOBES],
    /// Where the last path began, and the bodies there.
    pub(super) start: (Vec3, Bodies),
}

impl<'a> PathTracer<'a> {
    /// A tracer of paths with at most `max_order` specular events.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, model: PathModel, max_order: u32) -> Self {
        Self::with_field(scene, tracer, model, max_order, SceneBackground)
    }
}

impl<'a, F: RadianceField> PathTracer<'a, F> {
    /// A tracer of paths with at most `max_order` specular events, in a radiance field of rays that meet nothing.
    pub fn with_field(scene: &'a Scene, tracer: &'a Tracer, model: PathModel, max_order: u32, field: F) -> Self {
        Self {
            scene,
            field,
            tracer,
            model,
            max_order,
            waiting: Vec::new(),
            waves: Waves::default(),
            ray_count: 0,
            ended_count: 0,
            rough: RoughRays::default(),
            known: [None; LOBES],
            start: (Vec3::NAN, Bodies::default()),
        }
    }

    /// A path's first ray, to surfaces at a distance of at least `near`.
    #[inline(always)]
    pub(super) fn first(&mut self, ray: Ray, change: Option<RayDifferential>, near: f32) -> Segment {
        if self.start.0 != ray.origin {
            self.start = (ray.origin, self.tracer.bodies_at(self.scene, ray.origin));
        }
        let bodies = self.start.1;
        let filling = self.tracer.bodies().filling(&bodies);
        let absorption = filling.map_or(Vec3::ZERO, |body| self.scene.material_of(body).absorption);
        Segment { bodies, absorption, ..Segment::first(ray, change, near) }
    }

    /// The number of rays traced since the last call.
    pub fn take_ray_count(&mut self) -> u64 {
        std::mem::take(&mut self.ray_count)
    }

    /// The number of paths since the last call that ended at the highest order while they carried light that is seen.
    pub fn take_ended_count(&mut self) -> u64 {
        std::mem::take(&mut self.ended_count)
    }

    /// Counts a path that ends at the highest order, by the share of light that it carries.
    #[inline(always)]
    pub(super) fn note_end(&mut self, throughput: Vec3) {
        self.ended_count += u64::from(throughput.max_element() > LEAST_SHARE);
    }

    /// The radiance that arrives at a position of the picture (in pixels).
    ///
    /// Texture footprints are those of a pixel, times `footprint_scale`.
    #[inline(always)]
    pub fn radiance(&mut self, view: &ViewRays, near: &NearPlane, x_px: f32, y_px: f32, footprint_scale: f32) -> Vec3 {
        let start = self.start(view, near, x_px, y_px, footprint_scale);
        self.waiting.push(start);
        self.with_rest(Vec3::ZERO)
    }

    /// The first ray of the path to a position of the picture.
    #[inline(always)]
    pub(super) fn start(
        &mut self,
        view: &ViewRays,
        near: &NearPlane,
        x_px: f32,
        y_px: f32,
        footprint_scale: f32,
    ) -> Segment {
        let (ray, change) = if self.tracer.needs_differentials() {
            let (ray, change) = view.ray_with_differential(x_px, y_px);
            (ray, Some(change.scaled(footprint_scale)))
        } else {
            (view.ray(x_px, y_px), None)
        };
        self.first(ray, change, near.distance(&ray))
    }

    /// The radiance that arrives along a ray from surfaces at a distance of at least `near`.
    #[inline(always)]
    pub fn radiance_along(&mut self, ray: Ray, change: Option<RayDifferential>, near: f32) -> Vec3 {
        let start = self.first(ray, change, near);
        self.waiting.push(start);
        self.with_rest(Vec3::ZERO)
    }

    /// The radiance that arrives along a ray, and how far away what it meets first is: infinitely where that is
    /// nothing.
    pub fn radiance_and_distance(&mut self, ray: Ray, change: Option<RayDifferential>) -> (Vec3, f32) {
        let start = self.first(ray, change, 0.0);
        self.ray_count += 1;
        let hit = self.tracer.first_hit(self.scene, &ray, 0.0);
        let first = self.arrive(&start, start.throughput, hit.as_ref());
        (self.with_rest(first), hit.as_ref().map_or(f32::INFINITY, Hit::distance))
    }

    /// The radiance that arrives along a ray from a surface that it is known to meet, whatever lies before that: the
    /// ray begins within no body.
    pub fn radiance_from(&mut self, ray: Ray, change: Option<RayDifferential>, encounter: &SurfaceInteraction) -> Vec3 {
        let start = Segment::first(ray, change, 0.0);
        self.radiance_of(&start, encounter)
    }

    fn radiance_of(&mut self, start: &Segment, encounter: &SurfaceInteraction) -> Vec3 {
        let distance = start.ray.origin.distance(encounter.point.position);
        let first = self.meet(start, start.throughput, encounter, distance);
        self.with_rest(first)
    }

    /// The ray that goes on from the first surface along a ray, the refracted one of two, and its change.
    #[doc(hidden)]
    pub fn child(&mut self, ray: Ray, change: RayDifferential) -> Option<(Ray, RayDifferential)> {
        self.follow(&Segment::first(ray, Some(change), 0.0));
        // The refracted child, where there is one, was pushed first.
        let child = self.waiting.first().copied();
        self.waiting.clear();
        child.and_then(|child| Some((child.ray, child.change?)))
    }

    /// The sum of light that has arrived and of all that waits.
    #[inline(always)]
    fn with_rest(&mut self, mut sum: Vec3) -> Vec3 {
        while let Some(segment) = self.waiting.pop() {
            sum += self.follow(&segment);
        }
        // A sum of finite terms can still overflow; what hides light from infinity may take away more than there was.
        if sum.is_finite() { sum.max(Vec3::ZERO) } else { Vec3::ZERO }
    }

    /// Traces one ray: the light that ends the path here; children wait.
    #[inline(always)]
    fn follow(&mut self, segment: &Segment) -> Vec3 {
        self.ray_count += 1;
        let (scene, ray) = (self.scene, &segment.ray);
        let hit = self.tracer.first_hit(scene, ray, segment.near);
        if let Some(deferred) = &segment.deferred {
            let (own, weight) = deferred.settled(hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance()));
            return own + self.arrive(segment, segment.throughput * weight, hit.as_ref());
        }
        self.arrive(segment, segment.throughput, hit.as_ref())
    }

    /// Goes on at what a ray meets.
    #[inline(always)]
    pub(super) fn arrive(&mut self, segment: &Segment, throughput: Vec3, hit: Option<&Hit>) -> Vec3 {
        let (scene, ray) = (self.scene, &segment.ray);
        let Some(hit) = hit else {
            return match &segment.change {
                _ if segment.counted.is_some() => Vec3::ZERO,
                Some(change) if segment.is_cone => throughput * self.field.radiance_of_cone(scene, ray, change),
                change => throughput * self.field.radiance(scene, ray, change.as_ref()),
            };
        };
        let encounter = self.tracer.encounter(scene, ray, hit, segment.change.as_ref());
        let elsewhere = self.counted_by_others(segment, throughput, hit);
        self.meet(segment, throughput, &encounter, hit.distance()) - segment.counted.unwrap_or_default() - elsewhere
    }

    /// Goes on at a point of a surface, which a ray meets at a distance.
    #[inline(always)]
    pub(super) fn meet(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        distance: f32,
    ) -> Vec3 {
        let (scene, ray) = (self.scene, &segment.ray);
        let material = scene.material_of(encounter.point.object);
        let outside = ray.direction.dot(encounter.point.geometric_normal) <= 0.0;
        let sides = self.sides(segment, &encounter.point, material, outside);
        let throughput = throughput * transmittance(sides.absorption[0], distance);
        if sides.are_same {
            self.pass(segment, throughput, encounter, &sides);
            return Vec3::ZERO;
        }
        if let Some(lobes) = material.lobes() {
            return self.spread(segment, throughput, &sides, encounter, (material, lobes));
        }
        match material.role {
            Role::Diffuse => throughput * scene.radiance(&encounter.point, -ray.direction),
            _ => self.scatter(segment, throughput, &sides, encounter, material),
        }
    }

    /// Both sides of a surface that a path meets.
    #[inline(always)]
    pub(super) fn sides(&self, segment: &Segment, point: &SurfacePoint, material: &Material, outside: bool) -> Sides {
        let matters = self.tracer.bodies().meet() || segment.bodies != Bodies::default();
        if material.has_inside() && matters && self.tracer.bodies().of(point.object).is_some() {
            return self.tracer.sides(self.scene, &segment.ray, &segment.bodies, point);
        }
        let behind = if material.has_inside() { Bodies::default() } else { segment.bodies };
        Sides { behind, ..Sides::alone(material, outside, segment.absorption) }
    }

    /// Goes straight on through a surface.
    pub(super) fn pass(&mut self, segment: &Segment, throughput: Vec3, encounter: &SurfaceInteraction, sides: &Sides) {
        if segment.passages >= MOST_PASSAGES || throughput.max_element() < MIN_THROUGHPUT {
            return;
        }
        let direction = segment.ray.direction;
        let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
        let [origin_dx, origin_dy] = encounter.position_change;
        let change = segment.change.map(|change| RayDifferential { origin_dx, origin_dy, ..change });
        self.waiting.push(Segment {
            ray,
            change,
            near: 0.0,
            throughput,
            bodies: sides.behind,
            absorption: sides.absorption[1],
            passages: segment.passages + 1,
            // Light that was counted where the ray began has been taken away where it met this surface.
            counted: None,
            density: 0.0,
            deferred: None,
            ..*segment
        });
    }

    /// Goes on at a reflector or lens.
    fn scatter(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        sides: &Sides,
        encounter: &SurfaceInteraction,
        material: &Material,
    ) -> Vec3 {
        let (scene, direction, point) = (self.scene, segment.ray.direction, &encounter.point);
        let last = segment.order >= self.max_order;
        if last {
            self.note_end(throughput);
        }
        if last && !material.has_own_light() && !scene.ends_in_environment {
            return Vec3::ZERO;
        }
        let TurnedEncounter { encounter: turned, variance } = &scene.turned_encounter(material, encounter);
        let step = LightStep::at(scene, material, &turned.point, direction);
        let step = step.within(sides.eta_factor, material, || scene.base_color(material, point).truncate(), direction);
        let (mut reflects, mut refracts) = (!last, !last && material.role == Role::Lens && step.reflectance < 1.0);
        let absorption = sides.absorption[0];
        let mut segment = Segment { absorption, deferred: None, counted: None, density: 0.0, ..*segment };
        if material.role == Role::Lens {
            if self.model == PathModel::TwoPath && segment.split {
                reflects = step.prefers_reflection();
                refracts &= !reflects;
            }
            segment.split = true;
        }
        // The light that the surface scatters itself.
        let own = |share: f32| match share {
            0.0 => Vec3::ZERO,
            share => throughput * share * scene.own_radiance(point, -direction),
        };
        let is_deferred = reflects && step.attenuation.is_some();
        if is_deferred {
            segment.deferred = step.deferred(own(1.0));
        }
        let kinds = [(BounceKind::Transmit, refracts), (BounceKind::Reflect, reflects)];
        let kinds = kinds.into_iter().filter_map(|(kind, is_way)| is_way.then_some(kind));
        let alpha = if reflects || refracts { material.facets_alpha(*variance) } else { 0.0 };
        if reflects && material.reflection_roughness() > 0.0 {
            self.push_rough(&segment, throughput, turned, &step, material, alpha);
        } else if alpha > 0.0 && self.shows_lobe(&segment, alpha, encounter, &step) {
            self.push_parts(&segment, throughput, encounter, (material, sides), kinds);
        } else {
            for kind in kinds {
                self.push(&segment, kind, throughput, turned, &step, sides);
            }
        }
        let mut sum = throughput * scene.highlights(point, -direction);
        if last && scene.ends_in_environment {
            sum += throughput * step.background(scene, direction, material.facets_alpha(*variance));
        }
        if is_deferred { sum } else { sum + own(step.scattered) }
    }

    /// Adds the child of a path by an event.
    pub(super) fn push(
        &mut self,
        segment: &Segment,
        kind: BounceKind,
        throughput: Vec3,
        encounter: &SurfaceInteraction,
        step: &LightStep,
        sides: &Sides,
    ) {
        let (incoming, throughput) = (segment.ray.direction, throughput * step.weight(kind));
        let counts = throughput.max_element() >= MIN_THROUGHPUT || segment.deferred.is_some();
        if !counts {
            return;
        }
        let Some(direction) = step.outgoing(kind, incoming) else { return };
        let change = segment.change.as_ref().map(|change| step.outgoing_change(kind, incoming, change, encounter));
        let ray = Ray { origin: self.tracer.departure(&encounter.point, direction), direction };
        let order = segment.order + 1;
        self.waiting.push(Segment { ray, change, near: 0.0, throughput, order, ..segment.after(kind, sides) });
    }
}
