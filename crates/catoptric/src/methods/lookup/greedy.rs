//! Paths among some reflectors and lenses that do not branch: where light first meets a lens it goes on by a given way, from there on by the way
//! that takes more of it (Hakura, Snyder 2001, section 3). The reference's two-path model divides light at the same place.

use crate::optics::{Interface, transmittance};
use crate::scene::shade::SurfacePoint;
use crate::scene::{Ray, Role, Scene};
use crate::surface::tracer::Tracer;
use glam::Vec3;

/// The way of light at the first lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Reflected,
    Refracted,
}

impl First {
    /// Both ways; where no lens is met there is no second one.
    pub(super) const BOTH: [Self; 2] = [Self::Reflected, Self::Refracted];
}

/// What becomes of a ray after its first surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct GreedyPath {
    /// The ray that leaves in the end. None where its light ends among the surfaces, or after more events than are allowed.
    pub(super) leaving: Option<Ray>,
    /// What light from there is multiplied with on the way, but for the first surface: the product of Fresnel coefficients,
    /// tints and attenuation.
    pub(super) share: Vec3,
    /// Light that surfaces on the way (but for the first) scatter themselves, with their share.
    pub(super) added: Vec3,
    /// Events, the first among them: as many rays were traced.
    pub(super) events: u32,
    /// Bit k is set where light is refracted at event k.
    pub(super) refractions: u64,
    /// Whether a lens was met, so that there is a second path.
    pub(super) divides: bool,
}

/// Follows paths among the reflectors and lenses that a tracer knows.
#[derive(Clone, Copy)]
pub(super) struct GreedyPaths<'a> {
    pub(super) scene: &'a Scene,
    /// Of reflectors and lenses alone.
    pub(super) tracer: &'a Tracer,
    /// The most events of a path.
    pub(super) order: u32,
}

impl GreedyPaths<'_> {
    /// From a surface that is met in a unit direction, by one of the ways at the first lens. By the second way nothing arrives where there is
    /// none, and what surfaces before it scatter themselves is the first one's.
    ///
    /// Where a mirror's share depends on how far away what it shows is, and the ray leaves from there, that is taken to be
    /// infinitely far; at the first surface the share is the caller's.
    pub(super) fn follow(&self, mut incoming: Vec3, mut point: SurfacePoint, first: First) -> GreedyPath {
        let (scene, tracer) = (self.scene, self.tracer);
        let mut path = GreedyPath { share: Vec3::ONE, ..GreedyPath::default() };
        let mut absorption = Vec3::ZERO;
        loop {
            let material = scene.material_of(point.object);
            let interface = Interface::of(scene, material, &point, incoming);
            let is_first = path.events == 0;
            let mut deferred = None;
            let is_shared = first == First::Refracted && !path.divides;
            let way = match () {
                () if material.role == Role::Lens && !path.divides => first,
                () if interface.prefers_reflection() => First::Reflected,
                () => First::Refracted,
            };
            path.divides |= material.role == Role::Lens;
            let is_last = path.events >= self.order;
            if !is_first {
                if interface.scattered > 0.0 {
                    let share = if is_shared { Vec3::ZERO } else { path.share };
                    let own = share * scene.own_radiance(&point, -incoming);
                    deferred = interface.deferred(own).filter(|_| !is_last);
                    if deferred.is_none() {
                        path.added += own * interface.scattered;
                    }
                }
                path.share *= match way {
                    First::Reflected => interface.reflected,
                    First::Refracted => interface.transmitted,
                };
            }
            let direction = match way {
                First::Reflected => Some(interface.facing.reflected(incoming)),
                First::Refracted => interface.facing.refracted(incoming, interface.eta),
            };
            let Some(direction) = direction.filter(|_| !is_last && path.share.max_element() > 0.0) else {
                path.share = Vec3::ZERO;
                return path;
            };
            if way == First::Refracted {
                path.refractions |= 1u64.checked_shl(path.events).unwrap_or(0);
                absorption = if interface.facing.outside { material.absorption } else { Vec3::ZERO };
            }
            path.events += 1;
            let ray = Ray { origin: tracer.departure(&point, direction), direction };
            let hit = tracer.first_hit(scene, &ray, 0.0);
            let distance = hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance());
            if let Some(deferred) = deferred {
                let (own, weight) = deferred.settled(distance);
                path.added += own;
                path.share *= weight;
            }
            let Some(hit) = hit else {
                let is_empty = first == First::Refracted && !path.divides;
                path.leaving = (!is_empty).then_some(ray);
                path.share = if is_empty { Vec3::ZERO } else { path.share };
                return path;
            };
            point = tracer.point(scene, &ray, &hit);
            let met = scene.material_of(point.object);
            // Whoever meets a lens from inside was inside it.
            let inside = met.role == Role::Lens && direction.dot(point.geometric_normal) > 0.0;
            path.share *= transmittance(if inside { met.absorption } else { absorption }, distance);
            incoming = direction;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::methods::lookup::reflector::FirstSurface;
    use crate::methods::reference::{Beyond, PathModel, PathTracer};
    use crate::scene::{RayDifferential, builtin};

    /// Light that tells where it comes from.
    #[derive(Clone, Copy)]
    struct Sky;

    impl Sky {
        fn of(direction: Vec3) -> Vec3 {
            direction * 0.5 + 0.6
        }
    }

    impl Beyond for Sky {
        fn radiance(&self, _: &Scene, ray: &Ray, _: Option<&RayDifferential>) -> Vec3 {
            Self::of(ray.direction)
        }
    }

    #[test]
    fn both_paths_are_those_of_the_reference() {
        // A pot of glass and a mirror cup: each is seen in the other.
        let scene = builtin::parse("colonnade?tess=24").unwrap().pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |object| scene.role_of(object).is_specular());
        let order = 6;
        let paths = GreedyPaths { scene: &scene, tracer: &tracer, order };
        let mut reference = PathTracer::with_beyond(&scene, &tracer, PathModel::TwoPath, order, Sky);
        let view = scene.default_view(320, 240);
        let mut random = Stream::new(4);
        let (mut checked, mut divided_later) = (0, 0);
        for _ in 0..40_000 {
            let ray = view.ray(random.next_between(0.0, 320.0), random.next_between(0.0, 240.0));
            let Some(hit) = tracer.first_hit(&scene, &ray, 0.0) else { continue };
            let point = tracer.point(&scene, &ray, &hit);
            let FirstSurface { own, shares } = FirstSurface::of(&scene, &point, ray.direction, || None);
            let found = First::BOTH.into_iter().zip(shares).fold(own, |sum, (first, share)| {
                let path = paths.follow(ray.direction, point, first);
                let arrives = path.leaving.map_or(Vec3::ZERO, |leaving| path.share * Sky::of(leaving.direction));
                let is_mirror = scene.role_of(point.object) != Role::Lens;
                divided_later += u32::from(is_mirror && first == First::Refracted && path.divides);
                sum + share * (path.added + arrives)
            });
            let truth = reference.radiance_along(ray, None, 0.0);
            checked += 1;
            // The reference lets go of what counts less than a hundred thousandth.
            assert!((found - truth).abs().max_element() < 1e-4, "{found} against {truth}");
        }
        assert!(checked > 2000 && divided_later > 20, "{checked} rays, {divided_later} that divide after a mirror");
    }
}
