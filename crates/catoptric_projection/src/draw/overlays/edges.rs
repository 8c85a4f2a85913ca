//! The edges of moved triangles, where they show.

use super::shown::{PathEnd, ShownPixels};
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::{PicturePoint, Scene, View};
use catoptric_engine::method::overlay::paths::name_of;
use catoptric_engine::method::overlay::{Overlay, OverlayKind, OverlaySegment};
use catoptric_engine::raster::DrawList;
use glam::{IVec2, Vec2};
use std::collections::{BTreeMap, HashSet};

/// Vertices nearer to each other in the picture are the same: the rasteriser's grid.
const GRID_PX: f32 = 1.0 / 256.0;

/// A triangle's edge is seen where a pixel so far beside it shows the triangle, in pixels.
const BESIDE_PX: f32 = 0.75;

/// The edges of the triangles of lists in layers above the first where they show; lists as they were drawn.
///
/// # Errors
/// [`Cancelled`].
pub(crate) fn virtual_triangles(
    scene: &Scene,
    view: &View,
    lists: &[DrawList],
    shown: &ShownPixels,
    progress: &dyn Progress,
) -> Result<Overlay, Cancelled> {
    let mut overlay = Overlay::new(OverlayKind::VirtualTriangles, shown.size);
    let stage = Stage::begin(progress, "drawing edges", shown.ends.len())?;
    // Triangles that no pixel's centre shows are smaller than a pixel, or hidden.
    let mut triangles: Vec<HashSet<u32>> = vec![HashSet::new(); shown.ends.len()];
    for (end, triangle) in shown.end_of_pixels.iter().zip(&shown.triangle_of_pixels) {
        if let Some(end) = end {
            triangles[*end as usize].insert(*triangle);
        }
    }
    for (number, PathEnd { path, list }) in shown.ends.iter().enumerate() {
        stage.advance(1)?;
        let list = list.and_then(|list| lists.get(list as usize)).filter(|list| list.layer > 0);
        let Some(list) = list else { continue };
        let group = overlay.group(name_of(scene, path));
        for (ends, sources) in edges_of(list, view, &triangles[number]) {
            let is_seen = |place: Vec2| shows(shown, number as u32, &sources, place);
            for_each_seen_part(ends, shown.size, is_seen, |ends| overlay.add_segment(OverlaySegment { ends, group }));
            stage.check()?;
        }
    }
    Ok(overlay)
}

type Edges = Vec<([Vec2; 2], Vec<u32>)>;

/// The edges of a list's wanted triangles in pixels, each with the triangles of the scene beside it.
fn edges_of(list: &DrawList, view: &View, wanted: &HashSet<u32>) -> Edges {
    let on_grid = |place: Vec2| (place / GRID_PX).round().as_ivec2();
    let key = |[a, b]: [IVec2; 2]| if (a.x, a.y) <= (b.x, b.y) { [a.x, a.y, b.x, b.y] } else { [b.x, b.y, a.x, a.y] };
    let mut edges: BTreeMap<[i32; 4], ([Vec2; 2], Vec<u32>)> = BTreeMap::new();
    for triangle in list.triangles.iter().filter(|triangle| wanted.contains(&triangle.source)) {
        let corner = |vertex: u32| list.vertices.get(vertex as usize).copied();
        let [Some(a), Some(b), Some(c)] = triangle.vertices.map(corner) else { continue };
        for [a, b] in [[a, b], [b, c], [c, a]] {
            let Some(ends) = in_picture(a, b, view) else { continue };
            let (_, sources) = edges.entry(key(ends.map(on_grid))).or_insert_with(|| (ends, Vec::new()));
            if !sources.contains(&triangle.source) {
                sources.push(triangle.source);
            }
        }
    }
    edges.into_values().collect()
}

/// The part of an edge in front of the near plane and in the picture, in pixels.
fn in_picture(a: PicturePoint, b: PicturePoint, view: &View) -> Option<[Vec2; 2]> {
    let at = |share: f32| PicturePoint {
        xy: a.xy.lerp(b.xy, share),
        w: a.w + (b.w - a.w) * share,
        depth: a.depth + (b.depth - a.depth) * share,
    };
    let (mut from, mut to) = (0.0, 1.0);
    let crossing = (view.near - a.depth) / (b.depth - a.depth);
    match (a.depth >= view.near, b.depth >= view.near) {
        (true, true) => {}
        (false, false) => return None,
        (true, false) => to = crossing,
        (false, true) => from = crossing,
    }
    let [a, b] = [at(from), at(to)].map(|point| point.xy / point.w);
    let (mut from, mut to) = (0.0f32, 1.0f32);
    for (axis, length) in [view.width, view.height].into_iter().enumerate() {
        let (start, step) = (a[axis], b[axis] - a[axis]);
        if step == 0.0 {
            if !(0.0..=length as f32).contains(&start) {
                return None;
            }
            continue;
        }
        let [one, other] = [-start / step, (length as f32 - start) / step];
        (from, to) = (from.max(one.min(other)), to.min(one.max(other)));
    }
    let ends = [a.lerp(b, from), a.lerp(b, to)];
    (from < to && ends[0].is_finite() && ends[1].is_finite()).then_some(ends)
}

/// True if a pixel shows one of some triangles at an end of paths.
fn shows(shown: &ShownPixels, end: u32, sources: &[u32], place: Vec2) -> bool {
    let [width, height] = shown.size;
    let is_inside = place.cmpge(Vec2::ZERO).all() && place.x < width as f32 && place.y < height as f32;
    let pixel = place.y as usize * width as usize + place.x as usize;
    is_inside && shown.end_of_pixels[pixel] == Some(end) && sources.contains(&shown.triangle_of_pixels[pixel])
}

/// Calls `part` with the parts of a line beside which something is seen, in steps of about a pixel.
fn for_each_seen_part(
    [a, b]: [Vec2; 2],
    [width, height]: [u32; 2],
    is_seen: impl Fn(Vec2) -> bool,
    mut part: impl FnMut([Vec2; 2]),
) {
    // The part lies in the picture.
    let steps = (a.distance(b).ceil() as u32).clamp(1, width + height);
    let beside = (b - a).normalize_or_zero().perp() * BESIDE_PX;
    let mut start = None;
    for step in 0..=steps {
        let place = a.lerp(b, (step as f32 + 0.5) / steps as f32);
        let goes_on = step < steps && [Vec2::ZERO, beside, -beside].into_iter().any(|by| is_seen(place + by));
        match (start, goes_on) {
            (None, true) => start = Some(step),
            (Some(from), false) => {
                part([from, step].map(|step| a.lerp(b, step as f32 / steps as f32)));
                start = None;
            }
            _ => {}
        }
    }
}
