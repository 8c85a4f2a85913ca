//! Paths from the answers of a [`VertexProjector`]: the approximate kind of [`PathSearch`].

use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Ray, Role, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::path_query::{FoundPath, PathSearch, SearchOutcome};
use catoptric_engine::method::projector::{MAX_BOUNCES, Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::method::{Frame, Job};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::step::{Facing, crossed_medium, medium_after, relative_index};
use glam::{DMat3, DVec3, Vec3};
use std::collections::HashMap;

/// The maximum number of times that a ray may meet an object on its way to the reflection point that is looked for. A
/// bound on time; chosen, not measured.
const MAX_LAYERS: usize = 8;

/// The appearances that a method finds, completed to paths: the view ray through each is followed over the objects of
/// its path, whatever else stands in the way.
///
/// Bounce points are those of that ray, so they are off by the method's error, and so is its end: the residual gives
/// by how much the last bounce misses the scene point. Appearances whose ray does not meet the objects of its path
/// are left out. Single precision: about 1e-6 of the scene's coordinates.
pub struct ProjectedPaths<'a> {
    projector: Box<dyn VertexProjector + 'a>,
    /// Indices of the projector's paths that are wanted.
    wanted: Vec<u32>,
    follower: PathFollower<'a>,
}

/// Follows view rays over the objects of paths, whatever else stands in the way.
pub(crate) struct PathFollower<'a> {
    scene: &'a Scene,
    view: &'a View,
    /// A tracer of each object on the paths alone.
    tracers: HashMap<u32, Tracer>,
}

/// The paths of one to `order` bounces on some objects that a frame finds from an eye (that of the view, perhaps with
/// more digits): by the method's own search, else its projector's appearances completed to paths. `None` for methods
/// that do not project points.
///
/// # Errors
/// As [`Frame::path_search`].
pub fn path_search<'a>(
    frame: &'a dyn Frame,
    job: &Job<'a>,
    eye: DVec3,
    objects: &[u32],
) -> Result<Option<Box<dyn PathSearch + 'a>>, RenderError> {
    if let Some(own) = frame.path_search(eye, objects)? {
        return Ok(Some(own));
    }
    let complete = |projector| -> Box<dyn PathSearch + 'a> {
        Box::new(ProjectedPaths::new(job.scene, job.view, projector, job.quality.order, objects))
    };
    Ok(frame.projector().map(complete))
}

/// One bounce of a ray that is followed.
#[derive(Clone, Copy, Default)]
struct FollowedBounce {
    /// The unit shading normal, on the side that is met.
    normal: Vec3,
    /// Indices of refraction before and after the bounce.
    media: [f32; 2],
    outgoing: Vec3,
}

impl<'a> ProjectedPaths<'a> {
    /// The paths of a projector with at most `order` bounces, all of them on the given objects.
    pub fn new(
        scene: &'a Scene,
        view: &'a View,
        projector: Box<dyn VertexProjector + 'a>,
        order: u32,
        objects: &[u32],
    ) -> Self {
        let is_wanted = |path: &SpecularPath| {
            (1..=order.min(MAX_BOUNCES as u32) as usize).contains(&path.bounces.len())
                && path.bounces.iter().all(|bounce| objects.contains(&bounce.object))
        };
        let paths = projector.paths().iter().enumerate();
        let wanted: Vec<u32> = paths.filter(|(_, path)| is_wanted(path)).map(|(index, _)| index as u32).collect();
        let follower = PathFollower::new(scene, view, wanted.iter().map(|path| &projector.paths()[*path as usize]));
        Self { projector, wanted, follower }
    }
}

impl<'a> PathFollower<'a> {
    pub(crate) fn new<'b>(scene: &'a Scene, view: &'a View, paths: impl Iterator<Item = &'b SpecularPath>) -> Self {
        let mut tracers = HashMap::new();
        for bounce in paths.flat_map(|path| &path.bounces) {
            let build = || Tracer::build(scene, |object| object == bounce.object);
            tracers.entry(bounce.object).or_insert_with(build);
        }
        Self { scene, view, tracers }
    }

    /// The point of an object along a ray: the first, or the one nearest to a distance.
    fn point_along(&self, object: u32, ray: &Ray, distance: Option<f32>) -> Option<(f32, SurfacePoint)> {
        let tracer = self.tracers.get(&object)?;
        let mut hit = tracer.first_hit(self.scene, ray, 0.0)?;
        if let Some(distance) = distance {
            for _ in 0..MAX_LAYERS {
                let next = hit.distance() * (1.0 + 1e-4) + f32::MIN_POSITIVE;
                let Some(farther) = tracer.first_hit(self.scene, ray, next) else { break };
                if (farther.distance() - distance).abs() > (hit.distance() - distance).abs() {
                    break;
                }
                hit = farther;
            }
        }
        Some((hit.distance(), tracer.encounter(self.scene, ray, &hit, None).point))
    }

    /// A bounce of a ray that was taken to run through a medium of this index of refraction.
    fn step(&self, kind: BounceKind, point: &SurfacePoint, incoming: Vec3, medium: f32) -> Option<FollowedBounce> {
        let material = self.scene.material_of(point.object);
        let facing = Facing::new(incoming, point.geometric_normal, point.normal);
        let crossed = crossed_medium(material.role == Role::Lens, facing.outside, material.ior, medium);
        let media = [crossed, medium_after(kind, facing.outside, material.ior, crossed, 1.0)];
        let outgoing = facing.outgoing(kind, incoming, relative_index(material.ior, facing.outside))?;
        Some(FollowedBounce { normal: facing.normal, media, outgoing })
    }

    /// True if the view ray through an appearance meets the first object of its path: drawing cuts all others.
    pub(crate) fn begins(&self, bounces: &[Bounce], projection: &Projection) -> bool {
        let (ray, _) = self.view.ray_with_differential(projection.image_px.x, projection.image_px.y);
        bounces.first().is_some_and(|bounce| self.point_along(bounce.object, &ray, None).is_some())
    }

    /// The path of the view ray through an appearance of a point, whose bounces these are; the residual gives by how
    /// much it misses the point. Returns `None` if the ray does not meet the objects of the path.
    pub(crate) fn completed(&self, bounces: &[Bounce], projection: &Projection, point: DVec3) -> Option<FoundPath> {
        let (mut ray, change) = self.view.ray_with_differential(projection.image_px.x, projection.image_px.y);
        let mut distance = Some((projection.reflection_point - ray.origin).dot(ray.direction));
        let mut steps = [FollowedBounce::default(); MAX_BOUNCES];
        // The eye, the bounces, the scene point.
        let mut corners = [point; MAX_BOUNCES + 2];
        corners[0] = ray.origin.as_dvec3();
        let mut jacobian = DMat3::ZERO;
        for (index, bounce) in bounces.iter().enumerate() {
            let (along, at) = self.point_along(bounce.object, &ray, distance.take())?;
            let medium = index.checked_sub(1).map_or(1.0, |before| steps[before].media[1]);
            let step = self.step(bounce.kind, &at, ray.direction, medium)?;
            if index == 0 {
                let moved = change.transferred(&ray, along, at.geometric_normal);
                for (moved, by) in moved.iter().zip(&projection.image_change) {
                    let (moved, by) = (moved.as_dvec3(), by.as_dvec3());
                    jacobian += DMat3::from_cols(moved * by.x, moved * by.y, moved * by.z);
                }
            }
            corners[index + 1] = at.position.as_dvec3();
            let origin = self.tracers.get(&bounce.object)?.departure(&at, step.outgoing);
            ray = Ray { origin, direction: step.outgoing };
            steps[index] = step;
        }
        let mut found = FoundPath {
            path: projection.path,
            bounce_count: bounces.len(),
            focal_index: projection.focal_index,
            jacobian,
            ..FoundPath::default()
        };
        for (index, step) in steps[..bounces.len()].iter().enumerate() {
            let [before, at, after] = [0, 1, 2].map(|next: usize| corners[index + next]);
            found.bounce_points[index] = at;
            found.optical_length += at.distance(before) * f64::from(step.media[0]);
            found.residual = found.residual.max(residual(step, before - at, after - at));
        }
        let last = steps[bounces.len() - 1];
        found.optical_length += point.distance(corners[bounces.len()]) * f64::from(last.media[1]);
        let finite = found.optical_length.is_finite() && found.residual.is_finite() && jacobian.is_finite();
        finite.then_some(found)
    }
}

/// The norm of the specular constraint at a bounce, from the steps to the path's points before and after it.
fn residual(step: &FollowedBounce, back: DVec3, on: DVec3) -> f64 {
    let normal = step.normal.as_dvec3().normalize_or_zero();
    let sum = back.normalize_or_zero() * f64::from(step.media[0]) + on.normalize_or_zero() * f64::from(step.media[1]);
    (sum - normal * sum.dot(normal)).length()
}

impl PathSearch for ProjectedPaths<'_> {
    fn paths(&self) -> &[SpecularPath] {
        self.projector.paths()
    }

    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome {
        let start = found.len();
        if point.as_vec3().is_finite() {
            let mut projections = Projections::default();
            for &path in &self.wanted {
                self.projector.project_on(path, &[point.as_vec3()], &mut projections);
            }
            let completed = |projection: &Projection| {
                let bounces = &self.projector.paths()[projection.path as usize].bounces;
                self.follower.completed(bounces, projection, point)
            };
            found.extend(projections.all().iter().filter_map(completed));
        }
        let own = &mut found[start..];
        own.sort_by(|a, b| a.optical_length.total_cmp(&b.optical_length).then(a.path.cmp(&b.path)));
        SearchOutcome { found: own.len(), ..SearchOutcome::default() }
    }
}
