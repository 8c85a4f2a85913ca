//! Smooth mirrors and lenses whose normal maps have bumps that are smaller than what a ray stands for: parts of it are
//! reflected and refracted on their own.

use super::tracer::Tracer;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::LightStep;
use catoptric_core::math::lanes::LANES;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::math::random;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Material, Ray, RayDifferential, Scene};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// A ray that meets a surface with bumps, and all that it stands for.
pub struct BumpyMeeting<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The hierarchy that finds what rays meet next.
    pub tracer: &'a Tracer,
    /// The ray, with a unit direction.
    pub ray: &'a Ray,
    /// The change of the ray to its neighbours.
    pub change: &'a RayDifferential,
    /// Where it meets the surface, before the map turns the normal.
    pub encounter: &'a SurfaceInteraction,
}

/// A part of a ray at a surface with bumps.
pub struct BumpyPart<'a> {
    tracer: &'a Tracer,
    /// The unit direction in which it arrives, and its change to its neighbours.
    incoming: Vec3,
    change: RayDifferential,
    encounter: SurfaceInteraction,
    /// The shares of light that are reflected and refracted here.
    pub step: LightStep,
    /// How far bumps that are smaller still turn normals to each side.
    finer_slope: f32,
    /// The part's side, as a share of all that the ray stands for.
    side: f32,
}

/// Light that leaves a surface by one event.
pub struct LeavingPart {
    /// The leaving ray.
    pub ray: Ray,
    /// The ray's change to its neighbours.
    pub change: RayDifferential,
    /// The share of light that goes this way, with its tint.
    pub weight: Vec3,
}

impl<'a> BumpyMeeting<'a> {
    /// Visits the meeting's parts, of which there are `count`, fewer where a normal cannot be told. `turn` moves the
    /// numbers (0 to 1) that choose each part's place and its slope.
    pub fn for_each_part(
        &self,
        material: &Material,
        count: u32,
        turn: [Vec2; 2],
        mut visit: impl FnMut(BumpyPart<'a>),
    ) {
        let Some(map) = material.turning_map() else { return };
        let side = 1.0 / (count as f32).sqrt();
        let offset = |index: u32| (random::hammersley(index, count) + turn[0]).fract() - 0.5;
        // Parts change as much as each other.
        let middle = self.encounter.part(Vec2::ZERO, side);
        for first in (0..count).step_by(LANES) {
            let indices = first..count.min(first + LANES as u32);
            let mut points = [middle.point; LANES];
            for (point, index) in points.iter_mut().zip(indices.clone()) {
                *point = self.encounter.part(offset(index), side).point;
            }
            let mut normals = [(Vec3::ZERO, 0.0); LANES];
            self.scene.normals_of_map(map, &points[..indices.len()], &mut normals);
            for (index, (point, normal)) in indices.zip(points.into_iter().zip(normals)) {
                let slope = (random::spread(index) + turn[1]).fract();
                let encounter = SurfaceInteraction { point, ..middle };
                if let Some(part) = self.part(material, (offset(index), side), encounter, normal, slope) {
                    visit(part);
                }
            }
        }
    }

    /// A part so far from the middle of what the ray stands for, and of a side, by its mean normal and the variance
    /// about it. Bumps that are smaller than the part, too, are as if their slopes were normally distributed.
    fn part(
        &self,
        material: &Material,
        (offset, side): (Vec2, f32),
        encounter: SurfaceInteraction,
        (normal, variance): (Vec3, f32),
        slope: Vec2,
    ) -> Option<BumpyPart<'a>> {
        let Self { scene, tracer, ray, change, .. } = *self;
        let incoming = ray.direction + change.direction_dx * offset.x + change.direction_dy * offset.y;
        let incoming = incoming.try_normalize()?;
        let (across, along) = normal.any_orthonormal_pair();
        // The sine, cosine and length of two normally distributed numbers whose squares have this sum in the mean (Box
        // and Muller).
        let (sine, cosine) = (TAU * slope.x).sine_cosine();
        let length = (-variance * (1.0 - slope.y).max(f32::MIN_POSITIVE).logarithm()).sqrt();
        let normal = (normal + (across * cosine + along * sine) * length).try_normalize()?;
        let step = LightStep::with_normal(scene, material, &encounter.point, normal, incoming);
        let (change, finer_slope) = (change.scaled(side), variance.sqrt());
        Some(BumpyPart { tracer, incoming, change, encounter, step, finer_slope, side })
    }
}

impl BumpyPart<'_> {
    /// The part's light by an event; `None` where no light goes this way.
    pub fn leaving(&self, kind: BounceKind) -> Option<LeavingPart> {
        let Self { tracer, incoming, change, encounter, step, .. } = self;
        let weight = step.weight(kind);
        let direction = step.outgoing(kind, *incoming).filter(|_| weight != Vec3::ZERO)?;
        // The parts' cones cover the lobe together.
        let width = step.cone_width(kind, *incoming, self.finer_slope) * self.side;
        let change = step.outgoing_change(kind, *incoming, change, encounter).widened(direction, width);
        let ray = Ray { origin: tracer.departure(&encounter.point, direction), direction };
        Some(LeavingPart { ray, change, weight })
    }
}
