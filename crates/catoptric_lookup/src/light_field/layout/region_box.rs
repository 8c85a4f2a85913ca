//! Rays by where they leave the region's box, and by their direction.

use super::hemi_octahedron;
use super::slabs::{across, along};
use catoptric_core::math::Aabb;
use glam::{Vec2, Vec3};

/// Sides of a box, in the order +x, -x, +y, -y, +z, -z.
const SIDES: usize = 6;

/// The least views along an axis.
const LEAST: u32 = 2;

/// A share of a region's size that is no more than rounding. Chosen well above rounding, not measured.
const ROUNDING: f32 = 1e-3;

/// A side of the box: views that look out of it, over half of all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxSide {
    /// The axis along which it looks.
    pub axis: usize,
    /// 1 where it looks along the axis, -1 where against.
    pub(crate) sign: f32,
    /// The side's coordinate along the axis.
    pub plane: f32,
    /// The other two coordinates of the first view, in a corner of the side; the last one is in the opposite corner.
    pub low: Vec2,
    /// Steps from view to view, and one over them.
    pub spacing: Vec2,
    per_step: Vec2,
    /// Views along both, at least 2.
    pub counts: [u32; 2],
    /// The number of its first row of views.
    pub(crate) first_row: u32,
    /// The parallax of its focal plane: [`BoxLayout::unit`] by its distance from the side.
    pub(crate) focal: f32,
}

/// A ray where it leaves the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxRay {
    /// The side that it leaves by.
    pub side: usize,
    /// The place on the side, in views from the first.
    pub st: Vec2,
    /// The direction, x and y across the side's axis and z along it; the sum of their sizes is 1.
    pub direction: Vec3,
    /// The distance of that place from the point that was given, in scene units.
    pub ahead: f32,
}

/// The views about a region.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxLayout {
    /// The region.
    pub region: Aabb,
    /// Pixels a side of a view.
    pub(crate) uv: u32,
    /// The views of every side.
    pub sides: [BoxSide; SIDES],
    /// The longest step from view to view: parallaxes are this by a distance.
    pub(crate) unit: f32,
}

impl BoxSide {
    fn new(index: usize, region: &Aabb, counts: [u32; 3], first_row: u32) -> Self {
        let axis = index / 2;
        let sign = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        let plane = if sign > 0.0 { region.max[axis] } else { region.min[axis] };
        let of_axes = across(axis, Vec3::from(counts.map(|count| count as f32)));
        let (low, size) = (across(axis, region.min), across(axis, region.size()));
        let spacing = size / (of_axes - 1.0);
        let counts = of_axes.to_array().map(|count| count as u32);
        Self { axis, sign, plane, low, spacing, per_step: 1.0 / spacing, counts, first_row, focal: 0.0 }
    }

    /// Position of a view, in world space.
    pub fn eye(&self, s: u32, t: u32) -> Vec3 {
        along(self.axis, self.plane, self.low + self.spacing * Vec2::new(s as f32, t as f32))
    }

    /// A direction across and along the side's axis, in world space.
    pub fn in_world(&self, direction: Vec3) -> Vec3 {
        along(self.axis, direction.z * self.sign, direction.truncate())
    }

    /// A direction of world space across and along the side's axis.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn of_side(&self, direction: Vec3) -> Vec3 {
        across(self.axis, direction).extend(direction[self.axis] * self.sign)
    }
}

impl BoxLayout {
    /// About a region with a size along all axes, with about as many views as slabs of `st` x `st` have, never more:
    /// as many a length everywhere, but two along each edge at least; `st` is at least 2.
    pub fn new(region: Aabb, st: u32, uv: u32) -> Self {
        let counts = counts(region.size(), st);
        let mut sides = [0, 1, 2, 3, 4, 5].map(|index| BoxSide::new(index, &region, counts, 0));
        let mut rows = 0;
        for side in &mut sides {
            side.first_row = rows;
            rows += side.counts[1];
        }
        let unit = sides.iter().map(|side| side.spacing.max_element()).fold(0.0, f32::max);
        Self { region, uv, sides, unit }
    }

    pub(crate) fn row_count(&self) -> u32 {
        self.sides.iter().map(|side| side.counts[1]).sum()
    }

    /// Views of all sides.
    pub(crate) fn view_count(&self) -> u64 {
        self.sides.iter().map(|side| u64::from(side.counts[0]) * u64::from(side.counts[1])).sum()
    }

    /// The place where the ray from a point leaves the box; `None` for rays that miss it, or begin beyond it. All rays
    /// from points of the region leave it.
    #[inline(always)] // for the instructions of its caller
    pub fn locate(&self, point: Vec3, direction: Vec3) -> Option<BoxRay> {
        let size = direction.abs().element_sum();
        if !(size > 0.0 && size.is_finite() && point.is_finite()) {
            return None;
        }
        let per = direction.recip();
        let Aabb { min, max } = self.region;
        let (mut out, mut axis, mut entry) = (f32::INFINITY, 0, f32::NEG_INFINITY);
        for k in 0..3 {
            let (one, other) = ((min[k] - point[k]) * per[k], (max[k] - point[k]) * per[k]);
            let (near, far) = if direction[k] == 0.0 {
                // Along the side: within it or not.
                let slack = ROUNDING * (max[k] - min[k]);
                let within = point[k] >= min[k] - slack && point[k] <= max[k] + slack;
                if within { (f32::NEG_INFINITY, f32::INFINITY) } else { return None }
            } else {
                (one.min(other), one.max(other))
            };
            entry = entry.max(near);
            if far < out {
                (out, axis) = (far, k);
            }
        }
        let slack = ROUNDING * self.region.diagonal() / size;
        if !(entry <= out + slack && out >= -slack && out.is_finite()) {
            return None;
        }
        let index = 2 * axis + usize::from(direction[axis] < 0.0);
        let side = &self.sides[index];
        let last = Vec2::new((side.counts[0] - 1) as f32, (side.counts[1] - 1) as f32);
        let st = ((across(axis, point + direction * out) - side.low) * side.per_step).clamp(Vec2::ZERO, last);
        Some(BoxRay { side: index, st, direction: side.of_side(direction) / size, ahead: out * direction.length() })
    }

    /// The direction of a place of a view, in pixels from the corner of the first; places beside the view are moved to
    /// its border.
    pub fn direction_of(&self, pixel: Vec2) -> Vec3 {
        let place = (pixel * (2.0 / self.uv as f32) - 1.0).clamp(Vec2::NEG_ONE, Vec2::ONE);
        hemi_octahedron::direction(place)
    }

    /// The place of a direction in a view, in pixels from the corner of the first.
    #[inline(always)] // for the instructions of its caller
    pub fn pixel_of(&self, direction: Vec3) -> Vec2 {
        (hemi_octahedron::place(direction) + 1.0) * (0.5 * self.uv as f32)
    }
}

/// Views along all axes: one more than steps of one length, of 6 `st` x `st` views at most.
fn counts(size: Vec3, st: u32) -> [u32; 3] {
    let most = 6 * u64::from(st) * u64::from(st);
    let of = |step: f32| size.to_array().map(|size| ((size / step) as u32).saturating_add(1).clamp(LEAST, 2 * st * st));
    let total = |[x, y, z]: [u32; 3]| {
        let [x, y, z] = [x, y, z].map(u64::from);
        2 * (x * y + y * z + z * x)
    };
    // A step as long as this always gives few enough views.
    let (mut short, mut long) = (0.0, 2.0 * size.max_element());
    for _ in 0..40 {
        let middle = 0.5 * (short + long);
        if middle > 0.0 && total(of(middle)) <= most { long = middle } else { short = middle }
    }
    of(long)
}
