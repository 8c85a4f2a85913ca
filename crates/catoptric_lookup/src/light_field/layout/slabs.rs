//! Six slabs about a region: which ray is where in which of them (Yu, Yang, McMillan 2005, sections 3 and 5).

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use glam::{Vec2, Vec3};

/// Views see a little more than is asked of them, so that a neighbour's pixel exists for near surfaces, which appear
/// shifted in it: slopes up to this. Chosen, not measured.
pub(crate) const STEEPEST: f32 = 1.0625;

/// Slabs, in the order +x, -x, +y, -y, +z, -z of the directions that they hold.
pub const SLABS: usize = 6;

/// A slab: a plane of views (st) on a face of the region, that look out of it along an axis.
///
/// With half the field of view `theta = pi / 4` a ray that leaves the region within `pi / 4` of the axis, by direction
/// component, meets the face's plane no further beside the face than the region is deep: for a cube of side l the plane
/// of views has side 3l (section 5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// The axis along which it looks.
    pub axis: usize,
    /// 1 where it looks along the axis, -1 where against.
    pub sign: f32,
    /// The plane of the views: this coordinate along the axis.
    pub plane: f32,
    /// The other two coordinates of the first view.
    pub low: Vec2,
    /// Steps from view to view, one over them, and as shares of the longer.
    pub spacing: Vec2,
    per_step: Vec2,
    pub(crate) aspect: Vec2,
    /// The parallax of its focal plane, from view to view along the longer spacing.
    pub focal: f32,
}

/// Rays in slabs, side by side, component by component: the compiler makes vector instructions of loops over them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabRays<const LANES: usize> {
    /// 1 where a slab holds the ray; else 0, and the rest means nothing, but is finite.
    pub held: Lanes<LANES>,
    /// The number of the slab.
    pub slab: [u32; LANES],
    /// Intersection with the plane of views, in views from the first.
    pub st: [Lanes<LANES>; 2],
    /// The slope of the direction: steps along the other axes for a step along the slab's.
    pub slope: [Lanes<LANES>; 2],
    /// The distance along the axis from the point that was given to the plane.
    pub(crate) ahead: Lanes<LANES>,
}

/// The slabs about a region.
#[derive(Clone, Debug, PartialEq)]
pub struct SlabLayout {
    /// The region.
    pub region: Aabb,
    /// Views a side of a slab.
    pub(crate) st: u32,
    /// Pixels a side of a view.
    pub(crate) uv: u32,
    /// The slabs of +x, -x, +y, -y, +z and -z.
    pub slabs: [Slab; SLABS],
}

/// The two coordinates across an axis.
#[inline]
pub fn across(axis: usize, of: Vec3) -> Vec2 {
    match axis {
        0 => Vec2::new(of.y, of.z),
        1 => Vec2::new(of.z, of.x),
        _ => Vec2::new(of.x, of.y),
    }
}

/// The vector with a coordinate along an axis and two across it.
#[inline]
pub fn along(axis: usize, value: f32, across: Vec2) -> Vec3 {
    match axis {
        0 => Vec3::new(value, across.x, across.y),
        1 => Vec3::new(across.y, value, across.x),
        _ => Vec3::new(across.x, across.y, value),
    }
}

impl<const LANES: usize> Default for SlabRays<LANES> {
    fn default() -> Self {
        let (none, two) = (Lanes::ZERO, [Lanes::ZERO; 2]);
        Self { held: none, slab: [0; LANES], st: two, slope: two, ahead: none }
    }
}

/// All bits if `holds`, else none: masks choose values without a branch.
#[inline(always)] // for the instructions of its caller
pub(crate) fn bits(holds: bool) -> u32 {
    u32::from(holds).wrapping_neg()
}

/// The component of vectors whose bits are set.
#[inline(always)] // for the instructions of its caller
fn chosen<const LANES: usize>(axis: &[[u32; LANES]; 3], of: [&Lanes<LANES>; 3]) -> Lanes<LANES> {
    let mut value = [0; LANES];
    for k in 0..3 {
        for lane in 0..LANES {
            value[lane] |= of[k][lane].to_bits() & axis[k][lane];
        }
    }
    let mut chosen = Lanes::ZERO;
    for lane in 0..LANES {
        chosen[lane] = f32::from_bits(value[lane]);
    }
    chosen
}

impl Slab {
    fn new(index: usize, region: &Aabb, st: u32) -> Self {
        let axis = index / 2;
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let plane = if sign > 0.0 { region.max[axis] } else { region.min[axis] };
        let depth = region.size()[axis];
        let low = across(axis, region.min) - depth;
        let spacing = (across(axis, region.max) + depth - low) / (st - 1) as f32;
        let aspect = spacing / spacing.max_element();
        Self { axis, sign, plane, low, spacing, per_step: 1.0 / spacing, aspect, focal: 0.0 }
    }

    /// Position of a view, in world space.
    pub fn eye(&self, s: u32, t: u32) -> Vec3 {
        along(self.axis, self.plane, self.low + self.spacing * Vec2::new(s as f32, t as f32))
    }

    /// The direction with a slope, as long as it is along the axis 1.
    pub fn direction(&self, slope: Vec2) -> Vec3 {
        along(self.axis, self.sign, slope)
    }

    /// The distance before the plane of views, along the axis, at which the ray through a place of it leaves the
    /// region: 0 if it leaves through that plane. For rays that miss the region, where they are about nearest to it.
    pub fn exit(&self, region: &Aabb, eye: Vec3, slope: Vec2) -> f32 {
        let depth = region.size()[self.axis];
        let (low, high, at) = (across(self.axis, region.min), across(self.axis, region.max), across(self.axis, eye));
        // The ray is at `at - slope back` at a distance `back` before the plane.
        let enter = |at: f32, slope: f32, low: f32, high: f32| {
            if at > high && slope > 0.0 {
                (at - high) / slope
            } else if at < low && slope < 0.0 {
                (at - low) / slope
            } else {
                0.0
            }
        };
        enter(at.x, slope.x, low.x, high.x).max(enter(at.y, slope.y, low.y, high.y)).clamp(0.0, depth)
    }

    /// The distance before the plane of views, along the axis, at which a ray is nearest to the middle of the region,
    /// on its way through that; for rays that miss it, [`Self::exit`].
    pub fn nearest(&self, region: &Aabb, eye: Vec3, slope: Vec2) -> f32 {
        let long = self.direction(slope);
        let (one, other) = ((eye - region.min) / long, (eye - region.max) / long);
        // Axes that the ray is across are at both infinities, or no numbers where it runs along a side.
        let (out, entry) = (one.min(other).max_element(), one.max(other).min_element());
        if !(out <= entry && entry.is_finite()) {
            return self.exit(region, eye, slope);
        }
        let nearest = (eye - region.center()).dot(long) / long.length_squared();
        nearest.clamp(out, entry).max(0.0)
    }
}

impl SlabLayout {
    /// About a region with a size along all axes; `st` is at least 2.
    pub fn new(region: Aabb, st: u32, uv: u32) -> Self {
        Self { region, st, uv, slabs: [0, 1, 2, 3, 4, 5].map(|index| Slab::new(index, &region, st)) }
    }

    /// The rays from points, where slabs hold them: all from points of the region are held. The largest component of
    /// the direction chooses the slab (section 5).
    #[inline(always)] // for the instructions of its caller
    pub fn locate<const LANES: usize>(
        &self,
        points: &Vec3Lanes<LANES>,
        directions: &Vec3Lanes<LANES>,
    ) -> SlabRays<LANES> {
        let mut axis = [[0; LANES]; 3];
        for lane in 0..LANES {
            let (x, y, z) = (directions[0][lane].abs(), directions[1][lane].abs(), directions[2][lane].abs());
            axis[0][lane] = bits(x >= y) & bits(x >= z);
            axis[1][lane] = !axis[0][lane] & bits(y >= z);
            axis[2][lane] = !axis[0][lane] & !axis[1][lane];
        }
        let along = |of: &Vec3Lanes<LANES>, first: usize| {
            chosen(&axis, [&of[first % 3], &of[(first + 1) % 3], &of[(first + 2) % 3]])
        };
        let (forward, place) = (along(directions, 0), along(points, 0));
        let mut rays = SlabRays::default();
        let mut per_forward = [0.0; LANES];
        for lane in 0..LANES {
            rays.slab[lane] = (axis[1][lane] & 2) | (axis[2][lane] & 4) | (bits(forward[lane] < 0.0) & 1);
        }
        let (plane, sign) = (self.each(&rays.slab, |slab| slab.plane), self.each(&rays.slab, |slab| slab.sign));
        let low = [self.each(&rays.slab, |slab| slab.low.x), self.each(&rays.slab, |slab| slab.low.y)];
        let per_step = [self.each(&rays.slab, |slab| slab.per_step.x), self.each(&rays.slab, |slab| slab.per_step.y)];
        for lane in 0..LANES {
            rays.ahead[lane] = (plane[lane] - place[lane]) * sign[lane];
            per_forward[lane] = 1.0 / forward[lane].abs();
        }
        let (last, rounding) = ((self.st - 1) as f32, 1e-3);
        let mut held = [u32::MAX; LANES];
        for k in 0..2 {
            // These are the same axes as in `across`.
            let (turn, place) = (along(directions, k + 1), along(points, k + 1));
            for lane in 0..LANES {
                rays.slope[k][lane] = turn[lane] * per_forward[lane];
                let meets = place[lane] + rays.slope[k][lane] * rays.ahead[lane];
                let st = (meets - low[k][lane]) * per_step[k][lane];
                // Values that are not numbers are not held.
                held[lane] &= bits(st >= -rounding) & bits(st <= last + rounding);
                rays.st[k][lane] = st.clamp(0.0, last);
            }
        }
        for lane in 0..LANES {
            let only = |value: f32| f32::from_bits(value.to_bits() & held[lane]);
            rays.held[lane] = only(1.0);
            for k in 0..2 {
                rays.slope[k][lane] = only(rays.slope[k][lane]);
                rays.st[k][lane] = only(rays.st[k][lane]);
            }
        }
        rays
    }

    /// A number of each slab of several.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn each<const LANES: usize>(&self, slabs: &[u32; LANES], number: impl Fn(&Slab) -> f32) -> Lanes<LANES> {
        let mut value = [0; LANES];
        for (slab, of) in self.slabs.iter().enumerate() {
            let number = number(of).to_bits();
            for lane in 0..LANES {
                value[lane] |= number & bits(slabs[lane] == slab as u32);
            }
        }
        let mut each = Lanes::ZERO;
        for lane in 0..LANES {
            each[lane] = f32::from_bits(value[lane]);
        }
        each
    }

    /// The step of slopes from pixel to pixel of a view.
    #[inline]
    pub(crate) fn pixel(&self) -> f32 {
        2.0 * STEEPEST / (self.uv - 1) as f32
    }

    /// The slope of a pixel; the outermost pixels' middles lie on the border of a view's field.
    pub(crate) fn slope_of(&self, u: f32, v: f32) -> Vec2 {
        Vec2::new(u, v) * self.pixel() - STEEPEST
    }

    /// The pixel of a slope.
    pub(crate) fn place_of(&self, slope: Vec2) -> Vec2 {
        (slope + STEEPEST) / self.pixel()
    }
}
