//! Bytes that identify scenes.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use catoptric_core::scene::{Environment, PoseOptions, Role, Scene};
use catoptric_scenes::builtin;

fn scene(name: &str) -> Scene {
    builtin::parse(name).unwrap().pose(&PoseOptions::default()).unwrap()
}

fn identity(scene: &Scene, left_out: impl Fn(u32) -> bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    scene.write_identity(left_out, &mut |piece| bytes.extend_from_slice(piece));
    bytes
}

#[test]
fn the_same_scene_has_the_same_identity() {
    let one = identity(&scene("sphere_room"), |_| false);
    assert_eq!(one, identity(&scene("sphere_room"), |_| false));
    let mut renamed = scene("sphere_room");
    renamed.name = "another".into();
    renamed.cameras.clear();
    assert_eq!(one, identity(&renamed, |_| false));
}

/// One change of each kind of thing.
#[test]
fn whatever_is_seen_counts() {
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 10] = [
        ("a position", |scene| scene.positions[7].x += 1e-6),
        ("a normal", |scene| scene.normals[7] = -scene.normals[7]),
        ("texture coordinates", |scene| scene.uvs[7][0].x += 1e-3),
        ("a triangle", |scene| scene.triangles[3].swap(0, 1)),
        ("a colour", |scene| scene.materials[1].base_color.x *= 0.999_999),
        ("a role", |scene| scene.materials[0].role = Role::Lens),
        ("colours of vertices", |scene| scene.colors = vec![[1.0; 4]; scene.positions.len()]),
        ("the region", |scene| scene.region = Some(scene.bounds)),
        ("an object", |scene| drop(scene.objects.pop())),
        ("the environment", |scene| {
            scene.environment = Some(Environment::new("", 2, 1, vec![[1.0; 3]; 2]).into());
        }),
    ];
    let before = identity(&scene("sphere_room"), |_| false);
    for (what, change) in changes {
        let mut changed = scene("sphere_room");
        change(&mut changed);
        assert_ne!(before, identity(&changed, |_| false), "{what}");
    }
}

/// A reflector that moves may be left out.
#[test]
fn what_is_left_out_does_not_count() {
    let mut moved = scene("sphere_room");
    let ball = moved.specular_objects()[0];
    let left_out = |object| object == ball;
    let before = identity(&scene("sphere_room"), left_out);
    let object = moved.objects[ball as usize].clone();
    for vertex in object.vertices {
        moved.positions[vertex as usize].y += 0.1;
    }
    assert_eq!(before, identity(&moved, left_out));
    assert_ne!(identity(&scene("sphere_room"), |_| false), identity(&moved, |_| false));
}
