//! Layers about a group, looked up.

#![allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser

use super::distances::{Distances, Met};
use super::shell::{RayLanes, Shell};
use super::texels::{Taps, Texture};
use crate::methods::lookup::lanes::{AT_ONCE, one, vector};
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

/// The layers about a group, the nearest first.
#[derive(Clone, Debug, Default)]
pub(super) struct LayeredMap {
    /// Of all shells.
    pub(super) center: Vec3,
    pub(super) layers: Vec<Layer>,
}

/// What is behind layers that hide less than this share is not worth a look.
const OPAQUE: f32 = 1.0 / 1024.0;

/// As many viewpoints are blended at most.
const MOST_BLENDED: usize = 4;

impl Layer {
    /// Calls with the texels that rays (from the centre) read, as far as these are wanted.
    #[inline(always)] // for the instructions of its caller
    fn taps<const LANES: usize>(
        &self,
        rays: &RayLanes<LANES>,
        mut wanted: [bool; LANES],
        tap: &mut impl FnMut(usize, Taps),
    ) {
        let footprints = match &self.distances {
            None => self.shell.footprints(rays),
            Some(distances) => {
                let Met { share, is_met } = distances.met(&self.shell, rays, &wanted);
                if !is_met.contains(&true) {
                    return;
                }
                wanted = is_met;
                self.shell.footprints(&rays.shrunk(&share))
            }
        };
        self.texture.layout.taps(&footprints, &wanted, tap);
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
        self.taps(&RayLanes::new(&[(*ray, *change)], Vec3::ZERO), [true], &mut |_, taps| tap(taps));
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
/// viewpoints.
#[multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"))]
pub(super) fn radiance(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential)],
    mut arrived: impl FnMut(usize, Vec3),
) {
    let (chunks, rest) = rays.as_chunks::<AT_ONCE>();
    for (number, chunk) in chunks.iter().enumerate() {
        let found = radiance_of(maps, scene, chunk, AT_ONCE);
        (0..AT_ONCE).for_each(|lane| arrived(number * AT_ONCE + lane, found[lane]));
    }
    if let Some(last) = rest.last() {
        let mut padded = [*last; AT_ONCE];
        padded[..rest.len()].copy_from_slice(rest);
        let found = radiance_of(maps, scene, &padded, rest.len());
        (0..rest.len()).for_each(|lane| arrived(chunks.len() * AT_ONCE + lane, found[lane]));
    }
}

/// What arrives along the first `count` of some rays.
#[inline(always)] // for the instructions of its caller
fn radiance_of<const LANES: usize>(
    maps: &Blended<'_>,
    scene: &Scene,
    rays: &[(Ray, RayDifferential); LANES],
    count: usize,
) -> [Vec3; LANES] {
    let mut radiance = [Vec3::ZERO; LANES];
    let maps = &maps[..maps.len().min(MOST_BLENDED)];
    let Some((first, _)) = maps.first() else { return radiance };
    let lanes = RayLanes::new(rays, first.center);
    // Of every ray and viewpoint what has arrived and, last, the share that passes what hides it.
    let mut sums = [[Vec4::W; MOST_BLENDED]; LANES];
    let mut wanted: [bool; LANES] = std::array::from_fn(|lane| lane < count);
    for (number, layer) in first.layers.iter().enumerate() {
        let mut textures: [&[Vec4]; MOST_BLENDED] = [&[]; MOST_BLENDED];
        for (texels, (map, _)) in textures.iter_mut().zip(maps) {
            *texels = map.layers.get(number).map_or(&[], |layer| &layer.texture.texels);
        }
        let textures = &textures[..maps.len()];
        let mut seen = [[Vec4::ZERO; MOST_BLENDED]; LANES];
        layer.taps(&lanes, wanted, &mut |lane, taps| {
            for (seen, texels) in seen[lane].iter_mut().zip(textures) {
                *seen += taps.sum(texels);
            }
        });
        let mut any = false;
        for lane in 0..LANES {
            if !wanted[lane] {
                continue;
            }
            let mut most = 0.0f32;
            for (sum, seen) in sums[lane].iter_mut().zip(&seen[lane]).take(maps.len()) {
                let passes = sum.w * (1.0 - seen.w.clamp(0.0, 1.0));
                *sum = (sum.xyz() + seen.xyz() * sum.w).extend(passes);
                most = most.max(passes);
            }
            wanted[lane] = most >= OPAQUE;
            any |= wanted[lane];
        }
        if !any {
            break;
        }
    }
    for lane in 0..count {
        let background = match wanted[lane] {
            true => scene.background(vector(&lanes.directions, lane)),
            false => Vec3::ZERO,
        };
        let blended = |sum: Vec3, ((_, share), own): (&(&LayeredMap, f32), &Vec4)| {
            sum + (own.xyz() + background * own.w) * *share
        };
        // Inferred textures may swing below zero beside what is bright.
        radiance[lane] = maps.iter().zip(&sums[lane]).fold(Vec3::ZERO, blended).max(Vec3::ZERO);
    }
    radiance
}

/// How far away what a ray meets is taken to be.
pub(super) fn distance(maps: &Blended<'_>, ray: &Ray) -> f32 {
    maps.first().map_or(f32::INFINITY, |(map, _)| map.distance(ray))
}

impl LayeredMap {
    /// How far away what a ray meets is taken to be: the shell of the first layer that hides more than half.
    fn distance(&self, ray: &Ray) -> f32 {
        let from_center = Ray { origin: ray.origin - self.center, ..*ray };
        let hides = |layer: &&Layer| layer.seen(&from_center, &RayDifferential::default()).w > 0.5;
        let layer = self.layers.iter().find(hides);
        layer.map_or(f32::INFINITY, |layer| layer.distance(&from_center))
    }

    /// Memory of all textures.
    pub(super) fn byte_count(&self) -> u64 {
        let distances = |layer: &Layer| layer.distances.as_ref().map_or(0, Distances::byte_count);
        let layer = |layer: &Layer| size_of_val(layer.texture.texels.as_slice()) as u64 + distances(layer);
        self.layers.iter().map(layer).sum()
    }
}
