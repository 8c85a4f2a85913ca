//! Meshes of reflectors.

use catoptric_core::math::random::Stream;
use catoptric_core::surface::mesh::adjacency::NO_NEIGHBOUR;
use catoptric_projection::parts::ReflectorMesh;
use glam::Vec3;

fn mesh(name: &str, longest_edge: f32) -> ReflectorMesh {
    let scene =
        catoptric_scenes::builtin::parse(name).expect("a built-in scene").pose(&Default::default()).expect("a scene");
    ReflectorMesh::new(&scene, scene.specular_objects()[0], longest_edge)
}

fn area(mesh: &ReflectorMesh) -> f32 {
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(of).sum()
}

#[test]
fn balls_are_convex_and_slabs_have_six_faces() {
    for name in ["sphere_room", "sphere_room?tess=71", "ellipsoid"] {
        let ball = mesh(name, 0.125);
        assert!(ball.convex && ball.piece_count == 1 && ball.extrusion.is_none(), "{name}");
    }
    let slab = mesh("glass_slab", 0.125);
    assert_eq!(slab.piece_count, 6);
    // Normals of one piece are parallel.
    for (triangle, piece) in slab.triangles.iter().zip(&slab.pieces) {
        let first = slab.pieces.iter().position(|other| other == piece).unwrap();
        let [here, there] = [triangle[0], slab.triangles[first][0]].map(|vertex| slab.normals[vertex as usize]);
        assert!(here.dot(there) > 0.999);
    }
    assert!(!mesh("torus", 0.125).convex);
}

#[test]
fn halved_edges_leave_no_crack_and_the_same_area() {
    let slab = mesh("glass_slab", 0.5);
    let some = slab.triangles.iter().step_by(3).map(|[a, b, _]| [*a.min(b), *a.max(b)]).collect();
    let finer = slab.with_halved(&some);
    assert!(finer.triangles.len() > slab.triangles.len());
    assert!((area(&finer) - area(&slab)).abs() < 1e-4 * area(&slab));
    let borders = |mesh: &ReflectorMesh| {
        let ends = |(triangle, neighbours): (&[u32; 3], &[u32; 3])| -> f32 {
            let length = |k: usize| {
                let [a, b] = [(k + 1) % 3, (k + 2) % 3].map(|k| mesh.positions[triangle[k] as usize]);
                if neighbours[k] == NO_NEIGHBOUR { a.distance(b) } else { 0.0 }
            };
            (0..3).map(length).sum()
        };
        mesh.triangles.iter().zip(&mesh.neighbours).map(ends).sum::<f32>()
    };
    assert!((borders(&finer) - borders(&slab)).abs() < 1e-3 * borders(&slab));
    assert_eq!(finer.piece_count, slab.piece_count);
}

#[test]
fn seams_that_exporters_leave_do_not_open_a_ball() {
    let mut scene = catoptric_scenes::builtin::parse("sphere_room").unwrap().pose(&Default::default()).unwrap();
    let index = scene.specular_objects()[0];
    scene.objects[index as usize].surface = None;
    let object = scene.objects[index as usize].clone();
    let size = object.bounds.diagonal();
    // Every vertex is off by the rounding of six decimals of a unit object, and its normal by rounding.
    let mut random = Stream::new(7);
    let mut off = |most: f32| Vec3::from([0; 3].map(|_| random.next_between(-most, most)));
    for vertex in object.vertices.start as usize..object.vertices.end as usize {
        scene.positions[vertex] += off(1e-6 * size);
        scene.normals[vertex] = (scene.normals[vertex] + off(1e-5)).normalize();
    }
    // The last triangles are given again: the same, the other way round, and collapsed.
    let last = object.triangles.end as usize - 3;
    for (triangle, [a, b, c]) in (last..).zip([[0, 1, 2], [2, 1, 0], [0, 0, 1]]) {
        let first = scene.triangles[object.triangles.start as usize + 200];
        let before = scene.triangles[triangle];
        scene.triangles[triangle] = [first[a], first[b], first[c]];
        assert!(before != scene.triangles[triangle]);
    }
    let holed = ReflectorMesh::new(&scene, index, 1.0);
    assert!(!holed.closed, "three triangles are missing");
    let repeated = scene.triangles[last..last + 3].to_vec();
    let whole = catoptric_scenes::builtin::parse("sphere_room").unwrap().pose(&Default::default()).unwrap();
    scene.triangles[last..last + 3].copy_from_slice(&whole.triangles[last..last + 3]);
    let ball = ReflectorMesh::new(&scene, index, 1.0);
    assert!(ball.convex && ball.closed && ball.piece_count == 1);
    assert!(repeated.len() == 3 && holed.triangles.len() + 3 == ball.triangles.len());
}
