//! Many paths side by side: rays are traced one by one, what they end on is shaded together.

use super::lobe_light::{LOBES, LobeLight};
use super::near_plane::NearPlane;
use super::segment::{Segment, Waves};
use super::specular_paths::PathTracer;
use crate::light::radiance_field::RadianceField;
use crate::optics::step::transmittance;
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::shade::{Barycentrics, SurfaceInteraction};
use catoptric_core::scene::{Ray, RayDifferential, Role, SurfaceQuery, ViewRays};
use glam::{Vec2, Vec3};

/// Rays that are followed at once: what they hold stays in the cache.
const AT_ONCE: usize = 256;

/// A ray that stands for a cone.
pub struct Cone {
    /// The ray in its middle.
    pub ray: Ray,
    /// The ray's change to its neighbours: the cone's width.
    pub change: RayDifferential,
    /// Absorption of the medium that it crosses.
    pub absorption: Vec3,
}

/// A ray of an eye, which may be within bodies, and the surface that it is known to meet, whatever lies before that.
pub struct SeenSurface {
    /// The ray.
    pub ray: Ray,
    /// The ray's change to its neighbours.
    pub change: RayDifferential,
    /// Where it meets the surface.
    pub encounter: SurfaceInteraction,
    /// The light over the surface's lobes, where that is known.
    pub known: [Option<LobeLight>; LOBES],
}

impl<F: RadianceField> PathTracer<'_, F> {
    /// Sets the radiance that arrives from surfaces: of each pixel as many, one after the other, as it has paths
    /// ([`Self::set_rough_rays`]). Both are of the same length.
    pub fn radiances_of_seen(&mut self, seen: &[SeenSurface], sums: &mut [Vec3]) {
        follow_seen(self, seen, sums);
    }

    #[inline(always)] // for the instructions of its caller
    fn meet_seen(&mut self, seen: &[SeenSurface], sums: &mut [Vec3]) {
        sums.fill(Vec3::ZERO);
        let mut waves = std::mem::take(&mut self.waves);
        for (owner, SeenSurface { ray, change, encounter, known }) in seen.iter().enumerate() {
            let start = self.first(*ray, Some(*change), 0.0);
            let distance = ray.origin.distance(encounter.point.position);
            self.rough.part = owner as u32 % self.rough.parts;
            self.known = *known;
            sums[owner] += self.meet(&start, start.throughput, encounter, distance);
            self.known = [None; LOBES];
            waves.owners.resize(self.waiting.len(), owner as u32);
        }
        self.follow_waves(waves, sums);
    }

    /// Sets the radiance that arrives at positions of the picture (in pixels): [`Self::radiance`] of each, to rounding,
    /// but below zero where what hides light from infinity takes away more than there was, as much as elsewhere less:
    /// the mean over a pixel is nearer to the truth. `sums` is as long as `positions`. Tells what is first met at each
    /// of them, by its index.
    #[inline(always)] // for the instructions of its caller
    pub fn radiances(
        &mut self,
        view: &ViewRays,
        near: &NearPlane,
        positions: &[Vec2],
        footprint_scale: f32,
        sums: &mut [Vec3],
        mut tell: impl FnMut(usize, Option<&Hit>),
    ) {
        sums.fill(Vec3::ZERO);
        let mut waves = std::mem::take(&mut self.waves);
        let low = positions.iter().copied().fold(Vec2::INFINITY, Vec2::min);
        let high = positions.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
        let mut treelet = std::mem::take(&mut waves.treelet);
        self.tracer.gather(view, low, high, &mut treelet);
        for (owner, at) in positions.iter().enumerate() {
            let start = self.start(view, near, at.x, at.y, footprint_scale);
            let hit = self.tracer.first_hit_among(self.scene, &start.ray, start.near, &treelet);
            tell(owner, hit.as_ref());
            self.arrive_in_wave(&start, hit.as_ref(), owner as u32, &mut waves, sums);
        }
        waves.treelet = treelet;
        self.follow_waves(waves, sums);
    }

    /// Sets the radiance that arrives along rays, and how far away what each meets first is: infinitely where that is
    /// nothing. All three are of the same length.
    #[inline(always)] // for the instructions of its caller
    pub fn radiances_and_distances(
        &mut self,
        rays: &[(Ray, RayDifferential)],
        sums: &mut [Vec3],
        distances: &mut [f32],
    ) {
        let starts = rays.iter().map(|(ray, change)| Segment::first(*ray, Some(*change), 0.0));
        self.radiances_from(starts, sums, |owner, hit| distances[owner] = hit.map_or(f32::INFINITY, Hit::distance));
    }

    /// Sets the radiance that arrives along cones. Both are of the same length.
    #[inline(always)] // for the instructions of its caller
    pub fn radiances_of_cones(&mut self, cones: &[Cone], sums: &mut [Vec3]) {
        let starts = cones.iter().map(|Cone { ray, change, absorption }| {
            let first = Segment::first(*ray, Some(*change), 0.0);
            Segment { is_cone: true, absorption: *absorption, ..first }
        });
        self.radiances_from(starts, sums, |_, _| ());
        // Surfaces that hide light from infinity may take away more than there was.
        sums.iter_mut().for_each(|sum| *sum = sum.max(Vec3::ZERO));
    }

    /// Sets the radiance that arrives along first segments of paths, and tells what each meets.
    #[inline(always)] // for the instructions of its caller
    pub(super) fn radiances_from(
        &mut self,
        starts: impl Iterator<Item = Segment>,
        sums: &mut [Vec3],
        mut tell: impl FnMut(usize, Option<&Hit>),
    ) {
        sums.fill(Vec3::ZERO);
        let mut waves = std::mem::take(&mut self.waves);
        for (owner, start) in starts.enumerate() {
            let hit = self.tracer.first_hit(self.scene, &start.ray, start.near);
            tell(owner, hit.as_ref());
            self.arrive_in_wave(&start, hit.as_ref(), owner as u32, &mut waves, sums);
        }
        self.follow_waves(waves, sums);
    }

    /// Follows all that waits, and shades where paths end.
    #[inline(always)] // for the instructions of its caller
    fn follow_waves(&mut self, mut waves: Waves, sums: &mut [Vec3]) {
        // The last ones first: as few wait as on one path after the other, but for what is followed at once.
        while !self.waiting.is_empty() {
            let first = self.waiting.len().saturating_sub(AT_ONCE);
            waves.wave.clear();
            waves.wave.extend(self.waiting.drain(first..).zip(waves.owners.drain(first..)));
            let wave = std::mem::take(&mut waves.wave);
            for (segment, owner) in &wave {
                let hit = self.tracer.first_hit(self.scene, &segment.ray, segment.near);
                self.arrive_in_wave(segment, hit.as_ref(), *owner, &mut waves, sums);
            }
            waves.wave = wave;
        }
        waves.points.shade(self.scene, sums);
        self.waves = waves;
        for sum in sums {
            // A sum of finite terms can still overflow.
            if !sum.is_finite() {
                *sum = Vec3::ZERO;
            }
        }
    }

    /// Goes on at what a ray meets: light that ends the path here is added or waits to be shaded, children wait to be
    /// followed.
    #[inline(always)]
    fn arrive_in_wave(
        &mut self,
        segment: &Segment,
        hit: Option<&Hit>,
        owner: u32,
        waves: &mut Waves,
        sums: &mut [Vec3],
    ) {
        self.ray_count += 1;
        self.rough.part = owner % self.rough.parts;
        let (scene, ray) = (self.scene, &segment.ray);
        let mut throughput = segment.throughput;
        if let Some(deferred) = &segment.deferred {
            let (own, weight) = deferred.settled(hit.map_or(f32::INFINITY, |hit| hit.distance()));
            sums[owner as usize] += own;
            throughput *= weight;
        }
        if let Some(Hit::Triangle { distance, triangle, barycentrics }) = hit {
            let material = scene.material_of(scene.triangle_objects[*triangle as usize]);
            if material.role == Role::Diffuse && material.lobes().is_none() {
                let mut at = Barycentrics { value: *barycentrics, ..Barycentrics::default() };
                if let Some(change) = segment.change.as_ref().filter(|_| scene.has_footprints(material)) {
                    [at.dx, at.dy] = self.tracer.barycentric_changes(scene, ray, *triangle, *distance, change);
                }
                let query = SurfaceQuery { triangle: *triangle, barycentrics: at, towards_viewer: -ray.direction };
                sums[owner as usize] -= segment.counted.unwrap_or_default();
                if let Some(hit) = hit {
                    sums[owner as usize] -= self.counted_by_others(segment, throughput, hit);
                }
                let throughput = throughput * transmittance(segment.absorption, *distance);
                waves.points.push(scene, query, owner, throughput, sums);
                return;
            }
        }
        sums[owner as usize] += self.arrive(segment, throughput, hit);
        waves.owners.resize(self.waiting.len(), owner);
    }
}

/// Compiled with most of the shading for the instructions that the machine has.
#[cfg_attr(not(debug_assertions), multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt")))]
fn follow_seen<F: RadianceField>(paths: &mut PathTracer<'_, F>, seen: &[SeenSurface], sums: &mut [Vec3]) {
    paths.meet_seen(seen, sums);
}
