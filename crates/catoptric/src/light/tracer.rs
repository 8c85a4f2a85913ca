//! The first surface along a ray: triangles and analytic surfaces in one bounding volume hierarchy.
//!
//! The hierarchy is `obvhs`'s eight-wide compressed one (Ylitie, Karras, Laine 2017).

use super::traversal::{Corners, LeafRange, Nearest, SPECIAL, meet_triangle, nearest};
use crate::scene::hit::{Hit, PrimitiveHit};
use crate::scene::shade::{Barycentrics, SurfaceInteraction, SurfacePoint};
use crate::scene::{AlphaMode, Ray, RayDifferential, Scene};
use crate::surface::{PlacedSurface, SurfaceHit};
use glam::{Vec2, Vec3, Vec3A};
use obvhs::aabb::Aabb as BvhBox;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::PlocBuilder;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};
use std::sync::atomic::{AtomicU64, Ordering};

/// Primitives with this bit are analytic surfaces; the rest of the number is the object's index.
const ANALYTIC: u32 = 1 << 31;
/// Triangles with this bit are tested for their alpha.
const ALPHA_TESTED: u32 = 1 << 30;
const INDEX: u32 = !SPECIAL;

/// The scene's hierarchy. It belongs to the scene that it was built from.
pub struct Tracer {
    bvh: CwBvh,
    leaves: Vec<LeafRange>,
    textured: bool,
    /// Primitives that rays were tested against, where that is counted.
    tests: Option<AtomicU64>,
}

/// Boxes beyond this many are built with less care: it would take seconds.
const CAREFUL_BUILD: usize = 2_000_000;

/// Up to this many boxes every node is tried in better places, twice: it takes a tenth of a second.
const THOROUGH_BUILD: usize = 100_000;

fn split_large(boxes: &mut Vec<BvhBox>, indices: &mut Vec<u32>, triangles: &[Triangle]) {
    if boxes.is_empty() || boxes.len() > CAREFUL_BUILD {
        return;
    }
    let areas = boxes.iter().map(|bounds| bounds.half_area());
    let (sum, largest) = areas.fold((0.0f64, 0.0f32), |(sum, largest), area| (sum + area as f64, area.max(largest)));
    let mean = (sum / boxes.len() as f64) as f32;
    if mean.is_finite() && largest.is_finite() {
        split_aabbs_preset(boxes, indices, triangles, mean, largest);
    }
}

/// Primitives in a leaf; the compressed layout holds three at most.
const MAX_LEAF: u32 = 3;

/// The hierarchy over boxes; its leaves name the boxes.
///
/// The builder could map boxes to primitives itself, but looks numbers up twice on the way to the compressed layout,
/// which is right only where the first boxes stand for the primitives of the same numbers.
fn build(boxes: &[BvhBox], split: bool) -> CwBvh {
    let preset = if boxes.len() <= THOROUGH_BUILD {
        BvhBuildParams { reinsertion_batch_ratio: 2.0, ..BvhBuildParams::slow_build() }
    } else if boxes.len() <= CAREFUL_BUILD {
        BvhBuildParams::slow_build()
    } else {
        BvhBuildParams::fast_build()
    };
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        preset.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        preset.sort_precision,
        preset.search_depth_threshold,
    );
    bvh.uses_spatial_splits = split;
    ReinsertionOptimizer::default().run(&mut bvh, preset.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&bvh, MAX_LEAF, true, false)
}

impl Tracer {
    /// The hierarchy over all objects of a scene for which `include` is true.
    pub fn build(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let mut codes = Vec::new();
        let mut triangles = Vec::new();
        let mut analytic = Vec::new();
        for (index, object) in scene.objects.iter().enumerate() {
            let index = index as u32;
            if !include(index) {
                continue;
            }
            if object.surface.is_some() {
                analytic.push(index);
                continue;
            }
            let tested = if is_alpha_tested(scene, index) { ALPHA_TESTED } else { 0 };
            for triangle in object.triangles.clone() {
                let [v0, v1, v2] = scene.triangles[triangle as usize].map(|v| Vec3A::from(scene.positions[v as usize]));
                triangles.push(Triangle { v0, v1, v2 });
                codes.push(triangle | tested);
            }
        }
        let mut boxes: Vec<BvhBox> = triangles.iter().map(Boundable::aabb).collect();
        // Which primitive a box stands for.
        let mut indices: Vec<u32> = (0..boxes.len() as u32).collect();
        // Large triangles (walls, floors) get several small boxes each, or they would overlap everything near them.
        split_large(&mut boxes, &mut indices, &triangles);
        for object in analytic {
            let Some(surface) = &scene.objects[object as usize].surface else { continue };
            let bounds = surface.bounds();
            // A plane's box is flat, and the tests of boxes are not exact: leave some room.
            let margin = Vec3A::splat(1e-5 * (bounds.diagonal() + bounds.center().abs().max_element()) + 1e-12);
            boxes.push(BvhBox::new(Vec3A::from(bounds.min) - margin, Vec3A::from(bounds.max) + margin));
            indices.push(codes.len() as u32);
            codes.push(ANALYTIC | object);
        }
        let split = boxes.len() > codes.len();
        let bvh = if boxes.is_empty() { CwBvh::default() } else { build(&boxes, split) };
        let leaf = |number: &u32| {
            let code = codes[indices[*number as usize] as usize];
            let corners = if code & ANALYTIC != 0 {
                [Vec3::ZERO; 3]
            } else {
                scene.triangles[(code & INDEX) as usize].map(|v| scene.positions[v as usize])
            };
            LeafRange { corners: Corners::new(corners), code }
        };
        let leaves = bvh.primitive_indices.iter().map(leaf).collect();
        Self { bvh, leaves, textured: scene.materials.iter().any(crate::scene::Material::textured), tests: None }
    }

    /// Has it count the triangles and surfaces that rays are tested against: that makes it slower.
    pub fn counting_tests(self) -> Self {
        Self { tests: Some(AtomicU64::new(0)), ..self }
    }

    /// Number of tests of rays against triangles and surfaces so far; `None` if they are not counted.
    pub fn test_count(&self) -> Option<u64> {
        self.tests.as_ref().map(|tests| tests.load(Ordering::Relaxed))
    }

    /// Memory of the hierarchy and its copy of the triangles.
    pub fn byte_count(&self) -> u64 {
        (size_of_val(self.bvh.nodes.as_slice()) + self.leaves.len() * (size_of::<LeafRange>() + 4)) as u64
    }

    /// True if the scene has textures, whose footprints matter.
    pub fn needs_differentials(&self) -> bool {
        self.textured
    }

    /// The first surface along a ray at a distance of at least `near`.
    #[inline(always)]
    pub fn first_hit(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<Hit> {
        let found = self.nearest(scene, ray, near)?;
        let index = found.code & INDEX;
        if found.code & ANALYTIC == 0 {
            return Some(Hit::Triangle { distance: found.distance, triangle: index, barycentrics: found.barycentrics });
        }
        // Once more for the details; the walk keeps only the distance.
        let hit = self.meet_surface(scene, index, ray, near, f32::INFINITY)?;
        Some(Hit::Surface { object: index, hit })
    }

    /// The same without the details.
    pub(crate) fn first_meeting(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<PrimitiveHit> {
        let found = self.nearest(scene, ray, near)?;
        let index = found.code & INDEX;
        Some(match found.code & ANALYTIC {
            0 => PrimitiveHit::Triangle(index),
            _ => PrimitiveHit::Surface { object: index, distance: found.distance.into() },
        })
    }

    #[inline(always)]
    fn nearest(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<Nearest> {
        if self.leaves.is_empty() || !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return None;
        }
        let special = |leaf: &LeafRange, far: f32| {
            let index = leaf.code & INDEX;
            if leaf.code & ANALYTIC == 0 {
                let (origin, direction) = (ray.origin.into(), ray.direction.into());
                let met = meet_triangle(&leaf.corners, origin, direction, near, far);
                return met.filter(|(_, barycentrics)| present(scene, index, *barycentrics));
            }
            let surface = scene.objects[index as usize].surface.as_ref()?;
            let distance = surface.first_distance(ray.origin, ray.direction, near, far)?;
            Some((distance as f32, Vec2::ZERO))
        };
        let found = nearest(&self.bvh, &self.leaves, ray, near, &special);
        if let Some(tests) = &self.tests {
            tests.fetch_add(found.tests.into(), Ordering::Relaxed);
        }
        (found.distance != f32::INFINITY).then_some(found)
    }

    fn meet_surface(&self, scene: &Scene, object: u32, ray: &Ray, near: f32, far: f32) -> Option<SurfaceHit> {
        let surface: &PlacedSurface = scene.objects[object as usize].surface.as_ref()?;
        surface.intersect(ray.origin, ray.direction, near, far)
    }

    /// The surface's point at a hit, with its changes a pixel where the ray's are given.
    #[inline(always)]
    pub fn encounter(
        &self,
        scene: &Scene,
        ray: &Ray,
        hit: &Hit,
        change: Option<&RayDifferential>,
    ) -> SurfaceInteraction {
        match hit {
            Hit::Triangle { distance, triangle, barycentrics } => {
                let mut at = Barycentrics { value: *barycentrics, ..Barycentrics::default() };
                let Some(change) = change else {
                    return SurfaceInteraction {
                        point: scene.surface_point(*triangle, &at),
                        ..SurfaceInteraction::default()
                    };
                };
                let [a, b, c] = scene.triangles[*triangle as usize];
                let a = scene.positions[a as usize];
                let (ab, ac) = (scene.positions[b as usize] - a, scene.positions[c as usize] - a);
                let face = ab.cross(ac);
                let moved = change.transferred(ray, *distance, face);
                // The dual basis of the triangle's edges turns steps into changes of the weights.
                let inverse = 1.0 / face.length_squared().max(f32::MIN_POSITIVE);
                let (dual_b, dual_c) = (ac.cross(face) * inverse, face.cross(ab) * inverse);
                at.dx = Vec2::new(moved[0].dot(dual_b), moved[0].dot(dual_c));
                at.dy = Vec2::new(moved[1].dot(dual_b), moved[1].dot(dual_c));
                scene.encounter(*triangle, &at)
            }
            Hit::Surface { object, hit } => scene.exact_encounter(*object, hit, ray, change),
        }
    }

    /// The surface's point at a hit.
    #[inline(always)]
    pub fn point(&self, scene: &Scene, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.encounter(scene, ray, hit, None).point
    }

    /// A point a little off the surface on the side that `direction` leaves to, from which rays can start.
    #[inline]
    pub fn departure(&self, point: &SurfacePoint, direction: Vec3) -> Vec3 {
        let offset = 16.0 * f32::EPSILON * point.coordinate_size.max(f32::MIN_POSITIVE);
        let side = if direction.dot(point.geometric_normal) < 0.0 { -offset } else { offset };
        point.position + point.geometric_normal * side
    }
}

/// One triangle, ready to be met by many rays: as [`Tracer::first_hit`] meets it, to the bit.
pub(crate) struct TriangleTest {
    corners: Corners,
    triangle: u32,
    alpha_tested: bool,
}

impl TriangleTest {
    /// Primitive of a triangle of a scene.
    #[inline]
    pub(crate) fn new(scene: &Scene, triangle: u32, alpha_tested: bool) -> Self {
        let corners = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
        Self { corners: Corners::new(corners), triangle, alpha_tested }
    }

    /// The distance at which a ray meets the triangle, if that is at least `near` and less than `far`.
    #[inline(always)]
    pub(crate) fn distance(&self, scene: &Scene, ray: &Ray, near: f32, far: f32) -> Option<f32> {
        let (distance, at) = meet_triangle(&self.corners, ray.origin.into(), ray.direction.into(), near, far)?;
        (!self.alpha_tested || present(scene, self.triangle, at)).then_some(distance)
    }
}

/// Returns true for objects whose triangles may have holes.
pub(crate) fn is_alpha_tested(scene: &Scene, object: u32) -> bool {
    matches!(scene.material_of(object).alpha_mode, AlphaMode::Mask(_))
}

#[cold]
fn present(scene: &Scene, triangle: u32, barycentrics: Vec2) -> bool {
    let point = scene.surface_point(triangle, &Barycentrics { value: barycentrics, ..Barycentrics::default() });
    scene.is_present(scene.material_of(point.object), &point)
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
            assert!(triangles.iter().any(|triangle| {
                meet_triangle(&Corners::new(*triangle), ray.origin.into(), ray.direction.into(), 0.0, f32::INFINITY)
                    .is_some()
            }));
        }
    }

    #[test]
    fn split_triangles_and_analytic_surfaces_keep_their_numbers() {
        use crate::scene::{Material, model::*};
        // A long thin diagonal triangle among small ones is split into several boxes.
        let mut primitive = Primitive {
            positions: vec![Vec3::splat(-9.0), Vec3::splat(9.0), Vec3::new(9.0, 9.0, 8.9)],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        for k in 0..40u32 {
            let at = Vec3::new(20.0 + k as f32 * 0.1, 0.0, 0.0);
            primitive.positions.extend([at, at + Vec3::Y * 0.1, at + Vec3::Z * 0.1]);
            primitive.triangles.push([3 * k + 3, 3 * k + 4, 3 * k + 5]);
        }
        let mut model = Model { materials: vec![Material::default()], ..Model::default() };
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        model.nodes.push(Node { mesh: Some(0), ..Node::default() });
        for x in [-3.0, 3.0] {
            let surface = crate::surface::AnalyticSurface::Sphere { radius: 0.5 };
            let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
            model.nodes.push(Node { analytic, local: LocalTransform::at(Vec3::new(x, -2.0, 5.0)), ..Node::default() });
        }
        let scene = model.pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |_| true);
        assert!(tracer.leaves.len() > 43, "nothing was split: {}", tracer.leaves.len());
        for (x, object) in [(-3.0, 1), (3.0, 2)] {
            let ray = Ray { origin: Vec3::new(x, -2.0, 20.0), direction: Vec3::NEG_Z };
            match tracer.first_hit(&scene, &ray, 0.0) {
                Some(Hit::Surface { object: found, hit }) => assert!(found == object && hit.distance == 14.5),
                other => panic!("{other:?}"),
            }
        }
        for k in 0..40 {
            let origin = Vec3::new(20.0 + k as f32 * 0.1 - 0.05, 0.02, 0.02);
            match tracer.first_hit(&scene, &Ray { origin, direction: Vec3::X }, 0.0) {
                Some(Hit::Triangle { triangle, .. }) => assert_eq!(triangle, k + 1),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn barycentrics_and_distance_give_the_same_point() {
        let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 0.5, 0.0), Vec3::new(-0.5, 2.0, 0.2)];
        let inside = corners[0] * 0.5 + corners[1] * 0.2 + corners[2] * 0.3;
        let origin = Vec3::new(1.0, 1.0, 5.0);
        let ray = Ray { origin, direction: (inside - origin).normalize() };
        let (distance, at) =
            meet_triangle(&Corners::new(corners), ray.origin.into(), ray.direction.into(), 0.0, f32::INFINITY).unwrap();
        assert!((at - Vec2::new(0.2, 0.3)).length() < 1e-5);
        assert!((origin + ray.direction * distance - inside).length() < 1e-5);
        assert!(
            meet_triangle(&Corners::new(corners), ray.origin.into(), ray.direction.into(), 0.0, distance * 0.99)
                .is_none()
        );
    }
}
