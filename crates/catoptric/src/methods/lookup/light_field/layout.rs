//! Six slabs about a region: which ray is where in which of them (Yu, Yang, McMillan 2005, sections 3 and 5).

use crate::math::Aabb;
use glam::{Vec2, Vec3};

/// Views see a little more than is asked of them, so that a neighbour's pixel is there when what is near appears shifted
/// in it: slopes up to this.
pub(super) const STEEPEST: f32 = 1.0625;

/// Slabs, in the order +x, -x, +y, -y, +z, -z of the directions that they hold.
pub(super) const SLABS: usize = 6;

/// One slab: a plane of views (st) on a face of the region, that look out of it along an axis.
///
/// With half the field of view `theta = pi / 4` a ray that leaves the region within `pi / 4` of the axis, by direction
/// component, meets the face's plane no further beside the face than the region is deep: for a cube of side l the plane of
/// views has side 3l (section 5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slab {
    /// The axis along which it looks.
    pub(super) axis: usize,
    /// 1 where it looks along the axis, -1 where against.
    pub(super) sign: f32,
    /// The plane of the views: this coordinate along the axis.
    plane: f32,
    /// The other two coordinates of the first view.
    low: Vec2,
    /// Steps from view to view.
    pub(super) spacing: Vec2,
}

/// A ray in a slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlabRay {
    pub(super) slab: usize,
    /// Where it meets the plane of views, in views from the first.
    pub(super) st: Vec2,
    /// Its direction: steps along the other axes a step along the slab's.
    pub(super) slope: Vec2,
    /// How far along the axis the plane lies ahead of the point that it was asked for.
    pub(super) ahead: f32,
}

/// The slabs about a region.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) region: Aabb,
    /// Views a side of a slab.
    pub(super) st: u32,
    /// Pixels a side of a view.
    pub(super) uv: u32,
    pub(super) slabs: [Slab; SLABS],
}

/// The two coordinates across an axis.
#[inline]
pub(super) fn across(axis: usize, of: Vec3) -> Vec2 {
    match axis {
        0 => Vec2::new(of.y, of.z),
        1 => Vec2::new(of.z, of.x),
        _ => Vec2::new(of.x, of.y),
    }
}

/// The vector with a coordinate along an axis and two across it.
#[inline]
pub(super) fn along(axis: usize, value: f32, across: Vec2) -> Vec3 {
    match axis {
        0 => Vec3::new(value, across.x, across.y),
        1 => Vec3::new(across.y, value, across.x),
        _ => Vec3::new(across.x, across.y, value),
    }
}

impl Slab {
    fn new(index: usize, region: &Aabb, st: u32) -> Self {
        let axis = index / 2;
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let plane = if sign > 0.0 { region.max[axis] } else { region.min[axis] };
        let depth = region.size()[axis];
        let low = across(axis, region.min) - depth;
        let spacing = (across(axis, region.max) + depth - low) / (st - 1) as f32;
        Self { axis, sign, plane, low, spacing }
    }

    /// Where a view is, in the world.
    pub(super) fn eye(&self, s: u32, t: u32) -> Vec3 {
        along(self.axis, self.plane, self.low + self.spacing * Vec2::new(s as f32, t as f32))
    }

    /// The direction with a slope, as long as it is along the axis 1.
    pub(super) fn direction(&self, slope: Vec2) -> Vec3 {
        along(self.axis, self.sign, slope)
    }

    /// How far before the plane of views, along the axis, the ray through a place of it leaves the region: 0 where it
    /// leaves by that plane. Of rays that miss the region, where they are about nearest to it.
    pub(super) fn exit(&self, region: &Aabb, eye: Vec3, slope: Vec2) -> f32 {
        let depth = region.size()[self.axis];
        let (low, high, at) = (across(self.axis, region.min), across(self.axis, region.max), across(self.axis, eye));
        // At a distance `back` before the plane the ray is at `at - slope back`.
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

    /// How far before the plane of views, along the axis, a ray is where it is nearest to the middle of the region, on its way
    /// through that; of rays that miss it, [`Self::exit`].
    pub(super) fn nearest(&self, region: &Aabb, eye: Vec3, slope: Vec2) -> f32 {
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

    /// The ray through a point, in views and slopes; its direction must look along the slab's axis.
    #[inline]
    fn ray(&self, point: Vec3, direction: Vec3) -> (Vec2, Vec2, f32) {
        let slope = across(self.axis, direction) / direction[self.axis].abs();
        let ahead = (self.plane - point[self.axis]) * self.sign;
        let meets = across(self.axis, point) + slope * ahead;
        ((meets - self.low) / self.spacing, slope, ahead)
    }
}

impl Layout {
    /// About a region with a size along all axes; `st` is at least 2.
    pub(super) fn new(region: Aabb, st: u32, uv: u32) -> Self {
        Self { region, st, uv, slabs: [0, 1, 2, 3, 4, 5].map(|index| Slab::new(index, &region, st)) }
    }

    /// The ray from a point, where slabs hold it: all from points of the region are held. The largest component of the
    /// direction chooses the slab (section 5).
    #[inline]
    pub(super) fn locate(&self, point: Vec3, direction: Vec3) -> Option<SlabRay> {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let slab = 2 * axis + usize::from(direction[axis] < 0.0);
        let (st, slope, ahead) = self.slabs[slab].ray(point, direction);
        let (last, rounding) = ((self.st - 1) as f32, 1e-3);
        let held = st.min_element() >= -rounding && st.max_element() <= last + rounding;
        // Also what is not a number.
        held.then(|| SlabRay { slab, st: st.clamp(Vec2::ZERO, Vec2::splat(last)), slope, ahead })
    }

    /// The step of slopes from pixel to pixel of a view.
    #[inline]
    pub(super) fn pixel(&self) -> f32 {
        2.0 * STEEPEST / (self.uv - 1) as f32
    }

    /// The slope of a pixel; the outermost pixels' middles lie on the border of what a view sees.
    pub(super) fn slope_of(&self, u: f32, v: f32) -> Vec2 {
        Vec2::new(u, v) * self.pixel() - STEEPEST
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    fn vector(random: &mut Stream) -> Vec3 {
        Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0)))
    }

    /// All rays of a box that is no cube, in ten million tries in release.
    #[test]
    fn every_ray_through_the_region_is_in_a_slab() {
        let region = Aabb { min: Vec3::new(-1.0, 0.5, -0.2), max: Vec3::new(0.5, 1.0, 2.0) };
        let layout = Layout::new(region, 9, 16);
        let mut random = Stream::new(17);
        let count = if cfg!(debug_assertions) { 200_000 } else { 10_000_000 };
        for _ in 0..count {
            let point = region.center() + region.size() * 0.5 * vector(&mut random);
            let direction = vector(&mut random);
            let found = layout.locate(point, direction);
            let found = found.unwrap_or_else(|| panic!("{point} {direction} is not held"));
            assert!(found.slope.abs().max_element() <= 1.0);
            // It is that ray: the point lies on the line through the place of the plane with that slope.
            let slab = &layout.slabs[found.slab];
            let on_plane = along(slab.axis, slab.plane, slab.low + slab.spacing * found.st);
            let back = slab.direction(found.slope);
            let to_point = point - on_plane;
            let off = to_point - back * (to_point.dot(back) / back.length_squared());
            assert!(off.length() < 1e-4 && back.dot(direction) > 0.0, "{point} {direction}: {off}");
        }
    }

    #[test]
    fn a_cube_has_views_over_three_times_its_side() {
        let layout = Layout::new(Aabb { min: Vec3::ZERO, max: Vec3::splat(2.0) }, 4, 8);
        for slab in &layout.slabs {
            assert_eq!(slab.spacing * 3.0, Vec2::splat(6.0));
        }
    }

    #[test]
    fn rays_leave_the_region_and_are_nearest_to_its_middle() {
        let region = Aabb { min: Vec3::new(-1.0, -0.5, -0.25), max: Vec3::new(1.0, 0.5, 0.25) };
        let layout = Layout::new(region, 5, 8);
        let mut random = Stream::new(5);
        for _ in 0..2000 {
            let point = region.center() + region.size() * 0.5 * vector(&mut random);
            let direction = vector(&mut random).normalize();
            let Some(found) = layout.locate(point, direction) else { panic!("{point} {direction}") };
            let slab = &layout.slabs[found.slab];
            let eye = along(slab.axis, slab.plane, slab.low + slab.spacing * found.st);
            let start = eye - slab.direction(found.slope) * slab.exit(&region, eye, found.slope);
            // On the region's surface, and not before the point.
            let outside = |place: Vec3| (region.min - place).max(place - region.max).max_element();
            assert!(outside(start).abs() < 1e-4, "{start} is {} outside", outside(start));
            assert!((start - point).dot(direction) > -1e-4);
            let start = eye - slab.direction(found.slope) * slab.nearest(&region, eye, found.slope);
            assert!(outside(start) < 1e-4, "{start} is outside");
            // Nowhere in the region is the ray nearer to the middle.
            let nearer = region.center().distance(point) < region.center().distance(start) - 1e-4;
            assert!(!nearer, "{point} is nearer than {start}");
        }
    }

    #[test]
    fn rays_that_miss_the_region_or_mean_nothing_are_not_held() {
        let layout = Layout::new(Aabb { min: Vec3::ZERO, max: Vec3::ONE }, 5, 8);
        assert_eq!(layout.locate(Vec3::new(0.5, 0.5, 3.0), Vec3::new(1.0, 0.0, 0.1)), None);
        assert_eq!(layout.locate(Vec3::NAN, Vec3::X), None);
        assert_eq!(layout.locate(Vec3::splat(0.5), Vec3::ZERO), None);
    }
}
