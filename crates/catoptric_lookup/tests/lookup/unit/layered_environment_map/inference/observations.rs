//! Confidence in observations.

use catoptric_core::scene::Ray;
use catoptric_lookup::parts::confidence;
use glam::Vec3;

#[test]
fn confidence_falls_with_the_square_of_the_largest_angle() {
    let turned = |degrees: f32| {
        let (x, y) = degrees.to_radians().sin_cos();
        Ray { origin: Vec3::ZERO, direction: Vec3::new(x, y, 0.0) }
    };
    assert_eq!(confidence(&[]), 0.0);
    assert_eq!(confidence(&[turned(70.0), turned(70.0)]), 1.0);
    let found = confidence(&[turned(0.0), turned(2.5), turned(1.0)]);
    assert!((found - 0.75).abs() < 1e-4, "{found}");
    assert_eq!(confidence(&[turned(0.0), turned(5.1)]), 0.0);
}
