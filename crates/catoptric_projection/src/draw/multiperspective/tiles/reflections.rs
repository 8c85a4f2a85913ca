//! Everything that is the same for all tiles of a picture, and root tiles.

use super::found::{FoundSurface, bend};
use super::own::OwnRule;
use crate::draw::multiperspective::bundles::coverage::ROOT;
use crate::draw::multiperspective::bundles::least_squares::TERMS;
use crate::draw::multiperspective::counts::Counts;
use crate::draw::multiperspective::shapes::SceneShapes;
use crate::draw::multiperspective::tile_log::{TileLog, TileWay};
use crate::draw::multiperspective::tile_model::TileModel;
use crate::draw::rough::RoughReflections;
use catoptric_core::scene::{Scene, ViewRays};
use catoptric_engine::light::wide_hierarchy::WideHierarchy;
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::raster::patch_of_triangle;
use catoptric_engine::raster::source::TileBelow;
use glam::{Vec2, Vec3};

/// Surfaces whose footprint changes by a larger share within a pixel are shaded in quarters of pixels.
const EVEN_BEND: f32 = 0.25;

/// The places furthest to the left, right, top and bottom.
pub(in super::super) fn outermost(positions: &[Vec2]) -> [usize; 4] {
    let most = |along: Vec2| {
        let before = |a: &usize, b: &usize| positions[*a].dot(along).total_cmp(&positions[*b].dot(along));
        (0..positions.len()).max_by(before).unwrap_or_default()
    };
    [-Vec2::X, Vec2::X, -Vec2::Y, Vec2::Y].map(most)
}

/// Everything that is the same for all tiles of a picture.
pub(in super::super) struct Reflections<'a> {
    pub(in super::super) scene: &'a Scene,
    pub(in super::super) rays: ViewRays,
    /// The direction along which the eye's depths are.
    pub(in super::super) forward: Vec3,
    /// The places of samples in a pixel.
    pub(in super::super) positions: &'static [Vec2],
    /// The samples furthest to the left, right, top and bottom.
    pub(in super::super) outermost: [usize; 4],
    pub(in super::super) hierarchy: &'a WideHierarchy,
    pub(in super::super) shapes: &'a SceneShapes,
    /// Highest number of bounces.
    pub(in super::super) order: usize,
    pub(in super::super) model: TileModel,
    /// Reflectors at which no path goes on.
    pub(in super::super) maps: Option<&'a ReflectorMaps>,
    /// The light of rough mirrors.
    pub(in super::super) rough: Option<&'a RoughReflections<'a>>,
    /// Log of the division of the picture into tiles, for an overlay; `None` if it is not wanted.
    pub(in super::super) log: Option<&'a TileLog>,
    pub(in super::super) counts: Counts,
}

/// A root tile.
pub(in super::super) struct Root<'a, 'b> {
    pub(in super::super) tile: &'a TileBelow<'b>,
    /// The root tile's first pixel, counted in the rasteriser's tile.
    pub(in super::super) column: usize,
    pub(in super::super) row: usize,
    /// The last event of the paths.
    pub(in super::super) kind: BounceKind,
}

impl Root<'_, '_> {
    /// The corner of one of its pixels in the picture.
    pub(in super::super) fn corner(&self, column: usize, row: usize) -> Vec2 {
        let x = self.tile.pixel[0] + (self.column + column) as i32;
        let y = self.tile.pixel[1] + (self.row + row) as i32;
        Vec2::new(x as f32, y as f32)
    }

    /// The first sample of one of its pixels.
    pub(in super::super) fn first_sample(&self, column: usize, row: usize) -> usize {
        self.tile.first_sample(self.column + column, self.row + row)
    }
}

impl Reflections<'_> {
    /// A surface by a triangle of the scene and its functions in a tile: of its edges, and of its plane.
    pub(in super::super) fn found(
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
    pub(in super::super) fn record(
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

    /// The triangles of the last object of a path that its rays may meet.
    pub(in super::super) fn own_rule(&self, object: u32, kind: BounceKind, outside: bool) -> OwnRule {
        OwnRule::new(object, self.shapes.of(object), kind, outside)
    }
}
