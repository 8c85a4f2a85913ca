//! Slabs as they are looked up (Yu, Yang, McMillan 2005, section 6).

use super::capture::{Capture, restored};
use super::layout::{Layout, SLABS, STEEPEST, SlabRay, across};
use super::rows::{RowSize, RowView, Rows};
use super::settings::{Disparity, LightFieldSettings};
use super::texels::{Levels, unpacked};
use crate::error::RenderError;
use crate::math::Aabb;
use crate::methods::Settings;
use crate::parallel;
use crate::progress::Progress;
use crate::scene::Scene;
use glam::{Vec2, Vec3};

/// The largest ratio of a footprint's axes that is resolved by several look-ups.
const MOST_PROBES: f32 = 8.0;

/// Rays that a thread looks up at once.
const RAYS_AT_ONCE: usize = 4096;

/// Steps by which a view finds what a ray meets, where depth is known.
const DEPTH_STEPS: u32 = 4;

/// What lies before the plane of views has a parallax below 0 and is nearer than all beyond it: more than any parallax.
const BEFORE: f32 = 100.0;

/// A view knows what a ray meets if its pixel there shows what lies on the ray, up to so many pixels.
const AGREES_PX: f32 = 1.0;

/// Light that arrives at a region by all rays: six slabs about it.
///
/// ```
/// use catoptric::methods::lookup::light_field::{LightFieldSettings, Slabs};
/// use catoptric::progress::Silent;
/// use catoptric::scene::builtin;
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
    pub(super) layout: Layout,
    levels: Levels,
    rows: Rows,
    disparity: Disparity,
    /// The parallax of each slab's focal plane, from view to view along the longer spacing.
    focal: [f32; SLABS],
}

/// One of the four views about a ray.
#[derive(Clone, Copy, Debug, Default)]
struct Nearby {
    s: u32,
    t: u32,
    /// Its share in the blend.
    share: f32,
    /// How much the slope changes from the ray to the view's pixel with the parallax.
    shift: Vec2,
}

impl Slabs {
    /// Captures what arrives at a region of a scene, without the reflectors and lenses that lie in it. Others are seen with up
    /// to `order` specular events.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where a setting is not allowed, [`RenderError::Limit`] where the region has no size along an
    /// axis, or is not finite.
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
        let layout = Layout::new(region, settings.st, settings.uv);
        let rows = Capture::new(scene, &layout, settings.capture_samples, order).rows(progress);
        Ok(Self::new(settings, layout, Rows::Captured(rows)))
    }

    pub(super) fn new(settings: &LightFieldSettings, layout: Layout, rows: Rows) -> Self {
        let levels = Levels::new(layout.uv);
        let focal = [0, 1, 2, 3, 4, 5].map(|slab: usize| {
            let longer = layout.slabs[slab].spacing.max_element();
            match settings.disparity {
                Disparity::None => 0.0,
                _ if settings.focal_distance > 0.0 => longer / settings.focal_distance,
                _ => middle_parallax((0..layout.st as usize).map(|row| rows.row(slab * layout.st as usize + row))),
            }
        });
        Self { layout, levels, rows, disparity: settings.disparity, focal }
    }

    /// Whether a point lies in the region: slabs hold all rays from there.
    pub fn holds(&self, point: Vec3) -> bool {
        let Aabb { min, max } = self.layout.region;
        point.cmpge(min).all() && point.cmple(max).all()
    }

    /// Memory of all texels and of their parallax.
    pub fn byte_count(&self) -> u64 {
        (self.row_count() * RowSize::new(&self.layout, &self.levels).bytes()) as u64
    }

    /// Rays that were captured.
    pub fn ray_count(&self) -> u64 {
        (self.row_count() * RowSize::new(&self.layout, &self.levels).parallax) as u64
    }

    fn row_count(&self) -> usize {
        SLABS * self.layout.st as usize
    }

    /// The row of views that a view is in.
    #[inline(always)] // for the instructions of its caller
    fn row_of(&self, slab: usize, view: &Nearby) -> RowView<'_> {
        self.rows.row(slab * self.layout.st as usize + view.t as usize)
    }

    /// The radiance along a ray from a point of the region, blurred over the ray's changes a pixel (of the point and of the
    /// unit direction); none where no slab holds it.
    pub fn radiance(
        &self,
        point: Vec3,
        direction: Vec3,
        point_change: [Vec3; 2],
        direction_change: [Vec3; 2],
    ) -> Option<Vec3> {
        let ray = self.layout.locate(point, direction)?;
        Some(blended(self, &ray, direction, point_change, direction_change))
    }

    /// How far from a point of the region what a ray in a unit direction meets lies; infinite where that is not known.
    pub fn distance(&self, point: Vec3, direction: Vec3) -> f32 {
        let Some(ray) = self.layout.locate(point, direction) else { return f32::INFINITY };
        let views = self.views(&ray);
        let (parallax, shares) = self.parallax(&ray, &views);
        let total: f32 = shares.iter().sum();
        let mean = (0..4).map(|k| parallax[k] * shares[k]).sum::<f32>() / total;
        let slab = &self.layout.slabs[ray.slab];
        let beyond = slab.spacing.max_element() / mean;
        let distance = (ray.ahead + beyond) / direction[slab.axis].abs();
        if distance > 0.0 { distance } else { f32::INFINITY }
    }

    /// The radiance along many sharp rays, from points in unit directions; black where no slab holds one.
    pub fn radiance_batch(&self, points: &[Vec3], directions: &[Vec3], radiance: &mut [Vec3]) {
        let sharp = [Vec3::ZERO; 2];
        parallel::for_each_chunk_mut(radiance, RAYS_AT_ONCE, |chunk, radiance| {
            let first = chunk * RAYS_AT_ONCE;
            let points = points.get(first..).unwrap_or_default();
            let directions = directions.get(first..).unwrap_or_default();
            for (radiance, (point, direction)) in radiance.iter_mut().zip(points.iter().zip(directions)) {
                *radiance = self.radiance(*point, *direction, sharp, sharp).unwrap_or_default();
            }
        });
    }

    /// The four views about a ray (equation 5).
    #[inline(always)] // for the instructions of its caller
    fn views(&self, ray: &SlabRay) -> [Nearby; 4] {
        let slab = &self.layout.slabs[ray.slab];
        let low = ray.st.floor().min(Vec2::splat((self.layout.st - 2) as f32));
        let at = ray.st - low;
        let aspect = slab.spacing / slab.spacing.max_element();
        [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE].map(|corner| {
            let weights = Vec2::ONE - (at - corner).abs();
            let view = low + corner;
            Nearby { s: view.x as u32, t: view.y as u32, share: weights.x * weights.y, shift: (at - corner) * aspect }
        })
    }

    /// The parallax by which each view finds what the ray meets, and the views' shares (equation 6 with a parallax for
    /// each view).
    #[inline(always)] // for the instructions of its caller
    fn parallax(&self, ray: &SlabRay, views: &[Nearby; 4]) -> ([f32; 4], [f32; 4]) {
        let focal = self.focal[ray.slab];
        let (mut parallax, mut shares) = ([focal; 4], views.map(|view| view.share));
        if self.disparity != Disparity::Depth {
            return (parallax, shares);
        }
        let pixel = self.layout.pixel();
        let mut agrees = [0.0f32; 4];
        for k in 0..4 {
            let view = &views[k];
            let mut found = focal;
            let mut off = 0.0;
            for _ in 0..DEPTH_STEPS {
                let seen = self.parallax_at(ray.slab, view, ray.slope + view.shift * found);
                off = (view.shift * (seen - found)).length() / pixel;
                found = seen;
                if off < 0.25 * AGREES_PX {
                    break;
                }
            }
            let slope = ray.slope + view.shift * found;
            let seen = slope.abs().max_element() <= STEEPEST;
            parallax[k] = found;
            agrees[k] = if seen && off < AGREES_PX { 1.0 } else { 0.0 };
        }
        // Of several things on the ray the nearest hides the others.
        let nearness = |parallax: f32| if parallax < 0.0 { BEFORE + parallax } else { parallax };
        let mut nearest: Option<f32> = None;
        for k in 0..4 {
            let nearer = nearest.is_none_or(|nearest| nearness(parallax[k]) > nearness(nearest));
            if agrees[k] > 0.0 && shares[k] > 0.0 && nearer {
                nearest = Some(parallax[k]);
            }
        }
        let Some(nearest) = nearest else { return (parallax, shares) };
        for k in 0..4 {
            let apart = (parallax[k] - nearest).abs() / pixel;
            shares[k] *= agrees[k] * (2.0 * AGREES_PX - apart).clamp(0.0, 1.0);
        }
        (parallax, shares)
    }

    /// The parallax of the pixel of a view nearest to a slope.
    #[inline(always)] // for the instructions of its caller
    fn parallax_at(&self, slab: usize, view: &Nearby, slope: Vec2) -> f32 {
        let side = self.layout.uv as usize;
        let at = ((slope + STEEPEST) / self.layout.pixel()).round().clamp(Vec2::ZERO, Vec2::splat(side as f32 - 1.0));
        let row = self.row_of(slab, view);
        restored(row.parallax[(view.s as usize * side + at.y as usize) * side + at.x as usize])
    }

    /// How the slope at which a view sees what a ray meets changes from pixel to pixel of the picture.
    #[inline(always)] // for the instructions of its caller
    fn footprint(
        &self,
        ray: &SlabRay,
        direction: Vec3,
        parallax: f32,
        point_change: [Vec3; 2],
        direction_change: [Vec3; 2],
    ) -> [Vec2; 2] {
        let slab = &self.layout.slabs[ray.slab];
        let (axis, longer) = (slab.axis, slab.spacing.max_element());
        let forward = direction[axis].abs();
        [0, 1].map(|k: usize| {
            let turn = direction_change[k];
            let slope = (across(axis, turn) - ray.slope * (turn[axis] * slab.sign)) / forward;
            let moved = across(axis, point_change[k]) - ray.slope * (point_change[k][axis] * slab.sign);
            // What lies `longer / parallax` beyond the plane is met further aside by both.
            slope + (moved + slope * ray.ahead) * (parallax / longer)
        })
    }

    /// A view's radiance about a slope, over a footprint.
    #[inline(always)] // for the instructions of its caller
    fn filtered(&self, slab: usize, view: &Nearby, slope: Vec2, footprint: [Vec2; 2]) -> Vec3 {
        let [x2, y2] = footprint.map(Vec2::length_squared);
        let (major2, minor2, axis) = if x2 >= y2 { (x2, y2, footprint[0]) } else { (y2, x2, footprint[1]) };
        let row = self.row_of(slab, view);
        let view = &row.texels[(view.s * self.levels.count) as usize..((view.s + 1) * self.levels.count) as usize];
        let pixel = self.layout.pixel();
        let major = major2.sqrt();
        // Also what is not a number.
        let probes = if major > pixel && major.is_finite() {
            (major / minor2.sqrt().max(pixel)).clamp(1.0, MOST_PROBES).ceil()
        } else {
            1.0
        };
        let level = (major / (probes * pixel)).max(1.0).log2().min((self.levels.levels.len() - 1) as f32);
        let mut sum = Vec3::ZERO;
        for probe in 0..probes as u32 {
            sum += self.leveled(view, slope + axis * ((probe as f32 + 0.5) / probes - 0.5), level);
        }
        sum / probes
    }

    /// Between the two levels of a view about a level.
    #[inline(always)] // for the instructions of its caller
    fn leveled(&self, view: &[u32], slope: Vec2, level: f32) -> Vec3 {
        let index = level as usize;
        let blend = level - index as f32;
        let fine = self.bilinear(view, slope, index);
        if blend <= 0.0 {
            return fine;
        }
        fine.lerp(self.bilinear(view, slope, (index + 1).min(self.levels.levels.len() - 1)), blend)
    }

    #[inline(always)] // for the instructions of its caller
    fn bilinear(&self, view: &[u32], slope: Vec2, level: usize) -> Vec3 {
        let (first, side) = self.levels.levels[level];
        // In pixels of the finest level from its first corner, then of this one.
        let place = (slope + STEEPEST) / self.layout.pixel() + 0.5;
        let at = place / (1u32 << level) as f32 - 0.5;
        let at = at.clamp(Vec2::ZERO, Vec2::splat((side - 1) as f32));
        let low = at.floor();
        let blend = at - low;
        let (x, y) = (low.x as u32, low.y as u32);
        let (right, down) = ((x + 1).min(side - 1), (y + 1).min(side - 1));
        let texel = |x: u32, y: u32| unpacked(view[(first + y * side + x) as usize]);
        let upper = texel(x, y).lerp(texel(right, y), blend.x);
        let lower = texel(x, down).lerp(texel(right, down), blend.x);
        upper.lerp(lower, blend.y)
    }
}

/// The blend of the four views about a ray.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
fn blended(
    slabs: &Slabs,
    ray: &SlabRay,
    direction: Vec3,
    point_change: [Vec3; 2],
    direction_change: [Vec3; 2],
) -> Vec3 {
    let views = slabs.views(ray);
    let (parallax, shares) = slabs.parallax(ray, &views);
    // What is seen lies where the weights say; the footprint is taken there.
    let total: f32 = shares.iter().sum();
    let mean = (0..4).map(|k| parallax[k] * shares[k]).sum::<f32>() / total;
    let footprint = slabs.footprint(ray, direction, mean, point_change, direction_change);
    let mut sum = Vec3::ZERO;
    for k in 0..4 {
        if shares[k] > 0.0 {
            let slope = ray.slope + views[k].shift * parallax[k];
            sum += slabs.filtered(ray.slab, &views[k], slope, footprint) * (shares[k] / total);
        }
    }
    sum
}

/// The parallax in the middle of those of a slab's pixels: of its 5th and 95th hundredth, so that a few pixels that see
/// something very near do not count (Chai, Tong, Chan, Shum 2000: the optimal plane has the mean of the least and the
/// greatest).
fn middle_parallax<'a>(rows: impl Iterator<Item = RowView<'a>>) -> f32 {
    let mut counts = vec![0u64; 1 << 16];
    let mut total = 0;
    for value in rows.flat_map(|row| row.parallax) {
        counts[(i32::from(*value) + (1 << 15)) as usize] += 1;
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
