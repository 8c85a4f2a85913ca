//! The first surface along a ray: triangles and analytic surfaces in one bounding volume hierarchy.

pub use super::wide_hierarchy::has_extent;

use super::bodies::SceneBodies;
use super::light_through::{LightThrough, all_meetings};
#[cfg(target_arch = "x86_64")]
use super::wide_hierarchy::Avx2;
use super::wide_hierarchy::{
    ALPHA_TESTED, Beam, Portable, PrimitiveMet, PrimitiveTests, SignBits, Treelet, TriangleHit, WideHierarchy, meet,
};
use catoptric_core::scene::hit::{Hit, PrimitiveHit};
use catoptric_core::scene::shade::{Barycentrics, SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{AlphaMode, Light, Ray, RayDifferential, Scene, ViewRays};
use catoptric_core::surface::{PlacedSurface, SurfaceHit};
use glam::{Vec2, Vec3};
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Fewer points ask for their ways to a light one by one.
const FEW_POINTS: usize = 6;

/// A surface of a body that a ray passes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Crossing {
    /// See [`SceneBodies`].
    pub(crate) body: u32,
    pub(crate) distance: f32,
    /// The ray leaves the body there.
    pub(crate) leaves: bool,
}

/// The scene's hierarchy. It belongs to the scene that it was built from.
#[derive(Debug)]
pub struct Tracer {
    hierarchy: Arc<WideHierarchy>,
    /// The bodies among them.
    bodies: SceneBodies,
    /// Which objects it has, and which of them are not met everywhere or from both sides.
    objects: Vec<[bool; 2]>,
    has_footprints: bool,
    /// Primitives that rays were tested against, where that is counted.
    tests: Option<AtomicU64>,
}

impl Tracer {
    /// The hierarchy over all objects of a scene for which `include` is true: that of the scene's shadows, if it is the
    /// same.
    pub fn build(scene: &Scene, include: impl Fn(u32) -> bool) -> Self {
        let is_partial = |object: u32| is_alpha_tested(scene, object) || scene.is_one_sided(object);
        let objects: Vec<[bool; 2]> =
            (0..scene.objects.len() as u32).map(|object| [include(object), is_partial(object)]).collect();
        let of_shadows = scene.light_visibility.as_ref().and_then(|means| {
            let known: Option<&Self> = means.hierarchy().downcast_ref();
            known.filter(|known| known.objects == objects)
        });
        let hierarchy = match of_shadows {
            Some(known) => known.hierarchy.clone(),
            None => Arc::new(WideHierarchy::build_for_rays(scene, include, is_partial)),
        };
        let has_footprints = scene.materials.iter().any(|material| scene.has_footprints(material));
        let bodies = SceneBodies::new(scene, |object| objects[object as usize][0]);
        Self { hierarchy, bodies, objects, has_footprints, tests: None }
    }

    /// The same for another moment of the scene, with as many triangles; `None` if it has to be built anew. Where much
    /// has moved, rays take longer than through a new one.
    pub fn refitted(&self, scene: &Scene) -> Option<Self> {
        let mut hierarchy = WideHierarchy::clone(&self.hierarchy);
        let has_moved = hierarchy.refit(scene);
        let (hierarchy, objects) = (Arc::new(hierarchy), self.objects.clone());
        let bodies = SceneBodies::new(scene, |object| objects[object as usize][0]);
        has_moved.then_some(Self { hierarchy, bodies, objects, has_footprints: self.has_footprints, tests: None })
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
        self.hierarchy.byte_count()
    }

    /// True if footprints of rays matter: the scene has textures or highlights.
    pub fn needs_differentials(&self) -> bool {
        self.has_footprints
    }

    /// The first surface along a ray at a distance of at least `near`.
    #[inline(always)]
    pub fn first_hit(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<Hit> {
        self.details(scene, ray, near, self.nearest(scene, ray, near, None)?)
    }

    /// The first surface of those objects along a ray that a list says yes to, whatever is in front of them.
    pub fn first_hit_of(&self, scene: &Scene, ray: &Ray, near: f32, objects: &[bool]) -> Option<Hit> {
        let walk = Walk { objects: Some(objects), ..self.walk(scene, ray, near) };
        self.details(scene, ray, near, walk.run(&mut ())?)
    }

    /// The same for a ray of a beam whose leaves were gathered: [`Self::gather`].
    #[inline(always)]
    pub fn first_hit_among(&self, scene: &Scene, ray: &Ray, near: f32, treelet: &Treelet) -> Option<Hit> {
        self.details(scene, ray, near, self.nearest(scene, ray, near, Some(treelet))?)
    }

    /// Gathers what the rays through a rectangle of a picture (two corners, in pixels) may meet.
    pub fn gather(&self, view: &ViewRays, low: Vec2, high: Vec2, treelet: &mut Treelet) {
        gather(&self.hierarchy, &Beam::through(view, low, high), treelet);
    }

    #[inline(always)]
    fn details(&self, scene: &Scene, ray: &Ray, near: f32, met: PrimitiveMet) -> Option<Hit> {
        match met {
            PrimitiveMet::Triangle(TriangleHit { distance, triangle, barycentrics }) => {
                Some(Hit::Triangle { distance, triangle: triangle & !ALPHA_TESTED, barycentrics })
            }
            // Once more for the details; the walk keeps only the distance.
            PrimitiveMet::Surface(object, _) => {
                let hit = self.meet_surface(scene, object, ray, near, f32::INFINITY)?;
                Some(Hit::Surface { object, hit })
            }
        }
    }

    /// The same without the details.
    pub fn first_meeting(&self, scene: &Scene, ray: &Ray, near: f32) -> Option<PrimitiveHit> {
        Some(match self.nearest(scene, ray, near, None)? {
            PrimitiveMet::Triangle(hit) => PrimitiveHit::Triangle(hit.triangle & !ALPHA_TESTED),
            PrimitiveMet::Surface(object, distance) => PrimitiveHit::Surface { object, distance: distance.into() },
        })
    }

    /// Returns true if anything is nearer along a ray than a distance.
    pub(crate) fn is_blocked(&self, scene: &Scene, ray: &Ray, distance: f32) -> bool {
        self.walk(scene, ray, 0.0).is_blocked(distance)
    }

    /// The share of light that goes straight on along a ray to a distance, where some objects let light pass: no list
    /// of them where none does.
    pub(crate) fn passing(&self, scene: &Scene, ray: &Ray, distance: f32, clear: &[bool]) -> Vec3 {
        self.walk(scene, ray, 0.0).passing(distance, clear)
    }

    /// The bodies of glass and liquid.
    pub(crate) fn bodies(&self) -> &SceneBodies {
        &self.bodies
    }

    /// Visits the surfaces of bodies that a ray passes up to a distance, in any order.
    pub(crate) fn visit_crossings(&self, scene: &Scene, ray: &Ray, distance: f32, visit: impl FnMut(Crossing)) {
        let visit = RefCell::new(visit);
        let meet = |body: u32, distance: f32, leaves: bool| {
            (visit.borrow_mut())(Crossing { body, distance, leaves });
        };
        let passes = |hit: &TriangleHit| {
            let triangle = hit.triangle & !ALPHA_TESTED;
            if let Some(body) = self.bodies.of(scene.triangle_objects[triangle as usize])
                && (hit.triangle & ALPHA_TESTED == 0 || is_seen::<false>(scene, triangle, hit.barycentrics, ray))
            {
                meet(body, hit.distance, scene.is_met_from_behind(triangle, ray.direction));
            }
            false
        };
        let surface = |object: u32, far: f32| {
            let (placed, body) = (scene.objects[object as usize].surface.as_ref()?, self.bodies.of(object)?);
            for hit in all_meetings(placed, ray, [0.0, far]) {
                meet(body, hit.distance, ray.direction.dot(hit.normal) > 0.0);
            }
            None
        };
        self.hierarchy.meets_any::<Portable>(ray, distance, passes, surface);
    }

    /// The same for the ways from some points to a light. They share what they may meet.
    pub(crate) fn find_passing(
        &self,
        scene: &Scene,
        (light, points): (&Light, &[Vec3]),
        clear: &[bool],
        treelet: &mut Treelet,
        passing: &mut [Vec3],
    ) {
        let beam = if points.len() < FEW_POINTS { None } else { Beam::to_light(light, points) };
        if let Some(beam) = &beam {
            gather(&self.hierarchy, beam, treelet);
        }
        let treelet = beam.map(|_| &*treelet);
        for (point, passing) in points.iter().zip(passing) {
            *passing = light.way_from(*point).map_or(Vec3::ONE, |(ray, distance)| {
                Walk { treelet, ..self.walk(scene, &ray, 0.0) }.passing(distance, clear)
            });
        }
    }

    #[inline(always)]
    fn walk<'a>(&'a self, scene: &'a Scene, ray: &'a Ray, near: f32) -> Walk<'a> {
        Walk { hierarchy: &self.hierarchy, treelet: None, scene, ray, near, objects: None, through: None }
    }

    #[inline(always)]
    fn nearest(&self, scene: &Scene, ray: &Ray, near: f32, treelet: Option<&Treelet>) -> Option<PrimitiveMet> {
        let walk = Walk { treelet, ..self.walk(scene, ray, near) };
        let Some(tests) = &self.tests else { return walk.run(&mut ()) };
        let mut count = 0u64;
        let found = walk.run(&mut count);
        tests.fetch_add(count, Ordering::Relaxed);
        found
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
                [at.dx, at.dy] = self.barycentric_changes(scene, ray, *triangle, *distance, change);
                scene.encounter(*triangle, &at)
            }
            Hit::Surface { object, hit } => scene.exact_encounter(*object, hit, ray, change),
        }
    }

    /// The change a pixel, along columns and rows, of the barycentric coordinates at which a ray meets a triangle at a
    /// distance.
    #[inline(always)]
    pub(crate) fn barycentric_changes(
        &self,
        scene: &Scene,
        ray: &Ray,
        triangle: u32,
        distance: f32,
        change: &RayDifferential,
    ) -> [Vec2; 2] {
        let [a, b, c] = scene.triangles[triangle as usize];
        let a = scene.positions[a as usize];
        let (ab, ac) = (scene.positions[b as usize] - a, scene.positions[c as usize] - a);
        let face = ab.cross(ac);
        let moved = change.transferred(ray, distance, face);
        // The dual basis of the triangle's edges turns steps into changes of the weights.
        let inverse = 1.0 / face.length_squared().max(f32::MIN_POSITIVE);
        let (dual_b, dual_c) = (ac.cross(face) * inverse, face.cross(ab) * inverse);
        moved.map(|step| Vec2::new(step.dot(dual_b), step.dot(dual_c)))
    }

    /// The surface's point at a hit.
    #[inline(always)]
    pub fn point(&self, scene: &Scene, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.encounter(scene, ray, hit, None).point
    }

    /// How far off a surface rays start: what is nearer behind it is not met.
    #[inline(always)]
    pub(crate) fn departure_offset(point: &SurfacePoint) -> f32 {
        16.0 * f32::EPSILON * point.coordinate_size.max(f32::MIN_POSITIVE)
    }

    /// A point a little off the surface on the side that `direction` leaves to, from which rays can start.
    #[inline]
    pub fn departure(&self, point: &SurfacePoint, direction: Vec3) -> Vec3 {
        let offset = Self::departure_offset(point);
        let side = if direction.dot(point.geometric_normal) < 0.0 { -offset } else { offset };
        point.position + point.geometric_normal * side
    }
}

/// A ray's way through the hierarchy.
struct Walk<'a> {
    hierarchy: &'a WideHierarchy,
    treelet: Option<&'a Treelet>,
    scene: &'a Scene,
    ray: &'a Ray,
    near: f32,
    /// The objects that are met, if not all are.
    objects: Option<&'a [bool]>,
    /// What light passes on the way, if some objects let it.
    through: Option<&'a LightThrough<'a>>,
}

impl Walk<'_> {
    /// The nearest primitive, with AVX2 where the machine has it.
    #[inline(always)]
    fn run<C: PrimitiveTests>(&self, tests: &mut C) -> Option<PrimitiveMet> {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            fn with_avx2<C: PrimitiveTests>(walk: &Walk<'_>, tests: &mut C) -> Option<PrimitiveMet> {
                walk.run_in::<Avx2, C>(tests)
            }
            if Avx2::is_available() {
                #[allow(unsafe_code, reason = "the machine has just been asked for the features")]
                return unsafe { with_avx2(self, tests) };
            }
        }
        self.run_in::<Portable, C>(tests)
    }

    /// Whether there is any primitive nearer than a distance, with AVX2 where the machine has it.
    fn is_blocked(&self, distance: f32) -> bool {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            fn with_avx2(walk: &Walk<'_>, distance: f32) -> bool {
                walk.is_blocked_in::<Avx2>(distance)
            }
            if Avx2::is_available() {
                #[allow(unsafe_code, reason = "the machine has just been asked for the features")]
                return unsafe { with_avx2(self, distance) };
            }
        }
        self.is_blocked_in::<Portable>(distance)
    }

    /// The share of light that goes straight on to a distance.
    fn passing(self, distance: f32, clear: &[bool]) -> Vec3 {
        if clear.is_empty() {
            return if self.is_blocked(distance) { Vec3::ZERO } else { Vec3::ONE };
        }
        let through = LightThrough::new(clear);
        let walk = Walk { through: Some(&through), ..self };
        if walk.is_blocked(distance) { Vec3::ZERO } else { through.passed() }
    }

    /// Returns true if light is stopped where its ray meets a triangle, and notes what passes where some does.
    #[inline(always)]
    fn stops_light(&self, hit: &TriangleHit) -> bool {
        if let Some(through) = self.through {
            let object = self.scene.triangle_objects[(hit.triangle & !ALPHA_TESTED) as usize];
            let is_among = self.objects.is_none_or(|objects| objects[object as usize]);
            // Such objects let it pass at their holes, too.
            if is_among && through.lets_pass(object) {
                return !through.pass_triangle(self.scene, self.ray, hit);
            }
        }
        self.passes::<false>(hit)
    }

    /// The same for the surface of an object: the distance at which it stops light.
    #[inline(always)]
    fn surface_that_stops_light(&self, object: u32, far: f32) -> Option<f32> {
        let Some(through) = self.through.filter(|through| through.lets_pass(object)) else {
            return self.surface(object, far);
        };
        let Self { scene, ray, near, .. } = *self;
        if let Some(surface) = &scene.objects[object as usize].surface {
            through.pass_surface(scene, ray, (object, surface), [near, far]);
        }
        None
    }

    /// Returns true if a ray is stopped where it meets a triangle. Rays of sight pass holes and the backs of one-sided
    /// surfaces, rays to lights pass holes alone.
    #[inline(always)]
    fn passes<const OF_SIGHT: bool>(&self, hit: &TriangleHit) -> bool {
        let Self { scene, objects, ray, .. } = *self;
        let triangle = hit.triangle & !ALPHA_TESTED;
        let is_among = objects.is_none_or(|objects| objects[scene.triangle_objects[triangle as usize] as usize]);
        is_among && (hit.triangle & ALPHA_TESTED == 0 || is_seen::<OF_SIGHT>(scene, triangle, hit.barycentrics, ray))
    }

    /// The distance at which the surface of an object is met.
    #[inline(always)]
    fn surface(&self, object: u32, far: f32) -> Option<f32> {
        let Self { scene, ray, near, objects, .. } = *self;
        let surface = scene.objects[object as usize].surface.as_ref()?;
        if objects.is_some_and(|objects| !objects[object as usize]) {
            return None;
        }
        Some(surface.first_distance(ray.origin, ray.direction, near, far)? as f32)
    }

    #[inline(always)]
    fn is_blocked_in<S: SignBits>(&self, distance: f32) -> bool {
        let Self { hierarchy, treelet, ray, .. } = *self;
        let passes = |hit: &TriangleHit| self.stops_light(hit);
        let surface = |object: u32, far: f32| self.surface_that_stops_light(object, far);
        if let Some(treelet) = treelet
            && let Some(is_blocked) = treelet.meets_any::<S>(hierarchy, ray, distance, passes, surface)
        {
            return is_blocked;
        }
        hierarchy.meets_any::<S>(ray, distance, passes, surface)
    }

    #[inline(always)]
    fn run_in<S: SignBits, C: PrimitiveTests>(&self, tests: &mut C) -> Option<PrimitiveMet> {
        let Self { hierarchy, treelet, ray, near, .. } = *self;
        let passes = |hit: &TriangleHit| self.passes::<true>(hit);
        let surface = |object: u32, far: f32| self.surface(object, far);
        if let Some(treelet) = treelet
            && let Some(found) = treelet.nearest::<S>(hierarchy, ray, near, passes, surface, tests)
        {
            return found;
        }
        hierarchy.nearest_of_all::<S>(ray, near, f32::INFINITY, passes, surface, tests)
    }
}

/// [`WideHierarchy::gather`], with AVX2 where the machine has it.
fn gather<const SIDES: usize>(hierarchy: &WideHierarchy, beam: &Beam<SIDES>, treelet: &mut Treelet) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn with_avx2<const SIDES: usize>(hierarchy: &WideHierarchy, beam: &Beam<SIDES>, treelet: &mut Treelet) {
            hierarchy.gather::<Avx2, SIDES>(beam, treelet);
        }
        if Avx2::is_available() {
            #[allow(unsafe_code, reason = "the machine has just been asked for the features")]
            return unsafe { with_avx2(hierarchy, beam, treelet) };
        }
    }
    hierarchy.gather::<Portable, SIDES>(beam, treelet);
}

/// One triangle, ready to be met by many rays: as [`Tracer::first_hit`] meets it, to the bit.
pub struct TriangleTest {
    corners: [[f32; 3]; 3],
    triangle: u32,
    alpha_tested: bool,
}

impl TriangleTest {
    /// Primitive of a triangle of a scene.
    #[inline]
    pub fn new(scene: &Scene, triangle: u32, alpha_tested: bool) -> Self {
        let corners = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
        Self { corners: corners.map(|corner| corner.to_array()), triangle, alpha_tested }
    }

    /// The distance at which a ray meets the triangle, if that is at least `near` and less than `far`.
    #[inline(always)]
    pub fn distance(&self, scene: &Scene, ray: &Ray, near: f32, far: f32) -> Option<f32> {
        let met = meet(self.corners, [ray.origin.to_array(), ray.direction.to_array()]);
        let is_hit = met.inside && met.distance >= near && met.distance < far;
        let is_there = || !self.alpha_tested || present(scene, self.triangle, Vec2::from_array(met.weights));
        (is_hit && is_there()).then_some(met.distance)
    }
}

/// Returns true for objects whose triangles may have holes.
pub fn is_alpha_tested(scene: &Scene, object: u32) -> bool {
    scene.material_of(object).alpha_mode != AlphaMode::Opaque
}

#[cold]
fn is_seen<const OF_SIGHT: bool>(scene: &Scene, triangle: u32, barycentrics: Vec2, ray: &Ray) -> bool {
    let object = scene.triangle_objects[triangle as usize];
    let is_behind = OF_SIGHT && scene.is_one_sided(object) && scene.is_met_from_behind(triangle, ray.direction);
    !is_behind && (!is_alpha_tested(scene, object) || present(scene, triangle, barycentrics))
}

#[cold]
fn present(scene: &Scene, triangle: u32, barycentrics: Vec2) -> bool {
    let point = scene.surface_point(triangle, &Barycentrics { value: barycentrics, ..Barycentrics::default() });
    scene.is_present(scene.material_of(point.object), &point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::math::random::Stream;

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
                meet(triangle.map(|corner| corner.to_array()), [ray.origin.to_array(), ray.direction.to_array()]).inside
            }));
        }
    }

    #[test]
    fn split_triangles_and_analytic_surfaces_keep_their_numbers() {
        use catoptric_core::scene::{Material, model::*};
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
            let surface = catoptric_core::surface::AnalyticSurface::Sphere { radius: 0.5 };
            let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
            model.nodes.push(Node { analytic, local: LocalTransform::at(Vec3::new(x, -2.0, 5.0)), ..Node::default() });
        }
        let scene = model.pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |_| true);
        let places = tracer.hierarchy.place_count();
        assert!(places > 43, "nothing was split: {places}");
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

    /// A narrow floor, which is split into several boxes, and balls, exact ones and meshes, that are moved.
    fn balls(shift: Vec3) -> Scene {
        use catoptric_core::scene::{Material, model::*};
        use catoptric_core::surface::{AnalyticSurface, sphere_mesh};
        let mut model = Model { materials: vec![Material::default()], ..Model::default() };
        let floor = Primitive {
            positions: vec![Vec3::new(-9.0, -3.0, -9.0), Vec3::new(9.0, -1.0, 9.0), Vec3::new(9.0, -1.0, 6.0)],
            triangles: vec![[0, 2, 1]],
            ..Primitive::default()
        };
        let ball = sphere_mesh(0.7, 12, 24);
        let ball = Primitive {
            positions: ball.positions,
            normals: ball.normals,
            triangles: ball.triangles,
            ..Primitive::default()
        };
        for (mesh, primitive) in [floor, ball].into_iter().enumerate() {
            model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
            let local = LocalTransform::at(shift * mesh as f32);
            model.nodes.push(Node { mesh: Some(mesh), local, ..Node::default() });
        }
        for x in [-2.0, 2.0] {
            let surface = AnalyticSurface::Sphere { radius: 0.6 };
            let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
            let local = LocalTransform::at(Vec3::new(x, 0.0, 0.5) + shift * x);
            model.nodes.push(Node { analytic, local, ..Node::default() });
        }
        model.pose(&Default::default()).unwrap()
    }

    #[test]
    fn refitted_and_filtered_tracers_meet_what_new_ones_meet() {
        let (before, after) = (balls(Vec3::ZERO), balls(Vec3::new(0.3, 0.4, -0.5)));
        let new = Tracer::build(&after, |_| true);
        let refitted = Tracer::build(&before, |_| true).refitted(&after).expect("no triangle was flat");
        let places = new.hierarchy.place_count();
        assert!(places > after.objects[1].triangles.len() + 3, "the floor was not split: {places}");
        let listed = [false, true, false, true];
        let of_listed = Tracer::build(&after, |object| listed[object as usize]);
        let mut random = Stream::new(5);
        let mut met = [0; 4];
        for _ in 0..3000 {
            let mut point = |size: f32| Vec3::from_array([0, 1, 2].map(|_| random.next_between(-size, size)));
            let origin = point(4.0) + Vec3::Y * 4.0;
            let ray = Ray { origin, direction: (point(2.0) - origin).normalize() };
            let place = |hit: Option<Hit>| hit.map(|hit| (hit.object(&after), hit.distance()));
            let found = place(new.first_hit(&after, &ray, 0.0));
            assert_eq!(found, place(refitted.first_hit(&after, &ray, 0.0)), "{ray:?}");
            let among = place(new.first_hit_of(&after, &ray, 0.0, &listed));
            assert_eq!(among, place(of_listed.first_hit(&after, &ray, 0.0)), "{ray:?}");
            if let Some((object, _)) = found {
                met[object as usize] += 1;
            }
        }
        assert!(met.iter().all(|count| *count > 30), "{met:?}");
    }

    #[test]
    fn barycentrics_and_distance_give_the_same_point() {
        let corners = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(3.0, 0.5, 0.0), Vec3::new(-0.5, 2.0, 0.2)];
        let inside = corners[0] * 0.5 + corners[1] * 0.2 + corners[2] * 0.3;
        let origin = Vec3::new(1.0, 1.0, 5.0);
        let ray = Ray { origin, direction: (inside - origin).normalize() };
        let met = meet(corners.map(|corner| corner.to_array()), [ray.origin.to_array(), ray.direction.to_array()]);
        assert!(met.inside && (Vec2::from_array(met.weights) - Vec2::new(0.2, 0.3)).length() < 1e-5);
        assert!((origin + ray.direction * met.distance - inside).length() < 1e-5);
    }

    #[test]
    fn points_near_each_other_see_the_lights_that_each_sees_alone() {
        use catoptric_core::scene::LightKind;
        use catoptric_scenes::builtin;
        let scene = builtin::parse("workshop?tess=16").unwrap().pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |_| true);
        let mut random = Stream::new(17);
        let (mut treelet, mut counts) = (Treelet::default(), [0, 0]);
        let range = f32::INFINITY;
        for cluster in 0..400 {
            let mut point = |size: f32| {
                let step = Vec3::new(random.next_unit(), random.next_unit(), random.next_unit()) - 0.5;
                scene.bounds.size() * step * size
            };
            let middle = scene.bounds.center() + point(0.8);
            // Some lie among the points.
            let size = [0.01, 0.05, 0.5][cluster % 3];
            let position = middle + point([size, 0.5, 1.0][cluster / 3 % 3]);
            let direction = (middle - position).normalize();
            let kind = if cluster % 2 == 0 { LightKind::Directional } else { LightKind::Point { range } };
            let light = Light { kind, intensity: Vec3::ONE, position, direction };
            let points: Vec<Vec3> = (0..24).map(|_| middle + point(size)).collect();
            let mut found = [Vec3::ONE; 24];
            tracer.find_passing(&scene, (&light, &points), &[], &mut treelet, &mut found);
            for (point, found) in points.iter().zip(found) {
                let (ray, distance) = light.way_from(*point).unwrap();
                let is_hidden = tracer.is_blocked(&scene, &ray, distance);
                assert_eq!(found, if is_hidden { Vec3::ZERO } else { Vec3::ONE }, "{light:?} from {point}");
                counts[usize::from(is_hidden)] += 1;
            }
        }
        assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
    }

    #[test]
    fn surfaces_one_behind_the_other_are_those_of_all_triangles() {
        use catoptric_scenes::builtin;
        let scene = builtin::parse("teapot").unwrap().pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |_| true);
        let mut random = Stream::new(31);
        let size = scene.bounds.diagonal();
        let mut hits = 0;
        for _ in 0..150 {
            let mut point = || Vec3::new(random.next_unit(), random.next_unit(), random.next_unit()) - 0.5;
            let target = scene.bounds.center() + point() * size * 0.2;
            let origin = scene.bounds.center() + point() * size;
            let ray = Ray { origin, direction: (target - origin).normalize() };
            let mut near = 0.0;
            for _ in 0..12 {
                let found = tracer.first_hit(&scene, &ray, near);
                let all = (0..scene.triangles.len() as u32).filter_map(|triangle| {
                    TriangleTest::new(&scene, triangle, false).distance(&scene, &ray, near, f32::INFINITY)
                });
                let nearest = all.reduce(f32::min);
                assert_eq!(found.as_ref().map(Hit::distance), nearest, "{ray:?} beyond {near}");
                let Some(distance) = nearest else { break };
                near = distance * 1.0001 + 1e-5;
                hits += 1;
            }
        }
        assert!(hits > 300, "{hits}");
    }
}
