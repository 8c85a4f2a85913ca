//! Parallax of the surfaces in each of the four views about a ray.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::fetch::{Fetch, Nearby};
use super::form::RowView;
use super::texels::restored;
use crate::light_field::layout::{STEEPEST, SlabRays, bits};
use crate::light_field::settings::{Compression, Disparity};
use catoptric_core::math::lanes::{Lanes, whole};

/// Steps by which a view finds the surface that a ray meets. A search with twenty times the steps has 2 %
/// (`sphere_room`) and 5 % (`teapot`) less mean error.
const STEPS: u32 = 4;

/// A parallax above all others: surfaces before the plane of views have one below 0, and are nearer than all beyond.
const BEFORE: f32 = 100.0;

/// The greatest distance of the surface in a view's pixel from the ray, in pixels, at which the view counts as seeing
/// the ray's surface. Chosen, not measured.
const AGREES_PX: f32 = 1.0;

impl Fetch {
    /// Sets the parallax by which each view finds the ray's surface, and the views' shares (equation 6 with a parallax
    /// for each view), where depth is asked for.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn find<'a, const LANES: usize>(
        &self,
        row: impl Fn(u32) -> RowView<'a>,
        rays: &SlabRays<LANES>,
        views: &mut [Nearby<LANES>; 4],
    ) {
        if self.disparity != Disparity::Depth {
            return;
        }
        let per_pixel = 1.0 / self.layout.pixel();
        let mut agree = [[0; LANES]; 4];
        for (view, agree) in views.iter_mut().zip(&mut agree) {
            let mut length = [0.0; LANES];
            for lane in 0..LANES {
                let (x, y) = (view.shift[0][lane], view.shift[1][lane]);
                length[lane] = (x * x + y * y).sqrt() * per_pixel;
            }
            let mut off = [f32::INFINITY; LANES];
            for _ in 0..STEPS {
                let seen = self.parallax_at(&row, view, &view.slope(rays));
                let mut found = u32::MAX;
                for lane in 0..LANES {
                    // Found lanes stay.
                    let stays = bits(off[lane] < 0.25 * AGREES_PX);
                    let step = length[lane] * (seen[lane] - view.parallax[lane]).abs();
                    off[lane] = either(stays, off[lane], step);
                    view.parallax[lane] = either(stays, view.parallax[lane], seen[lane]);
                    found &= bits(off[lane] < 0.25 * AGREES_PX);
                }
                if found != 0 {
                    break;
                }
            }
            let slope = view.slope(rays);
            for lane in 0..LANES {
                let seen = bits(slope[0][lane].abs() <= STEEPEST) & bits(slope[1][lane].abs() <= STEEPEST);
                agree[lane] = seen & bits(off[lane] < AGREES_PX) & bits(view.share[lane] > 0.0);
            }
        }
        // The nearest one of several surfaces on the ray hides the others.
        let mut nearest = [0.0; LANES];
        let mut nearness = [f32::NEG_INFINITY; LANES];
        for (view, agree) in views.iter().zip(&agree) {
            for lane in 0..LANES {
                let parallax = view.parallax[lane];
                let before = f32::from_bits(BEFORE.to_bits() & bits(parallax < 0.0));
                let nearer = agree[lane] & bits(parallax + before > nearness[lane]);
                nearest[lane] = either(nearer, parallax, nearest[lane]);
                nearness[lane] = either(nearer, parallax + before, nearness[lane]);
            }
        }
        for (view, agree) in views.iter_mut().zip(&agree) {
            for lane in 0..LANES {
                let apart = (view.parallax[lane] - nearest[lane]).abs() * per_pixel;
                let agrees = f32::from_bits((2.0 * AGREES_PX - apart).clamp(0.0, 1.0).to_bits() & agree[lane]);
                // If no view has the ray's surface all of them count.
                view.share[lane] *= either(bits(nearness[lane] > f32::NEG_INFINITY), agrees, 1.0);
            }
        }
    }

    /// The parallax of the pixels of a view nearest to slopes.
    #[inline(always)] // for the instructions of its caller
    fn parallax_at<'a, const LANES: usize>(
        &self,
        row: impl Fn(u32) -> RowView<'a>,
        view: &Nearby<LANES>,
        slope: &[Lanes<LANES>; 2],
    ) -> Lanes<LANES> {
        let (side, last) = (self.layout.uv, (self.layout.uv - 1) as f32);
        let per_pixel = 1.0 / self.layout.pixel();
        let offset = STEEPEST * per_pixel + 0.5;
        let (mut pixel, mut at) = ([0; LANES], [[0; 2]; LANES]);
        for lane in 0..LANES {
            let x = (slope[0][lane] * per_pixel + offset).floor().clamp(0.0, last);
            let y = (slope[1][lane] * per_pixel + offset).floor().clamp(0.0, last);
            at[lane] = [whole(x), whole(y)];
            pixel[lane] = (view.view[lane] * side + at[lane][1]) * side + at[lane][0];
        }
        let mut stored = [0; LANES];
        let is_plain = self.form.compression == Compression::None;
        for lane in 0..LANES {
            let row = row(view.row[lane]);
            if !is_plain {
                stored[lane] = self.form.parallax(&row, view.view[lane], at[lane][0], at[lane][1]);
                continue;
            }
            stored[lane] = row.parallax.get(pixel[lane] as usize).copied().unwrap_or_default();
        }
        let mut found = Lanes::ZERO;
        for lane in 0..LANES {
            found[lane] = restored(stored[lane]);
        }
        found
    }
}

/// The first number if all bits are set, the second if none is.
#[inline(always)] // for the instructions of its caller
fn either(first: u32, one: f32, other: f32) -> f32 {
    f32::from_bits((one.to_bits() & first) | (other.to_bits() & !first))
}
