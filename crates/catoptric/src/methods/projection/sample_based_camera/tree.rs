//! The tree of leaves over one path's rays: blocks of the ray map, halved until a leaf is accurate.

use super::grid::{GridRay, GroupRays, NO_RAY, RayGrid};
use super::leaf::Leaf;
use crate::math::Aabb;
use crate::methods::projection::ray_map::{Beam, Reach, rounding_at};
use crate::scene::PreciseView;
use glam::{DVec3, Vec3};

/// Rays are looked at for their spread at this share of the scene's size.
const TYPICAL_SHARE: f64 = 0.25;

/// Beams go on beyond a path's border by this many times the difference of the last two rays.
const EXTRAPOLATED: f64 = 2.0;

/// A fit is tried on at most so many rays, 24 a term of the highest degree; of larger blocks on every n-th of them.
const MOST_FITTED: usize = 240;

/// Nodes that wait in a look-up: a block is halved at most 32 times in each direction.
const MOST_WAITING: usize = 66;

/// A block of cells, corners included.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    low: [u32; 2],
    high: [u32; 2],
}

/// What is below a node.
#[derive(Clone, Copy, Debug)]
enum Below {
    Nodes([u32; 2]),
    Leaf(u32),
}

#[derive(Clone, Debug)]
struct Node {
    beam: Beam,
    below: Below,
}

/// The leaves of one path, in a binary tree; the root is the last node.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    pub(super) leaves: Vec<(Leaf, Block)>,
    /// The leaf that each cell of the grid belongs to, or [`NO_RAY`].
    leaf_of_cell: Vec<u32>,
    /// Leaves of the smallest size whose fit is not accurate, and the rays in them.
    pub(super) inaccurate_leaves: u64,
    pub(super) inaccurate_rays: u64,
}

/// What trees are built for.
pub(super) struct Builder<'a> {
    pub(super) grid: &'a RayGrid,
    pub(super) group: &'a GroupRays,
    pub(super) view: &'a PreciseView,
    pub(super) bounds: Aabb,
    pub(super) accuracy_px: f64,
}

impl Block {
    /// Whether a place, in cells, is in the block.
    pub(super) fn holds(&self, place: [f64; 2], leeway: f64) -> bool {
        (0..2).all(|axis| {
            let (low, high) = (f64::from(self.low[axis]), f64::from(self.high[axis]));
            (low - leeway..=high + leeway).contains(&place[axis])
        })
    }
}

impl Builder<'_> {
    /// The tree over all rays of the path.
    pub(super) fn build(&self) -> Tree {
        let mut tree = Tree::default();
        let all = Block { low: [0, 0], high: [self.grid.columns - 1, self.grid.rows - 1] };
        if let Some(block) = self.shrunk(all) {
            self.add(&mut tree, block);
        }
        tree.leaf_of_cell = vec![NO_RAY; self.group.ray_of_cell.len()];
        for (leaf, (_, block)) in tree.leaves.iter().enumerate() {
            for row in block.low[1]..=block.high[1] {
                let start = (row * self.grid.columns) as usize;
                let cells = start + block.low[0] as usize..=start + block.high[0] as usize;
                tree.leaf_of_cell[cells].fill(leaf as u32);
            }
        }
        tree
    }

    /// The rays of a block, row by row.
    fn rays(&self, block: Block) -> impl Iterator<Item = (u32, u32, &GridRay)> {
        let cells = (block.low[1]..=block.high[1])
            .flat_map(move |row| (block.low[0]..=block.high[0]).map(move |column| (column, row)));
        cells.filter_map(|(column, row)| {
            let ray = self.group.ray_of_cell[(row * self.grid.columns + column) as usize];
            (ray != NO_RAY).then(|| (column, row, &self.group.rays[ray as usize]))
        })
    }

    fn ray_at(&self, column: i64, row: i64) -> Option<&GridRay> {
        let inside = |index: i64, count: u32| (0..i64::from(count)).contains(&index);
        if !inside(column, self.grid.columns) || !inside(row, self.grid.rows) {
            return None;
        }
        let ray = self.group.ray_of_cell[(row * i64::from(self.grid.columns) + column) as usize];
        self.group.rays.get(ray as usize)
    }

    /// The smallest block with the same rays.
    fn shrunk(&self, block: Block) -> Option<Block> {
        let mut found: Option<Block> = None;
        for (column, row, _) in self.rays(block) {
            let place = [column, row];
            found = Some(match found {
                None => Block { low: place, high: place },
                Some(block) => Block {
                    low: [0, 1].map(|axis| block.low[axis].min(place[axis])),
                    high: [0, 1].map(|axis| block.high[axis].max(place[axis])),
                },
            });
        }
        found
    }

    /// How far a ray goes until it leaves the scene.
    fn head(&self, ray: &GridRay) -> f64 {
        let (tail, direction) = (ray.tail, ray.direction);
        let mut exit = f64::INFINITY;
        for axis in 0..3 {
            let limit = if direction[axis] > 0.0 { self.bounds.max[axis] } else { self.bounds.min[axis] };
            let distance = (f64::from(limit) - tail[axis]) / direction[axis];
            if distance.is_finite() {
                exit = exit.min(distance.max(0.0));
            }
        }
        if exit.is_finite() { exit } else { f64::from(self.bounds.diagonal()) }
    }

    fn is_accurate(&self, leaf: &Leaf, rays: &[GridRay]) -> bool {
        rays.iter().all(|ray| leaf.error_px(ray, self.head(ray), self.view) <= self.accuracy_px)
    }

    /// Adds the node of a block with all that is below it; its number.
    fn add(&self, tree: &mut Tree, block: Block) -> u32 {
        let rays: Vec<GridRay> = self.rays(block).map(|(_, _, ray)| *ray).collect();
        let extent = [0, 1].map(|axis| block.high[axis] - block.low[axis]);
        let smallest = extent.iter().all(|&cells| cells <= 1);
        let below = match self.fitted(&rays, extent[0].max(extent[1])) {
            Some(leaf) => self.leaf(tree, leaf, block),
            None if smallest => {
                tree.inaccurate_leaves += 1;
                tree.inaccurate_rays += rays.len() as u64;
                let leaf = Leaf::fit(&rays, 1, 1).or_else(|| Leaf::fit(&rays[..1], 0, 1));
                match leaf {
                    Some(leaf) => self.leaf(tree, leaf, block),
                    None => Below::Nodes([u32::MAX; 2]),
                }
            }
            None => {
                let axis = usize::from(extent[1] > extent[0]);
                let middle = block.low[axis] + extent[axis] / 2;
                // Both halves hold the rays between them: no seam opens.
                let (mut first, mut second) = (block, block);
                (first.high[axis], second.low[axis]) = (middle, middle);
                let children = [first, second].map(|half| match self.shrunk(half) {
                    Some(block) => self.add(tree, block),
                    None => u32::MAX,
                });
                Below::Nodes(children)
            }
        };
        let beam = self.beam(block);
        tree.nodes.push(Node { beam, below });
        tree.nodes.len() as u32 - 1
    }

    fn leaf(&self, tree: &mut Tree, leaf: Leaf, block: Block) -> Below {
        tree.leaves.push((leaf, block));
        Below::Leaf(tree.leaves.len() as u32 - 1)
    }

    /// The fit of the highest degree that is accurate, if there is one.
    fn fitted(&self, rays: &[GridRay], cells: u32) -> Option<Leaf> {
        let step = rays.len().div_ceil(MOST_FITTED).max(1);
        let some: Vec<GridRay> = rays.iter().step_by(step).copied().collect();
        for degree in [3, 2, 1] {
            let leaf = Leaf::fit(&some, degree, cells).filter(|leaf| self.is_accurate(leaf, &some));
            if let Some(leaf) = leaf.filter(|leaf| step == 1 || self.is_accurate(leaf, rays)) {
                return Some(leaf);
            }
        }
        None
    }

    /// What the block's rays and those around it reach.
    fn beam(&self, block: Block) -> Beam {
        let around = Block {
            low: block.low.map(|low| low.saturating_sub(1)),
            high: [(block.high[0] + 1).min(self.grid.columns - 1), (block.high[1] + 1).min(self.grid.rows - 1)],
        };
        let mut reaches = Vec::new();
        for (column, row, ray) in self.rays(around) {
            reaches.push(Reach::of_ray(ray.tail, ray.direction));
            // Beyond the border of the path rays go on; at silhouettes they turn faster and faster.
            for [right, down] in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
                let neighbour = |side: i64| self.ray_at(column as i64 + side * right, row as i64 + side * down);
                if let (None, Some(opposite)) = (neighbour(1), neighbour(-1)) {
                    let beyond = |own: DVec3, opposite: DVec3| own + (own - opposite) * EXTRAPOLATED;
                    let direction = beyond(ray.direction, opposite.direction).normalize_or(ray.direction);
                    reaches.push(Reach::of_ray(beyond(ray.tail, opposite.tail), direction));
                }
            }
        }
        Beam::around(&reaches, TYPICAL_SHARE * f64::from(self.bounds.diagonal()))
    }
}

impl Tree {
    /// Calls `found` for every leaf whose beam holds a point.
    pub(super) fn leaves_at(&self, point: DVec3, mut found: impl FnMut(&Leaf, &Block)) {
        let point: Vec3 = point.as_vec3();
        let rounding = rounding_at(point);
        let mut waiting = [0u32; MOST_WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        waiting[0] = self.nodes.len().saturating_sub(1) as u32;
        while count > 0 {
            count -= 1;
            let Some(node) = self.nodes.get(waiting[count] as usize) else { continue };
            if !node.beam.holds(point, rounding) {
                continue;
            }
            match node.below {
                Below::Leaf(leaf) => {
                    let (leaf, block) = &self.leaves[leaf as usize];
                    found(leaf, block);
                }
                Below::Nodes(children) => {
                    for child in children {
                        if count < waiting.len() {
                            waiting[count] = child;
                            count += 1;
                        }
                    }
                }
            }
        }
    }

    /// The leaf at a place, in cells.
    pub(super) fn leaf_at(&self, grid: &RayGrid, [x, y]: [f64; 2]) -> Option<&(Leaf, Block)> {
        let cell = [x.round(), y.round()];
        let counts = [grid.columns, grid.rows];
        if !(0..2).all(|axis| cell[axis] >= 0.0 && cell[axis] < f64::from(counts[axis])) {
            return None;
        }
        let leaf = *self.leaf_of_cell.get(cell[1] as usize * grid.columns as usize + cell[0] as usize)?;
        self.leaves.get(leaf as usize)
    }

    /// Memory of the tree.
    pub(super) fn byte_count(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.leaves.as_slice())
            + size_of_val(self.leaf_of_cell.as_slice())
    }
}
