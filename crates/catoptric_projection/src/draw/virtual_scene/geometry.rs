//! The geometry of a view's paths, made with the virtual meshes that are kept.

use super::failed_paths::WholePaths;
use super::kept_meshes::PathObject;
use super::maker::MeshMaker;
use super::scene::VirtualScene;
use crate::draw::far_maps::MapsInView;
use crate::draw::lists::{EndsOfPaths, PathGeometry};
use crate::draw::virtual_mesh::{MeshQuality, SteadySource};
use catoptric_core::clock::Stopwatch;
use catoptric_core::progress::Cancelled;
use catoptric_engine::method::projector::{PathBeginnings, SpecularPath, VertexProjector};
use catoptric_engine::method::{Job, Report};
use catoptric_engine::raster::BlockMask;
use std::collections::HashSet;

/// The inputs of a view's virtual meshes.
pub(crate) struct MeshesOfView<'a, P: ?Sized> {
    pub(crate) projector: &'a P,
    pub(crate) quality: MeshQuality,
    /// The source of parts that stay from view to view, if the method has one.
    pub(crate) steady: Option<&'a dyn SteadySource>,
}

/// The virtual meshes of a view, path by path.
pub(crate) struct VirtualGeometry {
    pub(crate) paths: Vec<PathGeometry>,
    /// Paths that are left to something else.
    pub(crate) paths_left: PathBeginnings,
    /// The number of those of more bounces than projected paths have: left too, or not drawn.
    pub(super) paths_too_long: u64,
    /// True if appearances in lenses were found wrong.
    pub(super) has_wrong_lenses: bool,
    /// The picture where no path goes on.
    pub(super) ends: EndsOfPaths,
    pub(crate) report: Report,
}

impl VirtualScene {
    /// The geometry of a view's paths, and the paths that are left out. Makes the virtual meshes that are missing, with
    /// about as much work; if paths are to be whole, those that take more are left out, and those that are given are
    /// not tried.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn geometry<P: VertexProjector + ?Sized>(
        &self,
        job: &Job<'_>,
        MeshesOfView { projector, quality, steady }: &MeshesOfView<'_, P>,
        (work, whole): (u64, Option<&PathBeginnings>),
        (maps, wrong_in_lenses): (MapsInView<'_>, Option<&BlockMask>),
    ) -> Result<VirtualGeometry, Cancelled> {
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let projector = *projector;
        let maker = MeshMaker { scene: self, job, projector, quality, steady: *steady };
        let pairs = maker.pairs(maps);
        if maps.far.is_some() {
            // Meshes of objects that have become far since an earlier frame would be drawn twice.
            let wanted: HashSet<PathObject> = pairs.iter().copied().collect();
            self.locked_meshes().retain(|key, _| wanted.contains(key));
        }
        let mut is_drawn = vec![true; projector.paths().len()];
        let mut paths_left = PathBeginnings::default();
        let made = if let Some(without) = whole {
            let (made, WholePaths { undone, not_tried, tries }) = maker.add_whole(&pairs, (work, without))?;
            self.locked_failed().note(&tries, (job.scene, job.view), work);
            for (drawn, path) in is_drawn.iter_mut().zip(projector.paths()) {
                *drawn = !undone.hold(path);
            }
            report.counts.insert("paths_not_tried_again", not_tried);
            paths_left = undone;
            made
        } else {
            maker.add_in_shares(&pairs, work)?
        };
        let meshes = self.locked_meshes();
        let geometry = |(path, sequence): (usize, &SpecularPath)| {
            let holes = projector.holes(path as u32).cloned().unwrap_or_default();
            let mut geometry = PathGeometry { path: sequence.clone(), holes, ..PathGeometry::default() };
            for object in 0..job.scene.objects.len() as u32 {
                if let Some(kept) = meshes.get(&(path as u32, object)) {
                    geometry.holes.add(&kept.mesh.holes);
                    kept.mesh.append_to(&mut geometry.vertices, &mut geometry.triangles, &mut geometry.corners);
                }
            }
            geometry
        };
        let drawn_paths = projector.paths().iter().enumerate().filter(|(path, _)| is_drawn[*path]);
        let paths: Vec<PathGeometry> = drawn_paths.map(geometry).collect();
        let drawn = || meshes.iter().filter(|((path, _), _)| is_drawn[*path as usize]).map(|(_, kept)| &kept.mesh);
        report.counts.insert("work", meshes.values().map(|kept| kept.mesh.work).sum());
        report.counts.insert("vertices_projected", made.points_projected);
        report.counts.insert("virtual_triangles", paths.iter().map(|path| path.triangles.len() as u64).sum());
        report.counts.insert("paths", paths.len() as u64);
        report.add_fallback("undivided_pieces", drawn().map(|mesh| mesh.unfinished).sum());
        report.add_fallback("extrapolated_points", drawn().map(|mesh| mesh.extrapolated).sum());
        report.add_fallback("appearances_left_out", drawn().map(|mesh| mesh.left_out).sum());
        report.add_fallback("objects_left_out", made.left_out);
        drop(meshes);
        let too_long = maker.beginnings_of_longer_paths(&pairs, |path| is_drawn[path as usize]);
        let paths_too_long = too_long.len() as u64;
        if whole.is_some() {
            paths_left.extend(too_long);
        } else {
            report.add_fallback("paths_too_long", paths_too_long);
        }
        projector.add_fallbacks(&mut report);
        report.stages_ms.push(("project", watch.lap_ms() - made.blend_ms));
        if made.steady_points > 0 {
            report.stages_ms.push(("blend", made.blend_ms));
            report.counts.insert("steady_vertices", made.steady_points);
        }
        report.add_fallback("paths_drawn_by_tiles", paths_left.len() as u64);
        let has_holes = paths.iter().any(|path| !path.holes.is_empty());
        let by_tiles = whole.is_some();
        let wrong_in_lenses = wrong_in_lenses.cloned().unwrap_or_default();
        let has_wrong_lenses = !wrong_in_lenses.is_empty();
        let of_blocks = if by_tiles { "lens_blocks_drawn_by_tiles" } else { "wrong_lens_blocks" };
        report.add_fallback(of_blocks, wrong_in_lenses.count());
        let ends = match by_tiles && (has_holes || !paths_left.is_empty() || has_wrong_lenses) {
            true => EndsOfPaths::GoOn(wrong_in_lenses),
            false => EndsOfPaths::Environment,
        };
        Ok(VirtualGeometry { paths, paths_left, paths_too_long, has_wrong_lenses, ends, report })
    }
}
