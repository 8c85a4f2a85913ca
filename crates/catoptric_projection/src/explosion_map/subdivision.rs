//! The reflection subdivision: the cells of rays that leave the reflector's triangles divide space, and a point's place
//! in its cell is its reflection. The cell is found by walking from cell to cell.

use crate::find::virtual_objects::{ReflectionPoint, Reflector, interpolated, weights_of};
use crate::find::work;
use catoptric_core::surface::mesh::adjacency::NO_NEIGHBOUR;
use glam::{Mat3, Vec2, Vec3};

/// Newton's method gives up after this many steps, each of which may lead to another cell. A bound on time; chosen, not
/// measured.
const MAX_STEPS: u32 = 14;

/// Steps that do not become shorter than this share of the one before lead nowhere if there are more than two of them.
const SHRINKING: f32 = 0.7;
const MAX_STRAYS: u32 = 2;

/// Work of a step of a walk.
const WORK_A_STEP: u64 = 1;

/// The limit of walks from cell to cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WalkReach {
    /// To cells next to where they start: there the point is, or nowhere near.
    Near,
    /// Anywhere.
    Anywhere,
}

impl WalkReach {
    /// A step leads over no more edges than this.
    fn most_edges(self) -> u32 {
        match self {
            Self::Near => 8,
            Self::Anywhere => 64,
        }
    }
}

/// Steps this small, in the weights of the cell, are the last. Chosen, not measured.
const LAST_STEP: f32 = 1e-5;

/// The accuracy of a place, as a step in weights, that is accepted where steps go to and fro over an edge between two
/// cells. Chosen, not measured.
const UNSURE_STEP: f32 = 0.02;

/// A place this far outside its triangle, in its weights, is still in it: rounding must not send walks to and fro.
/// Chosen, not measured.
const OUTSIDE: f32 = 1e-4;

/// A step goes no further than this share of the reflector's radius. Chosen, not measured.
const LONGEST_STEP: f32 = 0.5;

/// The extension of the last cell where a reflector ends, as a share of the reflector's radius. Chosen, not measured.
const BORDER_SHARE: f32 = 0.05;

/// The maximum number of walks for one point that end in different cells. A bound on time; chosen, not measured.
const MAX_CELLS: usize = 8;

/// Walks to the cells that hold one point; several may lead to one cell.
pub(super) struct Walks<'a> {
    reflector: &'a Reflector<'a>,
    point: Vec3,
    known: [u32; MAX_CELLS],
    count: usize,
}

impl<'a> Walks<'a> {
    pub(super) fn new(reflector: &'a Reflector<'a>, point: Vec3) -> Self {
        Self { reflector, point, known: [u32::MAX; MAX_CELLS], count: 0 }
    }

    /// Walks from a place of a triangle; returns `None` if that ends in no cell, or in one that an earlier walk found.
    pub(super) fn walk(&mut self, triangle: u32, weights: Vec2, reach: WalkReach) -> Option<ReflectionPoint> {
        let found = walk_from(self.reflector, WalkSpot { triangle, weights, beyond: false }, self.point, reach)?;
        if self.known.contains(&found.triangle) || self.count >= MAX_CELLS {
            return None;
        }
        self.known[self.count] = found.triangle;
        self.count += 1;
        Some(found)
    }
}

/// The place in the cell that holds the point, at the end of a walk from a first guess.
fn walk_from(reflector: &Reflector<'_>, seed: WalkSpot, point: Vec3, reach: WalkReach) -> Option<ReflectionPoint> {
    let mesh = reflector.mesh;
    let longest = LONGEST_STEP * mesh.radius;
    let mut at = seed;
    if !at.settle(reflector, reach.most_edges()) && reach == WalkReach::Near {
        return None;
    }
    let (mut last_length, mut strays) = (f32::INFINITY, 0);
    for count in 1..=MAX_STEPS {
        work::add(WORK_A_STEP);
        let cell = RayCell::new(reflector, at.triangle);
        let (step, change) = cell.step(at.weights, point)?;
        let length = cell.length_of(step);
        strays += u32::from(length > SHRINKING * last_length && step.length() > UNSURE_STEP);
        if strays > MAX_STRAYS {
            return None;
        }
        last_length = length.min(longest);
        let step = if length > longest { step * (longest / length) } else { step };
        let before = at.triangle;
        at.weights += step;
        if !at.settle(reflector, reach.most_edges()) && reach == WalkReach::Near {
            return None;
        }
        let size = step.length();
        if at.triangle == before && size < LAST_STEP || count == MAX_STEPS && size < UNSURE_STEP {
            if at.beyond && cell.length_of(at.outside()) > BORDER_SHARE * mesh.radius {
                return None;
            }
            return Some(reflection_point_at(reflector, &at, change));
        }
    }
    None
}

/// A place on the mesh.
#[derive(Clone, Copy)]
struct WalkSpot {
    triangle: u32,
    weights: Vec2,
    /// True if it lies outside its triangle because there is no other beyond the edge.
    beyond: bool,
}

impl WalkSpot {
    /// Goes over edges to the triangle that the place lies in; returns false if that is more than so many edges away.
    fn settle(&mut self, reflector: &Reflector<'_>, most_edges: u32) -> bool {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        self.beyond = false;
        let mut before = u32::MAX;
        for _ in 0..most_edges {
            let shares = [1.0 - self.weights.x - self.weights.y, self.weights.x, self.weights.y];
            // Over the edge that it lies furthest beyond.
            let side = (0..3).fold(0, |best, k| if shares[k] < shares[best] { k } else { best });
            if shares[side] >= -OUTSIDE {
                return true;
            }
            let next = mesh.neighbours[self.triangle as usize][side];
            if next == before {
                return true; // on the edge between two
            }
            if next == NO_NEIGHBOUR || !rays.shows(mesh.triangles[next as usize]) {
                self.beyond = true;
                return true;
            }
            let place = interpolated(&mesh.positions, mesh.triangles[self.triangle as usize], self.weights);
            let corners = mesh.triangles[next as usize].map(|vertex| mesh.positions[vertex as usize]);
            before = self.triangle;
            self.triangle = next;
            self.weights = weights_of(corners, place);
        }
        false
    }

    /// The step from the nearest place of the triangle, about.
    fn outside(&self) -> Vec2 {
        let shares =
            [1.0 - self.weights.x - self.weights.y, self.weights.x, self.weights.y].map(|share| share.max(0.0));
        let sum: f32 = shares.iter().sum();
        self.weights - Vec2::new(shares[1], shares[2]) / sum
    }
}

/// A cell of rays: origins and directions, linear over its triangle.
struct RayCell {
    origin: [Vec3; 3],
    direction: [Vec3; 3],
}

impl RayCell {
    fn new(reflector: &Reflector<'_>, triangle: u32) -> Self {
        let corners = reflector.mesh.triangles[triangle as usize];
        let steps = |values: &[Vec3]| {
            let [a, b, c] = corners.map(|vertex| values[vertex as usize]);
            [a, b - a, c - a]
        };
        Self { origin: steps(&reflector.mesh.positions), direction: steps(&reflector.rays.outgoing) }
    }

    fn length_of(&self, step: Vec2) -> f32 {
        (self.origin[1] * step.x + self.origin[2] * step.y).length()
    }

    /// A step of Newton's method towards the ray through a point, and the changes of the weights with the point; none
    /// where the rays lead away from it.
    fn step(&self, weights: Vec2, point: Vec3) -> Option<(Vec2, [Vec3; 2])> {
        let at = |values: &[Vec3; 3]| values[0] + values[1] * weights.x + values[2] * weights.y;
        let (origin, direction) = (at(&self.origin), at(&self.direction));
        let from = point - origin;
        let distance = from.dot(direction) / direction.length_squared();
        let sides = [0, 1].map(|k: usize| self.origin[k + 1] + self.direction[k + 1] * distance);
        let inverse = Mat3::from_cols(sides[0], sides[1], direction).inverse();
        let step = (inverse * (from - direction * distance)).truncate();
        let rows = inverse.transpose();
        (step.is_finite() && distance > 0.0).then_some((step, [rows.x_axis, rows.y_axis]))
    }
}

/// The reflection point at a place; where the surface turns away, that of the silhouette.
fn reflection_point_at(reflector: &Reflector<'_>, spot: &WalkSpot, change: [Vec3; 2]) -> ReflectionPoint {
    let (mesh, rays) = (reflector.mesh, reflector.rays);
    let corners = mesh.triangles[spot.triangle as usize];
    let at = |values: &[Vec3]| interpolated(values, corners, spot.weights);
    let point = ReflectionPoint {
        position: at(&mesh.positions),
        normal: (at(&mesh.normals) * rays.side).normalize_or_zero(),
        position_change: Mat3::ZERO,
        normal_change: Mat3::ZERO,
        origin: at(&rays.origins),
        triangle: spot.triangle,
        weights: spot.weights,
        beyond: false,
        blended_image: None,
    };
    let held = point.held_at_horizon(mesh, rays, change);
    ReflectionPoint { beyond: held.beyond || spot.beyond, ..held }
}
