//! An octree over outgoing rays: every leaf holds all rays that can matter to any point in it.
//!
//! Chen and Arvo 2000, section III-B.2, with two kinds of exact candidate sets: the rays that are among the `k`
//! nearest to some point of a cell (their figure 3), and the rays that are nearer than all their neighbours in the
//! ray map to some point of the cell: one such *local minimum* for every reflection of the point.

use super::lines::Lines;
use crate::math::Aabb;
use crate::parallel;
use glam::Vec3;

/// Which rays a leaf holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CandidateRule {
    /// Those that are nearer than all their neighbours to some point of the cell.
    LocalMinima,
    /// Those that are among this many nearest to some point of the cell.
    Nearest(usize),
}

/// A cell with no more candidates than this (beyond what the rule needs) is not divided.
const SMALL_SET: usize = 12;

/// Cells are divided this many times at the most.
const MAX_DEPTH: u32 = 8;

/// In a divided cell, its first child's index; in a leaf, where its candidates are.
#[derive(Clone, Copy, Debug)]
enum Node {
    Divided { first_child: u32 },
    Leaf { start: u32, count: u32 },
}

/// The octree.
#[derive(Clone, Debug)]
pub struct RayTree {
    center: Vec3,
    half: f32,
    nodes: Vec<Node>,
    candidates: Vec<u32>,
}

struct Cell {
    center: Vec3,
    candidates: Vec<u32>,
}

impl RayTree {
    /// The tree over all rays, for points within `bounds`.
    pub fn build(lines: &Lines, bounds: &Aabb, rule: CandidateRule) -> Self {
        let center = bounds.center();
        let half = (bounds.max - bounds.min).max_element().max(1e-6) * 0.5;
        let least = match rule {
            CandidateRule::LocalMinima => 0,
            CandidateRule::Nearest(count) => count,
        };
        let mut tree = Self { center, half, nodes: vec![Node::Leaf { start: 0, count: 0 }], candidates: Vec::new() };
        // Cells of one depth, with their nodes' indices.
        let all = (0..lines.len() as u32).collect();
        let mut level = vec![(0usize, Cell { center, candidates: all })];
        let mut half = half;
        for depth in 0..=MAX_DEPTH {
            let divided: Vec<Option<[Cell; 8]>> = parallel::map_collect(level.len(), |index| {
                let cell = &level[index].1;
                (depth < MAX_DEPTH && cell.candidates.len() > SMALL_SET + least)
                    .then(|| divide(lines, cell, half, rule))
                    .filter(|children| {
                        // Divided only where it helps.
                        let sum: usize = children.iter().map(|child| child.candidates.len()).sum();
                        sum < cell.candidates.len() * 7
                    })
            });
            let mut next = Vec::new();
            for ((node, cell), children) in level.into_iter().zip(divided) {
                match children {
                    Some(children) => {
                        let first = tree.nodes.len();
                        tree.nodes[node] = Node::Divided { first_child: first as u32 };
                        tree.nodes.resize_with(first + 8, || Node::Leaf { start: 0, count: 0 });
                        next.extend(children.into_iter().enumerate().map(|(k, child)| (first + k, child)));
                    }
                    None => {
                        let start = tree.candidates.len() as u32;
                        tree.nodes[node] = Node::Leaf { start, count: cell.candidates.len() as u32 };
                        tree.candidates.extend(cell.candidates);
                    }
                }
            }
            level = next;
            half *= 0.5;
        }
        tree
    }

    /// The candidates of a point's leaf; none outside the tree's bounds, where nothing is known.
    #[inline]
    pub fn candidates(&self, point: Vec3) -> Option<&[u32]> {
        let mut offset = point - self.center;
        if !(offset.abs().max_element() <= self.half) {
            return None;
        }
        let mut half = self.half;
        let mut node = self.nodes[0];
        loop {
            match node {
                Node::Leaf { start, count } => {
                    return Some(&self.candidates[start as usize..(start + count) as usize]);
                }
                Node::Divided { first_child } => {
                    half *= 0.5;
                    let octant = octant_of(offset);
                    offset -= octant_center(octant) * half;
                    node = self.nodes[first_child as usize + octant];
                }
            }
        }
    }

    /// Memory of the tree.
    pub fn byte_count(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.candidates.as_slice())
    }
}

fn octant_of(offset: Vec3) -> usize {
    usize::from(offset.x >= 0.0) | usize::from(offset.y >= 0.0) << 1 | usize::from(offset.z >= 0.0) << 2
}

fn octant_center(octant: usize) -> Vec3 {
    let sign = |bit: usize| if octant >> bit & 1 != 0 { 1.0 } else { -1.0 };
    Vec3::new(sign(0), sign(1), sign(2))
}

fn divide(lines: &Lines, cell: &Cell, half: f32, rule: CandidateRule) -> [Cell; 8] {
    let half = half * 0.5;
    // The sphere around a child, a little larger for rounding.
    let radius = half * 3f32.sqrt() * 1.001;
    std::array::from_fn(|octant| {
        let center = cell.center + octant_center(octant) * half;
        let candidates = match rule {
            CandidateRule::LocalMinima => local_minima_near(lines, center, radius, &cell.candidates),
            CandidateRule::Nearest(count) => nearest_near(lines, center, radius, count, &cell.candidates),
        };
        Cell { center, candidates }
    })
}

/// Those of `candidates` that can be nearer than all their neighbours to a point of the sphere.
///
/// The difference of two squared distances is a quadratic function of the point; its value and gradient at the
/// centre, and the bound 2 sin(angle between the rays) of its Hessian, bound it from below.
fn local_minima_near(lines: &Lines, center: Vec3, radius: f32, candidates: &[u32]) -> Vec<u32> {
    let keeps = |&ray: &u32| {
        let own = lines.offset(ray, center);
        if own.along + radius < 0.0 {
            return false; // the ray begins beyond the whole sphere
        }
        let own2 = own.across.length_squared();
        !lines.neighbours(ray).iter().any(|&neighbour| {
            let other = lines.offset(neighbour, center);
            let slope = 2.0 * (own.across - other.across).length() * radius;
            let bend = lines.sine_between(ray, neighbour) * radius * radius;
            let rounding = 1e-5 * (own2 + other.across.length_squared());
            own2 - other.across.length_squared() - slope - bend - rounding > 0.0 && other.along - radius > 0.0
        })
    };
    candidates.iter().copied().filter(keeps).collect()
}

/// Those of `candidates` that can be among the `count` nearest to a point of the sphere (Chen and Arvo 2000, figure 3).
fn nearest_near(lines: &Lines, center: Vec3, radius: f32, count: usize, candidates: &[u32]) -> Vec<u32> {
    let mut distances: Vec<(f32, u32)> =
        candidates.iter().map(|&ray| (lines.offset(ray, center).across.length(), ray)).collect();
    distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The k-th nearest to the centre bounds the k-th nearest to any point of the sphere.
    let Some(farthest) = distances.get(count.saturating_sub(1)).map(|(distance, _)| *distance) else {
        return candidates.to_vec();
    };
    let limit = (farthest + 2.0 * radius) * 1.0001;
    let mut kept: Vec<u32> = distances.iter().filter(|(distance, _)| *distance <= limit).map(|(_, ray)| *ray).collect();
    kept.sort_unstable();
    kept
}
