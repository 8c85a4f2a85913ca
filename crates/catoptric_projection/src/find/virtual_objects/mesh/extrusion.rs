//! Linear extrusions: reflectors whose surface runs along one axis, so that their profile determines all (Ofek,
//! Rappoport 1998).

use crate::find::virtual_objects::piece::weights_of;
use catoptric_core::surface::mesh::convexity::MeshShape;
use glam::{Vec2, Vec3};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Normals across the axis may lean along it by this much: those of files are rounded. Chosen, not measured.
const LEANING: f32 = 2e-3;

/// Two normals whose sine is below this determine no axis. Chosen, not measured.
const MIN_TURN: f32 = 0.01;

/// Places of the profile nearer than this share of the radius are one. Chosen, not measured.
const SAME: f32 = 1e-5;

/// The rounding of positions, as a share of their size. About eight roundings of single precision.
const ROUNDING: f32 = 1e-6;

/// A place is within a segment if it is this far from its ends, as a share of its length. Chosen, not measured.
const WITHIN: f32 = 1e-2;

/// Profiles with more segments than this are left to maps. A bound on time; chosen, not measured.
const MAX_SEGMENTS: usize = 2048;

/// A triangle may be this much outside to hold a place all the same, in its weights. Chosen, not measured.
const OUTSIDE: f32 = 1e-3;

/// A reflector as a profile that is drawn along an axis.
#[derive(Clone, Debug)]
pub struct Extrusion {
    /// A unit vector, and two across it.
    axis: Vec3,
    across: [Vec3; 2],
    pub(crate) segments: Vec<ProfileSegment>,
    /// The triangles above all segments with the heights at which they begin, segment by segment, the lowest first.
    triangles: Vec<(f32, u32)>,
    /// The height of the tallest triangle along the axis.
    tallest: f32,
}

/// A straight part of the profile.
#[derive(Clone, Debug)]
pub(crate) struct ProfileSegment {
    /// A vertex of the mesh at each end.
    pub(crate) vertices: [u32; 2],
    /// True if no other segment goes on at an end.
    pub(crate) open: [bool; 2],
    /// The range of its triangles in the list of all.
    triangles: std::ops::Range<usize>,
}

impl Extrusion {
    /// The profile of a mesh in a ball (its centre and radius); returns `None` if it is no extrusion, or flat, or its
    /// profile is too long.
    pub(super) fn new(mesh: MeshShape<'_>, ball: (Vec3, f32)) -> Option<Self> {
        let axis = axis_of(mesh)?;
        let (right, down) = axis.any_orthonormal_pair();
        let mut extrusion =
            Self { axis, across: [right, down], segments: Vec::new(), triangles: Vec::new(), tallest: 0.0 };
        let corners = ProfileVertices::new(mesh, ball, &extrusion);
        let mut above: BTreeMap<[u32; 2], Above> = BTreeMap::new();
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let Some(sides) = corners.sides(triangle) else { continue };
            let heights = triangle.map(|vertex| extrusion.height(mesh.positions[vertex as usize]));
            let low = heights.into_iter().fold(f32::INFINITY, f32::min);
            let high = heights.into_iter().fold(f32::NEG_INFINITY, f32::max);
            extrusion.tallest = extrusion.tallest.max(high - low);
            for (key, vertices) in sides {
                let segment = above.entry(key).or_insert_with(|| Above { vertices, triangles: Vec::new() });
                segment.triangles.push((low, index as u32));
            }
        }
        corners.keep_shortest(&mut above);
        if above.is_empty() || above.len() > MAX_SEGMENTS {
            return None;
        }
        let mut ends: HashMap<u32, u32> = HashMap::new();
        for end in above.keys().flatten() {
            *ends.entry(*end).or_default() += 1;
        }
        for (key, mut segment) in above {
            let start = extrusion.triangles.len();
            segment.triangles.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            extrusion.triangles.extend(segment.triangles);
            extrusion.segments.push(ProfileSegment {
                vertices: segment.vertices,
                open: key.map(|end| ends[&end] == 1),
                triangles: start..extrusion.triangles.len(),
            });
        }
        Some(extrusion)
    }

    /// A point or direction in the plane of the profile.
    #[inline]
    pub(crate) fn flattened(&self, vector: Vec3) -> Vec2 {
        Vec2::new(self.across[0].dot(vector), self.across[1].dot(vector))
    }

    /// Coordinate of a point or direction along the axis.
    #[inline]
    pub(crate) fn height(&self, vector: Vec3) -> f32 {
        self.axis.dot(vector)
    }

    /// The triangle of a segment at a place of the profile and a height, or the one next to it, and the weights there.
    pub(crate) fn triangle_at(
        &self,
        mesh: MeshShape<'_>,
        segment: &ProfileSegment,
        place: Vec2,
        height: f32,
    ) -> Option<(u32, Vec2)> {
        let position = self.across[0] * place.x + self.across[1] * place.y + self.axis * height;
        let all = &self.triangles[segment.triangles.clone()];
        let end = all.partition_point(|(low, _)| *low <= height);
        let start = all.partition_point(|(low, _)| *low < height - self.tallest);
        // Below and above all of them, the ends.
        let (start, end) = if start < end { (start, end) } else { (start.saturating_sub(2), (end + 2).min(all.len())) };
        let mut best: Option<(f32, u32, Vec2)> = None;
        for (_, triangle) in &all[start..end] {
            let corners = mesh.triangles[*triangle as usize].map(|vertex| mesh.positions[vertex as usize]);
            let weights = weights_of(corners, position);
            let inside = weights.x.min(weights.y).min(1.0 - weights.x - weights.y);
            if best.is_none_or(|(most, ..)| inside > most) {
                best = Some((inside, *triangle, weights));
            }
            if inside > -OUTSIDE {
                break;
            }
        }
        best.map(|(_, triangle, weights)| (triangle, weights))
    }
}

/// The triangles above a segment.
struct Above {
    vertices: [u32; 2],
    triangles: Vec<(f32, u32)>,
}

/// The axis that all normals and faces are across; returns `None` if there is none or more than one.
fn axis_of(mesh: MeshShape<'_>) -> Option<Vec3> {
    let first = *mesh.normals.first()?;
    let turned = mesh.normals.iter().map(|normal| first.cross(*normal));
    let most = turned.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let axis = (most.length() > MIN_TURN).then(|| most.normalize())?;
    let is_across = |normal: Vec3| normal.dot(axis).abs() <= LEANING;
    let face = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let all = mesh.normals.iter().all(|normal| is_across(*normal))
        && mesh.triangles.iter().all(|triangle| is_across(face(triangle)));
    all.then_some(axis)
}

/// The vertices of a mesh in the plane of its profile, with those in one place united.
struct ProfileVertices {
    places: Vec<Vec2>,
    /// The place of each vertex.
    place_of: Vec<u32>,
    same: f32,
}

impl ProfileVertices {
    fn new(mesh: MeshShape<'_>, (center, radius): (Vec3, f32), extrusion: &Extrusion) -> Self {
        // The tolerance is no less than the rounding of positions.
        let same = SAME * radius + ROUNDING * center.length();
        let mut corners = Self { places: Vec::new(), place_of: Vec::with_capacity(mesh.positions.len()), same };
        // Squares of the plane with the places in them: a place next to a border is looked for beyond it, too.
        let mut squares: HashMap<[i64; 2], Vec<u32>> = HashMap::new();
        let square =
            |place: Vec2| [place.x, place.y].map(|at| (f64::from(at) / (4.0 * f64::from(same))).floor() as i64);
        for position in mesh.positions {
            let place = extrusion.flattened(*position);
            let [x, y] = square(place);
            let near = |number: &u32| corners.places[*number as usize].distance(place) <= same;
            let around = [-1, 0, 1].into_iter().flat_map(|dx| [-1, 0, 1].map(|dy| [x + dx, y + dy]));
            let known = around.filter_map(|key| squares.get(&key)).flatten().copied().find(near);
            let number = known.unwrap_or_else(|| {
                corners.places.push(place);
                let number = corners.places.len() as u32 - 1;
                squares.entry([x, y]).or_default().push(number);
                number
            });
            corners.place_of.push(number);
        }
        corners
    }

    /// The parts of the profile below a triangle, by their ends in order, with a vertex at each; none for triangles
    /// that stand on one place.
    fn sides(&self, triangle: &[u32; 3]) -> Option<Vec<([u32; 2], [u32; 2])>> {
        let places = triangle.map(|vertex| self.place_of[vertex as usize]);
        let at = |k: usize| self.places[places[k] as usize];
        let longest = (0..3).max_by(|a, b| {
            let length = |k: usize| at((k + 1) % 3).distance_squared(at((k + 2) % 3));
            length(*a).total_cmp(&length(*b))
        })?;
        let (from, to) = ((longest + 1) % 3, (longest + 2) % 3);
        let part = |a: usize, b: usize| {
            let ordered = places[a] < places[b];
            let (a, b) = if ordered { (a, b) } else { (b, a) };
            ([places[a], places[b]], [triangle[a], triangle[b]])
        };
        let middle = places[longest];
        if places[from] == places[to] {
            None
        } else if middle == places[from] || middle == places[to] {
            Some(vec![part(from, to)])
        } else {
            Some(vec![part(from, longest), part(longest, to)])
        }
    }

    /// Leaves out segments on which other places lie: shorter ones are there, too. Their triangles go to these.
    fn keep_shortest(&self, above: &mut BTreeMap<[u32; 2], Above>) {
        if above.len() > MAX_SEGMENTS {
            return;
        }
        let used: HashSet<u32> = above.keys().flatten().copied().collect();
        let used: Vec<u32> = {
            let mut used: Vec<u32> = used.into_iter().collect();
            used.sort_unstable();
            used
        };
        let holds = |key: &[u32; 2], other: u32| {
            let [a, b] = key.map(|place| self.places[place as usize]);
            let (edge, from) = (b - a, self.places[other as usize] - a);
            let share = from.dot(edge) / edge.length_squared();
            share > WITHIN && share < 1.0 - WITHIN && edge.perp_dot(from).abs() <= self.same * 2.0 * edge.length()
        };
        let long: Vec<[u32; 2]> =
            above.keys().filter(|key| used.iter().any(|other| holds(key, *other))).copied().collect();
        for key in long {
            let Some(left_out) = above.remove(&key) else { continue };
            for (other, segment) in above.iter_mut() {
                let is_part = other.iter().all(|place| key.contains(place) || holds(&key, *place));
                if is_part {
                    segment.triangles.extend(left_out.triangles.iter().copied());
                }
            }
        }
        for segment in above.values_mut() {
            segment.triangles.sort_by_key(|(_, triangle)| *triangle);
            segment.triangles.dedup_by_key(|(_, triangle)| *triangle);
        }
    }
}
