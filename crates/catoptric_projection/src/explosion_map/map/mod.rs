//! The explosion map of one reflector: cells by the directions of their hits on spheres about it.

mod chart;
mod mirror;

use crate::explosion_map::cell_tree::CellTree;
use crate::explosion_map::cells::{MapCells, RayCorner};
use crate::explosion_map::settings::{ExplosionMapSettings, Variant};
use crate::explosion_map::subdivision::{WalkReach, Walks};
use crate::find::virtual_objects::{
    Locator, Recursion, ReflectionPoint, ReflectionPoints, Reflector, interpolated, outer, weights_of,
};
use crate::find::work;
use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_engine::method::Report;
use catoptric_engine::optics::path::bundle::BounceKind;
use chart::{Axes, ChartPlace, Record, SphereChart, Tag};
use glam::{Mat3, Vec3, Vec3A};

/// The factor by which spheres are larger than their contents. Chosen well above rounding, not measured.
const ROOM: f32 = 1.001;

/// Profile triangles are extended by this share of the way to the singular direction. Chosen, not measured.
const EXTENSION: f32 = 0.85;

/// Cells at one place of one map that are looked at: no more reflections of a point than these. A bound on time;
/// chosen, not measured.
const MAX_CELLS: usize = 8;

/// Work of the look-up of a point.
const WORK_A_POINT: u64 = 3;

/// Bytes of a map that take a unit of work to fill.
const CHART_BYTES_A_UNIT: u64 = 24;

/// One sphere, or the reflector itself in place of one, with its two maps.
struct MapSphere {
    /// The radius; `None`: the reflector itself.
    radius: Option<f32>,
    charts: [SphereChart; 2],
}

/// The map of one reflector for one kind of rays.
pub(super) struct ExplosionMap {
    center: Vec3,
    axes: Axes,
    /// Texels a side of the maps.
    size: u32,
    /// The reflector itself, if there are more than two, and the spheres about it from the nearest to the farthest.
    spheres: Vec<MapSphere>,
    /// A tree of all cells, for points that the spheres do not resolve.
    tree: Option<CellTree>,
    variant: Variant,
    /// True if the answers of two spheres are blended as virtual vertices, false if as reflection points.
    blends_images: bool,
}

/// Records of one or two spheres at a place, blended.
#[derive(Clone, Copy)]
struct SphereBlend<'a> {
    near: TaggedRecord<'a>,
    far: TaggedRecord<'a>,
    /// The share of the far one.
    share: f32,
    /// The change of the share with the distance from the centre.
    slope: f32,
}

/// A record of a map, and the triangle that it is from.
type TaggedRecord<'a> = (&'a Record, &'a Tag);

impl<'a> SphereBlend<'a> {
    /// The record of one sphere alone.
    fn alone(one: TaggedRecord<'a>) -> Self {
        Self { near: one, far: one, share: 0.0, slope: 0.0 }
    }
}

impl ExplosionMap {
    /// Makes the map; returns `None` if the reflector shows no cell.
    pub(super) fn new(reflector: &Reflector<'_>, scene: &Aabb, settings: &ExplosionMapSettings) -> Option<Self> {
        let (mesh, rays) = (reflector.mesh, reflector.rays);
        let cells = MapCells::new(reflector);
        if cells.cells.is_empty() {
            return None;
        }
        // About the direction from which rays come back; glass sends them on.
        let mean: Vec3A = cells.cells.iter().map(|cell| cells.corners[cell.corners[0] as usize].outgoing).sum();
        let arriving: Vec3 = rays.incoming.iter().filter(|incoming| incoming.is_finite()).sum();
        let axis = if rays.kind == BounceKind::Reflect { -arriving } else { mean.into() };
        let axes = Axes::about(axis);
        let near = mesh.radius * ROOM;
        let far = scene.corners().iter().map(|corner| corner.distance(mesh.center)).fold(near * ROOM, f32::max) * ROOM;
        let count = settings.spheres;
        let radius = |index: u32| {
            let share = index as f32 / (count - 1) as f32;
            1.0 / (1.0 / near + (1.0 / far - 1.0 / near) * share)
        };
        // With two spheres, as in the paper, the nearer one is used for all points within it.
        let itself = (count > 2).then_some(None);
        let radii: Vec<Option<f32>> = itself.into_iter().chain((0..count).map(|index| Some(radius(index)))).collect();
        let make = |index: usize| MapSphere::new(radii[index], mesh.center, &axes, &cells, settings.map_size);
        let spheres = parallel::map_collect(radii.len(), make);
        // A convex mirror is hollow to an eye in it.
        let rays = reflector.rays;
        let hollow = rays.kind == BounceKind::Reflect && rays.side < 0.0 && !rays.inside_after;
        let tree = (!mesh.convex || hollow).then(|| CellTree::new(reflector, scene.diagonal()));
        let (center, size, variant) = (mesh.center, settings.map_size, settings.variant);
        let blends_images = variant == Variant::Map && settings.recursion() == Recursion::VirtualPoints;
        Some(Self { center, axes, size, spheres, tree, variant, blends_images })
    }

    /// The place of a point in the maps, and its distance from their centre.
    #[inline]
    fn place(&self, point: Vec3) -> (ChartPlace, Vec3, f32) {
        let from = point - self.center;
        let distance = from.length();
        let direction = from / distance;
        (self.axes.place(direction), direction, distance)
    }

    /// The index of the first sphere that is farther than a distance, or the last one; never the very first.
    #[inline]
    fn beyond(&self, distance: f32) -> usize {
        let last = self.spheres.len() - 1;
        let is_beyond = |index: &usize| self.spheres[*index].radius.is_some_and(|radius| radius >= distance);
        (1..last).find(is_beyond).unwrap_or(last)
    }

    /// The weight of the farther of two spheres at a point, and its change with the point's distance from the centre:
    /// reflection points move about evenly with one over the distance. `positions` are those of both records.
    #[inline]
    fn share(&self, spheres: [&MapSphere; 2], positions: [Vec3A; 2], distance: f32) -> (f32, f32) {
        let one_over = |k: usize| {
            let radius = spheres[k].radius.unwrap_or_else(|| positions[k].distance(self.center.into()));
            1.0 / radius
        };
        let (here, there, nearness) = (one_over(0), one_over(1), 1.0 / distance);
        let span = here - there;
        let share = (here - nearness) / span;
        let slope = if share > 0.0 && share < 1.0 { nearness * nearness / span } else { 0.0 };
        // The share is 0 if it is not a number, too.
        (if share > 0.0 { share.min(1.0) } else { 0.0 }, slope)
    }

    /// Calls `take` for the blended records of the maps at a place.
    fn blends(&self, place: &ChartPlace, distance: f32, take: &mut impl FnMut(&SphereBlend<'_>)) {
        let index = self.beyond(distance);
        let (near, far) = (&self.spheres[index - 1], &self.spheres[index]);
        let (near_cells, far_cells) = (near.at(place), far.at(place));
        let mut used = [false; MAX_CELLS];
        let mut found = false;
        let uv = place.uv;
        for &one in near_cells.iter().flatten() {
            // The cell at the far sphere that shows the same surface is the one with the nearest reflection point.
            let [here, _] = one.0.at(uv);
            let apart = |other: &TaggedRecord<'_>| other.0.at(uv)[0].distance_squared(here);
            let others = far_cells.iter().enumerate().filter(|(k, _)| !used[*k]);
            let others = others.filter_map(|(k, other)| Some((k, (*other)?)));
            found = true;
            let Some((k, other)) = others.min_by(|a, b| apart(&a.1).total_cmp(&apart(&b.1))) else {
                take(&SphereBlend::alone(one));
                continue;
            };
            used[k] = true;
            let (share, slope) = self.share([near, far], [here, other.0.at(uv)[0]], distance);
            take(&SphereBlend { near: one, far: other, share, slope });
        }
        for (k, other) in far_cells.iter().enumerate() {
            if let Some(other) = *other
                && !used[k]
            {
                take(&SphereBlend::alone(other));
                found = true;
            }
        }
        // Another sphere may have cells where these two have none.
        let mut others = self.spheres.iter().rev();
        while !found && let Some(sphere) = others.next() {
            for &record in sphere.at(place).iter().flatten() {
                take(&SphereBlend::alone(record));
                found = true;
            }
        }
    }

    /// The reflection point of a blend, with its changes.
    fn reflection_point(
        &self,
        reflector: &Reflector<'_>,
        blend: &SphereBlend<'_>,
        place: &ChartPlace,
        direction: Vec3,
        distance: f32,
    ) -> ReflectionPoint {
        let SphereBlend { near: (near, near_tag), far: (far, far_tag), share, slope } = *blend;
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let [near_position, near_normal] = near.at(place.uv).map(Vec3::from);
        let [far_position, far_normal] = far.at(place.uv).map(Vec3::from);
        let position = mix(near_position, far_position);
        let raw = mix(near_normal, far_normal);
        let inverse = raw.length().recip();
        let normal = raw * inverse;
        // The change of the place with the point: through the direction, which changes across itself.
        let turned = |change: Vec3| (change - direction * direction.dot(change)) / distance;
        let [along_u, along_v] = self.axes.change(place).map(turned);
        let along_share = direction * slope;
        let change = |near: [Vec3; 2], far: [Vec3; 2], apart: Vec3| {
            outer(mix(near[0], far[0]), along_u) + outer(mix(near[1], far[1]), along_v) + outer(apart, along_share)
        };
        let position_change = change(near.position_changes(), far.position_changes(), far_position - near_position);
        let normal_change: Mat3 =
            change(near.normal_changes(), far.normal_changes(), far_normal - near_normal) * inverse;
        let normal_change = normal_change - outer(normal, normal_change.transpose() * normal);
        let nearer = if share < 0.5 { near_tag } else { far_tag };
        // The weights of the blended position in the nearer one's triangle.
        let corners = reflector.mesh.triangles[nearer.triangle as usize];
        let weights = weights_of(corners.map(|vertex| reflector.mesh.positions[vertex as usize]), position);
        let origin = interpolated(&reflector.rays.origins, corners, weights);
        ReflectionPoint {
            position,
            normal,
            position_change,
            normal_change,
            origin,
            triangle: nearer.triangle,
            weights,
            beyond: near_tag.beyond || far_tag.beyond,
            blended_image: None,
        }
    }

    /// The virtual point of a blend (Ofek, Rappoport 1998): that between the point's images in the two spheres' tangent
    /// planes, and its change with the point. Returns `None` if one plane alone counts, or if a refracted ray cannot
    /// get to the point by one of them.
    fn blended_image(
        &self,
        reflector: &Reflector<'_>,
        blend: &SphereBlend<'_>,
        place: &ChartPlace,
        direction: Vec3,
        point: Vec3,
    ) -> Option<(Vec3, Mat3)> {
        let SphereBlend { near, far, share, slope } = *blend;
        if !self.blends_images || share <= 0.0 || share >= 1.0 {
            return None;
        }
        let distance = point.distance(self.center);
        let image = |record: TaggedRecord<'_>| {
            let alone = SphereBlend::alone(record);
            self.reflection_point(reflector, &alone, place, direction, distance).virtual_point(reflector.rays, point)
        };
        let ((near, near_change), (far, far_change)) = (image(near)?, image(far)?);
        let change = near_change * (1.0 - share) + far_change * share + outer(far - near, direction * slope);
        Some((near + (far - near) * share, change))
    }
}

impl ExplosionMap {
    fn chart_bytes(&self) -> u64 {
        self.spheres.iter().flat_map(|sphere| &sphere.charts).map(SphereChart::byte_count).sum()
    }

    /// Appends the reflection points of one scene point.
    fn locate_point(&self, reflector: &Reflector<'_>, point: Vec3, found: &mut Vec<ReflectionPoint>) {
        let (place, direction, distance) = self.place(point);
        if distance.is_nan() || distance <= 0.0 {
            return;
        }
        work::add(WORK_A_POINT);
        let mut walks = Walks::new(reflector, point);
        // Spheres resolve little between them and the reflector, unless that is convex.
        let nearest = self.spheres.iter().find_map(|sphere| sphere.radius).unwrap_or(0.0);
        let tree = self.tree.as_ref().filter(|_| self.variant == Variant::Subdivision || distance < nearest);
        if let Some(tree) = tree {
            tree.locate(reflector, point, &mut walks, found);
        }
        self.blends(&place, distance, &mut |blend| {
            let mut reflection_point = self.reflection_point(reflector, blend, &place, direction, distance);
            reflection_point.blended_image = self.blended_image(reflector, blend, &place, direction, point);
            match (self.variant, tree) {
                (Variant::Map, None) => found.push(reflection_point),
                (Variant::Subdivision, None) => {
                    found.extend(walks.walk(reflection_point.triangle, reflection_point.weights, WalkReach::Anywhere));
                }
                // Points beyond the silhouette or border of the reflector lie in no cell; rays within a body end there.
                (_, Some(_)) if reflection_point.beyond && !reflector.rays.inside_after => {
                    found.extend(walks.walk(reflection_point.triangle, reflection_point.weights, WalkReach::Anywhere));
                }
                (_, Some(_)) => {}
            }
        });
    }
}

impl Locator for ExplosionMap {
    fn locate(&self, reflector: &Reflector<'_>, points: &[Vec3], found: &mut ReflectionPoints) {
        found.extend(points, |point, found| self.locate_point(reflector, point, found));
    }

    fn add_fallbacks(&self, report: &mut Report) {
        report.add_fallback("cells_not_searched", self.tree.as_ref().map_or(0, CellTree::not_searched));
    }

    fn byte_count(&self) -> u64 {
        self.chart_bytes() + self.tree.as_ref().map_or(0, CellTree::byte_count)
    }

    fn build_work(&self) -> u64 {
        self.chart_bytes() / CHART_BYTES_A_UNIT + self.tree.as_ref().map_or(0, CellTree::build_work)
    }
}

impl MapSphere {
    fn new(radius: Option<f32>, center: Vec3, axes: &Axes, cells: &MapCells, size: u32) -> Self {
        let hits = cells.corners.iter().map(|corner| axes.local(hit(corner, center.into(), radius, axes)));
        let local: Vec<Vec3> = hits.collect();
        Self { radius, charts: [0, 1].map(|chart| SphereChart::new(size, chart, cells, &local)) }
    }

    /// The cells at a place.
    fn at(&self, place: &ChartPlace) -> [Option<TaggedRecord<'_>>; MAX_CELLS] {
        let mut found = [None; MAX_CELLS];
        for (slot, record) in found.iter_mut().zip(self.charts[place.chart].at(place.uv)) {
            *slot = Some(record);
        }
        found
    }
}

/// The direction from the centre in which a corner's ray hits a sphere; beyond a silhouette, further out.
#[inline]
fn hit(corner: &RayCorner, center: Vec3A, radius: Option<f32>, axes: &Axes) -> Vec3A {
    let from = corner.position - center;
    let along = from.dot(corner.outgoing);
    let length = match radius {
        Some(radius) => (along * along - from.length_squared() + radius * radius).max(0.0).sqrt() - along,
        None => 0.0,
    };
    let direction = (from + corner.outgoing * length).normalize_or_zero();
    if !corner.outward {
        return direction;
    }
    let axis = Vec3A::from(axes.axis());
    let Some(across) = (direction - axis * axis.dot(direction)).try_normalize() else { return direction };
    let angle = axis.dot(direction).clamp(-1.0, 1.0).arc_cosine();
    let (sin, cos) = (angle + EXTENSION * (std::f32::consts::PI - angle)).sine_cosine();
    axis * cos + across * sin
}
