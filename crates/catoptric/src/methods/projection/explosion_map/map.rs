//! The explosion map of one reflector: cells by the directions of their hits on spheres about it.

use super::cells::{Cell, RayCorner, cells_of};
use super::chart::{Axes, Chart, Place, Record};
use super::samples::Samples;
use super::settings::{ExplosionMapSettings, Variant};
use super::subdivision;
use crate::math::Aabb;
use crate::methods::projection::virtual_objects::{Foot, Locator, Reflector, interpolated, outer, weights_of};
use crate::optics::bundle::BounceKind;
use crate::parallel;
use glam::{Mat3, Vec2, Vec3};

/// Spheres are this much larger than what they are to hold.
const ROOM: f32 = 1.001;

/// Profile triangles are extended by this share of the way to the singular direction.
const EXTENSION: f32 = 0.85;

/// Cells at one place of one map that are looked at: no more reflections of a point than these.
pub(super) const MOST_CELLS: usize = 8;

/// One sphere with its two maps, or the reflector as if it were one.
struct Sphere {
    /// None for the reflector itself.
    radius: Option<f32>,
    charts: [Chart; 2],
}

/// The map of one reflector for one kind of rays.
pub(super) struct ExplosionMap {
    center: Vec3,
    axes: Axes,
    /// The reflector itself, and the spheres about it from the nearest to the farthest.
    spheres: Vec<Sphere>,
    samples: Samples,
    variant: Variant,
}

/// What one or two spheres say about a place.
#[derive(Clone, Copy)]
pub(super) struct Blend<'a> {
    pub(super) near: &'a Record,
    pub(super) far: &'a Record,
    /// The share of the far one.
    pub(super) share: f32,
    /// The change of the share with the distance from the centre.
    pub(super) slope: f32,
}

impl<'a> Blend<'a> {
    /// What one sphere says.
    fn alone(record: &'a Record) -> Self {
        Self { near: record, far: record, share: 0.0, slope: 0.0 }
    }
}

impl ExplosionMap {
    /// Makes the map; none where the reflector shows no cell.
    pub(super) fn new(reflector: &Reflector<'_>, scene: &Aabb, settings: &ExplosionMapSettings) -> Option<Self> {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let cells = cells_of(reflector);
        if cells.is_empty() {
            return None;
        }
        // About the direction from which rays come back; glass sends them on.
        let mean: Vec3 = cells.iter().map(|cell| cell.corners[0].outgoing).sum();
        let arriving: Vec3 = rays.incoming.iter().filter(|incoming| incoming.is_finite()).sum();
        let axis = if rays.kind == BounceKind::Reflect { -arriving } else { mean };
        let axes = Axes::about(axis);
        let near = mesh.radius * ROOM;
        let far = scene.corners().iter().map(|corner| corner.distance(mesh.center)).fold(near * ROOM, f32::max) * ROOM;
        let count = settings.spheres;
        let radius = |index: u32| {
            let share = index as f32 / (count - 1) as f32;
            1.0 / (1.0 / near + (1.0 / far - 1.0 / near) * share)
        };
        let make = |index: usize| {
            let radius = index.checked_sub(1).map(|index| radius(index as u32));
            Sphere::new(radius, mesh.center, &axes, &cells, settings.map_size)
        };
        let spheres = parallel::map_collect(count as usize + 1, make);
        let samples = Samples::new(reflector, &cells);
        Some(Self { center: mesh.center, axes, spheres, samples, variant: settings.variant })
    }

    /// The place of a point in the maps, and its distance from their centre.
    #[inline]
    fn place(&self, point: Vec3) -> (Place, Vec3, f32) {
        let from = point - self.center;
        let distance = from.length();
        let direction = from / distance;
        (self.axes.place(direction), direction, distance)
    }

    /// The index of the first sphere that is farther than a distance, or the last one; never the reflector itself.
    #[inline]
    fn beyond(&self, distance: f32) -> usize {
        let last = self.spheres.len() - 1;
        let is_beyond = |index: &usize| self.spheres[*index].radius.is_some_and(|radius| radius >= distance);
        (1..last).find(is_beyond).unwrap_or(last)
    }

    /// One over the radius of a sphere; of the reflector, at a record's place.
    fn curvature(&self, sphere: &Sphere, record: &Record, uv: Vec2) -> f32 {
        let radius = sphere.radius.unwrap_or_else(|| at(record.position, record.uv, uv).distance(self.center));
        1.0 / radius
    }

    /// Calls `take` for what the maps say about a place.
    fn blends(&self, place: &Place, distance: f32, take: &mut impl FnMut(&Blend<'_>)) {
        let index = self.beyond(distance);
        let (near, far) = (&self.spheres[index - 1], &self.spheres[index]);
        let (near_cells, far_cells) = (near.at(place), far.at(place));
        let mut used = [false; MOST_CELLS];
        let mut found = false;
        let uv = place.uv;
        for one in near_cells.iter().flatten() {
            // The same surface at the far sphere: the foot nearest to this one.
            let here = at(one.position, one.uv, uv);
            let apart = |other: &Record| at(other.position, other.uv, uv).distance_squared(here);
            let others = far_cells.iter().enumerate().filter(|(k, _)| !used[*k]);
            let others = others.filter_map(|(k, other)| Some((k, (*other)?)));
            let Some((k, other)) = others.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1))) else {
                take(&Blend::alone(one));
                found = true;
                continue;
            };
            used[k] = true;
            found = true;
            // Feet move about evenly with one over the distance.
            let [here, there] = [(near, *one), (far, other)].map(|(sphere, record)| self.curvature(sphere, record, uv));
            let span = here - there;
            let share = (here - 1.0 / distance) / span;
            let within = share > 0.0 && share < 1.0;
            let slope = if within { 1.0 / (distance * distance * span) } else { 0.0 };
            // Also what is not a number.
            let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
            take(&Blend { near: one, far: other, share, slope });
        }
        for (k, other) in far_cells.iter().enumerate() {
            if let Some(other) = other
                && !used[k]
            {
                take(&Blend::alone(other));
                found = true;
            }
        }
        // Where these spheres have no cell another one may.
        let mut others = self.spheres.iter().rev();
        while !found && let Some(sphere) = others.next() {
            for record in sphere.at(place).iter().flatten() {
                take(&Blend::alone(record));
                found = true;
            }
        }
    }

    /// Where the mirror image of a point is, from the first cell of each sphere; not finite where there is none. For
    /// reflectors that show a point once.
    #[inline]
    pub(super) fn mirror_image(&self, point: Vec3) -> Vec3 {
        let (place, _, distance) = self.place(point);
        let index = self.beyond(distance);
        let (near, far) = (&self.spheres[index - 1], &self.spheres[index]);
        let (one, other) = (near.charts[place.chart].first(place.uv), far.charts[place.chart].first(place.uv));
        let (Some(one), Some(other)) = (one.or(other), other.or(one)) else { return Vec3::NAN };
        let here = self.curvature(near, one, place.uv);
        let share = (here - 1.0 / distance) / (here - self.curvature(far, other, place.uv));
        // Also what is not a number.
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        let mix = |one: Vec3, other: Vec3| one + (other - one) * share;
        let position = mix(at(one.position, one.uv, place.uv), at(other.position, other.uv, place.uv));
        let normal = mix(at(one.normal, one.uv, place.uv), at(other.normal, other.uv, place.uv));
        point - normal * (2.0 * normal.dot(point - position) / normal.length_squared())
    }

    /// The foot of a blend, with its changes.
    fn foot(
        &self,
        reflector: &Reflector<'_>,
        blend: &Blend<'_>,
        place: &Place,
        direction: Vec3,
        distance: f32,
    ) -> Foot {
        let uv = place.uv;
        let Blend { near, far, share, slope } = *blend;
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let (near_position, far_position) = (at(near.position, near.uv, uv), at(far.position, far.uv, uv));
        let (near_normal, far_normal) = (at(near.normal, near.uv, uv), at(far.normal, far.uv, uv));
        let position = mix(near_position, far_position);
        let raw = mix(near_normal, far_normal);
        let inverse = raw.length().recip();
        let normal = raw * inverse;
        // Of the place with the point: of the direction, which changes across itself.
        let turned = |change: Vec3| (change - direction * direction.dot(change)) / distance;
        let [along_u, along_v] = self.axes.change(place).map(turned);
        let along_share = direction * slope;
        let change = |near: &[Vec3; 3], far: &[Vec3; 3], apart: Vec3| {
            outer(mix(near[1], far[1]), along_u) + outer(mix(near[2], far[2]), along_v) + outer(apart, along_share)
        };
        let position_change = change(&near.position, &far.position, far_position - near_position);
        let normal_change: Mat3 = change(&near.normal, &far.normal, far_normal - near_normal) * inverse;
        let normal_change = normal_change - outer(normal, normal_change.transpose() * normal);
        let nearer = if share < 0.5 { near } else { far };
        // Of the blended position, in the nearer one's triangle.
        let corners = reflector.mesh.triangles[nearer.triangle as usize];
        let weights = weights_of(corners.map(|vertex| reflector.mesh.positions[vertex as usize]), position);
        let origin = interpolated(&reflector.rays.origins, corners, weights);
        Foot {
            position,
            normal,
            position_change,
            normal_change,
            origin,
            triangle: nearer.triangle,
            weights,
            beyond: near.beyond || far.beyond,
        }
    }
}

impl Locator for ExplosionMap {
    fn locate(&self, reflector: &Reflector<'_>, point: Vec3, take: &mut dyn FnMut(&Foot)) {
        let (place, direction, distance) = self.place(point);
        if distance.is_nan() || distance <= 0.0 {
            return;
        }
        let foot = |blend: &Blend<'_>| self.foot(reflector, blend, &place, direction, distance);
        // Spheres tell little of what is between them and the reflector, unless that is convex.
        if distance < self.spheres[1].radius.unwrap_or(0.0) && !reflector.mesh.convex {
            return self.samples.locate(reflector, point, take);
        }
        if self.variant == Variant::Map {
            return self.blends(&place, distance, &mut |blend| take(&foot(blend)));
        }
        // Several guesses may lead to one cell.
        let mut known = [u32::MAX; MOST_CELLS];
        let mut count = 0;
        let mut walk = |seed: &Foot| {
            subdivision::locate(reflector, seed, point, &mut |found| {
                if !known.contains(&found.triangle) && count < MOST_CELLS {
                    known[count] = found.triangle;
                    count += 1;
                    take(found);
                }
            });
        };
        self.blends(&place, distance, &mut |blend| walk(&foot(blend)));
    }

    fn byte_count(&self) -> u64 {
        let charts = self.spheres.iter().flat_map(|sphere| &sphere.charts);
        charts.map(Chart::byte_count).sum::<u64>() + self.samples.byte_count()
    }
}

/// What is linear about a record's first corner, at a place.
#[inline]
fn at(values: [Vec3; 3], origin: Vec2, uv: Vec2) -> Vec3 {
    values[0] + values[1] * (uv.x - origin.x) + values[2] * (uv.y - origin.y)
}

impl Sphere {
    fn new(radius: Option<f32>, center: Vec3, axes: &Axes, cells: &[Cell], size: u32) -> Self {
        let hits: Vec<[Vec3; 3]> =
            cells.iter().map(|cell| cell.corners.map(|corner| hit(&corner, center, radius, axes))).collect();
        let chart = |chart: usize| {
            let drawn = |(cell, hits): (&Cell, &[Vec3; 3])| {
                let places = axes.triangle(*hits, chart)?;
                Some((places, cell.corners.map(|corner| corner.corner), cell.triangle, cell.beyond))
            };
            let mut drawn_cells = Vec::with_capacity(if chart == 0 { cells.len() } else { 0 });
            drawn_cells.extend(cells.iter().zip(&hits).filter_map(drawn));
            Chart::new(size, &drawn_cells)
        };
        Self { radius, charts: [chart(0), chart(1)] }
    }

    /// The cells at a place.
    fn at(&self, place: &Place) -> [Option<&Record>; MOST_CELLS] {
        let mut found = [None; MOST_CELLS];
        for (slot, record) in found.iter_mut().zip(self.charts[place.chart].at(place.uv)) {
            *slot = Some(record);
        }
        found
    }
}

/// The direction from the centre in which a corner's ray hits a sphere; beyond a silhouette, further out.
fn hit(corner: &RayCorner, center: Vec3, radius: Option<f32>, axes: &Axes) -> Vec3 {
    let from = corner.corner.position - center;
    let along = from.dot(corner.outgoing);
    let length = match radius {
        Some(radius) => (along * along - from.length_squared() + radius * radius).max(0.0).sqrt() - along,
        None => 0.0,
    };
    let direction = (from + corner.outgoing * length).normalize_or_zero();
    if !corner.outward {
        return direction;
    }
    let axis = axes.axis();
    let Some(across) = (direction - axis * axis.dot(direction)).try_normalize() else { return direction };
    let angle = axis.dot(direction).clamp(-1.0, 1.0).acos();
    let (sin, cos) = (angle + EXTENSION * (std::f32::consts::PI - angle)).sin_cos();
    axis * cos + across * sin
}
