//! Specular paths, from the eye to the diffuse surfaces that they end on.

mod bounces;
mod lobes;
mod rough;
mod waves;

use super::bodies::Bodies;
use super::radiance_field::{RadianceField, SceneBackground};
use super::sides::Sides;
use super::tracer::Tracer;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{Deferred, LightStep, transmittance};
use catoptric_core::parallel;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::{SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Material, Ray, RayDifferential, Role, Scene, TurnedEncounter, View, ViewRays};
use glam::Vec3;
pub use lobes::{LOBES, LobeLight, SharedLight, SharedRays};
use rough::RoughRays;
use waves::Waves;
pub use waves::{Cone, SeenSurface};

/// Paths that carry less than this share of the light are ended. Chosen far below a step of eight bits, not measured.
pub const MIN_THROUGHPUT: f32 = 1e-5;

/// Surfaces that a path passes straight on, at most.
const MOST_PASSAGES: u8 = 64;

/// A lobe that can add no more than this share of the light before it is not followed: half a step of eight bits at
/// half of the brightest.
const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// Paths at refracting surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathModel {
    /// Both children at every surface.
    #[default]
    Tree,
    /// Both children at the first, then the one with the larger Fresnel coefficient (Hakura, Snyder 2001, section 3).
    TwoPath,
}

/// A ray that waits to be traced.
#[derive(Clone, Copy)]
struct Segment {
    ray: Ray,
    change: Option<RayDifferential>,
    near: f32,
    throughput: Vec3,
    /// Specular events so far.
    order: u32,
    /// Absorption of the medium that it crosses.
    absorption: Vec3,
    /// The bodies that it is in, where that matters: some meet, or the path began within one.
    bodies: Bodies,
    /// The two-path model has split already.
    split: bool,
    /// The ray is one of several that left a rough mirror: it stands for a cone.
    is_cone: bool,
    /// The light from infinity that was counted where it started, and is taken away if it meets something; `None`: it
    /// brings that light itself.
    counted: Option<Vec3>,
    /// The density of rays like it, a solid angle, where others seek emitters from where it started; 0: none do.
    density: f32,
    /// The primary colour of its light, 0 to 2, if it has only one.
    color: Option<u8>,
    /// Surfaces that it has passed straight on.
    passages: u8,
    /// Light of the mirror that it left, whose share depends on the ray's length.
    deferred: Option<Deferred>,
}

impl Segment {
    /// A path's first ray, to surfaces at a distance of at least `near`.
    #[inline(always)]
    fn first(ray: Ray, change: Option<RayDifferential>, near: f32) -> Self {
        Self {
            ray,
            change,
            near,
            throughput: Vec3::ONE,
            order: 0,
            absorption: Vec3::ZERO,
            bodies: Bodies::default(),
            split: false,
            is_cone: false,
            counted: None,
            density: 0.0,
            color: None,
            passages: 0,
            deferred: None,
        }
    }
}

impl Segment {
    /// The same on the side where light goes on by an event.
    #[inline(always)]
    fn after(&self, kind: BounceKind, sides: &Sides) -> Self {
        match kind {
            BounceKind::Reflect => Self { absorption: sides.absorption[0], ..*self },
            BounceKind::Transmit => Self { absorption: sides.absorption[1], bodies: sides.behind, ..*self },
        }
    }
}

/// Follows specular paths; one a thread.
pub struct PathTracer<'a, F = SceneBackground> {
    scene: &'a Scene,
    field: F,
    tracer: &'a Tracer,
    model: PathModel,
    max_order: u32,
    waiting: Vec<Segment>,
    waves: Waves,
    ray_count: u64,
    ended_count: u64,
    rough: RoughRays,
    /// The light over lobes of the surface that is met next, where it is known.
    known: [Option<LobeLight>; LOBES],
    /// Where the last path began, and the bodies there.
    start: (Vec3, Bodies),
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
    fn first(&mut self, ray: Ray, change: Option<RayDifferential>, near: f32) -> Segment {
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
    fn note_end(&mut self, throughput: Vec3) {
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
    fn start(&mut self, view: &ViewRays, near: &NearPlane, x_px: f32, y_px: f32, footprint_scale: f32) -> Segment {
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
    fn arrive(&mut self, segment: &Segment, throughput: Vec3, hit: Option<&Hit>) -> Vec3 {
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
    fn meet(&mut self, segment: &Segment, throughput: Vec3, encounter: &SurfaceInteraction, distance: f32) -> Vec3 {
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
    fn sides(&self, segment: &Segment, point: &SurfacePoint, material: &Material, outside: bool) -> Sides {
        let matters = self.tracer.bodies().meet() || segment.bodies != Bodies::default();
        if material.has_inside() && matters && self.tracer.bodies().of(point.object).is_some() {
            return self.tracer.sides(self.scene, &segment.ray, &segment.bodies, point);
        }
        let behind = if material.has_inside() { Bodies::default() } else { segment.bodies };
        Sides { behind, ..Sides::alone(material, outside, segment.absorption) }
    }

    /// Goes straight on through a surface.
    fn pass(&mut self, segment: &Segment, throughput: Vec3, encounter: &SurfaceInteraction, sides: &Sides) {
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
    fn push(
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

/// The near plane of a view.
pub struct NearPlane {
    depth: f32,
    forward: Vec3,
}

impl NearPlane {
    /// The near plane of `view`.
    pub fn new(view: &View) -> Self {
        Self { depth: view.near, forward: -Vec3::from(view.world_from_view.matrix3.z_axis) }
    }

    /// The distance along a view ray where the plane is.
    #[inline]
    pub fn distance(&self, ray: &Ray) -> f32 {
        self.depth / ray.direction.dot(self.forward).max(1e-6)
    }
}

/// For every pixel whether the first surface at its centre is a reflector or lens; rows from the top.
pub fn specular_mask(scene: &Scene, view: &View) -> Vec<bool> {
    mask(scene, view, |object| scene.role_of(object).is_specular())
}

/// For every pixel whether there is a surface at its centre; rows from the top.
pub fn surface_mask(scene: &Scene, view: &View) -> Vec<bool> {
    mask(scene, view, |_| true)
}

fn mask(scene: &Scene, view: &View, is_wanted: impl Fn(u32) -> bool + Sync) -> Vec<bool> {
    let tracer = Tracer::build(scene, |_| true);
    let (rays, near) = (view.rays(), NearPlane::new(view));
    let mut mask = vec![false; view.width as usize * view.height as usize];
    parallel::for_each_chunk_mut(&mut mask, view.width as usize, |y, row| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let ray = rays.ray(x as f32 + 0.5, y as f32 + 0.5);
            let hit = tracer.first_hit(scene, &ray, near.distance(&ray));
            *pixel = hit.is_some_and(|hit| {
                let encounter = tracer.encounter(scene, &ray, &hit, None);
                is_wanted(encounter.point.object)
            });
        }
    });
    mask
}
