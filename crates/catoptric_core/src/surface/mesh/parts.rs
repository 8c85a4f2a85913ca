//! Division of a mesh's triangles into smooth surfaces.

use std::ops::Range;

/// Appends, for every triangle of an object, a number that it shares with all triangles that it hangs together with by
/// common vertices, and with no others of the scene; never 0. Where normals or textures jump, meshes have two vertices
/// at one place: there parts end.
///
/// `vertices` are those of the object; the triangles point to no others.
pub fn append_parts(triangles: &[[u32; 3]], vertices: Range<u32>, parts: &mut Vec<u32>) {
    let first = vertices.start;
    // A forest: of every vertex one that it hangs together with, and of roots the root.
    let mut parents: Vec<u32> = (0..vertices.len() as u32).collect();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| root(&mut parents, vertex - first));
        // The smallest number is the root: the result does not depend on how the forest grew.
        let least = a.min(b).min(c);
        [a, b, c].into_iter().for_each(|vertex| parents[vertex as usize] = least);
    }
    parts.extend(triangles.iter().map(|triangle| first + root(&mut parents, triangle[0] - first) + 1));
}

fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        // Shortens the way for the next time.
        parents[vertex as usize] = parents[parents[vertex as usize] as usize];
        vertex = parents[vertex as usize];
    }
    vertex
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hang_together_by_vertices() {
        // Two squares, the second given from its far end, and a triangle alone; numbered from vertex 7 on.
        let triangles = [[7, 8, 9], [14, 13, 12], [7, 9, 10], [15, 16, 17], [11, 12, 13]];
        let mut parts = vec![5];
        append_parts(&triangles, 7..18, &mut parts);
        let [before, a, c, b, alone, d] = parts[..] else { panic!("{parts:?}") };
        assert_eq!(before, 5, "what was there stays");
        assert_eq!((a, c), (b, d));
        assert!(a != c && a != alone && c != alone && a * c * alone != 0, "{parts:?}");
        // Parts connected by the last triangle alone.
        let mut chain: Vec<[u32; 3]> = (0..20).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        chain.extend((0..19).map(|k| [3 * k + 2, 3 * k + 3, 3 * k]));
        let mut parts = Vec::new();
        append_parts(&chain, 0..60, &mut parts);
        assert!(parts.iter().all(|part| *part == 1), "{parts:?}");
    }
}
