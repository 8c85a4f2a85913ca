//! The light that rough mirrors reflect: grids of sharp rays, blurred by the lobe of each place. See `wgsl/rough`.

use super::passes::{Band, WORKGROUP, begin};
use super::timer::Timer;
use crate::device::context::Context;
use crate::device::pipelines::{BLUR, FIND_NEAR, FOLLOW, MARK, MEET, REDUCE, group};
use crate::device::scene::DeviceScene;
use crate::layout::{GRIDS, Grids, LIGHT_BYTES, MOST_REDUCTIONS, PASSAGE_BYTES, SHARP_BYTES, WORD_BYTES};
use catoptric::scene::{Scene, View};
use glam::Vec3;
use std::num::NonZeroU64;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};

/// Cells of the finest grid along the shorter side of a picture, at least, unless memory allows no more.
const CELLS: u32 = 480;
/// The longest side of such a cell, in pixels, if memory allows shorter ones.
const LARGEST_CELL_PX: u32 = 2;
/// Lobes may look for cells so many of the largest ones beyond the picture.
const MARGIN: u32 = 16;
/// Beyond this many diagonals of the scene, nothing moves in what a place sees.
const FAR_DIAGONALS: f32 = 100.0;
const GRIDS_SIZE: u64 = size_of::<Grids>() as u64;
/// From record to record: offsets of uniform buffers are multiples of 256.
const STRIDE: u64 = GRIDS_SIZE.next_multiple_of(256);
/// A record a grid, then one for each mean.
const RECORDS: u64 = (GRIDS + MOST_REDUCTIONS) as u64;
/// The light of rough mirrors in pictures of a size; without any, of nothing.
#[derive(Debug)]
pub(crate) struct RoughTables {
    light: Buffer,
    /// A record for each pass.
    records: Buffer,
    grids: Option<GridTables>,
}

#[derive(Debug)]
struct GridTables {
    layout: Grids,
    group: BindGroup,
    byte_count: u64,
}

/// The grids of pictures of a size, whose finest one has cells of a side.
fn grids_of([width, height]: [u32; 2], finest_px: u32) -> Grids {
    let coarsest_px = finest_px << (GRIDS - 1);
    let [width, height] = [width, height].map(|side| side.div_ceil(coarsest_px) + 2 * MARGIN);
    let mut first = 0;
    let levels = std::array::from_fn(|level| {
        let [width, height] = [width << level, height << level];
        first += width * height;
        [width, height, coarsest_px >> level, first - width * height]
    });
    let mut grids = Grids { levels, margin_px: (MARGIN * coarsest_px) as f32, ..Grids::default() };
    let [mut width, mut height] = [width * 2, height * 2];
    let mut first = 0;
    for reduction in &mut grids.reductions {
        *reduction = [width, height, first, 0];
        first += width * height;
        grids.reduction_count += 1;
        if width.max(height) == 1 {
            break;
        }
        [width, height] = [width, height].map(|side| side.div_ceil(2));
    }
    grids
}

/// The cells of all grids, and those of all means.
fn cell_counts(grids: &Grids) -> [u64; 2] {
    let all =
        |levels: &[[u32; 4]]| levels.iter().map(|&[width, height, ..]| u64::from(width) * u64::from(height)).sum();
    [all(&grids.levels), all(&grids.reductions)]
}

impl RoughTables {
    /// Tables for pictures of a size; of nothing, if there are no rough mirrors.
    pub(crate) fn new(context: &Context, size: [u32; 2], has_grids: bool) -> Self {
        let Context { device, pipelines, .. } = context;
        let buffer = |label, size: u64| {
            let usage = BufferUsages::STORAGE;
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let records = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("grids"),
            size: STRIDE * RECORDS,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        if !has_grids {
            return Self { light: buffer("no rough mirrors", LIGHT_BYTES), records, grids: None };
        }
        let limits = device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / PASSAGE_BYTES;
        let wanted_px = (size[0].min(size[1]) / CELLS).clamp(1, LARGEST_CELL_PX);
        let mut layouts = (wanted_px..).map(|finest_px| grids_of(size, finest_px));
        // For all pictures that devices draw, cells of a few pixels are few enough.
        let layout = layouts.find(|layout| cell_counts(layout)[0] <= most).unwrap_or_default();
        let [cells, means] = cell_counts(&layout);
        let sizes = [
            (0, "what rays meet", cells * WORD_BYTES),
            (1, "what is near", cells * WORD_BYTES),
            (2, "rays of rough mirrors", cells * PASSAGE_BYTES),
            (3, "the light of rough mirrors", cells * LIGHT_BYTES),
            (4, "what sharp rays show", cells * SHARP_BYTES),
            (6, "lobes", cells * LIGHT_BYTES),
            (7, "means", means * SHARP_BYTES),
        ];
        let buffers = sizes.map(|(binding, label, size)| (binding, buffer(label, size)));
        let record = wgpu::BufferBinding { buffer: &records, offset: 0, size: NonZeroU64::new(GRIDS_SIZE) };
        let resources = buffers.iter().map(|(binding, buffer)| (*binding, buffer.as_entire_binding()));
        let resources = resources.chain([(5, BindingResource::Buffer(record))]);
        let group = group(device, &pipelines.rough.tables, resources);
        let byte_count = sizes.iter().map(|(_, _, size)| size).sum();
        let light = buffers[3].1.clone();
        Self { light, records, grids: Some(GridTables { layout, group, byte_count }) }
    }

    /// Memory that grids take on the device.
    pub(crate) fn byte_count(&self) -> u64 {
        self.grids.as_ref().map_or(0, |grids| grids.byte_count)
    }

    /// The bindings that shaders of pixels read: the light of rough mirrors, and the grids.
    pub(crate) fn read(&self) -> [(u32, BindingResource<'_>); 2] {
        let record = wgpu::BufferBinding { buffer: &self.records, offset: 0, size: NonZeroU64::new(GRIDS_SIZE) };
        [(3, self.light.as_entire_binding()), (5, BindingResource::Buffer(record))]
    }

    /// Traces and blurs the grids of a view.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        (resident, scene, view): (&DeviceScene, &Scene, &View),
        timer: &mut Timer,
    ) {
        let Some(GridTables { layout, group, .. }) = &self.grids else { return };
        let Context { device, pipelines, .. } = context;
        self.write_records(encoder, device, layout, scene, view);
        let of_pass = |pass| pipelines.rough.get(device, pass, resident.features, 1);
        let levels = 0..GRIDS;
        let mut dispatch = |stage, passes: &[((usize, &'static str), usize)]| {
            let mut pass = begin(encoder, timer.compute(stage));
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(1, &resident.hierarchy, &[]);
            for (kind, record) in passes {
                let place = layout.levels.iter().chain(&layout.reductions).nth(*record);
                let [width, height] = place.map_or([0; 2], |&[width, height, ..]| [width, height]);
                pass.set_pipeline(&of_pass(*kind));
                pass.set_bind_group(2, group, &[(*record as u64 * STRIDE) as u32]);
                pass.dispatch_workgroups(width.div_ceil(WORKGROUP), height.div_ceil(WORKGROUP), 1);
            }
        };
        for level in levels.clone() {
            let mut passes = vec![(MEET, level)];
            // Hidden places are looked for near those that are seen.
            passes.extend((level == 0).then_some((FIND_NEAR, level)));
            passes.push((FOLLOW, level));
            passes.extend((level + 1 < GRIDS).then_some((FIND_NEAR, level)));
            dispatch("rough mirrors", &passes);
        }
        let reductions = (0..layout.reduction_count as usize).map(|reduction| (REDUCE, GRIDS + reduction));
        let passes: Vec<_> = reductions.chain(levels.map(|level| (BLUR, level))).collect();
        dispatch("blur", &passes);
    }

    /// Copies in the order of the work: the caller may draw other views before all is submitted.
    fn write_records(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        device: &wgpu::Device,
        layout: &Grids,
        scene: &Scene,
        view: &View,
    ) {
        let forward = -Vec3::from(view.world_from_view.matrix3.z_axis);
        let greatest_distance = FAR_DIAGONALS * scene.bounds.diagonal().max(f32::MIN_POSITIVE);
        let of_view = Grids { forward: forward.to_array(), near: view.near, greatest_distance, ..*layout };
        let mut contents = Vec::new();
        for record in 0..RECORDS as u32 {
            let (level, reduction) = (record.min(GRIDS as u32 - 1), record.saturating_sub(GRIDS as u32));
            contents.extend_from_slice(bytemuck::bytes_of(&Grids { level, reduction, ..of_view }));
            contents.resize(contents.len().next_multiple_of(STRIDE as usize), 0);
        }
        let usage = BufferUsages::COPY_SRC;
        let staged =
            device.create_buffer_init(&BufferInitDescriptor { label: Some("grids"), contents: &contents, usage });
        encoder.copy_buffer_to_buffer(&staged, 0, &self.records, 0, contents.len() as u64);
    }

    /// Marks the hits of a band from which no ray needs to be followed.
    pub(crate) fn mark(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        (resident, hits, samples): (&DeviceScene, &Buffer, u32),
        band: &Band,
        timer: &mut Timer,
    ) {
        if self.grids.is_none() {
            return;
        }
        let Context { device, pipelines, .. } = context;
        let resources = [(0, hits.as_entire_binding())].into_iter().chain(self.read());
        let marking = group(device, &pipelines.rough.marking, resources);
        let mut pass = begin(encoder, timer.compute("gather"));
        pass.set_pipeline(&pipelines.rough.get(device, MARK, resident.features, samples));
        pass.set_bind_group(0, &resident.scene, &[band.record]);
        pass.set_bind_group(2, &marking, &[]);
        let [across, down] = band.cells.map(|count| count.div_ceil(WORKGROUP));
        pass.dispatch_workgroups(across, down, 1);
    }
}
