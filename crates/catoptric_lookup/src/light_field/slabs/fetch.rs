//! Look-ups of rays side by side, in the four views about each (Yu, Yang, McMillan 2005, section 6).

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::form::{RowView, ViewForm};
use super::texels::{MASKS, SHIFTED, scale};
use crate::light_field::layout::{STEEPEST, SlabLayout, SlabRays};
use crate::light_field::settings::{Compression, Disparity};
use catoptric_core::math::lanes::{Lanes, MANY_LANES, Vec3Lanes, whole};
use glam::Vec3;

/// Look-ups of rays in slabs, in rows that are given by number, slab after slab.
#[derive(Clone, Debug)]
pub(crate) struct Fetch {
    pub(crate) layout: SlabLayout,
    pub(crate) form: ViewForm,
    pub(crate) disparity: Disparity,
}

/// A view among the four about each ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearby<const LANES: usize> {
    /// The number of its row, and its own in that.
    pub(crate) row: [u32; LANES],
    pub(crate) view: [u32; LANES],
    /// The weight in the blend.
    pub(crate) share: Lanes<LANES>,
    /// The change of the slope from the ray to the view's pixel with the parallax.
    pub(crate) shift: [Lanes<LANES>; 2],
    /// The parallax of the surface that the ray meets.
    pub(crate) parallax: Lanes<LANES>,
}

impl<const LANES: usize> Nearby<LANES> {
    /// Slope, in this view, of the surface that the ray meets.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn slope(&self, rays: &SlabRays<LANES>) -> [Lanes<LANES>; 2] {
        let mut slope = rays.slope;
        for k in 0..2 {
            for lane in 0..LANES {
                slope[k][lane] += self.shift[k][lane] * self.parallax[lane];
            }
        }
        slope
    }
}

impl Fetch {
    /// The four views about rays (equation 5), with the parallax of the slabs' focal planes.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn views<const LANES: usize>(&self, rays: &SlabRays<LANES>) -> [Nearby<LANES>; 4] {
        let (st, most) = (self.layout.st, (self.layout.st - 2) as f32);
        let mut at = rays.st;
        let mut low = [[0; LANES]; 2];
        for k in 0..2 {
            for lane in 0..LANES {
                let floor = at[k][lane].floor().min(most);
                at[k][lane] -= floor;
                low[k][lane] = whole(floor);
            }
        }
        let aspect =
            [self.layout.each(&rays.slab, |slab| slab.aspect.x), self.layout.each(&rays.slab, |slab| slab.aspect.y)];
        let mut views = [Nearby {
            row: [0; LANES],
            view: low[0],
            share: Lanes::ZERO,
            shift: [Lanes::ZERO; 2],
            parallax: self.layout.each(&rays.slab, |slab| slab.focal),
        }; 4];
        for (number, view) in views.iter_mut().enumerate() {
            let (right, down) = (number & 1, number >> 1);
            for lane in 0..LANES {
                let (x, y) = (at[0][lane] - right as f32, at[1][lane] - down as f32);
                view.row[lane] = rays.slab[lane] * st + low[1][lane] + down as u32;
                view.view[lane] += right as u32;
                view.share[lane] = (1.0 - x.abs()) * (1.0 - y.abs());
                view.shift[0][lane] = x * aspect[0][lane];
                view.shift[1][lane] = y * aspect[1][lane];
            }
        }
        views
    }

    /// The radiance along sharp rays; black where no slab holds one.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn sharp<'a, const LANES: usize>(
        &self,
        row: impl Fn(u32) -> RowView<'a>,
        points: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> Vec3Lanes<LANES> {
        let rays = self.layout.locate(points, directions);
        let mut views = self.views(&rays);
        self.find(&row, &rays, &mut views);
        let mut scale = [0.0; LANES];
        for lane in 0..LANES {
            let total = views[0].share[lane] + views[1].share[lane] + views[2].share[lane] + views[3].share[lane];
            scale[lane] = rays.held[lane] / total;
        }
        let mut sum = Vec3Lanes::ZERO;
        for view in &views {
            let mut weight = view.share;
            for lane in 0..LANES {
                weight[lane] *= scale[lane];
            }
            self.add(&row, view, &view.slope(&rays), 0, &weight, &mut sum);
        }
        restored_sum(sum)
    }

    /// Adds the radiance of a view at slopes, bilinear in a level, by weights, to a sum for [`restored_sum`].
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn add<'a, const LANES: usize>(
        &self,
        row: impl Fn(u32) -> RowView<'a>,
        view: &Nearby<LANES>,
        slope: &[Lanes<LANES>; 2],
        level: usize,
        weight: &Lanes<LANES>,
        sum: &mut Vec3Lanes<LANES>,
    ) {
        let Some(&(first, side)) = self.form.levels.levels.get(level) else { return };
        // The coarsest level has one pixel a side.
        let (right, down) = if side > 1 { (1, side as usize) } else { (0, 0) };
        let last = (side - 1) as f32;
        let most_low = side.saturating_sub(2) as f32;
        // The offset is in pixels of the finest level from its first corner, then in pixels of this level.
        let shrunk = 1.0 / (1u32 << level) as f32;
        let per_pixel = shrunk / self.layout.pixel();
        let offset = STEEPEST * per_pixel + 0.5 * shrunk - 0.5;
        let mut blend = *slope;
        let (mut texel, mut lows) = ([0; LANES], [[0; 2]; LANES]);
        for lane in 0..LANES {
            let mut low = [0.0; 2];
            for k in 0..2 {
                let at = (slope[k][lane] * per_pixel + offset).clamp(0.0, last);
                low[k] = at.floor().min(most_low);
                blend[k][lane] = at - low[k];
            }
            lows[lane] = low.map(whole);
            texel[lane] = view.view[lane] * self.form.levels.count + first + lows[lane][1] * side + lows[lane][0];
        }
        let mut texels = [[0; LANES]; 4];
        let is_plain = self.form.compression == Compression::None;
        for lane in 0..LANES {
            if !is_plain {
                let four = self.form.four_of_blocks(&row(view.row[lane]), view.view[lane], level, lows[lane]);
                texels.iter_mut().zip(four).for_each(|(texels, one)| texels[lane] = one);
                continue;
            }
            let low = texel[lane] as usize;
            let Some(window) = row(view.row[lane]).texels.get(low..low + down + right + 1) else { continue };
            texels[0][lane] = window[0];
            texels[1][lane] = window[right];
            texels[2][lane] = window[down];
            texels[3][lane] = window[down + right];
        }
        for (corner, texels) in texels.iter().enumerate() {
            let mut factor = [0.0; LANES];
            for lane in 0..LANES {
                let (x, y) = (blend[0][lane], blend[1][lane]);
                let across = if corner & 1 == 0 { 1.0 - x } else { x };
                let along = if corner & 2 == 0 { 1.0 - y } else { y };
                factor[lane] = weight[lane] * across * along * scale(texels[lane]);
            }
            for (sum, mask) in sum.iter_mut().zip(MASKS) {
                for lane in 0..LANES {
                    sum[lane] += (texels[lane] & mask) as i32 as f32 * factor[lane];
                }
            }
        }
    }
}

/// The radiance of a sum of mantissas that were left where they are in packed numbers.
#[inline(always)] // for the instructions of its caller
pub(crate) fn restored_sum<const LANES: usize>(mut sum: Vec3Lanes<LANES>) -> Vec3Lanes<LANES> {
    for (sum, shifted) in sum.iter_mut().zip(SHIFTED) {
        *sum *= shifted;
    }
    sum
}

/// The radiance along many sharp rays.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(crate) fn sharp_rays(
    fetch: &Fetch,
    rows: &[RowView<'_>],
    points: &[Vec3],
    directions: &[Vec3],
    radiance: &mut [Vec3],
) {
    let row = |number: u32| rows.get(number as usize).copied().unwrap_or_default();
    let count = points.len().min(directions.len()).min(radiance.len());
    let (points, last_points) = points[..count].as_chunks::<MANY_LANES>();
    let (directions, last_directions) = directions[..count].as_chunks::<MANY_LANES>();
    let (radiance, last_radiance) = radiance[..count].as_chunks_mut::<MANY_LANES>();
    for (radiance, (points, directions)) in radiance.iter_mut().zip(points.iter().zip(directions)) {
        let found = fetch.sharp(row, &Vec3Lanes::new(points), &Vec3Lanes::new(directions));
        radiance.iter_mut().enumerate().for_each(|(lane, radiance)| *radiance = found.vector(lane));
    }
    if !last_radiance.is_empty() {
        let (mut points, mut directions) = ([Vec3::ZERO; MANY_LANES], [Vec3::ZERO; MANY_LANES]);
        let mut radiance = [Vec3::ZERO; MANY_LANES];
        points[..last_points.len()].copy_from_slice(last_points);
        directions[..last_directions.len()].copy_from_slice(last_directions);
        sharp_rays(fetch, rows, &points, &directions, &mut radiance);
        last_radiance.copy_from_slice(&radiance[..last_radiance.len()]);
    }
}
