//! The octree's candidates against a search through all rays in double precision.

use catoptric_core::math::Aabb;
use catoptric_core::math::random::Stream;
use catoptric_projection::find::ray_map::{Lines, RayTree};
use catoptric_testkit::scenes::random_vector as vector;
use glam::{DVec3, Vec3};

/// Rays along a side of a family's grid.
const SIDE: usize = 20;

/// A look-up in every cell down to the deepest divides all of them.
const LOOKUPS: usize = 90;

/// A family of rays, with the eight neighbours of each on a grid.
struct RayFamily {
    rays: Vec<(Vec3, Vec3)>,
    neighbours: Vec<Vec<u32>>,
    lines: Lines,
}

impl RayFamily {
    /// View rays after a mirror ball, seen from outside or from inside.
    fn reflected(random: &mut Stream, inside: bool) -> Self {
        let towards = vector(random).normalize();
        let eye =
            towards * f64::from(if inside { random.next_between(0.0, 0.8) } else { random.next_between(1.5, 4.0) });
        let side = towards.any_orthonormal_vector();
        let up = towards.cross(side);
        let width = if inside { 0.8 } else { 0.9 / eye.length() };
        let mut rays = Vec::new();
        for place in 0..SIDE * SIDE {
            let [x, y] = [place % SIDE, place / SIDE].map(|k| (k as f64 / (SIDE - 1) as f64 * 2.0 - 1.0) * width * 0.7);
            let direction = (side * x + up * y - towards).normalize();
            // |eye + t direction| = 1.
            let half = eye.dot(direction);
            let root = (half * half - eye.length_squared() + 1.0).max(0.0).sqrt();
            let at = eye + direction * (-half + if inside { root } else { -root });
            let normal = at.normalize();
            let outgoing = direction - normal * (2.0 * direction.dot(normal));
            rays.push((at.as_vec3(), outgoing.normalize().as_vec3()));
        }
        let neighbours: Vec<Vec<u32>> = (0..SIDE * SIDE).map(around).collect();
        let lines = Lines::new(rays.iter().copied(), &neighbours);
        Self { rays, neighbours, lines }
    }

    /// Distances along the ray and squared from it.
    fn offset(&self, ray: usize, point: DVec3) -> (f64, f64) {
        let (origin, direction) = self.rays[ray];
        let direction = direction.as_dvec3().normalize();
        let relative = point - origin.as_dvec3();
        (relative.dot(direction), relative.cross(direction).length_squared())
    }

    /// Points near a ray, in front of it, and points anywhere.
    fn point(&self, random: &mut Stream, case: usize) -> Vec3 {
        if case.is_multiple_of(2) {
            return vector(random).as_vec3() * 3.0;
        }
        let ray = (random.next_unit() * self.rays.len() as f32) as usize;
        let (origin, direction) = self.rays[ray];
        let point = origin + direction * random.next_between(0.05, 2.5) + vector(random).as_vec3() * 0.05;
        point.clamp(Vec3::splat(-3.0), Vec3::splat(3.0))
    }
}

fn around(place: usize) -> Vec<u32> {
    let (x, y) = ((place % SIDE) as i32, (place / SIDE) as i32);
    let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
    let inside =
        |&(a, b): &(i32, i32)| (0..SIDE as i32).contains(&a) && (0..SIDE as i32).contains(&b) && (a, b) != (x, y);
    steps.filter(inside).map(|(a, b)| (b * SIDE as i32 + a) as u32).collect()
}

fn bounds() -> Aabb {
    Aabb { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) }
}

#[test]
fn leaves_hold_the_nearest_rays_that_start_before_the_point() {
    let mut random = Stream::new(77);
    let (mut found, mut held, mut asked) = (0, 0, 0);
    for family in 0..6 {
        let count = [1, 3, 8][family / 2];
        let family = RayFamily::reflected(&mut random, family % 2 == 1);
        let tree = RayTree::new(&family.lines, &bounds(), count);
        for case in 0..30 {
            let point = family.point(&mut random, case);
            let mut expected: Vec<(f64, u32)> = (0..family.rays.len())
                .map(|ray| (family.offset(ray, point.as_dvec3()), ray as u32))
                .filter(|((along, _), _)| *along > 0.0)
                .map(|((_, distance2), ray)| (distance2, ray))
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            expected.truncate(count);
            found += expected.len();
            for lookup in 0..LOOKUPS {
                let candidates = tree.candidates(&family.lines, point).unwrap();
                let all = expected.iter().all(|(_, ray)| candidates.contains(ray));
                assert!(all, "case {case}, look-up {lookup}, {point}: {expected:?} in {candidates:?}");
            }
            held += tree.candidates(&family.lines, point).unwrap().len();
            asked += family.rays.len();
        }
    }
    assert!(found > 300 && held * 3 < asked, "{found} found, {held} of {asked} held");
}

#[test]
fn nothing_is_known_outside_and_no_rays_have_no_candidates() {
    let mut random = Stream::new(5);
    let family = RayFamily::reflected(&mut random, false);
    let tree = RayTree::new(&family.lines, &bounds(), 1);
    for outside in [Vec3::X * 1e4, Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::NAN, 0.0)] {
        assert!(tree.candidates(&family.lines, outside).is_none(), "{outside}");
    }
    let none = Lines::new(std::iter::empty(), &[]);
    let point = Aabb { min: Vec3::ONE, max: Vec3::ONE };
    let tree = RayTree::new(&none, &point, 3);
    assert!(none.is_empty() && (0..LOOKUPS).all(|_| tree.candidates(&none, Vec3::ONE).unwrap().is_empty()));
}

#[test]
fn offsets_and_neighbours_are_those_of_the_rays() {
    let family = RayFamily::reflected(&mut Stream::new(12), true);
    let mut random = Stream::new(13);
    for ray in 0..family.rays.len() {
        let point = vector(&mut random).as_vec3() * 3.0;
        let (along, distance2) = family.offset(ray, point.as_dvec3());
        let offset = family.lines.offset(ray as u32, point);
        assert!((f64::from(offset.along) - along).abs() < 1e-5);
        assert!((f64::from(offset.across.length()) - distance2.sqrt()).abs() < 1e-5);
        assert_eq!(family.lines.neighbours(ray as u32), family.neighbours[ray]);
    }
}
