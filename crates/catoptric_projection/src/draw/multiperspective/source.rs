//! The surfaces that mirrors and lenses show, as a source of the rasteriser's layers.

use super::bundles::coverage::ROOT;
use super::counts::Counts;
use super::tile_log::TileWay;
use super::tiles::follow::kind;
use super::tiles::found::FoundSurface;
use super::tiles::marks::PixelMarks;
use super::tiles::paths::{RootPaths, TilePaths};
use super::tiles::reflections::{Reflections, Root};
use super::tiles::square::PathWork;
use catoptric_core::scene::Role;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::raster::LayerSurface;
use catoptric_engine::raster::source::{EMPTY, LayerSource, ShownBySource, TileBelow};
use glam::Vec2;

/// The surfaces found in a tile, and a thread's buffers.
#[derive(Default)]
pub(super) struct TileSurfaces {
    pub(super) surfaces: Vec<FoundSurface>,
    pub(super) paths: TilePaths,
    root: RootPaths,
    work: PathWork,
    marks: PixelMarks,
}

impl LayerSource for Reflections<'_> {
    type Found = TileSurfaces;

    fn layer_count(&self) -> usize {
        self.order + 1
    }

    fn begin(&self, found: &mut TileSurfaces) {
        found.surfaces.clear();
        found.paths.clear();
        found.marks.clear();
    }

    fn draw_layer(&self, tile: &TileBelow<'_>, found: &mut TileSurfaces, ids: &mut [u32]) -> ShownBySource {
        let kind = kind(tile, tile.layer() - 1);
        let refracts = kind == BounceKind::Transmit;
        let going = found.paths.label(self.scene, tile, &found.surfaces, refracts);
        let mut any = false;
        // Rough mirrors are counted where lists go on, too.
        let may_be_rough = tile.layer() == 1 && self.rough.is_some();
        if going.any || may_be_rough {
            for row in (0..tile.extent[1]).step_by(ROOT) {
                for column in (0..tile.extent[0]).step_by(ROOT) {
                    any |= self.draw_root(&Root { tile, column, row, kind }, found, ids);
                }
            }
        }
        ShownBySource { any, divides: going.divides }
    }

    fn surface(&self, found: &TileSurfaces, number: u32, position: Vec2) -> LayerSurface {
        found.surfaces[number as usize].surface(position, None)
    }

    fn patch(&self, found: &TileSurfaces, number: u32) -> u32 {
        found.surfaces[number as usize].patch
    }

    fn depth_at(&self, found: &TileSurfaces, number: u32, position: Vec2) -> f32 {
        found.surfaces[number as usize].depth_at(position)
    }

    fn is_bent(&self, found: &TileSurfaces, number: u32) -> bool {
        found.surfaces[number as usize].is_bent
    }

    fn divides(&self, triangle: u32) -> bool {
        self.scene.role_of(self.scene.triangle_objects[triangle as usize]) == Role::Lens
    }
}

impl Reflections<'_> {
    /// Draws a root tile; true if anything shows.
    fn draw_root(&self, root: &Root<'_, '_>, found: &mut TileSurfaces, ids: &mut [u32]) -> bool {
        let TileSurfaces { surfaces, paths, root: pixels, work, marks } = found;
        pixels.gather(root.tile, [root.column, root.row], paths);
        let path = |label: u16| &paths.paths[label as usize - 1];
        let [low, high] = [root.corner(0, 0), root.corner(ROOT, ROOT)];
        // The surface behind a rough mirror is not needed.
        let rough = self.rough.filter(|_| root.tile.layer() == 1);
        // Pixels of a path mostly follow each other.
        let mut last = (0, false);
        let mut is_known = |label: u16| {
            if label != last.0 {
                last = (label, rough.is_some_and(|rough| rough.is_all_of(path(label).object, low, high)));
            }
            last.1
        };
        let mut any = false;
        let (mut by_tiles, mut by_rays) = ([0; ROOT], self.listed_rough_pixels(root));
        for (label, rows) in &pixels.full {
            let mut traced = *rows;
            if !is_known(*label) {
                work.by_rays = self.model.by_rays || self.model.turns_normals && path(*label).is_bumpy;
                any |= self.draw_path(root, path(*label).object, rows, work, surfaces, ids);
                traced = work.traced;
            }
            for row in 0..ROOT {
                by_tiles[row] |= rows[row] & !traced[row];
                by_rays[row] |= traced[row];
            }
        }
        Counts::add(&self.counts.rim_pixels, pixels.partial.len());
        for pixel in &pixels.partial {
            let place = pixel.place.map(usize::from);
            by_rays[place[1]] |= 1 << place[0];
            if is_known(pixel.label) {
                continue;
            }
            self.record(root, TileWay::Traced, place, 1, || {
                let mut rows = [0; ROOT];
                rows[place[1]] = 1 << place[0];
                rows
            });
            any |= self.trace_pixel(root, path(pixel.label).object, place, pixel.samples, surfaces, ids) == Some(true);
        }
        let place = ([root.column, root.row], root.tile.extent[0]);
        marks.add(place, (&by_tiles, &by_rays), &self.counts);
        any
    }

    /// The pixels of a root tile that show rough mirrors at which lists go on: the light of their grid's rays takes the
    /// place of these lists' surfaces.
    fn listed_rough_pixels(&self, root: &Root<'_, '_>) -> [u16; ROOT] {
        let mut pixels = [0; ROOT];
        let Some(rough) = self.rough.filter(|_| root.tile.layer() == 1) else { return pixels };
        let [columns, rows] = root.tile.extent;
        let (ids, samples) = (root.tile.ids(0), root.tile.positions.len());
        let is_listed = |id: u32, block: usize| {
            let object = |id: u32| self.scene.triangle_objects[root.tile.triangle(id).source as usize];
            id != EMPTY && root.tile.has_list(id, block) && rough.is_rough(object(id))
        };
        for (row, bits) in pixels.iter_mut().enumerate().take(rows.saturating_sub(root.row)) {
            for column in 0..ROOT.min(columns.saturating_sub(root.column)) {
                let first = root.first_sample(column, row);
                let block = first / root.tile.samples_a_block();
                let shows = ids[first..first + samples].iter().any(|id| is_listed(*id, block));
                *bits |= u16::from(shows) << column;
            }
        }
        pixels
    }
}
