//! The studio as light.

use catoptric_scenes::studio;
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
