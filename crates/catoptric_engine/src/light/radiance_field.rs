//! Radiance along rays.

use catoptric_core::scene::{Environment, Lamps, Ray, RayDifferential, Scene};
use glam::Vec3;
use std::sync::Arc;

/// Everything that rays look up: captured and stored light, and the light from infinity.
///
/// One ray a call: paths end one by one, after different numbers of bounces, and each result decides whether the next
/// ray is traced. Gathering them first would reorder the sums of radiance and cost the memory traffic.
pub trait RadianceField {
    /// The radiance that arrives at a ray's origin along it, blurred over the ray's change a pixel where that is known.
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3;

    /// [`Self::radiance`] of a ray that stands for a cone as wide as its change: blurred also where sharp rays are not.
    #[inline(always)]
    fn radiance_of_cone(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        self.radiance(scene, ray, Some(change))
    }

    /// The same from all around the ray, within an angle across.
    fn radiance_within(&self, scene: &Scene, ray: &Ray, across: f32) -> Vec3 {
        self.radiance_of_cone(scene, ray, &RayDifferential::default().widened(ray.direction, across))
    }

    /// Small bright parts of the light from infinity, which [`Self::radiance_beside_lamps`] can leave out.
    fn lamps<'s>(&self, scene: &'s Scene) -> Option<&'s Lamps> {
        let _ = scene;
        None
    }

    /// [`Self::radiance_within`] of which lamps have a share between 0 and 1.
    fn radiance_beside_lamps(&self, scene: &Scene, ray: &Ray, across: f32, share_of_lamps: f32) -> Vec3 {
        let _ = share_of_lamps;
        self.radiance_within(scene, ray, across)
    }

    /// The distance along a ray of unit direction of what it looks up; infinite where unknown.
    fn distance(&self, ray: &Ray) -> f32 {
        let _ = ray;
        f32::INFINITY
    }
}

impl<F: RadianceField + ?Sized> RadianceField for &F {
    #[inline(always)]
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3 {
        (**self).radiance(scene, ray, change)
    }

    #[inline(always)]
    fn radiance_of_cone(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        (**self).radiance_of_cone(scene, ray, change)
    }

    #[inline(always)]
    fn radiance_within(&self, scene: &Scene, ray: &Ray, across: f32) -> Vec3 {
        (**self).radiance_within(scene, ray, across)
    }

    fn lamps<'s>(&self, scene: &'s Scene) -> Option<&'s Lamps> {
        (**self).lamps(scene)
    }

    fn radiance_beside_lamps(&self, scene: &Scene, ray: &Ray, across: f32, share_of_lamps: f32) -> Vec3 {
        (**self).radiance_beside_lamps(scene, ray, across, share_of_lamps)
    }

    #[inline(always)]
    fn distance(&self, ray: &Ray) -> f32 {
        (**self).distance(ray)
    }
}

/// The scene's light from infinity.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneBackground;

impl RadianceField for SceneBackground {
    #[inline(always)]
    fn radiance(&self, scene: &Scene, ray: &Ray, _change: Option<&RayDifferential>) -> Vec3 {
        scene.background(ray.direction)
    }

    fn radiance_of_cone(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let over =
            |sky: &Arc<Environment>| sky.radiance_of_cone(ray.direction, [change.direction_dx, change.direction_dy]);
        scene.environment.as_ref().map_or(Vec3::ZERO, over)
    }

    #[inline(always)]
    fn radiance_within(&self, scene: &Scene, ray: &Ray, across: f32) -> Vec3 {
        scene.environment.as_ref().map_or(Vec3::ZERO, |sky| sky.radiance_within(ray.direction, across))
    }

    #[inline]
    fn lamps<'s>(&self, scene: &'s Scene) -> Option<&'s Lamps> {
        scene.environment.as_ref()?.lamps()
    }

    fn radiance_beside_lamps(&self, scene: &Scene, ray: &Ray, across: f32, share_of_lamps: f32) -> Vec3 {
        let Some(sky) = &scene.environment else { return Vec3::ZERO };
        match sky.lamps() {
            Some(lamps) => sky.radiance_within_beside(lamps, ray.direction, across, share_of_lamps),
            None => sky.radiance_within(ray.direction, across),
        }
    }
}
