//! Simple surfaces that stand in for what is around reflectors.

use super::settings::Shells;
use crate::math::Aabb;
use crate::methods::lookup::surround::Surround;
use crate::scene::{Ray, RayDifferential};
use glam::{DMat3, DVec3, Mat3, Vec2, Vec3};

/// What stands in for a layer, about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shell {
    /// All around; looked up by the direction from the centre.
    Around(Surround),
    /// A rectangle.
    Quad(Quad),
}

/// A rectangle, from the centre of the shells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quad {
    middle: Vec3,
    /// Unit, away from the centre.
    normal: Vec3,
    /// From the middle to the right and the upper edge.
    right: Vec3,
    up: Vec3,
}

/// A layer's points are no wider apart than this for a quad to stand in for them: the cosine of the angle to their middle.
const QUAD_CONE: f32 = 0.5;

/// A quad takes the place of a shell that is better by no more than this (a share of the distance): it needs a sixth of its texels.
const QUAD_ADVANTAGE: f32 = 0.01;

/// How much of a quad's size is added around it.
const QUAD_MARGIN: f32 = 0.05;

/// Steps in which points find the sides of a box or cylinder that they belong to.
const FIT_STEPS: usize = 8;

impl Shell {
    /// The one of a kind, or of all kinds the one with the least error, that is nearest to a layer's points (from the centre).
    pub(super) fn fit(kind: Shells, points: &[Vec3]) -> Self {
        let of_kind = |kind: Shells| match kind {
            Shells::Sphere => Some(Self::Around(sphere(points))),
            Shells::Box => Some(Self::Around(bounding_box(points))),
            Shells::Cylinder => Some(Self::Around(cylinder(points))),
            Shells::Quad => Quad::fit(points).map(Self::Quad),
            Shells::Auto => None,
        };
        if kind != Shells::Auto {
            // What surrounds the centre has no quad.
            return of_kind(kind).unwrap_or(Self::Around(sphere(points)));
        }
        let error = |shell: &Self| shell.relative_error(points);
        let around = [Shells::Sphere, Shells::Box, Shells::Cylinder].into_iter().filter_map(of_kind);
        let best = around.min_by(|a, b| error(a).total_cmp(&error(b)));
        let best = best.unwrap_or(Self::Around(Surround::Infinite));
        of_kind(Shells::Quad).filter(|quad| error(quad) <= error(&best) + QUAD_ADVANTAGE).unwrap_or(best)
    }

    /// Whether it is looked up by directions: else by places of a square.
    pub(super) fn is_around(&self) -> bool {
        matches!(self, Self::Around(_))
    }

    /// Where a ray looks it up; its origin is from the centre.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn place(&self, origin: Vec3, direction: Vec3) -> Vec3 {
        match self {
            Self::Around(surround) => surround.direction(Vec3::ZERO, origin, direction).normalize_or(direction),
            Self::Quad(quad) => quad.place(origin, direction),
        }
    }

    /// Where a ray (from the centre) looks it up, and how that changes from pixel to pixel.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn footprint(&self, ray: &Ray, change: &RayDifferential) -> (Vec3, [Vec3; 2]) {
        let place = self.place(ray.origin, ray.direction);
        let beside = |moved: Vec3, turned: Vec3| {
            let direction = (ray.direction + turned).normalize_or(ray.direction);
            self.place(ray.origin + moved, direction) - place
        };
        let RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy } = *change;
        (place, [beside(origin_dx, direction_dx), beside(origin_dy, direction_dy)])
    }

    /// How far a ray goes until it meets the shell; infinite where it never does.
    pub(super) fn distance(&self, origin: Vec3, direction: Vec3) -> f32 {
        match self {
            Self::Around(surround) => surround.distance(Vec3::ZERO, origin, direction),
            Self::Quad(quad) => quad.distance(origin, direction).unwrap_or(f32::INFINITY),
        }
    }

    /// Where a place of a texture lies, as a direction from the centre.
    pub(super) fn towards(&self, place: Vec3) -> Vec3 {
        match self {
            Self::Around(_) => place,
            Self::Quad(quad) => quad.middle + quad.right * place.x + quad.up * place.y,
        }
    }

    /// The root of the mean square of how far the shell is from points in their directions, as shares of their distances.
    fn relative_error(&self, points: &[Vec3]) -> f32 {
        let squares = points.iter().map(|point| {
            let length = point.length();
            let error = (self.distance(Vec3::ZERO, *point / length) - length) / length;
            f64::from((error * error).min(1.0))
        });
        (squares.sum::<f64>() / points.len().max(1) as f64).sqrt() as f32
    }

    /// Its kind, in reports.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Around(Surround::Infinite) => "infinite_shells",
            Self::Around(Surround::Box(_)) => "box_shells",
            Self::Around(Surround::Sphere(_)) => "sphere_shells",
            Self::Around(Surround::Cylinder { .. }) => "cylinder_shells",
            Self::Quad(_) => "quads",
        }
    }
}

fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0f64, 0u32), |(sum, count), value| (sum + f64::from(value), count + 1));
    (count > 0).then(|| (sum / f64::from(count)) as f32)
}

fn sphere(points: &[Vec3]) -> Surround {
    mean(points.iter().map(|point| point.length())).map_or(Surround::Infinite, Surround::Sphere)
}

/// The box whose sides are the means of the points that are nearest to them.
fn bounding_box(points: &[Vec3]) -> Surround {
    let bounds = Aabb::around(points.iter().copied()).with(Vec3::ZERO);
    let mut sides: [f32; 6] =
        std::array::from_fn(|side| if side < 3 { bounds.max[side] } else { bounds.min[side - 3] });
    for _ in 0..FIT_STEPS {
        let nearest = |point: &Vec3| {
            let off = |side: &usize| (point[side % 3] - sides[*side]).abs();
            (0..6).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
        };
        let belongs: Vec<usize> = points.iter().map(nearest).collect();
        sides = std::array::from_fn(|side| {
            let own = points.iter().zip(&belongs).filter(|(_, belongs)| **belongs == side);
            mean(own.map(|(point, _)| point[side % 3])).unwrap_or(sides[side])
        });
    }
    let [x, y, z, least @ ..] = sides;
    Surround::Box(Aabb { min: Vec3::from(least), max: Vec3::new(x, y, z) }.with(Vec3::ZERO))
}

/// The upright cylinder whose side, top and bottom are the means of the points that are nearest to them.
fn cylinder(points: &[Vec3]) -> Surround {
    let aside = |point: &Vec3| Vec2::new(point.x, point.z).length();
    let bounds = Aabb::around(points.iter().copied()).with(Vec3::ZERO);
    let radius = points.iter().map(aside).fold(0.0, f32::max);
    let mut sides = [radius, bounds.min.y, bounds.max.y];
    for _ in 0..FIT_STEPS {
        let from = |point: &Vec3| [aside(point), point.y, point.y];
        let nearest = |point: &Vec3| {
            let off = |side: &usize| (from(point)[*side] - sides[*side]).abs();
            (0..3).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
        };
        let belongs: Vec<usize> = points.iter().map(nearest).collect();
        sides = std::array::from_fn(|side| {
            let own = points.iter().zip(&belongs).filter(|(_, belongs)| **belongs == side);
            mean(own.map(|(point, _)| from(point)[side])).unwrap_or(sides[side])
        });
    }
    let [radius, bottom, top] = sides;
    Surround::Cylinder { radius, bottom: bottom.min(0.0), top: top.max(0.0) }
}

impl Quad {
    /// In the plane that comes nearest to the points, and as wide as they are seen from the centre. None where they are all around
    /// it.
    fn fit(points: &[Vec3]) -> Option<Self> {
        // The plane n . p = 1: what it is off by is relative to its own distance.
        let sum: DVec3 = points.iter().map(|point| point.as_dvec3()).sum();
        let spread = points.iter().map(|point| point.as_dvec3()).fold(DMat3::ZERO, |spread, point| {
            spread + DMat3::from_cols(point * point.x, point * point.y, point * point.z)
        });
        let plane = spread.inverse() * sum;
        let [towards, normal] = [sum, plane].map(|vector| vector.as_vec3().try_normalize());
        let towards = towards?;
        // Points of one plane with the centre have no such plane: then across the direction to their middle.
        let normal = normal.filter(|normal| normal.dot(towards) > QUAD_CONE).unwrap_or(towards);
        if !points.iter().all(|point| point.dot(normal) > QUAD_CONE * point.length()) {
            return None;
        }
        let aside = if normal.y.abs() < 0.9 { Vec3::Y } else { Vec3::X };
        let right = aside.cross(normal).normalize();
        let axes = Mat3::from_cols(right, normal.cross(right), normal);
        let depth = sum.as_vec3().dot(normal) / points.len() as f32;
        // From the centre, points are seen at these places of the plane.
        let seen = |point: &Vec3| {
            let place = axes.transpose() * *point;
            Vec3::new(place.x, place.y, 0.0) * (depth / place.z)
        };
        let bounds = Aabb::around(points.iter().map(seen));
        let half = bounds.size() * (0.5 + QUAD_MARGIN);
        let middle = axes * (bounds.center() + Vec3::Z * depth);
        (half.x > 0.0 && half.y > 0.0).then(|| Self {
            middle,
            normal,
            right: axes.x_axis * half.x,
            up: axes.y_axis * half.y,
        })
    }

    fn distance(&self, origin: Vec3, direction: Vec3) -> Option<f32> {
        let distance = (self.middle - origin).dot(self.normal) / direction.dot(self.normal);
        (distance > 0.0 && distance.is_finite()).then_some(distance)
    }

    /// Rays that do not meet the plane are laid along it and meet it far away (Hakura, Snyder 2001, section 4.2).
    fn place(&self, origin: Vec3, direction: Vec3) -> Vec3 {
        let from_middle = match self.distance(origin, direction) {
            Some(distance) => origin + direction * distance - self.middle,
            None => (direction - self.normal * direction.dot(self.normal)) * (1e3 * self.middle.length()),
        };
        let along = |axis: Vec3| from_middle.dot(axis) / axis.length_squared();
        Vec3::new(along(self.right), along(self.up), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    /// Points where rays from the middle meet a shape.
    fn points(surround: &Surround) -> Vec<Vec3> {
        let mut random = Stream::new(9);
        let mut number = || random.next_between(-1.0, 1.0);
        let directions = (0..3000).map(|_| Vec3::new(number(), number(), number()).normalize());
        directions.map(|direction| direction * surround.distance(Vec3::ZERO, Vec3::ZERO, direction)).collect()
    }

    #[test]
    fn shapes_are_found_again() {
        let room = Surround::Box(Aabb { min: Vec3::new(-3.0, -1.0, -4.0), max: Vec3::new(2.0, 2.0, 5.0) });
        let shapes = [Surround::Sphere(2.5), room, Surround::Cylinder { radius: 2.0, bottom: -1.0, top: 3.0 }];
        for shape in shapes {
            let points = points(&shape);
            let found = Shell::fit(Shells::Auto, &points);
            assert_eq!(found.name(), Shell::Around(shape).name());
            assert!(found.relative_error(&points) < 0.01, "{found:?} for {shape:?}");
            let wrong = if matches!(shape, Surround::Sphere(_)) { Shells::Box } else { Shells::Sphere };
            assert!(Shell::fit(wrong, &points).relative_error(&points) > 0.1);
        }
    }

    #[test]
    fn what_stands_on_one_side_becomes_a_quad() {
        let mut random = Stream::new(2);
        let mut number = || random.next_between(-1.0, 1.0);
        let points: Vec<Vec3> = (0..500).map(|_| Vec3::new(3.0, 0.5 + number(), 0.3 * number())).collect();
        let found = Shell::fit(Shells::Auto, &points);
        assert!(!found.is_around(), "{found:?}");
        for point in &points {
            let place = found.place(Vec3::ZERO, point.normalize());
            assert!(place.abs().max_element() <= 1.0, "{place}");
            // The way there and back.
            assert!(found.towards(place).normalize().distance(point.normalize()) < 1e-5);
        }
        let away = found.place(Vec3::ZERO, Vec3::NEG_X);
        assert!(away.is_finite());
        assert!(found.place(Vec3::ZERO, Vec3::new(-0.1, 1.0, 0.0).normalize()).abs().max_element() > 1.0, "is not met");
    }
}
