//! Capture of slabs, traced view by view.

use super::layout::region_box::BoxSide;
use super::layout::{BoxLayout, FieldLayout, SLABS, Slab, SlabLayout, along};
use super::settings::{Compression, LightFieldSettings};
use super::slabs::Slabs;
use super::slabs::blocks::compress;
use super::slabs::box_fetch::{limited, stored_parallax};
use super::slabs::form::ViewForm;
use super::slabs::rows::{Rows, ViewRow};
use super::slabs::texels::{packed, stored};
use crate::shared::regions::is_within;
use catoptric_core::clock::Stopwatch;
use catoptric_core::math::Aabb;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::Settings;
use glam::{Vec2, Vec3};

/// A share of a region's size that is more than rounding. Chosen well above rounding, not measured.
const OUTSIDE: f32 = 1e-3;

/// Captures rows of views.
pub(super) struct Capture<'a> {
    scene: &'a Scene,
    tracer: Tracer,
    /// The reflectors and lenses of the region, where they stay in their places.
    leaving: Option<Tracer>,
    layout: FieldLayout,
    form: ViewForm,
    /// Samples a side of a pixel.
    samples: u32,
    /// Specular events on paths that slabs show.
    order: u32,
}

impl<'a> Capture<'a> {
    /// A capture of a scene without the reflectors and lenses that lie in the layout's region. Others are seen with up
    /// to `order` specular events.
    pub(super) fn new(scene: &'a Scene, layout: &FieldLayout, samples: u32, order: u32) -> Self {
        let leaves = |object: u32| leaves(scene, object, layout.region());
        let tracer = Tracer::build(scene, |object| !leaves(object));
        let leaving = scene.region.is_none().then(|| Tracer::build(scene, leaves));
        let (form, layout) = (ViewForm::new(layout.uv(), Compression::None), layout.clone());
        Self { scene, tracer, leaving, layout, form, samples: samples.isqrt(), order }
    }

    /// Time that one core takes for all rows, about, in seconds: that of one view of each slab and of its compression,
    /// times the number of views.
    pub(super) fn estimate_core_secs(&self, compression: Compression) -> f64 {
        let mut watch = Stopwatch::new();
        let mut paths = self.paths();
        // A view in the middle of each slab or side.
        let rows = self.layout.row_count();
        for slab in 0..SLABS {
            let number = (0..rows).filter(|row| self.layout.place_of_row(*row).0 == slab);
            let numbers: Vec<usize> = number.collect();
            let Some(&number) = numbers.get(numbers.len() / 2) else { continue };
            let mut row = ViewRow::default();
            self.view(&mut paths, number, self.layout.views_in_row(number) / 2, &mut row);
            compress(compression, self.layout.uv(), &row.texels, &mut Vec::new());
        }
        watch.lap_ms() * 1e-3 * self.layout.view_count() as f64 / SLABS as f64
    }

    fn paths(&self) -> PathTracer<'_> {
        PathTracer::new(self.scene, &self.tracer, PathModel::Tree, self.order)
    }

    /// Captures the row of a number, slab after slab.
    pub(super) fn row(&self, number: usize) -> ViewRow {
        let views = self.layout.views_in_row(number);
        let mut paths = self.paths();
        let mut row = ViewRow::with_room_for(views, &self.form);
        for s in 0..views {
            self.view(&mut paths, number, s, &mut row);
            self.form.levels.append(&mut row.texels);
        }
        row
    }

    /// Appends the finest level of a view of a row.
    fn view(&self, paths: &mut PathTracer<'_>, number: usize, s: u32, row: &mut ViewRow) {
        let (slab, t) = self.layout.place_of_row(number);
        match &self.layout {
            FieldLayout::Slabs(layout) => self.slab_view(paths, layout, &layout.slabs[slab], [s, t], row),
            FieldLayout::Box(layout) => self.box_view(paths, layout, &layout.sides[slab], [s, t], row),
        }
    }

    fn slab_view(
        &self,
        paths: &mut PathTracer<'_>,
        layout: &SlabLayout,
        slab: &Slab,
        [s, t]: [u32; 2],
        row: &mut ViewRow,
    ) {
        let (eye, longer) = (slab.eye(s, t), slab.spacing.max_element());
        let step = layout.pixel() / self.samples as f32;
        for (u, v) in (0..layout.uv).flat_map(|v| (0..layout.uv).map(move |u| (u, v))) {
            let corner = layout.slope_of(u as f32 - 0.5, v as f32 - 0.5);
            let sample = |place: Vec2| {
                let slope = corner + place * (step * self.samples as f32);
                let long = slab.direction(slope);
                let length = long.length();
                let back = self.start(&layout.region, slab, eye, slope, long / length, length);
                // A step of the slope turns the direction.
                let turned = [Vec2::X, Vec2::Y].map(|axis| along(slab.axis, 0.0, axis * step));
                SampleRay { eye, long, back, turned }
            };
            let (radiance, nearness) = self.pixel(paths, f32::INFINITY, sample);
            row.texels.push(packed(radiance));
            row.parallax.push(stored(nearness * longer));
        }
    }

    fn box_view(
        &self,
        paths: &mut PathTracer<'_>,
        layout: &BoxLayout,
        side: &BoxSide,
        [s, t]: [u32; 2],
        row: &mut ViewRow,
    ) {
        let eye = side.eye(s, t);
        let most = limited(f32::INFINITY) / layout.unit;
        let step = 1.0 / self.samples as f32;
        for (u, v) in (0..layout.uv).flat_map(|v| (0..layout.uv).map(move |u| (u, v))) {
            let sample = |place: Vec2| {
                let at = Vec2::new(u as f32, v as f32) + place;
                let direction = layout.direction_of(at);
                let turned = [Vec2::X, Vec2::Y].map(|by| {
                    // Towards the middle, where there is a place beside this one.
                    let by = if (at + by * step).max_element() > layout.uv as f32 { -by } else { by };
                    side.in_world((layout.direction_of(at + by * step) - direction) * by.element_sum())
                });
                let long = side.in_world(direction);
                SampleRay { eye, long, back: self.start_in_box(&layout.region, eye, long), turned }
            };
            let (radiance, nearness) = self.pixel(paths, most, sample);
            row.texels.push(packed(radiance));
            row.parallax.push(stored_parallax(nearness * layout.unit));
        }
    }

    /// The mean radiance of a pixel's rays, by their places in it from 0 to 1, and the mean of the reciprocal distances
    /// of their hits from the view's eye, in lengths of their directions, each no more than `most` in size; below 0 for
    /// hits before the eye.
    fn pixel(&self, paths: &mut PathTracer<'_>, most: f32, sample: impl Fn(Vec2) -> SampleRay) -> (Vec3, f32) {
        let count = self.samples;
        let share = 1.0 / (count * count) as f32;
        let (mut sum, mut nearness) = (Vec3::ZERO, 0.0);
        for number in 0..count * count {
            let place = Vec2::new((number % count) as f32 + 0.5, (number / count) as f32 + 0.5) / count as f32;
            let SampleRay { eye, long, back, turned } = sample(place);
            let length = long.length();
            let direction = long / length;
            let ray = Ray { origin: eye - long * back, direction };
            let change = self.tracer.needs_differentials().then(|| {
                let [direction_dx, direction_dy] = turned.map(|by| (by - direction * direction.dot(by)) / length);
                let [origin_dx, origin_dy] = turned.map(|by| -by * back);
                RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy }
            });
            let (radiance, distance) = paths.radiance_and_distance(ray, change);
            sum += radiance * share;
            nearness += share * (1.0 / (distance / length - back)).clamp(-most, most);
        }
        (sum, nearness)
    }
}

/// A ray of a view.
struct SampleRay {
    eye: Vec3,
    /// The direction, of any length.
    long: Vec3,
    /// The distance before the eye from which the ray is captured, in lengths of the direction.
    back: f32,
    /// The change of the direction from sample to sample.
    turned: [Vec3; 2],
}

impl Capture<'_> {
    /// The distance before the plane of views, along the axis, from which a ray is captured. In a given region, whose
    /// reflectors may move, this is the place where the ray leaves it. Otherwise it is where the ray leaves the last
    /// reflector, since rays that leave it meet nothing of the region again: objects that stand in a region, as the
    /// floor that a reflector sinks into, are then seen in their places. Rays that meet no reflector start where they
    /// are nearest to the region's middle.
    fn start(&self, region: &Aabb, slab: &Slab, eye: Vec3, slope: Vec2, direction: Vec3, length: f32) -> f32 {
        let exit = slab.exit(region, eye, slope);
        let Some(reflectors) = &self.leaving else { return exit };
        // The search starts outside, so that no reflector is missed that the region's side touches.
        let outside = exit - OUTSIDE * region.diagonal();
        let back = Ray { origin: eye - direction * (outside * length), direction: -direction };
        match reflectors.first_hit(self.scene, &back, 0.0) {
            Some(hit) => outside + hit.distance() / length,
            None => slab.nearest(region, eye, slope),
        }
    }

    /// The distance before a view of the region's box, in lengths of its direction, from which a ray is captured: like
    /// [`Self::start`], but 0 in a region that is given, whose reflectors may move.
    fn start_in_box(&self, region: &Aabb, eye: Vec3, long: Vec3) -> f32 {
        let Some(reflectors) = &self.leaving else { return 0.0 };
        let length = long.length();
        let outside = OUTSIDE * region.diagonal() / length;
        let back = Ray { origin: eye + long * outside, direction: -long / length };
        if let Some(hit) = reflectors.first_hit(self.scene, &back, 0.0) {
            return (hit.distance() / length - outside).max(0.0);
        }
        // The ray enters the box here; axes that the ray is across are at infinities, or no numbers along a side.
        let (one, other) = ((eye - region.min) / long, (eye - region.max) / long);
        let entry = one.max(other).min_element();
        let nearest = (eye - region.center()).dot(long) / long.length_squared();
        if entry > 0.0 { nearest.clamp(0.0, entry) } else { 0.0 }
    }
}

impl Slabs {
    /// Captures the light that arrives at a region of a scene, without the reflectors and lenses that lie in it. Others
    /// are seen with up to `order` specular events.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where a setting is not allowed, [`RenderError::Limit`] where the region has no size
    /// along an axis, or is not finite.
    pub fn capture(
        settings: &LightFieldSettings,
        scene: &Scene,
        region: Aabb,
        order: u32,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let method = LightFieldSettings::METHOD;
        settings.check().map_err(|problem| RenderError::Setting { method, problem })?;
        let has_size = region.size().min_element() > 0.0 && region.size().is_finite() && region.min.is_finite();
        if !has_size {
            let problem = format!("the region from {} to {} has no size", region.min, region.max);
            return Err(RenderError::Limit { method, problem });
        }
        let layout = FieldLayout::new(settings, region);
        let form = ViewForm::new(settings.uv, settings.compression);
        let capture = Capture::new(scene, &layout, settings.capture_samples, order);
        let rows = Rows::captured(&layout, &form, progress, |number| Ok(capture.row(number)))?;
        Ok(Self::new(settings, layout, rows))
    }
}

/// Returns true for reflectors and lenses in a region, whose light its slabs do not hold.
pub(super) fn leaves(scene: &Scene, object: u32, region: &Aabb) -> bool {
    scene.role_of(object).is_specular() && is_within(scene, object, region)
}
