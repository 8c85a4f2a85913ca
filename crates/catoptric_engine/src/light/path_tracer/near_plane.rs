//! The near plane of a view, and pixels whose first surface behind it is wanted.

use crate::light::tracer::Tracer;
use catoptric_core::parallel;
use catoptric_core::scene::{Ray, Scene, View};
use glam::Vec3;

/// The near plane of a view.
pub struct NearPlane {
    depth: f32,
    forward: Vec3,
}

impl NearPlane {
    /// The near plane of `view`.
    pub fn new(view: &View) -> Self {
        Self { depth: view.near, forward: -Vec3::from(view.world_from_view.matrix3.z_axis) }
    }

    /// The distance along a view ray where the plane is.
    #[inline]
    pub fn distance(&self, ray: &Ray) -> f32 {
        self.depth / ray.direction.dot(self.forward).max(1e-6)
    }
}

/// For every pixel whether the first surface at its centre is a reflector or lens; rows from the top.
pub fn specular_mask(scene: &Scene, view: &View) -> Vec<bool> {
    mask(scene, view, |object| scene.role_of(object).is_specular())
}

/// For every pixel whether there is a surface at its centre; rows from the top.
pub fn surface_mask(scene: &Scene, view: &View) -> Vec<bool> {
    mask(scene, view, |_| true)
}

fn mask(scene: &Scene, view: &View, is_wanted: impl Fn(u32) -> bool + Sync) -> Vec<bool> {
    let tracer = Tracer::build(scene, |_| true);
    let (rays, near) = (view.rays(), NearPlane::new(view));
    let mut mask = vec![false; view.width as usize * view.height as usize];
    parallel::for_each_chunk_mut(&mut mask, view.width as usize, |y, row| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let ray = rays.ray(x as f32 + 0.5, y as f32 + 0.5);
            let hit = tracer.first_hit(scene, &ray, near.distance(&ray));
            *pixel = hit.is_some_and(|hit| {
                let encounter = tracer.encounter(scene, &ray, &hit, None);
                is_wanted(encounter.point.object)
            });
        }
    });
    mask
}
