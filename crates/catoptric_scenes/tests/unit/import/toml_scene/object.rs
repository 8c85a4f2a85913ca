//! Objects made in scene files.

use super::super::toml_model;
use super::{assert_error, read};
use catoptric_core::error::SceneError;
use catoptric_core::math::Aabb;
use catoptric_core::scene::{PoseOptions, Scene};
use catoptric_scenes::import::{Resolver, load, toml_scene};
use glam::Vec3;
use std::io::Cursor;
use std::path::Path;

fn posed(text: &str) -> Scene {
    read(text).pose(&PoseOptions::default()).unwrap()
}

#[track_caller]
fn assert_box(scene: &Scene, object: usize, center: Vec3, size: Vec3) {
    let Aabb { min, max } = scene.objects[object].bounds;
    let is_near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-3;
    assert!(is_near((min + max) * 0.5, center) && is_near(max - min, size), "{min} {max}");
}

/// The mean of the outer normals, by triangles, must agree with their winding; returns their sum of areas.
#[track_caller]
fn area(scene: &Scene, object: usize) -> f32 {
    let corners = |triangle: u32| scene.triangles[triangle as usize];
    let of = |triangle: u32| {
        let [a, b, c] = corners(triangle).map(|corner| scene.positions[corner as usize]);
        let area = (b - a).cross(c - a) * 0.5;
        let outwards: Vec3 = corners(triangle).iter().map(|corner| scene.normals[*corner as usize]).sum();
        assert!(area.dot(outwards) > 0.0, "{triangle}");
        area.length()
    };
    scene.objects[object].triangles.clone().map(of).sum()
}

#[test]
fn shapes_have_their_size_place_and_area() {
    use std::f32::consts::PI;
    let round = |radius: f32| PI * radius * radius;
    let cases = [
        ("box", "size = [1, 2, 3]", Vec3::new(1.0, 2.0, 3.0), 22.0),
        ("quad", "size = [1, 2]", Vec3::new(1.0, 2.0, 0.0), 2.0),
        ("quad", "size = [1, 2]\nnormal = [0, 1, 0]", Vec3::new(1.0, 0.0, 2.0), 2.0),
        ("sphere", "radius = 0.5", Vec3::ONE, 4.0 * round(0.5)),
        ("cylinder", "radius = 0.5\nheight = 2", Vec3::new(1.0, 2.0, 1.0), 2.0 * round(0.5) + 2.0 * PI),
        ("cone", "radius = 3\nheight = 4", Vec3::new(6.0, 4.0, 6.0), round(3.0) + PI * 15.0),
        ("cone", "radius = 3\nheight = 4\naxis = [-1, 0, 0]", Vec3::new(4.0, 6.0, 6.0), round(3.0) + PI * 15.0),
        ("disk", "radius = 0.5", Vec3::new(1.0, 1.0, 0.0), round(0.5)),
    ];
    for (shape, lines, size, surface) in cases {
        for look in ["", "checker = 0.25\n", "unlit = true\n"] {
            let scene = posed(&format!("[[object]]\nshape = \"{shape}\"\ncenter = [1, 2, 3]\n{look}{lines}\n"));
            assert_box(&scene, 0, Vec3::new(1.0, 2.0, 3.0), size);
            assert!((area(&scene, 0) / surface - 1.0).abs() < 3e-3, "{shape}: {}", area(&scene, 0));
        }
    }
    let scaled = posed("[[object]]\nshape = \"sphere\"\nradius = 1\nscale = [1, 2, 0.5]\nrotation_deg = [0, 0, 90]\n");
    assert_box(&scaled, 0, Vec3::ZERO, Vec3::new(4.0, 2.0, 1.0));
}

#[test]
fn pictures_are_upright_and_not_mirrored() {
    // Seen from +z, or from above with -z up: coordinates run to the right and down.
    let cases = [
        ("quad", "size = [2, 2]", Vec3::NEG_Y),
        ("quad", "size = [2, 2]\nnormal = [0, 1, 0]", Vec3::Z),
        ("box", "size = [2, 2, 2]", Vec3::NEG_Y),
        ("disk", "radius = 1", Vec3::NEG_Y),
        ("sphere", "radius = 1", Vec3::NEG_Y),
        ("cylinder", "radius = 1\nheight = 2", Vec3::NEG_Y),
    ];
    for (shape, lines, down) in cases {
        let scene = posed(&format!("[[object]]\nshape = \"{shape}\"\n{lines}\n"));
        let towards = if down == Vec3::Z { Vec3::Y } else { Vec3::Z };
        let mut seen = 0;
        for corners in &scene.triangles {
            let [a, b, c] = corners.map(|corner| corner as usize);
            if scene.normals[a].dot(towards) < 0.9 || scene.normals[b].dot(towards) < 0.9 {
                continue;
            }
            let way = |to: usize| scene.positions[to] - scene.positions[a];
            let change = |to: usize| scene.uvs[to][0] - scene.uvs[a][0];
            // The change of coordinates with the way, by both edges: the matrix of the one times the other's inverse.
            let across = glam::Mat2::from_cols(
                glam::Vec2::new(way(b).x, way(b).dot(down)),
                glam::Vec2::new(way(c).x, way(c).dot(down)),
            );
            let by_way = glam::Mat2::from_cols(change(b), change(c)) * across.inverse();
            assert!(by_way.x_axis.x > 0.1 && by_way.y_axis.y > 0.1, "{shape} {lines}: {by_way}");
            seen += 1;
        }
        assert!(seen > 10, "{shape}");
    }
}

#[test]
fn squares_have_their_side_on_every_face() {
    // Two squares a turn of the texture: the change of its coordinates with the place is half of one over the side.
    let scene = posed("[[object]]\nshape = \"box\"\nsize = [1, 2, 3]\nchecker = 0.25\n");
    for triangle in &scene.triangles {
        let [a, b] = [triangle[0], triangle[1]].map(|corner| corner as usize);
        let (way, change) = (scene.positions[b] - scene.positions[a], scene.uvs[b][0] - scene.uvs[a][0]);
        assert!((change.length() - way.length() * 2.0).abs() < 1e-4, "{way} {change}");
    }
}

#[test]
fn rows_and_grids_are_copies_with_a_number() {
    let row = posed("[[object]]\nname = \"ball\"\nshape = \"sphere\"\nradius = 0.1\ncount = 3\nstep = [0, 1, 2]\n");
    assert_eq!(
        row.objects.iter().map(|object| object.name.as_str()).collect::<Vec<_>>(),
        ["ball 0", "ball 1", "ball 2"]
    );
    assert_box(&row, 2, Vec3::new(0.0, 2.0, 4.0), Vec3::splat(0.2));
    let points =
        "[[object]]\nname = \"p\"\nshape = \"grid of points\"\nradius = 0.01\ncount = [2, 1, 3]\nstep = [1, 1, 5]\n";
    let grid = posed(points);
    assert_eq!(grid.objects.len(), 6);
    assert_box(&grid, 3, Vec3::new(1.0, 0.0, 5.0), Vec3::splat(0.02));
    assert!(grid.material_of(0).unlit);
    let mirrors = "[[reflector]]\nname = \"m\"\nsurface = \"sphere\"\ncenter = [0, 1, 0]\n\
                   radius = 0.1\ncount = 2\nstep = [3, 0, 0]\n";
    assert_box(&posed(mirrors), 1, Vec3::new(3.0, 1.0, 0.0), Vec3::splat(0.2));
    let lens = "[[reflector]]\nname = \"l\"\nsurface = \"lens\"\ncenter = [0, 1, 0]\naxis = [1, 0, 0]\nior = 1.5\n\
                aperture_radius = 0.5\nthickness = 0.5\ncount = 2\nstep = [3, 0, 0]\n[move]\n\"l 1\" = [0, 0, 7]\n";
    let scene = posed(lens);
    assert_eq!(scene.objects[7].name, "l 1 right edge");
    assert_box(&scene, 7, Vec3::new(3.0, 1.0, 6.75), Vec3::new(0.5, 1.0, 0.5));
}

/// A picture of two pixels, and a triangle.
struct Files;

impl Resolver for Files {
    fn read(&self, name: &str, _: u64) -> Result<Vec<u8>, SceneError> {
        match name {
            "p.png" => {
                let mut bytes = Cursor::new(Vec::new());
                let picture = image::RgbaImage::from_raw(2, 1, vec![255; 8]).unwrap();
                picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
                Ok(bytes.into_inner())
            }
            "t.obj" => Ok(b"o tri\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()),
            _ => Err(SceneError::invalid(name, "path", "there is no such file")),
        }
    }
}

#[test]
fn pictures_and_meshes_are_files_beside_the_scene() {
    let posed = |text: &str| {
        let model = toml_scene::from_slice("scene.toml", text.as_bytes(), &Files)?;
        Ok::<_, SceneError>((model.pose(&PoseOptions::default())?, model.warnings.len()))
    };
    let text = "[[object]]\nshape = \"quad\"\nsize = [1, 1]\npicture = \"p.png\"\n[[object]]\n\
                name = \"wedge\"\nshape = \"mesh\"\n\
                file = \"t.obj\"\nscale = 2\ncenter = [0, 0, 5]\ncolor = [0.1, 0.2, 0.3]\ncount = 2\nstep = [4, 0, 0]\n\
                [move]\n\"wedge 1\" = [0, 1, 0]\n";
    let (scene, _) = posed(text).unwrap();
    assert!(scene.material_of(0).base_texture.is_some());
    assert_box(&scene, 1, Vec3::new(1.0, 1.0, 5.0), Vec3::new(2.0, 2.0, 0.0));
    assert_box(&scene, 2, Vec3::new(5.0, 2.0, 5.0), Vec3::new(2.0, 2.0, 0.0));
    assert_eq!(scene.material_of(2).base_color.truncate(), Vec3::new(0.1, 0.2, 0.3));
    let missing =
        posed("\n[[object]]\nshape = \"quad\"\nsize = [1, 1]\npicture = \"q.png\"\n").unwrap_err().to_string();
    assert!(missing.contains("line 5: object.picture") && missing.contains("no such file"), "{missing}");
    let missing = posed("[[object]]\nshape = \"mesh\"\nfile = \"q.stl\"\n").unwrap_err().to_string();
    assert!(missing.contains("line 3: object.file") && missing.contains("q.stl"), "{missing}");
}

#[test]
fn misspelt_keys_name_their_line_and_the_right_one() {
    let ball = "[[reflector]]\nname = \"ball\"\nsurface = \"sphere\"\ncenter = [0, 0, 0]\n";
    assert_error(&format!("{ball}radus = 0.3\n"), 5, "reflector.radus: unknown key (did you mean `radius`?)");
    assert_error("[[reflector]]\nsurface = \"sphere\"\nradius = 1\ncentre = [0, 0, 0]\n", 4, "did you mean `center`?");
    assert_error("[[reflector]]\nsurfaces = \"sphere\"\n", 2, "did you mean `surface`?");
    assert_error("[[reflector]]\nsurface = \"shpere\"\n", 2, "there is no kind `shpere` (did you mean `sphere`?)");
    assert_error("[[reflector]]\nshape = \"sphere\"\n", 1, "`shape` is for [[object]]");
    assert_error("[camera]\neye = [0, 0, 1]\ntraget = [0, 0, 0]\n", 3, "did you mean `target`?");
    assert_error("[[light]]\nknd = \"point\"\n", 2, "did you mean `kind`?");
    let cases = [
        ("shap = \"box\"", 2, "did you mean `shape`?"),
        ("", 1, "shape: missing; allowed are `box`"),
        ("surface = \"sphere\"", 1, "`surface` is for [[reflector]]"),
        ("shape = \"bix\"", 2, "there is no shape `bix` (did you mean `box`?)"),
        ("shape = \"box\"", 1, "size: missing; the shape `box` needs `size`, 3 numbers"),
        ("shape = \"box\"\nsizes = [1, 1, 1]", 3, "did you mean `size`?"),
        ("shape = \"box\"\nsize = [1, 1]", 3, "3 finite numbers"),
        ("shape = \"box\"\nsize = [1, 1, 0]", 3, "a length must be"),
        ("shape = \"sphere\"\nradius = 1\nsize = 3", 4, "object.size: unknown key; known are: shape, name"),
        ("shape = \"sphere\"\nradius = 1\ncolour = [1, 1, 1]", 4, "did you mean `color`?"),
        ("shape = \"sphere\"\nradius = 1\ncolor = [2, 1, 1]", 4, "0 to 1"),
        ("shape = \"sphere\"\nradius = 1\nscale = 0", 4, "allowed is"),
        ("shape = \"sphere\"\nradius = 1\nchecker = -1", 4, "a square's side"),
        ("shape = \"sphere\"\nradius = 1\nchecker_color = [0, 0, 0]", 1, "checker: missing"),
        ("shape = \"sphere\"\nradius = 1\npicture = \"a.png\"\nchecker = 1", 5, "leave out"),
        ("shape = \"sphere\"\nradius = 1\ncount = 3", 1, "step: missing"),
        ("shape = \"sphere\"\nradius = 1\nstep = [1, 1, 1]", 1, "count: missing"),
        ("shape = \"sphere\"\nradius = 1\ncount = 1.5\nstep = [1, 1, 1]", 4, "whole numbers"),
        ("shape = \"sphere\"\nradius = 1\ncount = [1e9, 1e9, 1]\nstep = [1, 1, 1]", 4, "whole numbers"),
        ("shape = \"sphere\"\nradius = 1\ncount = 10001\nstep = [1, 1, 1]", 4, "from 1 to 10000"),
        ("shape = \"sphere\"\nradius = 1\ncount = [2, 2]\nstep = [1, 1, 1]", 4, "three in brackets"),
        ("shape = \"mesh\"\nfile = \"a.step\"", 3, ".glb"),
        ("shape = \"mesh\"", 1, "file: missing"),
    ];
    for (lines, line, needle) in cases {
        assert_error(&format!("[[object]]\n{lines}\n"), line, needle);
    }
    let twice = "[[object]]\nname = \"a\"\nshape = \"sphere\"\nradius = 1\n";
    assert_error(&format!("{twice}{twice}"), 5, "there is a `a` already");
    assert!(toml_model("[object]\nshape = \"box\"\n").unwrap_err().contains("[[object]]"));
}

#[test]
fn the_examples_are_short_and_read_without_warnings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let files = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let scenes: Vec<_> = files.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).collect();
    assert_eq!(scenes.len(), 6);
    for path in scenes {
        let text = std::fs::read_to_string(&path).unwrap();
        let model = load(&path).unwrap();
        assert!(text.lines().count() < 40 && model.warnings.is_empty(), "{path:?}: {:?}", model.warnings);
        assert!(!model.pose(&PoseOptions::default()).unwrap().specular_objects().is_empty(), "{path:?}");
    }
}

#[test]
fn many_exact_surfaces_share_a_budget_and_large_ones_have_the_most_of_it() {
    let ball = |name: &str, radius: f32, more: &str| {
        format!("[[reflector]]\nname = \"{name}\"\nsurface = \"sphere\"\nradius = {radius}\n{more}")
    };
    let finest = posed(&ball("alone", 1.0, "center = [0, 0, 0]\n")).triangles.len();
    let small = ball("small", 0.1, "center = [0, 0, 0]\ncount = [30, 30, 1]\nstep = [0.5, 0.5, 0]\n");
    let scene = posed(&(ball("large", 2.0, "center = [0, 0, -9]\n") + &small));
    assert_eq!(scene.objects.len(), 901);
    let counts: Vec<usize> = scene.objects.iter().map(|object| object.triangles.len()).collect();
    assert!(counts.iter().sum::<usize>() < 1_500_000, "{}", counts.iter().sum::<usize>());
    assert!(counts[1..].iter().all(|count| *count == counts[1] && *count > 200), "{}", counts[1]);
    assert!(counts[0] > 4 * counts[1] && counts[0] <= finest, "{} {finest}", counts[0]);
    // All of them lie on their spheres.
    for object in [0, 1, 900] {
        let Aabb { min, max } = scene.objects[object].bounds;
        let (center, radius) = ((min + max) * 0.5, (max - min).max_element() * 0.5);
        let vertices = scene.objects[object].vertices.clone();
        let is_on = |vertex: u32| (scene.positions[vertex as usize].distance(center) / radius - 1.0).abs() < 1e-3;
        assert!(vertices.into_iter().all(is_on), "{object}");
    }
}
