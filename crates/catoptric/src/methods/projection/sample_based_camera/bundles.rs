//! The leaves of kind `ray_bundle`: blocks of the ray map, halved until a leaf is accurate, found by beams.

use super::cameras::{Builder, Counts, MOST_FITTED, PARALLEL_RAYS, TYPICAL_SHARE};
use super::fit::{Fit, Shape, is_accurate};
use super::grid::GridRay;
use super::layout::BundleLeaf;
use crate::methods::projection::ray_map::{BeamTree, Reach};
use crate::parallel;
use glam::{DVec3, Vec3};

/// Halves of blocks of so many cells share a whole cell, those of smaller ones a row of rays.
const SHARED_CELLS: u32 = 8;

/// Beams hold all rays at the edges of a leaf and about this many in its middle.
const MIDDLE_REACHES: usize = 64;

/// No leaf.
const NO_LEAF: u32 = u32::MAX;

/// The leaves of one path.
#[derive(Clone, Debug, Default)]
pub(super) struct BundleTree {
    leaves: Vec<BundleLeaf>,
    beams: BeamTree,
    /// The leaf that each ray belongs to, or [`NO_LEAF`].
    leaf_of_ray: Vec<u32>,
    /// Leaves of the smallest size, whose fit is not accurate: they interpolate between their rays.
    interpolating_leaves: u64,
    rays_in_interpolating_leaves: u64,
}

/// A leaf with its rays.
struct Built {
    leaf: BundleLeaf,
    rays: Vec<u32>,
    accurate: bool,
}

impl Builder<'_> {
    /// The leaves over all rays of the path.
    pub(super) fn bundle_tree(&self) -> BundleTree {
        let pieces = self.pieces();
        let built: Vec<Built> = parallel::map_collect(pieces.len(), |piece| self.divided(&pieces[piece], piece as u32))
            .into_iter()
            .flatten()
            .collect();
        let mut tree = BundleTree { leaf_of_ray: vec![NO_LEAF; self.group.rays.len()], ..BundleTree::default() };
        let reaches = parallel::map_collect(built.len(), |leaf| self.reaches(&built[leaf]));
        let mut ends = Vec::with_capacity(built.len());
        let mut end = 0;
        for (index, one) in built.iter().enumerate() {
            if !one.accurate {
                tree.interpolating_leaves += 1;
                tree.rays_in_interpolating_leaves += one.rays.len() as u64;
            }
            for &ray in &one.rays {
                tree.leaf_of_ray[ray as usize] = index as u32;
            }
            end += reaches[index].len();
            ends.push(end);
        }
        tree.leaves = built.iter().map(|one| one.leaf).collect();
        tree.beams = BeamTree::new(&reaches.concat(), ends, TYPICAL_SHARE * f64::from(self.bounds.diagonal()));
        tree
    }

    /// The cells of rays, corners included.
    fn extent(&self, rays: &[u32]) -> [[u32; 2]; 2] {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for &ray in rays {
            for (axis, index) in self.group.cell_of(ray as usize).into_iter().enumerate() {
                low[axis] = low[axis].min(index as u32);
                high[axis] = high[axis].max(index as u32);
            }
        }
        [low, high]
    }

    /// The leaves over rays of one piece.
    fn divided(&self, rays: &[u32], piece: u32) -> Vec<Built> {
        let [low, high] = self.extent(rays);
        if let Some(fit) = self.fitted(rays) {
            return vec![self.built(&fit, rays, piece, [low, high], true)];
        }
        let extent = [0, 1].map(|axis: usize| high[axis] - low[axis]);
        if extent.iter().all(|&cells| cells <= 1) {
            let all: Vec<GridRay> = rays.iter().map(|&ray| self.group.rays[ray as usize]).collect();
            let fit = Fit::interpolating(&all);
            return fit.map(|fit| self.built(&fit, rays, piece, [low, high], false)).into_iter().collect();
        }
        let axis = usize::from(extent[1] > extent[0]);
        let middle = i64::from(low[axis] + extent[axis] / 2);
        // Both halves hold the rays between them: no seam opens.
        let shared = middle + i64::from(extent[axis] >= SHARED_CELLS);
        let place = |ray: &&u32| self.group.cell_of(**ray as usize)[axis];
        let first: Vec<u32> = rays.iter().filter(|ray| place(ray) <= shared).copied().collect();
        let second: Vec<u32> = rays.iter().filter(|ray| place(ray) >= middle).copied().collect();
        let (mut leaves, others) =
            parallel::join(rays.len() > PARALLEL_RAYS, || self.divided(&first, piece), || self.divided(&second, piece));
        leaves.extend(others);
        leaves
    }

    fn built(&self, fit: &Fit, rays: &[u32], piece: u32, cells: [[u32; 2]; 2], accurate: bool) -> Built {
        let own = rays.iter().map(|&ray| &self.group.rays[ray as usize]);
        let leaf = fit.leaf(own, piece, cells, accurate);
        Built { leaf, rays: rays.to_vec(), accurate }
    }

    /// The fit of the highest degree, if it is accurate.
    fn fitted(&self, rays: &[u32]) -> Option<Fit> {
        let gathered = |indices: &mut dyn Iterator<Item = u32>| -> (Vec<GridRay>, Vec<f32>) {
            let rays = indices.map(|ray| self.group.rays[ray as usize]);
            rays.map(|ray| (ray, self.head(&ray) as f32)).unzip()
        };
        let count = rays.len();
        let sampled = count > MOST_FITTED;
        let (some, heads) = if sampled {
            // One of every so many, not in step with the rows.
            let start = |stratum: usize| stratum * count / MOST_FITTED;
            let pick = |stratum: usize| {
                let (from, to) = (start(stratum), start(stratum + 1));
                rays[from + (stratum.wrapping_mul(0x9e37_79b9) >> 7) % (to - from)]
            };
            gathered(&mut (0..MOST_FITTED).map(pick))
        } else {
            gathered(&mut rays.iter().copied())
        };
        let accurate =
            |fit: &Fit, rays: &[GridRay], heads: &[f32]| is_accurate(fit, rays, heads, self.view, self.accuracy_px);
        let shapes = [Shape::Cubic, Shape::Quadratic, Shape::Linear];
        // Lower degrees are for few rays.
        let shapes = if sampled { &shapes[..1] } else { &shapes };
        let fit = shapes.iter().find_map(|&shape| Fit::new(&some, shape).filter(|fit| accurate(fit, &some, &heads)))?;
        if sampled {
            let (all, heads) = gathered(&mut rays.iter().copied());
            if !accurate(&fit, &all, &heads) {
                return None;
            }
        }
        Some(fit)
    }

    /// What a leaf's rays and those a little beyond the border of the path reach.
    fn reaches(&self, built: &Built) -> Vec<Reach> {
        let BundleLeaf { low_cell, high_cell, piece, .. } = built.leaf;
        let mut reaches: Vec<Reach> = Vec::with_capacity(256);
        let step = (built.rays.len() / MIDDLE_REACHES).max(1);
        for (index, &ray) in built.rays.iter().enumerate() {
            let own = &self.group.rays[ray as usize];
            let [column, row] = self.group.cell_of(ray as usize);
            let at_edge = [column, row]
                .iter()
                .zip(low_cell.iter().zip(&high_cell))
                .any(|(&cell, (&low, &high))| cell == i64::from(low) || cell == i64::from(high));
            let regular = self.group.regular(column, row).filter(|&regular| self.group.piece_of_ray[regular] == piece);
            let beside_border = regular != Some(ray as usize);
            if at_edge || beside_border || index % step == 0 {
                reaches.push(Reach::of_ray(own.tail, own.direction));
            }
            if let (true, Some(regular)) = (beside_border, regular) {
                let other = &self.group.rays[regular];
                let beyond = |own: DVec3, other: DVec3| own + (own - other);
                let direction = beyond(own.direction, other.direction).normalize_or(own.direction);
                reaches.push(Reach::of_ray(beyond(own.tail, other.tail), direction));
            }
        }
        reaches
    }
}

impl BundleTree {
    /// Appends the numbers of the leaves whose beams hold a point.
    pub(super) fn leaves_at(&self, point: Vec3, found: &mut Vec<u32>) {
        self.beams.leaves_at(point.to_array(), found);
    }

    /// The leaf of a number.
    #[inline]
    pub(super) fn leaf(&self, number: u32) -> Option<&BundleLeaf> {
        self.leaves.get(number as usize)
    }

    /// The leaf of a ray.
    pub(super) fn leaf_of(&self, ray: usize) -> Option<&BundleLeaf> {
        self.leaves.get(*self.leaf_of_ray.get(ray)? as usize)
    }

    pub(super) fn counts(&self) -> Counts {
        let bytes =
            size_of_val(self.leaves.as_slice()) + self.beams.byte_count() + size_of_val(self.leaf_of_ray.as_slice());
        Counts {
            leaves: self.leaves.len() as u64 - self.interpolating_leaves,
            ray_lists: self.interpolating_leaves,
            rays_in_lists: self.rays_in_interpolating_leaves,
            bytes: bytes as u64,
        }
    }
}
