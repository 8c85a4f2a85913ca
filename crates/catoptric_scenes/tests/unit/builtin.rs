//! The built-in scenes: their bodies against closed forms, their poses, their parameters.

use catoptric_core::math::Aabb;
use catoptric_core::scene::model::{LocalTransform, Node};
use catoptric_core::scene::{Model, PoseMemory, PoseOptions, Projection, Role, Scene};
use catoptric_core::surface::SurfaceMesh;
use catoptric_scenes::builtin::{Allowed, all, load, parse};
use glam::{IVec3, Vec2, Vec3};
use std::collections::HashMap;
use std::sync::LazyLock;

fn pose(spec: &str, time: f32) -> Scene {
    parse(spec).unwrap().pose(&PoseOptions { time, ..PoseOptions::default() }).unwrap()
}

#[test]
fn poses_are_the_same_after_others() {
    for builtin in all() {
        let mut model = parse(builtin.name).unwrap();
        let mut memory = PoseMemory::default();
        for (number, time) in [0.0, 0.4, 0.4, 1.3].into_iter().enumerate() {
            let options = PoseOptions { time, ..PoseOptions::default() };
            let (again, alone) = (model.pose_again(&options, &mut memory).unwrap(), model.pose(&options).unwrap());
            let of = |scene: &Scene| {
                let Scene { positions, normals, uvs, colors, tangents, triangles, .. } = scene.clone();
                let objects: Vec<_> = scene.objects.iter().map(|object| format!("{object:?}")).collect();
                let numbers = (triangles, scene.triangle_objects.clone(), scene.triangle_parts.clone());
                ((positions, normals, uvs), (colors, tangents), numbers, objects, scene.bounds)
            };
            assert!(of(&again) == of(&alone), "{} at {time}", builtin.name);
            // Nodes may be elsewhere the next time.
            let moved = number % model.nodes.len();
            if let LocalTransform::Parts { translation, .. } = &mut model.nodes[moved].local {
                translation.y += 0.25;
            }
        }
    }
}

/// The count of each directed edge, after equal positions are taken for one vertex.
fn directed_edges(positions: &[Vec3], triangles: &[[u32; 3]]) -> HashMap<(IVec3, IVec3), u32> {
    let key = |vertex: u32| (positions[vertex as usize] * 1e4).round().as_ivec3();
    let mut edges = HashMap::new();
    for [a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((key(*from), key(*to))).or_insert(0) += 1;
        }
    }
    edges
}

/// Returns true if every edge joins exactly two triangles, which run along it in opposite directions.
fn is_closed(positions: &[Vec3], triangles: &[[u32; 3]]) -> bool {
    let edges = directed_edges(positions, triangles);
    edges.iter().all(|((from, to), count)| from != to && *count == 1 && edges.get(&(*to, *from)) == Some(&1))
}

fn volume(shape: &SurfaceMesh) -> f32 {
    let corner = |vertex: u32| shape.positions[vertex as usize];
    shape.triangles.iter().map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c))) / 6.0).sum()
}

/// The largest angle, as a cosine, between a triangle's side of winding and the normals at its corners.
fn worst_agreement(shape: &SurfaceMesh) -> f32 {
    let agreement = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| shape.positions[vertex as usize]);
        let face = (b - a).cross(c - a).normalize();
        triangle.map(|vertex| shape.normals[vertex as usize].dot(face)).into_iter().fold(1.0, f32::min)
    };
    shape.triangles.iter().map(agreement).fold(1.0, f32::min)
}

fn node<'a>(model: &'a Model, name: &str) -> &'a Node {
    model.nodes.iter().find(|node| node.name == name).unwrap()
}

/// The mesh of a node in its own frame.
fn mesh_of(model: &Model, name: &str) -> SurfaceMesh {
    let primitive = model.meshes[node(model, name).mesh.unwrap()].primitives[0].clone();
    let [uvs, _] = primitive.uvs;
    SurfaceMesh { positions: primitive.positions, normals: primitive.normals, uvs, triangles: primitive.triangles }
}

fn mesh(spec: &str, name: &str) -> SurfaceMesh {
    mesh_of(&parse(spec).unwrap(), name)
}

/// Closed bodies of scenes with their volumes; round ones have `tess` rings or segments.
fn closed_bodies(tess: u32) -> Vec<(&'static str, SurfaceMesh, f32)> {
    let (lens_curvature, lens_aperture) = (2.0f64, 0.9f64);
    let sagitta = lens_curvature - (lens_curvature.powi(2) - lens_aperture.powi(2)).sqrt();
    let cap = std::f64::consts::PI * sagitta.powi(2) * (lens_curvature - sagitta / 3.0);
    let pi = std::f32::consts::PI;
    // Columns and cones have half as many segments as the scene's `tess`, and 64 at most.
    let props = parse(&format!("lens?tess={}", 2 * tess)).unwrap();
    vec![
        ("sphere", mesh(&format!("highlights?surface=mesh&tess={tess}"), "R"), 4.0 / 3.0 * pi),
        (
            "ellipsoid",
            mesh(&format!("ellipsoid?surface=mesh&tess={tess}"), "ellipsoid"),
            4.0 / 3.0 * pi * 1.15 * 0.68 * 0.5,
        ),
        ("torus", mesh(&format!("torus?surface=mesh&tess={tess}"), "torus"), 2.0 * pi * pi * 0.8 * 0.32 * 0.32),
        ("lens", mesh(&format!("lens?curvature=2&tess={tess}"), "lens"), 2.0 * cap as f32),
        ("cylinder", mesh_of(&props, "stand_foot"), pi * 0.4 * 0.4 * 0.06),
        ("cone", mesh_of(&props, "cone_teal"), pi * 0.28 * 0.28 * 0.8 / 3.0),
        ("cuboid", mesh_of(&props, "box_red"), 0.55 * 0.55 * 0.35),
        ("icosahedron", icosahedron(), 2.536_15 * 0.3 * 0.3 * 0.3),
    ]
}

/// A regular icosahedron; one with circumradius 1 has the volume 2.536150.
fn icosahedron() -> SurfaceMesh {
    static MESH: LazyLock<SurfaceMesh> = LazyLock::new(|| mesh("vase?tess=3", "icosahedron"));
    MESH.clone()
}

fn vase_wall(tess: u32) -> SurfaceMesh {
    mesh(&format!("vase?surface=mesh&tess={tess}"), "vase")
}

fn pot_body(tess: u32) -> SurfaceMesh {
    mesh(&format!("teapot?tess={tess}"), "pot_body")
}

fn dish(shape: &str, tess: u32) -> SurfaceMesh {
    mesh(&format!("dish?surface=mesh&shape={shape}&tess={tess}"), "dish")
}

fn lizard() -> SurfaceMesh {
    mesh("vase?tess=3", "lizard")
}

const VASE_HEIGHT: f64 = 2.0;

/// The radius of the vase at a share of its height.
fn vase_radius(s: f64) -> f64 {
    5.80 * s.powi(3) - 9.78 * s * s + 3.90 * s + 0.47
}

#[test]
fn bodies_are_closed_and_wound_from_outside() {
    for tess in [3, 4, 7, 24] {
        for (name, shape, _) in closed_bodies(tess).iter().chain(&[("pot", pot_body(tess), 0.0)]) {
            assert!(is_closed(&shape.positions, &shape.triangles), "{name} at {tess}");
            assert!(volume(shape) > 0.0, "{name} at {tess}");
            for normal in &shape.normals {
                assert!((normal.length() - 1.0).abs() < 1e-5, "{name} at {tess}: {normal}");
            }
        }
    }
}

#[test]
fn volumes_approach_the_closed_forms() {
    for (name, shape, expected) in closed_bodies(96) {
        let error = volume(&shape) / expected - 1.0;
        assert!(error.abs() < 3e-3, "{name}: volume {} of {expected}", volume(&shape));
    }
}

#[test]
fn normals_agree_with_the_winding() {
    let open = [
        ("vase", vase_wall(64)),
        ("pot", pot_body(64)),
        ("spherical dish", dish("sphere", 64)),
        ("parabolic dish", dish("parabola", 64)),
        ("lizard", lizard()),
        ("rectangle", mesh("lens?tess=3", "target")),
    ];
    for (name, shape) in open.into_iter().chain(closed_bodies(64).into_iter().map(|(name, shape, _)| (name, shape))) {
        let worst = worst_agreement(&shape);
        assert!(worst > 0.97, "{name}: {worst}");
    }
}

#[test]
fn an_open_sheet_is_not_taken_for_closed() {
    let wall = vase_wall(16);
    assert!(!is_closed(&wall.positions, &wall.triangles));
    let mut sphere = mesh("sphere_room?tess=8", "sphere");
    sphere.triangles[5].swap(0, 1);
    assert!(!is_closed(&sphere.positions, &sphere.triangles));
}

#[test]
fn the_vase_has_the_papers_profile_and_its_normals_are_those_of_its_slope() {
    for step in 0..=1000 {
        let s = step as f64 / 1000.0;
        assert!(vase_radius(s) > 0.25, "the vase is cut through at {s}");
    }
    let wall = vase_wall(40);
    for (position, normal) in wall.positions.iter().zip(&wall.normals) {
        let s = position.y as f64 / VASE_HEIGHT;
        let distance = Vec2::new(position.x, position.z).length();
        assert!((distance as f64 - vase_radius(s)).abs() < 1e-5);
        let slope = (vase_radius(s + 1e-5) - vase_radius(s - 1e-5)) / 2e-5 / VASE_HEIGHT;
        let outwards = Vec3::new(position.x / distance, -slope as f32, position.z / distance).normalize();
        assert!((outwards - *normal).length() < 1e-4, "{outwards} against {normal}");
    }
}

#[test]
fn normals_of_curved_sheets_match_differences_of_their_points() {
    // On a fine mesh the sum of the faces around an inner vertex points along the normal to second order.
    let sheets = [
        ("tube", mesh("teapot?tess=192", "pot_spout"), 0.005),
        ("ellipsoid", mesh("ellipsoid?surface=mesh&tess=96", "ellipsoid"), 0.005),
        ("torus", mesh("torus?surface=mesh&tess=128", "torus"), 0.005),
        ("parabolic dish", dish("parabola", 128), 0.005),
    ];
    for (name, shape, limit) in sheets {
        check_normals(name, &shape.positions, &shape.normals, &shape.triangles, limit);
    }
    // A quarter of these triangles gives four times these differences: they are the mesh's, not the normals'.
    for (spec, objects, limit) in [
        ("car?tess=256", ["hood", "door_front_left", "windshield", "nose", "tail"].as_slice(), 0.002),
        ("large_room?triangles=4000000&tess=3", ["column_1_1", "wall_back", "ceiling"].as_slice(), 0.008),
    ] {
        let scene = pose(spec, 0.0);
        for name in objects {
            let object = scene.objects.iter().find(|object| object.name == *name).unwrap();
            let triangles = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
            check_normals(name, &scene.positions, &scene.normals, triangles, limit);
        }
    }
}

/// Compares normals with the sums of the faces around every inner vertex.
fn check_normals(name: &str, positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]], limit: f32) {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    let mut faces = vec![0; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        for vertex in triangle {
            sums[*vertex as usize] += (b - a).cross(c - a);
            faces[*vertex as usize] += 1;
        }
    }
    let mut checked = 0;
    for vertex in (0..sums.len()).filter(|vertex| faces[*vertex] == 6) {
        let difference = (sums[vertex].normalize() - normals[vertex]).length();
        assert!(difference < limit, "{name}: {difference} at {}", positions[vertex]);
        checked += 1;
    }
    assert!(checked > 5000, "{name}: only {checked} inner vertices");
}

#[test]
fn dishes_have_their_focus_where_they_should() {
    let hollow = dish("parabola", 24);
    for (position, normal) in hollow.positions.iter().zip(&hollow.normals) {
        let reflected = Vec3::NEG_Y.reflect(*normal);
        let to_focus = (Vec3::Y - *position).normalize();
        assert!((reflected - to_focus).length() < 1e-5);
    }
    let hollow = dish("sphere", 24);
    for (position, normal) in hollow.positions.iter().zip(&hollow.normals) {
        assert!((*position + *normal * 2.0 - Vec3::Y * 2.0).length() < 1e-5);
    }
}

#[test]
fn the_lizard_is_a_simple_polygon_of_61_vertices() {
    let shape = lizard();
    assert_eq!((shape.positions.len(), shape.triangles.len()), (61, 59));
    assert!(shape.positions.iter().all(|position| position.z == 0.0));
    // The triangles fill the outline exactly once.
    let flat: Vec<Vec2> = shape.positions.iter().map(|p| p.truncate()).collect();
    let outline: f32 = (0..61).map(|i| flat[i].perp_dot(flat[(i + 1) % 61]) * 0.5).sum();
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|vertex| flat[vertex as usize]);
        (b - a).perp_dot(c - a) * 0.5
    };
    assert!(shape.triangles.iter().all(|triangle| area(triangle) > 0.0));
    let filled: f32 = shape.triangles.iter().map(area).sum();
    assert!((filled - outline).abs() < 1e-5 && outline > 0.1, "{filled} of {outline}");
    let cross = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp_dot(c - a);
    for i in 0..61 {
        for j in i + 2..61 {
            if (j + 1) % 61 == i {
                continue;
            }
            let [a, b, c, d] = [flat[i], flat[i + 1], flat[j], flat[(j + 1) % 61]];
            let crosses = cross(a, b, c) * cross(a, b, d) < 0.0 && cross(c, d, a) * cross(c, d, b) < 0.0;
            assert!(!crosses, "edges {i} and {j} cross");
        }
    }
}

#[test]
fn every_scene_poses_at_every_tessellation_and_choice() {
    for info in all() {
        for tess in ["3", "40"] {
            let scene = pose(&format!("{}?tess={tess}", info.name), 0.0);
            check_scene(&scene, info.name);
        }
        for parameter in info.parameters {
            match parameter.allowed {
                Allowed::Choice(words) => {
                    for word in words {
                        check_scene(&pose(&format!("{}?{}={word}&tess=8", info.name, parameter.name), 1.0), info.name);
                    }
                }
                Allowed::Integer { min, .. } => {
                    let coarse = if parameter.name == "tess" { "" } else { "&tess=8" };
                    check_scene(&pose(&format!("{}?{}={min}{coarse}", info.name, parameter.name), 1.0), info.name);
                }
                Allowed::Number { min, max } => {
                    for value in [min, max] {
                        check_scene(&pose(&format!("{}?{}={value}&tess=8", info.name, parameter.name), 1.0), info.name);
                    }
                }
            }
        }
    }
}

fn check_scene(scene: &Scene, name: &str) {
    assert!(!scene.cameras.is_empty(), "{name}");
    assert!(!scene.specular_objects().is_empty(), "{name}");
    assert!(scene.positions.iter().all(|p| p.is_finite()), "{name}");
    assert!(scene.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4), "{name}");
    let mut names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), scene.objects.len(), "{name}: two objects of one name");
    assert!(names.iter().all(|object| !object.is_empty()), "{name}");
    // The default camera is inside the scene, so that it looks at no black.
    for camera in &scene.cameras {
        let eye = Vec3::from(camera.world_from_camera.translation);
        let Aabb { min, max } = scene.bounds;
        assert!(eye.cmpgt(min).all() && eye.cmplt(max).all(), "{name}: camera {} stands outside", camera.name);
        assert!(matches!(camera.projection, Projection::Perspective { .. }));
    }
    for object in &scene.objects {
        if scene.materials[object.material as usize].role == Role::Lens {
            let triangles = &scene.triangles[object.triangles.start as usize..object.triangles.end as usize];
            assert!(is_closed(&scene.positions, triangles), "{name}: the glass `{}` is open", object.name);
        }
    }
}

#[test]
fn no_triangle_faces_away_from_its_normals() {
    for info in all() {
        let scene = pose(info.name, 0.0);
        for (index, triangle) in scene.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|vertex| scene.positions[vertex as usize].as_dvec3());
            let face = (b - a).cross(c - a);
            let normal: Vec3 = triangle.iter().map(|vertex| scene.normals[*vertex as usize]).sum();
            let object = &scene.objects[scene.triangle_objects[index] as usize].name;
            assert!(face.dot(normal.as_dvec3()) > 0.0, "{}: triangle {index} of `{object}`", info.name);
        }
    }
}

#[test]
fn the_large_room_has_the_given_number_of_triangles() {
    for wanted in [10_000u64, 25_000, 60_000, 300_000, 1_000_000] {
        let scene = pose(&format!("large_room?triangles={wanted}&tess=8"), 0.0);
        let mirror = scene.objects.iter().find(|object| object.name == "sphere").unwrap();
        let count = scene.triangles.len() as u64 - u64::from(mirror.triangles.end - mirror.triangles.start);
        let error = count as f64 / wanted as f64 - 1.0;
        assert!(error.abs() < 0.03, "{count} for {wanted}");
    }
}

#[test]
fn the_analytic_sphere_is_the_exact_surface() {
    let scene = pose("sphere_room?surface=analytic", 0.0);
    let sphere = scene.objects.iter().find(|object| object.name == "sphere").unwrap();
    assert!(sphere.surface.is_some());
    let scene = pose("sphere_room", 0.0);
    let sphere = scene.objects.iter().find(|object| object.name == "sphere").unwrap();
    assert!(sphere.surface.is_none());
    assert_eq!(sphere.triangles.end - sphere.triangles.start, 4 * 64 * 63);
}

#[test]
fn curved_mirrors_are_exact_unless_a_mesh_is_chosen() {
    for (spec, name, kind) in [
        ("vase", "vase", "revolution"),
        ("ellipsoid", "ellipsoid", "ellipsoid"),
        ("torus", "torus", "torus"),
        ("dish", "dish", "quadric"),
        ("dish?shape=parabola", "dish", "quadric"),
    ] {
        let exact = pose(spec, 0.0);
        let object = exact.objects.iter().find(|object| object.name == name).unwrap();
        let surface = object.surface.as_ref().unwrap();
        assert_eq!(surface.surface.kind(), kind, "{spec}");
        let separator = if spec.contains('?') { '&' } else { '?' };
        let scene = pose(&format!("{spec}{separator}surface=mesh&tess=24"), 0.0);
        let mesh = scene.objects.iter().find(|object| object.name == name).unwrap();
        assert!(mesh.surface.is_none());
        // The mesh's points lie on the exact surface, with the same outer side.
        for vertex in mesh.vertices.clone() {
            let taylor = surface.taylor2(scene.positions[vertex as usize].as_dvec3());
            assert!(taylor.value.abs() < 1e-5 * taylor.gradient.length(), "{spec}: {}", taylor.value);
            let normal = taylor.normal().unwrap().as_vec3();
            assert!((normal - scene.normals[vertex as usize]).length() < 1e-3, "{spec}: {normal}");
        }
        assert!((object.bounds.min - mesh.bounds.min).length() < 0.05, "{spec}");
    }
}

#[test]
fn the_icosahedron_circles_the_vase() {
    let center = |time: f32| {
        let scene = pose("vase?tess=3", time);
        let object = scene.objects.iter().find(|object| object.name == "icosahedron").unwrap();
        let vertices = &scene.positions[object.vertices.start as usize..object.vertices.end as usize];
        (vertices.iter().sum::<Vec3>() / vertices.len() as f32, vertices[0])
    };
    let (start, start_corner) = center(0.0);
    assert!((Vec2::new(start.x, start.z).length() - 1.42).abs() < 1e-4);
    let (half, half_corner) = center(4.0);
    // Half an orbit later it is on the other side.
    assert!((Vec2::new(start.x, start.z) + Vec2::new(half.x, half.z)).length() < 1e-3);
    assert!(((half_corner - half) - (start_corner - start)).length() > 0.05, "it does not turn");
    let (end, _) = center(8.0);
    assert!((start - end).length() < 1e-3);
    // The orbit never comes so near that the sphere would touch the vase.
    assert!(1.42 - 0.3 > (0..=100).map(|s| vase_radius(s as f64 / 100.0)).fold(0.0, f64::max));
    // Nor does it touch the sphere above its way.
    let with_sphere = pose("vase?tess=3&sphere=mirror", 0.0);
    let sphere = with_sphere.objects.iter().find(|object| object.name == "sphere").unwrap();
    assert_eq!(sphere.surface.as_ref().unwrap().surface.kind(), "sphere");
    assert!(sphere.bounds.min.y > start.y + 0.3);
}

#[test]
fn seeds_change_the_arrangement_and_the_same_seed_repeats_it() {
    for name in ["two_spheres", "large_room", "car"] {
        let [first, again, other] =
            ["1", "1", "2"].map(|seed| pose(&format!("{name}?tess=3&seed={seed}"), 0.0).positions);
        assert_eq!(first, again, "{name}");
        assert_ne!(first, other, "{name}");
    }
}

#[test]
fn wrong_names_and_values_are_explained() {
    let message = |spec: &str| parse(spec).unwrap_err().to_string();
    let unknown = message("sphere_rom");
    assert!(unknown.contains("`sphere_rom`") && unknown.contains("sphere_room") && unknown.contains("large_room"));
    let parameter = message("sphere_room?tes=4");
    assert!(
        parameter.contains("builtin:sphere_room: tes:") && parameter.contains("tess (a whole number from 3 to 512)")
    );
    for (spec, expected) in [
        ("sphere_room?tess=2", "`2` is not allowed; it takes a whole number from 3 to 512"),
        ("sphere_room?tess=many", "whole number"),
        ("sphere_room?tess=-5", "whole number"),
        ("sphere_room?tess=", "whole number"),
        ("lens?curvature=NaN", "a number from 1 to 100"),
        ("lens?curvature=inf", "a number from 1 to 100"),
        ("teapot?material=clay", "mirror or glass"),
        ("planar_mirror?mirrors=5", "from 1 to 4"),
        ("large_room?triangles=99", "from 10000 to 10000000"),
        ("vase?tess=5&tess=5", "given twice"),
        ("vase?tess", "key=value"),
        ("lens?surface=mesh", "no such parameter"),
        ("vase?surface=exact", "analytic or mesh"),
    ] {
        assert!(message(spec).contains(expected), "{spec}: {}", message(spec));
    }
    assert!(parse("vase?").is_ok());
    assert_eq!(parse("lens?ior=1.7&tess=64").unwrap().name, "builtin:lens?ior=1.7");
    assert_eq!(load("torus", &[]).unwrap().name, "builtin:torus");
}

#[test]
fn defaults_are_allowed_and_names_are_unique() {
    let mut names: Vec<&str> = all().iter().map(|info| info.name).collect();
    names.dedup();
    assert_eq!(names.len(), 18);
    for info in all() {
        for parameter in info.parameters {
            let given = [(parameter.name, parameter.default)];
            assert!(load(info.name, &given).is_ok(), "{}: default of {}", info.name, parameter.name);
        }
        assert!(info.command.contains(&format!("builtin:{}", info.name)));
    }
}

#[test]
fn places_turn_counter_clockwise_from_above() {
    let model = parse("planar_mirror?tess=3").unwrap();
    let LocalTransform::Parts { rotation, .. } = node(&model, "icosahedron").local else { panic!("a rigid place") };
    let (sin, cos) = 15f32.to_radians().sin_cos();
    assert!((rotation * Vec3::X - Vec3::new(cos, 0.0, -sin)).length() < 1e-6);
}
