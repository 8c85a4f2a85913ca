//! Cameras and views.

use catoptric_core::math::Aabb;
use catoptric_core::scene::{Camera, Projection, View};
use glam::{DVec2, DVec3, Vec2, Vec3};

fn views() -> [View; 2] {
    let camera = Camera::look_at("", Vec3::new(1.0, 2.0, 3.0), Vec3::new(-0.5, 0.0, 0.2), Vec3::Y, 50.0);
    let ortho = Camera { projection: Projection::Orthographic { half_height: 2.0 }, ..camera.clone() };
    [View::new(&camera, 640, 360, 0.01), View::new(&ortho, 640, 360, 0.01)]
}

#[test]
fn a_camera_looks_at_the_depth_of_the_centre_or_ahead() {
    let bounds = Aabb { min: Vec3::new(-1.0, -1.0, -1.0), max: Vec3::ONE };
    let camera = Camera::look_at("", Vec3::new(0.5, 0.0, 4.0), Vec3::new(0.5, 0.0, 0.0), Vec3::Y, 40.0);
    assert!((camera.point_looked_at(&bounds) - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-5);
    let away = Camera::look_at("", Vec3::new(0.0, 0.0, 4.0), Vec3::new(0.0, 0.0, 9.0), Vec3::Y, 40.0);
    assert!(away.point_looked_at(&bounds).z > 4.0);
}

#[test]
fn points_on_a_pixels_ray_project_to_that_pixel() {
    for view in views() {
        for (x, y) in [(0.5, 0.5), (320.0, 180.0), (639.5, 12.25)] {
            let ray = view.ray(x, y);
            let pixel = view.pixel_of(ray.origin + ray.direction * 3.7).unwrap();
            assert!((pixel - Vec2::new(x, y)).length() < 1e-3, "{pixel} against {x}, {y}");
        }
    }
}

#[test]
fn positions_in_double_precision_and_their_changes_agree_with_pixels() {
    for view in views() {
        let point = Vec3::new(-0.3, 0.4, -0.8);
        let pixel = view.pixel_of(point).unwrap();
        let exact = view.pixel_of_exact(point.as_dvec3()).unwrap();
        assert!((pixel.as_dvec2() - exact).length() < 1e-3, "{pixel} against {exact}");
        let (position, changes) = view.picture_from_world().pixel_with_change(point).unwrap();
        assert!((position - pixel).length() < 1e-3);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let step = axis * 1e-5;
            let at = |step: DVec3| view.pixel_of_exact(point.as_dvec3() + step).unwrap();
            let difference = (at(step) - at(-step)) / 2e-5;
            let change = DVec2::from(changes.map(|change| change.as_dvec3().dot(axis)));
            assert!((difference - change).length() < 1e-3 * (1.0 + difference.length()), "{difference} {change}");
        }
        assert_eq!(view.pixel_of_exact(view.eye().as_dvec3() + view.world_from_view.matrix3.z_axis.as_dvec3()), None);
    }
}

#[test]
fn differentials_match_differences() {
    for view in views() {
        let (_, differential) = view.ray_with_differential(100.0, 200.0);
        let difference = |dx: f32, dy: f32| {
            let (a, b) = (view.ray(100.0 - dx, 200.0 - dy), view.ray(100.0 + dx, 200.0 + dy));
            ((b.origin - a.origin) * 0.5, (b.direction - a.direction) * 0.5)
        };
        let (ox, dx) = difference(1.0, 0.0);
        let (oy, dy) = difference(0.0, 1.0);
        assert!((ox - differential.origin_dx).length() < 1e-5);
        assert!((oy - differential.origin_dy).length() < 1e-5);
        assert!((dx - differential.direction_dx).length() < 1e-5);
        assert!((dy - differential.direction_dy).length() < 1e-5);
    }
}

#[test]
fn degenerate_cameras_are_finite() {
    for (eye, target, up) in
        [(Vec3::ZERO, Vec3::ZERO, Vec3::Y), (Vec3::ZERO, Vec3::Y, Vec3::Y), (Vec3::ZERO, Vec3::X, Vec3::ZERO)]
    {
        let camera = Camera::look_at("", eye, target, up, 40.0);
        assert!(camera.world_from_camera.is_finite());
        assert!((camera.world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-5);
    }
}
