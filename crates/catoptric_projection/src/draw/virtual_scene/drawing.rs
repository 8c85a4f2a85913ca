//! The picture and overlays of a view from its virtual geometry, with tiles for the paths that it lacks.

use super::super::lists::{EndsOfPaths, draw_lists, lists_of_paths};
use super::super::overlays::{self, ShownPixels};
use super::super::work_limit::ExactTiles;
use super::geometry::VirtualGeometry;
use crate::draw::far_maps::MapsInView;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::scene::Role;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::path_lists::PathLists;
use catoptric_engine::method::projector::{MAX_BOUNCES, PathBeginnings, SpecularPath};
use catoptric_engine::method::{Job, Quality, Report, report};
use catoptric_engine::raster::{self, BlockMask};
use std::collections::HashSet;

impl VirtualGeometry {
    /// The geometry of a view all of whose paths are left to something else, without a try.
    pub(crate) fn all_left(paths_left: PathBeginnings) -> Self {
        let mut report = Report::default();
        let count = paths_left.len() as u64;
        let none = ["work", "vertices_projected", "virtual_triangles", "paths"].map(|name| (name, 0));
        report.counts.extend(none);
        report.counts.insert("paths_not_tried_again", count);
        report.add_fallback("paths_drawn_by_tiles", count);
        let ends = EndsOfPaths::GoOn(BlockMask::default());
        Self { paths: Vec::new(), paths_left, paths_too_long: 0, has_wrong_lenses: false, ends, report }
    }

    /// Rasterises the geometry. Reflectors with environment maps show these, and maps of far objects take the place of
    /// their virtual meshes; `tiles` draw the paths that are left.
    ///
    /// # Errors
    /// The errors of the rasteriser.
    pub(crate) fn draw(
        self,
        job: &Job<'_>,
        tiles: &ExactTiles<'_>,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let Self { paths, paths_left, paths_too_long, has_wrong_lenses, ends, mut report } = self;
        if paths_too_long > 0 {
            report.warnings.push(too_long_warning(tiles.go_on()));
        }
        if has_wrong_lenses {
            report.warnings.push(wrong_lenses_warning(tiles.go_on()));
        }
        let of_work = paths_left.len() as u64 > paths_too_long;
        if tiles.go_on() && of_work {
            // The text is the same in all frames, so that it is shown once.
            let warning = "some paths, with those that go on from them, are drawn by tiles: they take more than the \
                           `work` that is allowed (with `beyond_work = \"coarse\"` the method draws them, coarser)";
            report.warnings.push(warning.into());
        }
        report.warnings.extend(report::bumpy_surfaces(job.scene));
        report.add(tiles.draw(job, paths, &ends, maps, target)?);
        Ok(report)
    }

    /// The rasteriser's lists of the geometry, without that of what is seen directly.
    pub(crate) fn path_lists(self, job: &Job<'_>) -> PathLists {
        let has_rest = self.ends != EndsOfPaths::Environment;
        let specular = job.scene.specular_objects();
        // Any of them may be seen.
        let lenses = specular.into_iter().filter(|object| job.scene.role_of(*object) == Role::Lens).collect();
        PathLists { lists: lists_of_paths(job, self.paths, None, &self.ends, &lenses), has_rest, report: self.report }
    }

    /// An overlay of the picture that [`Self::draw`] draws. Kinds that virtual meshes do not have are `own` ones of the
    /// method, made from the surfaces that pixels show and the paths that meshes draw.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub(crate) fn overlay(
        self,
        kind: OverlayKind,
        job: &Job<'_>,
        tiles: &ExactTiles<'_>,
        maps: MapsInView<'_>,
        own: impl FnOnce(&ShownPixels, &HashSet<SpecularPath>) -> Result<Option<Overlay>, RenderError>,
    ) -> Result<Option<Overlay>, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let job = &Job { quality: Quality { samples: 1, ..quality }, ..*job };
        let Self { paths, paths_left, ends, .. } = self;
        let drawn = paths.iter().map(|geometry| geometry.path.clone()).collect();
        let lists = draw_lists(job, paths, maps.whole, &ends);
        let shown = match ends {
            EndsOfPaths::GoOn(_) => tiles.shown(job, &lists, maps)?,
            EndsOfPaths::Environment => ShownPixels::of(scene, view, |shader, target| {
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

/// The warning that appearances in parts of lenses are wrong.
fn wrong_lenses_warning(by_tiles: bool) -> String {
    let what = if by_tiles { "are drawn by tiles" } else { "are wrong" };
    let cure = if by_tiles { "" } else { " (with `beyond_work = \"tiles\"` tiles draw them)" };
    format!("parts of lenses {what}: the method finds no right places for what is seen there{cure}")
}

/// The warning that paths have more bounces than projected ones may have.
fn too_long_warning(by_tiles: bool) -> String {
    if by_tiles {
        format!("paths of more than {MAX_BOUNCES} bounces are drawn by tiles: the method projects no longer ones")
    } else {
        format!(
            "paths of more than {MAX_BOUNCES} bounces are not drawn: the method projects no longer ones (with \
             `beyond_work = \"tiles\"` tiles draw them)"
        )
    }
}
