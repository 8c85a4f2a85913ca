//! Occlusion of specular paths by reflectors and lenses.

use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::{Ray, Scene};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use glam::DVec3;

/// Rays leave and reach surfaces this many roundings of their coordinates away, the tracer's own distance.
const CLEARANCE: f64 = 16.0 * f32::EPSILON as f64;

/// A ray that touches surfaces more often than this without passing through one is taken to be free. A bound on time;
/// chosen, not measured.
const MAX_TOUCHES: usize = 16;

/// Visibility of paths: tells which are free, and which object blocks each of the others.
///
/// Segments are tested with single-precision rays (analytic surfaces in double precision). At its bounces a segment
/// ends a little above the surface, on the side from which it comes, so that neither rounding nor grazing incidence
/// makes a surface block itself, and one that lies in the way still does. Eye and scene point may lie on a surface.
/// Occluders nearer than about 2e-6 of the coordinates count as touching.
pub struct PathVisibility<'a> {
    scene: &'a Scene,
    tracer: Tracer,
}

/// One end of a segment.
#[derive(Clone, Copy)]
struct End {
    point: DVec3,
    /// True if the end may lie on a surface: touching one there does not block.
    free: bool,
}

impl<'a> PathVisibility<'a> {
    /// Visibility among the occluders in `tracer`: the scene's reflectors and lenses.
    pub fn new(scene: &'a Scene, tracer: Tracer) -> Self {
        Self { scene, tracer }
    }

    /// Visibility among all reflectors and lenses of a scene.
    pub fn of_scene(scene: &'a Scene) -> Self {
        Self::new(scene, Tracer::build(scene, |object| scene.role_of(object).is_specular()))
    }

    /// Visibility among all that hides points in a picture: reflectors, lenses, and surfaces that let no light pass.
    pub fn in_pictures(scene: &'a Scene) -> Self {
        let hides = |object| scene.role_of(object).is_specular() || !scene.material_of(object).lets_light_pass();
        Self::new(scene, Tracer::build(scene, hides))
    }

    /// True if nothing blocks the path from the eye over the bounce points (one for each bounce of `path`) to `point`.
    pub fn is_visible(&self, eye: DVec3, point: DVec3, path: &SpecularPath, bounce_points: &[DVec3]) -> bool {
        self.first_blocker(eye, point, &path.bounces, bounce_points).is_none()
    }

    /// The first object from the eye that blocks the path over the bounce points, one for each bounce, to `point`.
    pub fn first_blocker(&self, eye: DVec3, point: DVec3, bounces: &[Bounce], bounce_points: &[DVec3]) -> Option<u32> {
        let mut start = End { point: eye, free: true };
        for (index, (bounce, &at)) in bounces.iter().zip(bounce_points).enumerate() {
            let before = if index == 0 { eye } else { bounce_points[index - 1] };
            let after = bounce_points.get(index + 1).copied().filter(|_| index + 1 < bounces.len());
            let [back, on] = [before, after.unwrap_or(point)].map(|end| (end - at).normalize_or_zero());
            let normal = self.normal(*bounce, at, back, on);
            let above = |direction: DVec3| {
                let size = (at.abs().max_element()).max(before.abs().max_element());
                at + normal * (CLEARANCE * size).copysign(normal.dot(direction))
            };
            let blocker = self.blocker_between(start, End { point: above(back), free: false });
            if blocker.is_some() {
                return blocker;
            }
            start = End { point: above(on), free: false };
        }
        self.blocker_between(start, End { point, free: true })
    }

    /// A unit vector across the surface at a bounce, on either side.
    fn normal(&self, bounce: Bounce, at: DVec3, back: DVec3, on: DVec3) -> DVec3 {
        if bounce.kind == BounceKind::Reflect
            && let Some(half) = (back + on).try_normalize()
        {
            return half;
        }
        let analytic = self.scene.objects[bounce.object as usize].surface.as_ref();
        let of_formula = analytic.and_then(|surface| surface.taylor2(at).normal());
        // On meshes this is the normal of the triangle that the arriving segment meets there, else the direction along
        // the segments.
        of_formula
            .or_else(|| self.normal_of_triangle(bounce.object, at, back))
            .or_else(|| (back - on).try_normalize())
            .unwrap_or(DVec3::ZERO)
    }

    /// The flat normal of the object's triangle at a point, which is met from the direction `back`.
    fn normal_of_triangle(&self, object: u32, at: DVec3, back: DVec3) -> Option<DVec3> {
        let length = at.abs().max_element().max(self.scene.objects[object as usize].bounds.diagonal() as f64) * 1e-3;
        let ray = Ray { origin: (at + back * length).as_vec3(), direction: (-back).as_vec3() };
        let mut best: Option<(f32, DVec3)> = None;
        let mut near = 0.0;
        for _ in 0..MAX_TOUCHES {
            let Some(hit) = self.tracer.first_hit(self.scene, &ray, near) else { break };
            let miss = (hit.distance() - length as f32).abs();
            if best.is_some_and(|(least, _)| miss > least) || hit.distance() > 2.0 * length as f32 {
                break;
            }
            let point = self.tracer.encounter(self.scene, &ray, &hit, None).point;
            if point.object == object {
                best = Some((miss, point.geometric_normal.as_dvec3()));
            }
            near = beyond(&hit, 0.0);
        }
        best.map(|(_, normal)| normal)
    }

    /// The first object that blocks a segment.
    fn blocker_between(&self, start: End, end: End) -> Option<u32> {
        let between = end.point - start.point;
        let length = between.length();
        let direction = between.try_normalize()?;
        let ray = Ray { origin: start.point.as_vec3(), direction: direction.as_vec3() };
        let size = start.point.abs().max_element().max(end.point.abs().max_element());
        let clearance = CLEARANCE * size;
        let mut near = 0.0;
        for _ in 0..MAX_TOUCHES {
            let hit = self.tracer.first_hit(self.scene, &ray, near)?;
            if f64::from(hit.distance()) >= length {
                return None;
            }
            let at = self.tracer.encounter(self.scene, &ray, &hit, None).point;
            let (object, normal, at) = (at.object, at.geometric_normal.as_dvec3(), at.position.as_dvec3());
            let touches = |end: &End| end.free && normal.dot(end.point - at).abs() <= clearance;
            if !(touches(&start) || touches(&end)) {
                return Some(object);
            }
            near = beyond(&hit, clearance as f32);
        }
        None
    }
}

/// A distance just behind a hit.
fn beyond(hit: &Hit, clearance: f32) -> f32 {
    hit.distance() * (1.0 + 4.0 * f32::EPSILON) + clearance.max(f32::MIN_POSITIVE)
}
