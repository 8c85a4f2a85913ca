//! The first surface along a ray: triangles and analytic surfaces in one bounding volume hierarchy.
//!
//! The hierarchy is `obvhs`'s eight-wide compressed one (Ylitie, Karras, Laine 2017). Triangles are met by signed
//! volumes about the ray's origin, which are the same to the bit for both triangles at an edge: no ray slips
//! through a closed mesh.

use super::{PlacedSurface, SurfaceHit};
use crate::scene::shade::{Barycentrics, SurfacePoint};
use crate::scene::{AlphaMode, Ray, RayDifferential, Scene};
use glam::{Vec2, Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb as BvhBox;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams};

/// Primitives with this bit are analytic surfaces; the rest of the number is the object's index.
const ANALYTIC: u32 = 1 << 31;
/// Triangles with this bit are tested for their alpha.
const ALPHA_TESTED: u32 = 1 << 30;
const INDEX: u32 = ALPHA_TESTED - 1;

/// One primitive in the order of the hierarchy's leaves.
#[derive(Clone, Copy)]
struct Leaf {
    corners: [Vec3; 3],
    /// Index of the triangle or object, with the flags above.
    code: u32,
}

/// Where a ray meets the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hit {
    /// On a triangle.
    Triangle {
        /// Distance along the ray.
        distance: f32,
        /// Index of the triangle.
        triangle: u32,
        /// Barycentric coordinates of its second and third vertex.
        barycentrics: Vec2,
    },
    /// On an analytic surface.
    Surface {
        /// Index of the object.
        object: u32,
        /// Where, exactly.
        hit: SurfaceHit,
    },
}

impl Hit {
    /// Distance along the ray.
    pub fn distance(&self) -> f32 {
        match self {
            Self::Triangle { distance, .. } => *distance,
            Self::Surface { hit, .. } => hit.distance,
        }
    }
}

/// A hit with all that shading and the continuation of the ray need.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encounter {
    /// The surface's point.
    pub point: SurfacePoint,
    /// Change of the position with the pixel's column and row.
    pub position_change: [Vec3; 2],
    /// Change of the unit shading normal with the pixel's column and row.
    pub normal_change: [Vec3; 2],
}

/// The scene's hierarchy. It belongs to the scene that it was built from.
pub struct Tracer {
    bvh: CwBvh,
    leaves: Vec<Leaf>,
    /// Offset of new rays from their surface, as a share of their coordinates.
    scale: f32,
    textured: bool,
}

struct Bounded(BvhBox);

impl Boundable for Bounded {
    fn aabb(&self) -> BvhBox {
        self.0
    }
}

impl Tracer {
    /// The hierarchy over all objects of a scene for which `include` is true.
    pub fn build(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let mut codes = Vec::new();
        let mut boxes = Vec::new();
        for (index, object) in scene.objects.iter().enumerate() {
            let index = index as u32;
            if !include(index) {
                continue;
            }
            if let Some(surface) = &object.surface {
                let bounds = surface.bounds();
                // A plane's box is flat, and the tests of boxes are not exact: leave some room.
                let margin = Vec3A::splat(1e-5 * (bounds.diagonal() + bounds.center().abs().max_element()) + 1e-12);
                boxes.push(Bounded(BvhBox::new(Vec3A::from(bounds.min) - margin, Vec3A::from(bounds.max) + margin)));
                codes.push(ANALYTIC | index);
                continue;
            }
            let tested =
                if matches!(scene.material_of(index).alpha_mode, AlphaMode::Mask(_)) { ALPHA_TESTED } else { 0 };
            for triangle in object.triangles.clone() {
                let corners = scene.triangles[triangle as usize].map(|v| Vec3A::from(scene.positions[v as usize]));
                boxes.push(Bounded(BvhBox::from_points(&corners)));
                codes.push(triangle | tested);
            }
        }
        let bvh = if boxes.is_empty() {
            CwBvh::default()
        } else {
            let preset =
                if boxes.len() > 2_000_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
            build_cwbvh(&boxes, preset, &mut core::time::Duration::default())
        };
        let leaf = |index: &u32| {
            let code = codes[*index as usize];
            let corners = if code & ANALYTIC != 0 {
                [Vec3::ZERO; 3]
            } else {
                scene.triangles[(code & INDEX) as usize].map(|v| scene.positions[v as usize])
            };
            Leaf { corners, code }
        };
        let leaves = bvh.primitive_indices.iter().map(leaf).collect();
        let extent = scene.bounds.min.abs().max(scene.bounds.max.abs()).max_element();
        let scale = if extent.is_finite() { extent } else { 1.0 };
        Self { bvh, leaves, scale, textured: scene.materials.iter().any(crate::scene::Material::textured) }
    }

    /// Memory of the hierarchy and its copy of the triangles.
    pub fn byte_count(&self) -> u64 {
        (size_of_val(self.bvh.nodes.as_slice()) + self.leaves.len() * (size_of::<Leaf>() + 4)) as u64
    }

    /// Whether footprints of textures matter in this scene.
    pub fn needs_differentials(&self) -> bool {
        self.textured
    }

    /// The first surface along a ray at a distance of at least `near`.
    #[inline]
    pub fn first_hit(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<Hit> {
        if self.leaves.is_empty() || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let traversal = obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), near, f32::INFINITY);
        let mut best = None;
        let mut record = obvhs::ray::RayHit::none();
        self.bvh.ray_traverse(traversal, &mut record, |state, index| {
            let leaf = &self.leaves[index];
            if leaf.code & ANALYTIC == 0 {
                let Some((distance, barycentrics)) = meet(&leaf.corners, ray, near, state.tmax) else {
                    return f32::INFINITY;
                };
                let triangle = leaf.code & INDEX;
                if leaf.code & ALPHA_TESTED != 0 && !present(scene, triangle, barycentrics) {
                    return f32::INFINITY;
                }
                best = Some(Hit::Triangle { distance, triangle, barycentrics });
                distance
            } else {
                let object = leaf.code & INDEX;
                let surface: Option<&PlacedSurface> = scene.objects[object as usize].surface.as_ref();
                let Some(hit) = surface.and_then(|s| s.intersect(ray.origin, ray.direction, near, state.tmax)) else {
                    return f32::INFINITY;
                };
                best = Some(Hit::Surface { object, hit });
                hit.distance
            }
        });
        best
    }

    /// The surface's point at a hit, with its changes a pixel where the ray's are given.
    #[inline]
    pub fn encounter(&self, scene: &Scene, ray: &Ray, hit: &Hit, change: Option<&RayDifferential>) -> Encounter {
        match hit {
            Hit::Triangle { distance, triangle, barycentrics } => {
                let mut at = Barycentrics { value: *barycentrics, ..Barycentrics::default() };
                let Some(change) = change else {
                    return Encounter { point: scene.surface_point(*triangle, &at), ..Encounter::default() };
                };
                let vertices = scene.triangles[*triangle as usize].map(|v| v as usize);
                let [a, b, c] = vertices.map(|v| scene.positions[v]);
                let (ab, ac) = (b - a, c - a);
                let face = ab.cross(ac);
                let position_change = transferred(ray, change, *distance, face);
                let inverse = 1.0 / face.length_squared().max(f32::MIN_POSITIVE);
                let [dx, dy] = position_change
                    .map(|d| Vec2::new(d.cross(ac).dot(face) * inverse, ab.cross(d).dot(face) * inverse));
                (at.dx, at.dy) = (dx, dy);
                let point = scene.surface_point(*triangle, &at);
                let [na, nb, nc] = vertices.map(|v| scene.normals[v]);
                let (nab, nac) = (nb - na, nc - na);
                let length = (na + nab * barycentrics.x + nac * barycentrics.y).length().max(1e-6);
                let normal_change = [dx, dy].map(|d| {
                    let change = (nab * d.x + nac * d.y) / length;
                    change - point.normal * point.normal.dot(change)
                });
                Encounter { point, position_change, normal_change }
            }
            Hit::Surface { object, hit } => {
                let point = SurfacePoint {
                    object: *object,
                    position: hit.position,
                    geometric_normal: hit.normal,
                    normal: hit.normal,
                    color: Vec4::ONE,
                    ..SurfacePoint::default()
                };
                let Some(change) = change else {
                    return Encounter { point, ..Encounter::default() };
                };
                let position_change = transferred(ray, change, hit.distance, hit.normal);
                Encounter { point, position_change, normal_change: position_change.map(|d| d * hit.curvature) }
            }
        }
    }

    /// A point a little off the surface on the side that `direction` leaves to, from which rays can start.
    #[inline]
    pub fn departure(&self, point: &SurfacePoint, direction: Vec3) -> Vec3 {
        // Rounding of the point is in proportion to the largest coordinate that took part.
        let offset = 16.0 * f32::EPSILON * point.position.abs().max_element().max(0.1 * self.scale);
        let side = if direction.dot(point.geometric_normal) < 0.0 { -offset } else { offset };
        point.position + point.geometric_normal * side
    }
}

/// The change of the point where a ray meets a plane (Igehy 1999, equation 10).
#[inline]
fn transferred(ray: &Ray, change: &RayDifferential, distance: f32, normal: Vec3) -> [Vec3; 2] {
    let cosine = ray.direction.dot(normal);
    let inverse = if cosine.abs() > 1e-12 * normal.length() { 1.0 / cosine } else { 0.0 };
    [(change.origin_dx, change.direction_dx), (change.origin_dy, change.direction_dy)].map(|(origin, direction)| {
        let moved = origin + direction * distance;
        moved - ray.direction * (moved.dot(normal) * inverse)
    })
}

#[cold]
fn present(scene: &Scene, triangle: u32, barycentrics: Vec2) -> bool {
    let point = scene.surface_point(triangle, &Barycentrics { value: barycentrics, ..Barycentrics::default() });
    scene.is_present(scene.material_of(point.object), &point)
}

/// Distance and barycentric coordinates where a ray meets a triangle, from either side.
#[inline(always)]
fn meet(corners: &[Vec3; 3], ray: &Ray, near: f32, far: f32) -> Option<(f32, Vec2)> {
    let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
    let [a, b, c] = corners.map(|corner| Vec3A::from(corner) - origin);
    let (ca, ab, bc) = (c - a, a - b, b - c);
    // Six times the volumes of the tetrahedra that the ray spans with the edges; their signs decide.
    let u = ca.cross(c + a).dot(direction);
    let v = ab.cross(a + b).dot(direction);
    let w = bc.cross(b + c).dot(direction);
    let (low, high) = (u.min(v).min(w), u.max(v).max(w));
    if low < 0.0 && high > 0.0 {
        return None;
    }
    let normal = bc.cross(ab);
    let denominator = normal.dot(direction);
    let distance = normal.dot(a) / denominator;
    let sum = u + v + w;
    // Written so that a NaN is no hit.
    if !(distance >= near && distance < far && sum != 0.0) {
        return None;
    }
    let inverse = 1.0 / sum;
    Some((distance, Vec2::new(u * inverse, v * inverse)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

    #[test]
    fn no_ray_slips_through_shared_edges() {
        // Rays aimed exactly at points of shared edges of a fan must meet at least one of its triangles.
        let mut random = Stream::new(7);
        for _ in 0..2000 {
            let mut point = || Vec3::new(random.next_between(-1.0, 1.0), random.next_between(-1.0, 1.0), 0.0);
            let (hub, rim) = (point() * 0.1, [Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::NEG_X * 2.0, Vec3::NEG_Y * 2.0]);
            let triangles = [0, 1, 2, 3].map(|i| [hub, rim[i], rim[(i + 1) % 4]]);
            let share = random.next_unit();
            let target = hub.lerp(rim[(random.next_unit() * 4.0) as usize], share);
            let origin = Vec3::new(random.next_between(-3.0, 3.0), random.next_between(-3.0, 3.0), 2.0);
            let ray = Ray { origin, direction: (target - origin).normalize() };
            assert!(triangles.iter().any(|triangle| meet(triangle, &ray, 0.0, f32::INFINITY).is_some()));
        }
    }

    #[test]
    fn barycentrics_and_distance_give_the_same_point() {
        let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 0.5, 0.0), Vec3::new(-0.5, 2.0, 0.2)];
        let inside = corners[0] * 0.5 + corners[1] * 0.2 + corners[2] * 0.3;
        let origin = Vec3::new(1.0, 1.0, 5.0);
        let ray = Ray { origin, direction: (inside - origin).normalize() };
        let (distance, at) = meet(&corners, &ray, 0.0, f32::INFINITY).unwrap();
        assert!((at - Vec2::new(0.2, 0.3)).length() < 1e-5);
        assert!((origin + ray.direction * distance - inside).length() < 1e-5);
        assert!(meet(&corners, &ray, 0.0, distance * 0.99).is_none());
    }
}
