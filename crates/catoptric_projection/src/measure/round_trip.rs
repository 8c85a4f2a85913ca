//! The projection error of a method, by round trip.
//!
//! A view ray is followed through its specular events to the scene point that it shows; the method is asked where
//! that point appears on the same path. It should be where the ray came from. No root is sought on the way to the
//! point, so the measure shares no fault with the methods.

use crate::find::projected_paths::PathFollower;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::shade::SurfacePoint;
use catoptric_core::scene::{Material, Ray, Role, Scene, View};
use catoptric_engine::light::path_tracer::{MIN_THROUGHPUT, NearPlane};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::{
    MAX_BOUNCES, PathBeginnings, Projection, Projections, SpecularPath, VertexProjector,
};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::step::LightStep;
use glam::{Vec2, Vec3};
use serde::Serialize;
use std::collections::{HashMap, HashSet};

/// View rays that are sent on a round trip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoundTripOptions {
    /// The maximum number of bounces on a path; beyond [`MAX_BOUNCES`] none are measured.
    pub order: u32,
    /// The interval of the pixels and rows that are measured; 1: all.
    pub every: u32,
}

/// Distances between where view rays came from and where the method projects their scene points, in pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RoundTrip {
    /// Errors of all orders together.
    #[serde(flatten)]
    pub all: RoundTripError,
    /// Errors of the paths with one bounce, with two, and so on.
    pub orders: Vec<RoundTripError>,
}

/// The errors of some round trips. Percentiles are over those that were answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RoundTripError {
    /// The median, in pixels; `None` if nothing was answered.
    pub p50: Option<f64>,
    /// The 95th percentile, in pixels.
    pub p95: Option<f64>,
    /// The 99th percentile, in pixels.
    pub p99: Option<f64>,
    /// The largest, in pixels.
    pub max: Option<f64>,
    /// The share without an answer on the right path; 0 where there was nothing to ask.
    pub missing: f64,
    /// Number of points asked for.
    pub count: u64,
    /// The share of answers where the point does not appear: the ray through them, followed over the objects of its
    /// path, misses these or the point by more than 10 pixels, to first order.
    pub invented: f64,
    /// The share of answers that are within a pixel of one before, for the same point on the same path.
    pub doubled: f64,
    /// Number of answers in the picture, on the first reflector of their path.
    pub answers: u64,
}

/// An answer further off than this is none. Chosen well above the errors of answers that are meant, not measured.
const INVENTED_PX: f64 = 10.0;

/// Answers nearer to each other than this are one. Chosen, not measured.
const DOUBLED_PX: f32 = 1.0;

/// The answers to the queries of some pixels, for paths of one order.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// Distances in pixels, infinite where nothing was answered.
    pub errors: Vec<f32>,
    /// Answers within the picture from which a path begins.
    pub count: u64,
    /// Answers from which no path leads to the point.
    pub invented: u64,
    /// Answers that were given before.
    pub doubled: u64,
}

impl Answers {
    fn add(&mut self, other: &Self) {
        self.errors.extend_from_slice(&other.errors);
        self.count += other.count;
        self.invented += other.invented;
        self.doubled += other.doubled;
    }
}

impl RoundTripError {
    /// Summarises answers; distances that are not finite are of points without one.
    pub fn of(answers: Answers) -> Self {
        let Answers { mut errors, count: answer_count, invented, doubled } = answers;
        let count = errors.len();
        errors.retain(|error| error.is_finite());
        errors.sort_by(f32::total_cmp);
        // The smallest value that at least this share of the values does not exceed.
        let percentile = |share: f64| {
            let rank = (share * errors.len() as f64).ceil() as usize;
            errors.get(rank.max(1) - 1).map(|error| f64::from(*error))
        };
        Self {
            p50: percentile(0.5),
            p95: percentile(0.95),
            p99: percentile(0.99),
            max: percentile(1.0),
            missing: (count - errors.len()) as f64 / count.max(1) as f64,
            count: count as u64,
            invented: invented as f64 / answer_count.max(1) as f64,
            doubled: doubled as f64 / answer_count.max(1) as f64,
            answers: answer_count,
        }
    }
}

/// Measures a projector for this scene and view, on all paths.
///
/// # Errors
/// [`Cancelled`].
pub fn round_trip(
    scene: &Scene,
    view: &View,
    projector: &dyn VertexProjector,
    options: RoundTripOptions,
    progress: &dyn Progress,
) -> Result<RoundTrip, Cancelled> {
    round_trip_without(scene, view, (projector, &PathBeginnings::default()), options, progress)
}

/// Measures a projector for this scene and view, but for paths that are left to something else.
///
/// Rays through pixel centres split at lenses and are followed as the reference follows them, with all branches that
/// carry light; each end on a diffuse surface (a coated one included) after at least one bounce is a round trip. The
/// scene points are those of the single-precision ray tracer: errors of its rounding, about 1e-3 pixels, are
/// included. Results do not depend on the number of threads.
///
/// # Errors
/// [`Cancelled`].
pub fn round_trip_without(
    scene: &Scene,
    view: &View,
    (projector, left): (&dyn VertexProjector, &PathBeginnings),
    options: RoundTripOptions,
    progress: &dyn Progress,
) -> Result<RoundTrip, Cancelled> {
    let tracer = Tracer::build(scene, |_| true);
    let tree = ViewRayTree::new(projector.paths(), left);
    let every = options.every.max(1);
    // The middle pixel of every square of pixels.
    let places = |length: u32| (every.min(length) / 2..length).step_by(every as usize);
    let (columns, rows): (Vec<u32>, Vec<u32>) = (places(view.width).collect(), places(view.height).collect());
    let follower = PathFollower::new(scene, view, projector.paths().iter());
    let (rays, near) = (view.rays(), NearPlane::new(view));
    let init = || Walk {
        scene,
        tracer: &tracer,
        tree: &tree,
        projector,
        follower: &follower,
        size_px: Vec2::new(view.width as f32, view.height as f32),
        max_order: options.order.min(MAX_BOUNCES as u32),
        waiting: Vec::new(),
        found: Projections::default(),
        answers: Default::default(),
    };
    let rows = parallel::map_init_stage(progress, "round trip", rows.len(), init, |walk, row| {
        for &column in &columns {
            let pixel = Vec2::new(column as f32 + 0.5, rows[row] as f32 + 0.5);
            let ray = rays.ray(pixel.x, pixel.y);
            walk.follow(ray, near.distance(&ray), pixel);
        }
        std::mem::take(&mut walk.answers)
    })?;
    let (mut all, mut orders) =
        (Answers::default(), vec![Answers::default(); options.order.min(MAX_BOUNCES as u32) as usize]);
    for (index, order) in orders.iter_mut().enumerate() {
        rows.iter().for_each(|row| order.add(&row[index]));
        all.add(order);
    }
    Ok(RoundTrip { all: RoundTripError::of(all), orders: orders.into_iter().map(RoundTripError::of).collect() })
}

/// The projector's paths by their bounces.
struct ViewRayTree {
    /// The path that ends at each node; the root is the view itself.
    paths: Vec<Option<u32>>,
    children: HashMap<(u32, Bounce), u32>,
    /// Nodes of paths from which on all are left to something else.
    left: HashSet<u32>,
}

impl ViewRayTree {
    fn new(paths: &[SpecularPath], left: &PathBeginnings) -> Self {
        let mut tree = Self { paths: vec![None], children: HashMap::new(), left: HashSet::new() };
        for (index, path) in paths.iter().enumerate() {
            let node = tree.node(&path.bounces);
            tree.paths[node as usize] = Some(index as u32);
        }
        for (before, object) in left.iter() {
            for kind in [BounceKind::Reflect, BounceKind::Transmit] {
                let bounces: Vec<Bounce> = before.iter().copied().chain([Bounce { object: *object, kind }]).collect();
                let node = tree.node(&bounces);
                tree.left.insert(node);
            }
        }
        tree
    }

    /// The node of a path, made where there is none.
    fn node(&mut self, bounces: &[Bounce]) -> u32 {
        let Self { paths, children, .. } = self;
        bounces.iter().fold(0, |node, bounce| {
            *children.entry((node, *bounce)).or_insert_with(|| {
                paths.push(None);
                paths.len() as u32 - 1
            })
        })
    }

    /// The node of a path that goes on; returns `None` if there is no such path.
    fn child(&self, node: Option<u32>, bounce: Bounce) -> Option<u32> {
        self.children.get(&(node?, bounce)).copied()
    }
}

/// A ray that waits to be traced.
#[derive(Clone, Copy)]
struct TripSegment {
    ray: Ray,
    near: f32,
    throughput: Vec3,
    order: u32,
    node: Option<u32>,
}

/// Follows view rays; one a thread.
struct Walk<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer,
    tree: &'a ViewRayTree,
    projector: &'a dyn VertexProjector,
    max_order: u32,
    waiting: Vec<TripSegment>,
    found: Projections,
    follower: &'a PathFollower<'a>,
    size_px: Vec2,
    /// The answers for paths of each order.
    answers: [Answers; MAX_BOUNCES],
}

impl Walk<'_> {
    fn follow(&mut self, ray: Ray, near: f32, pixel: Vec2) {
        self.waiting.push(TripSegment { ray, near, throughput: Vec3::ONE, order: 0, node: Some(0) });
        while let Some(segment) = self.waiting.pop() {
            let Some(hit) = self.tracer.first_hit(self.scene, &segment.ray, segment.near) else { continue };
            let point = self.tracer.encounter(self.scene, &segment.ray, &hit, None).point;
            let material = self.scene.material_of(point.object);
            if segment.order > 0 && matches!(material.role, Role::Diffuse | Role::Coated) {
                self.ask(&segment, point.position, pixel);
            }
            if material.role.is_specular() && segment.order < self.max_order {
                self.scatter(&segment, &point, material);
            }
        }
    }

    fn ask(&mut self, segment: &TripSegment, point: Vec3, pixel: Vec2) {
        self.found.clear();
        if let Some(path) = segment.node.and_then(|node| self.tree.paths[node as usize]) {
            self.projector.project_on(path, &[point], &mut self.found);
        }
        let found = self.found.all();
        let distances = found.iter().map(|projection| projection.image_px.distance(pixel));
        let nearest = distances.filter(|distance| distance.is_finite()).fold(f32::INFINITY, f32::min);
        let answers = &mut self.answers[segment.order as usize - 1];
        answers.errors.push(nearest);
        for (index, one) in found.iter().enumerate() {
            let bounces = &self.projector.paths()[one.path as usize].bounces;
            let is_inside = one.image_px.clamp(Vec2::ZERO, self.size_px) == one.image_px;
            if !is_inside || !self.follower.begins(bounces, one) {
                continue;
            }
            answers.count += 1;
            if !is_of_point(self.follower, bounces, one, point) {
                answers.invented += 1;
            } else if found[..index].iter().any(|before| before.image_px.distance(one.image_px) < DOUBLED_PX) {
                answers.doubled += 1;
            }
        }
    }

    /// Paths that go on at a reflector or lens.
    fn scatter(&mut self, segment: &TripSegment, point: &SurfacePoint, material: &Material) {
        let incoming = segment.ray.direction;
        let step = LightStep::at(self.scene, material, point, incoming);
        for kind in [BounceKind::Transmit, BounceKind::Reflect] {
            let throughput = segment.throughput * step.weight(kind);
            if throughput.max_element() >= MIN_THROUGHPUT
                && let Some(direction) = step.outgoing(kind, incoming)
            {
                let ray = Ray { origin: self.tracer.departure(point, direction), direction };
                let node = self.tree.child(segment.node, Bounce { object: point.object, kind });
                if node.is_some_and(|node| self.tree.left.contains(&node)) {
                    continue;
                }
                self.waiting.push(TripSegment { ray, near: 0.0, throughput, order: segment.order + 1, node });
            }
        }
    }
}

/// True if the ray through an answer leads to the point, or near it.
fn is_of_point(follower: &PathFollower<'_>, bounces: &[Bounce], one: &Projection, point: Vec3) -> bool {
    let Some(path) = follower.completed(bounces, one, point.as_dvec3()) else { return false };
    // The residual is about the angle by which the last ray misses the point.
    let miss = path.residual * path.bounce_points[bounces.len() - 1].distance(point.as_dvec3());
    let pixels = one.image_change[0].length().hypotenuse(one.image_change[1].length());
    miss * f64::from(pixels) <= INVENTED_PX
}
