//! Paths in flat mirrors, point by point.

use catoptric_core::scene::model::*;
use catoptric_core::scene::{Material, Scene};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::method::path_query::{FoundPath, PathSearch};
use catoptric_projection::parts::{MirrorSearch, Mirrors};
use glam::{DVec3, Quat, Vec3};

/// A floor (facing up) and a wall (facing +x, a square of triangles) that meet in the z axis, two units wide.
fn corner(inside: bool) -> (Scene, Mirrors) {
    let mut model = Model { materials: vec![Material::mirror("", Vec3::ONE)], ..Model::default() };
    let surface = AnalyticSurface::Plane { half_width: 1.0, half_height: 1.0 };
    let analytic = Some(AnalyticAsset { surface, material: 0, inside });
    let local = LocalTransform::at(Vec3::new(1.0, 0.0, 0.0));
    model.nodes.push(Node { name: "floor".into(), analytic, local, ..Node::default() });
    let primitive = Primitive {
        positions: [(0.0, -1.0), (2.0, -1.0), (2.0, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z)).to_vec(),
        normals: vec![Vec3::X; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { name: "wall".into(), mesh: Some(0), ..Node::default() });
    let scene = model.pose(&Default::default()).expect("a scene");
    let mirrors = Mirrors::find(&scene);
    (scene, mirrors)
}

fn found(search: &MirrorSearch<'_>, point: DVec3) -> Vec<(String, FoundPath)> {
    let mut paths = Vec::new();
    let outcome = search.search(point, &mut paths);
    assert_eq!((outcome.found, outcome.infinite), (paths.len(), false));
    let name = |path: &FoundPath| search.paths()[path.path as usize].names(search.scene);
    paths.iter().map(|path| (name(path), *path)).collect()
}

#[test]
fn a_corner_has_the_reflections_of_the_textbook() {
    let (scene, mirrors) = corner(false);
    let eye = DVec3::new(1.2, 0.7, 0.25);
    let point = DVec3::new(0.5, 1.0, -0.5);
    let search = MirrorSearch::new(&scene, &mirrors, eye, 4, &[0, 1]).unwrap();
    let all = found(&search, point);
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    // Each mirror shows one; the image in both is one point behind the edge, met in the order of the path's side.
    let images = [DVec3::new(0.5, -1.0, -0.5), DVec3::new(-0.5, 1.0, -0.5), DVec3::new(-0.5, -1.0, -0.5)];
    assert_eq!(names, ["wall", "floor", "floor>wall"]);
    for ((_, path), image) in all.iter().zip([images[1], images[0], images[2]]) {
        assert!((path.optical_length - eye.distance(image)).abs() < 1e-14);
        assert!(path.residual < 1e-14 && path.focal_index == 0);
        let line = (image - eye).normalize();
        assert!((path.bounce_points[0] - eye).cross(line).length() < 1e-14);
    }
    let (_, both) = &all[2];
    assert!(both.bounce_points[0].y.abs() < 1e-15 && both.bounce_points[1].x.abs() < 1e-15);
}

#[test]
fn jacobians_are_differences() {
    let (scene, mirrors) = corner(false);
    let (eye, point) = (DVec3::new(1.2, 0.7, 0.25), DVec3::new(0.5, 1.0, -0.5));
    let search = MirrorSearch::new(&scene, &mirrors, eye, 2, &[0, 1]).unwrap();
    for (index, (_, path)) in found(&search, point).iter().enumerate() {
        for (axis, column) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(0..) {
            let at = |step: f64| found(&search, point + axis * step)[index].1.bounce_points[0];
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((difference - path.jacobian.col(column)).length() < 1e-9, "{index} {axis}");
        }
    }
}

#[test]
fn mirrors_end_where_they_end_and_have_sides() {
    let (scene, mirrors) = corner(false);
    let eye = DVec3::new(1.0, 1.0, 0.0);
    let floor = MirrorSearch::new(&scene, &mirrors, eye, 1, &[0]).unwrap();
    // The bounce lies half way, by symmetry: the border is at x = 2.
    assert_eq!(found(&floor, DVec3::new(3.0, 1.0, 0.0)).len(), 1);
    assert_eq!(found(&floor, DVec3::new(3.0 + 1e-9, 1.0, 0.0)).len(), 0);
    // These points lie behind the mirror, on it, and at no place at all.
    for nowhere in [DVec3::new(1.0, -0.5, 0.0), DVec3::new(1.5, 0.0, 0.0), DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(found(&floor, nowhere).len(), 0, "{nowhere}");
    }
    assert!(found(&floor, DVec3::splat(1e300)).iter().all(|(_, path)| path.residual.is_finite()));
    let (scene, mirrors) = corner(true);
    let blind = MirrorSearch::new(&scene, &mirrors, eye, 1, &[0]).unwrap();
    assert_eq!(found(&blind, DVec3::new(1.5, 1.0, 0.0)).len(), 0);
    let below = MirrorSearch::new(&scene, &mirrors, -eye + DVec3::X * 2.0, 1, &[0]).unwrap();
    assert_eq!(found(&below, DVec3::new(1.5, -1.0, 0.0)).len(), 1);
}

#[test]
fn no_bounce_falls_between_the_triangles_of_a_mirror() {
    let (scene, mirrors) = corner(false);
    let eye = DVec3::new(1.0, 1.0, 0.0);
    let search = MirrorSearch::new(&scene, &mirrors, eye, 1, &[1]).unwrap();
    // The eye's own reflections over the diagonal of the wall: the bounce of a point at the same distance is
    // half way between.
    for step in 0..=1000 {
        let along = f64::from(step) / 1000.0;
        let bounce = DVec3::new(0.0, 2.0 * along, 2.0 * along - 1.0);
        let point = DVec3::new(1.0, 2.0 * bounce.y - eye.y, 2.0 * bounce.z - eye.z);
        assert_eq!(found(&search, point).len(), 1, "{bounce}");
    }
}

#[test]
fn sequences_without_end_are_refused() {
    let mut model = Model { materials: vec![Material::mirror("", Vec3::ONE)], ..Model::default() };
    for step in 0..60 {
        let surface = AnalyticSurface::Plane { half_width: 1.0, half_height: 1.0 };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
        let rotation = Quat::from_rotation_x(step as f32 * 0.1);
        let local = LocalTransform::Parts { translation: Vec3::ZERO, rotation, scale: Vec3::ONE };
        model.nodes.push(Node { analytic, local, ..Node::default() });
    }
    let scene = model.pose(&Default::default()).unwrap();
    let mirrors = Mirrors::find(&scene);
    let all: Vec<u32> = (0..60).collect();
    assert!(MirrorSearch::new(&scene, &mirrors, DVec3::ONE, 2, &all).is_ok());
    let refused = MirrorSearch::new(&scene, &mirrors, DVec3::ONE, 3, &all).err().map(|error| error.to_string());
    assert!(refused.is_some_and(|message| message.contains("sequences")));
}
