//! Look-ups in cube maps.

use catoptric_engine::light::cube_map::CubeMap;
use glam::{Vec3, Vec4Swizzles};

/// A map whose radiance is the direction, shifted to be positive.
fn direction_map(size: u32) -> CubeMap {
    let pictures = (0..6).map(|face| {
        let view = CubeMap::face_view(face, Vec3::ZERO, size, 1e-3);
        let pixels = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
        pixels
            .map(|(x, y)| {
                let d = view.ray(x as f32 + 0.5, y as f32 + 0.5).direction;
                [d.x + 1.0, d.y + 1.0, d.z + 1.0, 1.0]
            })
            .collect()
    });
    CubeMap::new(size, pictures.collect())
}

#[test]
fn looking_up_a_direction_gives_that_direction() {
    let map = direction_map(64);
    let mut random = catoptric_core::math::random::Stream::new(3);
    for _ in 0..5000 {
        let mut number = || random.next_between(-1.0, 1.0);
        let direction = Vec3::new(number(), number(), number()).normalize();
        let found = map.radiance(direction * 3.0, 0.0).xyz() - 1.0;
        assert!((found - direction).length() < 1e-3, "{direction}: {found}");
    }
    // Exactly along edges and corners too.
    for direction in [Vec3::ONE, Vec3::new(1.0, 1.0, 0.0), Vec3::new(-1.0, 0.3, 1.0)] {
        let found = map.radiance(direction, 0.0).xyz() - 1.0;
        assert!((found - direction.normalize()).length() < 1e-3, "{direction}: {found}");
    }
}

#[test]
fn wide_spreads_average_and_odd_input_is_finite() {
    let map = direction_map(64);
    let blurred = map.radiance(Vec3::X, 3.0).xyz() - 1.0;
    assert!(blurred.x > 0.5 && blurred.y.abs() < 1e-3 && blurred.z.abs() < 1e-3, "{blurred}");
    for direction in [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::splat(f32::INFINITY)] {
        assert!(map.radiance(direction, f32::NAN).is_finite());
    }
}
