//! All specular paths between an eye and scene points, found from ray maps around the eye and solved exactly.
//!
//! Every reflector is sampled from the eye by its own ray map, refined until neighbouring rays predict each other;
//! a point's candidates are all rays that pass it nearer than their neighbours do, and Newton's method on the
//! specular constraint takes each to its path. So a search costs a few microseconds, and what can be missed are
//! reflections in parts of a reflector smaller than the finest sample spacing (see [`SearchSettings`]).

use super::finder::{FoundPath, PathSearch, SearchOutcome};
use super::projector::{MAX_BOUNCES, SpecularPath};
use super::ray_map::{Approximation, CandidateRule, PathRays, RayMap, Sampling, Specular, ViewField};
use super::visibility::PathVisibility;
use crate::error::RenderError;
use crate::math::Aabb;
use crate::optics::bundle::{Eye, OutgoingRays, RayBundle};
use crate::optics::specular_solver::{PathSites, Solution, bundle_of, solve};
use crate::scene::{Camera, Scene, View};
use crate::surface::site::SpecularSurfaces;
use crate::surface::tracer::Tracer;
use glam::{DMat3, DVec2, DVec3, Vec3};
use std::collections::HashSet;

/// How a search samples reflectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Sample rays across a reflector, in each direction, before refinement.
    pub samples_across: u32,
    /// How many times cells are divided in four where neighbouring rays disagree.
    pub refinements: u32,
    /// Paths that a reflector or lens blocks are left out.
    pub visible_only: bool,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self { samples_across: 32, refinements: 5, visible_only: true }
    }
}

/// Newton steps at the most.
const MAX_STEPS: u32 = 60;
/// Paths with smaller residuals of the specular constraint are solutions.
const SOLVED_RESIDUAL: f64 = 1e-11;
/// Bounce points nearer than this share of the scene's size are the same.
const SAME_POINT: f64 = 1e-7;
/// Charts have this many pixels between two sample rays: a unit for the accuracy of their predictions.
const SPACING_PX: f32 = 16.0;
/// Cells of a chart at the most.
const MAX_CELLS: usize = 200_000;

/// One ray map: what is seen of one reflector in one view.
struct Chart {
    map: RayMap,
    /// For every group of the map, the number of its path; none where the path is not wanted.
    path_of_group: Vec<Option<u32>>,
}

/// A search in one scene from one eye.
pub struct ExactSearch<'a> {
    scene: &'a Scene,
    surfaces: SpecularSurfaces<'a>,
    visibility: Option<PathVisibility<'a>>,
    eye: Eye,
    paths: Vec<SpecularPath>,
    charts: Vec<Chart>,
    /// Bounce points nearer than this are the same.
    same_point: f64,
    /// Points nearer to their last bounce than this lie on it.
    touching: f64,
}

impl<'a> ExactSearch<'a> {
    /// A search for paths of up to `order` bounces at `objects` (reflectors and lenses), from a finite eye.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when the order is above [`MAX_BOUNCES`], the eye is not finite, or an object is neither
    /// reflector nor lens.
    pub fn new(
        scene: &'a Scene,
        eye: DVec3,
        order: u32,
        objects: &[u32],
        settings: &SearchSettings,
    ) -> Result<Self, RenderError> {
        let limit = |problem: String| RenderError::Limit { method: "exact", problem };
        if order as usize > MAX_BOUNCES {
            return Err(limit(format!("paths of {order} bounces; at most {MAX_BOUNCES} can be searched")));
        }
        if !eye.is_finite() {
            return Err(limit(format!("the eye {eye} is not finite")));
        }
        if let Some(object) =
            objects.iter().find(|&&o| o as usize >= scene.objects.len() || !scene.role_of(o).is_specular())
        {
            return Err(limit(format!("object {object} is neither a reflector nor a lens")));
        }
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
        for &object in objects {
            for view in views_of(&scene.objects[object as usize].bounds, eye.as_vec3(), settings.samples_across) {
                let field = ViewField::new(&view, SPACING_PX);
                let map = RayMap::build(&specular, &field, &sampling, &bounds, CandidateRule::LocalMinima);
                let number = |group: &PathRays| {
                    let own = group.path.bounces.first().is_some_and(|bounce| bounce.object == object);
                    if !own || group.path.bounces.iter().any(|bounce| !wanted.contains(&bounce.object)) {
                        return None;
                    }
                    let known = paths.iter().position(|path| *path == group.path);
                    Some(known.unwrap_or_else(|| {
                        paths.push(group.path.clone());
                        paths.len() - 1
                    }) as u32)
                };
                let path_of_group = map.groups.iter().map(number).collect();
                charts.push(Chart { map, path_of_group });
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
            same_point: size * SAME_POINT,
            touching: size * SAME_POINT,
        })
    }

    /// The path that a sample ray leads to, where there is one.
    fn solve_from(&self, group: &PathRays, ray: u32, point: DVec3) -> Option<Solution> {
        let sample = &group.samples[ray as usize];
        let reach = 8.0 * f64::from(group.reach[ray as usize]);
        let parameters = match sample.neighbour(point, Approximation::Quadratic) {
            Some(neighbour) => neighbour.parameters.clamp_length_max(reach),
            None => DVec2::ZERO,
        };
        let attempt = |z: DVec2| {
            let start = sample.sites_at(&self.surfaces, z)?;
            let solution = solve(&self.surfaces, &self.eye, point, &start, MAX_STEPS, SOLVED_RESIDUAL)?;
            solution.converged.then_some(solution)
        };
        attempt(parameters).or_else(|| attempt(DVec2::ZERO))
    }

    fn is_valid(&self, path: &SpecularPath, sites: &PathSites, point: DVec3) -> bool {
        let within = |(bounce, site)| self.surfaces.is_within(bounce, site);
        let bounces = path.bounces.iter().map(|bounce| bounce.object).zip(&sites.sites);
        let last = sites.sites[sites.count - 1].position;
        bounces.into_iter().all(within) && last.distance(point) > self.touching
    }

    fn describe(&self, path: u32, solution: &Solution, point: DVec3) -> Option<(FoundPath, bool)> {
        let sites = &solution.sites;
        let bundle = bundle_of(&self.surfaces, &self.eye, sites)?;
        let rays = OutgoingRays::new(&bundle)?;
        let distance = rays.origin.distance(point);
        let mut bounce_points = [DVec3::ZERO; MAX_BOUNCES];
        for (to, site) in bounce_points.iter_mut().zip(&sites.sites[..sites.count]) {
            *to = site.position;
        }
        let spread = rays.spread(distance);
        let size2 = spread.iter().flatten().map(|s| s * s).sum::<f64>();
        let determinant = spread[0][0] * spread[1][1] - spread[0][1] * spread[1][0];
        let singular = determinant.is_nan() || determinant.abs() <= 1e-7 * size2;
        let found = FoundPath {
            path,
            bounce_count: sites.count,
            bounce_points,
            focal_index: bundle.focal_points_passed + rays.focal_points_before(distance),
            optical_length: self.optical_length(sites, point),
            residual: solution.residual,
            jacobian: jacobian(&bundle, &rays, distance),
        };
        Some((found, singular))
    }

    /// Whether a path at a focal point is one of infinitely many: a neighbour along the blind direction solves too.
    fn is_one_of_infinitely_many(&self, group: &PathRays, ray: u32, solution: &Solution, point: DVec3) -> bool {
        let Some(bundle) = bundle_of(&self.surfaces, &self.eye, &solution.sites) else { return false };
        let Some(rays) = OutgoingRays::new(&bundle) else { return false };
        let [[a, b], [c, d]] = rays.spread(rays.origin.distance(point));
        // The direction that the singular matrix takes to zero: across its larger row.
        let blind = if a * a + b * b > c * c + d * d { DVec2::new(-b, a) } else { DVec2::new(-d, c) };
        let Some(blind) = blind.try_normalize() else { return true };
        let step = f64::from(group.reach[ray as usize]);
        let first = solution.sites.bounces[0].object;
        [step, -step].iter().all(|step| {
            let mut moved = solution.sites;
            let Some(site) = self.surfaces.moved(first, &moved.sites[0], blind * *step) else { return false };
            moved.sites[0] = site;
            let solved = solve(&self.surfaces, &self.eye, point, &moved, MAX_STEPS, SOLVED_RESIDUAL);
            solved.is_some_and(|other| {
                let away = other.sites.sites[0].position.distance(solution.sites.sites[0].position);
                other.converged && away > 0.5 * step.abs()
            })
        })
    }

    fn optical_length(&self, sites: &PathSites, point: DVec3) -> f64 {
        let Eye::Point(mut from) = self.eye else { return 0.0 };
        let mut medium = 1.0;
        let mut sum = 0.0;
        for index in 0..sites.count {
            let (bounce, site) = (sites.bounces[index], &sites.sites[index]);
            let lens = self.surfaces.index_of(bounce.object);
            let outside = self
                .surfaces
                .frame(bounce.object, site)
                .is_none_or(|frame| (from - site.position).dot(frame.geometric_normal()) >= 0.0);
            let crossed = if self.surfaces.is_lens(bounce.object) && !outside { lens } else { medium };
            sum += crossed * from.distance(site.position);
            medium = match bounce.kind {
                crate::optics::bundle::BounceKind::Reflect => crossed,
                crate::optics::bundle::BounceKind::Transmit => {
                    if outside {
                        lens
                    } else {
                        1.0
                    }
                }
            };
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
        let fov_deg = 2.0 * (radius / distance).asin().to_degrees() * 1.01;
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
        let mut infinite = Vec::new();
        if !point.is_finite() {
            return SearchOutcome::default();
        }
        for chart in &self.charts {
            for (group, path) in chart.map.groups.iter().zip(&chart.path_of_group) {
                let Some(path) = *path else { continue };
                group.candidates(point.as_vec3(), CandidateRule::LocalMinima, &mut Vec::new(), |ray| {
                    let Some(solution) = self.solve_from(group, ray, point) else { return };
                    let first = solution.sites.sites[0].position;
                    let same = |other: &FoundPath| {
                        other.path == path && other.bounce_points[0].distance(first) < self.same_point
                    };
                    if found[start..].iter().any(same) || !self.is_valid(&group.path, &solution.sites, point) {
                        return;
                    }
                    let Some((described, singular)) = self.describe(path, &solution, point) else { return };
                    if singular && self.is_one_of_infinitely_many(group, ray, &solution, point) {
                        infinite.push(path);
                        return;
                    }
                    found.push(described);
                });
            }
        }
        let mut kept = start;
        for index in start..found.len() {
            let path = found[index];
            let sequence = &self.paths[path.path as usize];
            let visible = || {
                let Some(visibility) = &self.visibility else { return true };
                let Eye::Point(eye) = self.eye else { return true };
                visibility.is_visible(eye, point, sequence, &path.bounce_points[..path.bounce_count])
            };
            if !infinite.contains(&path.path) && visible() {
                found[kept] = path;
                kept += 1;
            }
        }
        found.truncate(kept);
        found[start..].sort_by(|a, b| a.optical_length.total_cmp(&b.optical_length).then_with(|| a.path.cmp(&b.path)));
        SearchOutcome { found: kept - start, infinite: !infinite.is_empty() }
    }
}

impl std::fmt::Debug for ExactSearch<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = &self.scene.name;
        formatter.debug_struct("ExactSearch").field("scene", name).field("paths", &self.paths.len()).finish()
    }
}
