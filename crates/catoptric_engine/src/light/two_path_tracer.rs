//! Paths among some reflectors and lenses that do not branch: where light first meets a lens it goes on by a given way,
//! from there on by the way that takes more of it (Hakura, Snyder 2001, section 3). The reference's two-path model
//! divides light at the same place.

use crate::light::tracer::Tracer;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{LightStep, crossed_medium, medium_after, transmittance};
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Ray, Role, Scene};
use glam::Vec3;

/// Path of a ray after its first surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpecularChain {
    /// The ray that leaves in the end. None where its light ends among the surfaces, or after more events than are
    /// allowed.
    pub leaving: Option<Ray>,
    /// Throughput of light from there on the way, without that of the first surface: the product of Fresnel
    /// coefficients, tints and attenuation.
    pub share: Vec3,
    /// Light that surfaces on the way (but for the first) scatter themselves, with their share.
    pub added: Vec3,
    /// Events, the first among them: as many rays were traced.
    pub events: u32,
    /// Bit k is set where light is refracted at event k.
    pub refractions: u64,
    /// True after a hit on a lens, from which a second path starts.
    pub divides: bool,
}

/// Follows paths among the reflectors and lenses of a tracer.
#[derive(Clone, Copy)]
pub struct TwoPathTracer<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Hierarchy of reflectors and lenses alone.
    pub tracer: &'a Tracer,
    /// The most events of a path.
    pub order: u32,
}

impl TwoPathTracer<'_> {
    /// From a surface that is met in a unit direction, by one of the ways at the first lens. By the second way nothing
    /// arrives where there is none, and what surfaces before it scatter themselves is the first one's.
    ///
    /// Where a mirror's share depends on how far away what it shows is, and the ray leaves from there, that is taken to
    /// be infinitely far; at the first surface the share is the caller's.
    pub fn follow(&self, mut incoming: Vec3, mut point: SurfacePoint, first: BounceKind) -> SpecularChain {
        let (scene, tracer) = (self.scene, self.tracer);
        let mut path = SpecularChain { share: Vec3::ONE, ..SpecularChain::default() };
        let (mut absorption, mut distance) = (Vec3::ZERO, 0.0);
        loop {
            let material = scene.material_of(point.object);
            let step = LightStep::at(scene, material, &point, incoming);
            absorption =
                crossed_medium(material.role == Role::Lens, step.facing.outside, material.absorption, absorption);
            path.share *= transmittance(absorption, distance);
            let is_first = path.events == 0;
            let mut deferred = None;
            let is_shared = first == BounceKind::Transmit && !path.divides;
            let kind = match () {
                () if material.role == Role::Lens && !path.divides => first,
                () if step.prefers_reflection() => BounceKind::Reflect,
                () => BounceKind::Transmit,
            };
            path.divides |= material.role == Role::Lens;
            let is_last = path.events >= self.order;
            if !is_first {
                if !is_shared {
                    path.added += path.share * scene.highlights(&point, -incoming);
                }
                if step.scattered > 0.0 {
                    let share = if is_shared { Vec3::ZERO } else { path.share };
                    let own = share * scene.own_radiance(&point, -incoming);
                    deferred = step.deferred(own).filter(|_| !is_last);
                    if deferred.is_none() {
                        path.added += own * step.scattered;
                    }
                }
                path.share *= step.weight(kind);
            }
            let goes_on = !is_last && path.share.max_element() > 0.0;
            let Some(direction) = step.outgoing(kind, incoming).filter(|_| goes_on) else {
                path.share = Vec3::ZERO;
                return path;
            };
            if kind == BounceKind::Transmit {
                path.refractions |= 1u64.checked_shl(path.events).unwrap_or(0);
            }
            absorption = medium_after(kind, step.facing.outside, material.absorption, absorption, Vec3::ZERO);
            path.events += 1;
            let ray = Ray { origin: tracer.departure(&point, direction), direction };
            let hit = tracer.first_hit(scene, &ray, 0.0);
            distance = hit.as_ref().map_or(f32::INFINITY, |hit| hit.distance());
            if let Some(deferred) = deferred {
                let (own, weight) = deferred.settled(distance);
                path.added += own;
                path.share *= weight;
            }
            let Some(hit) = hit else {
                let is_empty = first == BounceKind::Transmit && !path.divides;
                path.leaving = (!is_empty).then_some(ray);
                path.share = if is_empty { Vec3::ZERO } else { path.share };
                return path;
            };
            point = tracer.point(scene, &ray, &hit);
            incoming = direction;
        }
    }
}
