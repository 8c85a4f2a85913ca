//! Changes of rays with the position in the picture, against differences.

use catoptric_core::scene::model::*;
use catoptric_core::scene::{Camera, Material, Ray, RayDifferential, Scene, View};
use catoptric_core::surface::AnalyticSurface;
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::tracer::Tracer;
use glam::Vec3;

/// A ball and a smooth patch of triangles, seen obliquely.
fn scene(material: Material) -> Scene {
    let mut model = Model { materials: vec![material], ..Model::default() };
    let surface = AnalyticSurface::Sphere { radius: 1.0 };
    let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
    model.nodes.push(Node { analytic, ..Node::default() });
    let normal = |x: f32, y: f32| Vec3::new(x * 0.2, y * 0.3, 1.0).normalize();
    let primitive = Primitive {
        positions: vec![Vec3::new(1.5, -1.0, 0.0), Vec3::new(4.0, -1.0, 0.3), Vec3::new(2.0, 2.0, 0.1)],
        normals: vec![normal(0.0, 0.0), normal(1.0, 0.0), normal(0.0, 1.0)],
        triangles: vec![[0, 1, 2]],
        ..Primitive::default()
    };
    model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
    model.nodes.push(Node { mesh: Some(0), ..Node::default() });
    model.pose(&Default::default()).expect("the model is valid")
}

/// The child of a view ray at its first hit.
fn child(scene: &Scene, view: &View, x_px: f32, y_px: f32) -> (Ray, RayDifferential) {
    let tracer = Tracer::build(scene, |_| true);
    let mut paths = PathTracer::new(scene, &tracer, PathModel::Tree, 4);
    let (ray, change) = view.ray_with_differential(x_px, y_px);
    paths.child(ray, change).expect("light goes on at the first hit")
}

#[test]
fn ray_changes_match_differences() {
    let camera = Camera::look_at("", Vec3::new(1.2, 0.4, 6.0), Vec3::new(1.2, 0.2, 0.0), Vec3::Y, 45.0);
    let view = View::new(&camera, 400, 300, 1e-3);
    for material in [Material::mirror("", Vec3::ONE), Material::glass("", 1.4)] {
        let scene = scene(material);
        for (x, y) in [(110.0, 150.0), (90.0, 130.0), (280.0, 160.0), (300.0, 175.0)] {
            let change = child(&scene, &view, x, y).1;
            let step = 0.5;
            let (a, b) = (child(&scene, &view, x - step, y).0, child(&scene, &view, x + step, y).0);
            let origin = (b.origin - a.origin) / (2.0 * step);
            let direction = (b.direction - a.direction) / (2.0 * step);
            assert!((origin - change.origin_dx).length() < 2e-3 * origin.length(), "{x} {y}: {origin}");
            assert!((direction - change.direction_dx).length() < 5e-3 * direction.length(), "{x} {y}: {direction}");
            let (a, b) = (child(&scene, &view, x, y - step).0, child(&scene, &view, x, y + step).0);
            let direction = (b.direction - a.direction) / (2.0 * step);
            assert!((direction - change.direction_dy).length() < 5e-3 * direction.length(), "{x} {y}: {direction}");
        }
    }
}
