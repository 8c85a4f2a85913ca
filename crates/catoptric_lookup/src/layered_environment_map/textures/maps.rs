//! Layers about a group, looked up.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::distances::{Distances, HitLanes};
use super::texture::{LayerTexel, LayerTexture};
use crate::layered_environment_map::shell::{RayLanes, Shell};
use crate::layered_environment_map::texels::{Footprints, TexelTaps};
use catoptric_core::math::lanes::{Lanes, MANY_LANES, Vec3Lanes};
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// Largest number of layers.
pub(crate) const MAX_LAYERS: usize = 17;

/// A layer: a shell with its texture.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Centre of the shell, in world space.
    pub center: Vec3,
    /// The shell.
    pub shell: Shell,
    /// The depths of the texture's surfaces; `None`: they all lie on the shell.
    pub distances: Option<Distances>,
    /// The light.
    pub texture: LayerTexture,
}

/// Rays as they meet a layer.
struct Reached<const LANES: usize> {
    is_met: [bool; LANES],
    /// The distance along the ray, or the number of layers before.
    place: Lanes<LANES>,
    /// Hits on captured depths, if the layer has any.
    met: Option<HitLanes<LANES>>,
}

/// The least share that layers must leave for those behind to be looked up. A quarter of a step of eight bits; not
/// measured.
const OPAQUE: f32 = 1.0 / 1024.0;

/// Largest number of viewpoints that are blended.
const MAX_BLENDED: usize = 4;

impl Layer {
    /// True if everything that the layer (with a number) shows is certainly further than a place along a ray from an
    /// origin.
    #[inline(always)] // for the instructions of its caller
    fn is_beyond(&self, number: usize, place: f32, origin: Vec3) -> bool {
        match &self.distances {
            None => number as f32 > place,
            Some(distances) => distances.nearest() - origin.length() > place,
        }
    }

    /// Hits of rays (relative to its centre) on it, as the layer of a number.
    #[inline(always)] // for the instructions of its caller
    fn reached<const LANES: usize>(
        &self,
        number: usize,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
    ) -> Reached<LANES> {
        // Without distances the shells follow each other, the nearest first.
        let Some(distances) = &self.distances else {
            return Reached { is_met: *wanted, place: Lanes::splat(number as f32), met: None };
        };
        let met = distances.met(&self.shell, rays, wanted);
        Reached { is_met: met.is_met, place: met.distance, met: Some(met) }
    }

    /// Footprints of look-ups by rays that reach it so.
    #[inline(always)] // for the instructions of its caller
    fn footprints<const LANES: usize>(&self, rays: &RayLanes<LANES>, reached: &Reached<LANES>) -> Footprints<LANES> {
        let Some(HitLanes { distance, share, is_inward, outward, .. }) = &reached.met else {
            return self.shell.footprints(rays);
        };
        // The shell is scaled so that rays meet it at the distance of their hits.
        let mut shrunk = *rays;
        if is_inward.contains(&true) {
            // Shells are looked up where rays leave them: where one comes in, the same line is followed back from
            // within.
            let mut within = *distance;
            for lane in 0..LANES {
                within[lane] += 0.5 * (outward[lane] - distance[lane]);
            }
            shrunk.turn_round(is_inward, &within);
        }
        shrunk.shrink(share);
        let mut footprints = self.shell.footprints(&shrunk);
        // A ray may lie in its grown shell, where the places that their crossings are at mean nothing.
        let places = rays.at(distance);
        self.shell.hold_at(&mut footprints, &places, &rays.widths(distance, &places));
        footprints
    }

    /// Calls with the texels that rays read which reach it so, as far as they are wanted.
    #[inline(always)] // for the instructions of its caller
    fn taps_at<const LANES: usize>(
        &self,
        rays: &RayLanes<LANES>,
        reached: &Reached<LANES>,
        wanted: &[bool; LANES],
        tap: &mut impl FnMut(usize, TexelTaps),
    ) {
        if wanted.contains(&true) {
            self.texture.layout.taps(&self.footprints(rays, reached), wanted, tap);
        }
    }

    /// The distance along a ray at which it meets a surface.
    fn distance(&self, ray: &Ray) -> f32 {
        let origin = ray.origin - self.center;
        let rays = RayLanes::sharp(Vec3Lanes::one(origin), Vec3Lanes::one(ray.direction));
        match &self.distances {
            Some(distances) => distances.met(&self.shell, &rays, &[true]).distance[0],
            None => self.shell.distance(origin, ray.direction),
        }
    }

    /// The texel of the finest level that a ray meets; returns `None` if it meets nothing.
    pub fn texel_at(&self, ray: &Ray) -> Option<u32> {
        let rays = RayLanes::sharp(Vec3Lanes::one(ray.origin - self.center), Vec3Lanes::one(ray.direction));
        let reached = self.reached(0, &rays, &[true]);
        let [texel] = self.texture.layout.nearest(&self.footprints(&rays, &reached).places);
        (reached.is_met[0] && texel != u32::MAX).then_some(texel)
    }

    /// Returns true for places within the shell: rays from there meet it from within.
    pub(crate) fn surrounds(&self, place: Vec3) -> bool {
        self.shell.shell_scale(&Vec3Lanes::one(place - self.center))[0] < 1.0
    }

    /// The texels that a ray reads.
    pub(crate) fn taps_of(&self, ray: &Ray, change: &RayDifferential, mut tap: impl FnMut(TexelTaps)) {
        let rays = RayLanes::new(&[(*ray, *change)], self.center);
        let reached = self.reached(0, &rays, &[true]);
        self.taps_at(&rays, &reached, &reached.is_met, &mut |_, taps| tap(taps));
    }

    /// Radiance times opacity along a ray, and opacity.
    pub(crate) fn seen(&self, ray: &Ray, change: &RayDifferential) -> Vec4 {
        let mut sum = Vec4::ZERO;
        self.taps_of(ray, change, |taps| sum += taps.sum(&self.texture.texels));
        sum
    }
}

/// The layers about a group of a viewpoint, the nearest first.
pub(crate) type LayersAbout<'a> = Vec<&'a Layer>;

/// The layers of several viewpoints about a group, with their shares. All of them have the same shells, and textures
/// of one size.
pub(crate) type Blended<'a> = [(LayersAbout<'a>, f32)];

/// Radiance that arrives along rays, each with its differential: layer over layer before the scene's background,
/// blended over viewpoints. Layers with depths hide each other by these, ray by ray; others in their order.
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
pub fn radiance(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential)],
    mut arrived: impl FnMut(usize, Vec3),
) {
    let layers = maps.first().map_or(0, |(layers, _)| layers.len());
    let mut seen = vec![[[Vec4::ZERO; MAX_BLENDED]; MANY_LANES]; layers];
    let (chunks, rest) = rays.as_chunks::<MANY_LANES>();
    for (number, chunk) in chunks.iter().enumerate() {
        let found = radiance_of(maps, scene, chunk, MANY_LANES, &mut seen);
        (0..MANY_LANES).for_each(|lane| arrived(number * MANY_LANES + lane, found[lane]));
    }
    if let Some(last) = rest.last() {
        let mut padded = [*last; MANY_LANES];
        padded[..rest.len()].copy_from_slice(rest);
        let found = radiance_of(maps, scene, &padded, rest.len(), &mut seen);
        (0..rest.len()).for_each(|lane| arrived(chunks.len() * MANY_LANES + lane, found[lane]));
    }
}

/// Radiance times opacity, and opacity, of one layer by lane and viewpoint.
type SeenByLanes = [[Vec4; MAX_BLENDED]; MANY_LANES];

/// Radiance that arrives along the first `count` of some rays. `seen` has room for every layer.
#[inline(always)] // for the instructions of its caller
fn radiance_of(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential); MANY_LANES],
    count: usize,
    seen: &mut [SeenByLanes],
) -> [Vec3; MANY_LANES] {
    let mut radiance = [Vec3::ZERO; MANY_LANES];
    let maps = &maps[..maps.len().min(MAX_BLENDED)];
    let Some((first, _)) = maps.first() else { return radiance };
    let Some(nearest) = first.first() else {
        for lane in 0..count {
            radiance[lane] = scene.background(rays[lane].0.direction);
        }
        return radiance;
    };
    let (mut lanes, mut center) = (RayLanes::new(rays, nearest.center), nearest.center);
    let mut places = [[f32::INFINITY; MANY_LANES]; MAX_LAYERS];
    // Distance along each ray of the nearest opaque layer so far.
    let mut stopped: Lanes<MANY_LANES> = Lanes::splat(f32::INFINITY);
    for (number, (layer, seen)) in first.iter().zip(seen.iter_mut()).enumerate().take(MAX_LAYERS) {
        if layer.center != center {
            // Lanes are made from the rays themselves, so that bits are as for a ray alone.
            (lanes, center) = (RayLanes::new(rays, layer.center), layer.center);
        }
        let mut wanted = [false; MANY_LANES];
        for lane in 0..MANY_LANES {
            wanted[lane] = lane < count && !layer.is_beyond(number, stopped[lane], lanes.origins.vector(lane));
        }
        if !wanted.contains(&true) {
            continue;
        }
        let reached = layer.reached(number, &lanes, &wanted);
        for lane in 0..MANY_LANES {
            wanted[lane] = reached.is_met[lane] && reached.place[lane] < stopped[lane];
        }
        if !wanted.contains(&true) {
            continue;
        }
        let mut textures: [&[LayerTexel]; MAX_BLENDED] = [&[]; MAX_BLENDED];
        for (texels, (map, _)) in textures.iter_mut().zip(maps) {
            *texels = map.get(number).map_or(&[], |layer| &layer.texture.texels);
        }
        let textures = &textures[..maps.len()];
        *seen = [[Vec4::ZERO; MAX_BLENDED]; MANY_LANES];
        layer.taps_at(&lanes, &reached, &wanted, &mut |lane, taps| {
            for (seen, texels) in seen[lane].iter_mut().zip(textures) {
                *seen += taps.sum(texels);
            }
        });
        for lane in 0..MANY_LANES {
            if wanted[lane] {
                places[number][lane] = reached.place[lane];
                let hides = seen[lane][..maps.len()].iter().fold(1.0f32, |least, seen| least.min(seen.w));
                stopped[lane] = if hides > 1.0 - OPAQUE { reached.place[lane] } else { stopped[lane] };
            }
        }
    }
    let layers = first.len().min(MAX_LAYERS);
    for lane in 0..count {
        let (order, met) = layers_by_place(&places[..layers], lane);
        radiance[lane] = blended_radiance(maps, scene, rays[lane].0.direction, seen, lane, &order[..met]);
        // Inferred textures may swing below zero beside bright texels.
        radiance[lane] = radiance[lane].max(Vec3::ZERO);
    }
    radiance
}

/// Layers that a ray (a lane) meets, as places along it and numbers, the nearest first and of equals the first; and
/// their count.
#[inline(always)] // for the instructions of its caller
fn layers_by_place(places: &[[f32; MANY_LANES]], lane: usize) -> ([(f32, usize); MAX_LAYERS], usize) {
    let mut order = [(f32::INFINITY, 0); MAX_LAYERS];
    let mut met = 0;
    for number in (0..places.len()).filter(|number| places[*number][lane] < f32::INFINITY) {
        let place = places[number][lane];
        let at = order[..met].partition_point(|(other, _)| *other <= place);
        order.copy_within(at..met, at + 1);
        order[at] = (place, number);
        met += 1;
    }
    (order, met)
}

/// Radiance of layers in an order, each over the next and the last over the background, blended over viewpoints.
#[inline(always)] // for the instructions of its caller
fn blended_radiance(
    maps: &Blended<'_>,
    scene: &Scene,
    direction: Vec3,
    seen: &[SeenByLanes],
    lane: usize,
    order: &[(f32, usize)],
) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    let mut background = None;
    for (index, (_, share)) in maps.iter().enumerate() {
        let mut sum = Vec4::W;
        for (_, number) in order {
            let own = seen[*number][lane][index];
            sum = (sum.xyz() + own.xyz() * sum.w).extend(sum.w * (1.0 - own.w.clamp(0.0, 1.0)));
            if sum.w < OPAQUE {
                break;
            }
        }
        if sum.w >= OPAQUE {
            let background = *background.get_or_insert_with(|| scene.background(direction));
            sum += (background * sum.w).extend(0.0);
        }
        radiance += sum.xyz() * *share;
    }
    radiance
}

/// Distance along a ray of the nearest layer with an opacity over one half.
pub(crate) fn distance(maps: &Blended<'_>, ray: &Ray) -> f32 {
    let layers = maps.first().into_iter().flat_map(|(layers, _)| layers);
    let hides = |layer: &&&Layer| layer.seen(ray, &RayDifferential::default()).w > 0.5;
    layers.filter(hides).map(|layer| layer.distance(ray)).fold(f32::INFINITY, f32::min)
}

/// The number of the layer that a ray shows: of those with an opacity over one half the nearest. Layers without depths
/// hide each other in their order. Returns `None` if all let it through.
pub(crate) fn shown_layer(maps: &Blended<'_>, ray: &Ray) -> Option<usize> {
    let (layers, _) = maps.first()?;
    let place = |(number, layer): (usize, &&Layer)| {
        let hides = layer.seen(ray, &RayDifferential::default()).w > 0.5;
        let place = if layer.distances.is_some() { layer.distance(ray) } else { number as f32 };
        hides.then_some((place, number))
    };
    let nearest = layers.iter().enumerate().filter_map(place).min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    Some(nearest.1)
}

impl Layer {
    /// Memory.
    pub(crate) fn byte_count(&self) -> u64 {
        let distances = self.distances.as_ref().map_or(0, Distances::byte_count);
        size_of_val(self.texture.texels.as_slice()) as u64 + distances
    }
}
