//! Fragments from samples: the samples of a pixel that show the same chain of surfaces are shaded together.

use super::super::kernel::{BLOCK, EMPTY, Ids, TILE_BLOCKS};
use super::super::samples::Pattern;
use super::super::source::{KnownSurfaces, LayerSource};
use catoptric_core::math::lanes::LANES;
use glam::Vec2;

/// Parts of one surface that meet in a pixel differ in depth by less than this share of it.
const SAME_DEPTH: f32 = 2e-3;

/// The destination of a fragment's colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FragmentTarget {
    pub(super) column: u8,
    pub(super) row: u8,
    /// The samples that show it, as bits.
    pub(super) samples: u16,
}

impl FragmentTarget {
    /// The number of samples that show it.
    pub(super) fn weight(&self) -> u8 {
        self.samples.count_ones() as u8
    }
}

/// The fragments of a tile, without their attributes.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    pub(super) positions: Vec<Vec2>,
    pub(super) targets: Vec<FragmentTarget>,
    /// Ids of the triangles of all chains.
    pub(super) ids: Vec<u32>,
    /// The end of each fragment's chain in `ids`.
    pub(super) ends: Vec<u32>,
}

impl Chains {
    fn clear(&mut self) {
        self.positions.clear();
        self.targets.clear();
        self.ids.clear();
        self.ends.clear();
    }

    /// Keeps those fragments whose chains (ids, layer 0 first) pass a filter.
    pub(super) fn retain(&mut self, wanted: impl Fn(&[u32]) -> bool) {
        let (mut fragments, mut end, mut start) = (0, 0, 0);
        for index in 0..self.ends.len() {
            let chain = start..self.ends[index] as usize;
            start = chain.end;
            if !wanted(&self.ids[chain.clone()]) {
                continue;
            }
            let length = chain.len();
            self.ids.copy_within(chain, end);
            end += length;
            self.ends[fragments] = end as u32;
            self.positions[fragments] = self.positions[index];
            self.targets[fragments] = self.targets[index];
            fragments += 1;
        }
        self.ids.truncate(end);
        self.ends.truncate(fragments);
        self.positions.truncate(fragments);
        self.targets.truncate(fragments);
    }
}

/// Gathers the fragments of a tile of `extent` pixels whose first is `first_pixel` into `chains`.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
pub(super) fn resolve<L: LayerSource>(
    known: &KnownSurfaces<'_, L>,
    pattern: &Pattern,
    layers: &[Vec<Ids>],
    extent: [usize; 2],
    first_pixel: [i32; 2],
    chains: &mut Chains,
) {
    chains.clear();
    if let ([layer], 1) = (layers, pattern.samples) {
        return resolve_simple(layer, extent, first_pixel, chains);
    }
    let Chains { positions, targets, ids, ends } = chains;
    let samples = pattern.samples;
    let whole = Vec2::splat(0.5);
    let all = (1u32 << samples) - 1;
    let together = shaded_together(samples);
    for block in 0..TILE_BLOCKS * TILE_BLOCKS {
        let [block_x, block_y] = [block % TILE_BLOCKS * BLOCK, block / TILE_BLOCKS * BLOCK];
        for row in block_y..(block_y + BLOCK).min(extent[1]) {
            for column in block_x..(block_x + BLOCK).min(extent[0]) {
                let corner = Vec2::new((first_pixel[0] + column as i32) as f32, (first_pixel[1] + row as i32) as f32);
                let first = (block * BLOCK * BLOCK + (row - block_y) * BLOCK + (column - block_x)) * samples;
                let target = FragmentTarget { column: column as u8, row: row as u8, samples: all as u16 };
                let mut splits = false;
                let start = ids.len();
                for layer in layers {
                    let layer: &[u32] = &bytemuck::cast_slice(layer)[first..first + samples];
                    let id = layer[0];
                    let differences = layer.iter().fold(0, |sum, other| sum | (other ^ id));
                    if differences != 0 {
                        splits = true;
                        break;
                    }
                    if id == EMPTY {
                        break;
                    }
                    ids.push(id);
                }
                let is_bent = samples > 1 && ids[start..].last().is_some_and(|id| known.is_bent(*id));
                if !splits && !is_bent {
                    positions.push(corner + whole);
                    targets.push(target);
                    ends.push(ids.len() as u32);
                    continue;
                }
                ids.truncate(start);
                let mut prefix = [0u32; 64];
                let mut place = PixelPlace { known, pattern, layers, first, corner, merges: true };
                let mut add = |mask: u32, chain: &[u32]| {
                    let mut push = |mask: u32| {
                        positions.push(corner + if mask == all { whole } else { centroid(pattern, mask) });
                        targets.push(FragmentTarget { samples: mask as u16, ..target });
                        ids.extend_from_slice(chain);
                        ends.push(ids.len() as u32);
                    };
                    if mask.count_ones() > 1 && chain.last().is_some_and(|id| known.is_bent(*id)) {
                        pattern.quarters.iter().map(|quarter| mask & quarter).filter(|part| *part != 0).for_each(push);
                    } else {
                        push(mask);
                    }
                };
                if together {
                    split(&place, all, &mut prefix, 0, &mut add);
                } else if let Some(depth) = place.one_chain(all, &mut prefix) {
                    // Parts of one surface alone: no edge of anything visible.
                    add(all, &prefix[..depth]);
                } else {
                    place.merges = false;
                    split(&place, all, &mut prefix, 0, &mut |mask, chain| {
                        let mut rest = mask;
                        while rest != 0 {
                            add(1 << rest.trailing_zeros(), chain);
                            rest &= rest - 1;
                        }
                    });
                }
            }
        }
    }
}

/// Returns true if the samples of a pixel that show one of several chains are shaded together.
///
/// The places of a few samples that lie to one side of an edge differ much from their mean; with many samples a pixel
/// each counts little, and shading them together is worth more.
fn shaded_together(samples: usize) -> bool {
    samples > 8
}

/// One layer and one sample a pixel: every pixel is a fragment.
#[inline(always)]
fn resolve_simple(layer: &[Ids], extent: [usize; 2], first_pixel: [i32; 2], chains: &mut Chains) {
    let layer: &[u32] = bytemuck::cast_slice(layer);
    for (block, pixels) in layer.chunks_exact(BLOCK * BLOCK).enumerate() {
        let [block_x, block_y] = [block % TILE_BLOCKS * BLOCK, block / TILE_BLOCKS * BLOCK];
        let columns = extent[0].saturating_sub(block_x).min(BLOCK);
        let rows = extent[1].saturating_sub(block_y).min(BLOCK);
        for (row, pixels) in pixels.chunks_exact(BLOCK).take(rows).enumerate() {
            let row = block_y + row;
            let y = (first_pixel[1] + row as i32) as f32 + 0.5;
            let x = (first_pixel[0] + block_x as i32) as f32 + 0.5;
            chains.positions.extend((0..columns).map(|column| Vec2::new(x + column as f32, y)));
            let target =
                |column: usize| FragmentTarget { column: (block_x + column) as u8, row: row as u8, samples: 1 };
            chains.targets.extend((0..columns).map(target));
            for &id in &pixels[..columns] {
                if id != EMPTY {
                    chains.ids.push(id);
                }
                chains.ends.push(chains.ids.len() as u32);
            }
        }
    }
}

/// The mean position of some samples of a pixel.
#[inline]
fn centroid(pattern: &Pattern, mask: u32) -> Vec2 {
    let mut sum = Vec2::ZERO;
    let mut rest = mask;
    while rest != 0 {
        sum += pattern.positions[rest.trailing_zeros() as usize];
        rest &= rest - 1;
    }
    sum / mask.count_ones() as f32
}

/// A pixel whose samples show different triangles.
struct PixelPlace<'a, L: LayerSource> {
    known: &'a KnownSurfaces<'a, L>,
    pattern: &'a Pattern,
    layers: &'a [Vec<Ids>],
    /// The indices of its samples in the layers.
    first: usize,
    /// The pixel's corner in the picture.
    corner: Vec2,
    /// True if parts of one surface count as one.
    merges: bool,
}

impl<L: LayerSource> PixelPlace<'_, L> {
    fn layer(&self, depth: usize) -> Option<&[u32]> {
        let layer: &[u32] = bytemuck::cast_slice(self.layers.get(depth)?);
        Some(&layer[self.first..self.first + self.pattern.samples])
    }

    /// The length of the chain, written to `prefix`, if all samples show one chain of surfaces.
    fn one_chain(&self, all: u32, prefix: &mut [u32; 64]) -> Option<usize> {
        let mut depth = 0;
        while let Some(layer) = self.layer(depth) {
            let (id, same) = self.of_one_surface(layer, all);
            if same != all {
                return None;
            }
            if id == EMPTY {
                break;
            }
            prefix[depth] = id;
            depth += 1;
        }
        Some(depth)
    }

    /// The samples among `rest` that show the same surface in a layer as the first of them, and the triangle that the
    /// one in their middle shows.
    fn of_one_surface(&self, layer: &[u32], rest: u32) -> (u32, u32) {
        let id = layer[rest.trailing_zeros() as usize];
        let mut all = samples_of(layer, id) & rest;
        if id == EMPTY || all == rest || !self.merges {
            return (id, all);
        }
        let (list, patch) = self.known.patch(id);
        if patch == 0 {
            return (id, all);
        }
        let mut others = rest & !all;
        while others != 0 {
            let sample = others.trailing_zeros() as usize;
            let other = layer[sample];
            let mask = samples_of(layer, other) & rest;
            others &= !mask;
            if other == EMPTY {
                continue;
            }
            if self.known.patch(other) != (list, patch) {
                continue;
            }
            let at = self.corner + self.pattern.positions[sample];
            let (here, there) = (self.known.depth_at(id, at), self.known.depth_at(other, at));
            if (here - there).abs() <= SAME_DEPTH * there.abs() {
                all |= mask;
            }
        }
        let middle = centroid(self.pattern, all);
        let distance2 = |sample: usize| self.pattern.positions[sample].distance_squared(middle);
        let in_all = (0..layer.len()).filter(|sample| all >> sample & 1 != 0);
        let nearest = in_all.min_by(|a, b| distance2(*a).total_cmp(&distance2(*b)));
        (nearest.map_or(id, |sample| layer[sample]), all)
    }
}

/// The samples that show a triangle, as bits.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn samples_of(layer: &[u32], id: u32) -> u32 {
    let mut mask = 0;
    let (groups, rest) = layer.as_chunks::<LANES>();
    for (index, group) in groups.iter().enumerate() {
        let mut bits = [0u32; LANES];
        for (index, (bit, &other)) in bits.iter_mut().zip(group).enumerate() {
            *bit = u32::from(other == id) << index;
        }
        mask |= bits.iter().fold(0, |sum, bit| sum | bit) << (index * LANES);
    }
    for (index, &other) in rest.iter().enumerate() {
        mask |= u32::from(other == id) << (groups.len() * LANES + index);
    }
    mask
}

/// Calls `found` for every different chain among the samples in `mask`, in the order of their first samples within
/// each layer. `prefix[..depth]` is their common prefix so far.
fn split<L: LayerSource>(
    place: &PixelPlace<'_, L>,
    mask: u32,
    prefix: &mut [u32; 64],
    depth: usize,
    found: &mut impl FnMut(u32, &[u32]),
) {
    let Some(layer) = place.layer(depth) else {
        found(mask, &prefix[..depth]);
        return;
    };
    let mut rest = mask;
    while rest != 0 {
        let (id, same) = place.of_one_surface(layer, rest);
        rest &= !same;
        if id == EMPTY {
            found(same, &prefix[..depth]);
        } else {
            prefix[depth] = id;
            split(place, same, prefix, depth + 1, found);
        }
    }
}
