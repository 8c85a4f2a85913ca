//! Things that may hide a mirror.

use catoptric_core::math::Aabb;
use catoptric_projection::parts::may_hide;
use glam::Vec3;

#[test]
fn only_what_is_between_hides() {
    let cube = |center: Vec3, half: f32| Aabb { min: center - half, max: center + half };
    let mirror = cube(Vec3::new(10.0, 10.0, 0.0), 1.0);
    let eye = Vec3::ZERO;
    for (center, hides) in [
        (Vec3::new(5.0, 5.0, 0.0), true),
        (Vec3::new(9.0, 1.0, 0.0), false),
        (Vec3::new(-1.0, -1.0, 0.0), false),
        (Vec3::new(14.0, 14.0, 0.0), false),
        (Vec3::new(9.0, 9.0, 1.2), true),
        (Vec3::new(9.0, 9.0, 1.5), false),
        (Vec3::new(2.0, 2.0, 0.2), true),
        (Vec3::new(2.0, 2.0, 1.5), false),
    ] {
        assert_eq!(may_hide(&cube(center, 0.3), eye, &mirror), hides, "{center}");
    }
}
