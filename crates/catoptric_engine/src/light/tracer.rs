//! The first surface along a ray: triangles and analytic surfaces in one bounding volume hierarchy.

pub use super::wide_hierarchy::{Narrow, Solid, has_extent};

use super::bodies::SceneBodies;
use super::light_through::{LightThrough, all_meetings};
#[cfg(target_arch = "x86_64")]
use super::wide_hierarchy::Avx2;
use super::wide_hierarchy::{
    ALPHA_TESTED, Beam, Portable, PrimitiveMet, PrimitiveTests, SignBits, Treelet, TriangleHit, WideHierarchy, meet,
};
use catoptric_core::scene::hit::{Hit, PrimitiveHit};
use catoptric_core::scene::shade::{Barycentrics, SurfaceInteraction, SurfacePoint};
use catoptric_core::scene::{Light, Ray, RayDifferential, Scene, ViewRays};
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
        let is_partial = |object: u32| scene.is_alpha_tested(object) || scene.is_one_sided(object);
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

    /// The number of places in leaves of the hierarchy: more than there are triangles and surfaces if some are split.
    pub fn place_count(&self) -> usize {
        self.hierarchy.place_count()
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
        self.details(scene, ray, near, walk.run::<true, _>(&mut ())?)
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
    pub fn is_blocked(&self, scene: &Scene, ray: &Ray, distance: f32) -> bool {
        self.walk(scene, ray, 0.0).is_blocked(distance)
    }

    /// The share of light that goes straight on along a ray to a distance, where some objects let light pass: no list
    /// of them where none does.
    pub(crate) fn passing(&self, scene: &Scene, ray: &Ray, distance: f32, clear: &[bool]) -> Vec3 {
        self.walk(scene, ray, 0.0).passing(distance, clear)
    }

    /// The first surface along a ray that stops light, as [`Self::passing`] has it, among some objects if they are
    /// given.
    pub(crate) fn first_stop(&self, scene: &Scene, ray: &Ray, objects: Option<&[bool]>) -> Option<Hit> {
        let walk = Walk { objects, ..self.walk(scene, ray, 0.0) };
        self.details(scene, ray, 0.0, walk.run::<false, _>(&mut ())?)
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

    /// Sets the shares of light that go straight on from a light to some points near each other, where some objects let
    /// light pass: no list of them where none does. The ways share what they may meet.
    pub fn find_passing(
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
        let Some(tests) = &self.tests else { return walk.run::<true, _>(&mut ()) };
        let mut count = 0u64;
        let found = walk.run::<true, _>(&mut count);
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
    /// The objects that light passes on the way, if some let it, with the share that has passed them.
    through: Option<&'a LightThrough<'a>>,
}

impl Walk<'_> {
    /// The nearest primitive, for rays of sight or those of light, with AVX2 where the machine has it.
    #[inline(always)]
    fn run<const OF_SIGHT: bool, C: PrimitiveTests>(&self, tests: &mut C) -> Option<PrimitiveMet> {
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            fn with_avx2<const OF_SIGHT: bool, C: PrimitiveTests>(
                walk: &Walk<'_>,
                tests: &mut C,
            ) -> Option<PrimitiveMet> {
                walk.run_in::<Avx2, OF_SIGHT, C>(tests)
            }
            if Avx2::is_available() {
                #[allow(unsafe_code, reason = "the machine has just been asked for the features")]
                return unsafe { with_avx2::<OF_SIGHT, C>(self, tests) };
            }
        }
        self.run_in::<Portable, OF_SIGHT, C>(tests)
    }

    /// True if any primitive is nearer than a distance, with AVX2 where the machine has it.
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
    fn run_in<S: SignBits, const OF_SIGHT: bool, C: PrimitiveTests>(&self, tests: &mut C) -> Option<PrimitiveMet> {
        let Self { hierarchy, treelet, ray, near, .. } = *self;
        let passes = |hit: &TriangleHit| self.passes::<OF_SIGHT>(hit);
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

#[cold]
fn is_seen<const OF_SIGHT: bool>(scene: &Scene, triangle: u32, barycentrics: Vec2, ray: &Ray) -> bool {
    let object = scene.triangle_objects[triangle as usize];
    let is_behind = OF_SIGHT && scene.is_one_sided(object) && scene.is_met_from_behind(triangle, ray.direction);
    !is_behind && (!scene.is_alpha_tested(object) || present(scene, triangle, barycentrics))
}

#[cold]
fn present(scene: &Scene, triangle: u32, barycentrics: Vec2) -> bool {
    let point = scene.surface_point(triangle, &Barycentrics { value: barycentrics, ..Barycentrics::default() });
    scene.is_present(scene.material_of(point.object), &point)
}
