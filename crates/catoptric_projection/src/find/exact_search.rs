//! All specular paths between an eye and scene points, found from ray maps around the eye and solved exactly.
//!
//! Every reflector is sampled from the eye by its own ray map, refined until neighbouring rays predict each other; a
//! point's candidates are all rays whose expansions reach it, and Newton's method on the specular constraint takes one
//! for each place in the picture to its path; near caustics, where one ray can stand for several paths, its neighbours
//! are tried too. A search costs some five to fifty microseconds on convex surfaces, one or two hundred on meshes, tori
//! and vases, and a few milliseconds on surfaces of expressions. Where a surface is not convex a point has a hundred
//! candidates and more that lead to a handful of appearances: up to 64 places in the picture are tried, and beyond that
//! the search says that it was cut short. It can also miss reflections in parts of a reflector smaller than the finest
//! sample spacing (see [`SearchSettings`]), and one of two that nearly coincide beside a caustic, from where Newton's
//! method goes to the other.
//!
//! Ray maps hold what is seen from the eye. Where blocked paths are wanted too, those of one bounce on analytic
//! surfaces are found by subdivision ([`RootFinder`]): all of them, at some hundred times the cost. On meshes, and
//! with more bounces, blocked paths are found only where the first bounce is met by a ray from the eye and each
//! further one by the ray of the bounce before.

use super::path_visibility::PathVisibility;
use super::ray_map::{
    Approximation, CandidateFilter, CandidateRule, CandidateScratch, PathRays, RayMap, Sampling, Specular, ViewField,
};
use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Camera, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::path_query::{FoundPath, PathSearch, SearchOutcome};
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::optics::path::all_roots::{RootCount, RootFinder};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye, OutgoingRays, RayBundle};
use catoptric_engine::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric_engine::optics::path::specular_solver::{PathSites, Solution, first_order_bundle_of, solve};
use catoptric_engine::optics::step::{crossed_medium, medium_after};
use glam::{DMat3, DVec2, DVec3, Vec3};
use std::collections::HashSet;

/// Sampling of reflectors by a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Sample rays across a reflector, in each direction, before refinement.
    pub samples_across: u32,
    /// Number of times cells are divided in four where neighbouring rays disagree.
    pub refinements: u32,
    /// Paths that a reflector or lens blocks are left out. Otherwise all paths of one bounce on analytic surfaces are
    /// found, and of the others those that start with rays that reach the eye unoccluded.
    pub visible_only: bool,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self { samples_across: 32, refinements: 5, visible_only: true }
    }
}

/// Newton steps at the most. A bound on time; chosen, not measured.
const MAX_STEPS: u32 = 60;
/// Paths with smaller residuals of the specular constraint are solutions. Chosen, not measured.
const SOLVED_RESIDUAL: f64 = 1e-12;
/// Like [`SOLVED_RESIDUAL`], along a curve of paths, all of which are double roots. Chosen, not measured.
const CURVE_RESIDUAL: f64 = 1e-11;
/// Bounce points nearer than this share of the scene's size are the same. Chosen, not measured.
const SAME_POINT: f64 = 1e-7;
/// Like [`SAME_POINT`], at caustics, where roots are double, and known to the square root of the residual only. Chosen,
/// not measured.
const SAME_DOUBLE_POINT: f64 = 1e-5;
/// Paths whose determinant over the squared size of their spread is below this are at a caustic. Chosen, not measured.
const NEARLY_SINGULAR: f64 = 1e-4;
/// Steps along a supposed curve of paths, in sizes of the scene, and how many make a curve.
const CURVE_STEP: f64 = 1e-3;
const CURVE_STEPS: u32 = 4;
/// Newton steps from a neighbour of a candidate at the most. A bound on time; chosen, not measured.
const MAX_NEIGHBOUR_STEPS: u32 = 24;
/// A sample whose prediction's second order is above this share of the way to its neighbours is near a caustic. Chosen,
/// not measured.
const LARGE_REMAINDER: f64 = 0.25;
/// Samples reach at most this many distances to their neighbours. Chosen, not measured.
const LARGEST_REACH: f32 = 4.0;
/// Candidates of points farther away than this are those of a point there: it fits into single precision.
const FARTHEST_LOOKUP: f64 = 1e17;
/// Places in the picture that a point may be led to on a path. On surfaces that are not convex most candidates lead to
/// other appearances or to none: with 16 places 15 of 3,081 appearances in the blob and the gyroid of the round trips
/// were not found, with 64 all were.
const MAX_PLACES: usize = 64;
/// Charts have this many pixels between two sample rays: a unit for the accuracy of their predictions. Chosen, not
/// measured.
const SPACING_PX: f32 = 16.0;
/// Cells of a chart at the most. A bound on memory; chosen, not measured.
const MAX_CELLS: usize = 200_000;

/// The ray map of one reflector in one view.
struct ObjectMap {
    map: RayMap,
    /// The number of the path of every group of the map; `None` if the path is not wanted.
    path_of_group: Vec<Option<u32>>,
    /// True for groups in which a point has at most one path: reflections on the outside of a convex body.
    single: Vec<bool>,
}

/// The search for all paths of one bounce on an analytic surface, visible or not.
struct HiddenSearch {
    finder: RootFinder,
    bounce: Bounce,
    path: u32,
}

/// State of the search of a point.
struct SearchState<'f> {
    found: &'f mut Vec<FoundPath>,
    /// Index of the point's first path.
    start: usize,
    /// Paths of which there are infinitely many.
    infinite: Vec<u32>,
    /// True if a limit has been reached.
    cut_short: bool,
}

/// A search in one scene from one eye.
pub struct ExactSearch<'a> {
    scene: &'a Scene,
    surfaces: SpecularSurfaces<'a>,
    visibility: Option<PathVisibility<'a>>,
    eye: Eye,
    paths: Vec<SpecularPath>,
    charts: Vec<ObjectMap>,
    hidden: Vec<HiddenSearch>,
    /// The size of the scene.
    size: f64,
    /// Bounce points nearer than this are the same.
    same_point: f64,
    /// Points nearer to their last bounce than this lie on it.
    touching: f64,
}

/// Refuses orders, eyes and objects that no search can be made for.
fn refuse_unsearchable(scene: &Scene, eye: DVec3, order: u32, objects: &[u32]) -> Result<(), RenderError> {
    let limit = |problem: String| RenderError::Limit { method: "exact", problem };
    if order as usize > MAX_BOUNCES {
        return Err(limit(format!("paths of {order} bounces; at most {MAX_BOUNCES} can be searched")));
    }
    if !eye.as_vec3().is_finite() {
        return Err(limit(format!("the eye {eye} is not finite")));
    }
    let is_refused = |object: &&u32| **object as usize >= scene.objects.len() || !scene.role_of(**object).is_specular();
    match objects.iter().find(is_refused) {
        Some(object) => Err(limit(format!("object {object} is neither a reflector nor a lens"))),
        None => Ok(()),
    }
}

/// Searches for all paths of one bounce at objects with a formula; appends these paths.
fn hidden_searches(
    scene: &Scene,
    surfaces: &SpecularSurfaces<'_>,
    objects: &[u32],
    paths: &mut Vec<SpecularPath>,
) -> Vec<HiddenSearch> {
    let mut hidden = Vec::new();
    for &object in objects {
        let Some(surface) = scene.objects[object as usize].surface.as_ref() else { continue };
        let finder = RootFinder::new(surface);
        let mut add = |kind| {
            let bounce = Bounce { object, kind };
            paths.push(SpecularPath { bounces: vec![bounce] });
            hidden.push(HiddenSearch { finder: finder.clone(), bounce, path: paths.len() as u32 - 1 });
        };
        add(BounceKind::Reflect);
        if surfaces.is_lens(object) {
            add(BounceKind::Transmit);
        }
    }
    hidden
}

impl<'a> ExactSearch<'a> {
    /// A search for paths of up to `order` bounces at `objects` (reflectors and lenses), from a finite eye.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when the order is above [`MAX_BOUNCES`], the eye is not finite, or an object is neither
    /// reflector nor lens; [`RenderError::Cancelled`].
    pub fn new(
        scene: &'a Scene,
        eye: DVec3,
        order: u32,
        objects: &[u32],
        settings: &SearchSettings,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        refuse_unsearchable(scene, eye, order, objects)?;
        let tracer = Tracer::build(scene, |object| scene.role_of(object).is_specular());
        let surfaces = SpecularSurfaces::new(scene);
        let specular = Specular { scene, tracer: &tracer, surfaces: &surfaces, order };
        let sampling = Sampling {
            spacing_px: SPACING_PX,
            finest_px: SPACING_PX / (1u32 << settings.refinements.min(10)) as f32,
            accuracy_px: 1.0,
            max_cells: MAX_CELLS,
        };
        let wanted: HashSet<u32> = objects.iter().copied().collect();
        let bounds = bounds_of_search(scene, eye.as_vec3());
        let mut charts = Vec::new();
        let mut paths: Vec<SpecularPath> = Vec::new();
        let mut hidden = Vec::new();
        if !settings.visible_only && order > 0 {
            hidden = hidden_searches(scene, &surfaces, objects, &mut paths);
        }
        let is_hidden = |path: &SpecularPath| match path.bounces.as_slice() {
            [bounce] => hidden.iter().any(|hidden| hidden.bounce == *bounce),
            _ => false,
        };
        for &object in objects {
            for view in views_of(&scene.objects[object as usize].bounds, eye.as_vec3(), settings.samples_across) {
                let field = ViewField::new(&view, SPACING_PX);
                let rule = CandidateRule::InReach(LARGEST_REACH);
                let map = RayMap::build(&specular, &field, &sampling, &bounds, rule, progress)?;
                let number = |group: &PathRays| {
                    let own = group.path.bounces.first().is_some_and(|bounce| bounce.object == object);
                    if !own
                        || is_hidden(&group.path)
                        || group.path.bounces.iter().any(|bounce| !wanted.contains(&bounce.object))
                    {
                        return None;
                    }
                    let known = paths.iter().position(|path| *path == group.path);
                    Some(known.unwrap_or_else(|| {
                        paths.push(group.path.clone());
                        paths.len() - 1
                    }) as u32)
                };
                let path_of_group = map.groups.iter().map(number).collect();
                let convex = scene.objects[object as usize].surface.as_ref().is_some_and(|s| s.is_convex());
                let is_single = |group: &PathRays| {
                    let one = group.path.bounces.len() == 1 && group.path.bounces[0].kind == BounceKind::Reflect;
                    convex && one && group.samples.iter().all(|sample| sample.outside[0])
                };
                let single = map.groups.iter().map(is_single).collect();
                charts.push(ObjectMap { map, path_of_group, single });
            }
        }
        let visibility = settings.visible_only.then(|| PathVisibility::new(scene, tracer));
        let size = f64::from(scene.bounds.diagonal());
        Ok(Self {
            scene,
            surfaces,
            visibility,
            eye: Eye::Point(eye),
            paths,
            charts,
            hidden,
            size,
            same_point: size * SAME_POINT,
            touching: size * SAME_POINT,
        })
    }

    /// Takes a candidate, and near caustics and borders its neighbours too, to their paths.
    fn follow_up(
        &self,
        group: &PathRays,
        ray: u32,
        single: bool,
        path: u32,
        point: DVec3,
        answer: &mut SearchState<'_>,
    ) -> bool {
        let sample = &group.samples[ray as usize];
        let reach = f64::from(group.reach[ray as usize]);
        let mut regular = false;
        // True if the point is reflected beyond the sample's neighbours, which are candidates of their own then.
        let mut beyond = false;
        let mut parameters = DVec2::ZERO;
        if let Some(neighbour) = sample.neighbour(point, Approximation::Quadratic) {
            parameters = neighbour.parameters.clamp_length_max(8.0 * reach);
            beyond = group.picture_distance(ray, neighbour.linear) > 1.0;
            regular = neighbour.linear.length() <= reach && neighbour.remainder.length() <= LARGE_REMAINDER * reach;
        }
        let attempt = |ray: u32, z: DVec2, max_steps: u32| {
            let start = group.samples[ray as usize].sites_at(&self.surfaces, z)?;
            let solution = solve(&self.surfaces, &self.eye, point, &start, max_steps, SOLVED_RESIDUAL)?;
            solution.converged.then_some(solution)
        };
        let best = attempt(ray, parameters, MAX_STEPS).or_else(|| attempt(ray, DVec2::ZERO, MAX_STEPS));
        let found = best.is_some();
        if let Some(solution) = best {
            self.take(path, &solution, point, answer);
        }
        if regular && found || single || beyond {
            return found;
        }
        for &neighbour in group.lines.neighbours(ray) {
            if let Some(solution) = attempt(neighbour, DVec2::ZERO, MAX_NEIGHBOUR_STEPS) {
                self.take(path, &solution, point, answer);
            }
        }
        found
    }

    /// Keeps a path if it is one and new.
    fn take(&self, path: u32, solution: &Solution, point: DVec3, answer: &mut SearchState<'_>) {
        let sites = &solution.sites;
        let first = sites.sites[0].position;
        let known = &answer.found[answer.start..];
        let nearest =
            known.iter().filter(|other| other.path == path).map(|other| other.bounce_points[0].distance(first));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        if nearest < self.same_point || answer.infinite.contains(&path) || !self.is_valid(sites, point) {
            return;
        }
        let Some((described, rays)) = self.describe(path, solution, point) else { return };
        let spread = rays.spread(rays.origin.distance(point));
        let size2 = spread.iter().flatten().map(|s| s * s).sum::<f64>();
        let determinant = spread[0][0] * spread[1][1] - spread[0][1] * spread[1][0];
        let is_singular = determinant.is_nan() || determinant.abs() <= NEARLY_SINGULAR * size2;
        if is_singular && nearest < self.size * SAME_DOUBLE_POINT || !self.is_visible(&described, point) {
            return;
        }
        if is_singular && self.is_one_of_infinitely_many(solution, point) {
            answer.infinite.push(path);
            return;
        }
        answer.found.push(described);
    }

    /// Takes all paths of one bounce on an analytic surface.
    fn search_hidden(&self, hidden: &HiddenSearch, point: DVec3, answer: &mut SearchState<'_>) {
        let mut roots = Vec::new();
        let index = self.surfaces.index_of(hidden.bounce.object);
        match hidden.finder.roots(&self.eye, point, hidden.bounce.kind, index, &mut roots) {
            RootCount::Finite => {}
            RootCount::Infinite => answer.infinite.push(hidden.path),
            RootCount::Unresolved => answer.cut_short = true,
        }
        for root in roots {
            let Some(start) = PathSites::new(&[(hidden.bounce, ManifoldVertex::on_surface(root))]) else { continue };
            match solve(&self.surfaces, &self.eye, point, &start, MAX_STEPS, SOLVED_RESIDUAL) {
                Some(solution) if solution.converged => self.take(hidden.path, &solution, point, answer),
                _ => {}
            }
        }
    }

    fn is_visible(&self, path: &FoundPath, point: DVec3) -> bool {
        let (Some(visibility), Eye::Point(eye)) = (&self.visibility, self.eye) else { return true };
        let sequence = &self.paths[path.path as usize];
        visibility.is_visible(eye, point, sequence, &path.bounce_points[..path.bounce_count])
    }

    fn is_valid(&self, sites: &PathSites, point: DVec3) -> bool {
        let within = |(bounce, site)| self.surfaces.is_within(bounce, site);
        let bounces = sites.bounces[..sites.count].iter().map(|bounce| bounce.object).zip(&sites.sites);
        let last = sites.sites[sites.count - 1].position;
        bounces.into_iter().all(within) && last.distance(point) > self.touching
    }

    fn describe(&self, path: u32, solution: &Solution, point: DVec3) -> Option<(FoundPath, OutgoingRays)> {
        let sites = &solution.sites;
        let (bundle, outside) = first_order_bundle_of(&self.surfaces, &self.eye, sites)?;
        let rays = OutgoingRays::new(&bundle)?;
        let distance = rays.origin.distance(point);
        let mut bounce_points = [DVec3::ZERO; MAX_BOUNCES];
        for (to, site) in bounce_points.iter_mut().zip(&sites.sites[..sites.count]) {
            *to = site.position;
        }
        let found = FoundPath {
            path,
            bounce_count: sites.count,
            bounce_points,
            focal_index: bundle.focal_points_passed + rays.focal_points_before(distance),
            optical_length: self.optical_length(sites, &outside, point),
            residual: solution.residual,
            jacobian: jacobian(&bundle, &rays, distance),
        };
        Some((found, rays))
    }

    /// True if a path at a focal point is one of infinitely many: other paths follow from it along the direction in
    /// which neighbouring rays meet.
    fn is_one_of_infinitely_many(&self, solution: &Solution, point: DVec3) -> bool {
        let object = solution.sites.bounces[0].object;
        let step = CURVE_STEP * self.size;
        let (mut at, mut before) = (solution.sites, DVec3::ZERO);
        for _ in 0..CURVE_STEPS {
            let Some((bundle, _)) = first_order_bundle_of(&self.surfaces, &self.eye, &at) else { return false };
            let Some(rays) = OutgoingRays::new(&bundle) else { return false };
            let [[a, b], [c, d]] = rays.spread(rays.origin.distance(point));
            // The direction that the singular matrix takes to zero: across its larger row.
            let blind = if a * a + b * b > c * c + d * d { DVec2::new(-b, a) } else { DVec2::new(-d, c) };
            // A matrix of zeros takes any direction to zero.
            let blind = blind.try_normalize().unwrap_or(DVec2::X);
            let way = bundle.first.first[0] * blind.x + bundle.first.first[1] * blind.y;
            let way = if way.dot(before) < 0.0 { -way } else { way };
            let Some(frame) = self.surfaces.frame(object, &at.sites[0]) else { return false };
            let along = DVec2::new(frame.tangents[0].dot(way), frame.tangents[1].dot(way)).normalize_or_zero() * step;
            let Some(expected) = self.surfaces.moved(object, &at.sites[0], along) else { return false };
            let mut start = at;
            start.sites[0] = expected;
            match solve(&self.surfaces, &self.eye, point, &start, MAX_STEPS, CURVE_RESIDUAL) {
                Some(next)
                    if next.converged && next.sites.sites[0].position.distance(expected.position) < 0.5 * step =>
                {
                    (at, before) = (next.sites, way);
                }
                _ => return false,
            }
        }
        true
    }

    fn optical_length(&self, sites: &PathSites, met_outside: &[bool; MAX_BOUNCES], point: DVec3) -> f64 {
        let Eye::Point(mut from) = self.eye else { return 0.0 };
        let mut medium = 1.0;
        let mut sum = 0.0;
        let bounces = sites.bounces[..sites.count].iter().zip(&sites.sites).zip(met_outside);
        for ((bounce, site), &outside) in bounces {
            let lens = self.surfaces.index_of(bounce.object);
            let crossed = crossed_medium(self.surfaces.is_lens(bounce.object), outside, lens, medium);
            sum += crossed * from.distance(site.position);
            medium = medium_after(bounce.kind, outside, lens, crossed, 1.0);
            from = site.position;
        }
        sum + medium * from.distance(point)
    }
}

/// d(first bounce point)/d(scene point).
fn jacobian(bundle: &RayBundle, rays: &OutgoingRays, distance: f64) -> DMat3 {
    let Some(focus) = rays.focus(distance) else { return DMat3::ZERO };
    // x = first[a] focus[a][i] (across[i] . dp), as columns over the components of dp.
    let change = [0, 1].map(|i: usize| bundle.first.first[0] * focus[0][i] + bundle.first.first[1] * focus[1][i]);
    let column = |k: usize| change[0] * rays.across[0][k] + change[1] * rays.across[1][k];
    DMat3::from_cols(column(0), column(1), column(2))
}

/// The box that octrees cover: the scene and the eye.
fn bounds_of_search(scene: &Scene, eye: Vec3) -> Aabb {
    let margin = Vec3::splat(scene.bounds.diagonal().max(1e-3) * 0.25);
    Aabb { min: scene.bounds.min.min(eye) - margin, max: scene.bounds.max.max(eye) + margin }
}

/// Views from the eye that together show all of a box: one, or six when the eye is too near.
fn views_of(bounds: &Aabb, eye: Vec3, samples_across: u32) -> Vec<View> {
    let (center, radius) = (bounds.center(), bounds.diagonal() * 0.5);
    let distance = center.distance(eye);
    let side = samples_across.max(1) * SPACING_PX as u32;
    let near = (radius * 1e-9).max(f32::MIN_POSITIVE);
    if distance > radius * 1.3 {
        let fov_deg = 2.0 * (radius / distance).arc_sine().to_degrees() * 1.01;
        return vec![View::new(&Camera::look_at("", eye, center, Vec3::Y, fov_deg), side, side, near)];
    }
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let face = |axis: Vec3| {
        View::new(&Camera::look_at("", eye, eye + axis, axis.any_orthogonal_vector(), 90.0), side, side, near)
    };
    axes.map(face).to_vec()
}

impl PathSearch for ExactSearch<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome {
        let start = found.len();
        if !point.is_finite() {
            return SearchOutcome::default();
        }
        let mut answer = SearchState { found, start, infinite: Vec::new(), cut_short: false };
        let lookup = point.clamp_length_max(FARTHEST_LOOKUP).as_vec3();
        for chart in &self.charts {
            answer.cut_short |= chart.map.left_coarse > 0;
            let groups = chart.map.groups.iter().zip(&chart.path_of_group).zip(&chart.single);
            for ((group, path), &single) in groups {
                let Some(path) = *path else { continue };
                let mut attempts = CandidateFilter::<MAX_PLACES>::default();
                group.candidates(lookup, &mut CandidateScratch::default(), |candidate| {
                    let Some(attempt) = attempts.begin(&candidate) else { return };
                    let resolved = self.follow_up(group, candidate.ray, single, path, point, &mut answer);
                    attempts.end(attempt, resolved);
                });
                answer.cut_short |= attempts.is_cut_short();
            }
        }
        for hidden in &self.hidden {
            self.search_hidden(hidden, point, &mut answer);
        }
        let SearchState { found, infinite, cut_short, .. } = answer;
        if !infinite.is_empty() {
            let mut kept = start;
            for index in start..found.len() {
                if !infinite.contains(&found[index].path) {
                    found.swap(kept, index);
                    kept += 1;
                }
            }
            found.truncate(kept);
        }
        found[start..].sort_by(|a, b| a.optical_length.total_cmp(&b.optical_length).then_with(|| a.path.cmp(&b.path)));
        SearchOutcome { found: found.len() - start, infinite: !infinite.is_empty(), cut_short }
    }
}

impl std::fmt::Debug for ExactSearch<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = &self.scene.name;
        formatter.debug_struct("ExactSearch").field("scene", name).field("paths", &self.paths.len()).finish()
    }
}
