//! The colours of many points at once: the same as [`Scene::radiance`], worked out for many points together.
//!
//! Points are sorted by material, so that those worked out together read one texture in one way.

mod glossy;
mod points;
mod query;
mod queue;
mod triangles;

pub use query::SurfaceQuery;
pub use queue::ShadingQueue;

use super::super::shadows::{ShadowStart, hide};
use super::super::{Light, Material, Scene};
use super::arriving_light::{ArrivingLight, SeenSky, add_environment, add_scattered, headlight};
use crate::math::lanes::{LANES, Lanes, MANY_LANES, Vec3Lanes};
use glam::{Vec3, Vec4Swizzles};
use points::{Points, base_colors};
use query::one_by_one;
use triangles::TriangleTable;

impl Scene {
    /// The radiance that points of triangles scatter and emit to their viewers: [`Self::radiance`] of
    /// [`Self::surface_point`], to rounding. `colors` is as long as `queries`.
    pub fn radiance_batch(&self, queries: &[SurfaceQuery], colors: &mut [Vec3]) {
        radiance_batch(self, queries, colors);
    }
}

#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn radiance_batch(scene: &Scene, queries: &[SurfaceQuery], colors: &mut [Vec3]) {
    let table = TriangleTable::new(scene, queries);
    let mut start = 0;
    while let Some(material) = table.material_at(start) {
        let end = table.end_of_material(start);
        let material = &scene.materials[material as usize];
        let glows = material.emissive_texture.is_some() && material.emissive != Vec3::ZERO && !material.unlit;
        if glows || material.is_glossy(scene) {
            glossy::shade_all(scene, material, &table, start..end, queries, colors);
            start = end;
        }
        while start < end {
            // The rest in few lanes: what they would do for nothing costs as much as the others.
            if end - start > LANES {
                let count = (end - start).min(MANY_LANES);
                shade::<MANY_LANES>(scene, material, &table, start..start + count, queries, colors);
                start += count;
            } else {
                shade::<LANES>(scene, material, &table, start..end, queries, colors);
                start = end;
            }
        }
    }
}

/// Sets the arriving irradiance at points, over pi.
#[inline(always)]
fn irradiance_over_pi<const N: usize>(
    scene: &Scene,
    points: &Points<N>,
    order: &[u32],
    queries: &[SurfaceQuery],
    sum: &mut Vec3Lanes<N>,
) {
    if scene.has_headlight() {
        *sum = Vec3Lanes([headlight(&points.normal, &points.towards_viewer); 3]);
        return;
    }
    *sum = Vec3Lanes::ZERO;
    let mut arriving = ArrivingLight::NONE;
    for light in &scene.lights {
        arriving.set(light, &points.position);
        if scene.light_visibility.is_some() {
            shadow(scene, light, points, order, queries, &mut arriving);
        }
        add_scattered(&arriving, &points.normal, sum);
    }
    if let Some(environment) = &scene.environment {
        let (mut shares, mut starts) = (Vec3Lanes::splat(Vec3::ONE), [ShadowStart::NONE; N]);
        let seen = scene.sky.is_some().then(|| {
            seen_sky(scene, &points.side, order, queries, &mut shares, &mut starts);
            SeenSky { shares: &shares, starts: &starts }
        });
        add_environment(environment, &points.normal, order.len(), (scene, seen), sum);
    }
    if let Some(sky) = scene.sky.as_ref().filter(|sky| sky.has_light_of_surfaces()) {
        for (lane, &index) in order.iter().enumerate().take(N) {
            let SurfaceQuery { triangle, barycentrics, .. } = queries[index as usize];
            sum.set(lane, sum.vector(lane) + sky.by_surfaces(triangle, barycentrics.value, points.side[lane]));
        }
    }
    sum.iter_mut().for_each(|channel| *channel *= std::f32::consts::FRAC_1_PI);
}

/// Sets what the first points see of the sky, and where lights are sought from.
#[inline(never)]
fn seen_sky<const N: usize>(
    scene: &Scene,
    sides: &Lanes<N>,
    order: &[u32],
    queries: &[SurfaceQuery],
    shares: &mut Vec3Lanes<N>,
    starts: &mut [ShadowStart; N],
) {
    let Some(sky) = &scene.sky else { return };
    for (lane, &index) in order.iter().enumerate().take(N) {
        let SurfaceQuery { triangle, barycentrics, .. } = queries[index as usize];
        shares.set(lane, sky.share(triangle, barycentrics.value, sides[lane]));
        // Only suns are sought from there.
        if !sky.suns().is_empty() {
            starts[lane] = ShadowStart::on_triangle(scene, triangle, barycentrics.value, sides[lane]);
        }
    }
}

/// Takes the strength of a light away where something stands before it.
#[inline(never)] // rays cost much more than a call
fn shadow<const N: usize>(
    scene: &Scene,
    light: &Light,
    points: &Points<N>,
    order: &[u32],
    queries: &[SurfaceQuery],
    arriving: &mut ArrivingLight<N>,
) {
    let cosines = points.normal.dot(&arriving.towards);
    let strength = arriving.strength;
    let starts = order.iter().enumerate().filter(|(lane, _)| strength[*lane] > 0.0 && cosines[*lane] > 0.0);
    let starts = starts.map(|(lane, &index)| {
        let query = &queries[index as usize];
        (lane, ShadowStart::on_triangle(scene, query.triangle, query.barycentrics.value, points.side[lane]))
    });
    hide(scene, light, starts, (&mut arriving.strength, &mut arriving.color));
}

/// Shades those points that the table has in a range of its order, which are of one material.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn shade<const N: usize>(
    scene: &Scene,
    material: &Material,
    table: &TriangleTable,
    range: std::ops::Range<usize>,
    queries: &[SurfaceQuery],
    colors: &mut [Vec3],
) {
    let order = &table.order()[range];
    let mut points = Points::<N>::ZERO;
    points.set(table, order, queries);
    let base = base_colors::<N>(scene, material, table, order, queries, &points.look_ups);
    let mut usable = [true; N];
    let mut light = Vec3Lanes::splat(Vec3::ONE);
    if !material.unlit {
        points.orient_normals(&mut usable);
        irradiance_over_pi(scene, &points, order, queries, &mut light);
    }
    let emissive = if material.unlit { Vec3::ZERO } else { material.emissive };
    for (i, &index) in order.iter().enumerate().take(N) {
        let color = (material.base_color * base[i]).xyz() * light.vector(i) + emissive;
        let fits = usable[i] & color.is_finite();
        colors[index as usize] = if fits { color.max(Vec3::ZERO) } else { one_by_one(scene, &queries[index as usize]) };
    }
}
