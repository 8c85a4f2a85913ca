//! The mapping from rays that enter a region to rays that leave it: a second light field, of rays in place of light
//! (Heidrich, Lensch, Cohen, Seidel 1999, Light field techniques for reflections and refractions).

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

/// Half the width of the plane through the middle, where the rays' pixels are, in the same widths.
const HALF_UV: f32 = 1.0;

/// Places of the region are at least half a width before the plane of views; nearer ones are none of it. Chosen, not
/// measured.
const MIN_AHEAD: f32 = 0.25;

/// Rays whose directions are further apart than this (a cosine) have gone different ways and are not blended. Much less
/// would tear the reflection near the rim of a ball, where neighbours are 30 degrees apart. Not measured beyond that.
const APART: f32 = 0.3;

/// Positions are kept from -1 to 1 in widths of the cube, directions as they are.
const UNIT: f32 = i16::MAX as f32;

/// A leaving ray, and the throughput of light from there on the way, without that of the first surface.
#[derive(Clone, Copy, Debug)]
pub struct Leaving {
    /// The ray that leaves.
    pub ray: Ray,
    /// The share of light that comes along it.
    pub share: Vec3,
}

/// A kept ray.
#[derive(Clone, Copy, Debug)]
struct TransferEntry {
    origin: [i16; 3],
    direction: [i16; 3],
    /// [`packed`]; 0 where no light arrives, [`MISSED`] where no surface is met.
    share: u32,
}

/// A value that no share has.
const MISSED: u32 = u32::MAX;

impl TransferEntry {
    const fn without_ray(share: u32) -> Self {
        Self { origin: [0; 3], direction: [0; 3], share }
    }
}

/// The rays that leave a region for those that enter it.
#[derive(Clone, Debug)]
pub struct RayTransfer {
    /// The middle of the region and the width of the cube about it.
    center: Vec3,
    width: f32,
    /// Views a side, and pixels a side of each.
    st: u32,
    uv: u32,
    /// Half the width of the plane of pixels: [`HALF_UV`] and a step between views, so that neighbouring views hold the
    /// same places.
    half_uv: f32,
    /// Leaving rays of every ray: the one that is reflected first and, with lenses, the one that is refracted.
    ways: usize,
    /// Rows of views of every frame: view after view, row after row of pixels, path after path.
    rows: Vec<Vec<TransferEntry>>,
}

impl RayTransfer {
    /// Captures the rays through the reflectors and lenses that `tracer` knows, in a region, with paths of up to
    /// `order` events; `st` and `uv` are at least 2.
    pub fn capture(
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

    /// Appends the entries of a ray.
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

    /// The leaving ray of a ray that meets a place of a region's surfaces on its way from `towards` (a unit direction),
    /// by a first event; `None` where the rays about it were not kept, or carry nothing.
    ///
    /// The four views about the ray are asked for the pixels where they see that place, as if it were a focal surface;
    /// those that see no surface do not count, and the others count by their shares in the blend.
    #[inline]
    pub fn look_up(&self, position: Vec3, towards: Vec3, first: BounceKind) -> Option<Leaving> {
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
            // The line from the view through the place goes on to the plane of pixels.
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
