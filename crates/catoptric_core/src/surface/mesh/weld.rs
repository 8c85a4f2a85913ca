//! Welding: the rule by which vertices count as one point.

use glam::Vec3;
use std::collections::HashMap;

/// The rule by which vertices at one position are one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalRule {
    /// All of them.
    Any,
    /// Those with equal normals.
    Equal,
    /// Those whose normals differ by no more than this distance from that of the first.
    Within(f64),
}

/// Numbers vertices in the order in which they are given: one number for all that are one.
#[derive(Clone, Debug)]
pub struct Welder {
    rule: NormalRule,
    /// The last number at each position.
    last_at: HashMap<[u32; 3], u32>,
    /// The first normal of each number, and the number before it at the same position.
    members: Vec<(Vec3, u32)>,
}

/// The end of the numbers at a position.
const NONE: u32 = u32::MAX;

/// Equal for equal vectors: bit for bit, but for the sign of zeros.
fn key(vector: Vec3) -> [u32; 3] {
    (vector + Vec3::ZERO).to_array().map(f32::to_bits)
}

impl Welder {
    /// Without vertices; positions are one where they are equal.
    pub fn new(rule: NormalRule) -> Self {
        Self { rule, last_at: HashMap::new(), members: Vec::new() }
    }

    /// The number of a vertex: that of an earlier one that it is one with, else the next.
    pub fn number(&mut self, position: Vec3, normal: Vec3) -> u32 {
        let next = self.count();
        let last = self.last_at.entry(key(position)).or_insert(NONE);
        let mut number = *last;
        while let Some(&(known, before)) = self.members.get(number as usize) {
            let is_one = match self.rule {
                NormalRule::Any => true,
                NormalRule::Equal => key(known) == key(normal),
                NormalRule::Within(distance) => known.distance_squared(normal) <= (distance * distance) as f32,
            };
            if is_one {
                return number;
            }
            number = before;
        }
        self.members.push((normal, *last));
        *last = next;
        next
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
    /// Welds vertices by their positions and normals.
    pub fn new(positions: &[Vec3], normals: &[Vec3], rule: NormalRule) -> Self {
        let mut welder = Welder::new(rule);
        welder.last_at.reserve(positions.len());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_one_by_position_and_normal() {
        let positions = [Vec3::X, Vec3::new(1.0, -0.0, 0.0), Vec3::Y, Vec3::X, Vec3::X];
        let normals = [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::new(0.0, 1e-4, 1.0), Vec3::Y];
        let welded = |rule| {
            let WeldedVertices { numbers, firsts } = WeldedVertices::new(&positions, &normals, rule);
            (numbers, firsts)
        };
        assert_eq!(welded(NormalRule::Any), (vec![0, 0, 1, 0, 0], vec![0, 2]));
        assert_eq!(welded(NormalRule::Equal), (vec![0, 0, 1, 2, 3], vec![0, 2, 3, 4]));
        assert_eq!(welded(NormalRule::Within(1e-3)), (vec![0, 0, 1, 0, 2], vec![0, 2, 4]));
    }
}
