//! Light on its way to a surface, through glass and veils.

use super::wide_hierarchy::{ALPHA_TESTED, TriangleHit};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::shade::{Barycentrics, SurfacePoint};
use catoptric_core::scene::{Ray, Scene};
use catoptric_core::surface::{PlacedSurface, SurfaceHit};
use glam::Vec3;
use std::cell::Cell;

/// Surfaces of a body that a ray meets, at most.
const MOST_MEETINGS: usize = 64;

/// Where a ray meets an exact surface between two distances, from near to far.
pub(super) fn all_meetings(
    surface: &PlacedSurface,
    ray: &Ray,
    [mut near, far]: [f32; 2],
) -> impl Iterator<Item = SurfaceHit> {
    let next = move || {
        let hit = surface.intersect(ray.origin, ray.direction, near, far)?;
        near = hit.distance.next_up();
        Some(hit)
    };
    std::iter::from_fn(next).take(MOST_MEETINGS)
}

/// Smaller shares count as none: a fraction of a step of eight bits.
const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// The share of light that is left behind all surfaces that it passes, in any order.
pub(super) struct LightThrough<'a> {
    /// Which objects let light pass.
    clear: &'a [bool],
    share: Cell<Vec3>,
    /// The exponents of what bodies absorb: less where the ray enters one, more where it leaves it, each times the
    /// distance from the start. A ray that starts within a body only leaves it.
    absorbed: Cell<Vec3>,
}

impl<'a> LightThrough<'a> {
    pub(super) fn new(clear: &'a [bool]) -> Self {
        Self { clear, share: Cell::new(Vec3::ONE), absorbed: Cell::new(Vec3::ZERO) }
    }

    pub(super) fn lets_pass(&self, object: u32) -> bool {
        self.clear[object as usize]
    }

    /// The share of light of each colour that has passed everything so far.
    pub(super) fn passed(&self) -> Vec3 {
        // A body that the way ends in is entered and not left.
        let absorbed = self.absorbed.get().max(Vec3::ZERO);
        self.share.get() * absorbed.map(|exponent| (-exponent).exponential())
    }

    /// Notes what passes a triangle that lets light pass; returns false if it stops all that is left.
    #[inline(never)] // few objects do
    pub(super) fn pass_triangle(&self, scene: &Scene, ray: &Ray, hit: &TriangleHit) -> bool {
        let triangle = hit.triangle & !ALPHA_TESTED;
        let at = Barycentrics { value: hit.barycentrics, ..Barycentrics::default() };
        self.pass(scene, ray, hit.distance, &scene.surface_point(triangle, &at));
        self.share.get().max_element() >= LEAST_SHARE
    }

    /// Notes what passes all of an exact surface between two distances.
    #[inline(never)]
    pub(super) fn pass_surface(
        &self,
        scene: &Scene,
        ray: &Ray,
        (object, surface): (u32, &PlacedSurface),
        distances: [f32; 2],
    ) {
        for hit in all_meetings(surface, ray, distances) {
            self.pass(scene, ray, hit.distance, &scene.exact_encounter(object, &hit, ray, None).point);
        }
    }

    fn pass(&self, scene: &Scene, ray: &Ray, distance: f32, point: &SurfacePoint) {
        self.share.set(self.share.get() * scene.passing(point, ray.direction));
        let material = scene.material_of(point.object);
        if material.has_inside() {
            let leaves = ray.direction.dot(point.geometric_normal) > 0.0;
            let absorbed = material.absorption * if leaves { distance } else { -distance };
            self.absorbed.set(self.absorbed.get() + absorbed);
        }
    }
}
