//! The drawing of geometry that appears on paths.

use super::drawn_by::PixelsByOthers;
use super::far_maps::MapsInView;
use super::lists::{EndsOfPaths, PathGeometry, draw_lists};
use super::path_shader::PathShader;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::{Job, Report};
use catoptric_engine::raster::{self, RasterReport};

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

/// Like [`draw_paths`], with environment maps: reflectors that have one look it up, and no path goes on at them; maps
/// of far objects are seen behind paths. Also returns the counts of the shader.
pub(crate) fn draw_paths_with(
    job: &Job<'_>,
    paths: Vec<PathGeometry>,
    maps: MapsInView<'_>,
    target: &mut Framebuffer,
) -> Result<(RasterReport, Report), RenderError> {
    let lists = draw_lists(job, paths, maps.whole, &EndsOfPaths::Environment);
    let shader = PathShader::new(job.scene, job.view, job.quality.samples).with_maps(maps, job.quality.order);
    let drawn = raster::draw(job.view, job.quality.samples, &lists, &shader, target, job.progress)?;
    let mut report = Report::default();
    report.add_raster(&drawn);
    shader.describe(PixelsByOthers::default(), &mut report);
    Ok((drawn, report))
}
