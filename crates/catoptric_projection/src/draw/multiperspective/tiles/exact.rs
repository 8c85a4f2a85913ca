//! Pixels whose samples' rays are traced one by one: at the rims of paths, and where no bundle is accurate.

use super::super::bundles::coverage::MAX_SAMPLES;
use super::super::bundles::least_squares::{TERMS, fit_quadratics, terms};
use super::super::counts::Counts;
use super::follow::{Chain, chain};
use super::found::FoundSurface;
use super::own::TOUCHING;
use super::reflections::{Reflections, Root};
use catoptric_core::scene::shade::Barycentrics;
#[cfg(target_arch = "x86_64")]
use catoptric_engine::light::wide_hierarchy::Avx2;
use catoptric_engine::light::wide_hierarchy::{Portable, SignBits, TriangleHit};
use catoptric_engine::raster::source::{EMPTY, found_id};
use glam::{Vec2, Vec3};

/// Half a pixel's side.
const HALF: f32 = 0.5;

/// The step by which the change of a triangle's coordinates is found, in pixels.
const STEP_PX: f32 = 0.5;

/// The surface that a traced sample shows.
#[derive(Clone, Copy)]
struct Traced {
    sample: usize,
    /// The surface in the last layer, and the triangle that its ray meets.
    below: u32,
    triangle: u32,
    /// The hit's barycentric coordinates of the second and third corner, and its distance.
    values: [f32; 3],
}

impl Traced {
    const NONE: Self = Self { sample: 0, below: EMPTY, triangle: 0, values: [0.0; 3] };
}

impl Reflections<'_> {
    /// Traces the samples (bits) of a pixel of a path that ends on an object; true if anything shows, `None` if no ray
    /// goes on. With AVX2 where the machine has it.
    pub(in super::super) fn trace_pixel(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        place: [usize; 2],
        samples: u32,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> Option<bool> {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            fn with_avx2(
                reflections: &Reflections<'_>,
                root: &Root<'_, '_>,
                object: u32,
                place: [usize; 2],
                samples: u32,
                surfaces: &mut Vec<FoundSurface>,
                ids: &mut [u32],
            ) -> Option<bool> {
                reflections.trace_samples::<Avx2>(root, object, place, samples, surfaces, ids)
            }
            if Avx2::is_available() {
                #[allow(unsafe_code, reason = "the machine has just been asked for the features")]
                return unsafe { with_avx2(self, root, object, place, samples, surfaces, ids) };
            }
        }
        self.trace_samples::<Portable>(root, object, place, samples, surfaces, ids)
    }

    #[inline(always)]
    fn trace_samples<S: SignBits>(
        &self,
        root: &Root<'_, '_>,
        object: u32,
        [column, row]: [usize; 2],
        samples: u32,
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) -> Option<bool> {
        let corner = root.corner(column, row);
        let first = root.first_sample(column, row);
        let mut traced = [Traced::NONE; MAX_SAMPLES];
        let (mut count, mut goes_on) = (0, false);
        let mut rest = samples;
        while rest != 0 {
            let sample = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let position = corner + root.tile.positions[sample];
            let chain = chain(root.tile, first + sample);
            let Some(path) = self.follow(root.tile, surfaces, &chain, position) else { continue };
            goes_on = true;
            let ray = path.departing();
            let own = self.own_rule(object, root.kind, path.outside);
            let passes = |hit: &TriangleHit| {
                let triangle = hit.triangle;
                let from = match own.distances(self.scene, self.shapes, triangle) {
                    [along, against] if along == against => along,
                    [along, _] if self.winding_normal(triangle).dot(ray.direction) > 0.0 => along,
                    [_, against] => against,
                };
                let object = self.scene.triangle_objects[triangle as usize];
                let at = || Barycentrics { value: hit.barycentrics, ..Barycentrics::default() };
                hit.distance >= from
                    && (!self.scene.is_alpha_tested(object) || self.scene.is_surface_present(triangle, &at()))
            };
            Counts::add(&self.counts.traced, 1);
            let Some(mut hit) = self.hierarchy.nearest::<S>(&ray, 0.0, f32::INFINITY, passes) else { continue };
            let is_around = |triangle: u32| own.is_around(self.scene.triangle_objects[triangle as usize]);
            if own.is_around(object) && !is_around(hit.triangle) {
                let far = hit.distance * (1.0 + TOUCHING);
                let touching = |hit: &TriangleHit| is_around(hit.triangle) && passes(hit);
                hit = self.hierarchy.nearest::<S>(&ray, 0.0, far, touching).unwrap_or(hit);
            }
            let below = chain[root.tile.layer() - 1];
            let values = [hit.barycentrics.x, hit.barycentrics.y, hit.distance];
            traced[count] = Traced { sample, below, triangle: hit.triangle, values };
            count += 1;
        }
        self.surfaces_of_traced(root, [column, row], &mut traced[..count], surfaces, ids);
        goes_on.then_some(count > 0)
    }

    /// Makes a surface of all samples of a pixel that show a triangle by the same surface below.
    #[inline(always)]
    fn surfaces_of_traced(
        &self,
        root: &Root<'_, '_>,
        [column, row]: [usize; 2],
        mut rest: &mut [Traced],
        surfaces: &mut Vec<FoundSurface>,
        ids: &mut [u32],
    ) {
        let center = root.corner(column, row) + HALF;
        let first = root.first_sample(column, row);
        while let Some(&one) = rest.first() {
            // Samples with equal surfaces are moved to the front.
            let mut count = 0;
            for index in 0..rest.len() {
                if (rest[index].below, rest[index].triangle) == (one.below, one.triangle) {
                    rest.swap(count, index);
                    count += 1;
                }
            }
            let (alike, others) = std::mem::take(&mut rest).split_at_mut(count);
            rest = others;
            let (mut basis, mut values) = ([[0.0; TERMS]; MAX_SAMPLES], [[0.0; 3]; MAX_SAMPLES]);
            for (index, traced) in alike.iter().enumerate() {
                let place = (root.tile.positions[traced.sample] - HALF) / HALF;
                basis[index] = terms(place.x, place.y);
                values[index] = traced.values;
            }
            let id = found_id(surfaces.len() as u32);
            let surface = match fit_quadratics(&basis[..count], &values[..count]) {
                Some(fitted) => self.found(root, one.triangle, center, 1.0 / HALF, whole(fitted)),
                None => {
                    let position = root.corner(column, row) + root.tile.positions[one.sample];
                    let chain = chain(root.tile, first + one.sample);
                    let here = Vec3::from_array(one.values);
                    let dx = self.change(root, surfaces, &chain, one.triangle, here, position, Vec2::X);
                    let dy = self.change(root, surfaces, &chain, one.triangle, here, position, Vec2::Y);
                    let linear = [0, 1, 2].map(|axis| [here[axis], dx[axis], dy[axis], 0.0, 0.0, 0.0]);
                    self.found(root, one.triangle, position, 1.0, whole(linear))
                }
            };
            surfaces.push(surface);
            for traced in alike.iter() {
                ids[first + traced.sample] = id;
            }
        }
    }

    /// The change a pixel along an axis of where a chain's ray meets a triangle: its coordinates and the distance. 0
    /// where the ray beside it meets nothing.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn change(
        &self,
        root: &Root<'_, '_>,
        surfaces: &[FoundSurface],
        chain: &Chain,
        triangle: u32,
        here: Vec3,
        position: Vec2,
        axis: Vec2,
    ) -> Vec3 {
        let Some(moved) = self.follow(root.tile, surfaces, chain, position + axis * STEP_PX) else { return Vec3::ZERO };
        let Some((at, distance)) = self.scene.plane_met(triangle, &moved.ray) else { return Vec3::ZERO };
        (at.extend(distance) - here) / STEP_PX
    }

    #[inline(always)]
    fn winding_normal(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.scene.triangles[triangle as usize].map(|vertex| self.scene.positions[vertex as usize]);
        (b - a).cross(c - a)
    }
}

/// Edge functions whose sum is 1, and the plane's, by the coordinates of the second and third corner and the distance.
#[inline(always)]
fn whole([b, c, distance]: [[f32; TERMS]; 3]) -> [[f32; TERMS]; 4] {
    let mut a = [0.0; TERMS];
    a[0] = 1.0;
    for term in 0..TERMS {
        a[term] -= b[term] + c[term];
    }
    [a, b, c, distance]
}
