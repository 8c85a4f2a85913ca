//! Triangles that share an edge.

use rustc_hash::FxHashMap;

/// No triangle across an edge: a border, a crease, or more than two triangles at one edge.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// For each triangle the one across the edge opposite to each corner, where just one shares it, else
/// [`NO_NEIGHBOUR`]; `group_of` numbers vertices such that those that are one have one number.
///
/// Triangles over the same three vertices count once: those after the first have its neighbours and are nobody's.
pub fn neighbours(triangles: &[[u32; 3]], group_of: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
    let mut firsts: FxHashMap<[u32; 3], u32> = FxHashMap::default();
    firsts.reserve(triangles.len());
    let mut repeated: Vec<(u32, u32)> = Vec::new();
    for (number, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(&group_of);
        if a == b || b == c || c == a {
            continue;
        }
        let mut corners = [a, b, c];
        corners.sort_unstable();
        let first = *firsts.entry(corners).or_insert(number as u32);
        if first != number as u32 {
            repeated.push((number as u32, first));
            continue;
        }
        for (opposite, (p, q)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
            edges.push(([p.min(q), p.max(q)], number as u32, opposite as u8));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NO_NEIGHBOUR; 3]; triangles.len()];
    for same in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [(_, one, side), (_, other, other_side)] = *same {
            neighbours[one as usize][side as usize] = other;
            neighbours[other as usize][other_side as usize] = one;
        }
    }
    for (number, first) in repeated {
        let [own, others] = [number, first].map(|triangle| triangles[triangle as usize].map(&group_of));
        let of_first = neighbours[first as usize];
        neighbours[number as usize] =
            own.map(|corner| others.iter().position(|other| *other == corner).map_or(NO_NEIGHBOUR, |k| of_first[k]));
    }
    neighbours
}
