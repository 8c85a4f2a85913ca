//! A scene's surfaces that emit light, and points of them.

use super::emitters::{Emitter, EmitterPoint, Emitters};
use crate::math::random;
use crate::scene::Scene;
use crate::scene::shade::Barycentrics;
use glam::{Vec2, Vec3};

/// Points that stand for all emitters together where they light surfaces.
const POINTS: u32 = 64;

/// Where there are more triangles that emit light, each is looked at in its middle alone.
const MANY_TRIANGLES: usize = 20_000;

/// Points lie above their triangles by so much, in sizes of the scene.
const ABOVE: f32 = 1e-5;

const MIDDLE: Vec2 = Vec2::splat(1.0 / 3.0);

/// Places of a triangle where its light is looked at.
const PLACES: [Vec2; 4] = [MIDDLE, Vec2::splat(0.15), Vec2::new(0.7, 0.15), Vec2::new(0.15, 0.7)];

impl Scene {
    /// The surfaces that emit light; `None` if there are none.
    pub(super) fn find_emitters(&self) -> Option<Emitters> {
        let glows = |object: u32| self.material_of(object).emits_light();
        let found: Vec<u32> =
            (0..).zip(&self.triangle_objects).filter(|(_, object)| glows(**object)).map(|(index, _)| index).collect();
        let places = if found.len() > MANY_TRIANGLES { &PLACES[..1] } else { &PLACES };
        Emitters::new(found.into_iter().map(|triangle| {
            let radiance_at = |place: &Vec2| {
                let at = Barycentrics { value: *place, ..Barycentrics::default() };
                self.emitted_radiance(&self.surface_point(triangle, &at))
            };
            let radiance = places.iter().map(radiance_at).sum::<Vec3>() / places.len() as f32;
            let [a, b, c] = self.corners(triangle);
            let area = 0.5 * (b - a).cross(c - a).length();
            Emitter::new(triangle, area, radiance, !self.is_one_sided(self.triangle_objects[triangle as usize]))
        }))
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// A point of emitters that two numbers between 0 and 1 choose, by the power of what emits.
    pub fn point_of(&self, emitters: &Emitters, number: Vec2) -> Vec3 {
        let (emitter, left) = emitters.chosen(number.x);
        let root = left.sqrt();
        let [a, b, c] = self.corners(emitter.triangle);
        a * (1.0 - root) + b * (root * (1.0 - number.y)) + c * (root * number.y)
    }

    /// The density of such points on a triangle, an area at right angles to a direction; 0 if it emits nothing.
    pub fn density_of(&self, emitters: &Emitters, triangle: u32, direction: Vec3) -> f32 {
        let density = emitters.density(triangle);
        if density == 0.0 {
            return 0.0;
        }
        let [a, b, c] = self.corners(triangle);
        let cosine = (b - a).cross(c - a).normalize_or_zero().dot(direction).abs();
        // Seen along the surface it takes no room.
        density / cosine.max(1e-6)
    }

    /// Points that stand for all of them, each on one side.
    pub(super) fn points_of(&self, emitters: &Emitters) -> Vec<EmitterPoint> {
        let above = self.bounds.diagonal() * ABOVE;
        let mut points = Vec::new();
        for number in (0..POINTS).map(|index| random::hammersley(index, POINTS)) {
            let (emitter, _) = emitters.chosen(number.x);
            let position = self.point_of(emitters, number);
            let middle = Barycentrics { value: MIDDLE, ..Barycentrics::default() };
            let normal = self.surface_point(emitter.triangle, &middle).geometric_normal;
            let radiance = emitter.radiance;
            let area = emitters.power() / (POINTS as f32 * radiance.element_sum());
            let sides: &[f32] = if emitter.is_two_sided { &[1.0, -1.0] } else { &[1.0] };
            for side in sides {
                let normal = normal * *side;
                points.push(EmitterPoint { position: position + normal * above, normal, radiance, area });
            }
        }
        points
    }
}
