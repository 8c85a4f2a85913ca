//! Paths among some reflectors and lenses that do not branch: at every surface after the first light goes on by the way that
//! takes more of it (Hakura, Snyder 2001, section 3).

use crate::optics::{Interface, transmittance};
use crate::scene::shade::Encounter;
use crate::scene::{Ray, Role, Scene};
use crate::surface::tracer::Tracer;
use glam::Vec3;

/// The way of light at the first surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Reflected,
    Refracted,
}

impl First {
    /// Both ways; the second one is lenses' alone.
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
    /// From a surface that is met in a unit direction, by one of its ways.
    ///
    /// Where a mirror's share depends on how far away what it shows is, and the ray leaves from there, that is taken to be
    /// infinitely far; at the first surface the share is the caller's.
    pub(super) fn follow(&self, mut incoming: Vec3, mut encounter: Encounter, first: First) -> GreedyPath {
        let (scene, tracer) = (self.scene, self.tracer);
        let mut path = GreedyPath { share: Vec3::ONE, ..GreedyPath::default() };
        let mut absorption = Vec3::ZERO;
        loop {
            let point = &encounter.point;
            let material = scene.material_of(point.object);
            let interface = Interface::of(scene, material, point, incoming);
            let is_first = path.events == 0;
            let mut deferred = None;
            let way = match is_first {
                true => first,
                false if interface.prefers_reflection() => First::Reflected,
                false => First::Refracted,
            };
            let is_last = path.events >= self.order;
            if !is_first {
                if interface.scattered > 0.0 {
                    let own = path.share * scene.own_radiance(point, -incoming);
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
            let ray = Ray { origin: tracer.departure(point, direction), direction };
            let hit = tracer.first_hit(scene, &ray, 0.0);
            let distance = hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance());
            if let Some(deferred) = deferred {
                let (own, weight) = deferred.settled(distance);
                path.added += own;
                path.share *= weight;
            }
            let Some(hit) = hit else {
                path.leaving = Some(ray);
                return path;
            };
            encounter = tracer.encounter(scene, &ray, &hit, None);
            let met = scene.material_of(encounter.point.object);
            // Whoever meets a lens from inside was inside it.
            let inside = met.role == Role::Lens && direction.dot(encounter.point.geometric_normal) > 0.0;
            path.share *= transmittance(if inside { met.absorption } else { absorption }, distance);
            incoming = direction;
        }
    }
}
