//! What reflectors and lenses show by a ray-transfer light field.

use super::slabs::Slabs;
use super::transfer::RayTransfer;
use crate::methods::lookup::greedy::First;
use crate::methods::lookup::reflector::FirstSurface;
use crate::methods::reference::Beyond;
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
    let leaving = |first: First| transfer.look_up(point.position, -ray.direction, first);
    // Light; the footprint is the difference to what leaves for the next pixels.
    let arriving = |first: First| {
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
        Some(leaving.share * Beyond::radiance(&slabs, scene, &leaving.ray, Some(&change)))
    };
    let distance =
        || leaving(First::Reflected).map(|leaving| slabs.distance(leaving.ray.origin, leaving.ray.direction));
    let FirstSurface { own, shares } = FirstSurface::of(scene, point, ray.direction, distance);
    let shown = First::BOTH.into_iter().zip(shares).filter(|(_, share)| *share != Vec3::ZERO);
    own + shown.filter_map(|(first, share)| Some(share * arriving(first)?)).sum::<Vec3>()
}
