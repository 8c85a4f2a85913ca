//! Simple surfaces that stand in for the surroundings of reflectors.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use crate::layered_environment_map::settings::Shells;
use crate::layered_environment_map::texels::{Footprints, TexelLayout};
use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use catoptric_core::scene::{Ray, RayDifferential};
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use glam::{DMat3, DVec3, Mat3, Vec2, Vec3};

/// Simple shape that approximates a layer, about a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shell {
    /// A shape all around; looked up by the direction from the centre.
    Around(ParallaxProxy),
    /// A rectangle.
    Quad(Quad),
}

/// A rectangle, from the centre of the shells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// The middle.
    pub middle: Vec3,
    /// Unit, away from the centre.
    pub normal: Vec3,
    /// The vector from the middle to the right edge.
    pub right: Vec3,
    /// The vector from the middle to the upper edge.
    pub up: Vec3,
}

/// Rays side by side, from a centre, with their changes from pixel to pixel (right, then down): of origins and of
/// directions.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<const LANES: usize> {
    pub(crate) origins: Vec3Lanes<LANES>,
    pub(crate) directions: Vec3Lanes<LANES>,
    moved: [Vec3Lanes<LANES>; 2],
    turned: [Vec3Lanes<LANES>; 2],
}

impl<const LANES: usize> RayLanes<LANES> {
    /// Rays from the centre without differentials.
    #[inline(always)] // for the instructions of its caller
    pub fn sharp(origins: Vec3Lanes<LANES>, directions: Vec3Lanes<LANES>) -> Self {
        Self { origins, directions, moved: [Vec3Lanes::ZERO; 2], turned: [Vec3Lanes::ZERO; 2] }
    }

    /// Scales the rays about the centre by the inverse of these shares: they then meet the shell where they met a shell
    /// that is larger by the shares.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn shrink(&mut self, shares: &Lanes<LANES>) {
        let growth = inverse(shares);
        let [moved_x, moved_y] = &mut self.moved;
        for vectors in [&mut self.origins, moved_x, moved_y] {
            *vectors = *vectors * growth;
        }
    }

    /// The places at distances along them.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn at(&self, distances: &Lanes<LANES>) -> Vec3Lanes<LANES> {
        let mut places = self.origins;
        for axis in 0..3 {
            for lane in 0..LANES {
                places[axis][lane] += self.directions[axis][lane] * distances[lane];
            }
        }
        places
    }

    /// The distances at which neighbouring rays (to the right, below) pass the places at distances along the rays,
    /// measured across the places' directions from the centre.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn widths(&self, distances: &Lanes<LANES>, places: &Vec3Lanes<LANES>) -> [Lanes<LANES>; 2] {
        let mut widths = [Lanes::ZERO; 2];
        for neighbour in 0..2 {
            for lane in 0..LANES {
                let place = places.vector(lane);
                let change = self.moved[neighbour].vector(lane) + self.turned[neighbour].vector(lane) * distances[lane];
                let across2 = change.cross(place).length_squared() / place.length_squared();
                widths[neighbour][lane] = across2.sqrt();
            }
        }
        widths
    }

    /// Reverses rays, where wanted, to start at places further along them.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn turn_round(&mut self, is_turned: &[bool; LANES], distances: &Lanes<LANES>) {
        let further = self.at(distances);
        for axis in 0..3 {
            for lane in 0..LANES {
                let is_turned = is_turned[lane];
                let turned = |of: f32| if is_turned { -of } else { of };
                self.origins[axis][lane] = if is_turned { further[axis][lane] } else { self.origins[axis][lane] };
                self.directions[axis][lane] = turned(self.directions[axis][lane]);
                for neighbour in 0..2 {
                    let change = self.turned[neighbour][axis][lane];
                    let moved = if is_turned { change * distances[lane] } else { 0.0 };
                    self.moved[neighbour][axis][lane] += moved;
                    self.turned[neighbour][axis][lane] = turned(change);
                }
            }
        }
    }

    /// Rays in world space, relative to a centre.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn new(rays: &[(Ray, RayDifferential); LANES], center: Vec3) -> Self {
        let of = |component: &dyn Fn(&(Ray, RayDifferential)) -> Vec3| {
            let mut vectors = [Vec3::ZERO; LANES];
            vectors.iter_mut().zip(rays).for_each(|(vector, ray)| *vector = component(ray));
            Vec3Lanes::new(&vectors)
        };
        Self {
            origins: of(&|(ray, _)| ray.origin - center),
            directions: of(&|(ray, _)| ray.direction),
            moved: [of(&|(_, change)| change.origin_dx), of(&|(_, change)| change.origin_dy)],
            turned: [of(&|(_, change)| change.direction_dx), of(&|(_, change)| change.direction_dy)],
        }
    }
}

/// A layer's points are no wider apart than this for a quad to stand in for them: the cosine of the angle to their
/// middle. Chosen, not measured.
const QUAD_CONE: f32 = 0.5;

/// A quad takes the place of a shell that is better by no more than this (a share of the distance): it needs a sixth of
/// its texels. Chosen, not measured.
const QUAD_ADVANTAGE: f32 = 0.01;

/// The margin around a quad, as a share of its size. Chosen, not measured.
const QUAD_MARGIN: f32 = 0.05;

/// The greatest obliqueness that is assumed of surfaces, as a ratio of a footprint's lengths. Chosen, not measured.
const MAX_OBLIQUE: f32 = 8.0;

/// Steps in which points find the sides of a box or cylinder that they belong to. Chosen, not measured.
const FIT_STEPS: usize = 8;

impl Shell {
    /// The one of a kind, or of all kinds the one with the least error, that is nearest to a layer's points (from the
    /// centre).
    pub fn fit(kind: Shells, points: &[Vec3]) -> Self {
        let of_kind = |kind: Shells| match kind {
            Shells::Sphere => Some(Self::Around(sphere(points))),
            Shells::Box => Some(Self::Around(bounding_box(points))),
            Shells::Cylinder => Some(Self::Around(cylinder(points))),
            Shells::Quad => Quad::fit(points).map(Self::Quad),
            Shells::Auto => None,
        };
        if kind != Shells::Auto {
            // Points all around the centre have no quad.
            return of_kind(kind).unwrap_or(Self::Around(sphere(points)));
        }
        let error = |shell: &Self| shell.relative_error(points);
        let around = [Shells::Sphere, Shells::Box, Shells::Cylinder].into_iter().filter_map(of_kind);
        let best = around.min_by(|a, b| error(a).total_cmp(&error(b)));
        let best = best.unwrap_or(Self::Around(ParallaxProxy::Infinite));
        of_kind(Shells::Quad).filter(|quad| error(quad) <= error(&best) + QUAD_ADVANTAGE).unwrap_or(best)
    }

    /// The layout of its texture, of this many texels a side.
    pub(crate) fn layout(&self, size: u32) -> TexelLayout {
        match self {
            Self::Around(_) => TexelLayout::cube(size),
            Self::Quad(_) => TexelLayout::square(size),
        }
    }

    /// Places at which rays look it up.
    #[inline(always)] // for the instructions of its caller
    pub fn places<const LANES: usize>(&self, rays: &RayLanes<LANES>) -> Vec3Lanes<LANES> {
        self.places_of(&rays.origins, &rays.directions)
    }

    #[inline(always)] // for the instructions of its caller
    fn places_of<const LANES: usize>(
        &self,
        origins: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> Vec3Lanes<LANES> {
        match self {
            Self::Around(surround) => {
                let mut found = surround.directions(Vec3::ZERO, origins, directions);
                normalize(&mut found, directions);
                found
            }
            Self::Quad(quad) => quad.places(origins, directions),
        }
    }

    /// The coordinates by which places are looked up, seen from the centre: directions of any length, or places of a
    /// square.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn seen_at<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> Vec3Lanes<LANES> {
        match self {
            Self::Around(_) => *places,
            Self::Quad(quad) => quad.places(&Vec3Lanes::ZERO, places),
        }
    }

    /// The distances along rays at which they leave the shell, scaled about the centre by shares.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn distances_grown<const LANES: usize>(
        &self,
        rays: &RayLanes<LANES>,
        shares: &Lanes<LANES>,
    ) -> Lanes<LANES> {
        let origins = rays.origins * inverse(shares);
        self.distances(&origins, &rays.directions) * *shares
    }

    /// The factors that scale the shell about the centre so that it goes through places.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn shell_scale<const LANES: usize>(&self, places: &Vec3Lanes<LANES>) -> Lanes<LANES> {
        match self {
            Self::Around(surround) => surround.shares(places),
            Self::Quad(quad) => {
                let normal = quad.normal / quad.middle.dot(quad.normal);
                let mut shares = Lanes::ZERO;
                for lane in 0..LANES {
                    shares[lane] = places.vector(lane).dot(normal).max(0.0);
                }
                shares
            }
        }
    }

    /// Places at which rays look it up, and their changes from pixel to pixel.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn footprints<const LANES: usize>(&self, rays: &RayLanes<LANES>) -> Footprints<LANES> {
        let places = self.places(rays);
        let changes = [self.change(rays, &places, 0), self.change(rays, &places, 1)];
        Footprints { places, changes }
    }

    /// Moves footprints on shells around the centre to the places as seen from there, and limits them, by the distances
    /// at which neighbours pass the places, to those of surfaces that are not too oblique.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn hold_at<const LANES: usize>(
        &self,
        footprints: &mut Footprints<LANES>,
        places: &Vec3Lanes<LANES>,
        widths: &[Lanes<LANES>; 2],
    ) {
        let Self::Around(_) = self else { return };
        for lane in 0..LANES {
            let place = places.vector(lane);
            let inverse = 1.0 / place.length();
            for axis in 0..3 {
                footprints.places[axis][lane] = place[axis] * inverse;
            }
            for (change, width) in footprints.changes.iter_mut().zip(widths) {
                let most = MAX_OBLIQUE * width[lane] * inverse;
                let length2 = change.vector(lane).length_squared();
                let scale = if length2 > most * most { most / length2.sqrt() } else { 1.0 };
                change.iter_mut().for_each(|along| along[lane] *= scale);
            }
        }
    }

    /// The difference between `places`, where rays look the shell up, and those of their neighbours: to the right (0)
    /// or down (1).
    #[inline(always)] // for the instructions of its caller
    fn change<const LANES: usize>(
        &self,
        rays: &RayLanes<LANES>,
        places: &Vec3Lanes<LANES>,
        neighbour: usize,
    ) -> Vec3Lanes<LANES> {
        let (mut origins, mut directions) = (rays.origins, rays.directions);
        for axis in 0..3 {
            for lane in 0..LANES {
                origins[axis][lane] += rays.moved[neighbour][axis][lane];
                directions[axis][lane] += rays.turned[neighbour][axis][lane];
            }
        }
        normalize(&mut directions, &rays.directions);
        let changes = self.places_of(&origins, &directions);
        changes - *places
    }

    /// The distances along rays (by their origins and directions) at which they meet the shell.
    #[inline(always)] // for the instructions of its caller
    fn distances<const LANES: usize>(&self, origins: &Vec3Lanes<LANES>, directions: &Vec3Lanes<LANES>) -> Lanes<LANES> {
        match self {
            Self::Around(surround) => surround.distances(Vec3::ZERO, origins, directions),
            Self::Quad(quad) => {
                let mut distances = Lanes::splat(f32::INFINITY);
                for lane in 0..LANES {
                    let found = quad.distance(origins.vector(lane), directions.vector(lane));
                    distances[lane] = found.unwrap_or(f32::INFINITY);
                }
                distances
            }
        }
    }

    /// The distance along a ray at which it meets the shell; infinite if it never does.
    pub fn distance(&self, origin: Vec3, direction: Vec3) -> f32 {
        match self {
            Self::Around(surround) => surround.distance(Vec3::ZERO, origin, direction),
            Self::Quad(quad) => quad.distance(origin, direction).unwrap_or(f32::INFINITY),
        }
    }

    /// Direction from the centre to a place of a texture.
    pub fn towards(&self, place: Vec3) -> Vec3 {
        match self {
            Self::Around(_) => place,
            Self::Quad(quad) => quad.middle + quad.right * place.x + quad.up * place.y,
        }
    }

    /// The root of the mean square of how far the shell is from points in their directions, as shares of their
    /// distances.
    pub fn relative_error(&self, points: &[Vec3]) -> f32 {
        let squares = points.iter().map(|point| {
            let length = point.length();
            let error = (self.distance(Vec3::ZERO, *point / length) - length) / length;
            f64::from((error * error).min(1.0))
        });
        (squares.sum::<f64>() / points.len().max(1) as f64).sqrt() as f32
    }

    /// The name of its kind, in reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Around(ParallaxProxy::Infinite) => "infinite_shells",
            Self::Around(ParallaxProxy::Box(_)) => "box_shells",
            Self::Around(ParallaxProxy::Sphere(_)) => "sphere_shells",
            Self::Around(ParallaxProxy::Cylinder { .. }) => "cylinder_shells",
            Self::Quad(_) => "quads",
        }
    }
}

fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0f64, 0u32), |(sum, count), value| (sum + f64::from(value), count + 1));
    (count > 0).then(|| (sum / f64::from(count)) as f32)
}

fn sphere(points: &[Vec3]) -> ParallaxProxy {
    mean(points.iter().map(|point| point.length())).map_or(ParallaxProxy::Infinite, ParallaxProxy::Sphere)
}

/// The box whose sides are the means of the points that are nearest to them.
fn bounding_box(points: &[Vec3]) -> ParallaxProxy {
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
    ParallaxProxy::Box(Aabb { min: Vec3::from(least), max: Vec3::new(x, y, z) }.with(Vec3::ZERO))
}

/// The upright cylinder whose side, top and bottom are the means of the points that are nearest to them.
fn cylinder(points: &[Vec3]) -> ParallaxProxy {
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
    ParallaxProxy::Cylinder { radius, bottom: bottom.min(0.0), top: top.max(0.0) }
}

impl Quad {
    /// Fits a rectangle in the plane that comes nearest to the points, as wide as they are seen from the centre. `None`
    /// if they are all around it.
    fn fit(points: &[Vec3]) -> Option<Self> {
        // The plane is n . p = 1: errors are relative to its own distance.
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
        // The places of the plane at which points are seen from the centre.
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
    #[inline(always)] // for the instructions of its caller
    fn places<const LANES: usize>(
        &self,
        origins: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> Vec3Lanes<LANES> {
        let mut places = Vec3Lanes::ZERO;
        let (right, up) = (self.right / self.right.length_squared(), self.up / self.up.length_squared());
        let far = 1e3 * self.middle.length();
        for lane in 0..LANES {
            let (origin, direction) = (origins.vector(lane), directions.vector(lane));
            let (height, towards) = ((self.middle - origin).dot(self.normal), direction.dot(self.normal));
            let distance = height / towards;
            let meets = distance > 0.0 && distance < f32::INFINITY;
            let met = origin + direction * distance - self.middle;
            let laid = (direction - self.normal * towards) * far;
            places[0][lane] = if meets { met.dot(right) } else { laid.dot(right) };
            places[1][lane] = if meets { met.dot(up) } else { laid.dot(up) };
        }
        places
    }
}

#[inline(always)] // for the instructions of its caller
fn inverse<const LANES: usize>(numbers: &Lanes<LANES>) -> Lanes<LANES> {
    let mut inverse = Lanes::ZERO;
    for lane in 0..LANES {
        inverse[lane] = 1.0 / numbers[lane];
    }
    inverse
}

/// Gives vectors the length 1; where that cannot be they become the others.
#[inline(always)] // for the instructions of its caller
fn normalize<const LANES: usize>(vectors: &mut Vec3Lanes<LANES>, others: &Vec3Lanes<LANES>) {
    let mut scale = [0.0; LANES];
    for lane in 0..LANES {
        let [x, y, z] = vectors.components(lane);
        scale[lane] = 1.0 / (x * x + y * y + z * z).sqrt();
    }
    for axis in 0..3 {
        for lane in 0..LANES {
            let unit = vectors[axis][lane] * scale[lane];
            let is_unit = scale[lane] > 0.0 && scale[lane] < f32::INFINITY;
            vectors[axis][lane] = if is_unit { unit } else { others[axis][lane] };
        }
    }
}
