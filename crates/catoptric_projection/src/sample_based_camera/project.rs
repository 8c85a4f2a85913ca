//! Scene points to their appearances through the cameras.

use super::cameras::{CameraAnswer, CameraProjection, CameraScratch, Cameras};
use super::rays::grid::RayGrid;
use crate::find::polish::{Effort, polished};
use crate::find::ray_map::{RayField, RaySample, Specular, ViewField, follow};
use catoptric_core::scene::{PreciseView, Scene};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::optics::path::bundle::Eye;
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_engine::raster::BlockMask;
use glam::{DVec3, Vec2, Vec3};
use std::cell::RefCell;
use std::sync::Arc;

/// Points nearer to their last bounce than this share of the reflector's size lie on it. Chosen, not measured.
pub(super) const TOUCHING: f64 = 2e-4;

/// The distance beyond the cells of its rays, in cells, up to which a leaf is used. Chosen, not measured.
const BEYOND_BLOCK: f64 = 0.75;

/// The distance from their cell, in spacings of rays, up to which interpolated projections are accepted. Chosen, not
/// measured.
const INTERPOLATED_LEEWAY: f64 = 0.4;

/// Two answers of leaves that share a border are one when they are nearer than this many times the accuracy. Chosen,
/// not measured.
const SAME: f32 = 3.0;

/// Polished answers are one when they are nearer than this, in pixels: beside folds the solver's answers scatter.
/// Chosen, not measured.
const SAME_POLISHED_PX: f32 = 0.3;

/// Polish may move an answer by this many cells. Chosen, not measured.
const POLISH_REACH: f64 = 3.0;

/// An appearance that has moved further than this, in pixels, is not followed. Chosen, not measured.
const FOLLOWED_PX: f64 = 32.0;

/// Places in front of the eye's plane are anywhere; cells beyond this are none of the map's.
const FARTHEST_CELL: f64 = 1e9;

/// Projects scene points by the cameras of one view.
pub(super) struct CameraProjector<'a> {
    pub(super) grid: &'a RayGrid,
    /// The cameras of each group of the grid.
    pub(super) cameras: &'a [Cameras],
    pub(super) paths: Vec<SpecularPath>,
    /// Paths that have no cameras, because there is too much to do for them.
    pub(super) left_out: &'a [SpecularPath],
    /// The blocks of the picture, for every path, where appearances are not looked for.
    pub(super) holes: Vec<BlockMask>,
    pub(super) eye: Eye,
    pub(super) view: PreciseView,
    /// The rays of the grid.
    pub(super) field: ViewField,
    pub(super) scene: &'a Scene,
    pub(super) tracer: Arc<Tracer>,
    pub(super) surfaces: SpecularSurfaces<'a>,
    pub(super) margin_px: f64,
    /// The accuracy of each path's cameras.
    pub(super) accuracies_px: Vec<f32>,
    /// Steps of the solver, or 0.
    pub(super) polish: u32,
    /// The size of every object.
    pub(super) sizes: Vec<f64>,
}

/// A form in which appearances are collected.
pub(super) trait Appearance {
    /// An appearance, as a camera has found it.
    fn new(projection: Projection, answer: &CameraProjection) -> Self;

    /// The appearance.
    fn projection(&self) -> &Projection;
}

impl Appearance for Projection {
    fn new(projection: Projection, _: &CameraProjection) -> Self {
        projection
    }

    fn projection(&self) -> &Projection {
        self
    }
}

thread_local! {
    static SCRATCH: RefCell<CameraScratch> = RefCell::default();
}

impl VertexProjector for CameraProjector<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn left_out(&self) -> &[SpecularPath] {
        self.left_out
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        found.extend(points, |point, found| self.project_near(path, point, None, found));
    }

    fn holes(&self, path: u32) -> Option<&BlockMask> {
        self.holes.get(path as usize).filter(|holes| !holes.is_empty())
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Projections) {
        found.extend(&[point], |point, found| self.follow_point(one, point, found));
    }
}

impl CameraProjector<'_> {
    /// Appends the continuation of an appearance at a point near its own.
    pub(super) fn follow_point(&self, one: &Projection, point: Vec3, found: &mut Vec<Projection>) {
        let path = one.path as usize;
        let (Some(cameras), Some(group)) = (self.cameras.get(path), self.grid.groups.get(path)) else { return };
        let mut place = self.cell_of([one.image_px.x.into(), one.image_px.y.into()]);
        let mut first = one.reflection_point.as_dvec3();
        // The leaf of the appearance is asked, then the one that the appearance has moved into.
        for _ in 0..2 {
            let Some(ray) = group.nearest(place) else { break };
            let near =
                cameras.ask_near(ray, point, first, |seen| (self.projection(one.path, seen, point), seen.answer.first));
            let Some((projection, seen_at)) = near else { break };
            // Beside a fold the way may lead to the other sheet.
            if let Some(projection) = projection.filter(|other| other.focal_index == one.focal_index) {
                found.push(projection);
                return;
            }
            let Some(moved) = self.view.place_of(seen_at) else { break };
            (place, first) = (self.cell_of(moved), seen_at);
        }
        let most = FOLLOWED_PX / f64::from(self.grid.spacing_px);
        let near = (self.cell_of(one.image_px.to_array().map(f64::from)), most);
        self.project_near(one.path, point, Some(near), found);
    }

    /// Appends all appearances of a point on a path; those near a place of the map if there is a `limit` (in cells).
    pub(super) fn project_near<T: Appearance>(
        &self,
        path: u32,
        point: Vec3,
        limit: Option<([f64; 2], f64)>,
        found: &mut Vec<T>,
    ) {
        let Some(cameras) = self.cameras.get(path as usize) else { return };
        if !point.is_finite() {
            return;
        }
        let start = found.len();
        let accuracy_px = self.accuracies_px.get(path as usize).copied().unwrap_or_default();
        let mut take = |seen: &CameraAnswer<'_>| {
            let Some(projection) = self.projection(path, seen, point) else { return };
            let apart_px = match () {
                () if self.polish > 0 && projection.error_px == 0.0 => SAME_POLISHED_PX,
                () if seen.interpolates => (SAME * accuracy_px).max(seen.apart * self.grid.spacing_px),
                () => SAME * accuracy_px,
            };
            let same = |other: &T| {
                let other = other.projection();
                other.focal_index == projection.focal_index && other.image_px.distance(projection.image_px) < apart_px
            };
            if !found[start..].iter().any(same) {
                found.push(T::new(projection, seen.answer));
            }
        };
        SCRATCH.with_borrow_mut(|scratch| cameras.ask(point, limit, scratch, &mut take));
    }

    /// A place of the picture in cells of the ray map, whose rays are at whole numbers.
    pub(super) fn cell_of(&self, pixel: [f64; 2]) -> [f64; 2] {
        let cell = |pixel: f64| (pixel + self.margin_px) / f64::from(self.grid.spacing_px) - 0.5;
        pixel.map(|pixel| cell(pixel).clamp(-FARTHEST_CELL, FARTHEST_CELL))
    }

    /// A camera's answer as an appearance; returns `None` if the rays that it was fitted to are not.
    fn projection(&self, path: u32, seen: &CameraAnswer<'_>, point: Vec3) -> Option<Projection> {
        let answer = seen.answer;
        let object = self.paths[path as usize].bounces.last()?.object;
        if f64::from(answer.last_segment) < TOUCHING * self.sizes[object as usize] {
            return None;
        }
        // Polynomials go on beyond the silhouette, to the side that is not seen.
        if self.eye.direction_to(answer.first)?.dot(answer.normal.as_dvec3()) >= 0.0 {
            return None;
        }
        let [x, y] = self.view.place_of(answer.first)?;
        let place = self.cell_of([x, y]);
        if !self.is_within(path, seen, place) {
            return None;
        }
        let gradients = self.view.place_change(answer.first).map(DVec3::as_vec3);
        // Changes of the place with a lateral step.
        let [across, down] = gradients.map(|gradient| answer.moves.map(|moves| gradient.dot(moves)));
        let image_change = [across, down].map(|[right, up]| answer.lateral[0] * right + answer.lateral[1] * up);
        let largest = [across, down].as_flattened().iter().map(|change| change * change).sum::<f32>().sqrt();
        let projection = Projection {
            path,
            focal_index: answer.focal_index,
            image_px: Vec2::new(x as f32, y as f32),
            image_change,
            path_length: answer.length,
            reflection_point: answer.first.as_vec3(),
            last_segment: answer.last_segment,
            error_px: answer.lateral_error * largest,
        };
        match self.polish {
            0 => projection.if_meaningful(),
            _ => self.polished(path, seen, place, projection, point),
        }
    }

    /// An appearance made exact by the solver, from the bounces of the ray next to it; as it is where the solver does
    /// not get there in the steps that it has, none if it finds that there is no such path.
    fn polished(
        &self,
        path: u32,
        seen: &CameraAnswer<'_>,
        place: [f64; 2],
        as_seen: Projection,
        point: Vec3,
    ) -> Option<Projection> {
        let group = &self.grid.groups[path as usize];
        // Where rays are not kept nothing is polished.
        let ray = group.rays.get(group.nearest(place)?)?;
        let spacing = self.grid.spacing_px;
        let [x, y] = ray.place.map(|place| (place + 0.5) * spacing);
        let (view_ray, near) = self.field.ray(x, y);
        let order = self.paths[path as usize].bounces.len() as u32;
        let specular = Specular { scene: self.scene, tracer: &self.tracer, surfaces: &self.surfaces, order };
        let mut sample: Option<RaySample> = None;
        follow(&specular, &self.eye, &view_ray, near, &mut |other, followed| {
            if other == self.paths[path as usize] {
                sample = Some(followed);
            }
        });
        let Some(sample) = sample else { return as_seen.if_meaningful() };
        // Cameras count the last segment's focal points.
        let focal_index = as_seen.focal_index + sample.focal_points_passed;
        let as_seen = Projection { focal_index, ..as_seen };
        let parameters = sample.parameters_of(seen.answer.first);
        let Some(start) = sample.sites_at(&self.surfaces, parameters) else { return as_seen.if_meaningful() };
        let reach = POLISH_REACH * (ray.first.distance(seen.answer.first)).max(self.cell_size_at(ray.first));
        let effort = Effort { steps: self.polish, reach, must_converge: false };
        let exact = point.as_dvec3();
        let found = polished(&self.surfaces, &self.eye, &start, &sample.outside, exact, effort)?;
        if !found.converged {
            return as_seen.if_meaningful();
        }
        let place = self.view.place_of(found.sites.sites[0].position)?;
        let object = self.paths[path as usize].bounces.last()?.object;
        if found.last.distance(exact) < TOUCHING * self.sizes[object as usize] {
            return None;
        }
        if !self.is_within(path, &CameraAnswer { places: None, ..*seen }, self.cell_of(place)) {
            return None;
        }
        let length = sample.optical_length_along(&self.eye, &found.sites, exact);
        found.projection(path, &self.view, length, exact)
    }

    /// About how far apart on the first surface neighbouring rays are, seen face on.
    fn cell_size_at(&self, first: DVec3) -> f64 {
        let [right, down] = self.view.place_change(first).map(DVec3::length);
        f64::from(self.grid.spacing_px) / right.max(down).max(1e-12)
    }

    /// True if a place, in cells, is among the rays that an answer is meant for, or beside them where their piece ends.
    fn is_within(&self, path: u32, seen: &CameraAnswer<'_>, place: [f64; 2]) -> bool {
        let group = &self.grid.groups[path as usize];
        let accuracy = f64::from(self.accuracies_px[path as usize] / self.grid.spacing_px);
        let leeway = if seen.interpolates { INTERPOLATED_LEEWAY * f64::from(seen.apart) } else { accuracy };
        for axis in 0..2 {
            let Some([lowest, highest]) = seen.places else { break };
            let (low, high) = (f64::from(lowest[axis]), f64::from(highest[axis]));
            let above = place[axis] > high;
            // `next` is the row or column of the first regular ray beyond.
            let (beyond, next) =
                if above { (place[axis] - high, high.floor() + 1.0) } else { (low - place[axis], low.ceil() - 1.0) };
            if beyond <= leeway {
                continue;
            }
            let mut cell = place.map(|place| place.round() as i64);
            cell[axis] = next as i64;
            let goes_on = group.regular(cell[0], cell[1]).is_some_and(|ray| group.piece_of_ray[ray] == seen.piece);
            if beyond > BEYOND_BLOCK || goes_on {
                return false;
            }
            // Other leaves may hold rays between those two.
            let nearest = group.nearest(place).map(|ray| group.place_of(ray));
            let holds = |ray: [f32; 2]| (0..2).all(|axis| (lowest[axis]..=highest[axis]).contains(&ray[axis]));
            if !nearest.is_some_and(holds) {
                return false;
            }
        }
        group.piece_at(place) == Some(seen.piece)
    }
}
