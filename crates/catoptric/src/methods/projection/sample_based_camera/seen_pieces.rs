//! Which piece of a reflector each pixel shows, for pictures of the subdivision.

use super::grid::{PathRays, RayGrid, Sampler};
use super::{SampleBasedCameraSettings, margin_px};
use crate::methods::projection::SpecularPath;
use crate::methods::projection::ray_map::{Specular, ViewField};
use crate::methods::projection::virtual_scene::VirtualScene;
use crate::methods::reference::NearPlane;
use crate::scene::{Scene, View};

/// The paths of one bounce in a view, and for every pixel (rows from the top) which of them it shows, on which of that
/// path's connected pieces: the parts that cameras are built for one by one. Diffuse things hide nothing here. None where
/// there is no reflector.
pub fn seen_pieces(
    scene: &Scene,
    view: &View,
    settings: &SampleBasedCameraSettings,
) -> (Vec<SpecularPath>, Vec<Option<[u32; 2]>>) {
    let (mut prepared, mut frame) = (None, None::<()>);
    VirtualScene::prepare(&mut prepared, &mut frame, scene);
    let Some(prepared) = prepared else { return (Vec::new(), Vec::new()) };
    let surfaces = prepared.surfaces(scene);
    let specular = Specular { scene, tracer: prepared.tracer(), surfaces: &surfaces, order: 1 };
    let margin_px = margin_px(settings);
    let field = ViewField::new(view, margin_px);
    let grid = RayGrid::new(&Sampler::new(&specular, &field, settings.downsampling as f32, &[]));
    let spacing_px = f64::from(grid.spacing_px);
    let cell = |pixel: u32| (f64::from(pixel) + 0.5 + f64::from(margin_px)) / spacing_px - 0.5;
    let pixels = (0..view.height).flat_map(|y| (0..view.width).map(move |x| [x, y]));
    let (rays, near) = (view.rays(), NearPlane::new(view));
    let pieces = pixels.map(|pixel| {
        let [x, y] = pixel.map(|pixel| pixel as f32 + 0.5);
        let ray = rays.ray(x, y);
        let hit = prepared.tracer().first_hit(scene, &ray, near.distance(&ray))?;
        let object = prepared.tracer().encounter(scene, &ray, &hit, None).point.object;
        let shown = |group: &PathRays| group.path.bounces.first().is_some_and(|bounce| bounce.object == object);
        let mut groups = grid.groups.iter().zip(0..).filter(|(group, _)| shown(group));
        groups.find_map(|(group, path)| group.piece_at(pixel.map(cell)).map(|piece| [path, piece]))
    });
    let pieces = pieces.collect();
    (grid.groups.into_iter().map(|group| group.path).collect(), pieces)
}
