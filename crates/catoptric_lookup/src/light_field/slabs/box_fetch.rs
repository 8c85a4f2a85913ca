//! Look-ups of one ray at a time by the place where it leaves the region's box: the views about that place, and their
//! contents.

use super::form::ViewForm;
use super::rows::Rows;
use super::texels::{restored, stored, unpacked};
use crate::light_field::layout::BoxLayout;
use crate::light_field::layout::region_box::{BoxRay, BoxSide};
use crate::light_field::settings::Disparity;
use catoptric_core::math::portable::PortableMath;
use glam::{Vec2, Vec3};

/// The largest ratio of a footprint's axes that is resolved by several look-ups. A bound on time; chosen, not measured.
const MAX_PROBES: f32 = 8.0;

/// Steps by which a view finds the surface that a ray meets.
const STEPS: u32 = 6;

/// The greatest parallax that is kept: of a surface whose distance is an eighth of the step between views.
const MAX_PARALLAX: f32 = 8.0;

/// The scale of stored parallaxes: those of slabs are kept up to 2.
const SHRUNK: f32 = 2.0 / MAX_PARALLAX;

/// A parallax above all others: surfaces before the side of the box have one below 0, and are nearer than all beyond.
const BEFORE: f32 = 100.0;

/// The greatest distance of the surface in a view's pixel from the ray, in pixels, at which the view counts as seeing
/// the ray's surface. Chosen, not measured.
const AGREES_PX: f32 = 1.0;

/// Views about a place that are asked at most: 4, and the 12 about those where none of the 4 sees the ray's surface.
const MOST_VIEWS: usize = 16;

/// A parallax as it is kept.
pub(crate) fn stored_parallax(parallax: f32) -> i16 {
    stored(parallax * SHRUNK)
}

/// The parallax that is kept so.
#[inline(always)] // for the instructions of its caller
pub(crate) fn restored_parallax(parallax: i16) -> f32 {
    restored(parallax) / SHRUNK
}

/// The greatest parallax that can be kept, by its size.
pub(crate) fn limited(parallax: f32) -> f32 {
    if parallax.is_nan() { 0.0 } else { parallax.clamp(-MAX_PARALLAX, MAX_PARALLAX) }
}

/// Look-ups of rays in the views of a region's box.
#[derive(Clone, Debug)]
pub(crate) struct BoxFetch {
    pub(crate) layout: BoxLayout,
    pub(crate) form: ViewForm,
    pub(crate) disparity: Disparity,
}

/// A view about a ray.
#[derive(Clone, Copy, Debug, Default)]
struct NearView {
    /// The number of its row, and its own in that.
    row: u32,
    view: u32,
    /// The weight in the blend.
    share: f32,
    /// The vector from the view to the place where the ray leaves the box, in [`BoxLayout::unit`]s.
    off: Vec2,
    /// The parallax of the surface that the ray meets, as this view finds it.
    parallax: f32,
    /// True if the surface that it shows lies on the ray.
    agrees: bool,
    /// True if the surface that it shows is nearer than parallaxes can tell, about at the view itself.
    touches: bool,
}

/// A ray with the views about it.
pub(crate) struct BoxLookUp<'a> {
    fetch: &'a BoxFetch,
    rows: &'a Rows,
    side: &'a BoxSide,
    pub(crate) ray: BoxRay,
    views: [NearView; MOST_VIEWS],
    count: usize,
    /// The sum of the views' shares.
    total: f32,
}

impl<'a> BoxLookUp<'a> {
    /// Returns `None` for rays that do not leave the box.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn new(fetch: &'a BoxFetch, rows: &'a Rows, point: Vec3, direction: Vec3) -> Option<Self> {
        let ray = fetch.layout.locate(point, direction)?;
        let side = &fetch.layout.sides[ray.side];
        let mut found = Self { fetch, rows, side, ray, views: [NearView::default(); MOST_VIEWS], count: 4, total: 1.0 };
        let low = found.low();
        for number in 0..4 {
            let at = low + Vec2::new((number & 1) as f32, (number >> 1) as f32);
            let near = 1.0 - (ray.st - at).abs();
            found.views[number] = found.view(at, near.x * near.y);
        }
        if fetch.disparity == Disparity::Depth {
            found.find(0);
            if !found.agree() {
                found.look_further(low);
            }
        }
        found.total = found.views[..found.count].iter().map(|view| view.share).sum();
        Some(found)
    }

    /// The first of the four views about the ray.
    #[inline(always)] // for the instructions of its caller
    fn low(&self) -> Vec2 {
        let [s, t] = self.side.counts;
        self.ray.st.floor().min(Vec2::new((s - 2) as f32, (t - 2) as f32))
    }

    #[inline(always)] // for the instructions of its caller
    fn view(&self, at: Vec2, share: f32) -> NearView {
        let off = (self.ray.st - at) * self.side.spacing / self.fetch.layout.unit;
        let (row, view) = (self.side.first_row + at.y as u32, at.x as u32);
        let parallax = self.side.focal * self.ray.direction.z;
        NearView { row, view, share, off, parallax, agrees: false, touches: false }
    }

    /// The direction in which a view has the surface that the ray meets, if that has a parallax.
    #[inline(always)] // for the instructions of its caller
    fn towards(&self, view: &NearView, parallax: f32) -> Vec3 {
        self.ray.direction + (view.off * parallax).extend(0.0)
    }

    /// Finds the surface that the ray meets, by views from a number on: the next look-up is at the place on the ray
    /// nearest to the surface that the view shows.
    #[inline(always)] // for the instructions of its caller
    fn find(&mut self, first: usize) {
        let ray = self.ray.direction;
        let (length2, side) = (ray.length_squared(), self.fetch.form.side());
        // The ray cannot meet surfaces before its start; a little is rounding.
        let before = self.fetch.layout.unit * length2.sqrt() / (1.01 * self.ray.ahead).max(1e-30);
        let (last, per_step) = ((side - 1) as f32, 0.5 * std::f32::consts::SQRT_2 * side as f32);
        for number in first..self.count {
            let mut view = self.views[number];
            let row = self.rows.row(view.row as usize);
            let reach = view.off.length() * per_step;
            let mut step = f32::INFINITY;
            for _ in 0..STEPS {
                let towards = self.towards(&view, view.parallax);
                let pixel = self.fetch.layout.pixel_of(towards).clamp(Vec2::ZERO, Vec2::splat(last));
                let kept = self.fetch.form.parallax(&row, view.view, pixel.x as u32, pixel.y as u32);
                let seen = restored_parallax(kept);
                let from_exit = towards / towards.abs().element_sum() - (view.off * seen).extend(0.0);
                let next = limited(seen * length2 / from_exit.dot(ray));
                step = reach * (next - view.parallax).abs();
                view.parallax = next;
                if step < 0.25 * AGREES_PX {
                    break;
                }
            }
            let is_ahead = view.parallax >= 0.0 || -view.parallax > before;
            view.touches = view.parallax.abs() > 0.99 * MAX_PARALLAX;
            view.agrees = step < AGREES_PX && view.share > 0.0 && is_ahead && !view.touches;
            self.views[number] = view;
        }
    }

    /// Sets the shares of views by whether they agree on the nearest surface that any of them finds on the ray; changes
    /// nothing and returns false where none does.
    #[inline(always)] // for the instructions of its caller
    fn agree(&mut self) -> bool {
        let nearness = |parallax: f32| if parallax < 0.0 { parallax + BEFORE } else { parallax };
        let views = &mut self.views[..self.count];
        let found = views.iter().filter(|view| view.agrees).map(|view| view.parallax);
        let Some(nearest) = found.reduce(|one, other| if nearness(other) > nearness(one) { other } else { one }) else {
            return false;
        };
        let per_step = 0.5 * std::f32::consts::SQRT_2 * self.fetch.form.side() as f32;
        for view in views {
            let apart = (view.parallax - nearest).abs() * per_step;
            // A surface that touches a view may or may not reach to the ray: it counts, as it is near.
            view.share *= match view {
                NearView { touches: true, .. } => 1.0,
                NearView { agrees: true, .. } => (2.0 * AGREES_PX - apart).clamp(0.0, 1.0),
                _ => 0.0,
            };
        }
        true
    }

    /// Asks the 12 views about the four; where none of them sees the ray's surface, all four count.
    fn look_further(&mut self, low: Vec2) {
        let four = self.views;
        let last = Vec2::new((self.side.counts[0] - 1) as f32, (self.side.counts[1] - 1) as f32);
        for number in 0..16 {
            let by = Vec2::new((number % 4) as f32, (number / 4) as f32) - 1.0;
            let at = low + by;
            let is_of_four = by.cmpge(Vec2::ZERO).all() && by.cmple(Vec2::ONE).all();
            if is_of_four || at.cmplt(Vec2::ZERO).any() || at.cmpgt(last).any() || self.count == MOST_VIEWS {
                continue;
            }
            self.views[self.count] = self.view(at, 1.0 / (self.ray.st - at).length_squared().max(1e-3));
            self.count += 1;
        }
        self.find(4);
        if !self.agree() {
            (self.views, self.count) = (four, 4);
        }
    }

    /// The mean parallax, by the views' shares.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn parallax(&self) -> f32 {
        self.views[..self.count].iter().map(|view| view.parallax * view.share).sum::<f32>() / self.total
    }

    /// The distance beyond the box of the surface that the ray meets, in scene units; infinite for one at infinity.
    pub(crate) fn beyond(&self) -> f32 {
        self.fetch.layout.unit * self.ray.direction.length() / self.parallax()
    }

    /// Change from pixel to pixel, in pixels of a view at the ray's exit, of the surface that the ray meets; the ray is
    /// one of unit direction.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn footprint(&self, direction: Vec3, point_change: [Vec3; 2], direction_change: [Vec3; 2]) -> [Vec2; 2] {
        let nearness = self.parallax() / (self.fetch.layout.unit * self.ray.direction.length());
        let here = self.side.of_side(direction);
        let at = self.fetch.layout.pixel_of(here);
        [0, 1].map(|k: usize| {
            let moved = (point_change[k] + direction_change[k] * self.ray.ahead) * nearness;
            let by = direction_change[k] + moved;
            let mut there = here + self.side.of_side(by - direction * direction.dot(by));
            there.z = there.z.max(0.0);
            self.fetch.layout.pixel_of(there) - at
        })
    }

    /// The blend of the views, over a footprint in pixels.
    #[inline(always)] // for the instructions of its caller
    pub(crate) fn filtered(&self, footprint: [Vec2; 2]) -> Vec3 {
        let [x2, y2] = [footprint[0].length_squared(), footprint[1].length_squared()];
        let (major2, minor2, axis) = if x2 >= y2 { (x2, y2, footprint[0]) } else { (y2, x2, footprint[1]) };
        let major = major2.sqrt();
        // Values that are not numbers take one probe, too.
        let probes = if major > 1.0 && major.is_finite() {
            (major / minor2.sqrt().max(1.0)).clamp(1.0, MAX_PROBES).ceil()
        } else {
            1.0
        };
        let wide = major / probes;
        let coarsest = (self.fetch.form.levels.levels.len() - 1) as f32;
        let level = if wide > 1.0 { wide.logarithm2().min(coarsest) } else { 0.0 };
        let (fine, coarse) = (1.0 - level.fract(), level.fract());
        let mut sum = Vec3::ZERO;
        for view in self.views[..self.count].iter().filter(|view| view.share > 0.0) {
            let at = self.fetch.layout.pixel_of(self.towards(view, view.parallax));
            let weight = view.share / (self.total * probes);
            for probe in 0..probes as u32 {
                let aside = if probes > 1.0 { axis * ((probe as f32 + 0.5) / probes - 0.5) } else { Vec2::ZERO };
                sum += self.shown(view, at + aside, level as usize) * (weight * fine);
                if coarse > 0.0 {
                    sum += self.shown(view, at + aside, level as usize + 1) * (weight * coarse);
                }
            }
        }
        sum
    }

    /// The radiance of a level of a view at a place, in pixels of the finest level from its corner; bilinear.
    #[inline(always)] // for the instructions of its caller
    fn shown(&self, view: &NearView, place: Vec2, level: usize) -> Vec3 {
        let Some(&(_, side)) = self.fetch.form.levels.levels.get(level) else { return Vec3::ZERO };
        let shrunk = 1.0 / (1u32 << level) as f32;
        let at = (place * shrunk - 0.5).clamp(Vec2::ZERO, Vec2::splat((side - 1) as f32));
        let low = at.floor().min(Vec2::splat(side.saturating_sub(2) as f32));
        let row = self.rows.row(view.row as usize);
        let [a, b, c, d] = self.fetch.form.four(&row, view.view, level, [low.x as u32, low.y as u32]).map(unpacked);
        let Vec2 { x, y } = at - low;
        a.lerp(b, x).lerp(c.lerp(d, x), y)
    }
}

/// The radiance along a ray; returns `None` where it does not leave the box.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(crate) fn blended(
    fetch: &BoxFetch,
    rows: &Rows,
    point: Vec3,
    direction: Vec3,
    change: Option<[[Vec3; 2]; 2]>,
) -> Option<Vec3> {
    let look_up = BoxLookUp::new(fetch, rows, point, direction)?;
    let of_none = [Vec2::ZERO; 2];
    let footprint = change.map_or(of_none, |[point, turned]| look_up.footprint(direction, point, turned));
    Some(look_up.filtered(footprint))
}
