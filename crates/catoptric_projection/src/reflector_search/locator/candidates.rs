//! A coarse selection of a picture's texels: where is the normal about the half vector?

use super::law::Law;
use crate::find::work;
use crate::reflector_search::image::{ImagePlace, ReflectorImage};
use catoptric_core::math::lanes::{LANES, Lanes, Vec3Lanes, bits_of};
use glam::{Vec2, Vec3};

/// Squares along a side of a group of squares. Chosen, not measured.
const GROUP_SIDE: u32 = 4;

/// Blocks of candidates of a group.
const GROUP_BLOCKS: usize = (GROUP_SIDE * GROUP_SIDE) as usize / LANES;

/// The maximum number of candidates that are selected. A bound on memory; chosen, not measured.
const MAX_CANDIDATES: usize = 2048;

/// The number of a missing candidate.
const NONE: u16 = u16::MAX;

/// Normals may be this much further (radians) from the half vector than the surface bends between candidates: points
/// that appear a little beyond where a reflector ends. Chosen, not measured.
const LEEWAY: f32 = 0.15;

/// The half vector is met nearer to the nearest candidate than this share of the way to those around it. Chosen, not
/// measured.
const NEAREST_SHARE: f32 = 0.65;

/// Eight candidates: positions, normals on the side that is met, and arriving rays, component by component.
#[derive(Clone, Copy, Debug)]
struct CandidateBlock {
    position: Vec3Lanes,
    normal: Vec3Lanes,
    /// The direction back along the arriving ray, times the index of refraction.
    toward: Vec3Lanes,
    /// `normal . toward`
    along: Lanes,
    /// The greatest turn of the normals, and the greatest distance of positions, between a candidate and those around
    /// it.
    bend: Lanes,
    extent: Lanes,
    /// The reciprocal of the distance to the rays' origin.
    nearness: Lanes,
}

/// The selected texels.
#[derive(Clone, Debug)]
pub(in super::super) struct TexelCandidates {
    /// [`GROUP_BLOCKS`] for each group, in part empty.
    blocks: Vec<CandidateBlock>,
    /// A mean candidate for each group, with its bend and extent.
    groups: Vec<CandidateBlock>,
    /// The place of the candidate in each lane of each block.
    places: Vec<ImagePlace>,
    /// The candidates around each one; [`NONE`] where there is none.
    neighbours: Vec<[u16; 8]>,
    /// The distance between neighbours, in texels.
    pub(in super::super) stride: u32,
    /// Squares that have a candidate beyond [`MAX_CANDIDATES`].
    pub(in super::super) left_out: u64,
}

/// A texel that may be selected.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct TexelCandidate {
    pub(in super::super) position: Vec3,
    /// The unit normal on the side that is met.
    pub(in super::super) normal: Vec3,
    /// The unit direction back along the arriving ray, and one over the distance to where that comes from.
    pub(in super::super) toward: Vec3,
    pub(in super::super) nearness: f32,
}

/// A candidate with its square.
struct Selected {
    place: ImagePlace,
    middle: Vec2,
    candidate: TexelCandidate,
}

/// The division of a picture into squares, and of those into groups.
struct Squares<'a> {
    image: &'a ReflectorImage,
    stride: u32,
    columns: u32,
    rows: u32,
}

impl TexelCandidates {
    /// Selects of each square of `stride` texels a side the one nearest to its middle for which `choose` has something.
    pub(in super::super) fn select(
        image: &ReflectorImage,
        stride: u32,
        law: &Law,
        choose: impl Fn(u32, u32, u32) -> Option<TexelCandidate>,
    ) -> Self {
        let (columns, rows) = (image.width.div_ceil(stride), image.height.div_ceil(stride));
        let squares = Squares { image, stride, columns, rows };
        let mut all = Self {
            blocks: Vec::new(),
            groups: Vec::new(),
            places: Vec::new(),
            neighbours: Vec::new(),
            stride,
            left_out: 0,
        };
        let mut numbers = vec![NONE; (image.face_count * columns * rows) as usize];
        let mut lanes: Vec<Option<Selected>> = Vec::new();
        for face in 0..image.face_count {
            for top in (0..rows).step_by(GROUP_SIDE as usize) {
                for left in (0..columns).step_by(GROUP_SIDE as usize) {
                    let start = lanes.len();
                    let is_full = start + GROUP_BLOCKS * LANES > MAX_CANDIDATES;
                    for row in top..(top + GROUP_SIDE).min(rows) {
                        for column in left..(left + GROUP_SIDE).min(columns) {
                            let Some(selected) = squares.selected(face, column, row, &choose) else { continue };
                            if is_full {
                                all.left_out += 1;
                            } else {
                                numbers[squares.number(face, column, row)] = lanes.len() as u16;
                                lanes.push(Some(selected));
                            }
                        }
                    }
                    if lanes.len() > start {
                        lanes.resize_with(start + GROUP_BLOCKS * LANES, || None);
                    }
                }
            }
        }
        for group in lanes.chunks(GROUP_BLOCKS * LANES) {
            for block in group.chunks(LANES) {
                all.blocks
                    .push(CandidateBlock::of(block.iter().map(|lane| lane.as_ref().map(|one| one.candidate)), law));
            }
        }
        let neighbours = |lane: &Option<Selected>| match lane {
            Some(one) => squares.around(one).map(|number| number.map_or(NONE, |number| numbers[number])),
            None => [NONE; 8],
        };
        all.neighbours = lanes.iter().map(neighbours).collect();
        let nowhere = ImagePlace { face: 0, at: Vec2::ZERO };
        all.places = lanes.iter().map(|lane| lane.as_ref().map_or(nowhere, |one| one.place)).collect();
        all.measure(&lanes, law);
        all
    }

    /// Finds how far normals turn and positions move about candidates, and in groups.
    fn measure(&mut self, lanes: &[Option<Selected>], law: &Law) {
        let candidate = |number: u16| lanes.get(number as usize)?.as_ref().map(|one| one.candidate);
        for (lane, one) in lanes.iter().enumerate() {
            let Some(Selected { candidate: own, .. }) = one else { continue };
            let around = || self.neighbours[lane].into_iter().filter_map(candidate);
            let bend = around().map(|other| other.normal.distance(own.normal)).fold(0.0, f32::max);
            let extent = around().map(|other| other.position.distance(own.position)).fold(0.0, f32::max);
            let block = &mut self.blocks[lane / LANES];
            (block.bend[lane % LANES], block.extent[lane % LANES]) = (bend, extent);
        }
        let mut means = Vec::new();
        for (group, members) in lanes.chunks(GROUP_BLOCKS * LANES).enumerate() {
            let members: Vec<(usize, TexelCandidate)> = members
                .iter()
                .enumerate()
                .filter_map(|(k, one)| Some((group * GROUP_BLOCKS * LANES + k, one.as_ref()?.candidate)))
                .collect();
            let sum = |of: fn(&TexelCandidate) -> Vec3| members.iter().map(|(_, one)| of(one)).sum::<Vec3>();
            let mean = TexelCandidate {
                position: sum(|one| one.position) / members.len() as f32,
                normal: sum(|one| one.normal).normalize_or_zero(),
                toward: sum(|one| one.toward).normalize_or_zero(),
                nearness: members.iter().map(|(_, one)| one.nearness).fold(0.0, f32::max),
            };
            let (mut bend, mut extent): (f32, f32) = (0.0, 0.0);
            for (lane, one) in &members {
                let block = &self.blocks[lane / LANES];
                bend = bend.max(one.normal.distance(mean.normal) + block.bend[lane % LANES]);
                extent = extent.max(one.position.distance(mean.position) + block.extent[lane % LANES]);
            }
            means.push((mean, bend, extent));
        }
        for means in means.chunks(LANES) {
            let mut block = CandidateBlock::of(means.iter().map(|(mean, ..)| Some(*mean)), law);
            for (lane, (_, bend, extent)) in means.iter().enumerate() {
                (block.bend[lane], block.extent[lane]) = (*bend, *extent);
            }
            self.groups.push(block);
        }
    }

    /// True if there is none.
    pub(in super::super) fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The best candidate, if the half vector may be met about it.
    pub(in super::super) fn nearest(&self, law: &Law, point: Vec3) -> Option<ImagePlace> {
        let mut scores = [f32::NEG_INFINITY; MAX_CANDIDATES];
        let scores = &mut scores[..self.places.len()];
        let mut highest = [f32::NEG_INFINITY; LANES];
        for (block, scores) in self.blocks.iter().zip(scores.as_chunks_mut::<LANES>().0) {
            *scores = block.lanes(law, point).ranks(law).0;
            for lane in 0..LANES {
                highest[lane] = if scores[lane] > highest[lane] { scores[lane] } else { highest[lane] };
            }
        }
        let highest = highest.into_iter().fold(f32::NEG_INFINITY, f32::max);
        let best = scores.iter().position(|score| *score == highest)?;
        let block = &self.blocks[best / LANES];
        let leads = block.leads(&block.lanes(law, point), law, 1.0, LEEWAY);
        (leads >> (best % LANES) & 1 == 1).then_some(self.places[best])
    }

    /// Calls `take` first for all candidates that are better than those around them (with `true`), then for all others
    /// about which the half vector may be met (with `false`).
    #[inline]
    pub(in super::super) fn best(&self, law: &Law, point: Vec3, mut take: impl FnMut(ImagePlace, bool)) {
        let mut scores = [f32::NEG_INFINITY; MAX_CANDIDATES];
        let scores = &mut scores[..self.places.len()];
        work::add(self.groups.len() as u64);
        let mut leading = [Leading::default(); MAX_CANDIDATES / LANES];
        let count = leading_blocks(self, law, point, scores, &mut leading);
        let leading = &leading[..count];
        let is_best = |index: usize| {
            let score = scores[index];
            // The first of equal ones counts.
            let better = |other: u16| match scores.get(usize::from(other)) {
                Some(&rival) => rival > score || (rival == score && usize::from(other) < index),
                None => false,
            };
            !self.neighbours[index].iter().any(|other| better(*other))
        };
        for best in [true, false] {
            for one in leading {
                let mut leads = if best { one.leads } else { one.leads_near };
                while leads != 0 {
                    let index = usize::from(one.block) * LANES + leads.trailing_zeros() as usize;
                    leads &= leads - 1;
                    if scores[index] > 0.0 && is_best(index) == best {
                        take(self.places[index], best);
                    }
                }
            }
        }
    }

    /// Bytes held.
    pub(in super::super) fn byte_count(&self) -> u64 {
        let bytes = size_of_val(self.blocks.as_slice())
            + size_of_val(self.groups.as_slice())
            + size_of_val(self.places.as_slice())
            + size_of_val(self.neighbours.as_slice());
        bytes as u64
    }
}

impl Squares<'_> {
    fn number(&self, face: u32, column: u32, row: u32) -> usize {
        ((face * self.rows + row) * self.columns + column) as usize
    }

    /// The texel of a square that is nearest to its middle.
    fn selected(
        &self,
        face: u32,
        column: u32,
        row: u32,
        choose: &impl Fn(u32, u32, u32) -> Option<TexelCandidate>,
    ) -> Option<Selected> {
        let stride = self.stride;
        let middle = Vec2::new(column as f32 + 0.5, row as f32 + 0.5) * stride as f32;
        let mut best: Option<(f32, Selected)> = None;
        for y in row * stride..((row + 1) * stride).min(self.image.height - 1) {
            for x in column * stride..((column + 1) * stride).min(self.image.width - 1) {
                let at = Vec2::new(x as f32, y as f32);
                let apart = at.distance_squared(middle);
                if best.as_ref().is_none_or(|(least, _)| apart < *least)
                    && let Some(candidate) = choose(face, x, y)
                {
                    best = Some((apart, Selected { place: ImagePlace { face, at }, middle, candidate }));
                }
            }
        }
        best.map(|(_, selected)| selected)
    }

    /// The numbers of the squares around one.
    fn around(&self, one: &Selected) -> [Option<usize>; 8] {
        let around = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
        around.map(|(right, down): (i32, i32)| {
            let at = one.middle + Vec2::new(right as f32, down as f32) * self.stride as f32;
            let ImagePlace { face, at } = self.image.settled(ImagePlace { face: one.place.face, at });
            let square = at / self.stride as f32;
            // Casts saturate: negative places must be rejected before.
            let inside = square.x >= 0.0 && square.y >= 0.0;
            let (column, row) = (square.x as u32, square.y as u32);
            (inside && column < self.columns && row < self.rows).then(|| self.number(face, column, row))
        })
    }
}

/// A block of candidates, and about which of its lanes the half vector may be met: at all, and nearer to them than to
/// those around them.
#[derive(Clone, Copy, Default)]
struct Leading {
    block: u16,
    leads: u8,
    leads_near: u8,
}

/// Scores the groups of candidates about which the half vector may be met; fills in the blocks of those and returns how
/// many they are.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn leading_blocks(
    candidates: &TexelCandidates,
    law: &Law,
    point: Vec3,
    scores: &mut [f32],
    leading: &mut [Leading],
) -> usize {
    let mut count = 0;
    for (number, group) in candidates.groups.iter().enumerate() {
        let mut leads = group.leads(&group.lanes(law, point), law, 1.0, LEEWAY);
        while leads != 0 {
            let first = (number * LANES + leads.trailing_zeros() as usize) * GROUP_BLOCKS;
            leads &= leads - 1;
            for index in first..(first + GROUP_BLOCKS).min(candidates.blocks.len()) {
                let block = &candidates.blocks[index];
                let lanes = block.lanes(law, point);
                scores[index * LANES..][..LANES].copy_from_slice(&*lanes.ranks(law));
                leading[count] = Leading {
                    block: index as u16,
                    leads: block.leads(&lanes, law, 1.0, LEEWAY),
                    leads_near: block.leads(&lanes, law, NEAREST_SHARE, 0.0),
                };
                count += 1;
            }
        }
    }
    count
}

/// A point relative to eight candidates.
struct CandidateScores {
    /// Cosines between normals and half vectors.
    scores: Lanes,
    /// Heights above the tangent planes, over distances.
    heights: Lanes,
    /// The reciprocals of the distance of the point, and of the length of the half vector before it was made a unit.
    nearness: Lanes,
    shortness: Lanes,
}

impl CandidateBlock {
    fn of(candidates: impl Iterator<Item = Option<TexelCandidate>>, law: &Law) -> Self {
        // Lanes without a candidate have no score.
        let nothing = Lanes::splat(f32::NAN);
        let mut block = Self {
            position: Vec3Lanes([nothing; 3]),
            normal: Vec3Lanes([nothing; 3]),
            toward: Vec3Lanes([nothing; 3]),
            along: nothing,
            bend: Lanes::ZERO,
            extent: Lanes::ZERO,
            nearness: Lanes::ZERO,
        };
        for (lane, candidate) in candidates.enumerate() {
            let Some(candidate) = candidate else { continue };
            let toward = candidate.toward * law.eta;
            block.position.set(lane, candidate.position);
            block.normal.set(lane, candidate.normal);
            block.toward.set(lane, toward);
            block.along[lane] = candidate.normal.dot(toward);
            block.nearness[lane] = candidate.nearness;
        }
        block
    }

    #[inline(always)] // for the instructions of its caller
    fn lanes(&self, law: &Law, point: Vec3) -> CandidateScores {
        let zero = Lanes::ZERO;
        let mut lanes = CandidateScores { scores: zero, heights: zero, nearness: zero, shortness: zero };
        let constant = law.eta * law.eta + 1.0;
        for lane in 0..LANES {
            let from =
                [point.x - self.position[0][lane], point.y - self.position[1][lane], point.z - self.position[2][lane]];
            let dot = |with: &Vec3Lanes| from[0] * with[0][lane] + from[1] * with[1][lane] + from[2] * with[2][lane];
            let squared = from[0] * from[0] + from[1] * from[1] + from[2] * from[2];
            let nearness = 1.0 / squared.sqrt();
            let (height, with) = (dot(&self.normal) * nearness, dot(&self.toward) * nearness);
            let shortness = 1.0 / (constant + 2.0 * with).sqrt();
            lanes.scores[lane] = law.sign * (self.along[lane] + height) * shortness;
            lanes.heights[lane] = height;
            lanes.nearness[lane] = nearness;
            lanes.shortness[lane] = shortness;
        }
        lanes
    }

    /// Lanes (bits) whose half vector may be met about the candidate, as normals and directions change by this
    /// share there, or is missed by `leeway` at most.
    #[inline(always)] // for the instructions of its caller
    fn leads(&self, lanes: &CandidateScores, law: &Law, share: f32, leeway: f32) -> u8 {
        let mut leads = [false; LANES];
        for (lane, leads) in leads.iter_mut().enumerate() {
            let turns = self.extent[lane] * (self.nearness[lane] * law.eta + lanes.nearness[lane]);
            let allowed = share * (self.bend[lane] + turns * lanes.shortness[lane]) + leeway;
            // The chord between two unit vectors.
            *leads = 2.0 - 2.0 * lanes.scores[lane] <= allowed * allowed;
        }
        bits_of(leads)
    }
}

impl CandidateScores {
    /// The cosines between normals and half vectors; for refractions less on the wrong side.
    #[inline(always)] // for the instructions of its caller
    fn ranks(&self, law: &Law) -> Lanes {
        let mut ranks = self.scores;
        if law.transmits {
            for (rank, height) in ranks.iter_mut().zip(*self.heights) {
                *rank -= if height > 0.0 { 2.0 } else { 0.0 };
            }
        }
        ranks
    }
}
