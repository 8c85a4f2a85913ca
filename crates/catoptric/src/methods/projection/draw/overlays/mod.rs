//! Overlays of pictures that the rasteriser draws: the paths that pixels show, and the edges of moved triangles.

mod edges;
mod shown;

pub(in crate::methods::projection) use edges::virtual_triangles;
pub(in crate::methods::projection) use shown::ShownPixels;

use crate::methods::overlay::{Overlay, OverlayKind};
use crate::methods::projector::SpecularPath;
use crate::optics::path::bundle::Bounce;
use crate::scene::Scene;

/// A path's name: for each bounce its kind and its object, from the eye on.
fn name_of(scene: &Scene, path: &SpecularPath) -> String {
    let name = |bounce: &Bounce| format!("{} {}", bounce.kind.letter(), scene.objects[bounce.object as usize].name);
    path.bounces.iter().map(name).collect::<Vec<_>>().join(" > ")
}

/// Pixels by the path that they show; those without a bounce have no group.
pub(in crate::methods::projection) fn paths(scene: &Scene, shown: &ShownPixels) -> Overlay {
    let mut overlay = Overlay::new(OverlayKind::Paths, shown.size);
    let group = |path: &SpecularPath| match path.bounces.is_empty() {
        true => 0,
        false => overlay.group(name_of(scene, path)),
    };
    let groups: Vec<u16> = shown.ends.iter().map(|end| &end.path).map(group).collect();
    overlay.pixels = shown.end_of_pixels.iter().map(|end| end.map_or(0, |end| groups[end as usize])).collect();
    overlay
}
