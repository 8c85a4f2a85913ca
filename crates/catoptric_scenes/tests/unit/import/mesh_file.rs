//! Meshes in `.ply` and `.stl` files.

use super::mutated;
use catoptric_core::scene::model::{Model, Primitive};
use catoptric_scenes::import::{NoFiles, load_bytes};
use glam::Vec3;

fn read(name: &str, bytes: &[u8]) -> Model {
    load_bytes(name, bytes, &NoFiles).expect("a readable file")
}

fn mesh(model: &Model) -> &Primitive {
    &model.meshes[0].primitives[0]
}

fn ply_header(format: &str) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment a roof\nelement vertex 4\nproperty float x\nproperty double y\n\
         property short z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
         property uchar flags\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

const VERTICES: [[i16; 3]; 4] = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]];

#[test]
fn ply_is_the_same_as_text_and_in_both_orders_of_bytes() {
    let mut text = ply_header("ascii");
    let [mut little, mut big] =
        ["little", "big"].map(|order| ply_header(&format!("binary_{order}_endian")).into_bytes());
    for [x, y, z] in VERTICES {
        text += &format!("{x} {y} {z} 255 0 0\n");
        little.extend([&f32::from(x).to_le_bytes()[..], &f64::from(y).to_le_bytes(), &z.to_le_bytes()].concat());
        big.extend([&f32::from(x).to_be_bytes()[..], &f64::from(y).to_be_bytes(), &z.to_be_bytes()].concat());
        [&mut little, &mut big].into_iter().for_each(|bytes| bytes.extend([255, 0, 0]));
    }
    text += "7 4 0 1 2 3\n";
    [&mut little, &mut big].into_iter().for_each(|bytes| bytes.extend([7, 4]));
    (0..4i32).for_each(|index| little.extend(index.to_le_bytes()));
    (0..4i32).for_each(|index| big.extend(index.to_be_bytes()));
    for bytes in [text.as_bytes(), &little, &big] {
        let model = read("roof.ply", bytes);
        let mesh = mesh(&model);
        assert_eq!((model.nodes[0].name.as_str(), mesh.triangles.len()), ("roof", 2));
        let corners: Vec<Vec3> = mesh.triangles[0].iter().map(|corner| mesh.positions[*corner as usize]).collect();
        assert_eq!(corners, [Vec3::ZERO, Vec3::X * 2.0, Vec3::new(2.0, 2.0, 0.0)]);
        assert!(mesh.colors.iter().all(|color| *color == [1.0, 0.0, 0.0, 1.0]));
        assert!(mesh.normals.iter().all(|normal| *normal == Vec3::Z));
        let cut = load_bytes("roof.ply", &bytes[..bytes.len() - 3], &NoFiles).expect_err("a cut file").to_string();
        assert!(cut.contains("roof.ply: face[0]: "), "{cut}");
    }
}

/// As a program writes them that appends colours it does not announce.
#[test]
fn rows_of_text_may_hold_more_numbers() {
    let text = "ply\nformat ascii 1.0\nCreated by a program\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n\
                0 0 0 9 9\n1 0 0 9\n0 1 0\n3 0 1\n2 7 7 7\n";
    assert_eq!(mesh(&read("rows.ply", text.as_bytes())).triangles.len(), 1);
}

#[test]
fn strips_of_triangles_turn_to_one_side() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 0 1 2 3 -1\n";
    let model = read("strip.ply", text.as_bytes());
    assert_eq!(mesh(&model).triangles.len(), 2);
    assert!(mesh(&model).normals.iter().all(|normal| *normal == Vec3::Z), "{:?}", mesh(&model).normals);
}

/// A box, each side of two triangles.
fn cube_triangles() -> Vec<[Vec3; 3]> {
    let sides = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    sides
        .into_iter()
        .flat_map(|normal| {
            let across = Vec3::new(normal.y, normal.z, normal.x);
            let up = normal.cross(across);
            let corner = |u: f32, v: f32| normal + across * u + up * v;
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
        })
        .collect()
}

#[test]
fn stl_is_the_same_as_text_and_binary_and_keeps_creases() {
    let triangles = cube_triangles();
    // A header that begins like a text.
    let mut binary = b"solid of a program that writes binary".to_vec();
    binary.resize(80, b' ');
    binary.extend((triangles.len() as u32).to_le_bytes());
    let mut text = String::from("solid cube\n");
    for corners in &triangles {
        binary.extend([0; 12]);
        text += " facet normal 0 0 0\n  outer loop\n";
        for corner in corners {
            binary.extend(corner.to_array().into_iter().flat_map(f32::to_le_bytes));
            text += &format!("   vertex {:e} {} {}\n", corner.x, corner.y, corner.z);
        }
        binary.extend([0; 2]);
        text += "  endloop\n endfacet\n";
    }
    text += "endsolid cube\n";
    for bytes in [&binary, text.as_bytes()] {
        let model = read("cube.stl", bytes);
        let mesh = mesh(&model);
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 24));
        // Each corner has the normal of its side.
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
            let flat = (b - a).cross(c - a).normalize();
            assert!(triangle.iter().all(|corner| (mesh.normals[*corner as usize] - flat).length() < 1e-6));
        }
    }
    assert!(load_bytes("cube.stl", &binary[..500], &NoFiles).is_err());
}

#[test]
fn files_of_other_kinds_are_named() {
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n";
    for (name, bytes, needle) in [
        ("a.glb", &pointer[..], "git lfs pull"),
        ("a.obj", b"", "an empty file"),
        ("a.gltf", b"<!DOCTYPE html><html>", "a web page"),
        ("a.stl", b"PK\x03\x04", "ZIP"),
        ("a.ply", b"Kaydara FBX Binary", "FBX"),
        ("a.fbx", b"", "export glTF"),
        ("a", b"", "is missing; allowed are .glb"),
        ("/", b"", "is a folder"),
    ] {
        let message = load_bytes(name, bytes, &NoFiles).expect_err("another kind").to_string();
        assert!(message.starts_with(name) && message.contains(needle), "{message}");
    }
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                  end_header\n0 0 0\n";
    let model = read("points.ply", points.as_bytes());
    assert!(model.warnings.iter().any(|warning| warning.contains("points are not drawn")), "{:?}", model.warnings);
    assert!(model.warnings.iter().any(|warning| warning.contains("nothing to draw")), "{:?}", model.warnings);
}

/// Changed, doubled and lost bytes make no file worse than an error, and no mesh whose triangles miss their vertices.
#[test]
fn mutated_files_never_panic() {
    let mut binary = ply_header("binary_little_endian").into_bytes();
    binary.extend([0x40; 80]);
    let text = ply_header("ascii") + "0 0 0 1 2 3\n1 0 0 1 2 3\n1 1 0 1 2 3\n0 1 0 1 2 3\n0 4 0 1 2 3\n";
    let stl = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let mut binary_stl = vec![b' '; 80];
    binary_stl.extend(2u32.to_le_bytes());
    binary_stl.extend([0x3f; 100]);
    let obj =
        b"o a\ns 1\nv 0 0 0 1 1 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/-1 -1\nf 1 2 3 4\n";
    let samples: [(&str, &[u8]); 5] =
        [("a.ply", &binary), ("a.ply", text.as_bytes()), ("a.stl", stl), ("a.stl", &binary_stl), ("a.obj", obj)];
    for (iteration, (name, sample)) in (0..10_000u64).zip(samples.into_iter().cycle()) {
        let Ok(model) = load_bytes(name, &mutated(sample, iteration), &NoFiles) else { continue };
        for part in model.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            let count = part.positions.len();
            assert!(part.triangles.iter().flatten().all(|corner| (*corner as usize) < count), "{iteration}");
            assert!(part.positions.iter().all(|place| place.is_finite()), "{iteration}");
            for length in [part.normals.len(), part.uvs[0].len(), part.colors.len()] {
                assert!(length == 0 || length == count, "{iteration}");
            }
        }
    }
}
