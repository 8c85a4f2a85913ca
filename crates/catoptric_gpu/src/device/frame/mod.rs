//! The drawing of a frame on a device.

mod confined;
mod drawn_scene;
mod lookup;
mod passes;
mod paths;
mod picture;
mod reflections;
mod rough;
mod samples;
mod targets;
mod tiles;
mod timer;

pub(crate) use confined::{DeviceMirrors, OnDevice, Search};
pub(crate) use drawn_scene::DrawnScene;
pub(crate) use lookup::{DeviceFields, DeviceLayers, DeviceMaps};
pub(crate) use reflections::Reflections;
pub(crate) use timer::Timer;

use super::context::Context;
use super::pipelines::{Meeting, SAMPLE_COUNTS, Shading, group};
use super::readback::{Label, Readback};
use super::scene::{DeviceScene, FRAME_STRIDE, MAX_BANDS};
use crate::error::GpuError;
use crate::layout::{Appearance, Frame, MAX_ORDER, Reflection, bits, frame_flags};
use catoptric::methods::path_lists::PathLists;
use catoptric::methods::{Quality, Report};
use catoptric::scene::{Scene, View};
use confined::{DeviceLists, VirtualCounts, VirtualTables};
use glam::{Mat4, Vec3, Vec4};
use passes::{Band, WORKGROUP, begin};
use paths::Paths;
use picture::PictureTables;
use samples::{Part, Sums, parts_of};
use std::sync::Arc;
use targets::Targets;
use tiles::{BLOCKS, Seen, TileCounts, cell_side, hit_bytes, tile_rows};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BufferUsages, TextureView};

/// The most pixels of a piece of work: longer ones would let a screen freeze.
const PIXELS_AT_ONCE: u32 = 1 << 20;
/// The most tiles: a dispatch has at most 65,535 groups, of which tracing may need one for each of their blocks.
const TILES_AT_ONCE: u32 = 65_535 / BLOCKS;
/// The most bytes of a band's table of hits: devices bind no more than 128 MiB.
const HIT_BYTES_AT_ONCE: u64 = 1 << 27;
/// The shaders' functions for pixels without mirrors and glass, and for those with them; for each of [`SAMPLE_COUNTS`].
const ENTRIES: [[&str; 2]; 2] =
    [["shade_one_sample", "follow_one_sample"], ["shade_four_samples", "follow_four_samples"]];
/// The last of them for scenes in which light spreads.
const SPREADING: &str = "follow_four_samples_spreading";

/// Refuses what no pipeline draws.
pub(crate) fn check_quality(quality: Quality) -> Result<(), GpuError> {
    let refuse = |needed: String, allowed: String| {
        let (what, remedy) = ("the picture".into(), "use the CPU backend");
        Err(GpuError::Limit { what, needed, allowed, remedy })
    };
    if parts_of(quality.samples).is_empty() {
        return refuse(format!("{} samples a pixel", quality.samples), "1, 2, 4, 8 or 16".into());
    }
    if quality.order > MAX_ORDER {
        return refuse(format!("order {}", quality.order), format!("up to {MAX_ORDER}"));
    }
    Ok(())
}

/// A view of a scene, and the geometry of its paths where that is drawn.
#[derive(Clone, Copy)]
pub(crate) struct Sight<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) view: &'a View,
    pub(crate) quality: Quality,
    pub(crate) geometry: Option<Geometry<'a>>,
}

/// The geometry of a view's paths.
#[derive(Clone, Copy)]
pub(crate) enum Geometry<'a> {
    /// The processor has found it.
    Lists(&'a PathLists),
    /// The device finds it.
    OnDevice(&'a Found),
}

/// The reflectors of a view whose geometry the device finds, and the tables for it.
#[derive(Debug)]
pub(crate) struct Found {
    reflectors: Vec<Reflection>,
    tables: Arc<VirtualTables>,
}

impl Found {
    /// For a view; `None` where the processor finds it.
    pub(crate) fn new(
        context: &Context,
        drawn: &DrawnScene,
        scene: &Scene,
        view: &View,
    ) -> Result<Option<Self>, GpuError> {
        let DrawnScene { resident, reflections, virtual_tables, .. } = drawn;
        let Reflections::Projected(Some(on_device)) = reflections else { return Ok(None) };
        let clip_from_world = clip_from_world(scene, view, view.rays().perspective);
        let Some(reflectors) = on_device.seen_in(scene, view, &clip_from_world) else { return Ok(None) };
        let tables = VirtualTables::get(context, resident, virtual_tables, on_device, [view.width, view.height])?;
        Ok(tables.map(|tables| Self { reflectors, tables }))
    }
}

/// A view that has been drawn, once the work is done.
#[derive(Debug)]
pub(crate) struct Drawing {
    tables: Arc<PictureTables>,
    virtual_tables: Option<Arc<VirtualTables>>,
    /// Counts of what has been left out.
    pub(crate) report: Report,
}

impl Drawing {
    /// The view's colours, until another view of the scene is drawn.
    pub(crate) fn colors(&self) -> &wgpu::Texture {
        &self.tables.targets.colors
    }

    /// Copies what was counted, to be read once the work is done.
    pub(crate) fn copy_counts(&self, context: &Context, encoder: &mut wgpu::CommandEncoder, readback: &mut Readback) {
        readback.buffer(&context.device, encoder, Label::Tiles, self.tables.tiles.counts());
        if let Some(tables) = &self.virtual_tables {
            readback.buffer(&context.device, encoder, Label::VirtualGeometry, tables.counts());
        }
    }

    /// Adds what was counted to a report.
    pub(crate) fn count(&self, readback: &Readback, report: &mut Report) -> Result<(), GpuError> {
        for counts in readback.records::<TileCounts>(Label::Tiles)? {
            report.counts.extend([
                ("tiles", u64::from(counts.tiles)),
                ("blocks_traced", u64::from(counts.traced_blocks)),
                ("candidates", u64::from(counts.candidates)),
                ("pairs", u64::from(counts.pairs)),
            ]);
        }
        for counts in readback.records::<VirtualCounts>(Label::VirtualGeometry)? {
            let VirtualCounts { drawn, projected, unfinished, left_reflectors } = counts;
            report
                .counts
                .extend([("virtual_triangles", u64::from(drawn)), ("vertices_projected", u64::from(projected))]);
            report.add_fallback("undivided_pieces", u64::from(unfinished));
            report.add_fallback("paths_drawn_by_tiles", u64::from(left_reflectors));
        }
        Ok(())
    }
}

/// Adds the drawing of a view, which has pixels, to other work.
pub(crate) fn encode(
    context: &Context,
    drawn_scene: &DrawnScene,
    sight: Sight<'_>,
    encoder: &mut wgpu::CommandEncoder,
    timer: &mut Timer,
) -> Result<Drawing, GpuError> {
    let Sight { scene, view, quality, geometry } = sight;
    let mut report = Report::default();
    let (mut lists, mut virtual_tables) = (None, None);
    match geometry {
        Some(Geometry::Lists(found)) => lists = Some(DeviceLists::new(context, scene, view, found, &mut report)?),
        Some(Geometry::OnDevice(found)) => {
            report.bytes.insert("gpu_virtual_geometry", found.tables.byte_count());
            virtual_tables = Some(found.tables.clone());
        }
        None => {}
    }
    let parts = parts_of(quality.samples);
    let mut sums = Sums::new(context, [view.width, view.height], parts.len());
    let mut drawn = None;
    for part in parts {
        let (tables, of_part) = encode_part(context, drawn_scene, (sight, part), lists.as_ref(), encoder, timer)?;
        if let Some(sums) = &mut sums {
            sums.add(encoder, context, &tables.targets.colors, timer);
        }
        // The reports of all parts are the same.
        drawn = Some((tables, of_part));
    }
    context.check()?;
    let (tables, of_parts) = drawn.ok_or_else(|| GpuError::Device { problem: "nothing was drawn".into() })?;
    report.add(of_parts);
    Ok(Drawing { tables, virtual_tables, report })
}

/// The same of a part of the samples.
fn encode_part(
    context: &Context,
    drawn_scene: &DrawnScene,
    (sight, part): (Sight<'_>, Part),
    lists: Option<&DeviceLists>,
    encoder: &mut wgpu::CommandEncoder,
    timer: &mut Timer,
) -> Result<(Arc<PictureTables>, Report), GpuError> {
    let Context { device, pipelines, .. } = context;
    let DrawnScene { resident, reflections, .. } = drawn_scene;
    let Sight { scene, view, quality: Quality { order, .. }, geometry } = sight;
    let quality = Quality { samples: part.samples, order };
    let index = SAMPLE_COUNTS.iter().position(|count| *count == part.samples).unwrap_or_default();
    let way = reflections.way(matches!(geometry, Some(Geometry::OnDevice(_))));
    let paths = Paths::of(resident, quality.order, way);
    // The tables by which paths are shaded, beside the hits on them.
    let (meeting, hierarchy, looked_up) = match reflections {
        Reflections::LookedUp(maps) => (Meeting::Maps, &resident.hierarchy, Some(&maps.group)),
        Reflections::Fields(fields) => (Meeting::Fields, &fields.hierarchy, Some(&fields.group)),
        Reflections::Layers(layers) => (Meeting::Layers, &layers.hierarchy, Some(&layers.group)),
        _ => (Meeting::Followed, &resident.hierarchy, None),
    };
    // Rays that leave surfaces that spread light are traced.
    let traces = quality.order > paths.known_events() || resident.features.spreads_light();
    let [seen, mut followed] = ENTRIES[index];
    if resident.features.spreads_light() && part.samples > 1 {
        followed = SPREADING;
    }
    let (samples, features) = (quality.samples, resident.features);
    let shade = |entry, meeting| pipelines.shade(device, Shading { entry, samples, features, traces, meeting });
    let seen = shade(seen, Meeting::Followed);
    let followed = shade(followed, meeting);
    let rows = rows_at_once(view, quality.samples, paths);
    let size = [view.width, view.height];
    let cells = cells_of(view.width, rows, samples);
    let picture_tables = PictureTables::get(context, &drawn_scene.picture, size, cells, samples, paths)?;
    let PictureTables { targets, tiles: tables, rough, .. } = &*picture_tables;
    let written = targets.colors.create_view(&Default::default());
    let resources = [
        (0, tables.hits.as_entire_binding()),
        (1, wgpu::BindingResource::TextureView(&written)),
        (2, tables.work.as_entire_binding()),
    ];
    let picture = group(device, &pipelines.picture, resources.into_iter().chain(rough.read()));
    let mut record = frame_record(scene, view, quality, drawn_scene);
    record.tiled_events = paths.known_events();
    record.followed = tables.followed();
    (record.sample_place, record.sample_side) = (part.place, part.side);
    let (bands, records) = bands_of(&record, rows, samples);
    write_frames(encoder, context, resident, &records);
    targets.draw_ids(encoder, context, resident, index, timer);
    let mut report = Report::default();
    let canvas = Canvas { context, drawn_scene, targets, index, is_first: part.is_first };
    let of_objects = draw_paths(encoder, canvas, (sight, quality, paths), lists, timer, &mut report)?;
    let known = Seen { targets, of_objects, rough };
    if part.is_first {
        rough.encode(encoder, context, (resident, scene, view), timer);
    }
    if paths.has_grids {
        report.bytes.insert("gpu_rough_mirrors", rough.byte_count());
    }
    tables.begin(encoder);
    for band in bands {
        tables.encode(encoder, context, resident, known, &band, timer);
        for (stage, pipeline, is_followed) in [("shade seen", &seen, false), ("shade paths", &followed, true)] {
            if is_followed && paths.events == 0 {
                continue;
            }
            let mut pass = begin(encoder, timer.compute(stage));
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &resident.scene, &[band.record]);
            pass.set_bind_group(1, if is_followed { hierarchy } else { &resident.hierarchy }, &[]);
            pass.set_bind_group(2, &picture, &[]);
            if let Some(group) = looked_up.filter(|_| is_followed) {
                pass.set_bind_group(3, group, &[]);
            }
            match is_followed {
                true => tables.dispatch_followed(&mut pass),
                false => pass.dispatch_workgroups(view.width.div_ceil(WORKGROUP), band.rows.div_ceil(WORKGROUP), 1),
            }
        }
    }
    Ok((picture_tables.clone(), report))
}

/// Writes the records of frames in the order of the work: the caller may draw other views before all is submitted.
fn write_frames(encoder: &mut wgpu::CommandEncoder, context: &Context, resident: &DeviceScene, records: &[u8]) {
    let descriptor = BufferInitDescriptor { label: Some("frames"), contents: records, usage: BufferUsages::COPY_SRC };
    let staged = context.device.create_buffer_init(&descriptor);
    encoder.copy_buffer_to_buffer(&staged, 0, &resident.frame, 0, records.len() as u64);
}

/// Where the vertices of a scene appear in a view, reflector by reflector: waits for the device.
pub(crate) fn vertex_appearances(
    context: &Context,
    drawn_scene: &DrawnScene,
    (scene, view, quality): (&Scene, &View, Quality),
    found: &Found,
) -> Result<Vec<VertexAppearance>, GpuError> {
    let (Found { reflectors, tables }, resident) = (found, &drawn_scene.resident);
    let record = frame_record(scene, view, quality, drawn_scene);
    let axis = -Vec3::from(view.world_from_view.matrix3.z_axis);
    let mut all = Vec::new();
    for reflector in reflectors {
        let alone = Reflection { number: 0, ..*reflector };
        let mut encoder = context.device.create_command_encoder(&Default::default());
        write_frames(&mut encoder, context, resident, bytemuck::bytes_of(&record));
        tables.find(&mut encoder, context, resident, &[alone], &mut Timer::none());
        context.queue.submit([encoder.finish()]);
        for (vertex, Appearance { image_px, depth, state, .. }) in tables.appearances(context, &alone)? {
            let direction = view.ray_with_differential(image_px[0], image_px[1]).0.direction;
            let path_length = depth / direction.dot(axis);
            let (reflector, is_beside) = (alone.object, state != WITHIN);
            all.push(VertexAppearance { reflector, vertex, image_px, path_length, is_beside });
        }
    }
    context.check()?;
    Ok(all)
}

/// Where a vertex of the scene appears in a reflector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexAppearance {
    /// The object that reflects it.
    pub reflector: u32,
    /// The number of the vertex.
    pub vertex: u32,
    /// The appearance's place in the picture, in pixels from the upper left corner.
    pub image_px: [f32; 2],
    /// From the eye by the reflector to the vertex (orthographic: from the eye's plane).
    pub path_length: f32,
    /// True if the vertex appears next to the reflector, where that does not show it any more.
    pub is_beside: bool,
}

/// The state of appearances in the reflector.
const WITHIN: u32 = 1;

/// The scene and textures with which the geometry of paths is drawn.
#[derive(Clone, Copy)]
struct Canvas<'a> {
    context: &'a Context,
    drawn_scene: &'a DrawnScene,
    targets: &'a Targets,
    /// The place of the number of samples.
    index: usize,
    is_first: bool,
}

/// Draws what of paths hardware draws; returns the bits of objects where that is virtual geometry.
fn draw_paths<'a>(
    encoder: &mut wgpu::CommandEncoder,
    canvas: Canvas<'a>,
    (sight, quality, paths): (Sight<'_>, Quality, Paths),
    lists: Option<&'a DeviceLists>,
    timer: &mut Timer,
    report: &mut Report,
) -> Result<Option<&'a TextureView>, GpuError> {
    let Canvas { context, drawn_scene: DrawnScene { resident, reflections, .. }, targets, index, is_first } = canvas;
    let Sight { scene, view, geometry, .. } = sight;
    if let Reflections::Mirrored(mirrors) = reflections {
        let clip_from_world = clip_from_world(scene, view, view.rays().perspective);
        let what = (scene, view, quality);
        mirrors.draw(encoder, context, resident, what, clip_from_world, targets, timer, report)?;
    }
    if let Some(lists) = lists {
        lists.draw(encoder, context, resident, (paths, quality), targets, timer)?;
        return Ok(Some(&lists.of_objects));
    }
    let (Some(Geometry::OnDevice(found)), Reflections::Projected(Some(on_device))) = (geometry, reflections) else {
        return Ok(None);
    };
    let Found { reflectors, tables } = found;
    // At order 0 nothing is reflected.
    if targets.drawn.is_empty() {
        return Ok(None);
    }
    if is_first {
        tables.find(encoder, context, resident, reflectors, timer);
    }
    tables.draw(encoder, context, resident, (reflectors, index), targets, timer);
    Ok(Some(&on_device.of_objects))
}

/// The bands of a picture, of so many rows each, and a record for each, made from the picture's.
fn bands_of(of_picture: &Frame, rows: u32, samples: u32) -> (Vec<Band>, Vec<u8>) {
    let (mut bands, mut records) = (Vec::new(), Vec::new());
    for first_row in (0..of_picture.height).step_by(rows as usize) {
        let rows = rows.min(of_picture.height - first_row);
        let cells = cells_of(of_picture.width, rows, samples);
        bands.push(Band { record: records.len() as u32, cells, rows });
        records.extend_from_slice(bytemuck::bytes_of(&Frame { first_row, cells, ..*of_picture }));
        records.resize(records.len().next_multiple_of(FRAME_STRIDE as usize), 0);
    }
    (bands, records)
}

/// Columns and rows of cells of so many pixels.
fn cells_of(width: u32, rows: u32, samples: u32) -> [u32; 2] {
    [width, rows].map(|count| count.div_ceil(cell_side(samples)))
}

/// Rows of a picture that are drawn at a time: whole tiles, whose tables fit into a binding, and about as many in every
/// band.
fn rows_at_once(view: &View, samples: u32, paths: Paths) -> u32 {
    let unit = tile_rows(samples);
    let units = view.height.div_ceil(unit);
    let bytes = hit_bytes(cells_of(view.width, unit, samples), paths);
    let of_table = (HIT_BYTES_AT_ONCE / bytes) as u32;
    let of_pixels = PIXELS_AT_ONCE / (view.width * unit);
    let of_tiles = TILES_AT_ONCE / view.width.div_ceil(unit);
    let most = of_table.min(of_pixels).min(of_tiles).max(units.div_ceil(MAX_BANDS));
    units.div_ceil(units.div_ceil(most)) * unit
}

fn frame_record(scene: &Scene, view: &View, quality: Quality, drawn_scene: &DrawnScene) -> Frame {
    let DrawnScene { resident, reflections, .. } = drawn_scene;
    let rays = view.rays();
    let mut maps = resident.pictures.places.maps;
    // The place of the light on surfaces.
    maps[2][3] = resident.triangle_count;
    Frame {
        clip_from_world: clip_from_world(scene, view, rays.perspective).to_cols_array_2d(),
        origin: rays.origin.to_array(),
        flags: bits(&[
            (frame_flags::PERSPECTIVE, rays.perspective),
            // As on the processor.
            (frame_flags::APART, matches!(reflections, Reflections::Mirrored(_))),
        ]),
        direction: rays.direction.to_array(),
        order: quality.order,
        right: rays.right.to_array(),
        width: view.width,
        down: rays.down.to_array(),
        height: view.height,
        light_count: resident.light_count,
        root: resident.root,
        first_row: 0,
        extent: scene.bounds.diagonal(),
        cells: [0; 2],
        tiled_events: 0,
        followed: 0,
        sample_place: [0.5; 2],
        sample_side: 1.0,
        sun_count: resident.sun_count,
        maps,
        reductions: resident.pictures.places.reductions,
    }
}

/// Depth in clip space is reversed: 1 at the near plane, and 0 infinitely far away (perspective) or behind the scene.
fn clip_from_world(scene: &Scene, view: &View, is_perspective: bool) -> Mat4 {
    let pixel_size = view.pixel_size();
    let view_from_world = Mat4::from(view.world_from_view.inverse());
    let across = 2.0 / (pixel_size * view.width as f32);
    let along = 2.0 / (pixel_size * view.height as f32);
    let (depth, last) = match is_perspective {
        true => (Vec4::new(0.0, 0.0, 0.0, view.near), Vec4::new(0.0, 0.0, -1.0, 0.0)),
        false => {
            let forward = -Vec3::from(view.world_from_view.matrix3.z_axis);
            let middle = (scene.bounds.center() - view.eye()).dot(forward);
            let far = (middle + scene.bounds.diagonal()).max(view.near * 2.0);
            let scale = 1.0 / (far - view.near);
            (Vec4::new(0.0, 0.0, scale, far * scale), Vec4::W)
        }
    };
    let rows = [Vec4::X * across, Vec4::Y * along, depth, last];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose() * view_from_world
}
