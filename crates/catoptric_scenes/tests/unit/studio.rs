//! Environments that need no file.

use catoptric_scenes::{sky, studio};
use glam::Vec3;

#[test]
fn white_is_neither_grey_nor_burnt_out() {
    let studio = studio();
    let up = studio.irradiance(Vec3::Y) / std::f32::consts::PI;
    assert!((0.8..1.1).contains(&up.x), "{up}");
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y] {
        let side = studio.irradiance(normal) / std::f32::consts::PI;
        assert!((0.2..1.0).contains(&side.x), "{normal}: {side}");
    }
}

/// Luminances of the sky, and the sun's illuminance, against the formulas of Preetham, Shirley, Smits 1999, worked out
/// for a turbidity of 2.5 and the sun at 45 degrees.
#[test]
fn the_sky_is_that_of_its_model() {
    let sky = sky();
    let luminance = |light: Vec3| light.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    assert!((luminance(sky.irradiance(Vec3::Y)) / std::f32::consts::PI - 0.8).abs() < 0.02);
    let away = Vec3::new(0.642, 0.0, -0.766).normalize();
    let (zenith, other) = (sky.radiance(Vec3::Y), sky.radiance((Vec3::Y + away).normalize()));
    assert!((luminance(other) / luminance(zenith) - 4.49 / 5.916).abs() < 0.01);
    assert!(zenith.z > 2.0 * zenith.x, "{zenith} is no blue");
    // The sun: 97.0, 89.5, 73.9 kilolux of red, green and blue, where the zenith has 5.916 kilocandela.
    let lamps = sky.lamps().expect("the sun");
    let light: Vec3 = lamps.all().iter().map(|lamp| lamp.light).sum();
    let towards: Vec3 = lamps.all().iter().map(|lamp| lamp.towards * lamp.brightness).sum();
    let expected = Vec3::new(96.96, 89.46, 73.90) * (luminance(zenith) / 5.916);
    assert!((light / expected - Vec3::ONE).abs().max_element() < 0.05, "{light}, {expected}");
    assert!(towards.normalize().dot(Vec3::new(-0.642, 1.0, 0.766).normalize()) > 0.9999);
    // Grey paint is nowhere burnt out, and shadows are not black.
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y] {
        let side = luminance(sky.irradiance(normal)) / std::f32::consts::PI;
        assert!((0.1..1.0).contains(&side), "{normal}: {side}");
    }
}
