//! Cameras of scenes that bring none.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Scene, View};
use glam::{Affine3A, Vec3, Vec3Swizzles};
use std::f32::consts::PI;

/// A scene of triangles alone, its fronts outwards.
fn boxes(boxes: &[Aabb], is_room: bool) -> Scene {
    let mut scene = Scene::default();
    for one in boxes {
        let first = scene.positions.len() as u32;
        scene.positions.extend(one.corners());
        // Corners count x, y, z up by bits.
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        for [a, b, c, d] in quads {
            for [a, b, c] in [[a, b, c], [a, c, d]] {
                let corners = if is_room { [a, c, b] } else { [a, b, c] };
                scene.triangles.push(corners.map(|corner| first + corner));
            }
        }
    }
    scene.bounds = Aabb::around(scene.positions.iter().copied());
    scene
}

fn silhouette(scene: &Scene, [width, height]: [u32; 2]) -> [f32; 4] {
    let view = View::new(&scene.framing(width as f32 / height as f32), width, height, 0.0);
    let pixels = Aabb::around(scene.positions.iter().map(|at| view.pixel_of(*at).unwrap().extend(0.0)));
    let size = Vec3::new(width as f32, height as f32, 1.0);
    let (min, max) = (pixels.min / size, pixels.max / size);
    [min.x, min.y, max.x, max.y]
}

#[test]
fn the_silhouette_fills_four_fifths_of_one_side_at_any_size_and_place() {
    for (size, place) in [(1.0, 0.0), (1e-6, 0.0), (1e7, 0.0), (3.0, 500.0)] {
        for extent in [Vec3::ONE, Vec3::new(9.0, 0.1, 0.2), Vec3::new(0.1, 7.0, 0.1), Vec3::new(1.0, 0.0, 1.0)] {
            let min = Vec3::splat(place) - extent * 0.3 * size;
            let scene = boxes(&[Aabb { min, max: min + extent * size }], false);
            for picture in [[640, 480], [1920, 1080], [300, 900]] {
                let [left, top, right, bottom] = silhouette(&scene, picture);
                let filled = (right - left).max(bottom - top);
                assert!((filled - 0.8).abs() < 2e-3, "{extent} {size} {picture:?}: {filled}");
                assert!(left > 0.05 && top > 0.05 && right < 0.95 && bottom < 0.95, "{extent} {size} {picture:?}");
            }
        }
    }
}

#[test]
fn what_turns_stays_in_the_picture_all_around() {
    let table = Aabb { min: Vec3::new(3.0, -1.0, 5.0), max: Vec3::new(7.0, 0.5, 5.4) };
    let scene = boxes(&[table, Aabb { min: Vec3::new(3.0, 0.5, 5.0), max: Vec3::new(3.2, 2.0, 5.2) }], false);
    let center = scene.bounds.center();
    for ([width, height], fov_deg) in [([640, 480], None), ([1920, 400], Some(70.0)), ([300, 900], Some(15.0))] {
        let camera = scene.framing_all_round(width as f32 / height as f32, fov_deg);
        let mut swept = Aabb::EMPTY;
        for degree in 0..360 {
            let turn = Affine3A::from_rotation_y((degree as f32).to_radians());
            let turned = |point: Vec3| center + turn.transform_vector3(point - center);
            let view = View::new(&camera, width, height, 0.0);
            for at in &scene.positions {
                swept = swept.with(view.pixel_of(turned(*at)).unwrap().extend(0.0));
            }
        }
        let size = Vec3::new(width as f32, height as f32, 1.0);
        let (min, max) = (swept.min / size, swept.max / size);
        let filled = (max - min).max_element();
        assert!((filled - 0.8).abs() < 2e-3, "{width}x{height}: {min} to {max}");
        assert!(min.truncate().min_element() > 0.05 && max.truncate().max_element() < 0.95, "{min} to {max}");
    }
    // Within a room it looks at the middle, from a place that is never beyond a wall.
    let room = Aabb { min: Vec3::new(-4.0, 0.0, -2.0), max: Vec3::new(4.0, 3.0, 2.0) };
    let eye: Vec3 = boxes(&[room], true).framing_all_round(1.5, None).world_from_camera.translation.into();
    assert!(eye.xz().length() < 2.0 && eye.y == 1.5, "{eye}");
}

#[test]
fn what_surrounds_the_eye_is_seen_from_within() {
    let room = Aabb { min: Vec3::new(-4.0, 0.0, -2.0), max: Vec3::new(4.0, 3.0, 2.0) };
    let scene = boxes(&[room], true);
    let camera = scene.framing(1.5);
    let (eye, back) = (camera.world_from_camera.translation, camera.world_from_camera.matrix3.z_axis);
    assert!(room.contains(eye.into()), "{eye}");
    assert!(back.x.abs() > 0.9, "along the room: {back}");
    assert!(eye.x * back.x > 1.0, "from one end of it: {eye}");
    // The same walls seen from behind are a box.
    let eye = boxes(&[room], false).framing(1.5).world_from_camera.translation;
    assert!(!room.contains(eye.into()), "{eye}");
    // Thick walls, a box with another box's inside in it, are a room if they are as large as one, or if things are
    // within.
    let outside = Aabb { min: room.min - 0.2, max: room.max + 0.2 };
    let chest = |x, z| Aabb { min: Vec3::new(x, 0.0, z), max: Vec3::new(x + 1.0, 1.2, z + 0.8) };
    let chests = [chest(-3.0, -1.8), chest(2.0, -1.8), chest(2.0, 1.0), chest(-3.0, 1.0)];
    let empty = with_triangles_of(boxes(&[outside], false), &scene);
    let furnished = with_triangles_of(boxes(&[&[outside], &chests[..]].concat(), false), &scene);
    let is_seen_from_within = |scene: &Scene, scale: f32| {
        let mut scene = scene.clone();
        scene.positions.iter_mut().for_each(|position| *position *= scale);
        scene.bounds = Aabb::around(scene.positions.iter().copied());
        scene.bounds.contains(scene.framing(1.0).world_from_camera.translation.into())
    };
    assert!(is_seen_from_within(&empty, 1.0) && !is_seen_from_within(&empty, 0.1));
    // A small body that is turned inside out is seen from outside, too.
    assert!(!is_seen_from_within(&scene, 0.1));
    assert!(is_seen_from_within(&furnished, 1.0) && is_seen_from_within(&furnished, 0.1));
}

fn with_triangles_of(mut scene: Scene, other: &Scene) -> Scene {
    let first = scene.positions.len() as u32;
    scene.positions.extend(&other.positions);
    scene.triangles.extend(other.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    scene
}

#[test]
fn small_bodies_whose_faces_stand_twice_once_turned_over_are_seen_from_outside() {
    for count in [3, 12, 60] {
        let mut ball = Scene::default();
        for row in 0..=count {
            for column in 0..2 * count {
                let (below_top, around) = (PI * row as f32 / count as f32, PI * column as f32 / count as f32);
                let (radius, up) = (0.9 * below_top.sin(), 0.9 * below_top.cos());
                ball.positions.push(Vec3::new(radius * around.cos(), up, radius * around.sin()));
            }
        }
        for row in 0..count {
            for column in 0..2 * count {
                let at = |row: u32, column: u32| row * 2 * count + column % (2 * count);
                let [a, b] = [at(row, column), at(row, column + 1)];
                let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
                ball.triangles.extend([[a, b, c], [b, d, c], [a, c, b], [b, c, d]]);
            }
        }
        ball.bounds = Aabb::around(ball.positions.iter().copied());
        let eye: Vec3 = ball.framing(1.0).world_from_camera.translation.into();
        assert!(eye.length() > 1.5, "{count}: {eye}");
    }
}

#[test]
fn nothing_to_be_seen_is_framed_too() {
    for scene in [Scene::default(), boxes(&[Aabb { min: Vec3::ONE, max: Vec3::ONE }], false)] {
        assert!(scene.framing(f32::NAN).world_from_camera.is_finite());
    }
}
