//! What mirrors and lenses show, as a source of the rasteriser's layers.

use super::super::rough::RoughReflections;
use super::TileModel;
use super::bundles::coverage::ROOT;
use super::bundles::least_squares::TERMS;
use super::counts::Counts;
use super::shapes::SceneShapes;
use super::tile_log::{TileLog, TileWay};
use super::tiles::follow::kind;
use super::tiles::found::{FoundSurface, bend};
use super::tiles::marks::PixelMarks;
use super::tiles::own::OwnRule;
use super::tiles::paths::{RootPaths, TilePaths};
use super::tiles::square::PathWork;
use catoptric_core::scene::{Role, Scene, ViewRays};
use catoptric_engine::light::wide_hierarchy::WideHierarchy;
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::raster::source::{EMPTY, LayerSource, ShownBySource, TileBelow};
use catoptric_engine::raster::{LayerSurface, patch_of_triangle};
use glam::{Vec2, Vec3};

/// Surfaces whose footprint changes by a larger share within a pixel are shaded in quarters of pixels.
const EVEN_BEND: f32 = 0.25;

/// The places furthest to the left, right, top and bottom.
pub(super) fn outermost(positions: &[Vec2]) -> [usize; 4] {
    let most = |along: Vec2| {
        let before = |a: &usize, b: &usize| positions[*a].dot(along).total_cmp(&positions[*b].dot(along));
        (0..positions.len()).max_by(before).unwrap_or_default()
    };
    [-Vec2::X, Vec2::X, -Vec2::Y, Vec2::Y].map(most)
}

/// Everything that is the same for all tiles of a picture.
pub(super) struct Reflections<'a> {
    pub(super) scene: &'a Scene,
    pub(super) rays: ViewRays,
    /// The direction along which the eye's depths are.
    pub(super) forward: Vec3,
    /// The places of samples in a pixel.
    pub(super) positions: &'static [Vec2],
    /// The samples furthest to the left, right, top and bottom.
    pub(super) outermost: [usize; 4],
    pub(super) hierarchy: &'a WideHierarchy,
    pub(super) shapes: &'a SceneShapes,
    /// Highest number of bounces.
    pub(super) order: usize,
    pub(super) model: TileModel,
    /// Reflectors at which no path goes on.
    pub(super) maps: Option<&'a ReflectorMaps>,
    /// What rough mirrors reflect.
    pub(super) rough: Option<&'a RoughReflections<'a>>,
    /// Is told how the picture is divided, for who wants to see it.
    pub(super) log: Option<&'a TileLog>,
    pub(super) counts: Counts,
}

/// What was found in a tile, and a thread's buffers.
#[derive(Default)]
pub(super) struct TileSurfaces {
    pub(super) surfaces: Vec<FoundSurface>,
    pub(super) paths: TilePaths,
    root: RootPaths,
    work: PathWork,
    marks: PixelMarks,
}

/// A root tile.
pub(super) struct Root<'a, 'b> {
    pub(super) tile: &'a TileBelow<'b>,
    /// Its first pixel in the rasteriser's tile.
    pub(super) column: usize,
    pub(super) row: usize,
    /// The last event of the paths.
    pub(super) kind: BounceKind,
}

impl Root<'_, '_> {
    /// The corner of one of its pixels in the picture.
    pub(super) fn corner(&self, column: usize, row: usize) -> Vec2 {
        let x = self.tile.pixel[0] + (self.column + column) as i32;
        let y = self.tile.pixel[1] + (self.row + row) as i32;
        Vec2::new(x as f32, y as f32)
    }

    /// The first sample of one of its pixels.
    pub(super) fn first_sample(&self, column: usize, row: usize) -> usize {
        self.tile.first_sample(self.column + column, self.row + row)
    }
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
        // What is behind is not asked for.
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
    /// place of what these show.
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

    /// A surface by a triangle of the scene and its functions in a tile: of its edges, and of its plane.
    pub(super) fn found(
        &self,
        root: &Root<'_, '_>,
        triangle: u32,
        center: Vec2,
        scale: f32,
        [a, b, c, plane]: [[f32; TERMS]; 4],
    ) -> FoundSurface {
        let sum = std::array::from_fn(|term| a[term] + b[term] + c[term]);
        let functions = [b, c, sum, plane];
        let object = self.scene.triangle_objects[triangle as usize];
        let is_mapped = self.maps.is_some_and(|maps| maps.has(object));
        let goes_on = self.scene.role_of(object).is_specular() && root.tile.layer() < self.order && !is_mapped;
        let patch = patch_of_triangle(self.scene, triangle);
        let is_bent = bend(&functions, scale) > EVEN_BEND;
        FoundSurface { triangle, group: if goes_on { object + 1 } else { 0 }, patch, center, scale, functions, is_bent }
    }

    /// Tells the log how pixels of a root tile are drawn: those of a square, as bits of the root tile's rows.
    #[inline(always)]
    pub(super) fn record(
        &self,
        root: &Root<'_, '_>,
        way: TileWay,
        [column, row]: [usize; 2],
        side: usize,
        rows: impl FnOnce() -> [u16; ROOT],
    ) {
        if let Some(log) = self.log.filter(|_| root.tile.layer() == 1) {
            let corner = |column: usize, row: usize| root.corner(column, row).as_ivec2();
            log.add(corner(0, 0), corner(column, row), side, way, &rows());
        }
    }

    /// What of the last object of a path rays may meet.
    pub(super) fn own_rule(&self, object: u32, kind: BounceKind, outside: bool) -> OwnRule {
        OwnRule::new(object, self.shapes.of(object), kind, outside)
    }
}
