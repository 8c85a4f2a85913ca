//! Texels that no picture reads.

use catoptric_core::scene::{Ray, RayDifferential};
use catoptric_engine::light::parallax_proxy::ParallaxProxy;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_lookup::parts::{Layer, LayerTexture, Missing, Observation, Observations, Shell, TexelLayout};
use glam::Vec3;

#[test]
fn what_is_far_from_what_was_read_is_missing() {
    let center = Vec3::new(3.0, -1.0, 2.0);
    let layout = TexelLayout::cube(256);
    let texture = LayerTexture { texels: Vec::new(), layout };
    let layer = Layer { center, shell: Shell::Around(ParallaxProxy::Sphere(4.0)), distances: None, texture };
    let towards = |direction: Vec3| Ray { origin: center, direction: direction.normalize() };
    let observation = Observation {
        pixel: [0, 0],
        first: BounceKind::Reflect,
        ray: towards(Vec3::X),
        change: RayDifferential::default(),
        confidence: 1.0,
    };
    let mut picture = Observations::default();
    picture.list.push(observation);
    let missing = Missing::from(&layer, [&picture]);
    let likelihood = |degrees: f32| {
        let (up, along) = degrees.to_radians().sin_cos();
        missing.likelihood(layer.texel_at(&towards(Vec3::new(along, up, 0.0))).unwrap())
    };
    assert_eq!(likelihood(0.0), 0.0);
    // A texel in the middle of a face is 0.45 degrees wide.
    assert!((likelihood(2.5) - 0.25).abs() < 0.12, "{}", likelihood(2.5));
    assert_eq!((likelihood(8.0), likelihood(180.0)), (1.0, 1.0));
    assert_eq!(missing.likelihood(u32::MAX), 0.0, "what is beyond a square is not missing");
    let nothing = Missing::from(&layer, []);
    assert_eq!(nothing.likelihood(5), 1.0);
}
