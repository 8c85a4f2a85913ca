//! The piece of a reflector in each pixel, for pictures of the subdivision.

use super::grid::RayGrid;
use super::path_rays::DensePathRays;
use super::sampler::RaySampler;
use crate::find::ray_map::{Specular, ViewField};
use crate::sample_based_camera::settings::{SampleBasedCameraSettings, margin_px};
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::light::path_tracer::NearPlane;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::manifold::SpecularSurfaces;

/// Paths, and for every pixel a path's index and its piece's number.
pub type PiecesOfPixels = (Vec<SpecularPath>, Vec<Option<[u32; 2]>>);

/// The paths of one bounce in a view, and for every pixel (rows from the top) which of them it shows, on which of that
/// path's connected pieces: the parts that cameras are built for one by one. Diffuse things hide nothing here.
///
/// # Errors
/// [`Cancelled`].
pub fn visible_pieces(
    scene: &Scene,
    view: &View,
    settings: &SampleBasedCameraSettings,
    progress: &dyn Progress,
) -> Result<PiecesOfPixels, Cancelled> {
    let tracer = Tracer::build(scene, |object| scene.role_of(object).is_specular());
    let surfaces = SpecularSurfaces::new(scene);
    let specular = Specular { scene, tracer: &tracer, surfaces: &surfaces, order: 1 };
    let margin_px = margin_px(settings);
    let field = ViewField::new(view, margin_px);
    let grid = RayGrid::new(&RaySampler::new(&specular, &field, settings.downsampling as f32, &[]), progress)?;
    let spacing_px = f64::from(grid.spacing_px);
    let cell = |pixel: u32| (f64::from(pixel) + 0.5 + f64::from(margin_px)) / spacing_px - 0.5;
    let pixels = (0..view.height).flat_map(|y| (0..view.width).map(move |x| [x, y]));
    let (rays, near) = (view.rays(), NearPlane::new(view));
    let pieces = pixels.map(|pixel| {
        let [x, y] = pixel.map(|pixel| pixel as f32 + 0.5);
        let ray = rays.ray(x, y);
        let hit = tracer.first_hit(scene, &ray, near.distance(&ray))?;
        let object = tracer.encounter(scene, &ray, &hit, None).point.object;
        let shown = |group: &DensePathRays| group.path.bounces.first().is_some_and(|bounce| bounce.object == object);
        let mut groups = grid.groups.iter().zip(0..).filter(|(group, _)| shown(group));
        groups.find_map(|(group, path)| group.piece_at(pixel.map(cell)).map(|piece| [path, piece]))
    });
    let pieces = pieces.collect();
    Ok((grid.groups.into_iter().map(|group| group.path).collect(), pieces))
}
