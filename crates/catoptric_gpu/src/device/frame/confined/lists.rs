//! Virtual geometry of paths: found by the processor, drawn by hardware where the path before shows the object of the
//! last event.

use super::records::{MOST_PATHS, PathRecords};
use crate::device::context::Context;
use crate::device::frame::paths::Paths;
use crate::device::frame::targets::Targets;
use crate::device::frame::timer::Timer;
use crate::device::scene::{DeviceScene, Upload};
use crate::error::GpuError;
use crate::layout::{ListCorner, PathList, bits, hit_flags};
use crate::tables::onward_bits;
use catoptric::methods::path_lists::PathLists;
use catoptric::methods::{Quality, Report};
use catoptric::raster::{BLOCK, BlockMask, Branch, DrawList};
use catoptric::scene::{PicturePoint, Scene, View};
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BufferUsages, TextureView};

/// The corners of triangles that are their own source.
const WHOLE: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];

/// Numbers of choices of blocks have 16 bits. What is seen beyond that many is left to tiles.
const CHOICES: u32 = 1 << 16;

/// The geometry of one path.
struct OfPath {
    record: PathList,
    /// Events of the path, and their kinds: a bit each, set where light is refracted.
    events: u32,
    kinds: u32,
    /// Places of its corners: without holes, and with.
    parts: [Range<u32>; 2],
}

/// The geometry of a view on a device.
pub(crate) struct DeviceLists {
    /// By the numbers of the paths, from 1.
    paths: Vec<OfPath>,
    corners: Option<wgpu::Buffer>,
    /// For each object bits of hits and a choice of blocks, and these choices, four a texel.
    pub(crate) of_objects: TextureView,
}

impl DeviceLists {
    /// Loads geometry. Paths that have no number are left out, and followed otherwise.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        view: &View,
        lists: &PathLists,
        report: &mut Report,
    ) -> Result<Self, GpuError> {
        let all = &lists.lists[..lists.lists.len().min(MOST_PATHS)];
        let left_out = lists.lists.len() - all.len();
        report.add_fallback("lists_left_out", left_out as u64);
        let continued = Continued::new(scene, view, all, lists.has_rest || left_out > 0);
        let clip = Clip::new(scene, view, all);
        let mut paths: Vec<OfPath> = Vec::with_capacity(all.len());
        let mut corners: Vec<ListCorner> = Vec::new();
        for (number, list) in (1..).zip(all) {
            let stencil = list.stencil.unwrap_or_default();
            let parent = stencil.list.checked_sub(1).and_then(|parent| paths.get(parent as usize));
            let (events, kinds) = parent.map_or((0, 0), |parent| (parent.events, parent.kinds));
            let kind = u32::from(stencil.branch == Branch::Second);
            let record =
                PathList { object: stencil.group.wrapping_sub(1), parent: stencil.list, number, ..PathList::default() };
            let parts = [false, true].map(|holes| {
                let first = corners.len() as u32;
                clip.append(scene, list, holes, |group| continued.at(number, group), &mut corners);
                first..corners.len() as u32
            });
            paths.push(OfPath { record, events: events + 1, kinds: kinds | kind << events, parts });
        }
        report.counts.insert("lists", paths.len() as u64 + 1);
        report.counts.insert("triangles_drawn", corners.len() as u64 / 3);
        let mut upload = Upload { context, byte_count: 0 };
        let of_objects = upload.numbers("the objects' geometry", &continued.of_objects(scene))?;
        let contents: &[u8] = bytemuck::cast_slice(&corners);
        upload.check("the geometry of paths", contents.len() as u64, context.device.limits().max_buffer_size)?;
        let corners = (!corners.is_empty()).then(|| {
            let usage = BufferUsages::VERTEX;
            let descriptor = BufferInitDescriptor { label: Some("the geometry of paths"), contents, usage };
            context.device.create_buffer_init(&descriptor)
        });
        report.bytes.insert("gpu_lists", contents.len() as u64);
        context.check()?;
        Ok(Self { paths, corners, of_objects })
    }

    /// Draws the geometry of all paths whose hits have a table.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        context: &Context,
        resident: &DeviceScene,
        (paths, quality): (Paths, Quality),
        targets: &Targets,
        timer: &mut Timer,
    ) -> Result<(), GpuError> {
        let Context { device, pipelines, .. } = context;
        let records = PathRecords::new(device, self.paths.iter().map(|path| path.record));
        let index = usize::from(quality.samples > 1);
        for (place, (events, kinds)) in paths.all().enumerate() {
            let before = match events {
                1 => &targets.ids,
                // By the same kinds but for the last.
                _ => {
                    let parent = (events - 1, kinds & !(1 << (events - 1)));
                    let Some(place) = paths.all().position(|path| path == parent) else { continue };
                    &targets.drawn[place]
                }
            };
            let group = pipelines.lists.group(device, index, records.binding(), None, before);
            // Every sample is on one path of these kinds: all of them share the depth.
            let mut pass = targets.begin(encoder, &targets.drawn[place], timer.render("lists"));
            let Some(corners) = &self.corners else { continue };
            pass.set_bind_group(0, &resident.scene, &[0]);
            pass.set_bind_group(1, &resident.order, &[]);
            pass.set_vertex_buffer(0, corners.slice(..));
            for (part, has_holes) in [false, true].into_iter().enumerate() {
                let of_kinds = |path: &OfPath| (path.events, path.kinds) == (events, kinds);
                let drawn = self.paths.iter().enumerate().filter(|(_, path)| of_kinds(path));
                let drawn = drawn.filter(|(_, path)| !path.parts[part].is_empty());
                for (count, (place, path)) in drawn.enumerate() {
                    if count == 0 {
                        pass.set_pipeline(&pipelines.lists.get(device, index, has_holes));
                    }
                    pass.set_bind_group(2, &group, &[PathRecords::offset(place)]);
                    pass.draw(path.parts[part].clone(), 0..1);
                }
            }
        }
        context.check()
    }
}

/// Where geometry goes on.
struct Continued {
    /// The number of a path, the group of its triangles, and the kind.
    known: HashSet<(u32, u32, Branch)>,
    /// False if what no geometry goes on from shows the environment.
    has_rest: bool,
    /// The groups of bumpy surfaces, which were taken for smooth ones: tiles follow their rays.
    bumpy: HashSet<u32>,
    /// By the number of a path and a group, the blocks where some geometry leaves out what goes on from there, and the
    /// number of this choice.
    left_out: BTreeMap<(u32, u32), (u32, BlockMask)>,
    /// The length of a choice.
    words: usize,
}

impl Continued {
    fn new(scene: &Scene, view: &View, lists: &[DrawList], has_rest: bool) -> Self {
        let stencils = lists.iter().filter_map(|list| list.stencil);
        let known = stencils.map(|stencil| (stencil.list, stencil.group, stencil.branch)).collect();
        let objects = 0..scene.objects.len() as u32;
        let bumpy =
            objects.filter(|object| scene.material_of(*object).turning_map().is_some()).map(|object| object + 1);
        let mut left_out: BTreeMap<(u32, u32), (u32, BlockMask)> = BTreeMap::new();
        for list in lists.iter().filter(|list| !list.holes.is_empty()) {
            let Some(stencil) = list.stencil else { continue };
            left_out.entry((stencil.list, stencil.group)).or_default().1.add(&list.holes);
        }
        // As `BlockMask::words`, in halves.
        let blocks = [view.width, view.height].map(|side| (side as usize).div_ceil(BLOCK));
        let words = (2 * blocks[0].div_ceil(64) * blocks[1]).max(1);
        let first = scene.objects.len().div_ceil(words).max(1) as u32;
        for (number, (choice, _)) in (first..).zip(left_out.values_mut()) {
            *choice = number;
        }
        Self { known, has_rest, bumpy: bumpy.collect(), left_out, words }
    }

    /// For each object the bits of hits and the choice of blocks, and then these choices.
    fn of_objects(&self, scene: &Scene) -> Vec<u32> {
        let of_object = |object: u32| {
            let (bits, choice) = self.at(0, object + 1);
            bits | choice
        };
        let mut numbers: Vec<u32> = (0..scene.objects.len() as u32).map(of_object).collect();
        for (choice, blocks) in self.left_out.values().filter(|(choice, _)| *choice < CHOICES) {
            numbers.resize(*choice as usize * self.words, 0);
            numbers.extend(blocks.words().iter().flat_map(|word| [*word as u32, (word >> 32) as u32]));
        }
        numbers
    }

    /// The bits of hits on triangles of a group on a path, and the choice of blocks where they do not hold, or 0.
    fn at(&self, path: u32, group: u32) -> (u32, u32) {
        match self.left_out.get(&(path, group)) {
            Some((choice, _)) if *choice >= CHOICES => (0, 0),
            Some((choice, _)) => (self.bits(path, group), *choice),
            None => (self.bits(path, group), 0),
        }
    }

    /// The bits of hits on triangles of a group on a path.
    fn bits(&self, path: u32, group: u32) -> u32 {
        let is_known = |branch| !self.has_rest || self.known.contains(&(path, group, branch));
        let goes_on = |branch| !self.bumpy.contains(&group) && is_known(branch);
        bits(&[
            (hit_flags::HIT_LIST_REFLECTS, goes_on(Branch::First)),
            (hit_flags::HIT_LIST_REFRACTS, goes_on(Branch::Second)),
        ])
    }
}

/// From picture points to clip space.
struct Clip {
    size: [f32; 2],
    near: f32,
    /// A depth behind everything, in orthographic views; `None` in perspective ones.
    far: Option<f32>,
}

impl Clip {
    fn new(scene: &Scene, view: &View, lists: &[DrawList]) -> Self {
        let (size, near) = ([view.width as f32, view.height as f32], view.near);
        let far = (!view.rays().perspective).then(|| {
            let depths = lists.iter().flat_map(|list| &list.vertices).map(|vertex| vertex.depth);
            let farthest = depths.filter(|depth| depth.is_finite()).fold(near, f32::max);
            farthest + scene.bounds.diagonal().max(near)
        });
        Self { size, near, far }
    }

    fn position(&self, point: &PicturePoint) -> [f32; 4] {
        let PicturePoint { xy, w, depth } = *point;
        let z = match self.far {
            None => self.near,
            Some(far) => (far - depth) / (far - self.near),
        };
        [2.0 * xy.x / self.size[0] - w, w - 2.0 * xy.y / self.size[1], z, w]
    }

    /// Appends the triangles of a list with holes or those without.
    fn append(
        &self,
        scene: &Scene,
        list: &DrawList,
        holes: bool,
        continued: impl Fn(u32) -> (u32, u32),
        corners: &mut Vec<ListCorner>,
    ) {
        let mut last = (u32::MAX, (0, 0));
        for (index, triangle) in list.triangles.iter().enumerate().filter(|(_, one)| one.alpha_tested == holes) {
            let vertices = triangle.vertices.map(|vertex| list.vertices.get(vertex as usize));
            let [Some(a), Some(b), Some(c)] = vertices else { continue };
            let positions = [a, b, c].map(|vertex| self.position(vertex));
            if triangle.source as usize >= scene.triangles.len() {
                continue;
            }
            if !positions.as_flattened().iter().all(|value| value.is_finite()) {
                continue;
            }
            if triangle.group != last.0 {
                last = (triangle.group, continued(triangle.group));
            }
            let (bits, blocks) = last.1;
            let hit = (triangle.source + 1) | onward_bits(scene, triangle.source, false) | bits;
            let places = list.corners.get(index).map_or(WHOLE, |places| places.map(|place| place.to_array()));
            let corner = |(position, at)| ListCorner { position, at, hit, blocks };
            corners.extend(positions.into_iter().zip(places).map(corner));
        }
    }
}
