//! Which triangle every ray hits, by tiles: passes and tables.

use super::passes::{Band, WORKGROUP, begin};
use super::paths::{Paths, Way};
use super::rough::RoughTables;
use super::targets::Targets;
use super::timer::Timer;
use crate::device::context::Context;
use crate::device::pipelines::{Pass, Pipelines, group};
use crate::device::scene::{DeviceScene, Upload};
use crate::error::GpuError;
use crate::layout::{NONE, Tiling};
use bytemuck::{Pod, Zeroable};
use std::num::NonZeroU64;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, TextureView};

/// Rays of a cell.
const RAYS: u32 = 4;
/// Cells along a side of a tile.
const TILE: u32 = 16;
/// Blocks of a tile.
pub(crate) const BLOCKS: u32 = 16;
/// Words before the queues: see `tiles/work.wgsl`.
const COUNTERS: u32 = 16;
/// Words that are counted anew for each path: of tiles, and of blocks to be traced.
const COUNTED_A_PATH: u64 = 2;
/// The word that counts tiles to be shaded path by path.
const SHADED: u64 = 4;
/// The first of those that are counted in a picture.
const COUNTED_A_PICTURE: u64 = 5;
/// From record to record: offsets of uniform buffers are multiples of 256.
const TILING_STRIDE: u64 = 256;
const TILING_SIZE: u64 = size_of::<Tiling>() as u64;
/// Bytes of the arguments of a dispatch.
const ARGUMENTS: u64 = 12;

/// Counts of what tiles did in a picture, as `tiles/work.wgsl` has them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TileCounts {
    /// Tiles.
    pub(crate) tiles: u32,
    /// Blocks of tiles whose rays are traced.
    pub(crate) traced_blocks: u32,
    /// Triangles in the beams of tiles.
    pub(crate) candidates: u32,
    /// Blocks of tiles times the triangles that they looked at.
    pub(crate) pairs: u32,
}

/// Pixels along a side of a cell.
pub(crate) fn cell_side(samples: u32) -> u32 {
    if samples == 1 { 2 } else { 1 }
}

/// Rows of pixels of a tile.
pub(crate) fn tile_rows(samples: u32) -> u32 {
    TILE * cell_side(samples)
}

/// Bytes of the table of hits.
pub(crate) fn hit_bytes(cells: [u32; 2], paths: Paths) -> u64 {
    u64::from(cells[0]) * u64::from(cells[1]) * u64::from(paths.slots() * RAYS * 4)
}

/// The tables of tiles for bands of pictures.
#[derive(Debug)]
pub(crate) struct TileTables {
    cells: [u32; 2],
    samples: u32,
    paths: Paths,
    /// The hits of the rays of each cell, path by path.
    pub(crate) hits: Buffer,
    pub(crate) work: Buffer,
    /// The numbers of tiles, of blocks whose rays are traced, and of tiles that are shaded path by path.
    arguments: Buffer,
    working: BindGroup,
    followed: u32,
    /// Where no geometry is drawn.
    no_lists: TextureView,
}

impl TileTables {
    /// Tables for bands of up to so many columns and rows of cells.
    pub(crate) fn new(context: &Context, cells: [u32; 2], samples: u32, paths: Paths) -> Result<Self, GpuError> {
        let Context { device, pipelines, .. } = context;
        let tiles = cells[0].div_ceil(TILE) * cells[1].div_ceil(TILE);
        let buffer = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let mut words = COUNTERS;
        let [queue, traced_queue, followed] = [1, BLOCKS, 1].map(|most| {
            words += most * tiles;
            words - most * tiles
        });
        let storage = BufferUsages::STORAGE;
        let hits = buffer("hits", hit_bytes(cells, paths), storage);
        let copied = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let work = buffer("work of tiles", u64::from(words) * 4, storage | copied);
        // Squares of pixels of a tile that is shaded.
        let squares = (tile_rows(samples) / WORKGROUP).pow(2);
        let groups: Vec<u32> = [1, 1, squares].into_iter().flat_map(|squares| [0, squares, 1]).collect();
        let usage = BufferUsages::INDIRECT | BufferUsages::COPY_DST;
        let arguments = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("numbers of tiles"),
            contents: bytemuck::cast_slice(&groups),
            usage,
        });
        let mut records = Vec::new();
        for (events, kinds) in paths.all() {
            let shade_queue = if (events, kinds) == (1, 0) { followed } else { NONE };
            let some_known = match paths.way {
                Way::Lists => 1,
                Way::FirstLists => u32::from(events == 1),
                _ => 0,
            };
            let record = Tiling { events, kinds, queue, traced_queue, shade_queue, some_known, ..Tiling::default() };
            records.extend_from_slice(bytemuck::bytes_of(&record));
            records.resize(records.len().next_multiple_of(TILING_STRIDE as usize), 0);
        }
        records.resize(records.len().max(TILING_STRIDE as usize), 0);
        let tilings = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("passes of tiles"),
            contents: &records,
            usage: BufferUsages::UNIFORM,
        });
        let record = wgpu::BufferBinding { buffer: &tilings, offset: 0, size: NonZeroU64::new(TILING_SIZE) };
        let resources =
            [(0, hits.as_entire_binding()), (1, work.as_entire_binding()), (2, BindingResource::Buffer(record))];
        let working = group(device, &pipelines.tiles.working, resources);
        let no_lists = Upload { context, byte_count: 0 }.numbers("no geometry", &[])?;
        context.check()?;
        Ok(Self { cells, samples, paths, hits, work, arguments, working, followed, no_lists })
    }

    /// The place of the queue of tiles that are shaded path by path.
    pub(crate) fn followed(&self) -> u32 {
        self.followed
    }

    /// Shades the tiles of that queue.
    pub(crate) fn dispatch_followed(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.dispatch_workgroups_indirect(&self.arguments, 2 * ARGUMENTS);
    }

    /// True if they serve bands of so many cells.
    pub(crate) fn serve(&self, cells: [u32; 2], samples: u32, paths: Paths) -> bool {
        self.cells == cells && self.samples == samples && self.paths == paths
    }

    /// Where they count what they do in a picture: a buffer, an offset and a size in bytes.
    pub(crate) fn counts(&self) -> (&wgpu::Buffer, u64, u64) {
        (&self.work, COUNTED_A_PICTURE * 4, size_of::<TileCounts>() as u64)
    }

    /// Begins a picture: nothing is counted yet.
    pub(crate) fn begin(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&self.work, 0, Some(u64::from(COUNTERS) * 4));
    }

    /// Fills the table of hits for a band: from pictures of what is seen directly and, if there are more, after each
    /// event or on every path, and by tiles.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        scene: &DeviceScene,
        Seen { targets, of_objects, rough }: Seen<'_>,
        band: &Band,
        timer: &mut Timer,
    ) {
        let Context { device, pipelines, .. } = context;
        let (Pipelines { tiles: pipelines, .. }, samples) = (pipelines, self.samples);
        let index = usize::from(samples > 1);
        let of_pass = |pass| pipelines.get(device, samples, scene.features, pass);
        let pictures = [&targets.ids].into_iter().chain(&targets.drawn);
        for ((events, kinds), picture) in [(0, 0)].into_iter().chain(self.paths.all()).zip(pictures) {
            let [picture, of_objects] =
                [picture, of_objects.unwrap_or(&self.no_lists)].map(BindingResource::TextureView);
            let resources = [(0, self.hits.as_entire_binding()), (1 + index as u32, picture), (3, of_objects)];
            let gathered = group(device, &pipelines.gathering[index], resources);
            let mut pass = begin(encoder, timer.compute("gather"));
            let holes_wait = self.paths.way == Way::FirstLists;
            pass.set_pipeline(&of_pass(Pass::Gather { events, kinds, holes_wait }));
            pass.set_bind_group(0, &scene.scene, &[band.record]);
            pass.set_bind_group(1, &gathered, &[]);
            let [across, down] = band.cells.map(|count| count.div_ceil(WORKGROUP));
            pass.dispatch_workgroups(across, down, 1);
        }
        rough.mark(encoder, context, (scene, &self.hits, samples), band, timer);
        encoder.clear_buffer(&self.work, SHADED * 4, Some(4));
        // Where nothing is to be followed it is enough to know where something is seen.
        let paths =
            if self.paths.way.follows_rays() { self.paths.all().count() } else { self.paths.events.min(1) as usize };
        for path in 0..paths {
            let record = (path as u64 * TILING_STRIDE) as u32;
            encoder.clear_buffer(&self.work, 0, Some(COUNTED_A_PATH * 4));
            {
                let mut pass = begin(encoder, timer.compute("classify"));
                pass.set_pipeline(&of_pass(Pass::Classify));
                pass.set_bind_group(0, &scene.scene, &[band.record]);
                pass.set_bind_group(2, &self.working, &[record]);
                let [across, down] = band.cells.map(|count| count.div_ceil(TILE));
                pass.dispatch_workgroups(across, down, 1);
            }
            if !self.paths.way.follows_rays() {
                continue;
            }
            for (index, (stage, kind)) in [("tiles", Pass::Cover), ("traced rays", Pass::Trace)].into_iter().enumerate()
            {
                let (word, arguments) = (index as u64 * 4, index as u64 * ARGUMENTS);
                encoder.copy_buffer_to_buffer(&self.work, word, &self.arguments, arguments, 4);
                let mut pass = begin(encoder, timer.compute(stage));
                pass.set_pipeline(&of_pass(kind));
                pass.set_bind_group(0, &scene.scene, &[band.record]);
                pass.set_bind_group(1, &scene.hierarchy, &[]);
                pass.set_bind_group(2, &self.working, &[record]);
                pass.dispatch_workgroups_indirect(&self.arguments, arguments);
            }
        }
        encoder.copy_buffer_to_buffer(&self.work, SHADED * 4, &self.arguments, 2 * ARGUMENTS, 4);
    }
}

/// Pictures and tables that are there before tiles begin.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'a> {
    /// Pictures of what is seen.
    pub(crate) targets: &'a Targets,
    /// From which objects geometry goes on, where that of paths is drawn.
    pub(crate) of_objects: Option<&'a TextureView>,
    /// The light of rough mirrors.
    pub(crate) rough: &'a RoughTables,
}
