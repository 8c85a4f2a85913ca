//! Faces of different objects in one place, as of a label in the plane of a pane: one of the two is moved off the other
//! by a hair, so that every method and every ray agrees on what is seen.
//!
//! Cut-outs and veils lie before what is opaque or a mirror, that before thin panes, and all of them before bodies of
//! glass; of equals the smaller object. What is stuck onto a face is seen from there, and under a glass that stands on
//! something is a film of air, as there is. Faces of two bodies of glass stay: they are one interface for rays.
//!
//! Bodies of glass move, inwards; of others what lies before: so no gaps open beside faces that meet their neighbours.

use super::super::enclosure::FaceSums;
use super::super::{AlphaMode, Material, Object, Scene};
use crate::math::Aabb;
use crate::surface::{AnalyticSurface, PlacedSurface};
use glam::{Vec2, Vec3};
use std::cmp::Reverse;
use std::collections::HashMap;

/// Faces are in one place that lie nearer than this share of their coordinates: a little more than what rays jump where
/// they leave a surface.
const TOLERANCE: f32 = 24.0 * f32::EPSILON;

/// How far a face is moved off another one, as the same share: more than what rays to lights jump, too.
const GAP: f32 = 64.0 * f32::EPSILON;

/// The same of a body of glass, and of its thickness at most: methods that follow many rays by one look for what comes
/// after it from about there on.
const FILM: f32 = 5e-4;
const FILM_OF_THICKNESS: f32 = 0.02;

/// The most faces in one place that are all told apart.
const MOST_GAPS: f32 = 8.0;

/// Triangles whose boxes are looked at together.
const BLOCK: usize = 64;

/// Pairs of boxes that are compared, at most, in the order of objects: more would take too long. What is left stays
/// where it is.
const MOST_COMPARED: usize = 60_000_000;

/// A comparison of two triangles takes as long as so many of boxes.
const OF_TRIANGLES: usize = 10;

/// Faces are parallel whose normals have this cosine at least. Between faces without a plane in common by their corners
/// it is never reached.
const PARALLEL: f32 = 0.999;

/// Normals lie between two axes whose parts along them differ by less than this factor: more than parallel ones do.
const BETWEEN_AXES: f32 = 0.9;

/// Faces that overlap by less than this share of the smaller one's size lie beside each other.
const OVERLAP: f32 = 1e-3;

/// Triangles of two objects in one place: each a triangle of the first object and one of the second, by their numbers
/// within them.
#[derive(Clone, Debug)]
pub(super) struct CoincidentFaces {
    /// The first is the smaller number.
    objects: [u32; 2],
    triangles: Vec<[u32; 2]>,
}

/// Moves faces of a scene off faces of other objects in the same place. `is_new` tells whether an object has moved
/// since `known` were found; those of this moment take their place.
pub(super) fn separate(scene: &mut Scene, is_new: impl Fn(&u32) -> bool, known: &mut Vec<CoincidentFaces>) {
    known.retain(|faces| !faces.objects.iter().any(&is_new));
    Search::new(scene).find(is_new, known);
    known.sort_unstable_by_key(|faces| faces.objects);
    if !known.is_empty() {
        move_apart(scene, known);
    }
}

/// A triangle's plane, on the side of its vertices' normals.
#[derive(Clone, Copy)]
struct Face {
    corners: [Vec3; 3],
    normal: Vec3,
    double_area: f32,
    /// The largest coordinate of its corners.
    size: f32,
}

impl Face {
    /// `None` for triangles without area.
    fn new(scene: &Scene, triangle: u32) -> Option<Self> {
        let vertices = scene.triangles[triangle as usize].map(|vertex| vertex as usize);
        let corners = vertices.map(|vertex| scene.positions[vertex]);
        let [a, b, c] = corners;
        let area = (b - a).cross(c - a);
        let outwards: Vec3 = vertices.iter().map(|vertex| scene.normals[*vertex]).sum();
        let normal = area.try_normalize()?;
        let normal = if normal.dot(outwards) < 0.0 { -normal } else { normal };
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        Some(Self { corners, normal, double_area: area.length(), size })
    }

    /// Returns true if a part of both is in one place.
    fn coincides(&self, other: &Self) -> bool {
        let [smaller, larger] = if self.double_area <= other.double_area { [self, other] } else { [other, self] };
        let tolerance = TOLERANCE * self.size.max(other.size);
        let is_near = |corner: &Vec3| (*corner - larger.corners[0]).dot(larger.normal).abs() <= tolerance;
        self.normal.dot(other.normal).abs() >= PARALLEL
            && smaller.corners.iter().all(is_near)
            && smaller.overlaps(larger, tolerance)
    }

    /// Returns true if both overlap as they are seen along their normal (by the theorem of separating axes).
    fn overlaps(&self, other: &Self, tolerance: f32) -> bool {
        let (x, y) = other.normal.any_orthonormal_pair();
        let flat = |face: &Self| face.corners.map(|corner| Vec2::new(corner.dot(x), corner.dot(y)));
        let [own, others] = [flat(self), flat(other)];
        let edges = |corners: [Vec2; 3]| [0, 1, 2].map(|index| corners[(index + 1) % 3] - corners[index]);
        let longest = edges(own).iter().map(|edge| edge.length()).fold(0.0, f32::max);
        let least = (OVERLAP * longest).max(4.0 * tolerance);
        edges(own).into_iter().chain(edges(others)).all(|edge| {
            let Some(across) = edge.perp().try_normalize() else { return false };
            let extent = |corners: &[Vec2; 3]| {
                let [a, b, c] = corners.map(|corner| corner.dot(across));
                (a.min(b).min(c), a.max(b).max(c))
            };
            let [(own_least, own_most), (least_of_other, most_of_other)] = [extent(&own), extent(&others)];
            own_most.min(most_of_other) - own_least.max(least_of_other) > least
        })
    }
}

/// Finds faces in one place.
struct Search<'a> {
    scene: &'a Scene,
    /// The boxes of blocks of triangles, for each object that was asked for.
    blocks: HashMap<u32, Vec<Aabb>>,
    compared: usize,
}

impl<'a> Search<'a> {
    fn new(scene: &'a Scene) -> Self {
        Self { scene, blocks: HashMap::new(), compared: 0 }
    }

    /// Adds those of all pairs of objects one of which is new.
    fn find(&mut self, is_new: impl Fn(&u32) -> bool, found: &mut Vec<CoincidentFaces>) {
        let objects = &self.scene.objects;
        // Two of the same kind both stay where they are.
        let kind = |object: &Object| match rank(&self.scene.materials[object.material as usize]) {
            0 => (0, 0),
            rank => (rank, object.material),
        };
        let mut boxes: Vec<(u32, (u8, u32), Aabb)> =
            (0..).zip(objects).map(|(index, object)| (index, kind(object), widened(object.bounds))).collect();
        boxes.sort_unstable_by(|(a, _, one), (b, _, other)| one.min.x.total_cmp(&other.min.x).then(a.cmp(b)));
        for (index, (first, of_one, one)) in boxes.iter().enumerate() {
            for (second, of_other, other) in boxes[index + 1..].iter().take_while(|(_, _, it)| it.min.x <= one.max.x) {
                self.compared += 1;
                if self.compared > MOST_COMPARED {
                    return;
                }
                if of_one == of_other {
                    continue;
                }
                let common = common(one, other);
                if common.is_empty() || !(is_new(first) || is_new(second)) {
                    continue;
                }
                let objects = [*first.min(second), *first.max(second)];
                let triangles = self.of_pair(objects, &common);
                if !triangles.is_empty() {
                    found.push(CoincidentFaces { objects, triangles });
                }
            }
        }
    }

    /// The triangles of a pair of objects that are in one place, within a box that holds what both have in common.
    fn of_pair(&mut self, objects: [u32; 2], within: &Aabb) -> Vec<[u32; 2]> {
        let Some(first) = self.within(objects[0], within) else { return Vec::new() };
        let Some(second) = self.within(objects[1], within) else { return Vec::new() };
        let mut found = Vec::new();
        // By the axis that is nearest to the normal, along which faces are thin; between two axes by both.
        for axis in 0..3 {
            let [first, second] = [&first, &second].map(|faces| along(self.scene, faces, axis));
            let mut begin = 0;
            let longest = second.iter().map(|(_, bounds)| bounds.size()[axis]).fold(0.0, f32::max);
            for (own, bounds) in &first {
                while second.get(begin).is_some_and(|(_, other)| other.min[axis] + longest < bounds.min[axis]) {
                    begin += 1;
                }
                let reached = second[begin..].iter().take_while(|(_, others)| others.min[axis] <= bounds.max[axis]);
                for (other, others) in reached {
                    self.compared += 1;
                    if self.compared > MOST_COMPARED {
                        return found;
                    }
                    if common(bounds, others).is_empty() {
                        continue;
                    }
                    self.compared += OF_TRIANGLES;
                    let faces = [*own, *other].map(|triangle| Face::new(self.scene, triangle));
                    if let [Some(face), Some(of_other)] = faces
                        && face.coincides(&of_other)
                    {
                        let starts = objects.map(|object| self.scene.objects[object as usize].triangles.start);
                        found.push([own - starts[0], other - starts[1]]);
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The triangles of an object that reach into a box, with their boxes; `None` if there are none.
    fn within(&mut self, object: u32, within: &Aabb) -> Option<Vec<(u32, Aabb)>> {
        let scene = self.scene;
        let Object { triangles, .. } = &scene.objects[object as usize];
        let blocks = self.blocks.entry(object).or_insert_with(|| {
            let triangles: Vec<u32> = triangles.clone().collect();
            triangles.chunks(BLOCK).map(|block| around(block.iter().map(|triangle| bounds(scene, *triangle)))).collect()
        });
        self.compared += blocks.len();
        let mut found = Vec::new();
        for (number, _) in blocks.iter().enumerate().filter(|(_, block)| !common(block, within).is_empty()) {
            let start = triangles.start + (number * BLOCK) as u32;
            let block = start..(start + BLOCK as u32).min(triangles.end);
            self.compared += block.len();
            let of_block = block.map(|triangle| (triangle, bounds(scene, triangle)));
            found.extend(of_block.filter(|(_, bounds)| !common(bounds, within).is_empty()));
        }
        (!found.is_empty()).then_some(found)
    }
}

fn around(boxes: impl Iterator<Item = Aabb>) -> Aabb {
    boxes.fold(Aabb::EMPTY, Aabb::union)
}

/// A box grown by as much as faces in one place may lie apart.
fn widened(Aabb { min, max }: Aabb) -> Aabb {
    let reach = TOLERANCE * min.abs().max(max.abs()).max_element();
    Aabb { min: min - reach, max: max + reach }
}

/// The widened box of a triangle.
fn bounds(scene: &Scene, triangle: u32) -> Aabb {
    let corners = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
    widened(Aabb::around(corners))
}

fn common(one: &Aabb, other: &Aabb) -> Aabb {
    Aabb { min: one.min.max(other.min), max: one.max.min(other.max) }
}

/// The triangles whose normals are about as near to an axis as to any other, in their order along it.
fn along(scene: &Scene, triangles: &[(u32, Aabb)], axis: usize) -> Vec<(u32, Aabb)> {
    let is_near = |(triangle, _): &&(u32, Aabb)| {
        Face::new(scene, *triangle).is_some_and(|face| {
            let normal = face.normal.abs();
            normal[axis] >= BETWEEN_AXES * normal.max_element()
        })
    };
    let mut along: Vec<(u32, Aabb)> = triangles.iter().filter(is_near).copied().collect();
    along.sort_unstable_by(|(a, one), (b, other)| one.min[axis].total_cmp(&other.min[axis]).then(a.cmp(b)));
    along
}

/// How surely a surface lies before another one in the same place.
fn rank(material: &Material) -> u8 {
    if material.has_inside() {
        0
    } else if material.alpha_mode != AlphaMode::Opaque {
        3
    } else if material.lobes().is_some_and(|lobes| lobes.transmission > 0.0) {
        1
    } else {
        2
    }
}

/// Which of a pair of objects lies behind the other one, by its place there; `None` if both stay.
fn behind(scene: &Scene, pair: [u32; 2]) -> Option<usize> {
    let [first, second] = pair.map(|object| scene.material_of(object));
    let [one, other] = [rank(first), rank(second)];
    if one != other {
        return Some(usize::from(other < one));
    }
    let is_same = scene.objects[pair[0] as usize].material == scene.objects[pair[1] as usize].material;
    let [size, of_other] = pair.map(|object| scene.objects[object as usize].bounds.diagonal());
    (one > 0 && !is_same).then_some(usize::from(of_other > size))
}

/// Ways of a vertex, each a direction and a distance.
type Ways = Vec<(Vec3, f32)>;

/// Moves faces apart.
struct Apart<'a> {
    scene: &'a Scene,
    /// The sums over faces of the objects that were asked for.
    sums: HashMap<u32, FaceSums>,
    /// How far each triangle that lies before others is moved.
    distances: HashMap<u32, f32>,
    ways: HashMap<u32, Ways>,
}

impl Apart<'_> {
    fn sums(&mut self, object: u32) -> FaceSums {
        *self.sums.entry(object).or_insert_with(|| FaceSums::default().with(self.scene, object))
    }

    /// Adds the way of one of two triangles of a pair of objects, of which the one at the place `behind` lies behind.
    fn add(&mut self, objects: [u32; 2], behind: usize, triangles: [u32; 2]) {
        let [Some(first), Some(second)] = triangles.map(|triangle| Face::new(self.scene, triangle)) else { return };
        let Some((place, direction)) = self.way(objects, behind, [&first, &second]) else { return };
        let size = first.size.max(second.size);
        let [moved, resting] = [triangles[place], triangles[1 - place]];
        let distance = if place == behind {
            self.gap(objects[behind], size)
        } else {
            let of_resting = self.distances.get(&resting).copied().unwrap_or(0.0);
            let distance = (of_resting + GAP * size).min(MOST_GAPS * GAP * size);
            let known = self.distances.entry(moved).or_default();
            *known = distance.max(*known);
            *known
        };
        for vertex in self.scene.triangles[moved as usize] {
            add_way(self.ways.entry(vertex).or_default(), direction, distance);
        }
    }

    /// The place of the object that moves in a pair, and where to; `None` if the faces may stay.
    fn way(&mut self, pair: [u32; 2], behind: usize, faces: [&Face; 2]) -> Option<(usize, Vec3)> {
        let before = 1 - behind;
        let materials = pair.map(|object| self.scene.material_of(object));
        // Exact surfaces stay where they are, and only plane ones are told apart from triangles.
        let surfaces = pair.map(|object| self.scene.objects[object as usize].surface.as_ref());
        let is_plane = |surface: &PlacedSurface| matches!(surface.surface, AnalyticSurface::Plane { .. });
        if surfaces.iter().flatten().any(|surface| !is_plane(surface)) || surfaces.iter().all(Option::is_some) {
            return None;
        }
        let is_body = rank(materials[behind]) == 0;
        let is_facing = !is_body && faces[0].normal.dot(faces[1].normal) < 0.0;
        let is_one_sided = materials[before].is_one_sided();
        // Each is seen from a side of its own, or the inner side of what lies before is hidden by itself.
        let are_both = is_one_sided && materials[behind].is_one_sided();
        if is_facing && (are_both || !self.sums(pair[before]).are_open()) {
            return None;
        }
        let direction = if is_facing && is_one_sided { -faces[behind].normal } else { faces[behind].normal };
        let moves_back = surfaces[before].is_some() || is_body && surfaces[behind].is_none();
        Some(if moves_back { (behind, -direction) } else { (before, direction) })
    }

    /// How far an object's faces are moved back, whose coordinates are so large.
    fn gap(&mut self, object: u32, size: f32) -> f32 {
        let thickness = self.sums(object).thickness() as f32;
        (FILM * size).min(FILM_OF_THICKNESS * thickness).max(GAP * size)
    }
}

fn move_apart(scene: &mut Scene, coincident: &[CoincidentFaces]) {
    let mut pairs: Vec<(usize, &CoincidentFaces)> =
        coincident.iter().filter_map(|faces| Some((behind(scene, faces.objects)?, faces))).collect();
    // Faces behind others come first.
    let order = |object: u32| {
        let of = &scene.objects[object as usize];
        (rank(scene.material_of(object)), Reverse(of.bounds.diagonal().to_bits()), object)
    };
    pairs.sort_by_key(|(behind, faces)| order(faces.objects[*behind]));
    let mut apart = Apart { scene, sums: HashMap::new(), distances: HashMap::new(), ways: HashMap::new() };
    for (behind, CoincidentFaces { objects, triangles }) in pairs {
        let starts = objects.map(|object| scene.objects[object as usize].triangles.start);
        for [one, other] in triangles {
            apart.add(*objects, behind, [starts[0] + one, starts[1] + other]);
        }
    }
    let ways = apart.ways;
    move_vertices(scene, &ways);
}

/// Adds a way, or makes that in the same direction as long.
fn add_way(ways: &mut Ways, direction: Vec3, distance: f32) {
    match ways.iter_mut().find(|(known, _)| known.dot(direction) > PARALLEL) {
        Some((_, known)) => *known = known.max(distance),
        None => ways.push((direction, distance)),
    }
}

/// The shortest way, or little more, that leads as far as each of several ways in its direction.
fn together(ways: &Ways) -> Vec3 {
    ways.iter()
        .fold(Vec3::ZERO, |way, (direction, distance)| way + *direction * (distance - way.dot(*direction)).max(0.0))
}

/// Moves vertices, and those of the same object in the same places: so nothing is torn open.
fn move_vertices(scene: &mut Scene, ways: &HashMap<u32, Ways>) {
    let bits = |position: Vec3| position.to_array().map(f32::to_bits);
    let mut vertices: Vec<u32> = ways.keys().copied().collect();
    vertices.sort_unstable();
    let mut begin = 0;
    for index in 0..scene.objects.len() {
        let of_object = scene.objects[index].vertices.clone();
        let count = vertices[begin..].partition_point(|vertex| *vertex < of_object.end);
        let moved = &vertices[begin..begin + count];
        begin += count;
        if moved.is_empty() {
            continue;
        }
        let mut by_place: HashMap<[u32; 3], Ways> = HashMap::new();
        for vertex in moved {
            let of_place = by_place.entry(bits(scene.positions[*vertex as usize])).or_default();
            ways[vertex].iter().for_each(|(direction, distance)| add_way(of_place, *direction, *distance));
        }
        let mut bounds = scene.objects[index].bounds;
        for vertex in of_object {
            let position = &mut scene.positions[vertex as usize];
            if let Some(ways) = by_place.get(&bits(*position)) {
                *position += together(ways);
                bounds = bounds.with(*position);
            }
        }
        scene.objects[index].bounds = bounds;
        scene.bounds = scene.bounds.union(bounds);
    }
}
