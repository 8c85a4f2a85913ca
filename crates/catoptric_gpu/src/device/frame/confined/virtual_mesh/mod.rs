//! Virtual geometry of smooth reflectors, found on the device: where vertices appear, divided until it may be drawn
//! straight, and drawn by hardware where its reflector is seen.

mod reflectors;

pub(crate) use reflectors::Search;

use super::records::PathRecords;
use crate::device::context::Context;
use crate::device::frame::passes::begin;
use crate::device::frame::targets::Targets;
use crate::device::frame::timer::Timer;
use crate::device::pipelines::{DEPTH_FORMAT, MAP_FORMAT, PICTURE_FORMAT, Step, group};
use crate::device::scene::{DeviceScene, Upload};
use crate::error::GpuError;
use crate::layout::{
    Appearance, GRID_SIDE, ListCorner, PICTURE_SIDE, PathList, Piece, Point, Reflection, START_RAY_BYTES,
};
use crate::layout::{bits, hit_flags};
use bytemuck::{Pod, Zeroable};
use catoptric::scene::{Scene, View};
use glam::Mat4;
use reflectors::{Reflector, reflectors_of, seen_in};
use std::num::NonZeroU64;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, LoadOp, Operations, StoreOp, TextureUsages, TextureView};

/// Rounds of division: in the last one nothing is divided any more. As `MOST_ROUNDS` in `virtual_mesh/divide.wgsl`.
const ROUNDS: usize = 14;
/// Threads of a workgroup.
const THREADS: u32 = 64;
/// The most groups of a dispatch along a dimension.
const MOST_GROUPS: u32 = 32_768;
/// Room for pieces, beside one for each triangle of the scene: so many, and one for so many pixels of the picture, but
/// no more than this. Bounds on memory; chosen, not measured.
const LEAST_PIECES: u32 = 1 << 16;
const PIXELS_A_PIECE: u32 = 2;
const MOST_PIECES: u32 = 1 << 20;
/// Appearances of a point in reflectors that are not convex, on the average. A bound on memory; chosen, not measured.
const APPEARANCES_A_POINT: u32 = 3;
/// Vertices times reflectors of the scenes whose virtual geometry is found on the device, and the searches for one that
/// may appear several times. Bounds on time; chosen, not measured.
const MOST_SEARCHES: usize = 1 << 20;
const SEARCHES_A_POINT: usize = 4;
/// Scenes of more reflectors are left to the processor. Chosen, not measured.
const MOST_REFLECTORS: usize = 64;

/// Words before the arguments of drawing, and those that are counted in a picture: see `wgsl/virtual_mesh/work.wgsl`.
const COUNTERS: u64 = 16;
const COUNTED: u64 = 6;
/// The word that counts appearances.
const APPEARANCES: u64 = 10;

/// Counts of what was found in a picture, as `virtual_mesh/work.wgsl` has them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct VirtualCounts {
    /// Triangles to be drawn.
    pub(crate) drawn: u32,
    /// Points that were projected.
    pub(crate) projected: u32,
    /// Pieces that were left to tiles because they were to be divided further.
    pub(crate) unfinished: u32,
    /// Reflectors that were, because there was no room for what they show.
    pub(crate) left_reflectors: u32,
}

/// Tables of one size, for one reflector after the other.
#[derive(Debug)]
pub(crate) struct VirtualTables {
    room: Room,
    /// A record for each reflector.
    records: Buffer,
    work: Buffer,
    dispatch: Buffer,
    arguments: Buffer,
    points: Buffer,
    appearances: Buffer,
    corners: Buffer,
    picture: TextureView,
    depth: TextureView,
    /// Explosion maps of the near and of the far sphere; of one texel where there are none.
    maps: [TextureView; 2],
    drawing: BindGroup,
    /// The two of them change places from round to round.
    working: [BindGroup; 2],
}

/// Room in tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Room {
    /// Texels along a side of explosion maps.
    map_size: Option<u32>,
    vertices: u32,
    triangles: u32,
    /// For points and their appearances.
    points: u32,
    appearances: u32,
    /// Pieces that are divided, and triangles that are drawn.
    pieces: u32,
    drawn: u32,
}

impl Room {
    /// For the vertices and triangles of a scene in a picture with so many pixels; `None` where devices hold no tables
    /// of that size.
    fn new(context: &Context, on_device: &OnDevice, [vertices, triangles]: [u32; 2], pixels: u32) -> Option<Self> {
        let OnDevice { reflectors, search, are_convex, .. } = on_device;
        let limits = context.device.limits();
        let most_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most = |bytes: usize| u32::try_from(most_bytes / bytes as u64).unwrap_or(u32::MAX);
        let of_picture = (LEAST_PIECES + pixels / PIXELS_A_PIECE).min(MOST_PIECES);
        let pieces = triangles.checked_add(of_picture)?.min(most(size_of::<Piece>()));
        let points = vertices.checked_add(pieces)?.min(most(size_of::<Point>()));
        let times = if *are_convex { 1 } else { APPEARANCES_A_POINT };
        let appearances = points.saturating_mul(times).min(most(size_of::<Appearance>()));
        let drawn = triangles.saturating_mul(reflectors.len() as u32).saturating_add(of_picture);
        let drawn = drawn.min(most(3 * size_of::<ListCorner>()));
        let room = Self { map_size: search.map_size, vertices, triangles, points, appearances, pieces, drawn };
        // Where reflectors show more there is nothing to begin with.
        (points > vertices && pieces > triangles && appearances > vertices).then_some(room)
    }

    fn point_bytes(self) -> u64 {
        u64::from(self.points) * size_of::<Point>() as u64
    }

    fn appearance_bytes(self) -> u64 {
        u64::from(self.appearances) * size_of::<Appearance>() as u64
    }

    fn corner_bytes(self) -> u64 {
        u64::from(self.drawn) * 3 * size_of::<ListCorner>() as u64
    }

    fn piece_bytes(self) -> u64 {
        u64::from(self.pieces) * size_of::<Piece>() as u64
    }
}

/// The reflectors of a scene whose virtual geometry is found on the device.
#[derive(Debug)]
pub(crate) struct OnDevice {
    /// All its reflectors.
    reflectors: Vec<Reflector>,
    /// Every point appears once in each.
    are_convex: bool,
    search: Search,
    /// The bits of hits on objects that say whose virtual geometry is drawn, four a texel.
    pub(crate) of_objects: TextureView,
}

impl OnDevice {
    /// For a scene; `None` where reflectors show points several times, or not sharply.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        resident: &DeviceScene,
        search: Search,
    ) -> Result<Option<Self>, GpuError> {
        let found = reflectors_of(scene, &resident.tables).filter(|found| found.len() <= MOST_REFLECTORS);
        let Some(reflectors) = found else { return Ok(None) };
        let are_convex = reflectors.iter().all(|reflector| reflector.is_convex);
        // Finding what each of many reflectors shows of a large scene takes longer than the processor's way, which has
        // a limit.
        let most = if are_convex { MOST_SEARCHES } else { MOST_SEARCHES / SEARCHES_A_POINT };
        if scene.positions.len() * reflectors.len() > most {
            return Ok(None);
        }
        // Maps hold one record in each direction.
        if search.map_size.is_some() && !are_convex {
            return Ok(None);
        }
        let of_object =
            |object: u32| bits(&[(hit_flags::HIT_LIST_REFLECTS, reflectors.iter().any(|one| one.object == object))]);
        let objects: Vec<u32> = (0..scene.objects.len() as u32).map(of_object).collect();
        let of_objects = Upload { context, byte_count: 0 }.numbers("reflectors with virtual geometry", &objects)?;
        Ok(Some(Self { reflectors, are_convex, search, of_objects }))
    }

    /// The reflectors in a view; `None` where the processor finds what they show.
    pub(crate) fn seen_in(&self, scene: &Scene, view: &View, clip_from_world: &Mat4) -> Option<Vec<Reflection>> {
        seen_in(scene, view, &self.reflectors, &self.search, clip_from_world)
    }
}

impl VirtualTables {
    /// The tables of the last picture if they serve, or new ones; `None` where devices hold no tables of the size.
    pub(crate) fn get(
        context: &Context,
        resident: &DeviceScene,
        last: &Mutex<Option<Arc<Self>>>,
        on_device: &OnDevice,
        [width, height]: [u32; 2],
    ) -> Result<Option<Arc<Self>>, GpuError> {
        let of_scene = [resident.tables.vertices.len() as u32, resident.triangle_count];
        let Some(room) = Room::new(context, on_device, of_scene, width * height) else { return Ok(None) };
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(tables) = last.as_ref().filter(|tables| tables.room == room) {
            return Ok(Some(tables.clone()));
        }
        *last = None;
        let tables = Arc::new(Self::new(context, room));
        context.check()?;
        Ok(Some(last.insert(tables).clone()))
    }

    fn new(context: &Context, room: Room) -> Self {
        let device = &context.device;
        let buffer = |label, size, usage| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            device.create_buffer(&descriptor)
        };
        let storage = BufferUsages::STORAGE;
        let rays = buffer("rays of a reflector", u64::from(GRID_SIDE * GRID_SIDE) * START_RAY_BYTES, storage);
        let read = storage | BufferUsages::COPY_SRC;
        let appearances = buffer("appearances", room.appearance_bytes(), read);
        let points = buffer("points", room.point_bytes(), read);
        let pieces = [0, 1].map(|_| buffer("pieces of triangles", room.piece_bytes(), storage));
        let corners = buffer("virtual geometry", room.corner_bytes(), storage | BufferUsages::VERTEX);
        let words = COUNTERS + 4 * MOST_REFLECTORS as u64;
        let copied = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let work = buffer("work of division", words * 4, storage | copied);
        let indirect = BufferUsages::INDIRECT | BufferUsages::COPY_DST;
        let dispatch = buffer("groups of division", 12, indirect);
        let arguments = buffer("virtual geometry's arguments", 16 * MOST_REFLECTORS as u64, indirect);
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let records = buffer("reflectors", PathRecords::offset(MOST_REFLECTORS).into(), uniform);
        let target = |label, format, side, more| {
            let descriptor = wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT | more,
                view_formats: &[],
            };
            device.create_texture(&descriptor).create_view(&Default::default())
        };
        let read = TextureUsages::TEXTURE_BINDING;
        let picture = target("a reflector's picture", PICTURE_FORMAT, PICTURE_SIDE, read);
        let depth = target("its depth", DEPTH_FORMAT, PICTURE_SIDE, TextureUsages::empty());
        let maps = [0, 1].map(|_| target("an explosion map", MAP_FORMAT, room.map_size.unwrap_or(1), read));
        let record = || {
            let size = NonZeroU64::new(size_of::<Reflection>() as u64);
            (0, BindingResource::Buffer(wgpu::BufferBinding { buffer: &records, offset: 0, size }))
        };
        let pipelines = &context.pipelines.virtual_mesh;
        let drawing = group(device, &pipelines.drawing, [record()]);
        let working = [0, 1].map(|first| {
            let [now, next] = [&pieces[first], &pieces[1 - first]];
            let buffers = [&rays, &appearances, now, next, &corners, &work, &points];
            let buffers = (2..8).chain([10]).zip(buffers.map(Buffer::as_entire_binding));
            let views = [(1, &picture), (8, &maps[0]), (9, &maps[1])];
            let views = views.map(|(binding, view)| (binding, BindingResource::TextureView(view)));
            let resources = [record()].into_iter().chain(views);
            group(device, &pipelines.working, resources.chain(buffers))
        });
        Self {
            points,
            appearances,
            room,
            records,
            work,
            dispatch,
            arguments,
            corners,
            picture,
            depth,
            maps,
            drawing,
            working,
        }
    }

    /// Finds the virtual geometry of reflectors in a view, whose record lies first in the scene's buffer.
    pub(crate) fn find(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        reflectors: &[Reflection],
        timer: &mut Timer,
    ) {
        encoder.clear_buffer(&self.work, 0, Some(COUNTERS * 4));
        if reflectors.is_empty() {
            return;
        }
        let Self { room, .. } = *self;
        let mut bytes = Vec::new();
        for reflector in reflectors {
            let room = Reflection {
                most_appearances: room.appearances,
                most_points: room.points,
                most_pieces: room.pieces,
                most_drawn: room.drawn,
                ..*reflector
            };
            bytes.extend_from_slice(bytemuck::bytes_of(&room));
            bytes.resize(bytes.len().next_multiple_of(PathRecords::offset(1) as usize), 0);
        }
        let descriptor =
            BufferInitDescriptor { label: Some("reflectors"), contents: &bytes, usage: BufferUsages::COPY_SRC };
        let staged = context.device.create_buffer_init(&descriptor);
        encoder.copy_buffer_to_buffer(&staged, 0, &self.records, 0, bytes.len() as u64);
        for (index, reflector) in reflectors.iter().enumerate() {
            self.find_one(encoder, context, resident, (index, reflector), timer);
        }
        let size = 16 * reflectors.len() as u64;
        encoder.copy_buffer_to_buffer(&self.work, COUNTERS * 4, &self.arguments, 0, size);
    }

    fn find_one(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (index, reflector): (usize, &Reflection),
        timer: &mut Timer,
    ) {
        let record = PathRecords::offset(index);
        self.draw_pictures(encoder, context, resident, (record, reflector), timer);
        let Room { vertices, triangles, map_size, .. } = self.room;
        let from_maps = map_size.is_some();
        let pipelines = &context.pipelines.virtual_mesh;
        let mut run = |encoder: &mut wgpu::CommandEncoder, turn: usize, steps: &[(Step, Option<u32>)]| {
            let mut pass = begin(encoder, timer.compute("virtual geometry"));
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(2, &self.working[turn % 2], &[record]);
            for &(step, threads) in steps {
                pass.set_pipeline(&pipelines.get(&context.device, resident.features, from_maps, step));
                match threads {
                    Some(threads) => {
                        let groups = threads.div_ceil(THREADS);
                        let across = groups.min(MOST_GROUPS);
                        pass.dispatch_workgroups(across, groups.div_ceil(across.max(1)), 1);
                    }
                    None => pass.dispatch_workgroups_indirect(&self.dispatch, 0),
                }
            }
        };
        let of_one = [Step::Rays, Step::Begin, Step::Vertices, Step::Pieces, Step::Arrange];
        let threads = [GRID_SIDE * GRID_SIDE, 1, vertices, triangles, 1];
        // The first pieces are the next ones of a round before the first.
        run(encoder, 1, &of_one.into_iter().zip(threads.map(Some)).collect::<Vec<_>>());
        for round in 0..ROUNDS {
            encoder.copy_buffer_to_buffer(&self.work, 0, &self.dispatch, 0, 12);
            run(encoder, round, &[(Step::Divide, None), (Step::Arrange, Some(1))]);
        }
        run(encoder, 0, &[(Step::End, Some(1))]);
    }

    /// The reflector's own picture, and its explosion maps.
    fn draw_pictures(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (record, reflector): (u32, &Reflection),
        timer: &mut Timer,
    ) {
        let pipelines = &context.pipelines.virtual_mesh;
        let mut targets = vec![(&self.picture, &pipelines.picture, Some(&self.depth))];
        if self.room.map_size.is_some() {
            targets.extend(self.maps.iter().zip(&pipelines.maps).map(|(map, pipeline)| (map, pipeline, None)));
        }
        for (view, pipeline, depth) in targets {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("a picture of a reflector"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations { load: LoadOp::Clear(wgpu::Color::TRANSPARENT), store: StoreOp::Store },
                })],
                depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                    stencil_ops: None,
                }),
                timestamp_writes: timer.render("virtual geometry"),
                ..Default::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(2, &self.drawing, &[record]);
            let [first, end] = reflector.own_triangles;
            pass.draw(first * 3..end * 3, 0..1);
        }
    }

    /// Draws what was found, where the reflectors are seen.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (reflectors, index): (&[Reflection], usize),
        targets: &Targets,
        timer: &mut Timer,
    ) {
        let Some(target) = targets.drawn.first() else { return };
        let Context { device, pipelines, .. } = context;
        let of_path = |reflector: &Reflection| PathList { object: reflector.object, parent: 0, number: 1, unused: 0 };
        let records = PathRecords::new(device, reflectors.iter().map(of_path));
        let group = pipelines.lists.group(device, index, records.binding(), None, &targets.ids);
        let mut pass = targets.begin(encoder, target, timer.render("lists"));
        pass.set_pipeline(&pipelines.lists.get(device, index, resident.features.has_holes()));
        pass.set_bind_group(0, &resident.scene, &[0]);
        pass.set_bind_group(1, &resident.order, &[]);
        pass.set_vertex_buffer(0, self.corners.slice(..));
        for place in 0..reflectors.len() {
            pass.set_bind_group(2, &group, &[PathRecords::offset(place)]);
            pass.draw_indirect(&self.arguments, 16 * place as u64);
        }
    }

    /// Where a scene's vertices appear in the one reflector that was looked at last.
    pub(crate) fn appearances(
        &self,
        context: &Context,
        reflector: &Reflection,
    ) -> Result<Vec<(u32, Appearance)>, GpuError> {
        let encoder = || context.device.create_command_encoder(&Default::default());
        let count: Vec<u32> = context.read_buffer(encoder(), &self.work, APPEARANCES * 4, 1)?;
        let count = count.into_iter().next().unwrap_or_default().min(self.room.appearances) as usize;
        let points: Vec<Point> = context.read_buffer(encoder(), &self.points, 0, self.room.vertices as usize)?;
        let appearances: Vec<Appearance> = match count {
            0 => Vec::new(),
            count => context.read_buffer(encoder(), &self.appearances, 0, count)?,
        };
        let mut all = Vec::new();
        let [first, end] = reflector.own_vertices;
        for (vertex, point) in (0..).zip(points) {
            let is_own = (first..end).contains(&vertex) && reflector.shows_itself == 0;
            let range = point.first as usize..point.first.saturating_add(point.count) as usize;
            let own = appearances.get(range).filter(|_| !is_own).unwrap_or_default();
            all.extend(own.iter().map(|appearance| (vertex, *appearance)));
        }
        Ok(all)
    }

    /// Where it is counted what is found in a picture: a buffer, an offset and a size in bytes.
    pub(crate) fn counts(&self) -> (&wgpu::Buffer, u64, u64) {
        (&self.work, COUNTED * 4, size_of::<VirtualCounts>() as u64)
    }

    /// Memory that they take on the device.
    pub(crate) fn byte_count(&self) -> u64 {
        self.room.point_bytes() + self.room.appearance_bytes() + self.room.corner_bytes() + 2 * self.room.piece_bytes()
    }
}
