//! The automatic choice: flat and curved mirrors and glass in one frame, each in the others.

use catoptric::methods::{Choice, Quality};
use catoptric::metrics::Comparison;
use catoptric::scene::model::Primitive;
use catoptric::scene::{Material, Scene};
use catoptric_testkit::drawing::{draw, picture, reflector_error, scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Vec2, Vec3};

const ID: &str = "auto";

/// A flat mirror, a mirror ball and a glass ball before it, and a panel of `side` x `side` squares.
fn flat_and_curved(side: u32) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 6, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, walls);
    let red = builder.checker("red", 4, [200, 30, 20], [240, 190, 60]);
    builder.cuboid("box", Vec3::new(0.9, -1.0, 0.3), Vec3::new(1.4, -0.2, 0.8), false, red);
    builder.primitive("panel", panel(side, red));
    let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.95)));
    builder.quad("flat", Vec3::new(-1.8, -1.2, -2.8), Vec3::X * 3.6, Vec3::Y * 2.4, mirror);
    builder.sphere_mesh("ball", Vec3::new(-0.6, 0.0, -1.0), 0.6, 48, mirror);
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.sphere_mesh("glass", Vec3::new(0.7, 0.1, -0.6), 0.45, 48, glass);
    builder.camera(Vec3::new(0.4, 0.5, 2.8), Vec3::new(0.0, 0.0, -1.0), 50.0);
    builder.build()
}

/// A square on a side wall.
fn panel(side: u32, material: usize) -> Primitive {
    let mut panel = Primitive { material, ..Primitive::default() };
    for index in 0..(side + 1).pow(2) {
        let [column, row] = [index % (side + 1), index / (side + 1)].map(|place| place as f32 / side as f32);
        panel.positions.push(Vec3::new(-2.9, row, 1.0 - 2.0 * column));
        panel.normals.push(Vec3::X);
        panel.uvs[0].push(Vec2::new(column, row));
    }
    for square in 0..side.pow(2) {
        let a = square / side * (side + 1) + square % side;
        let (b, c, d) = (a + 1, a + side + 2, a + side + 1);
        panel.triangles.extend([[a, b, c], [a, c, d]]);
    }
    panel
}

#[test]
fn flat_mirrors_curved_ones_and_glass_show_each_other_as_in_the_reference() {
    let scene = flat_and_curved(1);
    let view = scene.default_view(300, 200);
    for order in 1..=4 {
        let quality = Quality { samples: 4, order };
        let drawn = draw(ID, "", &scene, &view, quality);
        let error = reflector_error(&drawn.picture, &picture("reference", "", &scene, &view, quality), &scene, &view);
        assert!(error.over_0_1 <= 0.006 && error.flip_mean <= 0.02, "order {order}: {error:?}");
        // The direct view, and the copy in the flat mirror: nothing else shows it, as no other mirror is flat.
        assert_eq!(drawn.report.counts["lists"], 2);
        assert!(drawn.report.error_px.is_some_and(|error| error > 0.0 && error <= 0.5));
    }
}

#[test]
fn what_is_chosen_is_reported_with_its_reason() {
    let choice = |object: &str, method, reason: &str| Choice { object: object.into(), method, reason: reason.into() };
    let scene = flat_and_curved(1);
    let view = scene.default_view(60, 40);
    let report = draw(ID, "", &scene, &view, Quality { samples: 1, order: 1 }).setup;
    let expected = [
        choice("flat", "planar_mirror", "flat"),
        choice("ball", "multiperspective", "curved"),
        choice("glass", "multiperspective", "glass"),
    ];
    assert_eq!(report.choices, expected);
}

#[test]
fn flat_mirrors_of_scenes_too_large_to_copy_are_drawn_by_tiles() {
    let (small, large) = (flat_and_curved(1), flat_and_curved(550));
    let view = large.default_view(120, 80);
    let quality = Quality { samples: 4, order: 2 };
    let drawn = draw(ID, "", &large, &view, quality);
    assert_eq!(drawn.report.counts["lists"], 1);
    assert!(drawn.setup.choices[0].reason.contains("flat, but a copy of the scene has"), "{:?}", drawn.setup.choices);
    let error = reflector_error(&drawn.picture, &picture("reference", "", &small, &view, quality), &small, &view);
    assert!(error.over_0_1 <= 0.01, "{error:?}");
}

#[test]
fn scenes_without_mirrors_are_drawn() {
    let mut plain = scene("sphere_room");
    for material in &mut plain.materials {
        material.role = catoptric::scene::Role::Diffuse;
    }
    let view = plain.default_view(60, 40);
    let quality = Quality { samples: 4, order: 2 };
    let drawn = draw(ID, "", &plain, &view, quality);
    assert!(drawn.setup.choices.is_empty());
    let comparison = Comparison::new(&drawn.picture, &picture("reference", "", &plain, &view, quality));
    let error = comparison.expect("they have the same size").whole().expect("the picture has pixels");
    assert!(error.over_0_1 <= 0.01, "{error:?}");
}
