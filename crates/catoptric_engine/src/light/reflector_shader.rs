//! Reflectors and lenses by the first bounce alone: light is looked up along the rays that leave it.

use crate::light::radiance_field::RadianceField;
use crate::optics::path::bundle::{Bounce, BounceKind};
use crate::optics::step::{LightStep, RoughLobe};
use catoptric_core::scene::shade::{SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Ray, RayDifferential, Role, Scene, TurnedEncounter};
use glam::Vec3;

/// Shading of reflectors and lenses.
pub trait ReflectorShader: Sync {
    /// The radiance of a reflector or lens towards where a ray comes from that meets it; `change` is the ray's a pixel.
    fn radiance(&self, scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray, change: &RayDifferential) -> Vec3;

    /// The radiance of what lies behind all that is drawn, along a ray from the eye.
    fn behind(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let _ = change;
        scene.background(ray.direction)
    }
}

/// Division of light at a reflector or lens, by the two ways from it.
#[derive(Clone, Copy, Debug)]
pub struct FirstSurface {
    step: LightStep,
    /// The cone that a rough mirror reflects, or a lens with bumps that are smaller than a footprint.
    pub lobe: Option<RoughLobe>,
    /// Radiance that the surface scatters itself, with its share, and its highlights.
    pub own: Vec3,
    /// Factors of light that arrives by each way; at mirrors light divides, if at all, further on.
    pub shares: [Vec3; 2],
}

impl FirstSurface {
    /// The division at a point that is met in a unit direction. A mirror whose share depends on the distance of what it
    /// shows takes that from `distance`; `None`: it shows nothing.
    #[inline(always)] // for the instructions of its caller
    pub fn of(
        scene: &Scene,
        point: &SurfacePoint,
        direction: Vec3,
        distance: impl FnOnce(&LightStep) -> Option<f32>,
    ) -> Self {
        Self::with_normal(scene, point, (point.normal, 0.0), direction, distance)
    }

    /// The same with another unit normal on the outer side than the point's, and how much it differs within the point's
    /// footprint.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn with_normal(
        scene: &Scene,
        point: &SurfacePoint,
        (normal, variance): (Vec3, f32),
        direction: Vec3,
        distance: impl FnOnce(&LightStep) -> Option<f32>,
    ) -> Self {
        let material = scene.material_of(point.object);
        let step = LightStep::with_normal(scene, material, point, normal, direction);
        let own = match step.scattered {
            0.0 => Vec3::ZERO,
            _ => scene.own_radiance(point, -direction),
        };
        let lobe = RoughLobe::of(material.facets_alpha(variance), &step.facing, direction);
        let mut found = Self { step, lobe, own: own * step.scattered, shares: [step.reflected, step.transmitted] };
        if step.reflected != Vec3::ZERO
            && let Some(deferred) = step.deferred(own)
            && let Some(distance) = distance(&step)
        {
            let (settled, weight) = deferred.settled(distance);
            (found.own, found.shares[0]) = (settled, step.reflected * weight);
        }
        if let Some(lobe) = &lobe {
            found.shares[0] *= lobe.share;
        }
        found.own += scene.highlights(point, -direction);
        if scene.role_of(point.object) != Role::Lens {
            found.shares[1] = found.shares[0];
        }
        found
    }
}

/// The radiance of a reflector or lens towards the origin of a ray that meets it: light that is looked up after one
/// event, and light that the surface scatters itself. Reflections are black without a radiance field.
pub fn reflector_radiance(
    light: Option<&impl RadianceField>,
    scene: &Scene,
    encounter: &SurfaceInteraction,
    ray: &Ray,
    change: &RayDifferential,
) -> Vec3 {
    let point = &encounter.point;
    let leaving =
        |step: &LightStep, kind| Some(Ray { origin: point.position, direction: step.outgoing(kind, ray.direction)? });
    let distance = |step: &LightStep| {
        let towards = light.zip(leaving(step, BounceKind::Reflect));
        Some(towards.map_or(f32::INFINITY, |(light, towards)| light.distance(&towards)))
    };
    let TurnedEncounter { encounter: turned, variance } =
        &scene.turned_encounter(scene.material_of(point.object), encounter);
    let FirstSurface { step, lobe, own: mut sum, shares } =
        FirstSurface::with_normal(scene, point, (turned.point.normal, *variance), ray.direction, distance);
    for (kind, share) in [(BounceKind::Reflect, shares[0]), (BounceKind::Transmit, step.transmitted)] {
        if share != Vec3::ZERO
            && let Some(light) = light
            && let Some(leaving) = leaving(&step, kind)
        {
            let change = step.outgoing_change(kind, ray.direction, change, turned);
            let Some(lobe) = lobe else {
                sum += share * light.radiance(scene, &leaving, Some(&change));
                continue;
            };
            let (direction, width) = match kind {
                BounceKind::Reflect => (lobe.direction, lobe.width),
                BounceKind::Transmit => (leaving.direction, step.cone_width(kind, ray.direction, variance.sqrt())),
            };
            let leaving = Ray { direction, ..leaving };
            sum += share * light.radiance_of_cone(scene, &leaving, &change.widened(direction, width));
        }
    }
    sum
}

/// The one event behind which [`reflector_radiance`] looks light up, of two the way through glass; `None` where light
/// goes on by none.
pub fn first_bounce(scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray) -> Option<Bounce> {
    let object = encounter.point.object;
    let material = scene.material_of(object);
    let TurnedEncounter { encounter: turned, .. } = &scene.turned_encounter(material, encounter);
    let step = LightStep::at(scene, material, &turned.point, ray.direction);
    let goes_on = |kind: &BounceKind| step.weight(*kind) != Vec3::ZERO && step.outgoing(*kind, ray.direction).is_some();
    let kind = [BounceKind::Transmit, BounceKind::Reflect].into_iter().find(goes_on)?;
    Some(Bounce { object, kind })
}
