//! What a reflector or lens shows by the first bounce alone: light is looked up along the rays that leave it.

use crate::optics::{Interface, fresnel_dielectric, mirror_tint, reflect, reflected_change, refract, refracted_change};
use crate::scene::shade::{Encounter, SurfacePoint};
use crate::scene::{Ray, RayDifferential, Role, Scene};
use glam::{Vec3, Vec4Swizzles};

/// What reflectors and lenses look like.
pub(in crate::methods) trait ReflectorLook: Sync {
    /// The radiance of a reflector or lens towards where a ray comes from that meets it; `change` is the ray's a pixel.
    fn radiance(&self, scene: &Scene, encounter: &Encounter, ray: &Ray, change: &RayDifferential) -> Vec3;

    /// The radiance of what lies behind all that is drawn, along a ray from the eye.
    fn behind(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let _ = change;
        scene.background(ray.direction)
    }
}

/// Light that arrives at a reflector or lens.
pub(super) trait ArrivingLight {
    /// The radiance along a ray that leaves the point in a direction (of unit length), blurred over its change a pixel.
    fn radiance(&self, scene: &Scene, encounter: &Encounter, direction: Vec3, change: [Vec3; 2]) -> Vec3;

    /// How far away what such a ray meets is taken to be; infinite where nothing is known.
    fn distance(&self, position: Vec3, direction: Vec3) -> f32;
}

/// What a reflector or lens makes of light by the two ways from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstSurface {
    /// What it scatters itself, with its share.
    pub(super) own: Vec3,
    /// What light that arrives by each way is multiplied with; at mirrors light divides, if at all, further on.
    pub(super) shares: [Vec3; 2],
}

impl FirstSurface {
    /// At a point that is met in a unit direction. Where a mirror's share depends on how far away what it shows is, that is asked for;
    /// none: nothing is shown.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn of(
        scene: &Scene,
        point: &SurfacePoint,
        direction: Vec3,
        distance: impl FnOnce() -> Option<f32>,
    ) -> Self {
        let interface = Interface::of(scene, scene.material_of(point.object), point, direction);
        let own = match interface.scattered {
            0.0 => Vec3::ZERO,
            _ => scene.own_radiance(point, -direction),
        };
        let mut found = Self { own: own * interface.scattered, shares: [interface.reflected, interface.transmitted] };
        if interface.reflected != Vec3::ZERO
            && let Some(deferred) = interface.deferred(own)
            && let Some(distance) = distance()
        {
            let (settled, weight) = deferred.settled(distance);
            (found.own, found.shares[0]) = (settled, interface.reflected * weight);
        }
        if scene.role_of(point.object) != Role::Lens {
            found.shares[1] = found.shares[0];
        }
        found
    }
}

/// What a reflector or lens shows where a ray meets it: light that is looked up, and what it scatters itself. Black is
/// reflected where no light is known.
pub(super) fn reflector_radiance(
    light: Option<&impl ArrivingLight>,
    scene: &Scene,
    encounter: &Encounter,
    ray: &Ray,
    change: &RayDifferential,
) -> Vec3 {
    let point = &encounter.point;
    let material = scene.material_of(point.object);
    let object = &scene.objects[point.object as usize];
    let outside = ray.direction.dot(point.geometric_normal) <= 0.0;
    let sign = if outside { 1.0 } else { -1.0 };
    let normal = point.normal * sign;
    let cosine = -ray.direction.dot(normal);
    let base = scene.base_color(material, point).xyz();
    let fetch = |direction: Vec3, direction_change: [Vec3; 2]| {
        light.map_or(Vec3::ZERO, |light| light.radiance(scene, encounter, direction, direction_change))
    };
    let mirrored = || {
        let bend = |ray_change, k: usize| {
            reflected_change(ray.direction, ray_change, normal, encounter.normal_change[k] * sign)
        };
        let change = [bend(change.direction_dx, 0), bend(change.direction_dy, 1)];
        fetch(reflect(ray.direction, normal), change)
    };
    match material.role {
        Role::Diffuse => Vec3::ZERO,
        Role::Reflector if outside && object.inside => Vec3::ZERO,
        Role::Reflector => {
            let reflection = mirror_tint(material, base, cosine) * mirrored();
            let Some(blend) = &material.blend else { return reflection };
            let mut weight = blend.weight_at(cosine.max(0.0));
            if let Some(attenuation) = &blend.attenuation {
                let towards = reflect(ray.direction, normal);
                weight *=
                    attenuation.weight(light.map_or(f32::INFINITY, |light| light.distance(point.position, towards)));
            }
            reflection * weight + scene.own_radiance(point, -ray.direction) * (1.0 - weight)
        }
        Role::Coated => {
            let reflectance = material.coat * fresnel_dielectric(cosine, 1.0 / material.ior);
            mirrored() * reflectance + scene.radiance(point, -ray.direction) * (1.0 - reflectance)
        }
        Role::Lens => {
            let eta = if outside { 1.0 / material.ior } else { material.ior };
            let reflectance = fresnel_dielectric(cosine, eta);
            let mut sum = mirrored() * reflectance;
            if let Some(direction) = refract(ray.direction, normal, eta) {
                let bend = |ray_change, k: usize| {
                    refracted_change(ray.direction, ray_change, normal, encounter.normal_change[k] * sign, eta)
                };
                let change = [bend(change.direction_dx, 0), bend(change.direction_dy, 1)];
                sum += base * fetch(direction, change) * (1.0 - reflectance);
            }
            sum
        }
    }
}
