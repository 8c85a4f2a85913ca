//! What reflectors and lenses show by a ray-transfer light field.

use super::slabs::Slabs;
use super::transfer::RayTransfer;
use crate::methods::lookup::greedy::First;
use crate::methods::reference::Beyond;
use crate::optics::Interface;
use crate::scene::shade::Encounter;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::Vec3;

/// What a reflector or lens shows by rays that were traced and kept.
pub(super) fn stored_radiance(
    slabs: &Slabs,
    transfer: &RayTransfer,
    scene: &Scene,
    encounter: &Encounter,
    ray: &Ray,
    change: &RayDifferential,
) -> Vec3 {
    let point = &encounter.point;
    let interface = Interface::of(scene, scene.material_of(point.object), point, ray.direction);
    // Light and how far it comes from; the footprint is the difference to what leaves for the next pixels.
    let arriving = |first: First| {
        let leaving = transfer.look_up(point.position, -ray.direction, first)?;
        let beside = |moved: Vec3, turned: Vec3| {
            let next = transfer.look_up(point.position + moved, -(ray.direction + turned).normalize(), first);
            next.map_or([Vec3::ZERO; 2], |next| {
                [next.ray.origin - leaving.ray.origin, next.ray.direction - leaving.ray.direction]
            })
        };
        let [origin_dx, direction_dx] = beside(encounter.position_change[0], change.direction_dx);
        let [origin_dy, direction_dy] = beside(encounter.position_change[1], change.direction_dy);
        let change = RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy };
        let radiance = Beyond::radiance(&slabs, scene, &leaving.ray, Some(&change));
        Some((leaving.share * radiance, leaving.ray))
    };
    let mut sum = Vec3::ZERO;
    let own = match interface.scattered {
        0.0 => Vec3::ZERO,
        _ => scene.own_radiance(point, -ray.direction),
    };
    let mut own_share = interface.scattered;
    if interface.reflected != Vec3::ZERO
        && let Some((radiance, leaving)) = arriving(First::Reflected)
    {
        let mut reflection = interface.reflected * radiance;
        if let Some(deferred) = interface.deferred(own) {
            let (settled, weight) = deferred.settled(slabs.distance(leaving.origin, leaving.direction));
            (own_share, reflection) = (0.0, settled + reflection * weight);
        }
        sum += reflection;
    }
    if interface.transmitted != Vec3::ZERO
        && let Some((radiance, _)) = arriving(First::Refracted)
    {
        sum += interface.transmitted * radiance;
    }
    sum + own * own_share
}
