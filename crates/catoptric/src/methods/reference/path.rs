//! Specular paths, from the eye to the diffuse surfaces that they end on.

use super::PathModel;
use crate::optics::{Deferred, Facing, Interface, reflected_change, refracted_change, transmittance};
use crate::scene::shade::{Encounter, SurfacePoint};
use crate::scene::{Material, Ray, RayDifferential, Role, Scene, View, ViewRays};
use crate::surface::tracer::{Hit, Tracer};
use glam::Vec3;

/// Paths that carry less than this share of the light are ended.
pub(crate) const LEAST_THROUGHPUT: f32 = 1e-5;

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
    /// The two-path model has split already.
    split: bool,
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
            split: false,
            deferred: None,
        }
    }
}

/// What rays see that meet nothing.
pub trait Beyond {
    /// The radiance along a ray of a scene; `change` is the ray's a pixel, where it is known.
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3;
}

/// The scene's light from infinity.
#[derive(Clone, Copy, Debug, Default)]
pub struct Background;

impl Beyond for Background {
    #[inline(always)]
    fn radiance(&self, scene: &Scene, ray: &Ray, _change: Option<&RayDifferential>) -> Vec3 {
        scene.background(ray.direction)
    }
}

/// Follows specular paths; one a thread.
pub struct PathTracer<'a, B = Background> {
    scene: &'a Scene,
    beyond: B,
    tracer: &'a Tracer,
    model: PathModel,
    max_order: u32,
    waiting: Vec<Segment>,
    ray_count: u64,
}

impl<'a> PathTracer<'a> {
    /// A tracer of paths with at most `max_order` specular events.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, model: PathModel, max_order: u32) -> Self {
        Self::with_beyond(scene, tracer, model, max_order, Background)
    }
}

impl<'a, B: Beyond> PathTracer<'a, B> {
    /// A tracer of paths with at most `max_order` specular events whose rays, where they meet nothing, see something else
    /// than the scene's background.
    pub fn with_beyond(scene: &'a Scene, tracer: &'a Tracer, model: PathModel, max_order: u32, beyond: B) -> Self {
        Self { scene, beyond, tracer, model, max_order, waiting: Vec::new(), ray_count: 0 }
    }

    /// The number of rays traced since the last call.
    pub fn take_ray_count(&mut self) -> u64 {
        std::mem::take(&mut self.ray_count)
    }

    /// The radiance that arrives at a position of the picture (in pixels).
    ///
    /// Texture footprints are those of a pixel, times `footprint_scale`.
    #[inline(always)]
    pub fn radiance(&mut self, view: &ViewRays, near: &NearPlane, x_px: f32, y_px: f32, footprint_scale: f32) -> Vec3 {
        let (ray, change) = if self.tracer.needs_differentials() {
            let (ray, change) = view.ray_with_differential(x_px, y_px);
            (ray, Some(change.scaled(footprint_scale)))
        } else {
            (view.ray(x_px, y_px), None)
        };
        self.radiance_along(ray, change, near.distance(&ray))
    }

    /// The radiance that arrives along a ray from surfaces at a distance of at least `near`.
    #[inline(always)]
    pub fn radiance_along(&mut self, ray: Ray, change: Option<RayDifferential>, near: f32) -> Vec3 {
        self.waiting.push(Segment::first(ray, change, near));
        self.with_rest(Vec3::ZERO)
    }

    /// The radiance that arrives along a ray, and how far away what it meets first is: infinitely where that is nothing.
    pub fn radiance_and_distance(&mut self, ray: Ray, change: Option<RayDifferential>) -> (Vec3, f32) {
        let start = Segment::first(ray, change, 0.0);
        self.ray_count += 1;
        let hit = self.tracer.first_hit(self.scene, &ray, 0.0);
        let first = self.arrive(&start, start.throughput, hit.as_ref());
        (self.with_rest(first), hit.as_ref().map_or(f32::INFINITY, Hit::distance))
    }

    /// The radiance that arrives along a ray from a surface that it is known to meet.
    pub fn radiance_from(&mut self, ray: Ray, change: Option<RayDifferential>, encounter: &Encounter) -> Vec3 {
        let start = Segment::first(ray, change, 0.0);
        let first = self.meet(&start, start.throughput, encounter, ray.origin.distance(encounter.point.position));
        self.with_rest(first)
    }

    /// The sum of light that has arrived and of all that waits.
    #[inline(always)]
    fn with_rest(&mut self, mut sum: Vec3) -> Vec3 {
        while let Some(segment) = self.waiting.pop() {
            sum += self.follow(&segment);
        }
        // A sum of finite terms can still overflow.
        if sum.is_finite() { sum } else { Vec3::ZERO }
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
        let Some(hit) = hit else { return throughput * self.beyond.radiance(scene, ray, segment.change.as_ref()) };
        let encounter = self.tracer.encounter(scene, ray, hit, segment.change.as_ref());
        self.meet(segment, throughput, &encounter, hit.distance())
    }

    /// Goes on at a point of a surface, which a ray meets at a distance.
    #[inline(always)]
    fn meet(&mut self, segment: &Segment, throughput: Vec3, encounter: &Encounter, distance: f32) -> Vec3 {
        let (scene, ray) = (self.scene, &segment.ray);
        let material = scene.material_of(encounter.point.object);
        // Whoever meets a lens from inside was inside it, also when the eye is there or another lens lies within.
        let inside = material.role == Role::Lens && ray.direction.dot(encounter.point.geometric_normal) > 0.0;
        let absorption = if inside { material.absorption } else { segment.absorption };
        let throughput = throughput * transmittance(absorption, distance);
        match material.role {
            Role::Diffuse => throughput * scene.radiance(&encounter.point, -ray.direction),
            _ => self.scatter(segment, throughput, encounter, material),
        }
    }

    /// Goes on at a reflector or lens.
    fn scatter(&mut self, segment: &Segment, throughput: Vec3, encounter: &Encounter, material: &Material) -> Vec3 {
        let (scene, direction, point) = (self.scene, segment.ray.direction, &encounter.point);
        let last = segment.order >= self.max_order;
        if last && material.role != Role::Coated && material.blend.is_none() {
            return Vec3::ZERO;
        }
        let interface = Interface::of(scene, material, point, direction);
        let (mut reflects, mut refracts) = (!last, material.role == Role::Lens && interface.reflectance < 1.0);
        let mut segment = Segment { deferred: None, ..*segment };
        if material.role == Role::Lens {
            if self.model == PathModel::TwoPath && segment.split {
                reflects = interface.prefers_reflection();
                refracts &= !reflects;
            }
            segment.split = true;
        }
        if refracts {
            self.push_refraction(&segment, throughput * interface.transmitted, encounter, &interface, material);
        }
        // How much the surface scatters itself.
        let own = |share: f32| match share {
            0.0 => Vec3::ZERO,
            share => throughput * share * scene.own_radiance(point, -direction),
        };
        if reflects && interface.attenuation.is_some() {
            segment.deferred = interface.deferred(own(1.0));
            self.push_reflection(&segment, throughput * interface.reflected, encounter, &interface.facing);
            return Vec3::ZERO;
        }
        if reflects {
            self.push_reflection(&segment, throughput * interface.reflected, encounter, &interface.facing);
        }
        own(interface.scattered)
    }

    fn push(&mut self, segment: &Segment, child: Segment, point: &SurfacePoint) {
        if child.throughput.max_element() >= LEAST_THROUGHPUT || child.deferred.is_some() {
            let origin = self.tracer.departure(point, child.ray.direction);
            let ray = Ray { origin, direction: child.ray.direction };
            self.waiting.push(Segment { ray, near: 0.0, order: segment.order + 1, ..child });
        }
    }

    fn push_reflection(&mut self, segment: &Segment, throughput: Vec3, encounter: &Encounter, facing: &Facing) {
        let incoming = segment.ray.direction;
        let direction = facing.reflected(incoming);
        let bend = |ray, normal| reflected_change(incoming, ray, facing.normal, normal);
        let change = segment.change.as_ref().map(|change| child_change(change, encounter, facing.sign(), bend));
        let ray = Ray { origin: encounter.point.position, direction };
        self.push(segment, Segment { ray, change, throughput, ..*segment }, &encounter.point);
    }

    fn push_refraction(
        &mut self,
        segment: &Segment,
        throughput: Vec3,
        encounter: &Encounter,
        interface: &Interface,
        material: &Material,
    ) {
        let incoming = segment.ray.direction;
        let Interface { facing, eta, .. } = *interface;
        let Some(direction) = facing.refracted(incoming, eta) else { return };
        let bend = |ray, normal| refracted_change(incoming, ray, facing.normal, normal, eta);
        let change = segment.change.as_ref().map(|change| child_change(change, encounter, facing.sign(), bend));
        let absorption = if facing.outside { material.absorption } else { Vec3::ZERO };
        let ray = Ray { origin: encounter.point.position, direction };
        self.push(segment, Segment { ray, change, throughput, absorption, ..*segment }, &encounter.point);
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

/// The changes of a child ray, from those of its direction.
#[inline]
fn child_change(
    change: &RayDifferential,
    encounter: &Encounter,
    sign: f32,
    bend: impl Fn(Vec3, Vec3) -> Vec3,
) -> RayDifferential {
    RayDifferential {
        origin_dx: encounter.position_change[0],
        origin_dy: encounter.position_change[1],
        direction_dx: bend(change.direction_dx, encounter.normal_change[0] * sign),
        direction_dy: bend(change.direction_dy, encounter.normal_change[1] * sign),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, model::*};
    use crate::surface::AnalyticSurface;

    /// A ball and a smooth patch of triangles, seen obliquely.
    fn scene(material: Material) -> Scene {
        let mut model = Model { materials: vec![material], ..Model::default() };
        let surface = AnalyticSurface::Sphere { radius: 1.0 };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        model.nodes.push(Node { analytic, ..Node::default() });
        let normal = |x: f32, y: f32| Vec3::new(x * 0.2, y * 0.3, 1.0).normalize();
        let primitive = Primitive {
            positions: vec![Vec3::new(1.5, -1.0, 0.0), Vec3::new(4.0, -1.0, 0.3), Vec3::new(2.0, 2.0, 0.1)],
            normals: vec![normal(0.0, 0.0), normal(1.0, 0.0), normal(0.0, 1.0)],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        model.nodes.push(Node { mesh: Some(0), ..Node::default() });
        model.pose(&Default::default()).unwrap()
    }

    /// The child of a view ray at its first hit.
    fn child(scene: &Scene, view: &View, x_px: f32, y_px: f32) -> Segment {
        let tracer = Tracer::build(scene, |_| true);
        let mut paths = PathTracer::new(scene, &tracer, PathModel::Tree, 4);
        let (ray, change) = view.ray_with_differential(x_px, y_px);
        paths.follow(&Segment::first(ray, Some(change), 0.0));
        // The refracted child, where there is one, was pushed first.
        paths.waiting[0]
    }

    #[test]
    fn ray_changes_match_differences() {
        let camera = Camera::look_at("", Vec3::new(1.2, 0.4, 6.0), Vec3::new(1.2, 0.2, 0.0), Vec3::Y, 45.0);
        let view = View::new(&camera, 400, 300, 1e-3);
        for material in [Material::mirror("", Vec3::ONE), Material::glass("", 1.4)] {
            let scene = scene(material);
            for (x, y) in [(110.0, 150.0), (90.0, 130.0), (280.0, 160.0), (300.0, 175.0)] {
                let change = child(&scene, &view, x, y).change.unwrap();
                let step = 0.5;
                let (a, b) = (child(&scene, &view, x - step, y).ray, child(&scene, &view, x + step, y).ray);
                let origin = (b.origin - a.origin) / (2.0 * step);
                let direction = (b.direction - a.direction) / (2.0 * step);
                assert!((origin - change.origin_dx).length() < 2e-3 * origin.length(), "{x} {y}: {origin}");
                assert!((direction - change.direction_dx).length() < 5e-3 * direction.length(), "{x} {y}: {direction}");
                let (a, b) = (child(&scene, &view, x, y - step).ray, child(&scene, &view, x, y + step).ray);
                let direction = (b.direction - a.direction) / (2.0 * step);
                assert!((direction - change.direction_dy).length() < 5e-3 * direction.length(), "{x} {y}: {direction}");
            }
        }
    }
}
