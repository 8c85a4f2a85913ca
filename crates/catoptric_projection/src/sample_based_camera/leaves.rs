//! An overlay that shows which leaf draws the reflection in each pixel.

use super::cameras::LeafNumber;
use super::project::{CameraProjector, TOUCHING};
use super::settings::CameraKind;
use crate::draw::overlays::ShownPixels;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::Ray;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::overlay::{Overlay, OverlayKind, OverlaySegment};
use catoptric_engine::method::projector::SpecularPath;
use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};

/// The origin of a pixel's reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Drawn {
    /// The pixel shows nothing that reflects, or no ray of the map is near.
    #[default]
    Nothing,
    /// A leaf of the cameras of a path.
    Leaf { path: u32, leaf: LeafNumber },
    /// The path was left to tiles.
    Tiles,
}

/// An overlay of pixels by the kind of leaf that draws their reflection, and of the borders between leaves.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn overlay(
    projector: &CameraProjector<'_>,
    camera: CameraKind,
    (shown, drawn): (&ShownPixels, &HashSet<SpecularPath>),
    progress: &dyn Progress,
) -> Result<Overlay, Cancelled> {
    let stage = Stage::begin(progress, "building the hierarchy", 1)?;
    // Pinholes are found by the points that they show.
    let tracer = (camera == CameraKind::Pinhole).then(|| Tracer::build(projector.scene, |_| true));
    stage.advance(1)?;
    let numbers: HashMap<&SpecularPath, u32> = projector.paths.iter().zip(0..).collect();
    let path_of_end = |path: &SpecularPath| match numbers.get(path) {
        Some(number) if drawn.contains(path) => Some(*number),
        _ => None,
    };
    let paths: Vec<Option<u32>> = shown.ends.iter().map(|end| path_of_end(&end.path)).collect();
    let [width, height] = shown.size.map(|length| length as usize);
    let rows = parallel::map_stage(progress, "finding leaves", height, |row| {
        let pixel = |column: usize| {
            let Some(end) = shown.end_of_pixels[row * width + column] else { return Drawn::Nothing };
            if shown.ends[end as usize].path.bounces.is_empty() {
                return Drawn::Nothing;
            }
            let Some(path) = paths[end as usize] else { return Drawn::Tiles };
            let place = [column as f64 + 0.5, row as f64 + 0.5];
            let leaf = leaf_at(projector, tracer.as_ref(), path, place);
            leaf.map_or(Drawn::Nothing, |leaf| Drawn::Leaf { path, leaf })
        };
        (0..width).map(pixel).collect::<Vec<_>>()
    })?;
    let mut overlay = Overlay::new(OverlayKind::Leaves, shown.size);
    let of_camera = overlay.group("a leaf that is a camera");
    let of_list = overlay.group("a leaf that is a list of rays");
    let of_tiles = overlay.group("no leaf: drawn by tiles");
    let of_border = overlay.group("where leaves meet");
    let group = |drawn: &Drawn| match drawn {
        Drawn::Nothing => 0,
        Drawn::Leaf { leaf, .. } if leaf.is_list => of_list,
        Drawn::Leaf { .. } => of_camera,
        Drawn::Tiles => of_tiles,
    };
    overlay.pixels = rows.iter().flatten().map(group).collect();
    add_borders(&rows, &mut overlay, of_border);
    Ok(overlay)
}

/// The leaf that draws the reflection at a place of the picture, in pixels, on a path.
fn leaf_at(projector: &CameraProjector<'_>, tracer: Option<&Tracer>, path: u32, place: [f64; 2]) -> Option<LeafNumber> {
    let CameraProjector { grid, cameras, scene, paths, sizes, .. } = projector;
    let group = grid.groups.get(path as usize)?;
    let number = group.nearest(projector.cell_of(place))?;
    let ray = group.rays.get(number)?;
    let point = tracer.map_or(Vec3::ZERO, |tracer| {
        let (origin, direction) = (ray.tail.as_vec3(), ray.direction.as_vec3());
        let last = paths[path as usize].bounces.last().map_or(0.0, |bounce| sizes[bounce.object as usize]);
        let hit = tracer.first_hit(scene, &Ray { origin, direction }, (TOUCHING * last) as f32);
        // The environment is as far as anything.
        origin + direction * hit.map_or(scene.bounds.diagonal(), |hit| hit.distance())
    });
    cameras.get(path as usize)?.leaf_at(number, *group.piece_of_ray.get(number)?, point)
}

/// Adds lines between pixels of different leaves, as long as they go on.
fn add_borders(rows: &[Vec<Drawn>], overlay: &mut Overlay, group: u16) {
    let [width, height] = overlay.size.map(|length| length as usize);
    let at = |x: usize, y: usize| rows.get(y).and_then(|row| row.get(x)).copied().unwrap_or_default();
    let differ =
        |one: Drawn, other: Drawn| one != other && matches!((one, other), (Drawn::Leaf { .. }, Drawn::Leaf { .. }));
    let mut add = |ends: [[usize; 2]; 2]| {
        let ends = ends.map(|[x, y]| Vec2::new(x as f32, y as f32));
        overlay.add_segment(OverlaySegment { ends, group });
    };
    for x in 1..width {
        for_each_run(height, |y| differ(at(x - 1, y), at(x, y)), |from, to| add([[x, from], [x, to]]));
    }
    for y in 1..height {
        for_each_run(width, |x| differ(at(x, y - 1), at(x, y)), |from, to| add([[from, y], [to, y]]));
    }
}

/// Calls `run` with the start and the end of all parts of a row in which something holds.
fn for_each_run(length: usize, holds: impl Fn(usize) -> bool, mut run: impl FnMut(usize, usize)) {
    let mut start = None;
    for place in 0..=length {
        match (start, place < length && holds(place)) {
            (None, true) => start = Some(place),
            (Some(from), false) => {
                run(from, place);
                start = None;
            }
            _ => {}
        }
    }
}
