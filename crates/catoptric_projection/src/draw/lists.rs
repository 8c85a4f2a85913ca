//! The rasteriser's lists (layers, stencils and groups) from the geometry of paths.

use catoptric_core::scene::{PicturePoint, Role, Scene};
use catoptric_engine::method::Job;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::raster::{BlockMask, Branch, DrawList, DrawTriangle, Stencil, scene_draw_list};
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};

/// The corners of a triangle that is its own source.
const WHOLE: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

/// Geometry that appears at the end of one specular path: pieces of scene triangles at the places where they appear.
///
/// Geometry of one path may come in several parts, for instance one a focal index.
#[derive(Clone, Debug, Default)]
pub struct PathGeometry {
    /// The path, of at least one bounce. Paths that pass through anything but a lens are not drawn.
    pub path: SpecularPath,
    /// Appearances of scene points: the picture points of the places on their view rays that are the path's length
    /// away.
    ///
    /// In a perspective view `w` and `depth` are the path's length times the cosine between view ray and view axis
    /// (for a flat mirror then all in between is interpolated exactly), and in an orthographic one `w` is 1 and `depth`
    /// is the path's length.
    pub vertices: Vec<PicturePoint>,
    /// A signed distance for every vertex: geometry where it is below 0 is clipped. Empty: nothing is clipped.
    pub clip_distances: Vec<f32>,
    /// Pieces of the scene's triangles: `source` is the scene's triangle. Group, patch and alpha test are filled in
    /// while drawing.
    pub triangles: Vec<DrawTriangle>,
    /// The weights of the source's second and third vertex at the corners of every piece. Empty: all pieces are whole
    /// triangles.
    pub corners: Vec<[Vec2; 3]>,
    /// Blocks of the picture where something else is to draw what the path shows.
    pub holes: BlockMask,
}

/// The picture that is seen beyond reflectors and lenses at which no list goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum EndsOfPaths {
    /// The environment.
    Environment,
    /// The picture of something else than lists; in these blocks also beyond lenses that are seen directly.
    GoOn(BlockMask),
}

/// The scene as it is seen directly, then one list a path: shorter paths first, each after the path it goes on from.
///
/// The group of a reflector's or lens's triangles is its object, plus 1. It is 0 for all others, those that have
/// environment maps among them, and where the highest order is reached: there paths end. If only lists draw, every
/// visible lens has a list for its transmitted paths, be it empty, so that light divides there in the rasteriser; else
/// lenses have one if they have a list for their reflected paths.
pub(super) fn draw_lists(
    job: &Job<'_>,
    paths: Vec<PathGeometry>,
    maps: Option<&ReflectorMaps>,
    ends: &EndsOfPaths,
) -> Vec<DrawList> {
    let (scene, order) = (job.scene, job.quality.order);
    let seen = scene_draw_list(scene, job.view, |object| Some(group(scene, maps, object, order > 0)));
    let seen_lenses = lenses(scene, &seen);
    let mut lists = vec![seen];
    lists.extend(lists_of_paths(job, paths, maps, ends, &seen_lenses));
    lists
}

/// Ends the paths of lists at lenses at which no list goes on, or not everywhere: rays follow them there.
pub(super) fn leave_lenses_to_rays(scene: &Scene, lists: &mut [DrawList]) {
    let surfaces = |has_holes: bool| {
        let lists = lists.iter().filter(move |list| list.holes.is_empty() != has_holes);
        lists.filter_map(|list| list.stencil).map(|stencil| (stencil.list, stencil.group))
    };
    let mut continued: BTreeSet<(u32, u32)> = surfaces(false).collect();
    for surface in surfaces(true) {
        continued.remove(&surface);
    }
    for (number, list) in (0..).zip(lists) {
        for triangle in &mut list.triangles {
            let is_lens = || {
                let object = scene.triangle_objects.get(triangle.source as usize);
                object.is_some_and(|object| scene.role_of(*object) == Role::Lens)
            };
            if triangle.group != 0 && !continued.contains(&(number, triangle.group)) && is_lens() {
                triangle.group = 0;
            }
        }
    }
}

/// The object plus 1 of reflectors and lenses at which paths go on, or 0.
fn group(scene: &Scene, maps: Option<&ReflectorMaps>, object: u32, goes_on: bool) -> u32 {
    let mapped = maps.is_some_and(|maps| maps.has(object));
    if goes_on && !mapped && scene.role_of(object).is_specular() { object + 1 } else { 0 }
}

/// The lists of [`draw_lists`] without the first, the direct view.
pub(super) fn lists_of_paths(
    job: &Job<'_>,
    paths: Vec<PathGeometry>,
    maps: Option<&ReflectorMaps>,
    ends: &EndsOfPaths,
    seen_lenses: &BTreeSet<u32>,
) -> Vec<DrawList> {
    let (scene, order) = (job.scene, job.quality.order as usize);
    // Sorted by length, so that parents come first.
    let mut waiting: BTreeMap<(usize, SpecularPath), Vec<PathGeometry>> = BTreeMap::new();
    for geometry in paths {
        let bounces = &geometry.path.bounces;
        if bounces.is_empty() || bounces.len() > order || !is_possible(scene, &geometry.path) {
            continue;
        }
        // Paths whose parents show nothing themselves still need them to be drawn in.
        for length in 1..bounces.len() {
            waiting.entry((length, SpecularPath { bounces: bounces[..length].to_vec() })).or_default();
        }
        waiting.entry((bounces.len(), geometry.path.clone())).or_default().push(geometry);
    }
    let mut lists = Vec::new();
    let add_passing =
        |waiting: &mut BTreeMap<(usize, SpecularPath), Vec<PathGeometry>>, path: &SpecularPath, object| {
            let length = path.bounces.len() + 1;
            let reflects = || waiting.contains_key(&(length, going_on(path, object, BounceKind::Reflect)));
            if *ends == EndsOfPaths::Environment || reflects() {
                waiting.entry((length, going_on(path, object, BounceKind::Transmit))).or_default();
            }
        };
    for &object in seen_lenses {
        add_passing(&mut waiting, &SpecularPath::default(), object);
    }
    let mut list_of_path: BTreeMap<SpecularPath, u32> = BTreeMap::new();
    while let Some(((length, path), parts)) = waiting.pop_first() {
        let parent = path.parent().and_then(|parent| list_of_path.get(&parent).copied()).unwrap_or(0);
        let Some(last) = path.bounces.last() else { continue };
        let mut list = joined(parts);
        list.layer = length as u32;
        let in_pieces = !list.corners.is_empty();
        let branch = match last.kind {
            BounceKind::Reflect => Branch::First,
            BounceKind::Transmit => Branch::Second,
        };
        list.stencil = Some(Stencil { list: parent, group: last.object + 1, branch });
        if let (1, EndsOfPaths::GoOn(in_lenses)) = (length, ends)
            && scene.role_of(last.object) == Role::Lens
        {
            list.holes.add(in_lenses);
        }
        for triangle in &mut list.triangles {
            match scene.triangle_objects.get(triangle.source as usize) {
                Some(&object) => {
                    triangle.group = group(scene, maps, object, length < order);
                    triangle.alpha_tested = scene.is_alpha_tested(object);
                    // Pieces of one triangle are one surface, too.
                    let piece = if in_pieces { triangle.source + 1 } else { 0 };
                    triangle.patch = scene.patch_of_object(object).unwrap_or(piece);
                }
                // A triangle of no scene: not drawn.
                None => triangle.vertices = [u32::MAX; 3],
            }
        }
        for object in lenses(scene, &list) {
            add_passing(&mut waiting, &path, object);
        }
        lists.push(list);
        // The first list is the direct view.
        list_of_path.insert(path, lists.len() as u32);
    }
    lists
}

/// The lenses among a list's triangles at which paths go on.
fn lenses(scene: &Scene, list: &DrawList) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    let mut last = 0;
    for triangle in &list.triangles {
        if triangle.group != last && triangle.group != 0 {
            last = triangle.group;
            let object = last - 1;
            if scene.role_of(object) == Role::Lens {
                found.insert(object);
            }
        }
    }
    found
}

/// A path that goes on at an object.
fn going_on(path: &SpecularPath, object: u32, kind: BounceKind) -> SpecularPath {
    let mut path = path.clone();
    path.bounces.push(Bounce { object, kind });
    path
}

/// True if light can take a path: it is reflected by reflectors and lenses, and passes through lenses alone.
fn is_possible(scene: &Scene, path: &SpecularPath) -> bool {
    path.bounces.iter().all(|bounce| {
        let known = (bounce.object as usize) < scene.objects.len();
        known
            && match bounce.kind {
                BounceKind::Reflect => scene.role_of(bounce.object).is_specular(),
                BounceKind::Transmit => scene.role_of(bounce.object) == Role::Lens,
            }
    })
}

/// The parts of one path as one list.
fn joined(parts: Vec<PathGeometry>) -> DrawList {
    let any_clipped = parts.iter().any(|part| !part.clip_distances.is_empty());
    let any_pieces = parts.iter().any(|part| !part.corners.is_empty());
    let mut list = DrawList::default();
    for mut part in parts {
        list.holes.add(&part.holes);
        let first_vertex = list.vertices.len() as u32;
        for triangle in &mut part.triangles {
            triangle.vertices = triangle.vertices.map(|vertex| match (vertex as usize) < part.vertices.len() {
                true => vertex + first_vertex,
                false => u32::MAX,
            });
        }
        if list.triangles.is_empty() && list.vertices.is_empty() {
            (list.vertices, list.triangles) = (part.vertices, part.triangles);
            (list.clip_distances, list.corners) = (part.clip_distances, part.corners);
        } else {
            list.vertices.append(&mut part.vertices);
            list.triangles.append(&mut part.triangles);
            list.clip_distances.append(&mut part.clip_distances);
            list.corners.append(&mut part.corners);
        }
        // Parts that are not cut, or hold whole triangles, beside others.
        if any_clipped {
            list.clip_distances.resize(list.vertices.len(), 0.0);
        }
        if any_pieces {
            list.corners.resize(list.triangles.len(), WHOLE);
        }
    }
    list
}
