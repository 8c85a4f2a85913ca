//! Transforms and samplers of textures.

use super::materials::{png, textured};
use super::*;
use catoptric_core::scene::{MipFilter, Sampler, Wrap};
use glam::Vec2;

#[test]
fn the_texture_transform_is_that_of_the_specification() {
    // From the extension's text: translation * rotation * scale as column-major matrices, rotation = (cos, -sin, 0;
    // sin, cos, 0; 0, 0, 1).
    let mut file = textured(&png([255; 4]), false);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = json!({
        "KHR_texture_transform": { "offset": [0, 1], "rotation": std::f32::consts::FRAC_PI_2, "scale": [0.5, 0.5] }
    });
    let map = file.model().materials[0].base_texture.as_ref().unwrap().texture_from_uv;
    assert!((map.transform_point2(Vec2::X) - Vec2::new(0.0, 0.5)).length() < 1e-6);
    assert!((map.transform_point2(Vec2::Y) - Vec2::new(0.5, 1.0)).length() < 1e-6);
}

#[test]
fn every_filter_and_wrap_is_understood() {
    let sampler_of = |sampler: Value| {
        let mut file = textured(&png([255; 4]), false);
        file.json["textures"][0]["sampler"] = json!(0);
        file.push("samplers", sampler);
        *file.model().textures[0].sampler()
    };
    let sampler = sampler_of(json!({ "magFilter": 9728, "minFilter": 9985, "wrapS": 33071, "wrapT": 33648 }));
    let expected = Sampler {
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::MirroredRepeat,
        magnify_linear: false,
        minify_linear: true,
        mip_filter: MipFilter::Nearest,
    };
    assert_eq!(sampler, expected);
    assert_eq!(sampler_of(json!({})), Sampler::default());
}
