//! Reflections in linear extrusions by their profile: the law of reflection holds in the plane across the axis, so a
//! point's place is found among the rays of line segments instead of those of triangles (Ofek, Rappoport 1998).

use super::subdivision::{WalkReach, Walks};
use crate::find::virtual_objects::{Extrusion, Locator, ReflectionPoint, ReflectionPoints, Reflector};
use catoptric_core::math::lanes::{LANES, Lanes};
use catoptric_core::scene::{Projection, View};
use catoptric_engine::method::Report;
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::{Vec2, Vec3};

/// The extension of the last segment where the profile ends, as a share of the reflector's radius. Chosen, not
/// measured.
const BORDER_SHARE: f32 = 0.05;

/// Places this far outside a segment, in shares of its length, still belong to it: rounding must not lose those between
/// two. Chosen, not measured.
const OUTSIDE: f32 = 1e-3;

/// The rays of the segments of a profile for one view.
pub(super) struct Profile {
    eye: ProfileEye,
    blocks: Vec<SegmentBlock>,
    /// The segment in each lane of each block.
    segments: Vec<u32>,
}

/// The origin of rays, by the plane of the profile and the axis across it.
enum ProfileEye {
    /// A point: its place in the plane, and its coordinate along the axis.
    Point(Vec2, f32),
    /// Parallel rays: their change along the axis for a unit step in the plane.
    Parallel(f32),
}

/// Eight segments with the rays that leave their ends, component by component. A lane without a segment holds zeros.
#[derive(Clone, Copy, Debug, Default)]
pub struct SegmentBlock {
    from: [Lanes; 2],
    edge: [Lanes; 2],
    /// The direction of the ray at the first end, and its change to the second.
    direction: [Lanes; 2],
    turn: [Lanes; 2],
    /// The range of the segment's parameter: 0 to 1, and further where the profile ends.
    low: Lanes,
    high: Lanes,
}

impl Profile {
    /// The rays of a reflector that is an extrusion; returns `None` if it is not, or rays do not come straight from the
    /// eye, or run along the axis.
    pub(super) fn new(reflector: &Reflector<'_>) -> Option<Self> {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let extrusion = mesh.extrusion.as_ref().filter(|_| rays.kind == BounceKind::Reflect)?;
        let eye = ProfileEye::new(extrusion, reflector.view?)?;
        let mut profile = Self { eye, blocks: Vec::new(), segments: Vec::new() };
        for (index, segment) in extrusion.segments.iter().enumerate() {
            let vertices = segment.vertices.map(|vertex| vertex as usize);
            if vertices.iter().all(|vertex| rays.cosines[*vertex].is_nan() || rays.cosines[*vertex] <= 0.0) {
                continue;
            }
            let places = vertices.map(|vertex| extrusion.flattened(mesh.positions[vertex]));
            let directions = vertices.map(|vertex| extrusion.flattened(rays.outgoing[vertex]).normalize_or_zero());
            let edge = places[1] - places[0];
            let border = BORDER_SHARE * mesh.radius / edge.length();
            let beyond = segment.open.map(|open| if open { border } else { OUTSIDE });
            let lane = profile.segments.len() % LANES;
            if lane == 0 {
                profile.blocks.push(SegmentBlock::default());
            }
            if let Some(block) = profile.blocks.last_mut() {
                block.set(lane, places[0], edge, directions, [-beyond[0], 1.0 + beyond[1]]);
                profile.segments.push(index as u32);
            }
        }
        (!profile.segments.is_empty()).then_some(profile)
    }
}

impl Profile {
    /// Appends the reflection points of one scene point.
    pub(super) fn locate_point(&self, reflector: &Reflector<'_>, point: Vec3, found: &mut Vec<ReflectionPoint>) {
        let Some(extrusion) = &reflector.mesh.extrusion else { return };
        let (place, height) = (extrusion.flattened(point), extrusion.height(point));
        let mut walks = Walks::new(reflector, point);
        for (number, block) in self.blocks.iter().enumerate() {
            let hold = block.hold(place);
            for (lane, _) in hold.iter().enumerate().filter(|(_, hold)| **hold) {
                let Some(segment) = self.segments.get(number * LANES + lane) else { continue };
                let segment = &extrusion.segments[*segment as usize];
                for reflection_point in block.reflection_points(lane, place).into_iter().flatten() {
                    let height = self.eye.reflection_height(reflection_point, place, height);
                    if let Some((triangle, weights)) =
                        extrusion.triangle_at(reflector.mesh.shape(), segment, reflection_point, height)
                    {
                        // The ray equals that of the mesh but for rounding; the walk ends where the mesh does.
                        found.extend(walks.walk(triangle, weights, WalkReach::Anywhere));
                    }
                }
            }
        }
    }
}

impl Locator for Profile {
    fn locate(&self, reflector: &Reflector<'_>, points: &[Vec3], found: &mut ReflectionPoints) {
        found.extend(points, |point, found| self.locate_point(reflector, point, found));
    }

    fn add_fallbacks(&self, _: &mut Report) {}

    fn byte_count(&self) -> u64 {
        (size_of_val(self.blocks.as_slice()) + size_of_val(self.segments.as_slice())) as u64
    }
}

impl ProfileEye {
    fn new(extrusion: &Extrusion, view: &View) -> Option<Self> {
        match view.projection {
            Projection::Perspective { .. } => {
                let eye = view.eye();
                Some(Self::Point(extrusion.flattened(eye), extrusion.height(eye)))
            }
            Projection::Orthographic { .. } => {
                let direction = view.ray(0.0, 0.0).direction;
                let slope = extrusion.height(direction) / extrusion.flattened(direction).length();
                slope.is_finite().then_some(Self::Parallel(slope))
            }
        }
    }

    /// The coordinate along the axis of the reflection point of a point: light keeps its slope along the axis.
    fn reflection_height(&self, reflection_point: Vec2, place: Vec2, height: f32) -> f32 {
        let after = place.distance(reflection_point);
        match self {
            Self::Point(eye, eye_height) => {
                let before = eye.distance(reflection_point);
                eye_height + (height - eye_height) * (before / (before + after))
            }
            Self::Parallel(slope) => height - slope * after,
        }
    }
}

impl SegmentBlock {
    /// Makes one of the segments the one with these ends and directions of rays there, from one share of it to another.
    pub fn set(&mut self, lane: usize, from: Vec2, edge: Vec2, directions: [Vec2; 2], [low, high]: [f32; 2]) {
        for axis in 0..2 {
            self.from[axis][lane] = from[axis];
            self.edge[axis][lane] = edge[axis];
            self.direction[axis][lane] = directions[0][axis];
            self.turn[axis][lane] = directions[1][axis] - directions[0][axis];
        }
        (self.low[lane], self.high[lane]) = (low, high);
    }

    /// Coefficients of `c0 + c1 s + c2 s^2`, which is 0 if the ray that leaves a segment at the share `s` of it passes
    /// through a point.
    #[inline(always)]
    fn form(&self, lane: usize, place: Vec2) -> [f32; 3] {
        let perp = |a: [f32; 2], b: [f32; 2]| a[0] * b[1] - a[1] * b[0];
        let [from, edge, direction, turn] =
            [&self.from, &self.edge, &self.direction, &self.turn].map(|of| [of[0][lane], of[1][lane]]);
        let to_point = [place.x - from[0], place.y - from[1]];
        [perp(to_point, direction), perp(to_point, turn) - perp(edge, direction), -perp(edge, turn)]
    }

    /// True if segments have a ray through a point, or its continuation backwards.
    #[inline]
    pub fn hold(&self, place: Vec2) -> [bool; LANES] {
        let mut hold = [false; LANES];
        for (lane, hold) in hold.iter_mut().enumerate() {
            let [c0, c1, c2] = self.form(lane, place);
            let (low, high) = (self.low[lane], self.high[lane]);
            let at = |s: f32| c0 + s * (c1 + s * c2);
            let crosses = at(low) * at(high) <= 0.0;
            // Two rays may pass through it: where the form turns between the ends, beyond zero.
            let turning = -0.5 * c1 / c2;
            let dips = turning > low && turning < high && at(turning) * at(low) <= 0.0;
            *hold = (crosses || dips) && low < high;
        }
        hold
    }

    /// The places of a segment whose rays lead to a point.
    pub fn reflection_points(&self, lane: usize, place: Vec2) -> [Option<Vec2>; 2] {
        let [from, edge, direction, turn] =
            [&self.from, &self.edge, &self.direction, &self.turn].map(|of| Vec2::new(of[0][lane], of[1][lane]));
        let [c0, c1, c2] = self.form(lane, place);
        let root = (c1 * c1 - 4.0 * c0 * c2).max(0.0).sqrt();
        // Without cancellation.
        let sum = -0.5 * (c1 + root.copysign(c1));
        [sum / c2, c0 / sum].map(|share| {
            let reflection_point = from + edge * share;
            let ahead = (place - reflection_point).dot(direction + turn * share) > 0.0;
            (ahead && share >= self.low[lane] && share <= self.high[lane]).then_some(reflection_point)
        })
    }
}
