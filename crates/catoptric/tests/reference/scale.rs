//! Scenes of any size: what is a power of two larger, with its eye, is the same picture to the bit.

use catoptric::methods::{self, MethodInfo, Quality};
use catoptric::scene::{Camera, Material};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;

#[test]
fn scenes_of_any_size_are_the_same_pictures() {
    let drawn = |scale: f32, info: &MethodInfo| {
        let mut builder = SceneBuilder::new();
        let checker = builder.checker("checker", 8, [20, 60, 200], [240, 200, 40]);
        let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.9)));
        let glass = builder.material(Material::glass("glass", 1.5));
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * scale;
        builder.quad("floor", at(-4.0, 0.0, 4.0), at(8.0, 0.0, 0.0), at(0.0, 0.0, -8.0), checker);
        builder.sphere_mesh("ball", at(-0.8, 1.0, 0.0), scale, 10, mirror);
        builder.cuboid("block", at(0.5, 0.1, -0.5), at(1.5, 1.1, 0.5), false, glass);
        let scene = builder.build();
        let camera = Camera::look_at("", at(0.5, 2.0, 5.0), at(0.0, 0.7, 0.0), Vec3::Y, 40.0);
        let quality = Quality { samples: 4, order: 2 };
        picture(info.id, info.limits.settings, &scene, &scene.view(&camera, 48, 36), quality).pixels
    };
    // Beyond these, squares of areas leave the range of single precision.
    for info in methods::all() {
        let expected = drawn(1.0, info);
        for exponent in [-24, 24] {
            let scaled = drawn(2f32.powi(exponent), info);
            let off = scaled.iter().zip(&expected).filter(|(one, other)| one != other).count();
            assert_eq!(off, 0, "{}, 2^{exponent}", info.id);
        }
    }
}
