//! The properties of several points of triangles.

use super::super::super::{Material, Scene};
use super::super::filter::{self, TextureLookUps};
use super::super::shade::Barycentrics;
use super::query::SurfaceQuery;
use super::triangles::TriangleTable;
use crate::math::lanes::{Lanes, Vec3Lanes};
use glam::Vec4;

/// The properties of several points.
pub(super) struct Points<const N: usize> {
    pub(super) position: Vec3Lanes<N>,
    /// Interpolated, of any length.
    pub(super) normal: Vec3Lanes<N>,
    /// Where the base texture is looked up.
    pub(super) look_ups: TextureLookUps<N>,
    pub(super) towards_viewer: Vec3Lanes<N>,
    /// -1 for views of a triangle's back, the side that its corners' normals do not point to, else 1.
    pub(super) side: Lanes<N>,
}

impl<const N: usize> Points<N> {
    pub(super) const ZERO: Self = Self {
        position: Vec3Lanes::ZERO,
        normal: Vec3Lanes::ZERO,
        look_ups: TextureLookUps::ZERO,
        towards_viewer: Vec3Lanes::ZERO,
        side: Lanes::ZERO,
    };

    /// Sets the points of some queries.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // lanes of several arrays, for the vectoriser
    pub(super) fn set(&mut self, table: &TriangleTable, order: &[u32], queries: &[SurfaceQuery]) {
        // A vector instruction works on all attributes of a point; points come side by side after that.
        let (mut attributes, mut changes) = ([[0.0f32; 8]; N], [[0.0f32; 8]; N]);
        for (i, &index) in order.iter().enumerate().take(N) {
            let query = &queries[index as usize];
            let Barycentrics { value, dx, dy, samples } = query.barycentrics;
            let triangle = table.triangle_of(index);
            let viewer = query.towards_viewer;
            for k in 0..8 {
                attributes[i][k] = triangle.first[k] + triangle.second[k] * value.x + triangle.third[k] * value.y;
            }
            let [second_u, second_v] = [triangle.second[6], triangle.second[7]];
            let [third_u, third_v] = [triangle.third[6], triangle.third[7]];
            changes[i] = [
                second_u * dx.x + third_u * dx.y,
                second_v * dx.x + third_v * dx.y,
                second_u * dy.x + third_u * dy.y,
                second_v * dy.x + third_v * dy.y,
                viewer.x,
                viewer.y,
                viewer.z,
                if triangle.face.dot(viewer) < 0.0 { -1.0 } else { 1.0 },
            ];
            self.look_ups.samples[i] = samples;
        }
        for i in 0..N {
            let [px, py, pz, nx, ny, nz, u, v] = attributes[i];
            (self.position[0][i], self.position[1][i], self.position[2][i]) = (px, py, pz);
            (self.normal[0][i], self.normal[1][i], self.normal[2][i]) = (nx, ny, nz);
            (self.look_ups.uv[0][i], self.look_ups.uv[1][i]) = (u, v);
        }
        for i in 0..N {
            let [dx_u, dx_v, dy_u, dy_v, x, y, z, side] = changes[i];
            (self.look_ups.dx[0][i], self.look_ups.dx[1][i]) = (dx_u, dx_v);
            (self.look_ups.dy[0][i], self.look_ups.dy[1][i]) = (dy_u, dy_v);
            let viewer = &mut self.towards_viewer;
            (viewer[0][i], viewer[1][i], viewer[2][i], self.side[i]) = (x, y, z, side);
        }
    }

    /// Makes normals unit vectors on the viewers' side, and sets whether that could be done.
    #[inline(always)]
    pub(super) fn orient_normals(&mut self, usable: &mut [bool; N]) {
        let [nx, ny, nz] = &mut self.normal.0;
        for i in 0..N {
            let (x, y, z) = (nx[i], ny[i], nz[i]);
            let length2 = x * x + y * y + z * z;
            usable[i] = (length2 > 1e-36) & (length2 < f32::INFINITY);
            let inverse = self.side[i] / length2.sqrt();
            (nx[i], ny[i], nz[i]) = (x * inverse, y * inverse, z * inverse);
        }
    }
}

/// Texture times vertex colours.
#[inline(always)]
pub(super) fn base_colors<const N: usize>(
    scene: &Scene,
    material: &Material,
    table: &TriangleTable,
    order: &[u32],
    queries: &[SurfaceQuery],
    look_ups: &TextureLookUps<N>,
) -> [Vec4; N] {
    let mut base = [Vec4::ONE; N];
    let texture = material.base_texture.as_ref().and_then(|binding| scene.textures.get(binding.texture as usize));
    if let Some(texture) = texture {
        filter::sample(texture, look_ups, order.len(), &mut base);
    }
    if let Some(vertex_colors) = table.vertex_colors() {
        for (base, &index) in base.iter_mut().zip(order) {
            let [a, b, c] = vertex_colors[table.number_of(index)];
            let value = queries[index as usize].barycentrics.value;
            *base *= a * (1.0 - value.x - value.y) + b * value.x + c * value.y;
        }
    }
    base
}
