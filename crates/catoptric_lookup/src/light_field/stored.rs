//! Shading of reflectors and lenses by a ray-transfer light field.

use super::slabs::Slabs;
use super::transfer::RayTransfer;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::light::radiance_field::RadianceField;
use catoptric_engine::light::reflector_shader::FirstSurface;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{LightStep, RoughLobe};
use glam::Vec3;

/// Radiance of a reflector or lens by stored rays.
pub(super) fn stored_radiance(
    slabs: &Slabs,
    transfer: &RayTransfer,
    scene: &Scene,
    encounter: &SurfaceInteraction,
    ray: &Ray,
    change: &RayDifferential,
) -> Vec3 {
    let point = &encounter.point;
    let leaving = |first: BounceKind| transfer.look_up(point.position, -ray.direction, first);
    // The arriving light; the footprint is the difference to the leaving rays of the next pixels.
    let arriving = |first: BounceKind, lobe: Option<RoughLobe>| {
        let leaving = leaving(first)?;
        let beside = |moved: Vec3, turned: Vec3| {
            let next = transfer.look_up(point.position + moved, -(ray.direction + turned).normalize(), first);
            next.map_or([Vec3::ZERO; 2], |next| {
                [next.ray.origin - leaving.ray.origin, next.ray.direction - leaving.ray.direction]
            })
        };
        let [origin_dx, direction_dx] = beside(encounter.position_change[0], change.direction_dx);
        let [origin_dy, direction_dy] = beside(encounter.position_change[1], change.direction_dy);
        let change = RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy };
        let change = match lobe {
            Some(lobe) if first == BounceKind::Reflect => change.widened(leaving.ray.direction, lobe.width),
            _ => change,
        };
        Some(leaving.share * RadianceField::radiance(slabs, scene, &leaving.ray, Some(&change)))
    };
    let distance =
        |_: &LightStep| leaving(BounceKind::Reflect).map(|leaving| RadianceField::distance(slabs, &leaving.ray));
    let FirstSurface { lobe, own, shares, .. } = FirstSurface::of(scene, point, ray.direction, distance);
    let shown = BounceKind::BOTH.into_iter().zip(shares).filter(|(_, share)| *share != Vec3::ZERO);
    own + shown.filter_map(|(first, share)| Some(share * arriving(first, lobe)?)).sum::<Vec3>()
}
