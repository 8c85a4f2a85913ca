//! The cells of a reflector's rays in a hierarchy of beams, which finds those that may hold a point.
//!
//! Spheres locate a point if the reflector is convex. Elsewhere rays cross, and between the reflector and the spheres
//! about it these resolve little. A cell's points are mixtures of points of the three rays at its corners, so any
//! convex set that holds these rays holds the cell. The beams by which path perturbation finds its samples therefore
//! find cells, too.

use super::subdivision::{WalkReach, Walks};
use crate::find::ray_map;
use crate::find::ray_map::BeamTree;
use crate::find::virtual_objects::{ReflectionPoint, Reflector};
use crate::find::work;
use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{LANES, Lanes, Vec3Lanes};
use glam::{Vec2, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// A point this far outside a cell, in its weights, after two steps of Newton's method may be in it after more. Chosen,
/// not measured.
pub const NEAR: f32 = 0.25;

/// Walks start from a cell next to a reflection point only if that is further away than this many times the size of the
/// cell. Chosen, not measured.
const APART: f32 = 2.0;

/// Beams' spread is measured at this share of the scene's diagonal. Chosen, not measured.
const TYPICAL_SHARE: f64 = 0.25;

/// The maximum number of leaves that are searched for one point. A bound on time; chosen, not measured.
const MAX_LEAVES: usize = 256;

/// Eight cells, component by component: the ray at the first corner, and the steps to those at the others.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellLeaf {
    position: Vec3Lanes,
    edges: [Vec3Lanes; 2],
    direction: Vec3Lanes,
    turns: [Vec3Lanes; 2],
}

/// Two steps of Newton's method from a point in eight cells.
#[derive(Clone, Copy, Debug)]
pub struct CellSolution {
    /// The weights of the second and third corner in each cell.
    pub weights: [Lanes; 2],
    /// The least of the three weights; below 0 outside, and where the cell leads away from the point.
    pub inside: Lanes,
    /// True if the cell's rays have crossed on the way.
    turned: [bool; LANES],
}

/// Work of two steps in eight cells.
const WORK_A_LEAF: u64 = 2;

/// Work of a cell's place in the hierarchy.
const WORK_A_CELL: u64 = 20;

/// The cells of a reflector's rays.
#[derive(Debug)]
pub(super) struct CellTree {
    beams: BeamTree,
    leaves: Vec<CellLeaf>,
    /// The triangle in each lane of each leaf.
    triangles: Vec<u32>,
    /// Cells that might have held a point and were not looked at, or not kept, summed over the points so far.
    not_searched: AtomicU64,
}

impl CellTree {
    /// Builds the tree of all triangles that have rays; points are expected within a scene with this diagonal.
    pub(super) fn new(reflector: &Reflector<'_>, diagonal: f32) -> Self {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let shown = (0..mesh.triangles.len() as u32).filter(|index| rays.shows(mesh.triangles[*index as usize]));
        let middle = |index: u32| {
            let [a, b, c] = mesh.triangles[index as usize].map(|vertex| mesh.positions[vertex as usize]);
            (a + b + c) / 3.0
        };
        let mut order: Vec<(Vec3, u32)> = shown.map(|index| (middle(index), index)).collect();
        gather(&mut order);
        let triangles: Vec<u32> = order.into_iter().map(|(_, index)| index).collect();
        let (mut leaves, mut reaches, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        for chunk in triangles.chunks(LANES) {
            let mut leaf = CellLeaf::default();
            for (lane, &index) in chunk.iter().enumerate() {
                let corners = mesh.triangles[index as usize].map(|vertex| vertex as usize);
                leaf.set(lane, corners.map(|at| mesh.positions[at]), corners.map(|at| rays.outgoing[at]));
                let ray =
                    |at: usize| ray_map::Reach::of_ray(mesh.positions[at].as_dvec3(), rays.outgoing[at].as_dvec3());
                reaches.extend(corners.map(ray));
            }
            leaves.push(leaf);
            ends.push(reaches.len());
        }
        let beams = BeamTree::new(&reaches, ends, TYPICAL_SHARE * f64::from(diagonal));
        Self { beams, leaves, triangles, not_searched: AtomicU64::new(0) }
    }

    /// Walks to all cells that hold the walks' point, or nearly.
    pub(super) fn locate(
        &self,
        reflector: &Reflector<'_>,
        point: Vec3,
        walks: &mut Walks<'_>,
        reflection_points: &mut Vec<ReflectionPoint>,
    ) {
        let mut near = Near { cells: [(0.0, 0, Vec2::ZERO, false); MAX_NEAR], count: 0 };
        let not_searched = find(self, point.to_array(), &mut near);
        if not_searched > 0 {
            self.not_searched.fetch_add(not_searched, Ordering::Relaxed);
        }
        // Cells that hold the point come first; others start walks only if they are not next to a reflection point
        // found before.
        let mesh = reflector.mesh;
        let mut found = [(Vec3::NAN, false); MAX_NEAR];
        let mut count = 0;
        near.cells[..near.count].sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (inside, triangle, weights, turned) in near.cells[..near.count].iter().copied() {
            let [a, b, c] = mesh.triangles[triangle as usize].map(|vertex| mesh.positions[vertex as usize]);
            let (place, size) = (a + (b - a) * weights.x + (c - a) * weights.y, a.distance(b).max(a.distance(c)));
            let known = |one: &(Vec3, bool)| one.1 == turned && one.0.distance(place) < APART * size;
            if inside < 0.0 && found[..count].iter().any(known) {
                continue;
            }
            if let Some(reflection_point) = walks.walk(triangle, weights, WalkReach::Near) {
                found[count] = (reflection_point.position, turned);
                count = (count + 1).min(MAX_NEAR - 1);
                reflection_points.push(reflection_point);
            }
        }
    }

    /// Cells that might have held a point and were not looked at, or not kept, summed over the points so far.
    pub(super) fn not_searched(&self) -> u64 {
        self.not_searched.load(Ordering::Relaxed)
    }

    /// Work that it took to make.
    pub(super) fn build_work(&self) -> u64 {
        WORK_A_CELL * self.triangles.len() as u64
    }

    /// Bytes held.
    pub(super) fn byte_count(&self) -> u64 {
        let leaves = size_of_val(self.leaves.as_slice()) + size_of_val(self.triangles.as_slice());
        (self.beams.byte_count() + leaves) as u64
    }
}

/// Finds the cells that may hold a point; returns the number of those that limits leave out.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn find(tree: &CellTree, point: [f32; 3], near: &mut Near) -> u64 {
    let (mut looked, mut left_out) = (0, 0);
    tree.beams.visit(point, |leaf| {
        looked += 1;
        if looked > MAX_LEAVES {
            left_out += (tree.triangles.len() - leaf as usize * LANES).min(LANES) as u64;
            return;
        }
        let Some(cells) = tree.leaves.get(leaf as usize) else { return };
        work::add(WORK_A_LEAF);
        let answer = cells.answer(point.into());
        for lane in 0..LANES {
            if answer.inside[lane] > -NEAR
                && let Some(triangle) = tree.triangles.get(leaf as usize * LANES + lane)
            {
                let weights = Vec2::new(answer.weights[0][lane], answer.weights[1][lane]);
                left_out += u64::from(!near.add(answer.inside[lane], *triangle, weights, answer.turned[lane]));
            }
        }
    });
    left_out
}

/// Cells that hold a point or are next to those that do: no more than this. A bound on time; chosen, not measured.
const MAX_NEAR: usize = 32;

/// Cells near a point: the least of the point's weights in each, its triangle, the weights, and true if its rays have
/// crossed.
struct Near {
    cells: [(f32, u32, Vec2, bool); MAX_NEAR],
    count: usize,
}

impl Near {
    /// Adds a cell, in the place of the one that holds the point least if there are too many; returns false then.
    fn add(&mut self, inside: f32, triangle: u32, weights: Vec2, turned: bool) -> bool {
        if self.count < MAX_NEAR {
            self.cells[self.count] = (inside, triangle, weights, turned);
            self.count += 1;
            return true;
        }
        let least = (0..MAX_NEAR).min_by(|a, b| self.cells[*a].0.total_cmp(&self.cells[*b].0));
        if let Some(least) = least
            && self.cells[least].0 < inside
        {
            self.cells[least] = (inside, triangle, weights, turned);
        }
        false
    }
}

impl CellLeaf {
    /// Makes one of the cells the one with these rays at its corners.
    pub fn set(&mut self, lane: usize, positions: [Vec3; 3], directions: [Vec3; 3]) {
        self.position.set(lane, positions[0]);
        self.direction.set(lane, directions[0]);
        for k in 0..2 {
            self.edges[k].set(lane, positions[k + 1] - positions[0]);
            self.turns[k].set(lane, directions[k + 1] - directions[0]);
        }
    }

    /// Two steps of Newton's method towards the ray through a point, from the middles of the cells.
    #[inline(always)]
    pub fn answer(&self, point: Vec3) -> CellSolution {
        let third = Lanes::splat(1.0 / 3.0);
        let mut answer = CellSolution { weights: [third; 2], inside: Lanes::splat(-1.0), turned: [false; LANES] };
        for _ in 0..2 {
            for lane in 0..LANES {
                let (u, v) = (answer.weights[0][lane], answer.weights[1][lane]);
                let [right_edge, down_edge] = self.edges.each_ref().map(|of| of.vector(lane));
                let [right_turn, down_turn] = self.turns.each_ref().map(|of| of.vector(lane));
                let from = point - (self.position.vector(lane) + right_edge * u + down_edge * v);
                let direction = self.direction.vector(lane) + right_turn * u + down_turn * v;
                let distance = from.dot(direction) / direction.dot(direction);
                let (right, down) = (right_edge + right_turn * distance, down_edge + down_turn * distance);
                let area = right.cross(down).dot(direction);
                let u = u + from.cross(down).dot(direction) / area;
                let v = v + right.cross(from).dot(direction) / area;
                answer.weights[0][lane] = u;
                answer.weights[1][lane] = v;
                let least = u.min(v).min(1.0 - u - v);
                // Cells without an area and empty lanes give values that are not numbers, which `min` would pass over.
                let ahead = (distance > 0.0) & (area != 0.0) & (u + v).is_finite();
                answer.inside[lane] = if ahead { least } else { f32::NEG_INFINITY };
                answer.turned[lane] = right_edge.cross(down_edge).dot(direction) * area < 0.0;
            }
        }
        answer
    }
}

/// Sorts places so that every run of [`LANES`], and of eight times as many, and so on, lies close together: halves
/// across the longest side of their box, at a multiple of the largest run.
pub fn gather(places: &mut [(Vec3, u32)]) {
    let count = places.len();
    if count <= LANES {
        return;
    }
    let mut run = LANES;
    while run * LANES < count {
        run *= LANES;
    }
    let bounds = Aabb::around(places.iter().map(|(place, _)| *place));
    let size = bounds.size();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let split = (count / 2).div_ceil(run) * run;
    if split < count {
        let key = |one: &(Vec3, u32)| (one.0[axis], one.1);
        places.select_nth_unstable_by(split, |a, b| {
            let (a, b) = (key(a), key(b));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        });
    }
    let (low, high) = places.split_at_mut(split.min(count));
    gather(low);
    gather(high);
}
