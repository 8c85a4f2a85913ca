//! Scenes far from the origin.

use catoptric_core::scene::model::{CameraAsset, LocalTransform, MeshAsset, Model, Node, Primitive};
use catoptric_core::scene::{Material, Projection};
use glam::{Affine3A, Vec3};

/// A triangle and a camera in front of it, below nodes that stand far away.
fn model(away: &[Vec3]) -> Model {
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for (index, step) in away.iter().enumerate() {
        let parent = index.checked_sub(1);
        model.nodes.push(Node { parent, local: LocalTransform::at(*step), ..Node::default() });
    }
    let primitive = Primitive {
        positions: vec![Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.1, 0.2, 0.3), Vec3::new(0.1, 1.3, 0.3)],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    let parent = model.nodes.len().checked_sub(1);
    model.nodes.push(Node { parent, mesh: Some(0), ..Node::default() });
    model.nodes.push(Node { parent, local: LocalTransform::at(Vec3::new(0.3, 0.2, 4.1)), ..Node::default() });
    model.cameras.push(CameraAsset {
        name: "camera".into(),
        other_name: String::new(),
        node: Some(model.nodes.len() - 1),
        placement: Affine3A::IDENTITY,
        projection: Projection::Perspective { fov_y: 0.7 },
    });
    model
}

/// A scene far away has the same coordinates, but for the origin, as one near the origin: nodes add up in double
/// precision before anything is rounded.
#[test]
fn scenes_far_away_are_those_near_the_origin() {
    let near = model(&[]).pose(&Default::default()).unwrap();
    let mut far = model(&[Vec3::new(4.5e6, 20.0, -6.0e6), Vec3::new(-0.25, 0.0, 0.125)]);
    far.move_near_origin().unwrap();
    assert!(far.warnings.is_empty(), "{:?}", far.warnings);
    let scene = far.pose(&Default::default()).unwrap();
    assert_eq!(scene.origin, far.origin);
    let shift = (glam::DVec3::new(4.5e6 - 0.25, 20.0, -6.0e6 + 0.125) - scene.origin).as_vec3();
    assert!(shift.length() < 2.0, "{shift}");
    for (one, other) in scene.positions.iter().zip(&near.positions) {
        assert!((*one - *other - shift).abs().max_element() < 3e-7, "{one} {other}");
    }
    let eyes = [&scene, &near].map(|scene| Vec3::from(scene.cameras[0].world_from_camera.translation));
    assert!((eyes[0] - eyes[1] - shift).abs().max_element() < 5e-7, "{eyes:?}");
    assert_eq!(near.origin, glam::DVec3::ZERO);
}

/// Numbers that the file has rounded already are told.
#[test]
fn meshes_that_are_rounded_coarsely_are_told() {
    let mut far = model(&[]);
    for position in &mut far.meshes[0].primitives[0].positions {
        *position += Vec3::X * 4.5e6;
    }
    far.move_near_origin().unwrap();
    assert!(far.warnings[0].contains("steps of about 5.4e-1"), "{:?}", far.warnings);
}
