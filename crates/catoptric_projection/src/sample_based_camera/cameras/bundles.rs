//! The leaves of kind `ray_bundle`: blocks of the ray map, halved until a leaf is accurate, found by beams.

use super::answer::Counts;
use super::builder::{Added, CameraBuilder, MAX_FITTED, PARALLEL_RAYS, TYPICAL_SHARE};
use super::fit::{Fit, FitSpan, FitTerms, is_accurate};
use crate::find::ray_map::{BeamTree, Reach};
use crate::sample_based_camera::layout::{BundleLeaf, WordReader, WordWriter};
use crate::sample_based_camera::rays::grid_ray::GridRay;
use catoptric_core::parallel;
use glam::{DVec3, Vec2, Vec3};

/// Halves of blocks of this many cells share a whole cell, those of smaller ones a row of rays. Chosen, not measured.
const SHARED_CELLS: u32 = 8;

/// Beams hold all rays at the edges of a leaf and about this many in its middle. Chosen, not measured.
const MIDDLE_REACHES: usize = 64;

/// The number of a missing leaf.
const NO_LEAF: u32 = u32::MAX;

/// The leaves of one path.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct BundleTree {
    leaves: Vec<BundleLeaf>,
    beams: BeamTree,
    /// The leaf that each ray belongs to, or [`NO_LEAF`].
    leaf_of_ray: Vec<u32>,
    /// Leaves of the smallest size, whose fit is not accurate: they interpolate between their rays.
    interpolating_leaves: u64,
    rays_in_interpolating_leaves: u64,
    unrefined_blocks: u64,
    /// Corners of the blocks, in cells, that have no leaves.
    left_out: Vec<[[f32; 2]; 2]>,
}

/// A leaf with the numbers of its rays: those of the map first, then those that were added.
struct Built {
    leaf: BundleLeaf,
    rays: Vec<u32>,
}

/// Leaves, and the rays traced to make them.
#[derive(Default)]
pub(in super::super) struct Leaves {
    built: Vec<Built>,
    pub(in super::super) added: Vec<GridRay>,
    pub(in super::super) traced: u64,
    /// Blocks that interpolate although rays between theirs could be traced: there were too many.
    pub(in super::super) unrefined: u64,
    /// Blocks of the map that cannot be halved any more, without a leaf so far: their rays.
    waiting: Vec<WaitingBlock>,
    /// Corners of the blocks, in cells, that are left without.
    left_out: Vec<[[f32; 2]; 2]>,
}

/// The rays of a block and their piece.
struct WaitingBlock {
    rays: Vec<u32>,
    piece: u32,
}

impl Leaves {
    pub(in super::super) fn push(&mut self, leaf: BundleLeaf, rays: Vec<u32>) {
        self.built.push(Built { leaf, rays });
    }

    /// The union of two sets of leaves, over a map of so many rays.
    fn and(mut self, other: Self, in_map: usize) -> Self {
        let shift = self.added.len() as u32;
        let shifted = |ray: u32| if ray as usize >= in_map { ray + shift } else { ray };
        self.built.extend(other.built.into_iter().map(|mut one| {
            one.rays.iter_mut().for_each(|ray| *ray = shifted(*ray));
            one
        }));
        self.added.extend(other.added);
        self.waiting.extend(other.waiting);
        self.left_out.extend(other.left_out);
        self.traced += other.traced;
        self.unrefined += other.unrefined;
        self
    }
}

impl CameraBuilder<'_> {
    /// The leaves over all rays of the path, and the rays that were added to those of the map.
    pub(in super::super) fn bundle_tree(&self) -> (BundleTree, Added) {
        let pieces = self.pieces();
        let in_map = self.group.rays.len();
        let leaves = parallel::map_collect(pieces.len(), |piece| self.divided(&pieces[piece], piece as u32))
            .into_iter()
            .reduce(|one, other| one.and(other, in_map))
            .unwrap_or_default();
        let Leaves { built, added, traced, unrefined, left_out, .. } = self.with_finer(leaves);
        let leaf_of_ray = vec![NO_LEAF; in_map + added.len()];
        let mut tree = BundleTree { leaf_of_ray, unrefined_blocks: unrefined, left_out, ..BundleTree::default() };
        let reaches = parallel::map_collect(built.len(), |leaf| self.reaches(&built[leaf], &added));
        let mut ends = Vec::with_capacity(built.len());
        let mut end = 0;
        for (index, one) in built.iter().enumerate() {
            if one.leaf.interpolates != 0 {
                tree.interpolating_leaves += 1;
                tree.rays_in_interpolating_leaves += one.rays.len() as u64;
            }
            for &ray in &one.rays {
                tree.leaf_of_ray[ray as usize] = index as u32;
            }
            end += reaches[index].len();
            ends.push(end);
        }
        let pieces = built.iter().flat_map(|one| one.rays.iter().map(|&ray| (ray, one.leaf.piece)));
        let mut piece_of_added = vec![0; added.len()];
        for (ray, piece) in pieces.filter_map(|(ray, piece)| Some(((ray as usize).checked_sub(in_map)?, piece))) {
            piece_of_added[ray] = piece;
        }
        tree.leaves = built.iter().map(|one| one.leaf).collect();
        tree.beams = BeamTree::new(&reaches.concat(), ends, TYPICAL_SHARE * f64::from(self.bounds.diagonal()));
        (tree, Added { rays: added.into_iter().zip(piece_of_added).collect(), traced })
    }

    /// Adds leaves over blocks that wait for rays between theirs, which share the limit of traced rays.
    fn with_finer(&self, mut leaves: Leaves) -> Leaves {
        let waiting = std::mem::take(&mut leaves.waiting);
        if self.demand.leaves_out {
            for block in waiting {
                let rays = block.rays.iter().map(|&ray| &self.group.rays[ray as usize]);
                leaves.left_out.push(places_of(rays));
            }
            return leaves;
        }
        let limit = self.demand.traced_a_ray.saturating_mul(self.group.rays.len() as u64) / waiting.len().max(1) as u64;
        let finer = |index: usize| self.finer(&waiting[index].rays, waiting[index].piece, limit);
        let finer = parallel::map_collect(waiting.len(), finer);
        finer.into_iter().fold(leaves, |all, one| all.and(one, self.group.rays.len()))
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
    fn divided(&self, rays: &[u32], piece: u32) -> Leaves {
        let [low, high] = self.extent(rays);
        if let Some(fit) = self.fitted(rays) {
            let own = rays.iter().map(|&ray| &self.group.rays[ray as usize]);
            let places = places_of(own.clone());
            let mut leaves = Leaves::default();
            let span = FitSpan { apart: 1.0, interpolates: false };
            leaves.push(fit.leaf(own, piece, places, span), rays.to_vec());
            return leaves;
        }
        let extent = [0, 1].map(|axis: usize| high[axis] - low[axis]);
        if extent.iter().all(|&cells| cells <= 1) {
            let waiting = vec![WaitingBlock { rays: rays.to_vec(), piece }];
            return Leaves { waiting, ..Leaves::default() };
        }
        let axis = usize::from(extent[1] > extent[0]);
        let middle = i64::from(low[axis] + extent[axis] / 2);
        // Both halves hold the rays between them, so that no seam opens.
        let shared = middle + i64::from(extent[axis] >= SHARED_CELLS);
        let place = |ray: &&u32| self.group.cell_of(**ray as usize)[axis];
        let first: Vec<u32> = rays.iter().filter(|ray| place(ray) <= shared).copied().collect();
        let second: Vec<u32> = rays.iter().filter(|ray| place(ray) >= middle).copied().collect();
        let (leaves, others) =
            parallel::join(rays.len() > PARALLEL_RAYS, || self.divided(&first, piece), || self.divided(&second, piece));
        leaves.and(others, self.group.rays.len())
    }

    /// The fit of the highest degree to rays of the map, if it is accurate.
    fn fitted(&self, rays: &[u32]) -> Option<Fit> {
        let gathered = |indices: &mut dyn Iterator<Item = u32>| -> Vec<GridRay> {
            indices.map(|ray| self.group.rays[ray as usize]).collect()
        };
        let count = rays.len();
        if count <= MAX_FITTED {
            return self.fit_to(&gathered(&mut rays.iter().copied()), 1.0);
        }
        // The subset has one ray of every so many, not in step with the rows.
        let start = |stratum: usize| stratum * count / MAX_FITTED;
        let pick = |stratum: usize| {
            let (from, to) = (start(stratum), start(stratum + 1));
            rays[from + (stratum.wrapping_mul(0x9e37_79b9) >> 7) % (to - from)]
        };
        let some = gathered(&mut (0..MAX_FITTED).map(pick));
        // Lower degrees are for few rays.
        let fit = self.accurate(&some, &[FitTerms::Cubic], 1.0)?;
        let all = gathered(&mut rays.iter().copied());
        self.is_accurate(&fit, &all).then_some(fit)
    }

    /// The fit of the highest degree to all of a few rays, which are `apart` from each other (in cells), if it is
    /// accurate.
    pub(in super::super) fn fit_to(&self, rays: &[GridRay], apart: f32) -> Option<Fit> {
        self.accurate(rays, &[FitTerms::Cubic, FitTerms::Quadratic, FitTerms::Linear], apart)
    }

    fn accurate(&self, rays: &[GridRay], shapes: &[FitTerms], apart: f32) -> Option<Fit> {
        let heads = self.heads(rays);
        let lines = lines_of(rays, apart);
        let accurate = |fit: &Fit| is_accurate(fit, rays, &heads, self.view, self.demand.accuracy_px);
        let mut shapes = shapes.iter().filter(|shape| shape.is_tested_by(lines));
        shapes.find_map(|&shape| Fit::all(rays, shape).find(accurate))
    }

    fn is_accurate(&self, fit: &Fit, rays: &[GridRay]) -> bool {
        is_accurate(fit, rays, &self.heads(rays), self.view, self.demand.accuracy_px)
    }

    fn heads(&self, rays: &[GridRay]) -> Vec<f32> {
        rays.iter().map(|ray| self.head(ray) as f32).collect()
    }

    /// The reach of a leaf's rays and those a little beyond the border of the path reach.
    fn reaches(&self, built: &Built, added: &[GridRay]) -> Vec<Reach> {
        let BundleLeaf { low_place, high_place, piece, .. } = built.leaf;
        let in_map = self.group.rays.len();
        let mut reaches: Vec<Reach> = Vec::with_capacity(256);
        let step = (built.rays.len() / MIDDLE_REACHES).max(1);
        for (index, &number) in built.rays.iter().enumerate() {
            let number = number as usize;
            let Some(own) = self.group.rays.get(number) else {
                let ray = &added[number - in_map];
                reaches.push(Reach::of_ray(ray.tail, ray.direction));
                continue;
            };
            let [column, row] = self.group.cell_of(number);
            let at_edge = [column, row]
                .iter()
                .zip(low_place.iter().zip(&high_place))
                .any(|(&cell, (&low, &high))| cell as f32 <= low || cell as f32 >= high);
            let regular = self.group.regular(column, row).filter(|&regular| self.group.piece_of_ray[regular] == piece);
            let beside_border = regular != Some(number);
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

/// The rectangle that holds the places of rays: its corners.
pub(in super::super) fn places_of<'a>(rays: impl Iterator<Item = &'a GridRay>) -> [[f32; 2]; 2] {
    let nothing = [Vec2::INFINITY, Vec2::NEG_INFINITY];
    let around = |[low, high]: [Vec2; 2], place: Vec2| [low.min(place), high.max(place)];
    rays.map(|ray| Vec2::from(ray.place)).fold(nothing, around).map(|corner| corner.to_array())
}

/// The numbers of columns and rows that hold rays which are `apart` from each other: at most 64.
fn lines_of(rays: &[GridRay], apart: f32) -> [u32; 2] {
    let [low, _] = places_of(rays.iter());
    [0, 1].map(|axis: usize| {
        let line = |ray: &GridRay| ((ray.place[axis] - low[axis]) / apart).round().clamp(0.0, 63.0) as u32;
        rays.iter().fold(0u64, |lines, ray| lines | 1 << line(ray)).count_ones()
    })
}

impl BundleTree {
    /// Appends the numbers of the leaves whose beams hold a point.
    pub(in super::super) fn leaves_at(&self, point: Vec3, found: &mut Vec<u32>) {
        self.beams.leaves_at(point.to_array(), found);
    }

    /// Corners of the blocks of the map, in cells, that have no leaves.
    pub(in super::super) fn left_out(&self) -> &[[[f32; 2]; 2]] {
        &self.left_out
    }

    /// The leaf of a number.
    #[inline]
    pub(in super::super) fn leaf(&self, number: u32) -> Option<&BundleLeaf> {
        self.leaves.get(number as usize)
    }

    /// Forgets which leaf each ray belongs to.
    pub(in super::super) fn forget_rays(&mut self) {
        self.leaf_of_ray = Vec::new();
    }

    /// Writes it, but for which leaf each ray belongs to.
    pub(in super::super) fn store(&self, words: &mut WordWriter) {
        words.records(&self.leaves);
        words.records(&self.beams.numbers().collect::<Vec<f32>>());
        words.counts([self.interpolating_leaves, self.rays_in_interpolating_leaves, self.unrefined_blocks]);
    }

    /// The leaves that [`Self::store`] has written; `None` for other words.
    pub(in super::super) fn stored(words: &mut WordReader<'_>) -> Option<Self> {
        let leaves: Vec<BundleLeaf> = words.records()?;
        let beams = BeamTree::of_numbers(leaves.len(), &words.records::<f32>()?)?;
        let [interpolating_leaves, rays_in_interpolating_leaves, unrefined_blocks] = words.counts()?;
        (interpolating_leaves <= leaves.len() as u64).then_some(Self {
            leaves,
            beams,
            leaf_of_ray: Vec::new(),
            interpolating_leaves,
            rays_in_interpolating_leaves,
            unrefined_blocks,
            left_out: Vec::new(),
        })
    }

    /// The rays have got other numbers: the old ones by the new.
    pub(in super::super) fn renumber(&mut self, order: &[u32]) {
        self.leaf_of_ray = order.iter().map(|&ray| self.leaf_of_ray[ray as usize]).collect();
    }

    /// The leaf of a ray.
    pub(in super::super) fn leaf_of(&self, ray: usize) -> Option<&BundleLeaf> {
        self.leaf(self.leaf_number(ray)?)
    }

    /// The number of the leaf of a ray.
    pub(in super::super) fn leaf_number(&self, ray: usize) -> Option<u32> {
        self.leaf_of_ray.get(ray).copied().filter(|leaf| *leaf != NO_LEAF)
    }

    pub(in super::super) fn counts(&self) -> Counts {
        let bytes =
            size_of_val(self.leaves.as_slice()) + self.beams.byte_count() + size_of_val(self.leaf_of_ray.as_slice());
        Counts {
            leaves: self.leaves.len() as u64 - self.interpolating_leaves,
            ray_lists: self.interpolating_leaves,
            rays_in_lists: self.rays_in_interpolating_leaves,
            unrefined_blocks: self.unrefined_blocks,
            unsplit_lists: 0,
            bytes: bytes as u64,
        }
    }
}
