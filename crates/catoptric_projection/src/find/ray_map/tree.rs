//! An octree over outgoing rays: every leaf holds all rays that can matter to any point in it.
//!
//! Chen and Arvo 2000, section III-B.2, with exact candidate sets: the rays that are among the `k` nearest to some
//! point of a cell (their figure 3).

use super::lines::Lines;
use catoptric_core::math::Aabb;
use glam::Vec3;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// The number of candidates (beyond those that the rule needs) up to which a cell is not divided. Chosen, not measured.
const SMALL_SET: usize = 16;

/// Cells are divided this many times at the most. A bound on memory; chosen, not measured.
const MAX_DEPTH: u32 = 9;

/// A cell that keeps more than this share of its parent's candidates is not divided: it would not help. Chosen, not
/// measured.
const MIN_REDUCTION: f32 = 0.98;

/// Cells are divided this many times all the same: the spheres around cells as large as the scene reach all rays.
/// Chosen, not measured.
const CERTAIN_DIVISIONS: u32 = 4;

/// A cell is divided after this many look-ups: it costs as much as that many.
const LOOKUPS_BEFORE_DIVISION: u32 = 6;

/// The size of the cell for points beyond the tree's bounds, in sizes of these. Chosen, not measured.
const OUTER_SIZE: f32 = 64.0;

/// A cell with its candidates. It is divided after some look-ups.
#[derive(Debug)]
struct OctreeCell {
    center: Vec3,
    half: f32,
    depth: u32,
    candidates: Vec<u32>,
    lookups: AtomicU32,
    /// The eight children; `None` in a leaf.
    children: OnceLock<Option<Box<[OctreeCell; 8]>>>,
}

/// The octree. Cells are divided where points are looked up; answers do not depend on the order of the queries.
#[derive(Debug)]
pub struct RayTree {
    root: OctreeCell,
    /// A larger and coarser cell for points beyond the root, made when there are such points.
    outer: OnceLock<Box<OctreeCell>>,
    /// Number of nearest rays in every leaf.
    count: usize,
}

impl RayTree {
    /// The tree over all rays, for points within `bounds`: leaves hold all rays that are among the `count` nearest to
    /// some point of the cell.
    pub fn new(lines: &Lines, bounds: &Aabb, count: usize) -> Self {
        let half = (bounds.max - bounds.min).max_element().max(1e-6) * 0.5;
        let candidates = (0..lines.len() as u32).collect();
        let root = OctreeCell::new(bounds.center(), half, 0, candidates);
        Self { root, outer: OnceLock::new(), count }
    }

    /// The candidates of a point's leaf; none far outside the tree's bounds, where nothing is known. `lines` are those
    /// that the tree was made for.
    #[inline]
    pub fn candidates(&self, lines: &Lines, point: Vec3) -> Option<&[u32]> {
        let mut cell = &self.root;
        let distance = (point - cell.center).abs().max_element();
        if !point.is_finite() {
            return None;
        }
        if distance > cell.half {
            if distance > cell.half * OUTER_SIZE {
                return None;
            }
            let outer = || Box::new(OctreeCell::new(cell.center, cell.half * OUTER_SIZE, 0, cell.candidates.clone()));
            cell = self.outer.get_or_init(outer);
        }
        while let Some(children) = cell.children(lines, self.count) {
            cell = &children[octant_of(point - cell.center)];
        }
        Some(&cell.candidates)
    }

    /// Number of nearest rays in every leaf.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Memory of the tree as far as it has grown.
    pub fn byte_count(&self) -> usize {
        self.root.byte_count() + self.outer.get().map_or(0, |outer| outer.byte_count())
    }
}

impl OctreeCell {
    fn new(center: Vec3, half: f32, depth: u32, candidates: Vec<u32>) -> Self {
        Self { center, half, depth, candidates, lookups: AtomicU32::new(0), children: OnceLock::new() }
    }

    #[inline]
    fn children(&self, lines: &Lines, count: usize) -> Option<&[Self; 8]> {
        if let Some(children) = self.children.get() {
            return children.as_deref();
        }
        // Sets differ in size, not in the rays found in them: the number of look-ups changes no answer.
        if self.lookups.fetch_add(1, Ordering::Relaxed) < LOOKUPS_BEFORE_DIVISION {
            return None;
        }
        self.children.get_or_init(|| self.divided(lines, count)).as_deref()
    }

    fn divided(&self, lines: &Lines, count: usize) -> Option<Box<[Self; 8]>> {
        if self.depth >= MAX_DEPTH || self.candidates.len() <= SMALL_SET + count {
            return None;
        }
        let half = self.half * 0.5;
        // The sphere around a child, a little larger for rounding.
        let radius = half * 3f32.sqrt() * 1.001;
        let child = |octant: usize| {
            let center = self.center + octant_center(octant) * half;
            let candidates = nearest_near(lines, center, radius, count, &self.candidates);
            Self::new(center, half, self.depth + 1, candidates)
        };
        let children: [Self; 8] = std::array::from_fn(child);
        let sum: usize = children.iter().map(|child| child.candidates.len()).sum();
        let limit = MIN_REDUCTION * 8.0 * self.candidates.len() as f32;
        (self.depth < CERTAIN_DIVISIONS || (sum as f32) < limit).then(|| Box::new(children))
    }

    fn byte_count(&self) -> usize {
        let children = self.children.get().and_then(Option::as_ref);
        let below: usize = children.map_or(0, |children| children.iter().map(Self::byte_count).sum());
        size_of::<Self>() + size_of_val(self.candidates.as_slice()) + below
    }
}

fn octant_of(offset: Vec3) -> usize {
    usize::from(offset.x >= 0.0) | usize::from(offset.y >= 0.0) << 1 | usize::from(offset.z >= 0.0) << 2
}

fn octant_center(octant: usize) -> Vec3 {
    let sign = |bit: usize| if octant >> bit & 1 != 0 { 1.0 } else { -1.0 };
    Vec3::new(sign(0), sign(1), sign(2))
}

/// The rays among `candidates` that can be among the `count` nearest to a point of the sphere (Chen and Arvo 2000,
/// figure 3).
fn nearest_near(lines: &Lines, center: Vec3, radius: f32, count: usize, candidates: &[u32]) -> Vec<u32> {
    // Rays that begin beyond the whole sphere do not count, and those that begin within it count for some points only.
    let offsets = candidates.iter().map(|&ray| (lines.offset(ray, center), ray));
    let mut distances: Vec<(f32, u32, bool)> = offsets
        .filter(|(offset, _)| offset.along + radius >= 0.0)
        .map(|(offset, ray)| (offset.across.length(), ray, offset.along - radius > 0.0))
        .collect();
    distances.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // The k-th nearest to the centre bounds the k-th nearest to any point of the sphere.
    let mut certain = distances.iter().filter(|(_, _, certain)| *certain);
    let farthest = certain.nth(count.saturating_sub(1)).map_or(f32::INFINITY, |(distance, _, _)| *distance);
    let limit = (farthest + 2.0 * radius) * 1.0001;
    let mut kept: Vec<u32> =
        distances.iter().filter(|(distance, _, _)| *distance <= limit).map(|(_, ray, _)| *ray).collect();
    kept.sort_unstable();
    kept
}
