//! Welding: the rule by which vertices count as one point.

use glam::Vec3;
use rustc_hash::FxHashMap;

/// The rule by which vertices at one position are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalRule {
    /// Vertices, whatever their normals.
    Any,
    /// Vertices with equal normals.
    Equal,
    /// Vertices whose normals differ by no more than this distance from that of the first.
    Within(f64),
}

/// Positions of one object that are no further apart than this share of its box's diagonal are one: exporters round,
/// and compute both sides of a seam by different formulas (a turn's sine is not 0). Ten times what six decimals of a
/// unit object are off by.
const SAME_POSITION: f32 = 1e-5;

/// The same as a share of the median length of edges: a vertex far off makes the box large, not the mesh coarse.
const SAME_OF_EDGE: f32 = 0.02;

/// Positions are one within so many steps between neighbouring numbers at least: objects far from the origin.
const ROUNDING: f32 = 4.0;

/// The tolerance of positions of one object: what they are rounded by, or a small share of its size.
pub fn weld_tolerance(positions: impl Iterator<Item = Vec3>) -> f32 {
    let finite = positions.filter(|position| position.is_finite());
    let (low, high) = finite.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    if low.cmpgt(high).any() {
        return 0.0;
    }
    let farthest = low.abs().max(high.abs()).max_element();
    (SAME_POSITION * low.distance(high)).max(ROUNDING * f32::EPSILON * farthest)
}

/// The distance within which positions of an object are one; the triangles are given by their corners' positions.
pub fn weld_distance(triangles: impl Iterator<Item = [Vec3; 3]>) -> f32 {
    let (mut low, mut high, mut lengths) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec::new());
    for corners in triangles.filter(|corners| corners.iter().all(|corner| corner.is_finite())) {
        for k in 0..3 {
            (low, high) = (low.min(corners[k]), high.max(corners[k]));
            lengths.push(corners[k].distance(corners[(k + 1) % 3]));
        }
    }
    // Collapsed triangles, which exporters leave at poles, say nothing of the others' edges.
    lengths.retain(|length| *length > 0.0);
    if lengths.is_empty() {
        return 0.0;
    }
    let middle = lengths.len() / 2;
    let median = *lengths.select_nth_unstable_by(middle, f32::total_cmp).1;
    let farthest = low.abs().max(high.abs()).max_element();
    (SAME_POSITION * low.distance(high)).min(SAME_OF_EDGE * median).max(ROUNDING * f32::EPSILON * farthest)
}

/// Numbers vertices in the order in which they are given: one number for all that are one.
#[derive(Clone, Debug)]
pub struct Welder {
    rule: NormalRule,
    /// Positions no further apart are one; those alone that are equal if it is 0.
    distance: f32,
    /// The last number in each cell of a grid.
    last_in: FxHashMap<[i32; 3], u32>,
    members: Vec<WeldMember>,
}

/// The first vertex of a number.
#[derive(Clone, Copy, Debug)]
struct WeldMember {
    position: Vec3,
    normal: Vec3,
    /// The number before it in the same cell of the grid.
    before: u32,
}

/// The end of the numbers in a cell.
const NONE: u32 = u32::MAX;

/// Cells of the grid, in distances within which positions are one: few of them have neighbours that near.
const CELL: f32 = 16.0;

impl Welder {
    /// Without vertices; positions no further apart than `distance` are one.
    pub fn new(rule: NormalRule, distance: f32) -> Self {
        Self { rule, distance, last_in: FxHashMap::default(), members: Vec::new() }
    }

    /// The number of a vertex: that of the earliest one that it is one with, else the next.
    pub fn number(&mut self, position: Vec3, normal: Vec3) -> u32 {
        if !position.is_finite() {
            self.members.push(WeldMember { position, normal, before: NONE });
            return self.count() - 1;
        }
        let [low, high] = [position - self.distance, position + self.distance].map(|corner| self.cell(corner));
        let mut number = NONE;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    number = number.min(self.earliest([x, y, z], position, normal));
                }
            }
        }
        if number != NONE {
            return number;
        }
        let next = self.count();
        let last = self.last_in.entry(self.cell(position)).or_insert(NONE);
        self.members.push(WeldMember { position, normal, before: *last });
        *last = next;
        next
    }

    /// The cell of a position: of the grid, or of its own.
    fn cell(&self, position: Vec3) -> [i32; 3] {
        if self.distance > 0.0 {
            // Positions are at most 2^22 distances away ([`weld_distance`]); others share the outermost cells.
            position.to_array().map(|x| (x / (CELL * self.distance)).floor() as i32)
        } else {
            // Bit for bit, but for the sign of zeros.
            (position + Vec3::ZERO).to_array().map(|x| x.to_bits() as i32)
        }
    }

    /// The earliest number of a cell that a vertex is one with, or [`NONE`].
    fn earliest(&self, cell: [i32; 3], position: Vec3, normal: Vec3) -> u32 {
        let mut earliest = NONE;
        let mut number = self.last_in.get(&cell).copied().unwrap_or(NONE);
        while let Some(member) = self.members.get(number as usize) {
            let is_one = match self.rule {
                NormalRule::Any => true,
                NormalRule::Equal => member.normal == normal,
                NormalRule::Within(distance) => member.normal.distance_squared(normal) <= (distance * distance) as f32,
            };
            if is_one && member.position.distance_squared(position) <= self.distance * self.distance {
                earliest = number;
            }
            number = member.before;
        }
        earliest
    }

    /// The number of different vertices.
    pub fn count(&self) -> u32 {
        self.members.len() as u32
    }
}

/// Vertices with their numbers.
#[derive(Clone, Debug)]
pub struct WeldedVertices {
    /// The number of each vertex.
    pub numbers: Vec<u32>,
    /// The first vertex of each number.
    pub firsts: Vec<u32>,
}

impl WeldedVertices {
    /// Welds vertices by their positions, one within `distance`, and normals.
    pub fn new(positions: &[Vec3], normals: &[Vec3], rule: NormalRule, distance: f32) -> Self {
        let mut welder = Welder::new(rule, distance);
        welder.last_in.reserve(positions.len());
        let mut firsts = Vec::new();
        let number = |(vertex, (position, normal)): (usize, (&Vec3, &Vec3))| {
            let number = welder.number(*position, *normal);
            if number as usize == firsts.len() {
                firsts.push(vertex as u32);
            }
            number
        };
        let numbers = positions.iter().zip(normals).enumerate().map(number).collect();
        Self { numbers, firsts }
    }
}
