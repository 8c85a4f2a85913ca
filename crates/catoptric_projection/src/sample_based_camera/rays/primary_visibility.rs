//! Primary visibility of a regular map: reflectors are drawn on the map, row by row, instead of a walk through the
//! hierarchy for each ray.
//!
//! Each triangle has a range of columns per row in which it may appear, with a little room; there every ray is tested
//! against the triangle itself, by the test of the ray tracer, and keeps the nearest hit. The answer is therefore the
//! tracer's.

use super::extent::extent;
use crate::find::ray_map::{RayField, Specular};
use catoptric_core::parallel;
use catoptric_core::scene::hit::PrimitiveHit;
use catoptric_core::scene::{Ray, Scene};
use catoptric_core::surface::PlacedSurface;
use catoptric_engine::light::tracer::TriangleTest;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Triangles are looked for this many cells beside where they appear, and further by the rounding of rays. Chosen, not
/// measured.
const ROOM: f64 = 0.03;

/// The rounding, in cells, above which nothing is drawn. Chosen, not measured.
const MAX_ROOM: f64 = 0.5;

/// The maximum number of tests for a ray, on the average of the map: a walk through the hierarchy costs about as much.
const MAX_TESTS: f64 = 8.0;

/// Tests that a surface's formula is worth. Chosen, not measured.
const SURFACE_TESTS: f64 = 2.0;

/// The maximum number of triangles that are drawn, in numbers of rays: of more, most would fall between the rays.
/// Chosen, not measured.
const MAX_TRIANGLES: usize = 4;

/// Halvings of an edge that leads behind the eye, to find where it gets there. The bits of a single-precision mantissa.
const HALVINGS: usize = 24;

/// Triangles that are drawn at once. A size for threads; chosen, not measured.
const CHUNK: usize = 1024;

/// The rays of one row of the map, with the first hit of each.
#[derive(Default)]
pub struct VisibilityRow {
    /// Columns of the rays. The others meet nothing.
    pub(in super::super) columns: Range<u32>,
    pub(in super::super) rays: Vec<Ray>,
    near: Vec<f32>,
    /// The distance of the nearest hit of each ray, and the hit.
    nearest: Vec<(f32, Option<PrimitiveHit>)>,
    spans: Vec<(u32, Range<u32>)>,
}

impl VisibilityRow {
    /// The rays that meet something: their columns, and their hits.
    pub fn seen(&self) -> impl Iterator<Item = (u32, &Ray, &PrimitiveHit)> {
        let met = self.rays.iter().zip(&self.nearest).zip(self.columns.clone());
        met.filter_map(|((ray, (_, meeting)), column)| Some((column, ray, meeting.as_ref()?)))
    }

    /// Rays of these columns that have met nothing.
    fn start(&mut self, columns: Range<u32>, ray: impl Fn(u32) -> (Ray, f32)) {
        self.columns = columns;
        self.rays.clear();
        self.near.clear();
        for column in self.columns.clone() {
            let (ray, near) = ray(column);
            self.rays.push(ray);
            self.near.push(near);
        }
        self.nearest.clear();
        self.nearest.resize(self.rays.len(), (f32::INFINITY, None));
    }

    /// Records hits of the rays of some columns: `distance` is the hit distance, if nearer than the best so far.
    #[inline(always)]
    fn meet(&mut self, columns: Range<u32>, mut met: impl FnMut(&Ray, f32, f32) -> Option<(f32, PrimitiveHit)>) {
        let places = (columns.start - self.columns.start) as usize..(columns.end - self.columns.start) as usize;
        let rays = self.rays[places.clone()].iter().zip(&self.near[places.clone()]);
        for ((ray, near), nearest) in rays.zip(&mut self.nearest[places]) {
            if let Some((distance, meeting)) = met(ray, *near, nearest.0) {
                *nearest = (distance, Some(meeting));
            }
        }
    }
}

/// A triangle as it appears, in cells: a polygon of up to four corners (the last one repeated).
#[derive(Clone, Copy)]
struct VisibleTriangle {
    triangle: u32,
    alpha_tested: bool,
    corners: [[f64; 2]; 4],
    /// The columns and rows that it may be seen in.
    columns: [u32; 2],
    rows: [u32; 2],
}

impl VisibleTriangle {
    /// The range of its coordinates across between two heights.
    #[inline]
    fn between(&self, low: f64, high: f64) -> [f64; 2] {
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for index in 0..4 {
            let (a, b) = (self.corners[index], self.corners[(index + 1) & 3]);
            let (upper, lower) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            if lower[1] < low || upper[1] > high {
                continue;
            }
            let height = lower[1] - upper[1];
            let at = |share: f64| upper[0] + (lower[0] - upper[0]) * share;
            let inside = |y: f64, otherwise: f64| if height > 0.0 { (y - upper[1]) / height } else { otherwise };
            for x in [at(inside(low, 0.0).max(0.0)), at(inside(high, 1.0).min(1.0))] {
                found = [found[0].min(x), found[1].max(x)];
            }
        }
        found
    }
}

/// An analytic surface, and the columns and rows in which its box appears.
struct ShownSurface<'a> {
    object: u32,
    surface: &'a PlacedSurface,
    columns: Range<u32>,
    rows: Range<u32>,
}

/// The reflectors and lenses of a scene, drawn on a map.
pub struct PrimaryVisibility<'a> {
    scene: &'a Scene,
    map: Map<'a>,
    triangles: Vec<VisibleTriangle>,
    /// The triangles that may be seen in each row, all rows one after another, and where each row starts.
    of_rows: Vec<u32>,
    starts: Vec<u32>,
    surfaces: Vec<ShownSurface<'a>>,
}

/// The whole numbers of a range, with some room, that are below `count`.
#[inline]
fn whole([low, high]: [f64; 2], room: f64, count: u32) -> Range<u32> {
    let (low, high) = ((low - room).max(0.0), high + room);
    // Conversions are clamped. (Rounding functions would be calls on machines that are not asked for their features.)
    let start = (low as u32).saturating_add(u32::from(f64::from(low as u32) < low));
    let end = if high >= 0.0 { (high as u32).saturating_add(1) } else { 0 };
    start.min(count)..end.min(count)
}

/// A regular map: its field, and how many columns and rows of rays it has.
#[derive(Clone, Copy)]
struct Map<'a> {
    field: &'a dyn RayField,
    spacing_px: f32,
    size: [u32; 2],
    room: f64,
}

impl Map<'_> {
    /// The place where a point appears, in cells; `None` behind the eye.
    #[inline]
    fn place(&self, point: DVec3) -> Option<[f64; 2]> {
        let place = self.field.place_of(point)?.map(|px| self.cells(px));
        place.iter().all(|place| place.is_finite()).then_some(place)
    }

    #[inline]
    fn cells(&self, px: f64) -> f64 {
        px / f64::from(self.spacing_px) - 0.5
    }

    /// The triangles of some objects that may be seen.
    fn triangles(&self, scene: &Scene, meshes: &[u32]) -> Vec<VisibleTriangle> {
        let of = |mesh: usize| &scene.objects[meshes[mesh] as usize];
        // The places where the vertices of each mesh appear.
        let places = parallel::map_collect(meshes.len(), |mesh| {
            let vertices = of(mesh).vertices.clone();
            let position = |index: usize| scene.positions[vertices.start as usize + index].as_dvec3();
            parallel::map_collect(vertices.len(), |index| self.place(position(index)))
        });
        let chunks_of = |mesh: usize| {
            let Range { start, end } = of(mesh).triangles;
            (start..end).step_by(CHUNK).map(move |start| (mesh, start..end.min(start + CHUNK as u32)))
        };
        let chunks: Vec<(usize, Range<u32>)> = (0..meshes.len()).flat_map(chunks_of).collect();
        let shown = parallel::map_collect(chunks.len(), |chunk| {
            let (mesh, ref triangles) = chunks[chunk];
            let (places, first) = (&places[mesh], of(mesh).vertices.start);
            let alpha_tested = scene.is_alpha_tested(meshes[mesh]);
            let shown = triangles.clone().filter_map(|triangle| {
                let vertices = scene.triangles[triangle as usize];
                let ends = vertices.map(|vertex| places[(vertex - first) as usize]);
                let positions = vertices.map(|vertex| scene.positions[vertex as usize]);
                let corners = polygon(ends, positions, &|point| self.place(point))?;
                let [columns, rows] = [0, 1].map(|axis: usize| {
                    let [a, b, c, d] = corners.map(|corner| corner[axis]);
                    let range = [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))];
                    let Range { start, end } = whole(range, self.room, self.size[axis]);
                    [start, end]
                });
                let may_be_seen = columns[0] < columns[1] && rows[0] < rows[1];
                may_be_seen.then_some(VisibleTriangle { triangle, alpha_tested, corners, columns, rows })
            });
            shown.collect::<Vec<VisibleTriangle>>()
        });
        shown.concat()
    }

    /// The analytic surfaces among some objects.
    fn surfaces<'a>(&self, scene: &'a Scene, objects: &[u32]) -> Vec<ShownSurface<'a>> {
        let shown = |&object: &u32| {
            let extent = extent(&scene.objects[object as usize].bounds, self.field);
            let [columns, rows] = [0, 1].map(|axis: usize| match &extent {
                // One more cell on every side allows for rounding.
                Some(ends) => whole([0, 1].map(|end: usize| self.cells(ends[end][axis])), 1.0, self.size[axis]),
                None => 0..self.size[axis],
            });
            Some(ShownSurface { object, surface: scene.objects[object as usize].surface.as_ref()?, columns, rows })
        };
        objects.iter().filter_map(shown).collect()
    }
}

impl<'a> PrimaryVisibility<'a> {
    /// Returns `None` if tracing the rays is faster.
    pub fn new(specular: &'a Specular<'a>, field: &'a dyn RayField, spacing_px: f32, size: [u32; 2]) -> Option<Self> {
        let scene = specular.scene;
        let ray_count = size[0] as usize * size[1] as usize;
        let map = Map { field, spacing_px, size, room: rounding(specular, field, spacing_px)? + ROOM };
        let is_mesh = |object: &u32| scene.objects[*object as usize].surface.is_none();
        let (meshes, analytic): (Vec<u32>, Vec<u32>) = scene.specular_objects().into_iter().partition(is_mesh);
        let triangle_count: usize = meshes.iter().map(|&mesh| scene.objects[mesh as usize].triangles.len()).sum();
        if triangle_count > MAX_TRIANGLES * ray_count {
            return None;
        }
        let (triangles, surfaces) = (map.triangles(scene, &meshes), map.surfaces(scene, &analytic));
        let area = |columns: u32, rows: u32| f64::from(columns) * f64::from(rows);
        let of_triangles = triangles
            .iter()
            .map(|VisibleTriangle { columns, rows, .. }| area(columns[1] - columns[0], rows[1] - rows[0]));
        let of_surfaces =
            surfaces.iter().map(|shown| SURFACE_TESTS * area(shown.columns.len() as u32, shown.rows.len() as u32));
        if of_triangles.chain(of_surfaces).sum::<f64>() > MAX_TESTS * ray_count as f64 {
            return None;
        }
        let mut starts = vec![0u32; size[1] as usize + 1];
        for triangle in &triangles {
            for row in triangle.rows[0]..triangle.rows[1] {
                starts[row as usize + 1] += 1;
            }
        }
        for row in 0..size[1] as usize {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut of_rows = vec![0u32; starts[size[1] as usize] as usize];
        for (number, triangle) in triangles.iter().enumerate() {
            for row in triangle.rows[0]..triangle.rows[1] {
                let next = &mut next[row as usize];
                of_rows[*next as usize] = number as u32;
                *next += 1;
            }
        }
        Some(Self { scene, map, triangles, of_rows, starts, surfaces })
    }

    /// Finds the first hits of the rays of a row.
    pub fn row(&self, number: u32, row: &mut VisibilityRow) {
        let (scene, Map { field, spacing_px, size, room }) = (self.scene, self.map);
        let (low, high) = (f64::from(number) - room, f64::from(number) + room);
        let mut spans = std::mem::take(&mut row.spans);
        spans.clear();
        let of_row = self.starts[number as usize] as usize..self.starts[number as usize + 1] as usize;
        for &triangle in &self.of_rows[of_row] {
            let columns = whole(self.triangles[triangle as usize].between(low, high), room, size[0]);
            if !columns.is_empty() {
                spans.push((triangle, columns));
            }
        }
        let surfaces =
            || self.surfaces.iter().filter(|shown| shown.rows.contains(&number) && !shown.columns.is_empty());
        let all = spans.iter().map(|(_, columns)| columns).chain(surfaces().map(|shown| &shown.columns));
        let columns = all.cloned().reduce(|all, some| all.start.min(some.start)..all.end.max(some.end)).unwrap_or(0..0);
        let y_px = (number as f32 + 0.5) * spacing_px;
        row.start(columns, |column| field.ray((column as f32 + 0.5) * spacing_px, y_px));
        for (triangle, columns) in spans.drain(..) {
            let shown = &self.triangles[triangle as usize];
            let test = TriangleTest::new(scene, shown.triangle, shown.alpha_tested);
            row.meet(columns, |ray, near, far| {
                let distance = test.distance(scene, ray, near, far)?;
                Some((distance, PrimitiveHit::Triangle(shown.triangle)))
            });
        }
        for shown in surfaces() {
            row.meet(shown.columns.clone(), |ray, near, far| {
                let finite = ray.origin.is_finite() && ray.direction.is_finite();
                let distance = finite.then(|| shown.surface.first_distance(ray.origin, ray.direction, near, far))??;
                // Directions are of unit length to single precision alone.
                let exact = distance * ray.direction.as_dvec3().length();
                Some((distance as f32, PrimitiveHit::Surface { object: shown.object, distance: exact }))
            });
        }
        row.spans = spans;
    }
}

/// The polygon of a triangle's part before the eye. Returns `None` if nothing is.
pub fn polygon(
    places: [Option<[f64; 2]>; 3],
    corners: [Vec3; 3],
    place: &impl Fn(DVec3) -> Option<[f64; 2]>,
) -> Option<[[f64; 2]; 4]> {
    if let [Some(a), Some(b), Some(c)] = places {
        return Some([a, b, c, c]);
    }
    // Edges that lead behind the eye end where they are still before it, but so far away in the picture that the rest
    // is outside.
    let end = |from: usize, to: usize| {
        let (mut seen, mut unseen) = (corners[from].as_dvec3(), corners[to].as_dvec3());
        let mut last = places[from];
        for _ in 0..HALVINGS {
            let middle = (seen + unseen) * 0.5;
            match place(middle) {
                Some(at) => (seen, last) = (middle, Some(at)),
                None => unseen = middle,
            }
        }
        last
    };
    let mut found = [[0.0; 2]; 4];
    let mut count = 0;
    let mut push = |place: Option<[f64; 2]>| {
        if let (Some(place), Some(next)) = (place, found.get_mut(count)) {
            *next = place;
            count += 1;
        }
    };
    for corner in 0..3 {
        let next = (corner + 1) % 3;
        match (places[corner].is_some(), places[next].is_some()) {
            (true, true) => push(places[corner]),
            (true, false) => {
                push(places[corner]);
                push(end(corner, next));
            }
            (false, true) => push(end(next, corner)),
            (false, false) => {}
        }
    }
    let last = found[count.checked_sub(1)?];
    found[count..].fill(last);
    Some(found)
}

/// Largest distance, in cells, between points of rays and the places of the rays. Returns `None` if rays start behind
/// the eye or the error is too large for places to be of use.
fn rounding(specular: &Specular<'_>, field: &dyn RayField, spacing_px: f32) -> Option<f64> {
    let size = field.size_px();
    let far = specular.scene.bounds.diagonal().max(1e-6);
    let mut worst = 0.0;
    for [across, down] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.31, 0.57], [0.73, 0.21], [0.5, 0.5]] {
        let [x, y] = [size[0] * across, size[1] * down];
        let (ray, near) = field.ray(x, y);
        let distance = f64::from(far.max(2.0 * near));
        let place = field.place_of(ray.origin.as_dvec3() + ray.direction.as_dvec3() * distance)?;
        let error = (place[0] - f64::from(x)).abs().max((place[1] - f64::from(y)).abs()) / f64::from(spacing_px);
        // Written so that a NaN is no room.
        if !(near >= 0.0 && error <= MAX_ROOM / 8.0) {
            return None;
        }
        worst = error.max(worst);
    }
    Some(4.0 * worst)
}
