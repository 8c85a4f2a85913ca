//! Triangles that share an edge.

/// No triangle across an edge: a border, a crease, or more than two triangles at one edge.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// For each triangle the one across the edge opposite to each corner, where just one shares it, else
/// [`NO_NEIGHBOUR`]; `group_of` numbers vertices such that those that are one have one number.
pub fn neighbours(triangles: &[[u32; 3]], group_of: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (number, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(&group_of);
        if a == b || b == c || c == a {
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
    neighbours
}
