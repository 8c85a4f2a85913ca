//! Normal maps of mirrors against the law of reflection.

use catoptric::methods::Quality;
use catoptric::scene::model::Primitive;
use catoptric::scene::{Environment, Material, NormalMap, Sampler, Scene, Texture, TextureBinding};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Affine2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A flat mirror at y = 0 whose normal map holds one normal: x along the world's x, y along -z.
fn mirror(normal: Vec3, scale: f32, handedness: f32) -> Scene {
    let mut builder = SceneBuilder::new();
    let binding = TextureBinding { texture: 0, uv_channel: 0, texture_from_uv: Affine2::IDENTITY };
    let texture = Texture::from_normals("tilt", 2, 2, [normal; 4].into_iter(), Sampler::default());
    builder.model_mut().textures.push(Arc::new(texture));
    let normal_map = Some(NormalMap { binding, scale });
    let material = builder.material(Material { normal_map, ..Material::mirror("mirror", Vec3::ONE) });
    builder.primitive(
        "mirror",
        Primitive {
            positions: vec![
                Vec3::new(-9.0, 0.0, 9.0),
                Vec3::new(9.0, 0.0, 9.0),
                Vec3::new(9.0, 0.0, -9.0),
                Vec3::new(-9.0, 0.0, -9.0),
            ],
            normals: vec![Vec3::Y; 4],
            uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y], Vec::new()],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, handedness); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material,
            ..Primitive::default()
        },
    );
    builder.camera(Vec3::new(0.0, 3.0, 2.0), Vec3::ZERO, 20.0);
    let mut scene = builder.build();
    // A sky that differs in every direction.
    let (width, height) = (256u32, 128u32);
    let texel = |index: u32| {
        let (u, v) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        let direction = Environment::direction(u / width as f32, v / height as f32);
        (direction * 0.5 + 0.5).to_array()
    };
    scene.environment =
        Some(Arc::new(Environment::new("sky", width, height, (0..width * height).map(texel).collect())));
    scene
}

#[test]
fn a_normal_map_turns_reflected_rays_as_a_tilted_mirror_does() {
    let (width, height) = (24, 16);
    for (normal, scale, handedness) in [
        (Vec3::new(0.2, 0.1, 1.0), 1.0, 1.0),
        (Vec3::new(-0.1, 0.15, 1.0), 1.5, 1.0),
        (Vec3::new(0.1, 0.2, 1.0), 1.0, -1.0),
    ] {
        let scene = mirror(normal, scale, handedness);
        let view = scene.default_view(width, height);
        // The map's y is the cross product of normal and tangent, turned over where the file says so.
        let turned = (Vec3::new(normal.x * scale, normal.z, -normal.y * scale * handedness)).normalize();
        for method in ["reference", "multiperspective", "auto"] {
            let drawn = picture(method, "", &scene, &view, Quality { samples: 1, order: 1 });
            for (index, pixel) in drawn.pixels.iter().enumerate() {
                let at = Vec2::new((index as u32 % width) as f32 + 0.5, (index as u32 / width) as f32 + 0.5);
                let incoming = view.ray(at.x, at.y).direction;
                let reflected = incoming - turned * (2.0 * incoming.dot(turned));
                assert!(reflected.y > 0.01, "the ray leaves the mirror");
                let found = Vec3::new(pixel[0], pixel[1], pixel[2]) * 2.0 - 1.0;
                assert!((found - reflected).length() < 0.01, "{method}: {found} for {reflected}, {normal}");
            }
        }
    }
}
