//! Shells and textures as they are stored.

use catoptric_core::math::Aabb;
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_lookup::parts::{
    LayerTexel, PartShells, Quad, Shell, TexelLayout, face_texels, shells_of_bytes, shells_to_bytes, texels_of,
};
use glam::Vec3;

#[test]
fn shells_come_back_as_they_were() {
    let shells = vec![
        Shell::Around(ParallaxProxy::Infinite),
        Shell::Around(ParallaxProxy::Box(Aabb { min: Vec3::splat(-1.5), max: Vec3::new(2.0, 3.0, 4.0) })),
        Shell::Around(ParallaxProxy::Sphere(0.25)),
        Shell::Around(ParallaxProxy::Cylinder { radius: 2.0, bottom: -1.0, top: 7.0 }),
        Shell::Quad(Quad { middle: Vec3::Z, normal: Vec3::Z, right: Vec3::X, up: Vec3::Y }),
    ];
    let parts = vec![
        PartShells { center: Vec3::new(1.0, -2.0, 3.0), shells: shells.clone() },
        PartShells { center: Vec3::ZERO, shells: vec![] },
        PartShells { center: Vec3::X, shells: shells[2..3].to_vec() },
    ];
    let bytes = shells_to_bytes(2, 45, &parts);
    assert_eq!(shells_of_bytes(&bytes).unwrap(), (2, 45, parts.clone()));
    for length in 0..bytes.len() {
        assert_eq!(shells_of_bytes(&bytes[..length]), None, "{length}");
    }
    assert_eq!(shells_of_bytes(&[&bytes[..], &[0; 4]].concat()), None);
    // Numbers that are none, kinds that there are not, other counts.
    for (word, value) in [(3, f32::NAN.to_bits()), (6, 3), (7, 5), (0, 4), (1, u32::MAX), (6, u32::MAX)] {
        let mut other = bytes.clone();
        other[4 * word..4 * word + 4].copy_from_slice(&u32::to_le_bytes(value));
        assert_eq!(shells_of_bytes(&other), None, "word {word}");
    }
}

#[test]
fn textures_come_back_face_by_face() {
    for layout in [TexelLayout::cube(8), TexelLayout::square(4)] {
        let texel = |number: usize| LayerTexel::new(glam::Vec4::splat(number as f32));
        let texels: Vec<LayerTexel> = (0..layout.texel_count()).map(texel).collect();
        let face = |face| face_texels(&layout, &texels, face).flat_map(LayerTexel::to_bytes).collect::<Vec<u8>>();
        let faces: Vec<Vec<u8>> = (0..layout.faces()).map(face).collect();
        assert_eq!(texels_of(&layout, faces.iter().map(Vec::as_slice)), texels);
    }
}
