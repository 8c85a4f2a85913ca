//! Smooth mirrors whose normal maps have bumps that are smaller than what a ray stands for: parts of it are reflected
//! on their own.

use super::tracer::Tracer;
use crate::math::random;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::{Facing, LightStep, cone_width};
use crate::scene::shade::SurfaceInteraction;
use crate::scene::{Material, Ray, RayDifferential, Scene, TurnedEncounter};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// A ray that meets a mirror with bumps, and all that it stands for.
pub(crate) struct BumpyMeeting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tracer: &'a Tracer,
    pub(crate) ray: &'a Ray,
    /// The change of the ray to its neighbours.
    pub(crate) change: &'a RayDifferential,
    /// Where it meets the mirror, before the map turns the normal.
    pub(crate) encounter: &'a SurfaceInteraction,
}

/// The reflection of a part of a ray.
pub(crate) struct ReflectedPart {
    pub(crate) ray: Ray,
    pub(crate) change: RayDifferential,
    /// The share of light that is reflected, with its tint.
    pub(crate) reflected: Vec3,
}

impl BumpyMeeting<'_> {
    /// The reflections of `count` parts, fewer where some reflect nothing. `turn` moves the numbers (0 to 1) that
    /// choose each part's place and its slope.
    pub(crate) fn parts(
        &self,
        material: &Material,
        count: u32,
        turn: [Vec2; 2],
    ) -> impl Iterator<Item = ReflectedPart> {
        (0..count).filter_map(move |index| {
            let place = (random::hammersley(index, count) + turn[0]).fract();
            let slope = (random::spread(index) + turn[1]).fract();
            self.part(material, count, place, slope)
        })
    }

    /// The reflection of one of `count` parts, by its place in what the ray stands for. Bumps that are smaller than the
    /// part, too, are as if their slopes were normally distributed.
    fn part(&self, material: &Material, count: u32, place: Vec2, slope: Vec2) -> Option<ReflectedPart> {
        let Self { scene, tracer, ray, change, encounter } = *self;
        let (offset, side) = (place - 0.5, 1.0 / (count as f32).sqrt());
        let incoming = ray.direction + change.direction_dx * offset.x + change.direction_dy * offset.y;
        let incoming = incoming.try_normalize()?;
        let part = encounter.part(offset, side);
        let TurnedEncounter { encounter: turned, variance } = scene.turned_encounter(material, &part);
        let mut step = LightStep::at(scene, material, &turned.point, incoming);
        let normal = step.facing.normal;
        let (across, along) = normal.any_orthonormal_pair();
        // Of two normally distributed numbers whose squares have this sum in the mean (Box and Muller).
        let (sine, cosine) = (TAU * slope.x).sin_cos();
        let length = (-variance * (1.0 - slope.y).max(f32::MIN_POSITIVE).ln()).sqrt();
        let normal = normal + (across * cosine + along * sine) * length;
        step.facing =
            Facing::new(incoming, turned.point.geometric_normal, normal.try_normalize()? * step.facing.sign());
        let direction = step.outgoing(BounceKind::Reflect, incoming)?;
        let change = step.outgoing_change(BounceKind::Reflect, incoming, &change.scaled(side), &part);
        // The parts' cones cover the lobe together.
        let change = change.widened(direction, cone_width(variance.sqrt()) * side);
        let ray = Ray { origin: tracer.departure(&turned.point, direction), direction };
        Some(ReflectedPart { ray, change, reflected: step.reflected })
    }
}
