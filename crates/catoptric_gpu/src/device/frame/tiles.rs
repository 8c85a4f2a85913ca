//! Which triangle every ray hits, by tiles: passes and tables.

use super::rough::RoughTables;
use super::targets::Targets;
use super::timer::Timer;
use crate::device::context::Context;
use crate::device::kept::Kept;
use crate::device::pipelines::{
    Pipelines, layout, pipeline_layout, shader_module, table, texture, uniform, written_storage,
};
use crate::device::upload::{DeviceScene, Reflections, Upload, group};
use crate::error::GpuError;
use crate::layout::{NONE, Tiling};
use crate::tables::SceneFeatures;
use bytemuck::{Pod, Zeroable};
use std::num::NonZeroU64;

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, Buffer, BufferUsages};
use wgpu::{ComputePipeline, ShaderStages, TextureSampleType, TextureView};

/// Rays of a cell.
const RAYS: u32 = 4;
/// Cells along a side of a tile.
const TILE: u32 = 16;
/// Blocks of a tile.
pub(crate) const BLOCKS: u32 = 16;
/// Pixels along a side of a workgroup that shades, and cells of one that gathers.
pub(crate) const WORKGROUP: u32 = 8;
/// Longer paths are traced.
const MOST_EVENTS: u32 = 2;
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

/// What tiles did in a picture, as `tiles/work.wgsl` counts it.
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

/// The paths whose rays tiles follow, at an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Paths {
    /// The most events.
    pub(crate) events: u32,
    has_lenses: bool,
    /// Grids of rays tell what rough mirrors reflect.
    pub(crate) has_grids: bool,
    way: Way,
}

/// How what rays hit becomes known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Tiles follow rays.
    Tiles,
    /// Light is looked up at the first event.
    LookUp,
    /// Hardware has drawn what is seen after every number of mirrors.
    Mirrors,
    /// Hardware has drawn what is seen on some paths; tiles follow the others.
    Lists,
    /// It has drawn what is seen after one event, but not all of that; tiles follow the rest and longer paths.
    FirstLists,
}

impl Way {
    fn follows_rays(self) -> bool {
        matches!(self, Self::Tiles | Self::Lists | Self::FirstLists)
    }

    fn draws(self) -> bool {
        matches!(self, Self::Mirrors | Self::Lists | Self::FirstLists)
    }
}

impl Paths {
    /// Of a scene; `first_lists` if virtual geometry is found on the device.
    pub(crate) fn of(scene: &DeviceScene, order: u32, first_lists: bool) -> Self {
        let (way, most) = match &scene.reflections {
            Reflections::Followed => (Way::Tiles, MOST_EVENTS),
            Reflections::LookedUp(_) | Reflections::Fields(_) | Reflections::Layers(_) => (Way::LookUp, 1),
            Reflections::Mirrored(_) => (Way::Mirrors, order),
            Reflections::Projected(_) if first_lists => (Way::FirstLists, MOST_EVENTS),
            Reflections::Projected(_) => (Way::Lists, MOST_EVENTS),
        };
        let events = if scene.has_specular { order.min(most) } else { 0 };
        let has_lenses = scene.features.has_lenses() && way.follows_rays();
        let has_grids = scene.features.has_rough() && way.follows_rays() && events > 0;
        Self { events, has_lenses, has_grids, way }
    }

    /// The most events after which the table of hits knows what rays hit.
    pub(crate) fn known_events(self) -> u32 {
        if self.way == Way::LookUp { 0 } else { self.events }
    }

    /// The number of paths on which hardware draws what is seen.
    pub(crate) fn drawn(self) -> usize {
        match self.way {
            Way::FirstLists => self.events.min(1) as usize,
            way if way.draws() => self.all().count(),
            _ => 0,
        }
    }

    /// Paths with their events and kinds, shorter ones first.
    pub(crate) fn all(self) -> impl Iterator<Item = (u32, u32)> {
        let kinds = move |events: u32| if self.has_lenses { 1 << events } else { 1 };
        (1..=self.events).flat_map(move |events| (0..kinds(events)).map(move |kinds| (events, kinds)))
    }

    /// Entries of the table of hits that a cell has.
    pub(crate) fn slots(self) -> u32 {
        if self.way == Way::LookUp { 1 } else { 1 + self.all().count() as u32 }
    }
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

/// A pass of tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Pass {
    /// Reads a picture of what is seen after so many events of kinds.
    Gather {
        events: u32,
        kinds: u32,
        holes_wait: bool,
    },
    Classify,
    Cover,
    Trace,
}

/// The pipelines of tiles.
#[derive(Debug)]
pub(crate) struct TilePipelines {
    /// Hits, and the picture of what is seen; for one sample a pixel, and for several.
    gathering: [BindGroupLayout; 2],
    /// Hits, work, and what a pass works on.
    working: BindGroupLayout,
    gather_layouts: [wgpu::PipelineLayout; 2],
    gather: wgpu::ShaderModule,
    /// Of classification, tiles and traced rays.
    modules: [wgpu::ShaderModule; 3],
    layouts: [wgpu::PipelineLayout; 2],
    /// By samples and what scenes have.
    known: Kept<(u32, SceneFeatures, Pass), ComputePipeline>,
}

impl TilePipelines {
    pub(crate) fn new(device: &wgpu::Device, scene: &BindGroupLayout, hierarchy: &BindGroupLayout) -> Self {
        let stage = ShaderStages::COMPUTE;
        let seen = |binding, multisampled| texture(binding, TextureSampleType::Uint, multisampled);
        let gathering = [seen(1, false), seen(2, true)]
            .map(|seen| layout(device, "gathering", stage, &[written_storage(0), seen, table(3)]));
        let working = layout(device, "tiles", stage, &[written_storage(0), written_storage(1), (2, uniform(true))]);
        let module = |path: &str| shader_module(device, path);
        let gather = module("tiles/gather.wgsl");
        let gather_layouts = [0, 1].map(|index| pipeline_layout(device, &[scene, &gathering[index]]));
        let modules = [module("tiles/classify.wgsl"), module("tiles/cover.wgsl"), module("tiles/trace.wgsl")];
        let empty = layout(device, "nothing", stage, &[]);
        let layouts = [
            pipeline_layout(device, &[scene, &empty, &working]),
            pipeline_layout(device, &[scene, hierarchy, &working]),
        ];
        Self { gathering, working, gather_layouts, gather, modules, layouts, known: Kept::default() }
    }

    fn get(&self, device: &wgpu::Device, samples: u32, features: SceneFeatures, pass: Pass) -> ComputePipeline {
        // All but tracing need to know no more of a scene than what changes rays.
        let features = if pass == Pass::Trace { features } else { features.of_rays() };
        self.known.get((samples, features, pass), || {
            let mut constants = features.constants();
            constants.push(("SAMPLES", f64::from(samples)));
            let (layout, module, entry) = match pass {
                Pass::Gather { events, kinds, holes_wait } => {
                    let numbers = [("EVENTS", events), ("KINDS", kinds), ("HOLES_WAIT", u32::from(holes_wait))];
                    constants.extend(numbers.map(|(name, number)| (name, f64::from(number))));
                    let index = usize::from(samples > 1);
                    let entry = ["gather_one_sample", "gather_four_samples"][index];
                    (&self.gather_layouts[index], &self.gather, entry)
                }
                Pass::Classify => (&self.layouts[0], &self.modules[0], "classify"),
                Pass::Cover => (&self.layouts[1], &self.modules[1], "cover"),
                Pass::Trace => (&self.layouts[1], &self.modules[2], "trace"),
            };
            compute(device, layout, module, entry, &constants)
        })
    }
}

/// A pipeline that computes.
pub(crate) fn compute(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    entry: &str,
    constants: &[(&str, f64)],
) -> ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(layout),
        module,
        entry_point: Some(entry),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

/// The tables of tiles for bands of pictures.
#[derive(Debug)]
pub(crate) struct TileTables {
    cells: [u32; 2],
    samples: u32,
    paths: Paths,
    /// What the rays of each cell hit, path by path.
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

/// What is known before tiles begin.
#[derive(Clone, Copy)]
pub(crate) struct Seen<'a> {
    /// Pictures of what is seen.
    pub(crate) targets: &'a Targets,
    /// From which objects geometry goes on, where that of paths is drawn.
    pub(crate) of_objects: Option<&'a TextureView>,
    /// The light of rough mirrors.
    pub(crate) rough: &'a RoughTables,
}

/// Begins a pass whose time may be taken.
pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
) -> wgpu::ComputePass<'a> {
    encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes })
}

/// Rows of a picture that are drawn at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    /// The place of its record.
    pub(crate) record: u32,
    /// Columns and rows of cells.
    pub(crate) cells: [u32; 2],
    /// Rows of pixels.
    pub(crate) rows: u32,
}
