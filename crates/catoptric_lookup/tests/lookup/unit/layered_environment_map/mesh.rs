//! Meshes over a picture.

use catoptric_core::progress::Silent;
use catoptric_core::scene::Scene;
use catoptric_engine::light::two_path_tracer::SpecularChain;
use catoptric_engine::method::{Job, Quality};
use catoptric_lookup::layered_environment_map::LayeredEnvironmentMapSettings;
use catoptric_lookup::parts::{AdaptiveMesh, Criteria, LayerGeometry, PatchLeaf, drawn};
use catoptric_scenes::builtin;
use glam::Vec2;
use rustc_hash::FxHashMap;

fn scene(spec: &str) -> Scene {
    builtin::parse(spec).unwrap().pose(&Default::default()).unwrap()
}

fn mesh_of(scene: &Scene, tau: f32) -> AdaptiveMesh {
    let settings = LayeredEnvironmentMapSettings { tau, ..LayeredEnvironmentMapSettings::default() };
    let known = LayerGeometry::new(&settings, scene, 4);
    let view = scene.default_view(200, 150);
    let paths = |object: u32| known.paths(scene, object);
    let job = Job { scene, view: &view, quality: Quality { samples: 1, order: 4 }, progress: &Silent };
    drawn(&job, &known.welds, &paths, Criteria::of(&settings), |_| true).unwrap().1
}

#[test]
fn there_are_no_t_junctions() {
    let scene = scene("colonnade?tess=12");
    let mesh = mesh_of(&scene, 2.0);
    assert!(mesh.leaves.len() > 2000, "it was refined: {}", mesh.leaves.len());
    // Vertices are compared in space, to a millionth: no triangle has a vertex in the middle of an edge.
    let key = |source: u32, at: Vec2| (scene.position_on(source, at) * 1e5).round().as_ivec3();
    let vertices: std::collections::HashSet<_> =
        mesh.leaves.iter().flat_map(|leaf| leaf.corners.map(|at| key(leaf.source, at))).collect();
    let edges = mesh.leaves.iter().flat_map(|leaf| (0..3).map(move |edge| (leaf, edge)));
    let divided = edges.filter(|(leaf, edge)| {
        let [from, to] = [leaf.corners[*edge], leaf.corners[(edge + 1) % 3]];
        let [start, middle, end] = [from, (from + to) * 0.5, to].map(|at| key(leaf.source, at));
        middle != start && middle != end && vertices.contains(&middle)
    });
    let divided = divided.count();
    assert_eq!(divided, 0, "edges whose middle is a vertex");
}

#[test]
fn parts_cover_their_triangles_and_smaller_edges_cost_more_rays() {
    let scene = scene("colonnade?tess=12");
    let (coarse, fine) = (mesh_of(&scene, 8.0), mesh_of(&scene, 2.0));
    assert!(fine.ray_count > coarse.ray_count && fine.leaves.len() > coarse.leaves.len());
    let mut areas: FxHashMap<u32, f32> = FxHashMap::default();
    for leaf in &fine.leaves {
        let [a, b, c] = leaf.corners;
        *areas.entry(leaf.source).or_default() += (b - a).perp_dot(c - a).abs();
    }
    // A whole triangle has twice the area one half in barycentric coordinates.
    assert!(areas.values().all(|area| (area - 1.0).abs() < 1e-4));
    // Corners that are alike are not divided: all that is long differs.
    let settings = LayeredEnvironmentMapSettings { tau: 2.0, ..LayeredEnvironmentMapSettings::default() };
    let criteria = Criteria::of(&settings);
    let small = |leaf: &&PatchLeaf| {
        let corners = leaf.vertices.map(|vertex| mesh_place(&fine, vertex));
        (0..3).all(|edge| corners[edge].distance(corners[(edge + 1) % 3]) <= 2.0 + 1e-3)
    };
    let alike = |leaf: &&PatchLeaf| {
        let [a, b, c] = leaf.vertices.map(|vertex| &fine.paths[vertex as usize]);
        let alike =
            |a: &[SpecularChain; 2], b: &[SpecularChain; 2]| a.iter().zip(b).all(|(a, b)| !criteria.differ(a, b));
        alike(a, b) && alike(b, c) && alike(c, a)
    };
    let good = fine.leaves.iter().filter(|leaf| small(leaf) || alike(leaf)).count();
    // Others were cut by their neighbours, or are hidden.
    assert!(good * 100 > fine.leaves.len() * 97, "{good} of {}", fine.leaves.len());
}

fn mesh_place(mesh: &AdaptiveMesh, vertex: u32) -> Vec2 {
    mesh.points[vertex as usize].xy / mesh.points[vertex as usize].w
}
