//! Drawing and shading of projected geometry: the same for every method that finds where scene points appear.
//!
//! Each specular path is a list of triangles in the layer of its number of bounces, confined by a stencil to where the
//! path without its last bounce shows the object of that bounce. A shader then walks along the surfaces that a pixel
//! shows, with the same optics and the same shading as the reference.
//!
//! At a lens light divides: reflection is the rasteriser's first [`Branch`](catoptric_engine::raster::Branch),
//! transmission its second. Every path belongs to exactly one sequence of branches (which of its bounces transmit), so
//! nothing is counted twice; a tile draws only the sequences that it shows, and one where there are no lenses.
//!
//! A path that entered a lens meets that lens's exit surface next, from inside. Nothing marks which of a lens's
//! triangles are exits: at the end of a path that entered, the nearest is one, and hides those beyond it.

mod drawn_by;
pub(super) mod far_maps;
pub(super) mod flat_mirrors;
mod followed;
mod lists;
mod lobe_lights;
mod mesh_neighbours;
pub(super) mod multiperspective;
pub(super) mod overlays;
mod path_shader;
pub(super) mod prepared;
mod rough;
pub mod virtual_mesh;
pub mod virtual_scene;
pub(super) mod work_limit;

use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::scene::PicturePoint;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::method::{Job, Report};
use catoptric_engine::raster::{self, BlockMask, DrawTriangle, RasterReport};
use far_maps::FarMaps;
use glam::Vec2;
use lists::EndsOfPaths;

pub(crate) use drawn_by::PixelsByOthers;
pub(crate) use path_shader::PathShader;
use path_shader::meet_known_surface;

/// Geometry that appears at the end of one specular path: pieces of scene triangles at the places where they appear.
///
/// Geometry of one path may come in several parts, for instance one a focal index.
#[derive(Clone, Debug, Default)]
pub struct PathGeometry {
    /// The path, of at least one bounce. Paths that pass through anything but a lens are not drawn.
    pub path: SpecularPath,
    /// Appearances of scene points: the picture points of the places that lie the path's length away on their view
    /// rays.
    ///
    /// In a perspective view `w` and `depth` are the path's length times the cosine between view ray and view axis
    /// (for a flat mirror then all in between is interpolated exactly), and in an orthographic one `w` is 1 and `depth`
    /// is the path's length.
    pub vertices: Vec<PicturePoint>,
    /// For every vertex a signed distance: what is below 0 is cut off. Empty: nothing is.
    pub clip_distances: Vec<f32>,
    /// Pieces of the scene's triangles: `source` is the scene's triangle. Group, patch and alpha test are filled in
    /// while drawing.
    pub triangles: Vec<DrawTriangle>,
    /// For every piece the weights of the source's second and third vertex at its corners. Empty: all are whole.
    pub corners: Vec<[Vec2; 3]>,
    /// Blocks of the picture where something else is to draw what the path shows.
    pub holes: BlockMask,
}

/// Environment maps that take the place of projected geometry.
#[derive(Clone, Copy, Default)]
pub(crate) struct MapsInView<'a> {
    /// Those of reflectors at which no path goes on.
    pub(crate) whole: Option<&'a ReflectorMaps>,
    /// Those of objects that are far from a reflector, seen behind its paths.
    pub(crate) far: Option<&'a FarMaps>,
}

/// Draws the scene directly in view, and in its reflectors the geometry that appears there.
///
/// Where a path shows nothing, the environment is seen at its end. Reflectors at the end of paths of the highest order
/// are black, as in the reference; longer paths are ignored.
///
/// # Errors
/// As [`raster::draw`].
pub fn draw_paths(
    job: &Job<'_>,
    paths: Vec<PathGeometry>,
    target: &mut Framebuffer,
) -> Result<RasterReport, RenderError> {
    draw_paths_with(job, paths, MapsInView::default(), target).map(|(report, _)| report)
}

/// As [`draw_paths`]; reflectors that have environment maps look these up, and no path goes on at them. Maps of far
/// objects are seen behind paths. With what the shader has counted.
pub(crate) fn draw_paths_with(
    job: &Job<'_>,
    paths: Vec<PathGeometry>,
    maps: MapsInView<'_>,
    target: &mut Framebuffer,
) -> Result<(RasterReport, Report), RenderError> {
    let lists = lists::draw_lists(job, paths, maps.whole, &EndsOfPaths::Environment);
    let shader = PathShader::new(job.scene, job.view, job.quality.samples).with_maps(maps, job.quality.order);
    let drawn = raster::draw(job.view, job.quality.samples, &lists, &shader, target, job.progress)?;
    let mut report = Report::default();
    report.add_raster(&drawn);
    shader.describe(PixelsByOthers::default(), &mut report);
    Ok((drawn, report))
}
