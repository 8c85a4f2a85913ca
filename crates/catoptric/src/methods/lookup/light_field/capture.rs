//! Capture of slabs, traced view by view.

use super::layout::{SLABS, Slab, SlabLayout, along};
use super::settings::Compression;
use super::slabs::blocks::compress;
use super::slabs::rows::ViewRow;
use super::slabs::texels::{ViewLevels, packed, stored};
use crate::clock::Stopwatch;
use crate::light::path_tracer::{PathModel, PathTracer};
use crate::light::tracer::Tracer;
use crate::math::Aabb;
use crate::methods::lookup::shared::regions::is_within;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::{Vec2, Vec3};

/// A share of a region's size that is more than rounding. Chosen well above rounding, not measured.
const OUTSIDE: f32 = 1e-3;

/// Captures rows of views.
pub(super) struct Capture<'a> {
    scene: &'a Scene,
    tracer: Tracer,
    /// The reflectors and lenses of the region, where they stay in their places.
    leaving: Option<Tracer>,
    layout: SlabLayout,
    levels: ViewLevels,
    /// Samples a side of a pixel.
    samples: u32,
    /// Specular events on what slabs show.
    order: u32,
}

impl<'a> Capture<'a> {
    /// Of a scene without the reflectors and lenses that lie in the layout's region. What slabs show of others has up
    /// to
    /// `order` specular events.
    pub(super) fn new(scene: &'a Scene, layout: &SlabLayout, samples: u32, order: u32) -> Self {
        let leaves = |object: u32| leaves(scene, object, &layout.region);
        let tracer = Tracer::build(scene, |object| !leaves(object));
        let leaving = scene.region.is_none().then(|| Tracer::build(scene, leaves));
        let (levels, layout) = (ViewLevels::new(layout.uv), layout.clone());
        Self { scene, tracer, leaving, layout, levels, samples: samples.isqrt(), order }
    }

    /// Time that one core takes for all rows, about, in seconds: that of one view of each slab and of its compression,
    /// times the
    /// number of views.
    pub(super) fn estimate_core_secs(&self, compression: Compression) -> f64 {
        let mut watch = Stopwatch::new();
        let mut paths = self.paths();
        let middle = self.layout.st / 2;
        for slab in 0..SLABS {
            let mut row = ViewRow::default();
            self.view(&mut paths, slab, middle, middle, &mut row);
            compress(compression, self.layout.uv, &row.texels, &mut Vec::new());
        }
        watch.lap_ms() * 1e-3 * f64::from(self.layout.st * self.layout.st)
    }

    fn paths(&self) -> PathTracer<'_> {
        PathTracer::new(self.scene, &self.tracer, PathModel::Tree, self.order)
    }

    /// One row: that of a number, slab after slab.
    pub(super) fn row(&self, number: usize) -> ViewRow {
        let st = self.layout.st;
        let (slab, t) = (number / st as usize, (number % st as usize) as u32);
        let mut paths = self.paths();
        let mut row = ViewRow::with_room_for(&self.layout);
        for s in 0..st {
            self.view(&mut paths, slab, s, t, &mut row);
            self.levels.append(&mut row.texels);
        }
        row
    }

    /// Appends the finest level of a view.
    fn view(&self, paths: &mut PathTracer<'_>, slab: usize, s: u32, t: u32, row: &mut ViewRow) {
        let (layout, count) = (&self.layout, self.samples);
        let slab = &layout.slabs[slab];
        let (eye, longer) = (slab.eye(s, t), slab.spacing.max_element());
        let step = layout.pixel() / count as f32;
        let share = 1.0 / (count * count) as f32;
        for v in 0..layout.uv {
            for u in 0..layout.uv {
                let corner = layout.slope_of(u as f32 - 0.5, v as f32 - 0.5);
                let (mut sum, mut nearness) = (Vec3::ZERO, 0.0);
                for sample in 0..count * count {
                    let place = Vec2::new((sample % count) as f32 + 0.5, (sample / count) as f32 + 0.5);
                    let slope = corner + place * step;
                    let long = slab.direction(slope);
                    let length = long.length();
                    let direction = long / length;
                    let back = self.start(slab, eye, slope, direction, length);
                    let ray = Ray { origin: eye - long * back, direction };
                    let change = self.tracer.needs_differentials().then(|| {
                        // A step of the slope moves the origin, before the plane, and turns the direction.
                        let [dx, dy] = [Vec2::X, Vec2::Y].map(|axis| along(slab.axis, 0.0, axis * step));
                        let turned = |by: Vec3| (by - direction * direction.dot(by)) / length;
                        RayDifferential {
                            origin_dx: -dx * back,
                            origin_dy: -dy * back,
                            direction_dx: turned(dx),
                            direction_dy: turned(dy),
                        }
                    });
                    let (radiance, distance) = paths.radiance_and_distance(ray, change);
                    sum += radiance * share;
                    // Of what lies before the plane, it is below 0.
                    nearness += share / (distance / length - back);
                }
                row.texels.push(packed(sum));
                row.parallax.push(stored(nearness * longer));
            }
        }
    }
}

impl Capture<'_> {
    /// How far before the plane of views, along the axis, a ray is captured from. In a region that is given, whose
    /// reflectors
    /// may move, where it leaves that. Else where it leaves the last reflector: rays that leave it meet none of the
    /// region
    /// again. So what stands in a region, as the floor that a reflector sinks into, is seen where it should be. Of
    /// rays that
    /// meet none, where they are nearest to the region's middle.
    fn start(&self, slab: &Slab, eye: Vec3, slope: Vec2, direction: Vec3, length: f32) -> f32 {
        let region = &self.layout.region;
        let exit = slab.exit(region, eye, slope);
        let Some(reflectors) = &self.leaving else { return exit };
        // From outside, so that none is missed that the region's side touches.
        let outside = exit - OUTSIDE * region.diagonal();
        let back = Ray { origin: eye - direction * (outside * length), direction: -direction };
        match reflectors.first_hit(self.scene, &back, 0.0) {
            Some(hit) => outside + hit.distance() / length,
            None => slab.nearest(region, eye, slope),
        }
    }
}

/// Returns true for reflectors and lenses in a region, whose light its slabs do not hold.
pub(super) fn leaves(scene: &Scene, object: u32, region: &Aabb) -> bool {
    scene.role_of(object).is_specular() && is_within(scene, object, region)
}
