//! A hierarchy of beams, eight in a node: which of many bundles of rays may pass through a point.

use super::super::work;
use super::beam::{Beam, BeamPlane, PLANES, Reach, rounding_at};
use catoptric_core::math::lanes::{LANES, Lanes, Vec3Lanes, bits_of};
use catoptric_core::parallel;

/// The beams of eight nodes of the next level (or of eight leaves), one lane a beam.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
struct BeamNode {
    normal: [Vec3Lanes; PLANES],
    limit: [Lanes; PLANES],
}

impl BeamNode {
    fn of(beams: &[Beam]) -> Self {
        let lane = |lane: usize| beams.get(lane).copied().unwrap_or(Beam::NOTHING).0;
        let lanes: [[BeamPlane; PLANES]; LANES] = std::array::from_fn(lane);
        Self {
            normal: std::array::from_fn(|plane| Vec3Lanes::new(&lanes.map(|beam| beam[plane].normal))),
            limit: std::array::from_fn(|plane| Lanes(lanes.map(|beam| beam[plane].limit))),
        }
    }

    /// The count of numbers that it consists of.
    const NUMBERS: usize = 4 * PLANES * LANES;

    fn numbers(&self) -> impl Iterator<Item = f32> {
        let of_plane = |(normal, limit): (&Vec3Lanes, &Lanes)| [normal[0], normal[1], normal[2], *limit];
        self.normal.iter().zip(&self.limit).flat_map(of_plane).flat_map(|lanes| lanes.0)
    }

    fn of_numbers(numbers: &[f32; Self::NUMBERS]) -> Self {
        let lanes = |at: usize| Lanes(std::array::from_fn(|lane| numbers[at * LANES + lane]));
        Self {
            normal: std::array::from_fn(|plane| Vec3Lanes([0, 1, 2].map(|axis| lanes(4 * plane + axis)))),
            limit: std::array::from_fn(|plane| lanes(4 * plane + 3)),
        }
    }

    /// Mask of its beams that hold a point, but for rounding.
    #[inline(always)]
    fn holding(&self, point: [f32; 3], rounding: f32) -> u8 {
        let mut holding = [true; LANES];
        for (normal, limit) in self.normal.iter().zip(&self.limit) {
            for lane in 0..LANES {
                let along = point[0] * normal[0][lane] + point[1] * normal[1][lane] + point[2] * normal[2][lane];
                holding[lane] &= along <= limit[lane] + rounding;
            }
        }
        bits_of(holding)
    }
}

/// The hierarchy over leaves, of which it holds the beams only.
#[derive(Clone, Debug, Default)]
pub struct BeamTree {
    /// The root first, then level by level; the last level's children are the leaves.
    nodes: Vec<BeamNode>,
    /// Index of the children of a node's first lane: among the nodes, or from `nodes.len()` on among the leaves.
    first_children: Vec<u32>,
}

/// Stack size: at most eleven levels (2^32 leaves), each with at most eight waiting.
const MAX_WAITING: usize = 12 * LANES;

/// Index of the children of each node's first lane, by the sizes of the levels from the leaves up.
fn first_children(sizes: &[usize]) -> Vec<u32> {
    let mut children = Vec::new();
    for size in sizes.iter().rev() {
        let next = children.len() + size;
        children.extend((0..*size).map(|node| (next + node * LANES) as u32));
    }
    children
}

impl BeamTree {
    /// Over leaves that reach `reaches[ends[leaf - 1]..ends[leaf]]`; leaves that follow one another should be near each
    /// other. Points are expected about `distance` away from where rays start.
    pub fn new(reaches: &[Reach], mut ends: Vec<usize>, distance: f64) -> Self {
        // Levels from the leaves up: the beams of a level's nodes, eight nodes of which are a node of the next.
        let mut levels: Vec<Vec<BeamNode>> = Vec::new();
        while levels.is_empty() || ends.len() > 1 {
            let start = |node: usize| if node == 0 { 0 } else { ends[node - 1] };
            let beam = |node: usize| Beam::around(&reaches[start(node)..ends[node]], distance);
            let beams = parallel::map_collect(ends.len(), beam);
            levels.push(beams.chunks(LANES).map(BeamNode::of).collect());
            ends = ends.chunks(LANES).filter_map(|ends| ends.last().copied()).collect();
        }
        let sizes: Vec<usize> = levels.iter().map(Vec::len).collect();
        Self { nodes: levels.into_iter().rev().flatten().collect(), first_children: first_children(&sizes) }
    }

    /// The numbers that it consists of.
    pub fn numbers(&self) -> impl Iterator<Item = f32> {
        self.nodes.iter().flat_map(BeamNode::numbers)
    }

    /// The hierarchy over so many leaves that consists of these numbers ([`Self::numbers`]); `None` where there are
    /// more or fewer of them.
    pub fn of_numbers(leaves: usize, numbers: &[f32]) -> Option<Self> {
        let (nodes, []) = numbers.as_chunks::<{ BeamNode::NUMBERS }>() else { return None };
        // Levels are counted from the leaves up, as they are built.
        let mut levels = vec![leaves.div_ceil(LANES)];
        while let Some(&last) = levels.last().filter(|last| **last > 1) {
            levels.push(last.div_ceil(LANES));
        }
        let is_whole = levels.iter().sum::<usize>() == nodes.len();
        is_whole.then(|| Self {
            nodes: nodes.iter().map(BeamNode::of_numbers).collect(),
            first_children: first_children(&levels),
        })
    }

    /// Calls `found` with every leaf whose beam holds a point, but for rounding.
    #[inline(always)]
    pub fn visit(&self, point: [f32; 3], mut found: impl FnMut(u32)) {
        let rounding = rounding_at(point.into());
        let mut waiting = [0u32; MAX_WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        let mut visited = 0;
        while count > 0 {
            count -= 1;
            visited += 1;
            let node = waiting[count] as usize;
            let mut holding = self.nodes[node].holding(point, rounding);
            let first = self.first_children[node];
            while holding != 0 {
                let child = first + holding.trailing_zeros();
                holding &= holding - 1;
                match (child as usize).checked_sub(self.nodes.len()) {
                    Some(leaf) => found(leaf as u32),
                    None => {
                        waiting[count] = child;
                        count += 1;
                    }
                }
            }
        }
        work::add(visited);
    }

    /// True if a leaf's beam may hold a point of a ball: so none does if it is false.
    pub fn may_hold_any(&self, center: [f32; 3], radius: f32) -> bool {
        may_hold_any(self, center, radius)
    }

    /// Appends every leaf whose beam holds a point, but for rounding.
    pub fn leaves_at(&self, point: [f32; 3], found: &mut Vec<u32>) {
        leaves_at(self, point, found);
    }

    /// Memory of the arrays.
    pub fn byte_count(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.first_children.as_slice())
    }
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn may_hold_any(tree: &BeamTree, center: [f32; 3], radius: f32) -> bool {
    // The planes' normals have length 1.
    let leeway = rounding_at(center.into()) + radius;
    let mut waiting = [0u32; MAX_WAITING];
    let mut count = usize::from(!tree.nodes.is_empty());
    let mut visited = 0;
    let mut may_hold = false;
    while count > 0 && !may_hold {
        count -= 1;
        visited += 1;
        let node = waiting[count] as usize;
        let mut holding = tree.nodes[node].holding(center, leeway);
        let first = tree.first_children[node];
        may_hold = holding != 0 && first as usize >= tree.nodes.len();
        while holding != 0 && !may_hold {
            waiting[count] = first + holding.trailing_zeros();
            holding &= holding - 1;
            count += 1;
        }
    }
    work::add(visited);
    may_hold
}

#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn leaves_at(tree: &BeamTree, point: [f32; 3], found: &mut Vec<u32>) {
    tree.visit(point, |leaf| found.push(leaf));
}
