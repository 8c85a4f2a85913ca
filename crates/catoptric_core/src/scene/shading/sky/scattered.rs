//! Light that surfaces scatter onto each other, to several bounces.
//!
//! Each place at which the light of the sky is known looks around by rays; what these meet is lit by the light that is
//! known there, and, bounce by bounce, by what it gets itself from others (gathered radiosity: Cohen, Wallace 1993,
//! Radiosity and Realistic Image Synthesis, chapter 8). Rays are traced once, for all bounces. Neighbours share what
//! they find as far as they see alike: within a part of the distances around (after Ward, Rubinstein, Clear 1988).

use super::super::super::{
    AlphaMode, Light, LightStop, LightVisibility, LobeTexture, Material, Ray, Role, Scene, StoppingSurface,
};
use super::super::shade::{Barycentrics, SurfacePoint};
use super::Sky;
use super::gather::{GROUPS, Gathered, Point, Sample};
use super::neighbours::{Facing, Neighbourhoods};
use super::refine::Places;
use crate::math::portable::PortableMath;
use crate::math::random;
use crate::parallel;
use crate::progress::{Cancelled, Progress};
use glam::{Vec2, Vec3, Vec4};
use std::f32::consts::TAU;
use std::ops::Range;

/// Rays of a round, each for a part of all directions: one round at each place, or fewer rays where there are many.
const ROUND: usize = 16;

/// Rays that tell the light of a place, its own with those of its neighbours. Where there are fewer, a place has more
/// rounds, so many at most, and all places together so many.
const RAYS: f32 = 1024.0;
const MOST_ROUNDS: u32 = 64;
const MOST_ROUNDS_OF_ALL: usize = 64_000;

/// Places share what they find within so much of the distances that they see, in a mean in which near things count
/// most: that of their inverse fourth powers. Chosen between blotches and what is lost near small things.
const REACH: f32 = 0.25;

/// The nearest distance, in sizes of the scene.
const NEAREST: f32 = 1e-6;

/// Places that a thread takes at once.
const AT_ONCE: usize = 256;

/// A place of a surface that a ray of another place meets.
#[derive(Clone)]
struct MetPlace {
    /// The side of the place that looks there.
    side: u8,
    /// The side that is met.
    met_side: u8,
    triangle: u32,
    at: Vec2,
    /// The share of light that it scatters back along the ray.
    scattered: Vec3,
    /// The irradiance there by all that does not scatter it.
    irradiance: Vec3,
}

/// Surfaces all around a place.
#[derive(Clone, Default)]
struct Surroundings {
    /// Rays on each side.
    rays: [f32; 2],
    /// How many of them meet anything, and the sums of the inverse fourth powers of their lengths, in sizes of the
    /// scene.
    hits: [f32; 2],
    nearness: [f32; 2],
    met: Vec<MetPlace>,
}

impl Surroundings {
    fn add(&mut self, mut other: Self) {
        for side in 0..2 {
            self.rays[side] += other.rays[side];
            self.hits[side] += other.hits[side];
            self.nearness[side] += other.nearness[side];
        }
        self.met.append(&mut other.met);
    }
}

/// Finds the light that surfaces scatter onto each other at all places of a sky.
pub(super) struct Scattering<'a> {
    pub(super) scene: &'a Scene,
    /// The scene's size.
    pub(super) size: f32,
    pub(super) sky: &'a Sky,
    pub(super) visibility: &'a dyn LightVisibility,
    pub(super) progress: &'a dyn Progress,
}

impl Scattering<'_> {
    /// The irradiance by surfaces, on both sides, at the corners of triangles and then at other places, after so many
    /// bounces: in the order of [`super::shares::SurfaceShares::arriving`].
    pub(super) fn irradiances(&self, places: &Places<'_>, bounces: u32) -> Result<Vec<[Vec3; 2]>, Cancelled> {
        let (scene, corners) = (self.scene, places.corner_samples(self.scene));
        let size = self.size;
        let rays_of_corner = corners.each.min(ROUND);
        let sample_corner =
            |corner: usize, number: usize| corners.sample(scene, corner, number * corners.each / rays_of_corner);
        let sample_other = |place: usize, number: usize| places.sample(scene, place, number * GROUPS / ROUND);
        let mut of_corners = vec![Surroundings::default(); corners.count()];
        let mut of_others = vec![Surroundings::default(); places.others.len()];
        let once = |_: usize| 0..1;
        self.look_around(&mut of_corners, rays_of_corner, sample_corner, once)?;
        self.look_around(&mut of_others, ROUND, sample_other, once)?;
        let mut known = vec![[Vec3::ZERO; 2]; self.sky.shares.arriving.len()];
        // In the order of the light: nothing is known of vertices that nothing needs.
        let gathered = |of_corners: &[Surroundings], of_others: &[Surroundings], known: &[[Vec3; 2]]| {
            let scattered = |surroundings: &[Surroundings]| {
                parallel::map_collect(surroundings.len(), |place| self.scattered(&surroundings[place], known))
            };
            let mut gathered = corners.shared(scene, scattered(of_corners));
            gathered.push(Gathered::default());
            gathered.extend(scattered(of_others));
            gathered
        };
        let sums = |gathered: &[Gathered]| gathered.iter().flat_map(Gathered::by_surfaces).collect::<Vec<Vec4>>();
        let first = gathered(&of_corners, &of_others, &known);
        // Where there are so many corners that some have no rays, these share all they find along edges.
        let has_all = corners.count() == places.corner_count();
        let alone = if has_all { 0 } else { places.corner_count() + 1 };
        let facing = first.iter().enumerate().skip(alone).flat_map(|(place, gathered)| {
            let ((position, normal), [_, nearness]) = (places.middle(scene, place), gathered.hits_and_nearness());
            let reach = nearness.map(|nearness| REACH * size / nearness.max(f32::MIN_POSITIVE).sqrt().sqrt());
            let rays = gathered.by_surfaces().map(|sum| sum.w);
            let facing = |side: usize| Facing { position, normal: normal * [1.0, -1.0][side], reach: reach[side] };
            [0, 1].map(|side| (rays[side] > 0.0).then(|| facing(side)))
        });
        let neighbourhoods = Neighbourhoods::new(&facing.collect::<Vec<_>>(), size);
        let near = |mut sums: Vec<Vec4>| {
            let shared = neighbourhoods.sums(&sums[2 * alone..]);
            sums.truncate(2 * alone);
            sums.extend(shared);
            sums
        };
        let rounds = self.more_rounds(&first, &near(sums(&first)));
        drop(first);
        if has_all && rays_of_corner == ROUND {
            self.look_around(&mut of_corners, ROUND, sample_corner, |corner| 1..rounds[corner])?;
        }
        let others = &rounds[places.corner_count() + 1..];
        self.look_around(&mut of_others, ROUND, sample_other, |place| 1..others[place])?;
        for _ in 0..bounces {
            let near = near(sums(&gathered(&of_corners, &of_others, &known)));
            let mean = |sum: &Vec4| sum.truncate() / sum.w.max(1e-6);
            known = near.chunks_exact(2).map(|sides| [mean(&sides[0]), mean(&sides[1])]).collect();
        }
        Ok(known)
    }

    /// The number of rounds of rays that each place should have: of places with what they have gathered in the first
    /// one, and the sums with those of their neighbours.
    fn more_rounds(&self, gathered: &[Gathered], near: &[Vec4]) -> Vec<u32> {
        let wanted = gathered.iter().zip(near.chunks_exact(2)).map(|(gathered, near)| {
            // Where less is met, errors of that are seen less.
            let [hits, _] = gathered.hits_and_nearness();
            let rounds = |side: usize| RAYS * hits[side].powi(2) / near[side].w.max(1.0);
            rounds(0).max(rounds(1)).clamp(1.0, MOST_ROUNDS as f32)
        });
        let wanted: Vec<f32> = wanted.collect();
        let more = wanted.iter().map(|rounds| rounds - 1.0).sum::<f32>();
        let share = (MOST_ROUNDS_OF_ALL as f32 / more.max(1.0)).min(1.0);
        wanted.into_iter().map(|rounds| 1 + ((rounds - 1.0) * share) as u32).collect()
    }

    /// The irradiance of a place by its surroundings, from those at all places before.
    fn scattered(&self, surroundings: &Surroundings, known: &[[Vec3; 2]]) -> Gathered {
        let mut sums = [Vec3::ZERO; 2];
        for met in &surroundings.met {
            let side = usize::from(met.met_side);
            let again = self.sky.shares.interpolated(met.triangle, met.at, |corner| known[corner as usize][side]);
            sums[usize::from(met.side)] += met.scattered * (met.irradiance + again.unwrap_or(Vec3::ZERO));
        }
        Gathered::of_surfaces(sums, surroundings.hits, surroundings.nearness, surroundings.rays)
    }

    /// Adds what places see in some rounds, by so many samples.
    fn look_around(
        &self,
        surroundings: &mut [Surroundings],
        samples: usize,
        sample: impl Fn(usize, usize) -> Sample + Sync + Send,
        rounds: impl Fn(usize) -> Range<u32> + Sync + Send,
    ) -> Result<(), Cancelled> {
        let (count, at_once) = (surroundings.len(), (AT_ONCE / samples).max(1));
        let chunks = parallel::map_stage(self.progress, "light between surfaces", count.div_ceil(at_once), |chunk| {
            let places = chunk * at_once..((chunk + 1) * at_once).min(count);
            let around = |place: usize| self.around((0..samples).map(|number| sample(place, number)), rounds(place));
            places.map(around).collect::<Vec<_>>()
        })?;
        for (sum, found) in surroundings.iter_mut().zip(chunks.into_iter().flatten()) {
            sum.add(found);
        }
        Ok(())
    }

    fn around(&self, samples: impl Iterator<Item = Sample>, rounds: Range<u32>) -> Surroundings {
        let mut found = Surroundings::default();
        if rounds.is_empty() {
            return found;
        }
        for sample in samples {
            let point = Point::new(self.scene, 0, sample);
            for round in rounds.clone() {
                let number = round * ROUND as u32 + u32::from(sample.group) * ROUND as u32 / GROUPS as u32;
                let Vec2 { x, y } = random::sobol(number);
                // As often as its light counts: by the cosine.
                let (radius, angle) = (x.sqrt(), TAU * y);
                let [x, y, z] = [radius * angle.cosine(), radius * angle.sine(), (1.0 - x).max(0.0).sqrt()];
                let [at_x, at_y] = sample.at.to_array().map(|part| part.to_bits().into());
                let choice = random::unit(u64::from(sample.triangle) << 32 | u64::from(number), at_x, at_y);
                for side in 0..=usize::from(point.has_two_sides) {
                    found.rays[side] += 1.0;
                    let normal = point.normal * [1.0, -1.0][side];
                    let (across, along) = normal.any_orthonormal_pair();
                    let ray = Ray { origin: point.origins[side], direction: across * x + along * y + normal * z };
                    let Some(stop) = self.visibility.first_stop(self.scene, &ray) else { continue };
                    found.hits[side] += 1.0;
                    found.nearness[side] += (stop.distance / self.size).max(NEAREST).powi(-4);
                    let met = self.met(&ray, &stop, choice);
                    found.met.extend(met.map(|met| MetPlace { side: side as u8, ..met }));
                }
            }
        }
        found.met.shrink_to_fit();
        found
    }

    /// The place where a ray is stopped, if that scatters light. A number between 0 and 1 chooses the lamp that is
    /// asked for.
    fn met(&self, ray: &Ray, stop: &LightStop, choice: f32) -> Option<MetPlace> {
        let scene = self.scene;
        let point = match &stop.surface {
            StoppingSurface::Triangle(triangle, at) => {
                scene.surface_point(*triangle, &Barycentrics { value: *at, ..Barycentrics::default() })
            }
            StoppingSurface::Exact(object, hit) => scene.exact_encounter(*object, hit, ray, None).point,
        };
        let side = if point.geometric_normal.dot(ray.direction) > 0.0 { -1.0 } else { 1.0 };
        let material = scene.material_of(point.object);
        if side < 0.0 && material.is_one_sided() {
            return None;
        }
        let scattered = stop.passing * scene.scattered_share(material, &point);
        if scattered.max_element() <= 0.0 {
            return None;
        }
        let irradiance = self.irradiance(&point, side, choice);
        let met_side = u8::from(side < 0.0);
        Some(MetPlace { side: 0, met_side, triangle: point.triangle, at: point.barycentrics, scattered, irradiance })
    }

    /// The irradiance of a point by the sky, by emitters and by lights.
    fn irradiance(&self, point: &SurfacePoint, side: f32, choice: f32) -> Vec3 {
        let (scene, normal) = (self.scene, point.normal * side);
        let mut sum = scene.by_surfaces_onto(point, side);
        if let Some(environment) = &scene.environment {
            sum += self.sky.irradiance_at(environment.place(normal)) * scene.sky_share(point, side);
        }
        let lit = |light: &Light| {
            let (towards, irradiance) = light.arriving(point.position);
            irradiance * towards.dot(normal).max(0.0)
        };
        let lights = || scene.lights.iter().chain(self.sky.suns());
        let all: f32 = lights().map(|light| lit(light).element_sum()).sum();
        if !(all > 0.0 && all.is_finite()) {
            return sum;
        }
        // One light stands for all, chosen by how bright it is.
        let mut left = all * choice;
        for light in lights() {
            let irradiance = lit(light);
            let brightness = irradiance.element_sum();
            left -= brightness;
            if left < 0.0 && brightness > 0.0 {
                let passing = scene.shadow_start(point, side).passing(scene, light);
                return sum + irradiance * passing * (all / brightness);
            }
        }
        sum
    }
}

impl Scene {
    /// The share of light that a point of a surface scatters back on the side where it arrives.
    fn scattered_share(&self, material: &Material, point: &SurfacePoint) -> Vec3 {
        if material.unlit || matches!(material.role, Role::Reflector | Role::Lens) {
            return Vec3::ZERO;
        }
        let base = self.base_color(material, point);
        let mut share = if material.alpha_mode == AlphaMode::Blend { base.w } else { 1.0 };
        if let Some(facets) = &material.microfacets {
            let metallic = facets.texture.as_ref().map_or(1.0, |binding| self.sample(binding, point).z);
            share *= (1.0 - facets.metallic * metallic) * (1.0 - facets.specular.max_element());
        }
        if let Some(lobes) = material.lobes() {
            let texel = |texture| lobes.texture(texture).map(|binding| self.sample(binding, point));
            let passing = [
                lobes.transmission * texel(LobeTexture::Transmission).map_or(1.0, |texel| texel.x),
                lobes.diffuse_transmission * texel(LobeTexture::DiffuseTransmission).map_or(1.0, |texel| texel.w),
            ];
            share *= passing.map(|passing| 1.0 - passing).iter().product::<f32>();
        }
        (base.truncate() * share).clamp(Vec3::ZERO, Vec3::ONE)
    }
}
