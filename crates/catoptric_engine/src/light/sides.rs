//! Media on both sides of a surface of a body, within other bodies or touching them: how they refract and absorb.
//!
//! Where bodies overlap, one of them fills the place: that of the greater priority (Schmidt, Budge 2002, Simple nested
//! dielectrics in ray traced images), or else the smaller one. Surfaces of the others are not met there. Faces of
//! several bodies in one place are one interface, of what lies before all of them and what lies behind all.

use super::bodies::Bodies;
use super::tracer::{Crossing, Tracer};
use crate::optics::step::relative_index;
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Material, Ray, Scene};
use glam::Vec3;

/// Directions in which surfaces are counted about a point, to tell which bodies it is in: the planes and axes of few
/// models lie along them.
const DIRECTIONS: [Vec3; 3] =
    [Vec3::new(0.267, 0.863, 0.429), Vec3::new(-0.771, 0.339, 0.539), Vec3::new(0.591, -0.467, -0.658)];

/// Surfaces in one place, at most.
const MOST_IN_ONE_PLACE: usize = 8;

/// The least cosine at which surfaces in one place are sought along a ray.
const LEAST_COSINE: f32 = 0.02;

/// The media on both sides of a surface that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sides {
    /// Index of refraction before the surface over that behind it, over what that would be in vacuum.
    pub(crate) eta_factor: f32,
    /// Absorption a unit of length before it and behind it.
    pub(crate) absorption: [Vec3; 2],
    /// The bodies behind it.
    pub(crate) behind: Bodies,
    /// Both sides are the same: nothing happens to light.
    pub(crate) are_same: bool,
}

impl Sides {
    /// The sides of a surface that a ray meets on its outer side or from within, as if no other body were near;
    /// `absorption` is that of the medium about it.
    #[inline(always)]
    pub(crate) fn alone(material: &Material, outside: bool, absorption: Vec3) -> Self {
        let absorption = match (material.has_inside(), outside) {
            (false, _) => [absorption; 2],
            (true, true) => [absorption, material.absorption],
            (true, false) => [material.absorption, Vec3::ZERO],
        };
        Self { eta_factor: 1.0, absorption, behind: Bodies::default(), are_same: false }
    }
}

/// Surfaces in one place.
#[derive(Default)]
struct InOnePlace {
    crossings: [Crossing; MOST_IN_ONE_PLACE],
    count: usize,
}

impl InOnePlace {
    /// Adds one, if it is not there: rays meet all triangles about an edge.
    fn add(&mut self, crossing: Crossing) {
        let is_same = |known: &Crossing| (known.body, known.leaves) == (crossing.body, crossing.leaves);
        if self.count < MOST_IN_ONE_PLACE && !self.all().iter().any(is_same) {
            self.crossings[self.count] = crossing;
            self.count += 1;
        }
    }

    fn all(&self) -> &[Crossing] {
        &self.crossings[..self.count]
    }
}

impl Tracer {
    /// The bodies that a point is in: those whose surfaces say so that are met from there in several directions.
    pub(crate) fn bodies_at(&self, scene: &Scene, point: Vec3) -> Bodies {
        let mut bodies = Bodies::default();
        if self.bodies().about(point).next().is_none() {
            return bodies;
        }
        let crossings = DIRECTIONS.map(|direction| {
            let mut crossings = Vec::new();
            let ray = Ray { origin: point, direction: direction.normalize() };
            self.visit_crossings(scene, &ray, f32::INFINITY, |crossing| crossings.push(crossing));
            crossings
        });
        for body in self.bodies().about(point) {
            let is_within = |crossings: &Vec<Crossing>| {
                let of_body = crossings.iter().filter(|crossing| crossing.body == body);
                of_body.map(|crossing| if crossing.leaves { 1 } else { -1 }).sum::<i32>() > 0
            };
            if crossings.iter().all(is_within) {
                bodies = bodies.with(body);
            }
        }
        bodies
    }

    /// The sides of a point of a body that a ray meets, which runs within some bodies.
    pub(crate) fn sides(&self, scene: &Scene, ray: &Ray, within: &Bodies, point: &SurfacePoint) -> Sides {
        let outside = ray.direction.dot(point.geometric_normal) <= 0.0;
        let (mut before, mut behind) = (*within, *within);
        for Crossing { body, leaves, .. } in self.in_one_place(scene, ray, point).all() {
            if !leaves {
                behind = behind.with(*body);
                continue;
            }
            let material = |body: u32| scene.objects[body as usize].material;
            let all = behind.all();
            // A body's inner walls may be a body for themselves.
            let known = all.iter().position(|known| known == body);
            match known.or_else(|| all.iter().position(|known| material(*known) == material(*body))) {
                Some(index) => behind = behind.without(index),
                // The ray began within it, or it is open.
                None => before = before.with(*body),
            }
        }
        let filling = [before, behind].map(|bodies| self.bodies().filling(&bodies));
        let [first, second] = filling.map(|body| body.map(|body| scene.material_of(body)));
        let index = |material: Option<&Material>| material.map_or(1.0, |material| material.ior);
        let absorption = [first, second].map(|material| material.map_or(Vec3::ZERO, |material| material.absorption));
        let own = relative_index(scene.material_of(point.object).ior, outside);
        let are_equal =
            |first: &Material, second: &Material| (first.ior, first.absorption) == (second.ior, second.absorption);
        let are_same =
            filling[0] == filling[1] || first.zip(second).is_some_and(|(first, second)| are_equal(first, second));
        Sides { eta_factor: index(first) / index(second) / own, absorption, behind, are_same }
    }

    /// The surfaces of bodies where a ray meets one of them: all that rays which go on from there do not meet any more.
    fn in_one_place(&self, scene: &Scene, ray: &Ray, point: &SurfacePoint) -> InOnePlace {
        let mut found = InOnePlace::default();
        if self.bodies().meet() {
            let cosine = ray.direction.dot(point.geometric_normal).abs().max(LEAST_COSINE);
            let reach = Self::departure_offset(point) / cosine;
            let start = Ray { origin: point.position - ray.direction * (0.25 * reach), direction: ray.direction };
            let mut crossings = InOnePlace::default();
            self.visit_crossings(scene, &start, 1.25 * reach, |crossing| crossings.add(crossing));
            crossings.crossings[..crossings.count].sort_by(|one, other| one.distance.total_cmp(&other.distance));
            found = crossings;
        }
        let leaves = ray.direction.dot(point.geometric_normal) > 0.0;
        if let Some(body) = self.bodies().of(point.object) {
            found.add(Crossing { body, distance: 0.0, leaves });
        }
        found
    }
}
