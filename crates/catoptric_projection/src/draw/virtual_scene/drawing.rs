//! From the virtual geometry of a view to its picture and overlays: with tiles for the paths that it lacks.

use super::super::lists::{EndsOfPaths, draw_lists};
use super::super::overlays::{self, ShownPixels};
use super::super::work_limit::ExactTiles;
use super::super::{MapsInView, draw_paths_with};
use super::VirtualGeometry;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath};
use catoptric_engine::method::{Job, Quality, Report, report};
use catoptric_engine::raster;
use std::collections::HashSet;

impl VirtualGeometry {
    /// That of a view all of whose paths are left to something else, without a try.
    pub(crate) fn all_left(paths_left: PathBeginnings) -> Self {
        let mut report = Report::default();
        let count = paths_left.len() as u64;
        let none = ["work", "vertices_projected", "virtual_triangles", "paths"].map(|name| (name, 0));
        report.counts.extend(none);
        report.counts.insert("paths_not_tried_again", count);
        report.add_fallback("paths_drawn_by_tiles", count);
        Self { paths: Vec::new(), paths_left, has_holes: false, report }
    }

    /// Rasterises it. Reflectors with environment maps show these, and maps of far objects take the place of their
    /// virtual meshes. With `tiles` these draw the paths that are left.
    ///
    /// # Errors
    /// Those of the rasteriser.
    pub(crate) fn draw(
        self,
        job: &Job<'_>,
        tiles: Option<&ExactTiles<'_>>,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let Self { paths, paths_left, has_holes, mut report } = self;
        if !paths_left.is_empty() {
            // The same for all frames, so that it is shown once.
            let warning = "some paths, with those that go on from them, are drawn by tiles: they take more than the \
                           `work` that is allowed (with `beyond_work = \"coarse\"` the method draws them, coarser)";
            report.warnings.push(warning.into());
        }
        report.warnings.extend(report::bumpy_surfaces(job.scene));
        match tiles.filter(|_| has_holes || !paths_left.is_empty()) {
            Some(tiles) => report.add(tiles.draw(job, paths, maps, target)?),
            None => {
                report.warnings.extend(report::rough_mirrors(job.scene));
                report.add(draw_paths_with(job, paths, maps, target)?.1);
            }
        }
        Ok(report)
    }

    /// An overlay of what [`Self::draw`] draws. Kinds that virtual meshes do not have are `own` ones of the method: it
    /// makes them of what pixels show and of the paths that meshes draw.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub(crate) fn overlay(
        self,
        kind: OverlayKind,
        job: &Job<'_>,
        tiles: Option<&ExactTiles<'_>>,
        maps: MapsInView<'_>,
        own: impl FnOnce(&ShownPixels, &HashSet<SpecularPath>) -> Result<Option<Overlay>, RenderError>,
    ) -> Result<Option<Overlay>, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let job = &Job { quality: Quality { samples: 1, ..quality }, ..*job };
        let Self { paths, paths_left, has_holes, .. } = self;
        let tiles = tiles.filter(|_| has_holes || !paths_left.is_empty());
        let ends = if tiles.is_some() { EndsOfPaths::GoOn } else { EndsOfPaths::Environment };
        let drawn = paths.iter().map(|geometry| geometry.path.clone()).collect();
        let lists = draw_lists(job, paths, maps.whole, ends);
        let shown = match tiles {
            Some(tiles) => tiles.shown(job, &lists, maps)?,
            None => ShownPixels::of(scene, view, |shader, target| {
                raster::draw(view, 1, &lists, shader, target, progress).map(drop)
            })?,
        };
        Ok(match kind {
            OverlayKind::Paths => Some(overlays::paths(scene, &shown, &paths_left)),
            OverlayKind::VirtualTriangles => Some(overlays::virtual_triangles(scene, view, &lists, &shown, progress)?),
            OverlayKind::Tiles | OverlayKind::Leaves | OverlayKind::Layers => own(&shown, &drawn)?,
        })
    }
}
