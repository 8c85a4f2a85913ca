//! The colours of many points at once: the same as [`Scene::radiance`], worked out for eight points together.

use super::super::{Light, LightKind, Material, Scene, Texture};
use super::filter::{self, TextureLookUps};
use super::shade::Barycentrics;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

/// A point to be shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceQuery {
    /// The triangle of the scene.
    pub triangle: u32,
    /// The place on it.
    pub barycentrics: Barycentrics,
    /// The direction to the previous point of the path, of any length.
    pub towards_viewer: Vec3,
}

impl Scene {
    /// The radiance that points of triangles scatter and emit to their viewers: [`Self::radiance`] of
    /// [`Self::surface_point`], to rounding. `colors` is as long as `queries`.
    pub fn radiance_batch(&self, queries: &[SurfaceQuery], colors: &mut [Vec3]) {
        radiance_batch(self, queries, colors);
    }
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
    "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
))]
fn radiance_batch(scene: &Scene, queries: &[SurfaceQuery], colors: &mut [Vec3]) {
    for (queries, colors) in queries.chunks(LANES).zip(colors.chunks_mut(LANES)) {
        let mut lanes = [&queries[0]; LANES];
        for (lane, query) in lanes.iter_mut().zip(queries) {
            *lane = query;
        }
        let result = radiance(scene, &lanes);
        for (color, (value, query)) in colors.iter_mut().zip(result.iter().zip(queries)) {
            *color = value.unwrap_or_else(|| one_by_one(scene, query));
        }
    }
}

/// The general way, for points with properties too rare for lanes.
#[cold]
fn one_by_one(scene: &Scene, query: &SurfaceQuery) -> Vec3 {
    let towards_viewer = query.towards_viewer.normalize_or_zero();
    scene.radiance(&scene.surface_point(query.triangle, &query.barycentrics), towards_viewer)
}

/// Properties of the triangles of eight points.
struct Triangles<'a> {
    /// Attributes of the three corners.
    positions: [Vec3Lanes; 3],
    normals: [Vec3Lanes; 3],
    uvs: [[Lanes; 2]; 3],
    materials: [Option<&'a Material>; LANES],
    textures: [Option<&'a Texture>; LANES],
    base: [Vec4; LANES],
    /// Rows of the map from the vertices' to the textures' coordinates.
    texture_from_uv: [Vec3Lanes; 2],
}

impl<'a> Triangles<'a> {
    const NONE: Self = Self {
        positions: [Vec3Lanes::ZERO; 3],
        normals: [Vec3Lanes::ZERO; 3],
        uvs: [[Lanes::ZERO; 2]; 3],
        materials: [None; LANES],
        textures: [None; LANES],
        base: [Vec4::ONE; LANES],
        texture_from_uv: [Vec3Lanes::ZERO; 2],
    };

    #[inline(always)]
    fn set(&mut self, i: usize, scene: &'a Scene, triangle: u32) {
        let triangle = triangle as usize;
        let material = scene.material_of(scene.triangle_objects[triangle]);
        let channel = material.base_texture.as_ref().map_or(0, |binding| binding.uv_channel as usize & 1);
        for (corner, vertex) in scene.triangles[triangle].into_iter().enumerate() {
            let vertex = vertex as usize;
            self.positions[corner].set(i, scene.positions[vertex]);
            self.normals[corner].set(i, scene.normals[vertex]);
            let uv = scene.uvs[vertex][channel];
            (self.uvs[corner][0][i], self.uvs[corner][1][i]) = (uv.x, uv.y);
        }
        self.materials[i] = Some(material);
        self.base[i] = material.base_color;
        if let Some(binding) = &material.base_texture {
            self.textures[i] = scene.textures.get(binding.texture as usize).map(|texture| &**texture);
            let map = &binding.texture_from_uv;
            for row in 0..2 {
                let entries = [map.matrix2.x_axis[row], map.matrix2.y_axis[row], map.translation[row]];
                for (column, entry) in entries.into_iter().enumerate() {
                    self.texture_from_uv[row][column][i] = entry;
                }
            }
        }
    }

    /// Gives all points the triangle of the first.
    #[inline(always)]
    fn spread(&mut self) {
        for corner in 0..3 {
            for axis in 0..3 {
                self.positions[corner][axis] = Lanes::splat(self.positions[corner][axis][0]);
                self.normals[corner][axis] = Lanes::splat(self.normals[corner][axis][0]);
                self.texture_from_uv[axis % 2][corner] = Lanes::splat(self.texture_from_uv[axis % 2][corner][0]);
                self.uvs[corner][axis % 2] = Lanes::splat(self.uvs[corner][axis % 2][0]);
            }
        }
        self.materials = [self.materials[0]; LANES];
        self.textures = [self.textures[0]; LANES];
        self.base = [self.base[0]; LANES];
    }
}

/// The radiance of eight points; returns `None` if they need the general way.
#[inline(always)]
#[allow(clippy::needless_range_loop)] // lanes of many arrays, for the vectoriser
fn radiance(scene: &Scene, queries: &[&SurfaceQuery; LANES]) -> [Option<Vec3>; LANES] {
    let mut triangles = Triangles::NONE;
    let mut samples = [1u32; LANES];
    let (mut weights, mut dx, mut dy) = ([Lanes::ZERO; 2], [Lanes::ZERO; 2], [Lanes::ZERO; 2]);
    let mut viewers = Vec3Lanes::ZERO;
    let mut differences = 0;
    for (i, query) in queries.iter().enumerate() {
        let Barycentrics { value, dx: at_dx, dy: at_dy, samples: at_samples } = query.barycentrics;
        differences |= query.triangle ^ queries[0].triangle;
        samples[i] = at_samples;
        for axis in 0..2 {
            weights[axis][i] = value[axis];
            dx[axis][i] = at_dx[axis];
            dy[axis][i] = at_dy[axis];
        }
        viewers.set(i, query.towards_viewer);
    }
    triangles.set(0, scene, queries[0].triangle);
    if differences == 0 {
        // Neighbours mostly lie on one triangle.
        triangles.spread();
    } else {
        for i in 1..LANES {
            triangles.set(i, scene, queries[i].triangle);
        }
    }
    if !scene.colors.is_empty() {
        for (i, query) in queries.iter().enumerate() {
            let [a, b, c] =
                scene.triangles[query.triangle as usize].map(|vertex| Vec4::from(scene.colors[vertex as usize]));
            let value = query.barycentrics.value;
            triangles.base[i] *= a * (1.0 - value.x - value.y) + b * value.x + c * value.y;
        }
    }
    let Triangles { positions, normals, uvs, materials, textures, base, texture_from_uv } = &triangles;
    let any_lit = materials.iter().flatten().any(|material| !material.unlit);

    let look_ups = TextureLookUps { samples, ..look_ups(uvs, texture_from_uv, &weights, &dx, &dy) };
    let texels = filter::sample(textures, &look_ups);
    let mut light = Vec3Lanes::splat(Vec3::ONE);
    let mut usable = [true; LANES];
    if any_lit {
        let sides = sides(positions, normals, &viewers);
        let positions = interpolated(positions, &weights);
        let mut normals = interpolated(normals, &weights);
        for i in 0..LANES {
            let [x, y, z] = normals.components(i);
            let length2 = x * x + y * y + z * z;
            usable[i] = (length2 > 1e-36) & (length2 < f32::INFINITY);
            let inverse = sides[i] / length2.sqrt();
            (normals[0][i], normals[1][i], normals[2][i]) = (x * inverse, y * inverse, z * inverse);
        }
        light = irradiance_over_pi(scene, &positions, &normals, &viewers);
    }
    let mut result = [None; LANES];
    for i in 0..LANES {
        let Some(material) = materials[i] else { continue };
        let mut color = (base[i] * texels[i]).xyz();
        if !material.unlit {
            if !usable[i] || (material.emissive_texture.is_some() && material.emissive != Vec3::ZERO) {
                continue;
            }
            color = color * light.vector(i) + material.emissive;
        }
        if color.is_finite() {
            result[i] = Some(color.max(Vec3::ZERO));
        }
    }
    result
}

/// -1 for views of a triangle's back, the side that its corners' normals do not point to, else 1.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn sides(positions: &[Vec3Lanes; 3], normals: &[Vec3Lanes; 3], viewers: &Vec3Lanes) -> Lanes {
    let mut sides = Lanes::splat(1.0);
    // All loads come first and nothing branches, so that the loop becomes vector instructions.
    for i in 0..LANES {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [0, 1, 2].map(|corner: usize| positions[corner].components(i));
        let [[nx, ny, nz], [ox, oy, oz], [px, py, pz]] = [0, 1, 2].map(|corner: usize| normals[corner].components(i));
        let [vx, vy, vz] = viewers.components(i);
        let (sx, sy, sz) = (nx + ox + px, ny + oy + py, nz + oz + pz);
        let ([ux, uy, uz], [wx, wy, wz]) = ([bx - ax, by - ay, bz - az], [cx - ax, cy - ay, cz - az]);
        let (fx, fy, fz) = (uy * wz - wy * uz, uz * wx - wz * ux, ux * wy - wx * uy);
        let faces = fx * fx + fy * fy + fz * fz > 1e-36;
        let (fx, fy, fz) = (if faces { fx } else { nx }, if faces { fy } else { ny }, if faces { fz } else { nz });
        let outside = fx * sx + fy * sy + fz * sz;
        let towards = fx * vx + fy * vy + fz * vz;
        let sign = if outside < 0.0 { -1.0 } else { 1.0 };
        sides[i] = if towards * sign < 0.0 { -1.0 } else { 1.0 };
    }
    sides
}

#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn interpolated(corners: &[Vec3Lanes; 3], weights: &[Lanes; 2]) -> Vec3Lanes {
    let mut result = Vec3Lanes::ZERO;
    for axis in 0..3 {
        for i in 0..LANES {
            let [a, b, c] = [corners[0][axis][i], corners[1][axis][i], corners[2][axis][i]];
            result[axis][i] = a + (b - a) * weights[0][i] + (c - a) * weights[1][i];
        }
    }
    result
}

/// Texture coordinates and footprints.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn look_ups(
    corners: &[[Lanes; 2]; 3],
    texture_from_uv: &[Vec3Lanes; 2],
    weights: &[Lanes; 2],
    dx: &[Lanes; 2],
    dy: &[Lanes; 2],
) -> TextureLookUps<LANES> {
    let zero = [Lanes::ZERO; 2];
    let mut result = TextureLookUps { uv: zero, dx: zero, dy: zero, samples: [1; LANES] };
    for i in 0..LANES {
        let corner = |k: usize| Vec2::new(corners[k][0][i], corners[k][1][i]);
        let (a, b, c) = (corner(0), corner(1) - corner(0), corner(2) - corner(0));
        let at = a + b * weights[0][i] + c * weights[1][i];
        let (at_dx, at_dy) = (b * dx[0][i] + c * dx[1][i], b * dy[0][i] + c * dy[1][i]);
        for row in 0..2 {
            let [x, y, translation] = [0, 1, 2].map(|column| texture_from_uv[row][column][i]);
            result.uv[row][i] = x * at.x + y * at.y + translation;
            result.dx[row][i] = x * at_dx.x + y * at_dx.y;
            result.dy[row][i] = x * at_dy.x + y * at_dy.y;
        }
    }
    result
}

/// The arriving irradiance, over pi. Normals are of unit length and towards the viewers, whose directions are of any
/// length.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn irradiance_over_pi(scene: &Scene, positions: &Vec3Lanes, normals: &Vec3Lanes, viewers: &Vec3Lanes) -> Vec3Lanes {
    let mut sum = Vec3Lanes::ZERO;
    if scene.lights.is_empty() && scene.environment.is_none() {
        for i in 0..LANES {
            let [x, y, z] = viewers.components(i);
            let length2 = x * x + y * y + z * z;
            let cosine = (normals[0][i] * x + normals[1][i] * y + normals[2][i] * z) / length2.sqrt();
            let cosine = if cosine > 0.0 { cosine } else { 0.0 };
            (sum[0][i], sum[1][i], sum[2][i]) = (cosine, cosine, cosine);
        }
        return sum;
    }
    for light in &scene.lights {
        let strength = arriving(light, positions, normals);
        for (channel, intensity) in light.intensity.to_array().into_iter().enumerate() {
            for i in 0..LANES {
                sum[channel][i] += strength[i] * intensity;
            }
        }
    }
    if let Some(environment) = &scene.environment {
        for i in 0..LANES {
            let irradiance = environment.irradiance(normals.vector(i));
            for channel in 0..3 {
                sum[channel][i] += irradiance[channel];
            }
        }
    }
    sum.iter_mut().for_each(|channel| *channel *= std::f32::consts::FRAC_1_PI);
    sum
}

/// The share of a light's intensity that arrives on surfaces: [`Light::arriving`] times the cosine.
#[inline(always)]
#[allow(clippy::needless_range_loop)]
fn arriving(light: &Light, positions: &Vec3Lanes, normals: &Vec3Lanes) -> Lanes {
    let mut strength = Lanes::ZERO;
    let (range, inner_cos, outer_cos) = match light.kind {
        LightKind::Directional => {
            let towards = -light.direction;
            for i in 0..LANES {
                let cosine = normals[0][i] * towards.x + normals[1][i] * towards.y + normals[2][i] * towards.z;
                strength[i] = if cosine > 0.0 { cosine } else { 0.0 };
            }
            return strength;
        }
        // A point light is a spot that has not begun to fade behind itself.
        LightKind::Point { range } => (range, -3.0, -4.0),
        LightKind::Spot { range, inner_cos, outer_cos } => (range, inner_cos, outer_cos),
    };
    let inverse_range2 = if range.is_finite() { 1.0 / (range * range) } else { 0.0 };
    let inverse_fade = 1.0 / (inner_cos - outer_cos).max(1e-4);
    let (at, shines) = (light.position, light.direction);
    for i in 0..LANES {
        let [x, y, z] = [at.x - positions[0][i], at.y - positions[1][i], at.z - positions[2][i]];
        let distance2 = x * x + y * y + z * z;
        let distance2 = if distance2 > 1e-12 { distance2 } else { 1e-12 };
        let inverse = 1.0 / distance2.sqrt();
        let cosine = (normals[0][i] * x + normals[1][i] * y + normals[2][i] * z) * inverse;
        let cosine = if cosine > 0.0 { cosine } else { 0.0 };
        let ratio2 = distance2 * inverse_range2;
        let window = 1.0 - ratio2 * ratio2;
        let window = if window > 0.0 { window } else { 0.0 };
        let fade = (-(shines.x * x + shines.y * y + shines.z * z) * inverse - outer_cos) * inverse_fade;
        let fade = if fade > 0.0 { fade } else { 0.0 };
        let fade = if fade < 1.0 { fade } else { 1.0 };
        strength[i] = cosine * window * (fade * fade) / distance2;
    }
    strength
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::scene::{Environment, Sampler, TextureBinding};
    use glam::Affine2;
    use std::sync::Arc;

    /// Random triangles of seven materials: lit, unlit, glowing, with and without textures.
    fn scene(random: &mut Stream, colors: bool) -> Scene {
        let texel = |i: u32| [(i * 7919 % 65_536) as u16, (i * 104_729 % 65_536) as u16, 40_000, 65_535];
        let texture = Texture::from_linear16("", 32, 16, (0..512).map(texel).collect(), Sampler::default());
        let binding = |texture, uv_channel| {
            let texture_from_uv = Affine2::from_scale_angle_translation(Vec2::new(2.0, 0.5), 0.4, Vec2::new(0.1, -3.0));
            Some(TextureBinding { texture, uv_channel, texture_from_uv })
        };
        let plain = Material::diffuse("", Vec3::new(0.2, 0.5, 0.9));
        let textured = Material { base_texture: binding(0, 0), ..plain.clone() };
        let materials = vec![
            Material { base_texture: binding(0, 1), unlit: true, ..plain.clone() },
            Material { emissive: Vec3::new(3.0, 0.0, 0.5), ..textured.clone() },
            Material { emissive: Vec3::ONE, emissive_texture: binding(0, 1), ..textured.clone() },
            // A texture that does not exist is white.
            Material { base_texture: binding(7, 0), ..plain.clone() },
            Material { unlit: true, ..plain.clone() },
            plain,
            textured,
        ];
        let mut scene = Scene { materials, textures: vec![Arc::new(texture)], ..Scene::default() };
        for triangle in 0..70u32 {
            let mut number = || random.next_between(-1.0, 1.0);
            for _ in 0..3 {
                scene.positions.push(Vec3::new(number(), number(), number()) * 3.0);
                scene.normals.push(Vec3::new(number(), number(), number()).normalize_or_zero());
                scene.uvs.push([Vec2::new(number(), number()), Vec2::new(number(), number()) * 9.0]);
                if colors {
                    scene.colors.push([number().abs(), number().abs(), number().abs(), 1.0]);
                }
            }
            // Corners whose normals cancel out.
            if triangle % 10 == 9 {
                let last = scene.normals.len() - 1;
                scene.normals[last - 2..].copy_from_slice(&[Vec3::X, Vec3::NEG_X, Vec3::ZERO]);
            }
            scene.triangles.push([triangle * 3, triangle * 3 + 1, triangle * 3 + 2]);
            scene.triangle_objects.push(triangle % 7);
        }
        for material in 0..7 {
            scene.objects.push(crate::scene::Object {
                name: String::new(),
                material,
                triangles: 0..0,
                vertices: 0..0,
                surface: None,
                inside: false,
                bounds: Default::default(),
            });
        }
        scene
    }

    fn lights() -> Vec<Light> {
        let (inner_cos, outer_cos) = (0.9, 0.3);
        let kinds = [
            LightKind::Directional,
            LightKind::Point { range: f32::INFINITY },
            LightKind::Point { range: 2.5 },
            LightKind::Spot { range: f32::INFINITY, inner_cos, outer_cos },
            LightKind::Spot { range: 4.0, inner_cos: 0.5, outer_cos: 0.5 },
        ];
        let light = |kind| Light {
            kind,
            intensity: Vec3::new(1.0, 2.0, 0.3),
            position: Vec3::new(0.3, -0.7, 1.9),
            direction: Vec3::new(0.6, 0.0, -0.8),
        };
        kinds.map(light).to_vec()
    }

    #[test]
    fn batches_give_what_single_points_give() {
        let mut random = Stream::new(9);
        for round in 0..8 {
            let mut scene = scene(&mut random, round & 1 != 0);
            if round & 2 != 0 {
                scene.lights = lights();
            }
            if round & 4 != 0 {
                let sky = (0..32).map(|i| [i as f32, 1.0, 0.2]).collect();
                scene.environment = Some(Arc::new(Environment::new("sky", 8, 4, sky)));
            }
            for (count, alike) in [(0, 1), (1, 1), (7, 1), (8, 8), (9, 8), (333, 1), (333, 20)] {
                let queries: Vec<SurfaceQuery> = (0..count)
                    .map(|index| {
                        let mut pair = |scale: f32| Vec2::new(random.next_unit(), random.next_unit()) * scale;
                        let barycentrics =
                            Barycentrics { value: pair(0.5), dx: pair(0.2), dy: pair(0.02), samples: index % 9 };
                        // The middle of an edge, where opposite normals cancel out.
                        let middle = Barycentrics { value: Vec2::new(0.5, 0.0), ..barycentrics };
                        SurfaceQuery {
                            triangle: index / alike * 31 % 70,
                            barycentrics: if index % 5 == 0 { middle } else { barycentrics },
                            towards_viewer: (pair(2.0) - 1.0).extend(1.0 - random.next_unit()) * 7.0,
                        }
                    })
                    .collect();
                let mut colors = vec![Vec3::NAN; queries.len()];
                scene.radiance_batch(&queries, &mut colors);
                for (query, color) in queries.iter().zip(&colors) {
                    let expected = one_by_one(&scene, query);
                    let error = (*color - expected).abs().max_element();
                    assert!(error <= 2e-5 * (1.0 + expected.max_element()), "{color} against {expected}: {query:?}");
                }
            }
        }
    }
}
