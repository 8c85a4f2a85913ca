//! Layers about a group, looked up.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::distances::{Distances, Met};
use super::shell::{RayLanes, Shell};
use super::surroundings::MOST_LAYERS;
use super::texels::{Footprints, Taps};
use super::texture::{Texel, Texture};
use crate::methods::lookup::lanes::{AT_ONCE, Lane, one, vector};
use crate::scene::{Ray, RayDifferential, Scene};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// One layer: a shell with its texture.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Of the shell.
    pub(super) center: Vec3,
    pub(super) shell: Shell,
    /// How far from the shell what the texture shows is; none: it is all on it.
    pub(super) distances: Option<Distances>,
    pub(super) texture: Texture,
}

/// Rays as they meet a layer.
struct Reached<const LANES: usize> {
    is_met: [bool; LANES],
    /// How far along the ray, or behind how many layers.
    place: Lane<LANES>,
    /// What they meet, where distances are known.
    met: Option<Met<LANES>>,
}

/// What is behind layers that hide less than this share is not worth a look.
const OPAQUE: f32 = 1.0 / 1024.0;

/// As many viewpoints are blended at most.
const MOST_BLENDED: usize = 4;

impl Layer {
    /// Whether all that it shows (as the layer of a number) is further than a place along a ray from an origin, for sure.
    #[inline(always)] // for the instructions of its caller
    fn is_beyond(&self, number: usize, place: f32, origin: Vec3) -> bool {
        match &self.distances {
            None => number as f32 > place,
            Some(distances) => distances.nearest() - origin.length() > place,
        }
    }

    /// Where rays (from its centre) meet it, as the layer of a number.
    #[inline(always)] // for the instructions of its caller
    fn reached<const LANES: usize>(
        &self,
        number: usize,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
    ) -> Reached<LANES> {
        // Without distances the shells follow each other, the nearest first.
        let Some(distances) = &self.distances else {
            return Reached { is_met: *wanted, place: [number as f32; LANES], met: None };
        };
        let met = distances.met(&self.shell, rays, wanted);
        Reached { is_met: met.is_met, place: met.distance, met: Some(met) }
    }

    /// Where rays look it up that reach it so.
    #[inline(always)] // for the instructions of its caller
    fn footprints<const LANES: usize>(&self, rays: &RayLanes<LANES>, reached: &Reached<LANES>) -> Footprints<LANES> {
        let Some(Met { distance, share, is_inward, outward, .. }) = &reached.met else {
            return self.shell.footprints(rays);
        };
        // They meet the shell where it is as far away as what they meet.
        let mut shrunk = *rays;
        if is_inward.contains(&true) {
            // Shells are looked up where rays leave them: where one comes in, the same line is followed back from within.
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
        tap: &mut impl FnMut(usize, Taps),
    ) {
        if wanted.contains(&true) {
            self.texture.layout.taps(&self.footprints(rays, reached), wanted, tap);
        }
    }

    /// How far a ray goes until it meets what is seen.
    fn distance(&self, ray: &Ray) -> f32 {
        let origin = ray.origin - self.center;
        let rays = RayLanes::sharp(one(origin), one(ray.direction));
        match &self.distances {
            Some(distances) => distances.met(&self.shell, &rays, &[true]).distance[0],
            None => self.shell.distance(origin, ray.direction),
        }
    }

    /// The texel of the finest level that a ray meets; none where it meets nothing.
    pub(super) fn texel_at(&self, ray: &Ray) -> Option<u32> {
        let rays = RayLanes::sharp(one(ray.origin - self.center), one(ray.direction));
        let reached = self.reached(0, &rays, &[true]);
        let [texel] = self.texture.layout.nearest(&self.footprints(&rays, &reached).places);
        (reached.is_met[0] && texel != u32::MAX).then_some(texel)
    }

    /// Whether it surrounds a place: rays from there meet it from within.
    pub(super) fn surrounds(&self, place: Vec3) -> bool {
        let [share] = self.shell.shares_of(&one(place - self.center));
        share < 1.0
    }

    /// The texels that a ray reads.
    pub(super) fn taps_of(&self, ray: &Ray, change: &RayDifferential, mut tap: impl FnMut(Taps)) {
        let rays = RayLanes::new(&[(*ray, *change)], self.center);
        let reached = self.reached(0, &rays, &[true]);
        self.taps_at(&rays, &reached, &reached.is_met, &mut |_, taps| tap(taps));
    }

    /// What a ray sees of it: radiance times opacity, and opacity.
    pub(super) fn seen(&self, ray: &Ray, change: &RayDifferential) -> Vec4 {
        let mut sum = Vec4::ZERO;
        self.taps_of(ray, change, |taps| sum += taps.sum(&self.texture.texels));
        sum
    }
}

/// The layers about a group of a viewpoint, the nearest first.
pub(super) type LayersAbout<'a> = Vec<&'a Layer>;

/// The layers of several viewpoints about a group, with their shares. All of them have the same shells, and textures of one size.
pub(super) type Blended<'a> = [(LayersAbout<'a>, f32)];

/// What arrives along rays, each with its change from pixel to pixel: layer over layer before the scene's background, blended over
/// viewpoints. Layers that know how far away what they show is hide each other by that, ray by ray; others in their order.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
pub(super) fn radiance(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential)],
    mut arrived: impl FnMut(usize, Vec3),
) {
    let layers = maps.first().map_or(0, |(layers, _)| layers.len());
    let mut seen = vec![[[Vec4::ZERO; MOST_BLENDED]; AT_ONCE]; layers];
    let (chunks, rest) = rays.as_chunks::<AT_ONCE>();
    for (number, chunk) in chunks.iter().enumerate() {
        let found = radiance_of(maps, scene, chunk, AT_ONCE, &mut seen);
        (0..AT_ONCE).for_each(|lane| arrived(number * AT_ONCE + lane, found[lane]));
    }
    if let Some(last) = rest.last() {
        let mut padded = [*last; AT_ONCE];
        padded[..rest.len()].copy_from_slice(rest);
        let found = radiance_of(maps, scene, &padded, rest.len(), &mut seen);
        (0..rest.len()).for_each(|lane| arrived(chunks.len() * AT_ONCE + lane, found[lane]));
    }
}

/// What rays see of one layer, for each viewpoint.
type SeenByLanes = [[Vec4; MOST_BLENDED]; AT_ONCE];

/// What arrives along the first `count` of some rays. `seen` has room for every layer.
#[inline(always)] // for the instructions of its caller
fn radiance_of(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential); AT_ONCE],
    count: usize,
    seen: &mut [SeenByLanes],
) -> [Vec3; AT_ONCE] {
    let mut radiance = [Vec3::ZERO; AT_ONCE];
    let maps = &maps[..maps.len().min(MOST_BLENDED)];
    let Some((first, _)) = maps.first() else { return radiance };
    let Some(nearest) = first.first() else {
        for lane in 0..count {
            radiance[lane] = scene.background(rays[lane].0.direction);
        }
        return radiance;
    };
    let about_nearest = RayLanes::new(rays, nearest.center);
    let (mut lanes, mut center) = (about_nearest, nearest.center);
    let mut places = [[f32::INFINITY; AT_ONCE]; MOST_LAYERS];
    // Where each ray is stopped for good, as far as is known.
    let mut stopped: Lane<AT_ONCE> = [f32::INFINITY; AT_ONCE];
    for (number, (layer, seen)) in first.iter().zip(seen.iter_mut()).enumerate().take(MOST_LAYERS) {
        if layer.center != center {
            (lanes, center) = (about_nearest.from(layer.center - nearest.center), layer.center);
        }
        let mut wanted = [false; AT_ONCE];
        for lane in 0..AT_ONCE {
            wanted[lane] = lane < count && !layer.is_beyond(number, stopped[lane], vector(&lanes.origins, lane));
        }
        if !wanted.contains(&true) {
            continue;
        }
        let reached = layer.reached(number, &lanes, &wanted);
        for lane in 0..AT_ONCE {
            wanted[lane] = reached.is_met[lane] && reached.place[lane] < stopped[lane];
        }
        if !wanted.contains(&true) {
            continue;
        }
        let mut textures: [&[Texel]; MOST_BLENDED] = [&[]; MOST_BLENDED];
        for (texels, (map, _)) in textures.iter_mut().zip(maps) {
            *texels = map.get(number).map_or(&[], |layer| &layer.texture.texels);
        }
        let textures = &textures[..maps.len()];
        *seen = [[Vec4::ZERO; MOST_BLENDED]; AT_ONCE];
        layer.taps_at(&lanes, &reached, &wanted, &mut |lane, taps| {
            for (seen, texels) in seen[lane].iter_mut().zip(textures) {
                *seen += taps.sum(texels);
            }
        });
        for lane in 0..AT_ONCE {
            if wanted[lane] {
                places[number][lane] = reached.place[lane];
                let hides = seen[lane][..maps.len()].iter().fold(1.0f32, |least, seen| least.min(seen.w));
                stopped[lane] = if hides > 1.0 - OPAQUE { reached.place[lane] } else { stopped[lane] };
            }
        }
    }
    let layers = first.len().min(MOST_LAYERS);
    for lane in 0..count {
        // The nearest first; of equals the first.
        let mut order = [(f32::INFINITY, 0); MOST_LAYERS];
        let mut met = 0;
        for number in (0..layers).filter(|number| places[*number][lane] < f32::INFINITY) {
            let place = places[number][lane];
            let at = order[..met].partition_point(|(other, _)| *other <= place);
            order.copy_within(at..met, at + 1);
            order[at] = (place, number);
            met += 1;
        }
        let order = &order[..met];
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
                let background = *background.get_or_insert_with(|| scene.background(rays[lane].0.direction));
                sum += (background * sum.w).extend(0.0);
            }
            radiance[lane] += sum.xyz() * *share;
        }
        // Inferred textures may swing below zero beside what is bright.
        radiance[lane] = radiance[lane].max(Vec3::ZERO);
    }
    radiance
}

/// How far away what a ray meets is taken to be: the nearest of the layers that hide more than half.
pub(super) fn distance(maps: &Blended<'_>, ray: &Ray) -> f32 {
    let layers = maps.first().into_iter().flat_map(|(layers, _)| layers);
    let hides = |layer: &&&Layer| layer.seen(ray, &RayDifferential::default()).w > 0.5;
    layers.filter(hides).map(|layer| layer.distance(ray)).fold(f32::INFINITY, f32::min)
}

impl Layer {
    /// Memory.
    pub(super) fn byte_count(&self) -> u64 {
        let distances = self.distances.as_ref().map_or(0, Distances::byte_count);
        size_of_val(self.texture.texels.as_slice()) as u64 + distances
    }
}
