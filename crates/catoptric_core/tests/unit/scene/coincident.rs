//! Faces of different objects in one place.

use catoptric_core::scene::edits::MoveRule;
use catoptric_core::scene::model::{MeshAsset, Model, Node, Primitive};
use catoptric_core::scene::{AlphaMode, Material, PoseMemory, PoseOptions, Role, Scene};
use glam::{Quat, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// A rectangle of n by n pairs of triangles, turned, which faces along its third axis.
fn rectangle(middle: Vec3, half: [f32; 2], n: u32, turned: Quat) -> Primitive {
    let mut primitive = Primitive::default();
    for index in 0..(n + 1) * (n + 1) {
        let [column, row] = [index % (n + 1), index / (n + 1)].map(|step| 2.0 * step as f32 / n as f32 - 1.0);
        primitive.positions.push(turned * (middle + Vec3::new(column * half[0], row * half[1], 0.0)));
        primitive.normals.push(turned * Vec3::Z);
    }
    for (column, row) in (0..n).flat_map(|row| (0..n).map(move |column| (column, row))) {
        let first = row * (n + 1) + column;
        let above = first + n + 1;
        primitive.triangles.extend([[first, first + 1, above + 1], [first, above + 1, above]]);
    }
    primitive
}

/// A box with faces of their own vertices, twice as long as these along the axes.
fn block(middle: Vec3, half: Vec3, turned: Quat) -> Primitive {
    let mut all = Primitive::default();
    let quarters = (0..4).map(|quarter| Vec3::Y * quarter as f32).chain([Vec3::X, Vec3::NEG_X]);
    for side in quarters.map(|axis| Quat::from_scaled_axis(axis * FRAC_PI_2)) {
        let face = rectangle(Vec3::Z, [1.0; 2], 1, side);
        let first = all.positions.len() as u32;
        // Corners of a cube are whole numbers.
        all.positions.extend(face.positions.iter().map(|corner| turned * (middle + corner.round() * half)));
        all.normals.extend(face.normals.iter().map(|normal| turned * normal.round()));
        all.triangles.extend(face.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }
    all
}

fn model(parts: Vec<(&str, Material, Primitive)>) -> Model {
    let mut model = Model::default();
    for (index, (name, material, primitive)) in parts.into_iter().enumerate() {
        model.materials.push(material);
        let primitive = Primitive { material: index, ..primitive };
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        model.nodes.push(Node { name: name.into(), mesh: Some(index), ..Node::default() });
    }
    model
}

fn mirror() -> Material {
    Material { role: Role::Reflector, double_sided: true, ..Material::default() }
}

fn paint() -> Material {
    Material { double_sided: true, ..Material::default() }
}

/// How far the vertices of an object have been moved, each along a direction.
fn moved(model: &Model, scene: &Scene, object: usize, along: Vec3) -> Vec<f32> {
    let before = &model.meshes[object].primitives[0].positions;
    let vertices = scene.objects[object].vertices.clone();
    let after = &scene.positions[vertices.start as usize..vertices.end as usize];
    after.iter().zip(before).map(|(after, before)| (*after - *before).dot(along)).collect()
}

/// As large as single precision rounds the coordinates here.
const ROUNDING: f32 = 3e-7;

fn turned() -> Quat {
    Quat::from_axis_angle(Vec3::new(0.3, 1.0, 0.2).normalize(), 0.5)
}

#[test]
fn a_label_in_the_plane_of_glass_or_of_a_mirror_lies_before_it() {
    let along = turned() * Vec3::Z;
    let label = |turn: Quat| rectangle(Vec3::new(0.1, 0.05, 0.0), [0.3, 0.2], 7, turned() * turn);
    let pane = rectangle(Vec3::ZERO, [1.0, 0.8], 1, turned());
    let half = Vec3::new(1.0, 0.8, 0.5);
    let glass = block(Vec3::new(0.0, 0.0, -0.5), half, turned());
    let veil = Material { alpha_mode: AlphaMode::Blend, ..paint() };
    let upside_down = Quat::from_rotation_x(PI);
    for (host, material, label, of_label) in [
        (&pane, mirror(), label(Quat::IDENTITY), paint()),
        (&pane, mirror(), label(upside_down), paint()),
        (&pane, mirror(), label(Quat::IDENTITY), veil.clone()),
        (&glass, Material::glass("glass", 1.5), label(Quat::IDENTITY), paint()),
        (&glass, Material::glass("glass", 1.5), label(Quat::IDENTITY), veil),
        (&pane, paint(), label(Quat::IDENTITY), paint()),
    ] {
        let model = model(vec![("host", material, host.clone()), ("label", of_label, label)]);
        let scene = model.pose(&PoseOptions::default()).unwrap();
        let is_glass = model.materials[0].has_inside();
        let forward = moved(&model, &scene, 1, along);
        assert!(forward.iter().all(|way| if is_glass { *way == 0.0 } else { (5e-6..1e-4).contains(way) }));
        for (way, corner) in moved(&model, &scene, 0, along).iter().zip(&host.positions) {
            // All corners of the face, of whichever sides of the block they are.
            let is_of_face = is_glass && corner.dot(along).abs() < 1e-5;
            let expected = if is_of_face { -1e-3..-5e-6 } else { -ROUNDING..ROUNDING };
            assert!(expected.contains(way), "{way} at {corner}");
        }
    }
}

/// A label around a ball of glass, of the same triangles as the ball.
#[test]
fn what_is_bent_moves_as_far_as_what_is_flat() {
    let at = |row: u32, column: u32| {
        let (polar, around) = (row as f32 / 12.0 * PI, column as f32 / 24.0 * 2.0 * PI);
        turned() * Vec3::new(polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin())
    };
    let sphere = |rows: std::ops::Range<u32>, columns: u32| {
        let mut primitive = Primitive::default();
        for (row, column) in rows.flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let first = primitive.positions.len() as u32;
            let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            primitive.positions.extend(corners);
            primitive.normals.extend(corners);
            primitive.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        primitive
    };
    let glass = Material::glass("glass", 1.5);
    let model = model(vec![("ball", glass, sphere(0..12, 24)), ("label", paint(), sphere(4..8, 9))]);
    let scene = model.pose(&PoseOptions::default()).unwrap();
    let before = &model.meshes[0].primitives[0].positions;
    let inwards: Vec<f32> =
        before.iter().zip(&scene.positions).map(|(before, after)| before.length() - after.length()).collect();
    assert!(inwards.iter().any(|way| *way > 1e-4));
    assert!(inwards.iter().all(|way| way.abs() < ROUNDING || (3e-4..7e-4).contains(way)), "{inwards:?}");
}

#[test]
fn glass_stands_a_hair_above_the_table() {
    let up = turned() * Vec3::Y;
    let lying = turned() * Quat::from_rotation_x(-FRAC_PI_2);
    let table = rectangle(Vec3::ZERO, [3.0, 3.0], 4, lying);
    let glass = block(Vec3::new(0.1, 0.5, 0.2), Vec3::new(0.4, 0.5, 0.4), turned());
    let one_sided = Material { double_sided: false, ..paint() };
    let model = model(vec![("glass", Material::glass("glass", 1.5), glass.clone()), ("table", one_sided, table)]);
    let scene = model.pose(&PoseOptions::default()).unwrap();
    assert!(moved(&model, &scene, 1, up).iter().all(|way| *way == 0.0));
    for (way, corner) in moved(&model, &scene, 0, up).iter().zip(&glass.positions) {
        let expected = if corner.dot(up) < 0.5 { 5e-6..1e-3 } else { -ROUNDING..ROUNDING };
        assert!(expected.contains(way), "{way} at {corner}");
    }
}

#[test]
fn of_several_sheets_each_lies_before_the_larger_ones() {
    let sheets = [3.0, 1.0, 2.0, 0.5].map(|side| rectangle(Vec3::new(0.05, 0.0, 0.0), [side; 2], 1, turned()));
    let model = model(sheets.into_iter().map(|sheet| ("sheet", paint(), sheet)).collect());
    let scene = model.pose(&PoseOptions::default()).unwrap();
    let ways = [0, 2, 1, 3].map(|object| moved(&model, &scene, object, turned() * Vec3::Z));
    for pair in ways.windows(2) {
        let furthest = |ways: &[f32]| ways.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let nearest = |ways: &[f32]| ways.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(furthest(&pair[0]) < nearest(&pair[1]) - 5e-6, "{ways:?}");
    }
    assert!(ways[0].iter().all(|way| *way == 0.0));
}

#[test]
fn what_lies_beside_before_or_within_the_same_thing_stays() {
    let at = |x: f32, z: f32| rectangle(Vec3::new(x, 0.0, z), [1.0; 2], 2, turned());
    let side_by_side = model(vec![("one", mirror(), at(-1.0, 0.0)), ("other", paint(), at(1.0, 0.0))]);
    let apart = model(vec![("one", mirror(), at(0.0, 0.0)), ("other", paint(), at(0.5, 1e-4))]);
    let crossing = rectangle(Vec3::ZERO, [1.0; 2], 2, turned() * Quat::from_rotation_y(0.2));
    let crossed = model(vec![("one", mirror(), at(0.0, 0.0)), ("other", paint(), crossing)]);
    let mut alike = model(vec![("one", paint(), at(0.0, 0.0)), ("other", paint(), at(0.5, 0.0))]);
    alike.meshes[1].primitives[0].material = 0;
    let glass = |ior| Material::glass("glass", ior);
    let block = |x: f32| block(Vec3::new(x, 0.0, 0.0), Vec3::new(1.0, 0.5, 0.5), turned());
    let of_glass = model(vec![("one", glass(1.5), block(-1.0)), ("other", glass(1.33), block(1.0))]);
    for (number, model) in [side_by_side, apart, crossed, alike, of_glass].iter().enumerate() {
        let scene = model.pose(&PoseOptions::default()).unwrap();
        for object in 0..2 {
            let ways = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| moved(model, &scene, object, axis));
            assert!(ways.iter().flatten().all(|way| *way == 0.0), "{number}");
        }
    }
}

#[test]
fn what_has_moved_away_leaves_nothing_behind() {
    let host = rectangle(Vec3::ZERO, [2.0; 2], 1, Quat::IDENTITY);
    let labels = [-0.7, 0.7].map(|x| rectangle(Vec3::new(x, 0.0, 0.0), [0.3; 2], 3, Quat::IDENTITY));
    let [left, right] = labels;
    let model = model(vec![("host", mirror(), host), ("left", paint(), left), ("right", paint(), right)]);
    let mut memory = PoseMemory::default();
    let away = |name: &str| MoveRule::new(name, Vec3::Z * 0.5).unwrap();
    for moves in [vec![], vec![away("left")], vec![away("left"), away("right")], vec![], vec![away("host")]] {
        let options = PoseOptions { moves, ..PoseOptions::default() };
        let scene = model.pose_again(&options, &mut memory).unwrap();
        assert_eq!(scene.positions, model.pose(&options).unwrap().positions);
        let is_apart = options.moves.len() == 2 || options.moves.iter().any(|rule| rule.pattern() == "host");
        let has_moved = scene.positions.iter().any(|corner| ![0.0, 0.5].contains(&corner.z));
        assert_eq!(has_moved, !is_apart);
    }
}
