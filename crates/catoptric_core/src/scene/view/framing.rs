//! A camera for scenes that bring none.

use super::super::Scene;
use super::Camera;
use crate::math::Aabb;
use crate::math::portable::PortableMath;
use crate::parallel;
use glam::{Mat3A, Vec3, Vec3A, Vec3Swizzles};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// The vertical field of view from outside, and from within what surrounds the eye.
const FOV_DEG: f32 = 40.0;
const FOV_WITHIN_DEG: f32 = 65.0;
/// The share of the picture's width or height that the silhouette fills.
const FILLED: f32 = 0.8;
/// The share of all directions in which a scene shows its front around an eye that it surrounds.
const SURROUNDING_SHARE: f32 = 0.9;
/// The least side of a room, in metres.
const LEAST_ROOM: f32 = 2.0;
/// How many different triangles are to be seen within for each one from outside: of fronts alone in scenes as large as
/// rooms, which may be empty; of all in smaller ones, where chests, bottles and bodies turned inside out are common.
const LEAST_SHOWN_IN_ROOM: f32 = 0.5;
const LEAST_SHOWN_WITHIN: f32 = 1.5;
/// Directions along each edge of a cube around the eye.
const RESOLUTION: usize = 12;

impl Scene {
    /// A camera that shows the whole scene: its silhouette, from a little above, fills four fifths of the width or
    /// height of a picture of this shape (width by height). A scene that surrounds its middle is seen from within.
    pub fn framing(&self, aspect_ratio: f32) -> Camera {
        let aspect_ratio = if aspect_ratio.is_finite() { aspect_ratio.clamp(1e-3, 1e3) } else { 1.0 };
        self.within().unwrap_or_else(|| self.outside(aspect_ratio, FOV_DEG, false))
    }

    /// A camera that still shows the whole scene when it is turned to any side about the upright line through the
    /// middle of the scene's box: what the scene sweeps as it turns fills four fifths of the width or height of a
    /// picture of this shape (width by height). Within a scene that surrounds its middle it looks at the middle. The
    /// field of view is vertical, in degrees; `None`: as [`Self::framing`] has it.
    pub fn framing_all_round(&self, aspect_ratio: f32, fov_deg: Option<f32>) -> Camera {
        let aspect_ratio = if aspect_ratio.is_finite() { aspect_ratio.clamp(1e-3, 1e3) } else { 1.0 };
        if self.within().is_none() {
            return self.outside(aspect_ratio, fov_deg.unwrap_or(FOV_DEG), true);
        }
        let (center, size) = (self.bounds.center(), self.bounds.size());
        let eye = center + Vec3::Z * (0.75 * 0.5 * size.x.min(size.z));
        Camera::look_at("framing", eye, center, Vec3::Y, fov_deg.unwrap_or(FOV_WITHIN_DEG))
    }

    /// From a little above, of the scene as it stands, or of all that it sweeps as it turns about its middle.
    fn outside(&self, aspect_ratio: f32, fov_deg: f32, turns: bool) -> Camera {
        let center = self.bounds.center();
        let size = match self.bounds.diagonal() {
            size if size > 0.0 && size.is_finite() => size,
            _ => 1.0,
        };
        let towards_eye = Vec3::new(0.45, 0.3, 0.85).normalize();
        let mut camera = Camera::look_at("framing", center + towards_eye * size, center, Vec3::Y, fov_deg);
        // In units of the scene's size, so that all sizes are framed alike.
        let axes = camera.world_from_camera.matrix3.transpose();
        let tangent = (fov_deg.to_radians() * 0.5).tangent() * FILLED;
        let tangents = [tangent * aspect_ratio, tangent];
        // Planes through the picture's four edges, pushed to the outermost point: the frustum's tip is where they meet.
        let mut outermost = [f32::NEG_INFINITY; 4];
        let mut nearest = f32::NEG_INFINITY;
        let towards = camera.world_from_camera.matrix3;
        for corner in self.triangles.iter().flatten() {
            let offset = (self.positions[*corner as usize] - center) / size;
            let at = axes * Vec3A::from(offset);
            // The farthest that a point on a circle about the upright line comes.
            let turned = |along: Vec3A| along.y * offset.y + along.xz().length() * offset.xz().length();
            nearest = nearest.max(if turns { turned(towards.z_axis) } else { at.z });
            for (axis, tangent) in tangents.into_iter().enumerate() {
                for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                    let plane = &mut outermost[2 * axis + side];
                    *plane = plane.max(match turns {
                        true => turned(towards.col(axis) * sign + towards.z_axis * tangent),
                        false => sign * at[axis] + tangent * at.z,
                    });
                }
            }
        }
        let [right, left, up, down] = outermost;
        let distance = ((right + left) / (2.0 * tangents[0])).max((up + down) / (2.0 * tangents[1]));
        // A flat scene that is seen along itself would touch the eye.
        let distance = distance.max(nearest + 1e-3);
        if distance.is_finite() {
            let eye = Vec3A::new((right - left) * 0.5, (up - down) * 0.5, distance);
            camera.world_from_camera.translation = Vec3A::from(center) + axes.transpose() * eye * size;
        }
        camera
    }

    /// A camera within, if the scene surrounds most places in it and shows enough there for what it shows from outside,
    /// as rooms do and cups do not: at the back of the widest view of one.
    fn within(&self) -> Option<Camera> {
        let places: Vec<Vec3> = (0..9)
            .map(|index| Vec3::new(0.25 + 0.25 * (index % 3) as f32, 0.5, 0.25 + 0.25 * (index / 3) as f32))
            .map(|share| self.bounds.min + self.bounds.size() * share)
            .collect();
        let around = parallel::map_collect(places.len(), |index| {
            let place = places[index];
            self.may_surround(place).then(|| Surroundings::of(self, place)).flatten()
        });
        // A box with an open side surrounds some places at its back.
        if 2 * around.iter().flatten().count() <= places.len() {
            return None;
        }
        let widest = |surroundings: &Surroundings| surroundings.mean_distance(Vec3::ZERO, -1.0);
        let surroundings = around.into_iter().flatten().max_by(|a, b| widest(a).total_cmp(&widest(b)))?;
        let is_large = self.bounds.size().min_element() >= LEAST_ROOM;
        let least_ratio = if is_large { LEAST_SHOWN_IN_ROOM } else { LEAST_SHOWN_WITHIN };
        if ratio_of_different(&surroundings.fronts, &self.triangles_from_outside(is_large)) < least_ratio {
            return None;
        }
        let ahead = (0..16).map(|index| (index as f32 * (TAU / 16.0)).sine_cosine());
        let ahead = ahead.map(|(sine, cosine)| Vec3::new(sine, 0.0, cosine));
        let width = |direction: &Vec3| surroundings.mean_distance(*direction, (PI / 6.0).cosine());
        let ahead = ahead.max_by(|a, b| width(a).total_cmp(&width(b)))?;
        let eye = surroundings.place - ahead * (0.75 * surroundings.least_distance(-ahead, (PI / 9.0).cosine()));
        Some(Camera::look_at("framing", eye, eye + ahead, Vec3::Y, FOV_WITHIN_DEG))
    }

    /// The triangles that are seen from six sides, or those of them that show their fronts; one for each line of sight.
    fn triangles_from_outside(&self, fronts_alone: bool) -> Vec<u32> {
        // From the middle of the scene's box, in its diagonals.
        const DISTANCE: f32 = 4.0;
        let (center, size) = (self.bounds.center(), self.bounds.diagonal());
        let half = Vec3A::from(self.bounds.size() * 0.5).max(Vec3A::splat(1e-3 * size));
        let mut triangles = Vec::new();
        for side in 0..6 {
            let axes = axes_towards(side);
            let place = center - Vec3::from(axes.z_axis) * (DISTANCE * size);
            // The box fills the picture.
            let scale = |axis: Vec3A| axis * ((DISTANCE - 0.5) * size / axis.abs().dot(half));
            let axes = Mat3A::from_cols(scale(axes.x_axis), scale(axes.y_axis), axes.z_axis);
            let counts = |seen: &&Seen| seen.is_front || (seen.is_hit() && !fronts_alone);
            triangles.extend(self.seen_from(place, axes).iter().filter(counts).map(|seen| seen.triangle));
        }
        triangles
    }

    /// Looks at all triangles from a place, along the last of these axes.
    fn seen_from(&self, place: Vec3, axes: Mat3A) -> [Seen; RESOLUTION * RESOLUTION] {
        let (to_view, size) = (axes.transpose(), self.bounds.diagonal());
        let mut seen = [Seen { distance: f32::INFINITY, triangle: 0, is_front: false }; RESOLUTION * RESOLUTION];
        for (index, corners) in self.triangles.iter().enumerate() {
            let corners = corners.map(|vertex| to_view * Vec3A::from((self.positions[vertex as usize] - place) / size));
            look_at_triangle(corners.map(Vec3::from), index as u32, &mut seen);
        }
        seen
    }

    /// True if the triangles that show their front to a place could cover most directions from it.
    fn may_surround(&self, place: Vec3) -> bool {
        let mut covered = 0.0;
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|vertex| self.positions[vertex as usize] - place);
            // Van Oosterom and Strackee 1983; negative where the front is seen.
            let lengths = [a, b, c].map(Vec3::length);
            let volume = a.dot(b.cross(c));
            if volume < 0.0 {
                let [la, lb, lc] = lengths;
                let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
                covered += if below > 0.0 { 2.0 * (-volume / below).min(FRAC_PI_2) } else { PI };
                if covered > SURROUNDING_SHARE * 4.0 * PI {
                    return true;
                }
            }
        }
        false
    }
}

/// The nearest triangle in one direction.
#[derive(Clone, Copy)]
struct Seen {
    /// In the units of the triangles' corners; infinite where there is none.
    distance: f32,
    triangle: u32,
    is_front: bool,
}

impl Seen {
    fn is_hit(&self) -> bool {
        self.distance.is_finite()
    }
}

/// How far it is to the surfaces around a place, in directions all around.
struct Surroundings {
    place: Vec3,
    /// Unit directions and distances.
    distances: Vec<(Vec3, f32)>,
    /// The triangles whose fronts are seen, one for each direction that has one.
    fronts: Vec<u32>,
}

impl Surroundings {
    /// The surroundings of a place, if nearly everywhere the scene's front is seen from it.
    fn of(scene: &Scene, place: Vec3) -> Option<Self> {
        let mut distances = Vec::with_capacity(6 * RESOLUTION * RESOLUTION);
        let (mut fronts, size) = (Vec::new(), scene.bounds.diagonal());
        for side in 0..6 {
            let axes = axes_towards(side);
            for (index, seen) in scene.seen_from(place, axes).into_iter().enumerate() {
                fronts.extend(seen.is_front.then_some(seen.triangle));
                let direction = (axes * Vec3A::from(direction(index))).normalize();
                // Nothing is to be seen through an opening.
                distances.push((direction.into(), if seen.is_hit() { seen.distance * size } else { 0.0 }));
            }
        }
        (fronts.len() as f32 >= SURROUNDING_SHARE * distances.len() as f32).then_some(Self { place, distances, fronts })
    }

    fn towards(&self, direction: Vec3, least_cosine: f32) -> impl Iterator<Item = f32> {
        let within = move |(other, _): &&(Vec3, f32)| other.dot(direction) >= least_cosine;
        self.distances.iter().filter(within).map(|(_, distance)| *distance)
    }

    fn mean_distance(&self, direction: Vec3, least_cosine: f32) -> f32 {
        let (sum, count) = self.towards(direction, least_cosine).fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
        sum / count.max(1) as f32
    }

    fn least_distance(&self, direction: Vec3, least_cosine: f32) -> f32 {
        self.towards(direction, least_cosine).fold(f32::INFINITY, f32::min).min(self.mean_distance(Vec3::ZERO, -1.0))
    }
}

/// The number of different triangles among the first, for each among as many of the second; infinite where the second
/// are too few to tell.
fn ratio_of_different(first: &[u32], second: &[u32]) -> f32 {
    if second.len() * 10 < first.len() {
        return f32::INFINITY;
    }
    let count = first.len().min(second.len());
    let different = |all: &[u32]| {
        let mut some: Vec<u32> = (0..count).map(|index| all[index * all.len() / count]).collect();
        some.sort_unstable();
        some.dedup();
        some.len().max(1)
    };
    different(first) as f32 / different(second) as f32
}

/// Axes to the right, downwards and ahead of a view along one of the six axes.
fn axes_towards(side: usize) -> Mat3A {
    let axes = [Vec3A::X, Vec3A::Y, Vec3A::Z];
    let forward = axes[side / 2] * if side.is_multiple_of(2) { 1.0 } else { -1.0 };
    let [across, down] = if side.is_multiple_of(2) { [1, 2] } else { [2, 1] };
    Mat3A::from_cols(axes[(side / 2 + across) % 3], axes[(side / 2 + down) % 3], forward)
}

/// A direction on a side of the cube; its third coordinate is 1.
fn direction(index: usize) -> Vec3 {
    let at = |cell: usize| (cell as f32 + 0.5) * (2.0 / RESOLUTION as f32) - 1.0;
    Vec3::new(at(index % RESOLUTION), at(index / RESOLUTION), 1.0)
}

/// Keeps a triangle where it is nearer than what was seen before. Of two in one place the one counts that shows its
/// front.
fn look_at_triangle(corners: [Vec3; 3], triangle: u32, seen: &mut [Seen]) {
    const SAME_PLACE: f32 = 1e-5;
    let [a, b, c] = corners;
    if corners.iter().all(|corner| corner.z <= 0.0) {
        return;
    }
    let cells = match corners.iter().all(|corner| corner.z > 1e-6) {
        true => Aabb::around(corners.map(|corner| corner / corner.z)),
        false => Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE },
    };
    let cell = |at: f32| ((at + 1.0) * (0.5 * RESOLUTION as f32) - 0.5).clamp(-1.0, RESOLUTION as f32);
    let range = |min: f32, max: f32| (cell(min).ceil().max(0.0) as usize)..(cell(max).floor() + 1.0).max(0.0) as usize;
    let normal = (b - a).cross(c - a);
    for row in range(cells.min.y, cells.max.y) {
        for column in range(cells.min.x, cells.max.x) {
            if row >= RESOLUTION || column >= RESOLUTION {
                continue;
            }
            let index = row * RESOLUTION + column;
            let direction = direction(index);
            let volumes = [(b, c), (c, a), (a, b)].map(|(from, to)| direction.dot(from.cross(to)));
            let is_met = volumes.iter().all(|volume| *volume >= 0.0) || volumes.iter().all(|volume| *volume <= 0.0);
            let (along, ahead) = (normal.dot(direction), normal.dot(a));
            let depth = ahead / along;
            if is_met && depth.is_finite() && depth > 0.0 {
                let distance = depth * direction.length();
                let before = &mut seen[index];
                let is_front = along < 0.0;
                let change = distance / before.distance - 1.0;
                let is_better = if is_front && !before.is_front { SAME_PLACE } else { -SAME_PLACE };
                if !before.is_hit() || change < is_better {
                    *before = Seen { distance, triangle, is_front };
                }
            }
        }
    }
}
