//! Following rays through reflectors and lenses without derivatives.

use super::grid_ray::GridRay;
use crate::find::ray_map::{Scattering, Specular, departure, is_spurious};
use catoptric_core::scene::Ray;
use catoptric_core::scene::hit::PrimitiveHit;
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::path::manifold::SurfaceArrival;
use glam::DVec3;
use std::hash::{Hash, Hasher};

/// A path so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Bounces {
    /// Signature of the path: sums of signatures differ for different sets of paths.
    pub(in super::super) signature: u64,
    count: usize,
    bounces: [Bounce; MAX_BOUNCES],
}

impl Bounces {
    const NONE: Self = Self {
        signature: 0x9e37_79b9_7f4a_7c15,
        count: 0,
        bounces: [Bounce { object: 0, kind: BounceKind::Reflect }; MAX_BOUNCES],
    };

    fn and(mut self, bounce: Bounce) -> Self {
        let letter = u64::from(bounce.object) << 1 | u64::from(bounce.kind == BounceKind::Reflect);
        let mixed = (self.signature ^ letter.wrapping_add(0x632b_e59b_d9b4_e019)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        self.signature = mixed ^ mixed >> 32;
        self.bounces[self.count] = bounce;
        self.count += 1;
        self
    }

    /// The bounces of the path, from the eye on.
    pub(in super::super) fn so_far(&self) -> &[Bounce] {
        &self.bounces[..self.count]
    }

    pub(in super::super) fn path(&self) -> SpecularPath {
        SpecularPath { bounces: self.so_far().to_vec() }
    }
}

impl Hash for Bounces {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.signature);
    }
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct RayState {
    ray: Ray,
    from: DVec3,
    direction: DVec3,
    first: Option<(DVec3, DVec3)>,
    length: f64,
    medium: f64,
    /// True if the last bounce was on the outer side.
    outside: bool,
    bounces: Bounces,
}

/// The scene that rays are followed through.
pub(in super::super) struct Follower<'a> {
    specular: &'a Specular<'a>,
    /// Objects that show environment maps: no path goes on at them.
    mapped: &'a [bool],
    most: usize,
}

/// Room for following rays, and how many were traced.
#[derive(Default)]
pub(in super::super) struct FollowSteps {
    waiting: Vec<RayState>,
    pub(in super::super) traced: u64,
}

impl<'a> Follower<'a> {
    pub(in super::super) fn new(specular: &'a Specular<'a>, mapped: &'a [bool]) -> Self {
        Self { specular, mapped, most: (specular.order as usize).min(MAX_BOUNCES) }
    }

    /// The first hit of a view ray.
    pub(in super::super) fn traced(&self, ray: &Ray, near: f32) -> Option<PrimitiveHit> {
        self.specular.tracer.first_meeting(self.specular.scene, ray, near)
    }

    /// Calls `found` for the outgoing ray of every `wanted` path that a view ray begins, which meets this first; paths
    /// that begin with unwanted ones are not followed. Its place is left at the origin.
    #[inline]
    pub(in super::super) fn follow(
        &self,
        ray: &Ray,
        meeting: &PrimitiveHit,
        steps: &mut FollowSteps,
        wanted: &impl Fn(&Bounces) -> bool,
        found: &mut impl FnMut(&Bounces, GridRay),
    ) {
        if self.most == 0 {
            return;
        }
        steps.traced += 1;
        steps.waiting.clear();
        let (from, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize_or_zero());
        let arrival = self.specular.surfaces.arrival(from, direction, meeting);
        let bounces = Bounces::NONE;
        let way =
            RayState { ray: *ray, from, direction, first: None, length: 0.0, medium: 1.0, outside: true, bounces };
        if let Some(arrival) = arrival {
            self.scatter(&way, &arrival, &mut steps.waiting, wanted, found);
        }
        while let Some(way) = steps.waiting.pop() {
            steps.traced += 1;
            // The first hit is searched for the ray as it is given, in single precision.
            let (origin, direction) = (way.ray.origin.as_dvec3(), way.ray.direction.as_dvec3().normalize_or_zero());
            let meeting = self.traced(&way.ray, 0.0);
            let arrival = meeting.and_then(|meeting| self.specular.surfaces.arrival(origin, direction, &meeting));
            if let Some(arrival) = arrival {
                self.scatter(&way, &arrival, &mut steps.waiting, wanted, found);
            }
        }
    }

    #[inline]
    fn scatter(
        &self,
        before: &RayState,
        arrival: &SurfaceArrival,
        waiting: &mut Vec<RayState>,
        wanted: &impl Fn(&Bounces) -> bool,
        found: &mut impl FnMut(&Bounces, GridRay),
    ) {
        let (object, position, normal) = (arrival.object, arrival.position, arrival.normal);
        if self.mapped.get(object as usize) == Some(&true) {
            return;
        }
        if let Some(last) = before.bounces.so_far().last()
            && is_spurious(self.specular.surfaces, *last, before.outside, object)
        {
            return;
        }
        let cosine = before.direction.dot(normal);
        let Some(scattering) = Scattering::new(self.specular, object, cosine, before.medium) else { return };
        let outside = scattering.outside;
        let length = before.length + scattering.crossed * before.from.distance(position);
        let first = before.first.unwrap_or((position, if outside { normal } else { -normal }));
        for kind in [BounceKind::Transmit, BounceKind::Reflect] {
            let Some(medium) = scattering.medium_after(kind) else { continue };
            let direction = match kind {
                BounceKind::Reflect => Some(before.direction - normal * (2.0 * cosine)),
                BounceKind::Transmit => {
                    let ratio = if outside { 1.0 / scattering.index } else { scattering.index };
                    refracted(before.direction, normal, cosine, ratio)
                }
            };
            let Some(direction) = direction else { continue };
            // By shading normals, light may seem to come from behind the flat triangle.
            let geometric = arrival.geometric_normal;
            if (direction.dot(geometric) > 0.0) != (outside == (kind == BounceKind::Reflect)) {
                continue;
            }
            let bounces = before.bounces.and(Bounce { object, kind });
            if !wanted(&bounces) {
                continue;
            }
            let (place, tail) = ([0.0; 2], position);
            found(&bounces, GridRay { place, first: first.0, normal: first.1, tail, direction, length, medium });
            if bounces.count < self.most {
                let ray =
                    Ray { origin: departure(tail, geometric, direction), direction: direction.as_vec3().normalize() };
                waiting.push(RayState {
                    ray,
                    from: tail,
                    direction,
                    first: Some(first),
                    length,
                    medium,
                    outside,
                    bounces,
                });
            }
        }
    }
}

/// Snell's law; returns `None` if there is total reflection. `ratio`: the index before over that behind.
fn refracted(direction: DVec3, normal: DVec3, cosine: f64, ratio: f64) -> Option<DVec3> {
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (behind >= 0.0).then(|| direction * ratio + normal * (behind.sqrt().copysign(cosine) - ratio * cosine))
}
