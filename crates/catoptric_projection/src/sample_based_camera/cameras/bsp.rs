//! The paper's tree: splitting planes, pinholes in its leaves, and lists of rays where no split helps (Popescu, Sacks,
//! Mei 2006, Figure 10).

use super::answer::{CameraAnswer, CameraScratch, Counts, LeafNumber};
use super::builder::{CameraBuilder, MAX_FITTED, PARALLEL_RAYS, TYPICAL_SHARE};
use super::bundle;
use super::fit::{Fit, FitSpan};
use super::pinhole;
use crate::find::ray_map::{BeamTree, Reach};
use crate::sample_based_camera::layout::{BundleLeaf, PinholeLeaf, SplitNode, WordReader, WordWriter};
use crate::sample_based_camera::rays::grid_ray::GridRay;
use catoptric_core::parallel;
use glam::{DVec3, Vec3};
use std::collections::BTreeSet;

/// A tree's splits look at no more than this many times its rays: a balanced tree of a hundred thousand rays has 17
/// levels, and some rays are on both sides. Chosen, not measured.
const MAX_LEVELS: f64 = 48.0;

/// The trees of one path: one for each connected region of rays.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct PinholeTrees {
    /// Start of the tree of each piece: a number as in [`SplitNode::children`].
    roots: Vec<u32>,
    nodes: Vec<SplitNode>,
    leaves: Vec<PinholeLeaf>,
    /// Interpolations between listed rays, in the cells of the map: inside their unit frusta.
    cells: Vec<BundleLeaf>,
    beams: BeamTree,
    lists: u64,
    listed_rays: u64,
    /// Lists that could have been split further.
    unsplit: u64,
}

/// A tree as it is built.
enum BspBranch {
    Camera(Box<PinholeLeaf>),
    List { rays: Vec<u32>, unsplit: bool },
    Split { normal: Vec3, offset: f32, children: Box<[BspBranch; 2]> },
}

impl CameraBuilder<'_> {
    /// The trees over all rays of the path.
    pub(in super::super) fn pinhole_trees(&self) -> PinholeTrees {
        let group = self.group;
        let heads: Vec<f32> = group.rays.iter().map(|ray| self.head(ray) as f32).collect();
        let pieces = self.pieces();
        let branches = parallel::map_collect(pieces.len(), |piece| {
            let rays = &pieces[piece];
            self.branch(rays, &heads, MAX_LEVELS * rays.len() as f64)
        });
        let mut trees = PinholeTrees::default();
        let mut cells = BTreeSet::new();
        for (piece, branch) in branches.into_iter().enumerate() {
            let root = self.add(branch, piece as u32, &mut trees, &mut cells);
            trees.roots.push(root);
        }
        let (mut reaches, mut ends) = (Vec::new(), Vec::new());
        for (cell, piece) in cells {
            let rays: Vec<GridRay> = group.in_unit(cell, piece).map(|ray| group.rays[ray]).collect();
            let Some(fit) = Fit::interpolating(&rays) else { continue };
            let places = [cell, cell.map(|low| low + 1)].map(|corner| corner.map(|index| index as f32));
            trees.cells.push(fit.leaf(rays.iter(), piece, places, FitSpan { apart: 1.0, interpolates: true }));
            reaches.extend(rays.iter().map(|ray| Reach::of_ray(ray.tail, ray.direction)));
            ends.push(reaches.len());
        }
        trees.beams = BeamTree::new(&reaches, ends, TYPICAL_SHARE * f64::from(self.bounds.diagonal()));
        trees
    }

    fn gathered(&self, rays: impl Iterator<Item = u32>, heads: &[f32]) -> (Vec<GridRay>, Vec<f32>) {
        rays.map(|ray| (self.group.rays[ray as usize], heads[ray as usize])).unzip()
    }

    fn camera(&self, rays: &[u32], heads: &[f32]) -> Option<PinholeLeaf> {
        let accurate = |leaf: &PinholeLeaf, some: &(Vec<GridRay>, Vec<f32>)| {
            pinhole::is_accurate(leaf, &some.0, &some.1, self.view, self.demand.accuracy_px)
        };
        if rays.len() > MAX_FITTED {
            let some = self.gathered(rays.iter().copied().step_by(rays.len().div_ceil(MAX_FITTED)), heads);
            // Half as much again: a fit to all rays is a little better for them.
            let tried = pinhole::fit(&some.0, &some.1)?;
            if !pinhole::is_accurate(&tried, &some.0, &some.1, self.view, 1.5 * self.demand.accuracy_px) {
                return None;
            }
        }
        let all = self.gathered(rays.iter().copied(), heads);
        pinhole::fit(&all.0, &all.1).filter(|leaf| accurate(leaf, &all))
    }

    /// The tree over some rays; its splits look at no more than `budget` rays.
    fn branch(&self, rays: &[u32], heads: &[f32], budget: f64) -> BspBranch {
        if let Some(camera) = self.camera(rays, heads) {
            return BspBranch::Camera(Box::new(camera));
        }
        let list = |unsplit| BspBranch::List { rays: rays.to_vec(), unsplit };
        let Some((normal, offset)) = self.plane(rays) else { return list(false) };
        let sides: Vec<[bool; 2]> = rays.iter().map(|&ray| self.sides(ray, normal, offset, heads)).collect();
        let subset = |side: usize| -> Vec<u32> {
            rays.iter().zip(&sides).filter(|(_, sides)| sides[side]).map(|(ray, _)| *ray).collect()
        };
        let (positive, negative) = (subset(0), subset(1));
        let fails = positive.len() == rays.len() || negative.len() == rays.len();
        let handled = (positive.len() + negative.len()) as f64;
        if fails || handled > f64::from(self.demand.max_shared) * rays.len() as f64 {
            return list(false);
        }
        // The paper's rule alone goes on for as long as a ray less is left on each side.
        if handled > budget {
            return list(true);
        }
        let share = |side: &[u32]| (budget - handled) * side.len() as f64 / handled;
        let children = parallel::join(
            rays.len() > PARALLEL_RAYS,
            || self.branch(&positive, heads, share(&positive)),
            || self.branch(&negative, heads, share(&negative)),
        );
        BspBranch::Split { normal: normal.as_vec3(), offset: offset as f32, children: Box::new(children.into()) }
    }

    /// The splitting plane: through the middle of the tails, along the mean direction, across the tails' diameter.
    fn plane(&self, rays: &[u32]) -> Option<(DVec3, f64)> {
        let rays = || rays.iter().map(|&ray| &self.group.rays[ray as usize]);
        let center = rays().map(|ray| ray.tail).sum::<DVec3>() / rays().count() as f64;
        let direction = rays().map(|ray| ray.direction).sum::<DVec3>().try_normalize()?;
        let farthest = |from: DVec3| {
            let tails = rays().map(|ray| ray.tail);
            tails.max_by(|a, b| a.distance_squared(from).total_cmp(&b.distance_squared(from)))
        };
        let one = farthest(center)?;
        let diameter = farthest(one)? - one;
        let normal = diameter.reject_from_normalized(direction).try_normalize()?;
        Some((normal, center.dot(normal)))
    }

    /// The sides of a plane on which a ray lies with its unit frustum: the four rays around it.
    fn sides(&self, ray: u32, normal: DVec3, offset: f64, heads: &[f32]) -> [bool; 2] {
        let group = self.group;
        let [column, row] = group.cell_of(ray as usize);
        let piece = group.piece_of_ray[ray as usize];
        let corners = [(1, 1), (1, -1), (-1, 1), (-1, -1)];
        let around = corners.iter().filter_map(|(right, down)| group.regular(column + right, row + down));
        let mut sides = [false; 2];
        for ray in around.filter(|&ray| group.piece_of_ray[ray] == piece).chain([ray as usize]) {
            let ends = &group.rays[ray];
            for end in [ends.tail, ends.tail + ends.direction * f64::from(heads[ray])] {
                sides[usize::from(end.dot(normal) <= offset)] = true;
            }
        }
        sides
    }

    /// Appends a tree; its number as in [`SplitNode::children`].
    fn add(
        &self,
        branch: BspBranch,
        piece: u32,
        trees: &mut PinholeTrees,
        cells: &mut BTreeSet<([u32; 2], u32)>,
    ) -> u32 {
        match branch {
            BspBranch::Camera(leaf) => {
                trees.leaves.push(*leaf);
                SplitNode::LEAF | (trees.leaves.len() - 1) as u32
            }
            BspBranch::List { rays, unsplit } => {
                trees.lists += 1;
                trees.unsplit += u64::from(unsplit);
                trees.listed_rays += rays.len() as u64;
                for ray in rays {
                    let [column, row] = self.group.cell_of(ray as usize).map(|cell| cell as u32);
                    for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        cells.insert(([column.saturating_sub(right), row.saturating_sub(down)], piece));
                    }
                }
                SplitNode::LIST
            }
            BspBranch::Split { normal, offset, children } => {
                let number = trees.nodes.len();
                let node = SplitNode { normal: normal.to_array(), offset, children: [SplitNode::LIST; 2] };
                trees.nodes.push(node);
                let children = children.map(|child| self.add(child, piece, trees, cells));
                trees.nodes[number].children = children;
                number as u32
            }
        }
    }
}

impl PinholeTrees {
    /// The number of trees.
    pub(in super::super) fn piece_count(&self) -> u32 {
        self.roots.len() as u32
    }

    /// Writes them.
    pub(in super::super) fn store(&self, words: &mut WordWriter) {
        words.numbers(&self.roots);
        words.records(&self.nodes);
        words.records(&self.leaves);
        words.records(&self.cells);
        words.records(&self.beams.numbers().collect::<Vec<f32>>());
        words.counts([self.lists, self.listed_rays, self.unsplit]);
    }

    /// The trees that [`Self::store`] has written; `None` for other words.
    pub(in super::super) fn stored(words: &mut WordReader<'_>) -> Option<Self> {
        let roots = words.numbers()?.to_vec();
        let nodes: Vec<SplitNode> = words.records()?;
        let (leaves, cells): (Vec<PinholeLeaf>, Vec<BundleLeaf>) = (words.records()?, words.records()?);
        let beams = BeamTree::of_numbers(cells.len(), &words.records::<f32>()?)?;
        let [lists, listed_rays, unsplit] = words.counts()?;
        // Ways lead from nodes to later ones: they end.
        let goes_on = |(number, node): (usize, &SplitNode)| {
            node.children.iter().all(|child| child & SplitNode::LEAF != 0 || *child as usize > number)
        };
        nodes.iter().enumerate().all(goes_on).then_some(Self {
            roots,
            nodes,
            leaves,
            cells,
            beams,
            lists,
            listed_rays,
            unsplit,
        })
    }

    /// Calls `found` with the trees' projections of a point.
    pub(in super::super) fn ask(
        &self,
        point: Vec3,
        scratch: &mut CameraScratch,
        mut found: impl FnMut(&CameraAnswer<'_>),
    ) {
        let CameraScratch { numbers, answers } = scratch;
        // The pieces in whose trees the point is in a list come first in the scratch.
        for (piece, &root) in self.roots.iter().enumerate() {
            let at = self.end_at(root, point);
            if at == SplitNode::LIST {
                numbers.push(piece as u32);
            } else if let Some(leaf) = self.leaves.get((at & !SplitNode::LEAF) as usize)
                && let Some(answer) = &pinhole::ask(leaf, point)
            {
                found(&CameraAnswer { answer, piece: piece as u32, places: None, apart: 1.0, interpolates: false });
            }
        }
        let listed = numbers.len();
        if listed == 0 {
            return;
        }
        self.beams.leaves_at(point.to_array(), numbers);
        let (pieces, cells) = numbers.split_at(listed);
        for leaf in cells.iter().filter_map(|&cell| self.cells.get(cell as usize)) {
            if pieces.binary_search(&leaf.piece).is_err() {
                continue;
            }
            answers.clear();
            bundle::ask(leaf, point, answers);
            for answer in answers.iter() {
                found(&CameraAnswer::of(answer, leaf));
            }
        }
    }

    /// The leaf to which the tree with this root sends a point: a number as in [`SplitNode::children`].
    fn end_at(&self, root: u32, point: Vec3) -> u32 {
        let mut at = root;
        while at & SplitNode::LEAF == 0 {
            let Some(node) = self.nodes.get(at as usize) else { break };
            at = node.children[usize::from(point.dot(node.normal.into()) <= node.offset)];
        }
        at
    }

    /// The leaf that is asked for a point in a piece; all lists of rays of a piece count as one.
    pub(in super::super) fn leaf_at(&self, piece: u32, point: Vec3) -> Option<LeafNumber> {
        match self.end_at(*self.roots.get(piece as usize)?, point) {
            SplitNode::LIST => Some(LeafNumber { number: piece, is_list: true }),
            leaf => Some(LeafNumber { number: leaf & !SplitNode::LEAF, is_list: false }),
        }
    }

    pub(in super::super) fn counts(&self) -> Counts {
        let bytes = size_of_val(self.nodes.as_slice())
            + size_of_val(self.leaves.as_slice())
            + size_of_val(self.cells.as_slice())
            + self.beams.byte_count();
        Counts {
            leaves: self.leaves.len() as u64,
            ray_lists: self.lists,
            rays_in_lists: self.listed_rays,
            unrefined_blocks: 0,
            unsplit_lists: self.unsplit,
            bytes: bytes as u64,
        }
    }
}
