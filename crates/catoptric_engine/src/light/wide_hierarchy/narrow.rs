//! Binary hierarchies of boxes, also of boxes that lie on each other.
//!
//! Merging neighbours (PLOC, Meister and Bittner 2018) merges one pair a round where boxes are the same, lie in each
//! other or at even distances: time is quadratic. Such piles are found first and divided at their median.

use catoptric_core::parallel;
use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Range;

/// Fewer boxes are no pile: merging them takes little time in any case.
const LEAST_OF_PILE: usize = 256;

/// The mean area of a pile's boxes is at least this share of that of the box around them.
const SHARE_OF_PILE: f64 = 0.1;

/// Bits of a place along each axis.
const PLACE_BITS: u32 = 21;

/// A hierarchy whose leaves have one box each.
pub struct Narrow {
    /// The hierarchy; its primitives are the numbers of the boxes.
    pub tree: Bvh2,
    /// Boxes that are left out, each with the one that is the same.
    pub left_out: Vec<[u32; 2]>,
}

impl Narrow {
    /// The hierarchy over boxes of finite size, at least one. In piles those are left out whose keys are the same as
    /// that of a box with a smaller number; boxes without a key stay.
    pub fn new<K: Eq + Hash>(boxes: &[BvhBox], preset: &BvhBuildParams, key: impl Fn(u32) -> Option<K>) -> Self {
        let Piles { mut order, ranges } = Piles::find(boxes);
        let mut left_out = Vec::new();
        let mut is_piled = vec![false; if ranges.is_empty() { 0 } else { boxes.len() }];
        let mut piles = Vec::with_capacity(ranges.len());
        for range in ranges {
            let pile = &mut order[range.clone()];
            pile.iter().for_each(|number| is_piled[*number as usize] = true);
            let count = without_copies(pile, &key, &mut left_out);
            piles.push(range.start..range.start + count);
        }
        // Merging sees single boxes, then one for each pile.
        let singles: Vec<u32> = match piles.is_empty() {
            true => (0..boxes.len() as u32).collect(),
            false => (0..).zip(&is_piled).filter_map(|(number, piled)| (!piled).then_some(number)).collect(),
        };
        let mut seen: Vec<BvhBox> = singles.iter().map(|number| boxes[*number as usize]).collect();
        seen.extend(piles.iter().map(|pile| around(boxes, &order[pile.clone()])));
        let mut tree = PlocBuilder::with_capacity(seen.len()).build(
            preset.ploc_search_distance,
            &seen,
            (0..seen.len() as u32).collect(),
            preset.sort_precision,
            preset.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut tree, preset.reinsertion_batch_ratio, None);
        if !piles.is_empty() {
            divide_piles(&mut tree, boxes, &singles, (&mut order, &piles));
        }
        Self { tree, left_out }
    }
}

/// Moves one of each kind to the front of a pile, in the order of their numbers, and returns how many these are.
fn without_copies<K: Eq + Hash>(
    pile: &mut [u32],
    key: impl Fn(u32) -> Option<K>,
    left_out: &mut Vec<[u32; 2]>,
) -> usize {
    pile.sort_unstable();
    let mut known = HashMap::new();
    let mut count = 0;
    for place in 0..pile.len() {
        let number = pile[place];
        if let Some(key) = key(number) {
            let first = *known.entry(key).or_insert(number);
            if first != number {
                left_out.push([number, first]);
                continue;
            }
        }
        pile[count] = number;
        count += 1;
    }
    count
}

/// Puts trees of piles in the place of the leaves that stand for them.
fn divide_piles(tree: &mut Bvh2, boxes: &[BvhBox], singles: &[u32], (order, piles): (&mut [u32], &[Range<usize>])) {
    let leaves: Vec<usize> = (0..tree.nodes.len()).filter(|node| tree.nodes[*node].is_leaf()).collect();
    let seen = std::mem::take(&mut tree.primitive_indices);
    let mut primitives = Vec::with_capacity(boxes.len());
    let mut waiting: Vec<(usize, Range<usize>)> = Vec::new();
    for leaf in leaves {
        let number = seen[tree.nodes[leaf].first_index as usize] as usize;
        match number.checked_sub(singles.len()) {
            Some(pile) => waiting.push((leaf, piles[pile].clone())),
            None => {
                tree.nodes[leaf].first_index = primitives.len() as u32;
                primitives.push(singles[number]);
            }
        }
    }
    let most = piles.iter().map(ExactSizeIterator::len).max().unwrap_or(1);
    while let Some((node, range)) = waiting.pop() {
        let pile = &mut order[range.clone()];
        let bounds = around(boxes, pile);
        if let [number] = *pile {
            tree.nodes[node] = Bvh2Node::new(bounds, 1, primitives.len() as u32);
            primitives.push(number);
            continue;
        }
        let middle = pile.len() / 2;
        halve(boxes, pile);
        let first = tree.nodes.len();
        tree.nodes[node] = Bvh2Node::new(bounds, 0, first as u32);
        tree.nodes.extend([Bvh2Node::new(bounds, 0, 0); 2]);
        waiting.push((first, range.start..range.start + middle));
        waiting.push((first + 1, range.start + middle..range.end));
    }
    tree.primitive_indices = primitives;
    // They were those of the tree before.
    tree.parents.clear();
    tree.max_depth += most.ilog2() as usize + 2;
}

/// Divides boxes at their median: by their places along the axis where these differ most, or by size where that
/// differs more.
fn halve(boxes: &[BvhBox], pile: &mut [u32]) {
    let of = |number: u32| {
        let bounds = &boxes[number as usize];
        let center = bounds.center();
        [center.x, center.y, center.z, bounds.diagonal().length() * 0.5]
    };
    let mut spans = [[f32::INFINITY, f32::NEG_INFINITY]; 4];
    for number in &*pile {
        for (span, value) in spans.iter_mut().zip(of(*number)) {
            *span = [span[0].min(value), span[1].max(value)];
        }
    }
    let width = |index: &usize| spans[*index][1] - spans[*index][0];
    let widest = (0..4).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let middle = pile.len() / 2;
    pile.select_nth_unstable_by(middle, |a, b| of(*a)[widest].total_cmp(&of(*b)[widest]).then(a.cmp(b)));
}

fn around(boxes: &[BvhBox], numbers: &[u32]) -> BvhBox {
    numbers.iter().fold(BvhBox::empty(), |around, number| around.union(&boxes[*number as usize]))
}

/// Boxes that lie on each other.
struct Piles {
    /// The boxes, in the order of a curve that fills space.
    order: Vec<u32>,
    /// Parts of the order that are piles.
    ranges: Vec<Range<usize>>,
}

impl Piles {
    fn find(boxes: &[BvhBox]) -> Self {
        let mut ranges = Vec::new();
        if boxes.len() < LEAST_OF_PILE {
            return Self { order: Vec::new(), ranges };
        }
        let centers = parallel::map_collect(boxes.len(), |number| boxes[number].center());
        let (low, high) = centers
            .iter()
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), center| (low.min(*center), high.max(*center)));
        let scale = (high - low).max(Vec3A::splat(f32::MIN_POSITIVE)).recip();
        let mut places: Vec<(u64, u32)> =
            parallel::map_collect(boxes.len(), |number| (along_curve((centers[number] - low) * scale), number as u32));
        places.sort_unstable();
        let order: Vec<u32> = places.iter().map(|(_, number)| *number).collect();
        let runs = Runs::new(boxes, &order);
        let mut waiting = vec![(0, boxes.len())];
        while let Some((start, end)) = waiting.pop() {
            let range = start..end;
            if range.len() < LEAST_OF_PILE {
                continue;
            }
            if runs.mean_area(&range) > SHARE_OF_PILE * f64::from(runs.around(&range).half_area()) {
                ranges.push(range);
                continue;
            }
            // Where the highest bit changes that is not the same in all of them.
            let codes = &places[range];
            let differing = codes[0].0 ^ codes[codes.len() - 1].0;
            let Some(bit) = differing.checked_ilog2() else { continue };
            let middle = start + codes.partition_point(|(code, _)| code >> bit & 1 == 0);
            waiting.extend([(start, middle), (middle, end)]);
        }
        Self { order, ranges }
    }
}

/// Boxes one after the other, so that what holds of a range of them takes little time.
struct Runs {
    boxes: Vec<BvhBox>,
    /// Sums of the areas before each of them, and of all.
    areas: Vec<f64>,
    /// The boxes around [`RUN`] of them at a time.
    runs: Vec<BvhBox>,
}

/// Boxes that are looked at together.
const RUN: usize = 64;

impl Runs {
    fn new(boxes: &[BvhBox], order: &[u32]) -> Self {
        let boxes: Vec<BvhBox> = order.iter().map(|number| boxes[*number as usize]).collect();
        let mut sum = 0.0;
        let mut areas = vec![0.0];
        areas.extend(boxes.iter().map(|bounds| {
            sum += f64::from(bounds.half_area());
            sum
        }));
        let runs = boxes.chunks(RUN).map(around_all).collect();
        Self { boxes, areas, runs }
    }

    fn mean_area(&self, range: &Range<usize>) -> f64 {
        (self.areas[range.end] - self.areas[range.start]) / range.len() as f64
    }

    /// The box around a range, which is longer than two runs.
    fn around(&self, range: &Range<usize>) -> BvhBox {
        let (first, last) = (range.start.div_ceil(RUN), range.end / RUN);
        let ends =
            around_all(&self.boxes[range.start..first * RUN]).union(&around_all(&self.boxes[last * RUN..range.end]));
        around_all(&self.runs[first..last]).union(&ends)
    }
}

fn around_all(boxes: &[BvhBox]) -> BvhBox {
    boxes.iter().fold(BvhBox::empty(), |around, bounds| around.union(bounds))
}

/// The place of a point of the unit cube along Morton's curve.
fn along_curve(point: Vec3A) -> u64 {
    let spread = |share: f32| {
        // Saturates.
        let mut bits = u64::from((share * (1 << PLACE_BITS) as f32) as u32).min((1 << PLACE_BITS) - 1);
        for (shift, mask) in [
            (32, 0x001f_0000_0000_ffff),
            (16, 0x001f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ] {
            bits = (bits | bits << shift) & mask;
        }
        bits
    };
    spread(point.x) | spread(point.y) << 1 | spread(point.z) << 2
}
