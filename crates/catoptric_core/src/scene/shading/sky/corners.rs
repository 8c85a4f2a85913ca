//! The light that arrives at the corners of a scene's triangles.

use super::super::super::{Material, Scene};
use super::gather::{GROUPS, Gathered, Sample, near};
use crate::math::random;
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Corners that look in all directions, at most; more of them share the same rays, each in other directions than its
/// neighbours.
const MOST_CORNERS: usize = 16_000;

/// Corners at which anything is sought, at most; others have what their neighbours have.
const MOST_PLACES: usize = 16 * MOST_CORNERS;

/// Returns true if light from infinity on a surface is seen.
pub(super) fn is_lit(material: &Material) -> bool {
    !material.unlit
}

/// The corners of triangles whose light is seen.
pub(super) struct Corners {
    corners: Vec<Corner>,
    /// The corner of each vertex; `u32::MAX` for those that nothing needs.
    of_vertex: Vec<u32>,
    /// The triangles at the corners, those of a corner after each other.
    triangles: Vec<u32>,
}

/// A corner of triangles: vertices of one position and normal.
struct Corner {
    position: Vec3,
    normal: Vec3,
    /// The first of its triangles in the list of all of them.
    first: usize,
    count: usize,
}

impl Corners {
    pub(super) fn count(&self) -> usize {
        self.corners.len()
    }

    /// Returns true if what arrives at a corner is known from rays of its own, not from its neighbours', too.
    pub(super) fn are_apart(&self) -> bool {
        self.count() <= MOST_CORNERS
    }

    /// The position and normal of a corner.
    pub(super) fn place(&self, corner: usize) -> (Vec3, Vec3) {
        (self.corners[corner].position, self.corners[corner].normal)
    }

    /// The corner of a vertex; `u32::MAX` for those that nothing needs.
    pub(super) fn of_vertex(&self, vertex: u32) -> u32 {
        self.of_vertex[vertex as usize]
    }

    /// A point near a corner in one of its triangles, no further from it than a distance or than a part of the sides.
    pub(super) fn sample(&self, scene: &Scene, corner: usize, number: usize, within: (f32, f32)) -> (u32, Vec2) {
        let Corner { first, count, .. } = self.corners[corner];
        let key = random::mix(corner as u64);
        let triangle = self.triangles[first + (number + (key >> 32) as usize) % count];
        let vertices = scene.triangles[triangle as usize];
        let is_here = |vertex: &u32| self.of_vertex[*vertex as usize] as usize == corner;
        let at = [Vec2::ZERO, Vec2::X, Vec2::Y][vertices.iter().position(is_here).unwrap_or(0)];
        let number = (key >> 16) as u32 % 4096 + number as u32;
        (triangle, near(at, number, reach(scene, triangle, within)))
    }

    /// The samples of the corners: at points of their triangles within a distance and a part of the sides.
    pub(super) fn samples(&self, within: (f32, f32)) -> CornerSamples<'_> {
        let all = self.count();
        // As many each as all of them may have, and where those are too few, for some of the corners only.
        let each = (MOST_CORNERS * GROUPS).checked_div(all).unwrap_or(1).clamp(1, GROUPS);
        let every = all.div_ceil(MOST_PLACES).max(1);
        let rounds = (GROUPS / each * every).ilog2();
        let same = if rounds > 0 { self.at_same_positions() } else { Vec::new() };
        CornerSamples { corners: self, within, each, every, rounds, same }
    }

    /// Finds the corners of a scene.
    pub(super) fn new(scene: &Scene) -> Self {
        let mut of_vertex = vec![u32::MAX; scene.positions.len()];
        let mut corners: Vec<Corner> = Vec::new();
        let mut known: HashMap<[[u32; 3]; 2], u32> = HashMap::new();
        let lit = || {
            let is_lit = |triangle: &usize| is_lit(scene.material_of(scene.triangle_objects[*triangle]));
            (0..scene.triangles.len()).filter(is_lit)
        };
        for vertex in lit().flat_map(|triangle| scene.triangles[triangle]) {
            let vertex = vertex as usize;
            if of_vertex[vertex] == u32::MAX {
                let (position, normal) = (scene.positions[vertex], scene.normals[vertex]);
                let bits = [position, normal].map(|vector| vector.to_array().map(f32::to_bits));
                of_vertex[vertex] = *known.entry(bits).or_insert_with(|| {
                    corners.push(Corner { position, normal, first: 0, count: 0 });
                    corners.len() as u32 - 1
                });
            }
            corners[of_vertex[vertex] as usize].count += 1;
        }
        let mut count = 0;
        for corner in &mut corners {
            corner.first = count;
            count += std::mem::take(&mut corner.count);
        }
        let mut triangles = vec![0; count];
        for triangle in lit() {
            for vertex in scene.triangles[triangle] {
                let corner = &mut corners[of_vertex[vertex as usize] as usize];
                triangles[corner.first + corner.count] = triangle as u32;
                corner.count += 1;
            }
        }
        Self { corners, of_vertex, triangles }
    }

    /// Pairs of corners at the same position, whose normals differ, as at flat triangles.
    fn at_same_positions(&self) -> Vec<[u32; 2]> {
        let position = |corner: u32| self.corners[corner as usize].position.to_array().map(f32::to_bits);
        let mut by_position: Vec<u32> = (0..self.count() as u32).collect();
        by_position.sort_unstable_by_key(|corner| (position(*corner), *corner));
        let pairs = by_position.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.filter(|[one, other]| position(*one) == position(*other)).collect()
    }

    /// Gives each corner what its neighbours have, too, as far as they face the same way; `same`: those at the same
    /// positions.
    fn mixed(&self, scene: &Scene, same: &[[u32; 2]], gathered: &[Gathered]) -> Vec<Gathered> {
        let mut mixed = gathered.to_vec();
        let mut mix = |one: u32, other: u32| {
            if one != other {
                let (one, other) = (one as usize, other as usize);
                let weight = self.corners[one].normal.dot(self.corners[other].normal).max(0.0).powi(4);
                mixed[one].add_shares(&gathered[other], weight);
                mixed[other].add_shares(&gathered[one], weight);
            }
        };
        for vertices in &scene.triangles {
            let [a, b, c] = vertices.map(|vertex| self.of_vertex(vertex));
            if a != u32::MAX && b != u32::MAX && c != u32::MAX {
                mix(a, b);
                mix(b, c);
                mix(c, a);
            }
        }
        for [one, other] in same {
            mix(*one, *other);
        }
        mixed
    }
}

/// The samples by which the light at corners is gathered.
pub(super) struct CornerSamples<'a> {
    corners: &'a Corners,
    within: (f32, f32),
    /// Samples of each corner that has any.
    pub(super) each: usize,
    /// One corner in so many has them.
    every: usize,
    /// Rounds in which corners share their light.
    rounds: u32,
    /// Pairs of corners at the same position.
    same: Vec<[u32; 2]>,
}

impl CornerSamples<'_> {
    /// How many corners have samples.
    pub(super) fn count(&self) -> usize {
        self.corners.count().div_ceil(self.every)
    }

    /// A sample of one of them.
    pub(super) fn sample(&self, scene: &Scene, corner: usize, number: usize) -> Sample {
        let (triangle, at) = self.corners.sample(scene, corner * self.every, number, self.within);
        let group = (random::mix(corner as u64) as usize).wrapping_add(number * GROUPS / self.each) % GROUPS;
        Sample { triangle, at, group: group as u8 }
    }

    /// The light at all corners, from what those with samples have gathered.
    pub(super) fn shared(&self, scene: &Scene, found: Vec<Gathered>) -> Vec<Gathered> {
        let mut gathered = vec![Gathered::default(); self.corners.count()];
        for (corner, found) in found.into_iter().enumerate() {
            gathered[corner * self.every] = found;
        }
        // Twice as many share their light with each round, or somewhat more.
        for _ in 0..self.rounds {
            gathered = self.corners.mixed(scene, &self.same, &gathered);
        }
        gathered
    }
}

/// The parts of a triangle's sides from its first corner within a distance and a part of them.
fn reach(scene: &Scene, triangle: u32, (distance, part): (f32, f32)) -> Vec2 {
    let [a, b, c] = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
    let within = |length: f32| (distance / length.max(f32::MIN_POSITIVE)).min(part);
    Vec2::new(within(a.distance(b)), within(a.distance(c)))
}
