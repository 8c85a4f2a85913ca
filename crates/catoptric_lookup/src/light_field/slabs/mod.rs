//! Slabs as they are looked up (Yu, Yang, McMillan 2005, section 6).

pub(crate) mod blocks;
pub(super) mod box_fetch;
mod depth;
pub(crate) mod depth_blocks;
mod fetch;
pub(crate) mod form;
pub(crate) mod rows;
pub(super) mod tables;
pub(crate) mod texels;
#[cfg(feature = "files")]
pub(super) mod views;

use crate::light_field::layout::{FieldLayout, SLABS, Slab, SlabRays, across};
use crate::light_field::settings::{Disparity, LightFieldSettings};
use box_fetch::{BoxFetch, BoxLookUp, restored_parallax};
use catoptric_core::math::Aabb;
use catoptric_core::math::lanes::{Lanes, Vec3Lanes};
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use fetch::{Fetch, Nearby, restored_sum, sharp_rays};
use form::{RowView, ViewForm};
use glam::{Vec2, Vec3};
use rows::Rows;
use texels::restored;

/// The largest ratio of a footprint's axes that is resolved by several look-ups. A bound on time; chosen, not measured.
const MAX_PROBES: f32 = 8.0;

/// Rays that a thread looks up at once. A size for threads; chosen, not measured.
const RAYS_AT_ONCE: usize = 4096;

/// Light that arrives at a region by all rays: six slabs about it, or views on the six sides of its box.
///
/// ```
/// use catoptric::methods::lookup::light_field::{LightFieldSettings, Slabs};
/// use catoptric::progress::Silent;
/// use catoptric_scenes::builtin;
/// use glam::Vec3;
///
/// let scene = builtin::load("sphere_room", &[]).unwrap().pose(&Default::default()).unwrap();
/// let ball = scene.objects[scene.specular_objects()[0] as usize].bounds;
/// let settings = LightFieldSettings { st: 4, uv: 16, ..LightFieldSettings::default() };
/// let slabs = Slabs::capture(&settings, &scene, ball, 0, &Silent).unwrap();
/// let sharp = [Vec3::ZERO; 2];
/// let up = slabs.radiance(ball.center(), Vec3::Y, sharp, sharp).unwrap();
/// assert!(up.min_element() > 0.0, "the ceiling is lit");
/// ```
#[derive(Clone, Debug)]
pub struct Slabs {
    field: Field,
    rows: Rows,
}

/// The layout-dependent look-ups of rays.
#[derive(Clone, Debug)]
enum Field {
    Slabs(Fetch),
    Box(BoxFetch),
}

impl Slabs {
    /// Views that were captured in a layout.
    #[doc(hidden)]
    pub fn new(settings: &LightFieldSettings, layout: FieldLayout, rows: Rows) -> Self {
        let form = ViewForm::new(settings.uv, settings.compression);
        let disparity = settings.disparity;
        let focal = |unit: f32, middle: &dyn Fn() -> f32| match disparity {
            Disparity::None => 0.0,
            _ if settings.focal_distance > 0.0 => unit / settings.focal_distance,
            _ => middle(),
        };
        let field = match layout {
            FieldLayout::Slabs(mut layout) => {
                let st = layout.st as usize;
                for (number, slab) in layout.slabs.iter_mut().enumerate() {
                    let kept = || (0..st).map(|row| rows.row(number * st + row));
                    let middle = || middle_parallax(kept().flat_map(|row| parallaxes(&form, row)), restored);
                    slab.focal = focal(slab.spacing.max_element(), &middle);
                }
                Field::Slabs(Fetch { layout, form, disparity })
            }
            FieldLayout::Box(mut layout) => {
                let unit = layout.unit;
                for side in &mut layout.sides {
                    let kept = || (side.first_row..side.first_row + side.counts[1]).map(|row| rows.row(row as usize));
                    let middle = || middle_parallax(kept().flat_map(|row| parallaxes(&form, row)), restored_parallax);
                    // Depths of pixels need no start.
                    side.focal = if disparity == Disparity::Depth { 0.0 } else { focal(unit, &middle) };
                }
                Field::Box(BoxFetch { layout, form, disparity })
            }
        };
        Self { field, rows }
    }

    /// Returns true for points of the region: slabs hold all rays from there.
    pub fn holds(&self, point: Vec3) -> bool {
        let Aabb { min, max } = match &self.field {
            Field::Slabs(fetch) => fetch.layout.region,
            Field::Box(fetch) => fetch.layout.region,
        };
        point.cmpge(min).all() && point.cmple(max).all()
    }

    /// Memory of all light and of its parallax, in bytes.
    pub fn byte_count(&self) -> u64 {
        self.view_count() * self.form().bytes_a_view() as u64
    }

    /// Rays that were captured.
    pub fn ray_count(&self) -> u64 {
        self.view_count() * self.form().rays_a_view()
    }

    fn view_count(&self) -> u64 {
        match &self.field {
            Field::Slabs(fetch) => SLABS as u64 * u64::from(fetch.layout.st) * u64::from(fetch.layout.st),
            Field::Box(fetch) => fetch.layout.view_count(),
        }
    }

    fn form(&self) -> &ViewForm {
        match &self.field {
            Field::Slabs(fetch) => &fetch.form,
            Field::Box(fetch) => &fetch.form,
        }
    }

    /// The radiance along a ray from a point of the region, blurred over the ray's changes a pixel (of the point and of
    /// the unit direction); none where no slab holds it.
    pub fn radiance(
        &self,
        point: Vec3,
        direction: Vec3,
        point_change: [Vec3; 2],
        direction_change: [Vec3; 2],
    ) -> Option<Vec3> {
        match &self.field {
            Field::Slabs(fetch) => blended((fetch, &self.rows), point, direction, point_change, direction_change),
            Field::Box(fetch) => {
                box_fetch::blended(fetch, &self.rows, point, direction, Some([point_change, direction_change]))
            }
        }
    }

    /// The place of a ray from a point of the region in the slabs (Yu, Yang, McMillan 2005, equation 1, without
    /// disparity); `None` where no slab holds it.
    pub fn coordinates(&self, point: Vec3, direction: Vec3) -> Option<SlabCoordinates> {
        match &self.field {
            Field::Slabs(Fetch { layout, .. }) => {
                let ray = layout.locate(&Vec3Lanes::one(point), &Vec3Lanes::one(direction));
                let slope = Vec2::new(ray.slope[0][0], ray.slope[1][0]);
                (ray.held[0] > 0.0).then(|| SlabCoordinates {
                    slab: ray.slab[0],
                    view: Vec2::new(ray.st[0][0], ray.st[1][0]),
                    pixel: layout.place_of(slope),
                })
            }
            Field::Box(BoxFetch { layout, .. }) => {
                let ray = layout.locate(point, direction)?;
                let pixel = layout.pixel_of(ray.direction) - 0.5;
                Some(SlabCoordinates { slab: ray.side as u32, view: ray.st, pixel })
            }
        }
    }

    /// The distance from a point of the region to the surface that a ray in a unit direction meets; infinite where that
    /// is not known.
    pub fn distance(&self, point: Vec3, direction: Vec3) -> f32 {
        let distance = match &self.field {
            Field::Slabs(fetch) => SlabLookUp::new(fetch, &self.rows, point, direction).map(|look_up| {
                let beyond = look_up.slab.spacing.max_element() / look_up.parallax();
                (look_up.ray.ahead[0] + beyond) / direction[look_up.slab.axis].abs()
            }),
            Field::Box(fetch) => {
                BoxLookUp::new(fetch, &self.rows, point, direction).map(|look_up| look_up.ray.ahead + look_up.beyond())
            }
        };
        distance.filter(|distance| *distance > 0.0).unwrap_or(f32::INFINITY)
    }

    /// The radiance along many sharp rays, from points in unit directions; black where nothing holds one.
    pub fn radiance_batch(&self, points: &[Vec3], directions: &[Vec3], radiance: &mut [Vec3]) {
        let row_count = match &self.field {
            Field::Slabs(fetch) => SLABS * fetch.layout.st as usize,
            Field::Box(_) => 0,
        };
        let rows: Vec<RowView<'_>> = (0..row_count).map(|number| self.rows.row(number)).collect();
        parallel::for_each_chunk_mut(radiance, RAYS_AT_ONCE, |chunk, radiance| {
            let first = chunk * RAYS_AT_ONCE;
            let points = points.get(first..).unwrap_or_default();
            let directions = directions.get(first..).unwrap_or_default();
            match &self.field {
                Field::Slabs(fetch) => sharp_rays(fetch, &rows, points, directions, radiance),
                Field::Box(fetch) => {
                    for (radiance, (point, direction)) in radiance.iter_mut().zip(points.iter().zip(directions)) {
                        let found = box_fetch::blended(fetch, &self.rows, *point, *direction, None);
                        *radiance = found.unwrap_or_default();
                    }
                }
            }
        });
    }
}

/// Coordinates of a ray in the slabs about a region, or on the sides of its box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabCoordinates {
    /// The slab or side: 0 to 5 are +x, -x, +y, -y, +z, -z.
    pub slab: u32,
    /// The paper's s' and t': views from the first, 0 to `st - 1`, or to one less than a side of the box has.
    pub view: Vec2,
    /// The paper's u' and v': pixels of each view from the middle of the first, 0 to `uv - 1`; on sides of the box
    /// half a pixel less and more.
    pub pixel: Vec2,
}

/// A ray in a slab.
struct SlabLookUp<'a> {
    fetch: &'a Fetch,
    slab: &'a Slab,
    ray: SlabRays<1>,
    views: [Nearby<1>; 4],
    /// The sum of the views' shares.
    total: f32,
    /// The number of the first of the two rows that the views are in, and both.
    first: u32,
    rows: [RowView<'a>; 2],
}

impl<'a> SlabLookUp<'a> {
    /// Returns `None` if no slab holds the ray.
    #[inline(always)] // for the instructions of its caller
    fn new(fetch: &'a Fetch, kept: &'a Rows, point: Vec3, direction: Vec3) -> Option<Self> {
        let ray = fetch.layout.locate(&Vec3Lanes::one(point), &Vec3Lanes::one(direction));
        if ray.held[0] == 0.0 {
            return None;
        }
        let mut views = fetch.views(&ray);
        let first = views[0].row[0];
        let rows = [kept.row(first as usize), kept.row(first as usize + 1)];
        fetch.find(|row| rows[(row - first) as usize & 1], &ray, &mut views);
        let total = views[0].share[0] + views[1].share[0] + views[2].share[0] + views[3].share[0];
        Some(Self { fetch, slab: &fetch.layout.slabs[ray.slab[0] as usize], ray, views, total, first, rows })
    }

    /// The mean parallax, by the views' shares.
    #[inline(always)] // for the instructions of its caller
    fn parallax(&self) -> f32 {
        self.views.iter().map(|view| view.parallax[0] * view.share[0]).sum::<f32>() / self.total
    }

    /// Change from pixel to pixel of the slope, in a view, of the surface that the ray meets.
    #[inline(always)] // for the instructions of its caller
    fn footprint(&self, direction: Vec3, point_change: [Vec3; 2], direction_change: [Vec3; 2]) -> [Vec2; 2] {
        let (axis, sign) = (self.slab.axis, self.slab.sign);
        let ray_slope = Vec2::new(self.ray.slope[0][0], self.ray.slope[1][0]);
        let forward = direction[axis].abs();
        // The surface lies where the shares say, `longer / parallax` beyond the plane, and is met further aside by
        // both.
        let parallax = self.parallax() / self.slab.spacing.max_element();
        [0, 1].map(|k: usize| {
            let turn = direction_change[k];
            let slope = (across(axis, turn) - ray_slope * (turn[axis] * sign)) / forward;
            let moved = across(axis, point_change[k]) - ray_slope * (point_change[k][axis] * sign);
            slope + (moved + slope * self.ray.ahead[0]) * parallax
        })
    }

    /// The blend of the four views, over a footprint.
    #[inline(always)] // for the instructions of its caller
    fn filtered(&self, footprint: [Vec2; 2]) -> Vec3 {
        let [x2, y2] = [footprint[0].length_squared(), footprint[1].length_squared()];
        let (major2, minor2, axis) = if x2 >= y2 { (x2, y2, footprint[0]) } else { (y2, x2, footprint[1]) };
        let (pixel, major) = (self.fetch.layout.pixel(), major2.sqrt());
        // Values that are not numbers take one probe, too.
        let probes = if major > pixel && major.is_finite() {
            (major / minor2.sqrt().max(pixel)).clamp(1.0, MAX_PROBES).ceil()
        } else {
            1.0
        };
        let wide = major / (probes * pixel);
        let coarsest = (self.fetch.form.levels.levels.len() - 1) as f32;
        let level = if wide > 1.0 { wide.logarithm2().min(coarsest) } else { 0.0 };
        // Between the two levels about that.
        let (fine, coarse) = (1.0 - level.fract(), level.fract());
        let mut sum = Vec3Lanes::ZERO;
        for view in self.views.iter().filter(|view| view.share[0] > 0.0) {
            let slope = view.slope(&self.ray);
            let weight = view.share[0] / (self.total * probes);
            for probe in 0..probes as u32 {
                let aside = axis * ((probe as f32 + 0.5) / probes - 0.5);
                let slope = [slope[0] + aside.x, slope[1] + aside.y];
                let row = |row: u32| self.rows[(row - self.first) as usize & 1];
                self.fetch.add(row, view, &slope, level as usize, &Lanes([weight * fine]), &mut sum);
                if coarse > 0.0 {
                    self.fetch.add(row, view, &slope, level as usize + 1, &Lanes([weight * coarse]), &mut sum);
                }
            }
        }
        restored_sum(sum).vector(0)
    }
}

/// The radiance along a ray; returns `None` if no slab holds it.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn blended(
    (fetch, rows): (&Fetch, &Rows),
    point: Vec3,
    direction: Vec3,
    point_change: [Vec3; 2],
    direction_change: [Vec3; 2],
) -> Option<Vec3> {
    let look_up = SlabLookUp::new(fetch, rows, point, direction)?;
    Some(look_up.filtered(look_up.footprint(direction, point_change, direction_change)))
}

/// The parallax in the middle of those of a slab's pixels: of its 5th and 95th hundredth, so that a few pixels that see
/// something very near do not count (Chai, Tong, Chan, Shum 2000: the optimal plane has the mean of the least and the
/// greatest).
fn middle_parallax(parallaxes: impl Iterator<Item = i16>, restored: impl Fn(i16) -> f32) -> f32 {
    let mut counts = vec![0u64; 1 << 16];
    let mut total = 0;
    for value in parallaxes {
        counts[(i32::from(value) + (1 << 15)) as usize] += 1;
        total += 1;
    }
    let at = |share: f64| {
        let wanted = (total as f64 * share) as u64;
        let mut sum = 0;
        let found = counts.iter().position(|count| {
            sum += count;
            sum > wanted
        });
        restored((found.unwrap_or(1 << 15) as i32 - (1 << 15)) as i16)
    };
    0.5 * (at(0.05) + at(0.95))
}

/// The parallaxes of a row, as they are stored.
fn parallaxes(form: &ViewForm, row: RowView<'_>) -> Vec<i16> {
    form.parallaxes(&row).into_owned()
}
