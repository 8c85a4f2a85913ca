//! The first surfaces that an eye sees in the pixels of a picture, by rays.

use super::path_tracer::NearPlane;
use super::tracer::Tracer;
use catoptric_core::parallel;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::{Ray, Scene, View, ViewRays};
use glam::{Vec2, Vec3};

/// The first surfaces that a view of a scene shows.
pub struct FirstSurfaces<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer,
    rays: ViewRays,
    near: NearPlane,
    forward: Vec3,
    size: [u32; 2],
}

/// The first surface in the middle of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// Distance from the plane through the eye at right angles to the view axis, in scene units.
    pub depth: f32,
    /// The unit shading normal in the world, without normal maps, on the side that is seen.
    pub normal: Vec3,
    /// Index of the object.
    pub object: u32,
}

impl<'a> FirstSurfaces<'a> {
    /// The surfaces of a view; the tracer holds the whole scene.
    pub fn new(scene: &'a Scene, tracer: &'a Tracer, view: &View) -> Self {
        let forward = -Vec3::from(view.world_from_view.matrix3.z_axis).normalize_or_zero();
        let size = [view.width, view.height];
        Self { scene, tracer, rays: view.rays(), near: NearPlane::new(view), forward, size }
    }

    /// For every pixel the share of its samples, 0 to 1, whose first surface belongs to a wanted object; rows from the
    /// top. `place` tells the position in the picture of a pixel's sample, in pixels.
    pub fn shares(
        &self,
        samples: u32,
        place: impl Fn([u32; 2], u32) -> Vec2 + Sync,
        is_wanted: impl Fn(u32) -> bool + Sync,
    ) -> Vec<f32> {
        self.of_pixels(|pixel| {
            let is_seen = |sample: &u32| {
                let at = place(pixel, *sample);
                self.hit(at).is_some_and(|(_, hit)| is_wanted(hit.object(self.scene)))
            };
            (0..samples).filter(is_seen).count() as f32 / samples.max(1) as f32
        })
    }

    /// For every pixel what is in its middle, if there is something; rows from the top.
    pub fn in_the_middle(&self) -> Vec<Option<SeenPoint>> {
        self.of_pixels(|[x, y]| {
            let (ray, hit) = self.hit(Vec2::new(x as f32 + 0.5, y as f32 + 0.5))?;
            let point = self.tracer.point(self.scene, &ray, &hit);
            let is_outside = ray.direction.dot(point.geometric_normal) <= 0.0;
            let normal = if is_outside { point.normal } else { -point.normal };
            Some(SeenPoint { depth: hit.distance() * ray.direction.dot(self.forward), normal, object: point.object })
        })
    }

    fn of_pixels<T: Clone + Default + Send>(&self, pixel: impl Fn([u32; 2]) -> T + Sync) -> Vec<T> {
        let [width, height] = self.size;
        let mut values = vec![T::default(); width as usize * height as usize];
        parallel::for_each_chunk_mut(&mut values, width.max(1) as usize, |y, row| {
            for (x, value) in row.iter_mut().enumerate() {
                *value = pixel([x as u32, y as u32]);
            }
        });
        values
    }

    fn hit(&self, at: Vec2) -> Option<(Ray, Hit)> {
        let ray = self.rays.ray(at.x, at.y);
        self.tracer.first_hit(self.scene, &ray, self.near.distance(&ray)).map(|hit| (ray, hit))
    }
}
