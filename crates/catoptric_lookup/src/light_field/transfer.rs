//! Which ray leaves a region for one that enters it: a second light field, of rays in place of light (Heidrich, Lensch,
//! Cohen, Seidel 1999, Light field techniques for reflections and refractions).

use super::layout::{across, along};
use super::slabs::texels::{packed, unpacked};
use catoptric_core::math::Aabb;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::{Ray, Scene};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::two_path_tracer::TwoPathTracer;
use catoptric_engine::optics::path::bundle::BounceKind;
use glam::{Vec2, Vec3};

/// Directions of views: +x, -x, +y, -y, +z, -z, towards the eye.
const FRAMES: usize = 6;

/// Half the width of the plane of views, which is as far from the middle of the region as its cube is wide, in such
/// widths: rays through that cube within 45 degrees of the axis get no further aside.
const HALF_ST: f32 = 2.0;

/// The same of the plane through the middle, where the rays' pixels are.
const HALF_UV: f32 = 1.0;

/// Places of the region are at least half a width before the plane of views; nearer ones are none of it. Chosen, not
/// measured.
const MIN_AHEAD: f32 = 0.25;

/// Rays whose directions are further apart than this (a cosine) have gone different ways and are not blended. Much less
/// would tear what is seen near the rim of a ball, where neighbours are 30 degrees apart. Not measured beyond that.
const APART: f32 = 0.3;

/// Positions are kept from -1 to 1 in widths of the cube, directions as they are.
const UNIT: f32 = i16::MAX as f32;

/// A leaving ray, and the throughput of light from there on the way, without that of the first surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaving {
    pub(super) ray: Ray,
    pub(super) share: Vec3,
}

/// One kept ray.
#[derive(Clone, Copy, Debug)]
struct TransferEntry {
    origin: [i16; 3],
    direction: [i16; 3],
    /// [`packed`]; 0 where no light arrives, [`MISSED`] where no surface is met.
    share: u32,
}

/// No share is as large.
const MISSED: u32 = u32::MAX;

impl TransferEntry {
    const fn without_ray(share: u32) -> Self {
        Self { origin: [0; 3], direction: [0; 3], share }
    }
}

/// The rays that leave a region for those that enter it.
#[derive(Clone, Debug)]
pub(super) struct RayTransfer {
    /// The middle of the region and the width of the cube about it.
    center: Vec3,
    width: f32,
    /// Views a side, and pixels a side of each.
    st: u32,
    uv: u32,
    /// Half the width of the plane of pixels: [`HALF_UV`], and as much as a view sees beyond that of what its
    /// neighbours show.
    half_uv: f32,
    /// Leaving rays of every ray: the one that is reflected first and, with lenses, the one that is refracted.
    ways: usize,
    /// Rows of views of every frame: view after view, row after row of pixels, path after path.
    rows: Vec<Vec<TransferEntry>>,
}

impl RayTransfer {
    /// Of the reflectors and lenses that `tracer` knows, in a region, with paths of up to `order` events; `st` and `uv`
    /// are at least 2.
    pub(super) fn capture(
        scene: &Scene,
        tracer: &Tracer,
        region: &Aabb,
        [st, uv]: [u32; 2],
        order: u32,
        has_lenses: bool,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let paths = TwoPathTracer { scene, tracer, order };
        let half_uv = HALF_UV + 2.0 * HALF_ST / (st - 1) as f32;
        let (center, width) = (region.center(), region.size().max_element());
        let ways = if has_lenses { 2 } else { 1 };
        let mut transfer = Self { center, width, st, uv, half_uv, ways, rows: Vec::new() };
        let rows = FRAMES * st as usize;
        transfer.rows = parallel::map_stage(progress, "tracing a ray-transfer light field", rows, |row| {
            let (frame, t) = (row / st as usize, row as u32 % st);
            let mut entries = Vec::with_capacity((st * uv * uv) as usize * ways);
            for (s, v) in (0..st).flat_map(|s| (0..uv).map(move |v| (s, v))) {
                for u in 0..uv {
                    let ray = transfer.entering(frame, Vec2::new(s as f32, t as f32), Vec2::new(u as f32, v as f32));
                    transfer.push(&paths, &ray, &mut entries);
                }
            }
            entries
        })?;
        Ok(transfer)
    }

    /// Memory of one with these sizes whose region has lenses.
    pub(super) fn most_bytes([st, uv]: [u32; 2]) -> u64 {
        let side = |count: u32| u64::from(count) * u64::from(count);
        2 * FRAMES as u64 * side(st) * side(uv) * size_of::<TransferEntry>() as u64
    }

    /// Rays that are kept.
    pub(super) fn ray_count(&self) -> u64 {
        self.rows.iter().map(Vec::len).sum::<usize>() as u64
    }

    pub(super) fn byte_count(&self) -> u64 {
        self.ray_count() * size_of::<TransferEntry>() as u64
    }

    /// The place of a view, and that of a pixel on the plane through the middle.
    fn view_at(&self, st: Vec2) -> Vec2 {
        st * (2.0 * HALF_ST / (self.st - 1) as f32) - HALF_ST
    }

    fn pixel_at(&self, uv: Vec2) -> Vec2 {
        uv * (2.0 * self.half_uv / (self.uv - 1) as f32) - self.half_uv
    }

    /// The ray that enters through a view and a pixel.
    fn entering(&self, frame: usize, st: Vec2, uv: Vec2) -> Ray {
        let (axis, sign) = (frame / 2, if frame.is_multiple_of(2) { 1.0 } else { -1.0 });
        let (eye, pixel) = (self.view_at(st), self.pixel_at(uv));
        let origin = self.center + along(axis, sign, eye) * self.width;
        Ray { origin, direction: along(axis, -sign, pixel - eye).normalize() }
    }

    /// Appends what becomes of a ray.
    fn push(&self, paths: &TwoPathTracer<'_>, ray: &Ray, entries: &mut Vec<TransferEntry>) {
        let Some(hit) = paths.tracer.first_hit(paths.scene, ray, 0.0) else {
            entries.resize(entries.len() + self.ways, TransferEntry::without_ray(MISSED));
            return;
        };
        let point = paths.tracer.point(paths.scene, ray, &hit);
        for first in BounceKind::BOTH.into_iter().take(self.ways) {
            let path = paths.follow(ray.direction, point, first);
            let entry = |ray| self.entry(&Leaving { ray, share: path.share });
            entries.push(path.leaving.map_or(TransferEntry::without_ray(0), entry));
        }
    }

    fn entry(&self, leaving: &Leaving) -> TransferEntry {
        // Casts saturate.
        let kept = |value: Vec3| value.to_array().map(|value| (value * UNIT).round() as i16);
        let origin = kept((leaving.ray.origin - self.center) / self.width);
        TransferEntry { origin, direction: kept(leaving.ray.direction), share: packed(leaving.share) }
    }

    /// What becomes of a ray that meets a place of a region's surfaces on its way from `towards` (a unit direction), by
    /// a first way; none where the rays about it were not kept, or carry nothing.
    ///
    /// The four views about the ray are asked for the pixels where they see that place, as if it were a focal surface;
    /// those that see no surface do not count, and the others count by their shares in the blend.
    #[inline]
    pub(super) fn look_up(&self, position: Vec3, towards: Vec3, first: BounceKind) -> Option<Leaving> {
        let way = match first {
            BounceKind::Reflect => 0,
            BounceKind::Transmit if self.ways > 1 => 1,
            BounceKind::Transmit => return None,
        };
        let mut near = [(0.0, TransferEntry::without_ray(MISSED)); 16];
        self.near(position, towards, way, &mut near)?;
        let (_, heaviest) = near.iter().filter(|(_, entry)| entry.share != MISSED && entry.share != 0).fold(
            None,
            |best: Option<&(f32, TransferEntry)>, next| match best {
                Some(best) if best.0 >= next.0 => Some(best),
                _ => Some(next),
            },
        )?;
        let main = vector(heaviest.direction);
        let (mut origin, mut direction, mut share) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let (mut met, mut blended) = (0.0, 0.0);
        for (weight, entry) in &near {
            if entry.share == MISSED || *weight == 0.0 {
                continue;
            }
            met += weight;
            share += unpacked(entry.share) * *weight;
            let towards = vector(entry.direction);
            if entry.share != 0 && towards.dot(main) > APART {
                blended += weight;
                origin += vector(entry.origin) * *weight;
                direction += towards * *weight;
            }
        }
        let origin = self.center + origin * (self.width / blended);
        let direction = direction.try_normalize()?;
        Some(Leaving { ray: Ray { origin, direction }, share: share / met })
    }

    /// The stored rays about one, with their weights in the blend; returns `None` if it does not pass through the
    /// region.
    #[inline]
    fn near(&self, position: Vec3, towards: Vec3, way: usize, near: &mut [(f32, TransferEntry); 16]) -> Option<()> {
        let size = towards.abs();
        let axis = size.max_position();
        let sign = towards[axis].signum();
        let place = (position - self.center) / self.width;
        let (aside, ahead) = (across(axis, place), 1.0 - place[axis] * sign);
        let meets = aside + across(axis, towards) * (ahead / size[axis]);
        let st = (meets + HALF_ST) * ((self.st - 1) as f32 / (2.0 * HALF_ST));
        if !(st.is_finite() && ahead > MIN_AHEAD) {
            return None;
        }
        let frame = 2 * axis + usize::from(sign < 0.0);
        let low = st.floor().clamp(Vec2::ZERO, Vec2::splat((self.st - 2) as f32));
        let part = (st - low).clamp(Vec2::ZERO, Vec2::ONE);
        for view in 0..4 {
            let corner = Vec2::new((view & 1) as f32, (view >> 1) as f32);
            let weight = share_of(part, corner);
            let eye = self.view_at(low + corner);
            // On from the view through the place, to the plane of pixels.
            let pixel = eye + (aside - eye) / ahead;
            let uv = (pixel + self.half_uv) * ((self.uv - 1) as f32 / (2.0 * self.half_uv));
            if !(uv.cmpge(Vec2::ZERO).all() && uv.cmple(Vec2::splat((self.uv - 1) as f32)).all()) {
                continue;
            }
            let first = uv.floor().min(Vec2::splat((self.uv - 2) as f32));
            let [s, t] = (low + corner).to_array().map(|value| value as usize);
            let [u, v] = first.to_array().map(|value| value as usize);
            let (st, side) = (self.st as usize, self.uv as usize);
            let (row, start) = (&self.rows[frame * st + t], (s * side + v) * side + u);
            for (pixel, offset) in [0, 1, side, side + 1].into_iter().enumerate() {
                let corner = Vec2::new((pixel & 1) as f32, (pixel >> 1) as f32);
                let entry = row[(start + offset) * self.ways + way];
                near[4 * view + pixel] = (weight * share_of(uv - first, corner), entry);
            }
        }
        Some(())
    }
}

/// The share of a corner (of 0 and 1) in a bilinear blend.
#[inline]
fn share_of(part: Vec2, corner: Vec2) -> f32 {
    let share = Vec2::ONE - (part - corner).abs();
    share.x * share.y
}

#[inline]
fn vector(kept: [i16; 3]) -> Vec3 {
    Vec3::from(kept.map(f32::from)) / UNIT
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::regions::Regions;
    use catoptric_core::math::random::Stream;
    use catoptric_core::progress::Silent;
    use catoptric_core::scene::Material;
    use catoptric_core::scene::model::{AnalyticAsset, Model, Node};
    use catoptric_core::surface::AnalyticSurface;
    use catoptric_engine::optics::{fresnel_dielectric, reflect, refract};

    const RADIUS: f32 = 0.7;

    fn ball(material: Material) -> Scene {
        let mut model = Model { materials: vec![material], ..Model::default() };
        let surface = AnalyticSurface::Sphere { radius: f64::from(RADIUS) };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        model.nodes.push(Node { analytic, ..Node::default() });
        model.pose(&Default::default()).unwrap()
    }

    fn captured(scene: &Scene, sizes: [u32; 2], order: u32, has_lenses: bool) -> RayTransfer {
        let region = Regions::of(scene, 0.0).boxes[0];
        let tracer = Tracer::build(scene, |_| true);
        RayTransfer::capture(scene, &tracer, &region, sizes, order, has_lenses, &Silent).unwrap()
    }

    /// Places of the ball, and directions from there that do not graze it.
    fn seen(random: &mut Stream, least_cosine: f32) -> (Vec3, Vec3) {
        loop {
            let mut unit = || Vec3::from([0; 3].map(|_| random.next_between(-1.0, 1.0))).normalize();
            let (normal, towards) = (unit(), unit());
            if normal.dot(towards) > least_cosine {
                return (normal, towards);
            }
        }
    }

    /// How far two rays are apart where they are a few radii away.
    fn apart(found: &Ray, origin: Vec3, direction: Vec3) -> f32 {
        let off = found.origin + found.direction * 3.0 - origin;
        (off - direction * off.dot(direction)).length()
    }

    #[test]
    fn a_mirror_ball_sends_rays_where_the_law_says_and_better_with_more_views() {
        let scene = ball(Material::mirror("", Vec3::ONE));
        let mut means = Vec::new();
        for sizes in [[6, 24], [12, 48], [24, 96]] {
            let transfer = captured(&scene, sizes, 1, false);
            let (mut random, mut sum) = (Stream::new(3), 0.0);
            for _ in 0..2000 {
                let (normal, towards) = seen(&mut random, 0.3);
                let found = transfer.look_up(normal * RADIUS, towards, BounceKind::Reflect).expect("it is seen");
                assert!(found.share.distance(Vec3::ONE) < 0.01);
                sum += apart(&found.ray, normal * RADIUS, reflect(-towards, normal));
                assert!(transfer.look_up(normal * RADIUS, towards, BounceKind::Transmit).is_none());
            }
            means.push(sum / 2000.0);
        }
        // Errors of a linear blend fall with the square of the step.
        assert!(means[1] < 0.4 * means[0] && means[2] < 0.4 * means[1] && means[2] < 0.02, "{means:?}");
    }

    #[test]
    fn a_glass_ball_refracts_rays_twice_and_keeps_their_light() {
        const IOR: f32 = 1.4;
        let scene = ball(Material::glass("", IOR));
        let transfer = captured(&scene, [24, 96], 2, true);
        let mut random = Stream::new(4);
        let (mut off, mut lost) = (0.0, 0.0);
        for _ in 0..1000 {
            let (normal, towards) = seen(&mut random, 0.4);
            let inner = refract(-towards, normal, 1.0 / IOR).unwrap();
            let back = normal - inner * (2.0 * normal.dot(inner));
            let outer = refract(inner, -back, IOR).unwrap();
            let transmitted = 1.0 - fresnel_dielectric(inner.dot(back), IOR);
            let found = transfer.look_up(normal * RADIUS, towards, BounceKind::Transmit).expect("it is seen");
            lost += (found.share.x - transmitted).abs() / 1000.0;
            off += apart(&found.ray, back * RADIUS, outer) / 1000.0;
        }
        assert!(off < 0.02 && lost < 0.005, "{off} apart, {lost} of the light");
        // One event is not enough to get out.
        let short = captured(&scene, [6, 24], 1, true);
        assert!(short.look_up(Vec3::X * RADIUS, Vec3::X, BounceKind::Transmit).is_none());
    }

    #[test]
    fn what_is_no_ray_of_the_region_has_no_answer() {
        let transfer = captured(&ball(Material::mirror("", Vec3::ONE)), [4, 8], 1, false);
        for (position, towards) in [
            (Vec3::NAN, Vec3::X),
            (Vec3::ZERO, Vec3::NAN),
            (Vec3::ZERO, Vec3::ZERO),
            (Vec3::splat(50.0), Vec3::X),
            (Vec3::splat(-50.0), Vec3::X),
        ] {
            let found = transfer.look_up(position, towards, BounceKind::Reflect);
            assert!(found.is_none_or(|found| found.ray.direction.is_finite()), "{position} {towards}");
        }
        assert!(transfer.look_up(Vec3::NAN, Vec3::X, BounceKind::Reflect).is_none());
    }
}
