//! A tile of the picture: its layers of samples are drawn, and read back as fragments.

mod resolve;

use super::attributes::{CornerLanes, Weights, in_source, lane, weights};
use super::bin::Bins;
use super::fragment::{FragmentBatch, FragmentShader, LayerSurface};
use super::kernel::{
    BLOCK, EMPTY, Ids, Keys, LayerSamples, StencilMask, TILE, TILE_BLOCKS, TilePlace, draw_triangles, edges,
    groups_in_tile, overlap,
};
use super::lists::DrawTriangle;
use super::plan::{LayerPlan, Plan, surface_at};
use super::samples::Pattern;
use super::setup::{PictureSetup, SetupTriangle};
use super::source::{FOUND, KnownSurfaces, LayerSource, ShownBySource, TileBelow, found_number};
use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::EdgeSamples;
use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::shade::Barycentrics;
use glam::{Vec2, Vec3, Vec4};
use resolve::{Chains, FragmentTarget, resolve};

/// The distance beside a piece of a surface up to which its attributes are valid, in sizes of the piece.
const PIECE_LEEWAY: f32 = 1.0;

/// A worker's buffers for a tile, reused from tile to tile.
#[derive(Debug, Default)]
pub(super) struct TileScratch<F> {
    keys: Vec<Keys>,
    layers: Vec<Vec<Ids>>,
    labels: Vec<Ids>,
    chains: Chains,
    surfaces: Vec<LayerSurface>,
    colors: Vec<Vec3>,
    /// Colours of fragments that not all samples of their pixel show.
    parts: Vec<(FragmentTarget, Vec3)>,
    /// Places of surfaces of lists among all.
    listed: Vec<u32>,
    /// The surfaces that the source has found.
    found: F,
}

/// The work done in a tile: fragments, and the times of stages in one thread.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TileReport {
    pub(super) fragments: u64,
    pub(super) raster_ms: f64,
    pub(super) shade_ms: f64,
    pub(super) resolve_ms: f64,
}

impl TileReport {
    pub(super) fn add(&mut self, other: Self) {
        self.fragments += other.fragments;
        self.raster_ms += other.raster_ms;
        self.shade_ms += other.shade_ms;
        self.resolve_ms += other.resolve_ms;
    }
}

/// A tile and the input of its drawing.
pub(super) struct TileWork<'a, S: ?Sized, L> {
    pub(super) frame: &'a PictureSetup,
    pub(super) plan: &'a Plan<'a>,
    pub(super) bins: &'a [Bins],
    pub(super) source: &'a L,
    pub(super) shader: &'a S,
    pub(super) tile: usize,
    pub(super) place: TilePlace,
}

/// The visible surfaces in a tile's layers for one sequence of branches.
struct VisibleLayers {
    /// The number of layers that show anything.
    layers: usize,
    /// Bit k: light divides at surfaces that layer k shows.
    divides: u64,
}

impl<S: FragmentShader + ?Sized, L: LayerSource> TileWork<'_, S, L> {
    /// Draws the tile; `rows` are its pixels in the picture.
    pub(super) fn draw(&self, scratch: &mut TileScratch<L::Found>, rows: &mut [&mut [[f32; 4]]]) -> TileReport {
        if self.frame.pattern.samples > 1 {
            for row in rows.iter_mut() {
                row.fill([0.0, 0.0, 0.0, 1.0]);
            }
        }
        self.source.begin(&mut scratch.found);
        scratch.parts.clear();
        self.draw_branches(0, 0, scratch, rows)
    }

    /// The samples of pixels that parts of their samples show, after the tile was drawn.
    pub(super) fn edges(&self, scratch: &mut TileScratch<L::Found>, rows: &[&mut [[f32; 4]]]) -> EdgeSamples {
        let parts = &mut scratch.parts;
        let pixel = |target: &FragmentTarget| (target.row, target.column);
        parts.sort_by_key(|(target, _)| pixel(target));
        let count = self.frame.pattern.samples;
        let (mut edges, mut samples) = (EdgeSamples::default(), [Vec3::ZERO; 16]);
        for parts in parts.chunk_by(|(one, _), (other, _)| pixel(one) == pixel(other)) {
            let (row, column) = pixel(&parts[0].0);
            let in_parts: Vec3 = parts.iter().map(|(target, color)| *color * f32::from(target.weight())).sum();
            let mean = Vec4::from(rows[usize::from(row)][usize::from(column)]).truncate();
            // Light that all samples show belongs to no part.
            samples.fill((mean - in_parts / count as f32).max(Vec3::ZERO));
            for (index, sample) in samples.iter_mut().enumerate() {
                let shown = parts.iter().filter(|(target, _)| target.samples >> index & 1 != 0);
                *sample += shown.map(|(_, color)| *color).sum::<Vec3>();
            }
            let [x, y] = [column, row].map(u32::from);
            let [left, top] = self.place.pixel.map(|pixel| pixel as u32);
            edges.add((top + y) * self.frame.width + left + x, &samples[..count]);
        }
        edges
    }

    /// Calls `seen` with the pixel and the triangle for all triangles of a list in layer 0 that samples show.
    pub(super) fn for_each_seen(
        &self,
        list: u32,
        scratch: &mut TileScratch<L::Found>,
        seen: &impl Fn([u32; 2], &DrawTriangle),
    ) {
        let may_show = |bins: &Bins| bins.list == list && !bins.of_tile(self.tile).is_empty();
        if !self.bins.iter().any(may_show) || self.draw_layers(0, 0, scratch).layers == 0 {
            return;
        }
        let (frame, samples) = (self.frame, self.frame.pattern.samples);
        let corner = self.place.pixel.map(|pixel| pixel as u32);
        let ids: &[u32] = bytemuck::cast_slice(&scratch.layers[0]);
        for (index, ids) in ids.chunks_exact(samples).enumerate() {
            let (block, pixel) = (index / (BLOCK * BLOCK), index % (BLOCK * BLOCK));
            let column = corner[0] + (block % TILE_BLOCKS * BLOCK + pixel % BLOCK) as u32;
            let row = corner[1] + (block / TILE_BLOCKS * BLOCK + pixel / BLOCK) as u32;
            if column >= frame.width || row >= frame.height {
                continue;
            }
            let mut last = EMPTY;
            for &id in ids {
                if id != last && id != EMPTY {
                    let (shown, triangle) = self.plan.triangle(id);
                    if shown == list {
                        seen([column, row], triangle);
                    }
                }
                last = id;
            }
        }
    }

    /// Draws the surfaces of a sequence of branches, and by all that differ from it in a later layer.
    ///
    /// Layers below `first_layer` stand in `scratch` already. The branches in layers from there on are first ones.
    fn draw_branches(
        &self,
        second_branches: u64,
        first_layer: usize,
        scratch: &mut TileScratch<L::Found>,
        rows: &mut [&mut [[f32; 4]]],
    ) -> TileReport {
        let mut watch = Stopwatch::new();
        let shown = self.draw_layers(second_branches, first_layer, scratch);
        let mut done = TileReport { raster_ms: watch.lap_ms(), ..TileReport::default() };
        done.add(self.shade(second_branches, shown.layers, scratch, rows));
        // From the last layer down: drawing a layer again leaves the layers below unchanged.
        let mut divides = shown.divides;
        while divides != 0 {
            let layer = divides.ilog2();
            divides &= !(1 << layer);
            done.add(self.draw_branches(second_branches | 1 << layer, layer as usize + 1, scratch, rows));
        }
        done
    }

    /// Shades the fragments of the layers in `scratch` and adds them to the picture.
    fn shade(
        &self,
        second_branches: u64,
        layers: usize,
        scratch: &mut TileScratch<L::Found>,
        rows: &mut [&mut [[f32; 4]]],
    ) -> TileReport {
        let mut watch = Stopwatch::new();
        let (plan, pattern) = (self.plan, &self.frame.pattern);
        let TileScratch { layers: ids, chains, surfaces, colors, parts, listed, found, .. } = scratch;
        let extent = [rows.first().map_or(0, |row| row.len()), rows.len()];
        let known = KnownSurfaces { plan, source: self.source, found };
        resolve(&known, pattern, &ids[..layers], extent, self.place.pixel, chains);
        if second_branches != 0 {
            // Surfaces without second branches have been drawn before.
            chains.retain(|chain| {
                let mut taken = (0..u64::BITS as usize).filter(|layer| second_branches >> layer & 1 != 0);
                taken.all(|layer| chain.get(layer).is_some_and(|&id| known.divides(layer, id)))
            });
        }
        let mut done = TileReport { resolve_ms: watch.lap_ms(), ..TileReport::default() };
        fetch_surfaces(&known, chains, pattern.samples, listed, surfaces);
        // All of them are set by the shader.
        colors.resize(chains.positions.len(), Vec3::ZERO);
        let batch = FragmentBatch { positions: &chains.positions, chain_ends: &chains.ends, surfaces, second_branches };
        self.shader.shade_batch(&batch, colors);
        done.fragments = colors.len() as u64;
        done.shade_ms = watch.lap_ms();
        if pattern.samples == 1 && second_branches == 0 {
            // Every pixel is one fragment.
            for (target, color) in chains.targets.iter().zip(colors.iter()) {
                rows[target.row as usize][target.column as usize] = color.extend(1.0).to_array();
            }
        } else {
            let unit = 1.0 / pattern.samples as f32;
            for (target, color) in chains.targets.iter().zip(colors.iter()) {
                let (pixel, weight) = (&mut rows[target.row as usize][target.column as usize], target.weight());
                let sum = Vec4::from(*pixel) + (*color * (f32::from(weight) * unit)).extend(0.0);
                *pixel = sum.to_array();
                if usize::from(weight) < pattern.samples {
                    parts.push((*target, *color));
                }
            }
        }
        done.resolve_ms += watch.lap_ms();
        done
    }

    /// Draws the layers from `first_layer` on into `scratch`.
    fn draw_layers(
        &self,
        second_branches: u64,
        first_layer: usize,
        scratch: &mut TileScratch<L::Found>,
    ) -> VisibleLayers {
        let Self { frame, plan, source, place, .. } = *self;
        let groups = groups_in_tile(frame.pattern.samples);
        let count = plan.layers.len().max(source.layer_count());
        let mut divides = 0u64;
        for index in first_layer..count {
            let TileScratch { layers, .. } = scratch;
            if layers.len() <= index {
                layers.push(Vec::new());
            }
            let mut ids = std::mem::take(&mut layers[index]);
            ids.clear();
            ids.resize(groups, Ids([EMPTY; LANES]));
            let second = index > 0 && second_branches >> (index - 1) & 1 != 0;
            let mut shown = self.draw_lists(index, second, scratch, &mut ids);
            if index > 0 && index < source.layer_count() && (index > 1 || self.has_groups()) {
                let extent = [0, 1].map(|axis| {
                    let size = [frame.width, frame.height][axis] as i32 - place.pixel[axis];
                    (size.max(0) as usize).min(TILE)
                });
                let tile = TileBelow {
                    pixel: place.pixel,
                    extent,
                    positions: frame.pattern.positions,
                    second_branches,
                    plan,
                    layers: &scratch.layers[..index],
                };
                let by_source = source.draw_layer(&tile, &mut scratch.found, bytemuck::cast_slice_mut(&mut ids));
                shown.any |= by_source.any;
                shown.divides |= by_source.divides;
            }
            scratch.layers[index] = ids;
            if let Some(below) = index.checked_sub(1).filter(|below| *below >= first_layer) {
                // The branches of the layers below are chosen already.
                divides |= u64::from(shown.divides) << below;
            }
            if !shown.any {
                return VisibleLayers { layers: index, divides };
            }
        }
        VisibleLayers { layers: count, divides }
    }

    /// Returns true if any triangle that may show in the first layer has a group: where none does, nothing goes on.
    fn has_groups(&self) -> bool {
        let Some(layer) = self.plan.layers.first() else { return false };
        self.bins[layer.pieces.clone()].iter().any(|bins| {
            let group = |number: u32| self.plan.triangle(bins.setup[number as usize].id).1.group;
            bins.of_tile(self.tile).iter().any(|&number| group(number) != 0)
        })
    }

    /// Draws the lists of a layer.
    fn draw_lists(
        &self,
        index: usize,
        second: bool,
        scratch: &mut TileScratch<L::Found>,
        ids: &mut [Ids],
    ) -> ShownBySource {
        let Self { frame, plan, bins, shader, tile, place, .. } = *self;
        let Some(layer) = plan.layers.get(index) else { return ShownBySource::default() };
        let TileScratch { keys, layers, labels, .. } = scratch;
        let (in_blocks, divides) = match index.checked_sub(1) {
            None => ([0; TILE_BLOCKS * TILE_BLOCKS], false),
            Some(below) => label(plan, layer, &layers[below], labels),
        };
        let present = in_blocks.iter().fold(0, |all, block| all | block);
        let visible = |bins: &&Bins| {
            let list = &plan.list_plans[bins.list as usize];
            let reached = index == 0 || (present >> (list.label & 63) & 1 != 0 && list.second == second);
            reached && !bins.of_tile(tile).is_empty()
        };
        let bins = || bins[layer.pieces.clone()].iter().filter(visible);
        if bins().next().is_none() {
            return ShownBySource { any: false, divides };
        }
        keys.clear();
        keys.resize(ids.len(), Keys([f32::NEG_INFINITY; LANES]));
        let mut target = LayerSamples { keys, ids };
        let corner = place.pixel.map(|pixel| pixel as usize / BLOCK);
        // The labels in blocks where a list is drawn.
        let drawn = |bins: &Bins| {
            let holes = &plan.lists[bins.list as usize].holes;
            let mut drawn = in_blocks;
            if !holes.is_empty() {
                for (block, labels) in drawn.iter_mut().enumerate() {
                    if holes.has(corner[0] + block % TILE_BLOCKS, corner[1] + block / TILE_BLOCKS) {
                        *labels = 0;
                    }
                }
            }
            drawn
        };
        let wanted = |bins: &Bins| plan.list_plans[bins.list as usize].label;
        for bins in bins() {
            let in_blocks = &drawn(bins);
            let stencil = (index > 0).then_some(StencilMask { labels, wanted: wanted(bins), in_blocks });
            draw_triangles(&frame.pattern, &place, &bins.setup, bins.of_tile(tile), stencil, &mut target);
        }
        for bins in bins().filter(|bins| plan.list_plans[bins.list as usize].alpha_tested) {
            let in_blocks = &drawn(bins);
            let triangles = bins.of_tile(tile).iter().map(|&number| &bins.setup[number as usize]);
            for triangle in triangles.filter(|triangle| triangle.alpha_tested) {
                let stencil = (index > 0).then_some(StencilMask { labels, wanted: wanted(bins), in_blocks });
                draw_tested(&frame.pattern, &place, triangle, stencil, &mut target, |position| {
                    shader.is_present(&surface_at(plan, triangle.id, position, 0.0), position)
                });
            }
        }
        ShownBySource { any: true, divides }
    }
}

/// Gives every sample the label of its surface in the layer below, and collects which labels each block holds and
/// whether light divides at any of them.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn label(
    plan: &Plan<'_>,
    layer: &LayerPlan,
    below: &[Ids],
    labels: &mut Vec<Ids>,
) -> ([u64; TILE_BLOCKS * TILE_BLOCKS], bool) {
    let mut divided = false;
    let mut in_blocks = [0; TILE_BLOCKS * TILE_BLOCKS];
    labels.clear();
    let groups_in_block = below.len() / in_blocks.len();
    // Neighbours mostly show the same.
    let (mut last_id, mut last_label) = (EMPTY, 0);
    for (in_block, groups) in in_blocks.iter_mut().zip(below.chunks_exact(groups_in_block)) {
        for Ids(ids) in groups {
            let mut found = [last_label; LANES];
            let differences = ids.iter().fold(0, |sum, id| sum | (id ^ last_id));
            if differences != 0 {
                for (found, &id) in found.iter_mut().zip(ids) {
                    if id != last_id {
                        last_id = id;
                        last_label = 0;
                        if id & FOUND == 0 {
                            let (list, triangle) = plan.triangle(id);
                            last_label = layer.label(list, triangle.group);
                            divided |= layer.divides(last_label);
                        }
                    }
                    if last_label != 0 {
                        *in_block |= 1 << (last_label & 63);
                    }
                    *found = last_label;
                }
            } else if last_label != 0 {
                *in_block |= 1 << (last_label & 63);
            }
            labels.push(Ids(found));
        }
    }
    (in_blocks, divided)
}

/// Draws a triangle sample by sample; `is_present` is true if it is there at a position in the picture (in pixels).
fn draw_tested(
    pattern: &Pattern,
    place: &TilePlace,
    triangle: &SetupTriangle,
    stencil: Option<StencilMask<'_>>,
    target: &mut LayerSamples<'_>,
    is_present: impl Fn(Vec2) -> bool,
) {
    let Some(columns) = overlap(triangle.columns, place.pixel[0]) else { return };
    let Some(rows) = overlap(triangle.rows, place.pixel[1]) else { return };
    let edges = edges(triangle, place);
    let [key_x, key_y, key_constant] = triangle.key_plane;
    let keys: &mut [f32] = bytemuck::cast_slice_mut(target.keys);
    let ids: &mut [u32] = bytemuck::cast_slice_mut(target.ids);
    let labels: Option<(&[u32], u32)> = stencil.map(|mask| (bytemuck::cast_slice(mask.labels), mask.wanted));
    for row in rows[0]..=rows[1] {
        for column in columns[0]..=columns[1] {
            let block = row / BLOCK * TILE_BLOCKS + column / BLOCK;
            if stencil.is_some_and(|mask| mask.in_blocks[block] >> (mask.wanted & 63) & 1 == 0) {
                continue;
            }
            let pixel = (block * BLOCK + row % BLOCK) * BLOCK + column % BLOCK;
            for (sample, offset) in pattern.positions.iter().enumerate() {
                let at = (Vec2::new(column as f32, row as f32) + *offset) * 16.0;
                if edges.iter().any(|edge| edge.at(at.x as i64, at.y as i64) < 0) {
                    continue;
                }
                let index = pixel * pattern.samples + sample;
                if labels.is_some_and(|(labels, wanted)| labels[index] != wanted) {
                    continue;
                }
                let from_center = place.from_center.map(f64::from);
                let (x, y) = (from_center[0] + at.x as f64 / 16.0, from_center[1] + at.y as f64 / 16.0);
                let key = (key_constant + key_x * x + key_y * y) as f32;
                let key = key.max(triangle.key_range[0]).min(triangle.key_range[1]);
                let position = Vec2::new(place.pixel[0] as f32, place.pixel[1] as f32) + at / 16.0;
                if key > keys[index] && is_present(position) {
                    keys[index] = key;
                    ids[index] = triangle.id;
                }
            }
        }
    }
}

/// The surfaces of all chains, with their attributes; `listed` is a buffer.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn fetch_surfaces<L: LayerSource>(
    known: &KnownSurfaces<'_, L>,
    chains: &Chains,
    samples: usize,
    listed: &mut Vec<u32>,
    surfaces: &mut Vec<LayerSurface>,
) {
    // All values from before are overwritten.
    surfaces.resize(chains.ids.len(), LayerSurface::default());
    listed.clear();
    let mut start = 0;
    for (fragment, &end) in chains.ends.iter().enumerate() {
        for index in start..end {
            match found_number(chains.ids[index as usize]) {
                None => listed.push(index),
                Some(number) => {
                    let mut surface = known.source.surface(known.found, number, chains.positions[fragment]);
                    of_part(&mut surface.barycentrics, chains.targets[fragment].weight(), samples);
                    surfaces[index as usize] = surface;
                }
            }
        }
        start = end;
    }
    fetch_listed(known.plan, chains, samples, listed, surfaces);
}

/// Confines a footprint to the part of a pixel that shows the surface.
#[inline(always)]
fn of_part(barycentrics: &mut Barycentrics, weight: u8, samples: usize) {
    if (weight as usize) < samples {
        // A part of a pixel stands for its share of the footprint.
        let side = (weight as f32 / samples as f32).sqrt();
        barycentrics.dx *= side;
        barycentrics.dy *= side;
    }
    barycentrics.samples = weight.into();
}

/// Sets the surfaces at the places in `listed`, which lists have drawn.
#[inline(always)]
fn fetch_listed(plan: &Plan<'_>, chains: &Chains, samples: usize, listed: &[u32], surfaces: &mut [LayerSurface]) {
    let (mut corners, mut result) = (CornerLanes::default(), Weights::default());
    let (mut fragment_weights, mut ids) = ([0u8; LANES], [0u32; LANES]);
    let mut fragment = 0;
    for places in listed.chunks(LANES) {
        for (lane, &place) in places.iter().enumerate() {
            while chains.ends[fragment] <= place {
                fragment += 1;
            }
            corners.set_position(lane, chains.positions[fragment]);
            fragment_weights[lane] = chains.targets[fragment].weight();
            ids[lane] = chains.ids[place as usize];
        }
        let ids = &ids[..places.len()];
        // One of several pieces may be shaded for all of them, at a place beside it.
        let leeway = |triangle: &DrawTriangle| if triangle.patch != 0 { PIECE_LEEWAY } else { 0.0 };
        let alike = ids.iter().fold(0, |differences, id| differences | (id ^ ids[0])) == 0;
        if alike {
            // Neighbours mostly show the same triangle.
            let (list, triangle) = plan.triangle(ids[0]);
            corners.set_all(plan.corners(list, triangle), leeway(triangle));
            for &place in places {
                let surface = &mut surfaces[place as usize];
                (surface.list, surface.source, surface.group) = (list, triangle.source, triangle.group);
            }
        } else {
            for (lane, (&id, &place)) in ids.iter().zip(places).enumerate() {
                let (list, triangle) = plan.triangle(id);
                let surface = &mut surfaces[place as usize];
                (surface.list, surface.source, surface.group) = (list, triangle.source, triangle.group);
                corners.set(lane, plan.corners(list, triangle), leeway(triangle));
            }
        }
        weights(&corners, &mut result);
        for (index, (&place, &id)) in places.iter().zip(ids).enumerate() {
            let surface = &mut surfaces[place as usize];
            let mut barycentrics = lane(&result, index);
            of_part(&mut barycentrics, fragment_weights[index], samples);
            surface.barycentrics = match plan.corners_in_source(surface.list, id) {
                Some(corners) => in_source(&barycentrics, corners),
                None => barycentrics,
            };
        }
    }
}
