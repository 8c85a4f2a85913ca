//! Layers about a group, looked up.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::distances::{Distances, Met};
use super::shell::{RayLanes, Shell};
use super::texels::{Taps, Texture};
use crate::methods::lookup::lanes::{AT_ONCE, Lane, one, vector};
use crate::scene::{Ray, RayDifferential, Scene};
use glam::{Vec3, Vec4, Vec4Swizzles};

/// One layer: a shell with its texture.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) shell: Shell,
    /// How far from the shell what the texture shows is; none: it is all on it.
    pub(super) distances: Option<Distances>,
    pub(super) texture: Texture,
}

/// Rays as they meet a layer.
struct Reached<const LANES: usize> {
    /// As they meet the shell where it is as far away as what they meet.
    rays: RayLanes<LANES>,
    is_met: [bool; LANES],
    /// How far along the ray, or behind how many layers.
    place: Lane<LANES>,
}

/// The layers about a group, the nearest first.
#[derive(Clone, Debug, Default)]
pub(super) struct LayeredMap {
    /// Of all shells.
    pub(super) center: Vec3,
    pub(super) layers: Vec<Layer>,
}

/// What is behind layers that hide less than this share is not worth a look.
const OPAQUE: f32 = 1.0 / 1024.0;

/// As many layers are looked up at most.
const MOST_LAYERS: usize = 16;

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

    /// Where rays (from the centre) meet it, as the layer of a number.
    #[inline(always)] // for the instructions of its caller
    fn reached<const LANES: usize>(
        &self,
        number: usize,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
    ) -> Reached<LANES> {
        // Without distances the shells follow each other, the nearest first.
        let Some(distances) = &self.distances else {
            return Reached { rays: *rays, is_met: *wanted, place: [number as f32; LANES] };
        };
        let Met { share, is_met } = distances.met(&self.shell, rays, wanted);
        let rays = rays.shrunk(&share);
        let mut place = self.shell.distances(&rays);
        for lane in 0..LANES {
            place[lane] *= share[lane];
        }
        Reached { rays, is_met, place }
    }

    /// Calls with the texels that rays read which are as [`Reached`] has them, as far as they are wanted.
    #[inline(always)] // for the instructions of its caller
    fn taps_at<const LANES: usize>(
        &self,
        rays: &RayLanes<LANES>,
        wanted: &[bool; LANES],
        tap: &mut impl FnMut(usize, Taps),
    ) {
        if wanted.contains(&true) {
            self.texture.layout.taps(&self.shell.footprints(rays), wanted, tap);
        }
    }

    /// How far a ray (from the centre) goes until it meets what is seen.
    fn distance(&self, ray: &Ray) -> f32 {
        let rays = RayLanes::sharp(one(ray.origin), one(ray.direction));
        let met = self.distances.as_ref().map(|distances| distances.met(&self.shell, &rays, &[true]));
        let share = met.map_or(1.0, |met| met.share[0]);
        share * self.shell.distance(ray.origin / share, ray.direction)
    }

    /// The texels that a ray (from the centre) reads.
    pub(super) fn taps_of(&self, ray: &Ray, change: &RayDifferential, mut tap: impl FnMut(Taps)) {
        let reached = self.reached(0, &RayLanes::new(&[(*ray, *change)], Vec3::ZERO), &[true]);
        self.taps_at(&reached.rays, &reached.is_met, &mut |_, taps| tap(taps));
    }

    /// What a ray (from the centre) sees of it: radiance times opacity, and opacity.
    pub(super) fn seen(&self, ray: &Ray, change: &RayDifferential) -> Vec4 {
        let mut sum = Vec4::ZERO;
        self.taps_of(ray, change, |taps| sum += taps.sum(&self.texture.texels));
        sum
    }
}

/// The layers of several viewpoints about a group, with their shares. All of them have the same shells, and textures of one size.
pub(super) type Blended<'a> = [(&'a LayeredMap, f32)];

/// What arrives along rays, each with its change from pixel to pixel: layer over layer before the scene's background, blended over
/// viewpoints. Layers that know how far away what they show is hide each other by that, ray by ray; others in their order.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(super) fn radiance(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential)],
    mut arrived: impl FnMut(usize, Vec3),
) {
    let layers = maps.first().map_or(0, |(map, _)| map.layers.len());
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
    let lanes = RayLanes::new(rays, first.center);
    let mut places = [[f32::INFINITY; AT_ONCE]; MOST_LAYERS];
    // Where each ray is stopped for good, as far as is known.
    let mut stopped: Lane<AT_ONCE> = [f32::INFINITY; AT_ONCE];
    for (number, (layer, seen)) in first.layers.iter().zip(seen.iter_mut()).enumerate().take(MOST_LAYERS) {
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
        let mut textures: [&[Vec4]; MOST_BLENDED] = [&[]; MOST_BLENDED];
        for (texels, (map, _)) in textures.iter_mut().zip(maps) {
            *texels = map.layers.get(number).map_or(&[], |layer| &layer.texture.texels);
        }
        let textures = &textures[..maps.len()];
        *seen = [[Vec4::ZERO; MOST_BLENDED]; AT_ONCE];
        layer.taps_at(&reached.rays, &wanted, &mut |lane, taps| {
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
    let layers = first.layers.len().min(MOST_LAYERS);
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
                let background = *background.get_or_insert_with(|| scene.background(vector(&lanes.directions, lane)));
                sum += (background * sum.w).extend(0.0);
            }
            radiance[lane] += sum.xyz() * *share;
        }
        // Inferred textures may swing below zero beside what is bright.
        radiance[lane] = radiance[lane].max(Vec3::ZERO);
    }
    radiance
}

/// How far away what a ray meets is taken to be.
pub(super) fn distance(maps: &Blended<'_>, ray: &Ray) -> f32 {
    maps.first().map_or(f32::INFINITY, |(map, _)| map.distance(ray))
}

impl LayeredMap {
    /// How far away what a ray meets is taken to be: the nearest of the layers that hide more than half.
    fn distance(&self, ray: &Ray) -> f32 {
        let from_center = Ray { origin: ray.origin - self.center, ..*ray };
        let hides = |layer: &&Layer| layer.seen(&from_center, &RayDifferential::default()).w > 0.5;
        let distances = self.layers.iter().filter(hides).map(|layer| layer.distance(&from_center));
        distances.fold(f32::INFINITY, f32::min)
    }

    /// Memory of all textures.
    pub(super) fn byte_count(&self) -> u64 {
        let distances = |layer: &Layer| layer.distances.as_ref().map_or(0, Distances::byte_count);
        let layer = |layer: &Layer| size_of_val(layer.texture.texels.as_slice()) as u64 + distances(layer);
        self.layers.iter().map(layer).sum()
    }
}
