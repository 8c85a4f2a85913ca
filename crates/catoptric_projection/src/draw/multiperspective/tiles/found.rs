//! Surfaces that samples of a tile show.

use super::super::bundles::least_squares::TERMS;
use super::super::bundles::model::{slopes_at, value_at};
use catoptric_core::scene::shade::Barycentrics;
use catoptric_engine::raster::LayerSurface;
use glam::Vec2;

/// A surface that samples of a tile show.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct FoundSurface {
    pub(in super::super) triangle: u32,
    pub(in super::super) group: u32,
    /// [`DrawTriangle::patch`](catoptric_engine::raster::DrawTriangle::patch).
    pub(in super::super) patch: u32,
    /// The position where u and v are 0, in pixels, and their change a pixel.
    pub(in super::super) center: Vec2,
    pub(in super::super) scale: f32,
    /// Edge functions of the second and third corner, the sum of all three, and that of the plane.
    pub(in super::super) functions: [[f32; TERMS]; 4],
    /// True if the place on the surface changes unevenly within a pixel.
    pub(in super::super) is_bent: bool,
}

/// The relative change, within a pixel, of a place's change from pixel to pixel, where u and v are 0. Places are given
/// by the edge functions of the second and third corner and by the sum of all three.
pub(in super::super) fn bend([b, c, sum, _]: &[[f32; TERMS]; 4], scale: f32) -> f32 {
    let slope = |function: &[f32; TERMS]| function[1].abs() + function[2].abs();
    let second = |function: &[f32; TERMS]| 2.0 * (function[3].abs() + function[4].abs() + function[5].abs());
    let by_foreshortening = 2.0 * slope(sum) / sum[0].abs();
    scale * ((second(b) + second(c)) / (slope(b) + slope(c)) + by_foreshortening)
}

impl FoundSurface {
    /// The surface at a position, no further beside the triangle than so many times its size; `None`: by its patch.
    #[inline(always)]
    pub(in super::super) fn surface(&self, position: Vec2, beside: Option<f32>) -> LayerSurface {
        let Vec2 { x: u, y: v } = (position - self.center) * self.scale;
        let [b, c, sum, _] = &self.functions;
        let slopes = |function: &[f32; TERMS]| Vec2::from_array(slopes_at(function, u, v)) * self.scale;
        let inverse = 1.0 / value_at(sum, u, v);
        let (wb, wc) = (value_at(b, u, v) * inverse, value_at(c, u, v) * inverse);
        let of_sum = slopes(sum);
        let (db, dc) = ((slopes(b) - of_sum * wb) * inverse, (slopes(c) - of_sum * wc) * inverse);
        let beside = beside.unwrap_or(if self.patch != 0 { 1.0 } else { 0.0 });
        let value = Vec2::new(wb, wc).clamp(Vec2::splat(-beside), Vec2::splat(1.0 + beside));
        let excess = (0.5 * (value.x + value.y - 1.0 - beside)).max(0.0);
        let usable = db.is_finite() && dc.is_finite() && value.is_finite();
        let barycentrics = match usable {
            true => {
                Barycentrics { value: value - excess, dx: Vec2::new(db.x, dc.x), dy: Vec2::new(db.y, dc.y), samples: 1 }
            }
            false => Barycentrics { value: Vec2::splat(1.0 / 3.0), samples: 1, ..Barycentrics::default() },
        };
        LayerSurface { list: u32::MAX, source: self.triangle, group: self.group, barycentrics }
    }

    /// The depth along the rays at a position.
    pub(in super::super) fn depth_at(&self, position: Vec2) -> f32 {
        let Vec2 { x: u, y: v } = (position - self.center) * self.scale;
        value_at(&self.functions[3], u, v) / value_at(&self.functions[2], u, v)
    }
}
