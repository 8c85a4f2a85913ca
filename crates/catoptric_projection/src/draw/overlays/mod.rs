//! Overlays of pictures that the rasteriser draws: the paths that pixels show, and the edges of moved triangles.

mod edges;
mod shown;

pub(crate) use edges::virtual_triangles;
pub(crate) use shown::ShownPixels;

use catoptric_core::scene::Scene;
use catoptric_engine::method::overlay::{self, Overlay};
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath};

/// Pixels by the path that they show; those without a bounce have no group. Paths that are left to tiles say so.
pub(crate) fn paths(scene: &Scene, shown: &ShownPixels, left: &PathBeginnings) -> Overlay {
    let none = SpecularPath::default();
    let path = |end: &Option<u32>| end.map_or(&none, |end| &shown.ends[end as usize].path);
    let pixels: Vec<&SpecularPath> = shown.end_of_pixels.iter().map(path).collect();
    overlay::paths::of_named(shown.size, &pixels, |path| {
        let name = overlay::paths::name_of(scene, path);
        if left.hold(path) { format!("{name}, by tiles") } else { name }
    })
}
