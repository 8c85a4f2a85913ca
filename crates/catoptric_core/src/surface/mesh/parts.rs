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
