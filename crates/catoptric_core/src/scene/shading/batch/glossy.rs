//! Many points of glossy surfaces at once.

use super::super::super::shadows::ShadowStart;
use super::super::super::{Material, Scene, TextureBinding};
use super::super::filter::{self, TextureLookUps};
use super::super::glossy::{self, LitPoints};
use super::super::lit_point::LookUps;
use super::super::microfacets::variance_over_pixel;
use super::points::{Points, base_colors};
use super::query::{SurfaceQuery, one_by_one};
use super::triangles::TriangleTable;
use crate::math::lanes::{LANES, MANY_LANES, Vec3Lanes};
use glam::{Vec3, Vec4, Vec4Swizzles};
use std::ops::Range;

/// Shades the points that the table has in a range of its order, which are of one material.
#[inline(never)]
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
pub(super) fn shade_all(
    scene: &Scene,
    material: &Material,
    table: &TriangleTable,
    range: Range<usize>,
    queries: &[SurfaceQuery],
    colors: &mut [Vec3],
) {
    let mut start = range.start;
    while start < range.end {
        if range.end - start > LANES {
            let count = (range.end - start).min(MANY_LANES);
            shade::<MANY_LANES>(scene, material, table, start..start + count, queries, colors);
            start += count;
        } else {
            shade::<LANES>(scene, material, table, start..range.end, queries, colors);
            start = range.end;
        }
    }
}

/// Where some queries look textures up.
struct QueryLookUps<'a, const N: usize> {
    scene: &'a Scene,
    order: &'a [u32],
    queries: &'a [SurfaceQuery],
    /// The texture whose coordinates the table has, and its places.
    first: Option<&'a TextureBinding>,
    look_ups: &'a TextureLookUps<N>,
}

impl<const N: usize> LookUps<N> for QueryLookUps<'_, N> {
    #[inline(always)]
    fn of(&self, binding: &TextureBinding) -> TextureLookUps<N> {
        let has_same_places = |first: &&TextureBinding| {
            first.uv_channel == binding.uv_channel && first.texture_from_uv == binding.texture_from_uv
        };
        match self.first.filter(has_same_places) {
            Some(_) => self.look_ups.clone(),
            None => self.elsewhere(binding),
        }
    }
}

impl<const N: usize> QueryLookUps<'_, N> {
    #[inline(never)] // most materials have all textures at the same places
    fn elsewhere(&self, binding: &TextureBinding) -> TextureLookUps<N> {
        let (channel, map) = (binding.uv_channel as usize & 1, &binding.texture_from_uv);
        let mut look_ups = self.look_ups.clone();
        for (i, &index) in self.order.iter().enumerate() {
            let query = &self.queries[index as usize];
            let [a, b, c] = self.scene.triangles[query.triangle as usize].map(|v| self.scene.uvs[v as usize][channel]);
            let (ab, ac, at) = (b - a, c - a, &query.barycentrics);
            let uv = map.transform_point2(a + ab * at.value.x + ac * at.value.y);
            let [dx, dy] = [at.dx, at.dy].map(|change| map.matrix2 * (ab * change.x + ac * change.y));
            for axis in 0..2 {
                look_ups.uv[axis][i] = uv[axis];
                (look_ups.dx[axis][i], look_ups.dy[axis][i]) = (dx[axis], dy[axis]);
            }
        }
        look_ups
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
#[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
fn shade<const N: usize>(
    scene: &Scene,
    material: &Material,
    table: &TriangleTable,
    range: Range<usize>,
    queries: &[SurfaceQuery],
    colors: &mut [Vec3],
) {
    let order = &table.order()[range];
    let mut points = Points::<N>::ZERO;
    points.set(table, order, queries);
    let mut usable = [true; N];
    points.orient_normals(&mut usable);
    let base = base_colors::<N>(scene, material, table, order, queries, &points.look_ups);
    let first = material.bindings().next();
    let look_ups = QueryLookUps { scene, order, queries, first, look_ups: &points.look_ups };
    let mut lit = LitPoints::<N>::ZERO;
    lit.position = points.position;
    lit.smooth_normal = points.normal;
    for i in 0..N {
        let [x, y, z] = points.towards_viewer.components(i);
        let inverse = 1.0 / (x * x + y * y + z * z).sqrt();
        let viewer = &mut lit.towards_viewer;
        (viewer[0][i], viewer[1][i], viewer[2][i]) = (x * inverse, y * inverse, z * inverse);
    }
    for i in 0..N {
        let color = material.base_color * base[i];
        (lit.base[0][i], lit.base[1][i], lit.base[2][i]) = (color.x, color.y, color.z);
    }
    if material.microfacets.is_some() {
        set_variances(table, order, queries, &mut lit);
    }
    lit.set_surface(scene, material, order.len(), &look_ups);
    let mut tangents = [Vec4::ZERO; N];
    if material.normal_map.is_some() && !scene.tangents.is_empty() {
        for (tangent, &index) in tangents.iter_mut().zip(order) {
            let query = &queries[index as usize];
            let [a, b, c] = scene.triangles[query.triangle as usize].map(|vertex| scene.tangents[vertex as usize]);
            let at = query.barycentrics.value;
            *tangent = (a * (1.0 - at.x - at.y) + b * at.x + c * at.y).truncate().extend(a.w);
        }
    }
    lit.turn_normals(scene, material, order.len(), &look_ups, tangents, &points.side);
    if scene.seeks_light() {
        for (i, &index) in order.iter().enumerate() {
            let query = &queries[index as usize];
            let at = query.barycentrics.value;
            lit.shadow_starts[i] = ShadowStart::on_triangle(scene, query.triangle, at, points.side[i]);
        }
    }
    if let Some(sky) = &scene.sky {
        for (i, &index) in order.iter().enumerate() {
            let query = &queries[index as usize];
            let share = sky.share(query.triangle, query.barycentrics.value, points.side[i]);
            lit.occlusion.set(i, lit.occlusion.vector(i).min(share));
            lit.emitted.set(i, sky.by_surfaces(query.triangle, query.barycentrics.value, points.side[i]));
        }
    }
    let mut sum = Vec3Lanes::ZERO;
    glossy::radiance(scene, material.microfacets.as_ref(), &lit, order.len(), &mut sum);
    let emitted = emitted::<N>(scene, material, order.len(), &look_ups);
    for (i, &index) in order.iter().enumerate().take(N) {
        let color = sum.vector(i) + emitted[i];
        let fits = usable[i] & color.is_finite();
        colors[index as usize] = if fits { color.max(Vec3::ZERO) } else { one_by_one(scene, &queries[index as usize]) };
    }
}

/// Sets the variance of smooth normals over a pixel.
#[cfg_attr(not(debug_assertions), inline(always))]
fn set_variances<const N: usize>(
    table: &TriangleTable,
    order: &[u32],
    queries: &[SurfaceQuery],
    lit: &mut LitPoints<N>,
) {
    for (i, &index) in order.iter().enumerate().take(N) {
        let (triangle, at) = (table.triangle_of(index), &queries[index as usize].barycentrics);
        let corner = |row: &[f32; 8]| Vec3::new(row[3], row[4], row[5]);
        let [first, second, third] = [&triangle.first, &triangle.second, &triangle.third].map(corner);
        let length2 = (first + second * at.value.x + third * at.value.y).length_squared().max(1e-6);
        let normal = lit.smooth_normal.vector(i);
        let [dx, dy] = [at.dx, at.dy].map(|change| {
            let changed = second * change.x + third * change.y;
            (changed - normal * changed.dot(normal)).length_squared()
        });
        lit.variance[i] = variance_over_pixel((dx + dy) / length2);
    }
}

/// Radiance that points emit.
#[cfg_attr(not(debug_assertions), inline(always))]
fn emitted<const N: usize>(
    scene: &Scene,
    material: &Material,
    count: usize,
    look_ups: &QueryLookUps<'_, N>,
) -> [Vec3; N] {
    let mut emitted = [material.emissive; N];
    let binding = material.emissive_texture.as_ref().filter(|_| material.emissive != Vec3::ZERO);
    let texture = binding.and_then(|binding| scene.textures.get(binding.texture as usize));
    if let (Some(binding), Some(texture)) = (binding, texture) {
        let mut texels = [Vec4::ONE; N];
        filter::sample(texture, &look_ups.of(binding), count, &mut texels);
        for (emitted, texel) in emitted.iter_mut().zip(&texels) {
            *emitted *= texel.xyz();
        }
    }
    emitted
}
