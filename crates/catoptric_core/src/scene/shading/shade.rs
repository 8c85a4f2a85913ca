//! The appearance of a point of a surface: the one place where colours are computed, for every method.
//!
//! Surfaces are lit by the file's lights, by the environment, and, where a scene has neither, by a headlight that
//! travels with the path: it shines from the path's previous point, makes no highlights, and casts no shadows. Both
//! sides of a surface are lit: for views of its back the normal is turned over. Lambert's law is worked out here; what
//! has microfacets or a normal map, in the modules `lit_point` and `glossy`.

use super::super::{AlphaMode, Material, Ray, RayDifferential, Scene, Texture, TextureBinding, UvFootprint};
use super::filter::{self, TextureLookUps};
use crate::math::lanes::LANES;
use crate::surface::SurfaceHit;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

/// A point of a surface with everything that shading and the continuation of a path need.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfacePoint {
    /// The object.
    pub object: u32,
    /// The point in the world.
    pub position: Vec3,
    /// The unit normal of the flat triangle (or of the exact surface), on the outer side.
    pub geometric_normal: Vec3,
    /// The interpolated unit normal, on the outer side.
    pub normal: Vec3,
    /// Two sets of texture coordinates.
    pub uvs: [Vec2; 2],
    /// Change of the texture coordinates a pixel.
    pub footprints: [UvFootprint; 2],
    /// Linear vertex colour with alpha.
    pub color: Vec4,
    /// Tangent along the texture's u and sign of the bitangent, of surfaces with normal maps.
    pub tangent: Vec4,
    /// Sum of the squares of the unit normal's changes with the pixel's column and row, of surfaces with microfacets.
    pub normal_change2: f32,
    /// The triangle; `u32::MAX` on exact surfaces.
    pub triangle: u32,
    /// The place on the triangle.
    pub barycentrics: Vec2,
    /// The size of the coordinates that the position was computed from: it is rounded in proportion to them.
    pub coordinate_size: f32,
}

/// Barycentric coordinates of the second and third vertex, and their change a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Barycentrics {
    /// Weights of the second and third vertex.
    pub value: Vec2,
    /// Change with the pixel's column.
    pub dx: Vec2,
    /// Change with the pixel's row.
    pub dy: Vec2,
    /// The number of antialiasing samples shaded at once here, 0 as 1: textures are then looked up as if each were.
    pub samples: u32,
}

impl Barycentrics {
    /// The same with a footprint that is so many times as wide.
    #[inline(always)]
    #[must_use]
    pub fn widened(&self, factor: f32) -> Self {
        Self { dx: self.dx * factor, dy: self.dy * factor, ..*self }
    }
}

/// A point of a surface and how it changes from pixel to pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceInteraction {
    /// The surface's point.
    pub point: SurfacePoint,
    /// Change of the position with the pixel's column and row.
    pub position_change: [Vec3; 2],
    /// Change of the outer unit normal with the pixel's column and row (reflectors and lenses alone).
    pub normal_change: [Vec3; 2],
}

impl Scene {
    /// The point of a triangle and its changes a pixel, from those of the barycentric coordinates.
    #[inline(always)]
    pub fn encounter(&self, triangle: u32, at: &Barycentrics) -> SurfaceInteraction {
        let point = self.surface_point(triangle, at);
        if !self.role_of(point.object).is_specular() {
            return SurfaceInteraction { point, ..SurfaceInteraction::default() };
        }
        let [a, b, c] = self.triangles[triangle as usize];
        let (a, b, c) = (a as usize, b as usize, c as usize);
        let (ab, ac) = (self.positions[b] - self.positions[a], self.positions[c] - self.positions[a]);
        let (na, nb, nc) = (self.normals[a], self.normals[b], self.normals[c]);
        let (nab, nac) = (nb - na, nc - na);
        let length = (na + nab * at.value.x + nac * at.value.y).length().max(1e-6);
        let turned = |d: Vec2| {
            let change = (nab * d.x + nac * d.y) / length;
            change - point.normal * point.normal.dot(change)
        };
        let moved = |d: Vec2| ab * d.x + ac * d.y;
        let (position_change, normal_change) = ([moved(at.dx), moved(at.dy)], [turned(at.dx), turned(at.dy)]);
        SurfaceInteraction { point, position_change, normal_change }
    }

    /// The point where a ray met an analytic surface, and its changes a pixel where the ray's are given.
    #[inline]
    pub fn exact_encounter(
        &self,
        object: u32,
        hit: &SurfaceHit,
        ray: &Ray,
        change: Option<&RayDifferential>,
    ) -> SurfaceInteraction {
        let point = SurfacePoint {
            object,
            position: hit.position,
            geometric_normal: hit.normal,
            normal: hit.normal,
            color: Vec4::ONE,
            triangle: u32::MAX,
            coordinate_size: hit.position.abs().max_element(),
            ..SurfacePoint::default()
        };
        let Some(change) = change else {
            return SurfaceInteraction { point, ..SurfaceInteraction::default() };
        };
        let position_change = change.transferred(ray, hit.distance, hit.normal);
        let normal_change = match &self.objects[object as usize].surface {
            Some(surface) if self.role_of(object).is_specular() => {
                let shape = surface.shape_operator(hit.position.as_dvec3()).as_mat3();
                position_change.map(|change| shape * change)
            }
            _ => [Vec3::ZERO; 2],
        };
        let point = SurfacePoint {
            normal_change2: normal_change[0].length_squared() + normal_change[1].length_squared(),
            ..point
        };
        SurfaceInteraction { point, position_change, normal_change }
    }

    /// The position on a triangle at these barycentric coordinates of its second and third vertex.
    #[inline(always)]
    pub fn position_on(&self, triangle: u32, at: Vec2) -> Vec3 {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize]);
        a + (b - a) * at.x + (c - a) * at.y
    }

    /// The barycentric coordinates of a triangle's second and third vertex, and the distance, at which a ray meets its
    /// plane, within the triangle or beside it. `None` for rays along the plane, and triangles without area.
    #[inline(always)] // for the instructions of its caller
    pub fn plane_met(&self, triangle: u32, ray: &Ray) -> Option<(Vec2, f32)> {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let distance = (a - ray.origin).dot(normal) / ray.direction.dot(normal);
        let from = ray.origin + ray.direction * distance - a;
        let inverse = 1.0 / normal.length_squared();
        let at = Vec2::new(from.cross(ac).dot(normal), ab.cross(from).dot(normal)) * inverse;
        (at.is_finite() && distance.is_finite()).then_some((at, distance))
    }

    /// The point of a triangle at these barycentric coordinates. The geometric normal is on the side of the vertex
    /// normals, whatever the winding.
    #[inline(always)]
    pub fn surface_point(&self, triangle: u32, at: &Barycentrics) -> SurfacePoint {
        let [a, b, c] = self.triangles[triangle as usize].map(|vertex| vertex as usize);
        let object = self.triangle_objects[triangle as usize];
        let (wb, wc) = (at.value.x, at.value.y);
        let wa = 1.0 - wb - wc;
        let [pa, pb, pc] = [self.positions[a], self.positions[b], self.positions[c]];
        let [na, nb, nc] = [self.normals[a], self.normals[b], self.normals[c]];
        let (ab, ac) = (pb - pa, pc - pa);
        let sum = na * wa + nb * wb + nc * wc;
        let face = ab.cross(ac);
        let face = if face.dot(na + nb + nc) < 0.0 { -face } else { face };
        let geometric_normal = unit_or(face, na);
        let normal = unit_or(sum, geometric_normal);
        let [ua, ub, uc] = [&self.uvs[a], &self.uvs[b], &self.uvs[c]];
        let mut uvs = [Vec2::ZERO; 2];
        let mut footprints = [UvFootprint::default(); 2];
        let material = &self.materials[self.objects[object as usize].material as usize];
        if material.textured() {
            for channel in 0..2 {
                let (du, dv) = (ub[channel] - ua[channel], uc[channel] - ua[channel]);
                uvs[channel] = ua[channel] + du * wb + dv * wc;
                footprints[channel] = UvFootprint {
                    dx: du * at.dx.x + dv * at.dx.y,
                    dy: du * at.dy.x + dv * at.dy.y,
                    samples: at.samples,
                };
            }
        }
        let color = if self.colors.is_empty() {
            Vec4::ONE
        } else {
            let [ca, cb, cc] = [a, b, c].map(|vertex| Vec4::from(self.colors[vertex]));
            ca * wa + cb * wb + cc * wc
        };
        let position = pa + ab * wb + ac * wc;
        let coordinate_size = pa.abs().max(pb.abs()).max(pc.abs()).max_element();
        let mut point = SurfacePoint {
            object,
            position,
            geometric_normal,
            normal,
            uvs,
            footprints,
            color,
            triangle,
            barycentrics: at.value,
            coordinate_size,
            ..SurfacePoint::default()
        };
        if material.reads_tangents() && !self.tangents.is_empty() {
            let [ta, tb, tc] = [self.tangents[a], self.tangents[b], self.tangents[c]];
            point.tangent = (ta * wa + tb * wb + tc * wc).truncate().extend(ta.w);
        }
        if (material.microfacets.is_some() || material.highlight_roughness().is_some()) && !self.has_headlight() {
            let (change_b, change_c) = (nb - na, nc - na);
            let changes = [at.dx, at.dy].map(|d| (change_b * d.x + change_c * d.y).reject_from_normalized(normal));
            point.normal_change2 =
                (changes[0].length_squared() + changes[1].length_squared()) / sum.length_squared().max(1e-6);
        }
        point
    }

    /// Base colour times texture times vertex colour, linear, with alpha.
    #[inline(always)]
    pub fn base_color(&self, material: &Material, point: &SurfacePoint) -> Vec4 {
        let color = material.base_color * point.color;
        match &material.base_texture {
            Some(binding) => color * self.sample(binding, point),
            None => color,
        }
    }

    /// The share of the surface that a clear coat covers.
    #[inline(always)]
    pub fn coat(&self, material: &Material, point: &SurfacePoint) -> f32 {
        match &material.coat_texture {
            Some(binding) => material.coat * self.sample(binding, point).x,
            None => material.coat,
        }
    }

    #[inline(always)]
    pub(super) fn sample(&self, binding: &TextureBinding, point: &SurfacePoint) -> Vec4 {
        let Some(texture) = self.textures.get(binding.texture as usize) else { return Vec4::ONE };
        let uv = point.uvs[binding.uv_channel as usize & 1];
        texture.sample(binding.texture_from_uv.transform_point2(uv), &footprint_in_texture(binding, point))
    }

    /// The same of up to [`LANES`] points at a time.
    pub(super) fn sample_at(&self, binding: &TextureBinding, points: &[SurfacePoint], values: &mut [Vec4; LANES]) {
        match self.textures.get(binding.texture as usize) {
            Some(texture) => sample_at(texture, binding, points, values),
            None => *values = [Vec4::ONE; LANES],
        }
    }

    /// The longer axis of a point's footprint in a texture, in texels of the finest level; 0 without the texture.
    pub(super) fn texels_across(&self, binding: &TextureBinding, point: &SurfacePoint) -> f32 {
        let Some(texture) = self.textures.get(binding.texture as usize) else { return 0.0 };
        let (width, height) = texture.size();
        let size = Vec2::new(width as f32, height as f32);
        let UvFootprint { dx, dy, .. } = footprint_in_texture(binding, point);
        (dx * size).length().max((dy * size).length())
    }

    /// Returns true if the surface is there at all at a point, by its alpha.
    #[inline(always)]
    pub fn is_present(&self, material: &Material, point: &SurfacePoint) -> bool {
        match material.alpha_mode {
            AlphaMode::Opaque => true,
            AlphaMode::Mask(cutoff) => self.base_color(material, point).w >= cutoff,
            AlphaMode::Blend => self.base_color(material, point).w > 0.0,
        }
    }

    /// The radiance that a point scatters and emits towards the previous point of the path.
    ///
    /// `towards_viewer` is the unit direction to the previous point of the path. Never negative, always finite.
    #[inline(always)]
    pub fn radiance(&self, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        let material = self.material_of(point.object);
        self.radiance_of(material, self.base_color(material, point).xyz(), point, towards_viewer)
    }

    /// The radiance that a point of a reflector, or under a coat, scatters and emits by itself, before its
    /// share is taken: as [`Self::radiance`], by the mirror's own colour where it has one.
    #[inline]
    pub fn own_radiance(&self, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        let material = self.material_of(point.object);
        match material.blend.and_then(|blend| blend.diffuse) {
            Some(diffuse) => self.radiance_of(material, diffuse, point, towards_viewer),
            None => self.radiance(point, towards_viewer),
        }
    }

    #[inline(always)]
    fn radiance_of(&self, material: &Material, base: Vec3, point: &SurfacePoint, towards_viewer: Vec3) -> Vec3 {
        if material.unlit {
            return finite(base);
        }
        let mut radiance = self.lit(material, base, point, towards_viewer);
        radiance += self.emitted(material, point);
        finite(radiance)
    }

    /// The radiance that a point emits.
    pub fn emitted_radiance(&self, point: &SurfacePoint) -> Vec3 {
        self.emitted(self.material_of(point.object), point)
    }

    #[inline(always)]
    pub(super) fn emitted(&self, material: &Material, point: &SurfacePoint) -> Vec3 {
        if material.emissive == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let texture = material.emissive_texture.as_ref().map_or(Vec3::ONE, |t| self.sample(t, point).xyz());
        material.emissive * texture
    }

    /// Returns true if a material's look depends on how much of it a pixel shows.
    #[inline(always)]
    pub fn has_footprints(&self, material: &Material) -> bool {
        let is_glossy = material.microfacets.is_some() || material.highlight_roughness().is_some();
        material.textured() || material.reflection_roughness() > 0.0 || is_glossy && !self.has_headlight()
    }

    /// The radiance from infinity in a direction of unit length.
    #[inline(always)]
    pub fn background(&self, direction: Vec3) -> Vec3 {
        self.environment.as_ref().map_or(Vec3::ZERO, |environment| environment.radiance(direction))
    }

    /// Radiance that the eye sees in a direction of unit length where nothing stands before it.
    #[inline(always)]
    pub fn background_seen(&self, direction: Vec3) -> Vec3 {
        self.backdrop.unwrap_or_else(|| self.background(direction))
    }
}

impl Material {
    /// True if the material's look depends on the direction of its textures.
    #[inline(always)]
    fn reads_tangents(&self) -> bool {
        let is_anisotropic = || self.lobes.as_ref().is_some_and(|lobes| lobes.anisotropy > 0.0);
        self.normal_map.is_some() || self.coat_normal_map.is_some() || is_anisotropic()
    }

    /// Returns true if anything is read from a texture.
    #[inline(always)]
    pub fn textured(&self) -> bool {
        self.base_texture.is_some()
            || self.emissive_texture.is_some()
            || self.normal_map.is_some()
            || self.coat_normal_map.is_some()
            || self.coat_texture.is_some()
            || self.occlusion_map.is_some()
            || self.microfacets.as_ref().is_some_and(|microfacets| microfacets.texture.is_some())
            || self.lobes.is_some()
    }
}

#[inline]
fn unit_or(vector: Vec3, otherwise: Vec3) -> Vec3 {
    let length2 = vector.length_squared();
    if length2 > 1e-36 && length2.is_finite() { vector * length2.sqrt().recip() } else { otherwise }
}

#[inline]
pub(super) fn finite(radiance: Vec3) -> Vec3 {
    if radiance.is_finite() { radiance.max(Vec3::ZERO) } else { Vec3::ZERO }
}

#[cfg_attr(not(debug_assertions), multiversion::multiversion(targets("x86_64+avx2+bmi1+bmi2+popcnt+lzcnt")))]
fn sample_at(texture: &Texture, binding: &TextureBinding, points: &[SurfacePoint], values: &mut [Vec4; LANES]) {
    filter::sample(texture, &look_ups(binding, points), points.len().min(LANES), values);
}

/// Where the first points, one a lane, look a texture up.
#[inline(always)] // for the instructions of its callers
pub(super) fn look_ups<const N: usize>(binding: &TextureBinding, points: &[SurfacePoint]) -> TextureLookUps<N> {
    let mut look_ups = TextureLookUps::ZERO;
    for (lane, point) in points.iter().enumerate().take(N) {
        let uv = binding.texture_from_uv.transform_point2(point.uvs[binding.uv_channel as usize & 1]);
        let UvFootprint { dx, dy, samples } = footprint_in_texture(binding, point);
        for axis in 0..2 {
            look_ups.uv[axis][lane] = uv[axis];
            (look_ups.dx[axis][lane], look_ups.dy[axis][lane]) = (dx[axis], dy[axis]);
        }
        look_ups.samples[lane] = samples;
    }
    look_ups
}

/// A point's footprint in the coordinates of a texture.
#[inline(always)]
fn footprint_in_texture(binding: &TextureBinding, point: &SurfacePoint) -> UvFootprint {
    let UvFootprint { dx, dy, samples } = point.footprints[binding.uv_channel as usize & 1];
    let matrix = binding.texture_from_uv.matrix2;
    UvFootprint { dx: matrix * dx, dy: matrix * dy, samples }
}
