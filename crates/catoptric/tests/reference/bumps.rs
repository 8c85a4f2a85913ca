//! Normal maps of mirrors and glass against the laws of reflection and refraction.

use catoptric::methods::Quality;
use catoptric::scene::model::Primitive;
use catoptric::scene::{Environment, Material, NormalMap, Sampler, Scene, Texture, TextureBinding};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Affine2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A flat surface at y = 0 of a material to which a normal map comes, with so many copies of two times two normals: x
/// along the world's x, y along -z; in a sky of radiance by direction.
fn bumpy(
    material: Material,
    normals: [Vec3; 4],
    copies: f32,
    scale: f32,
    handedness: f32,
    sky: impl Fn(Vec3) -> Vec3,
) -> Scene {
    let mut builder = SceneBuilder::new();
    let binding =
        TextureBinding { texture: 0, uv_channel: 0, texture_from_uv: Affine2::from_scale(Vec2::splat(copies)) };
    let texture = Texture::from_normals("tilt", 2, 2, normals.into_iter(), Sampler::default());
    builder.model_mut().textures.push(Arc::new(texture));
    let normal_map = Some(NormalMap { binding, scale });
    let material = builder.material(Material { normal_map, ..material });
    builder.primitive(
        "surface",
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
    let (width, height) = (256u32, 128u32);
    let texel = |index: u32| {
        let (u, v) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        sky(Environment::direction(u / width as f32, v / height as f32)).to_array()
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
        // A sky that differs in every direction.
        let mirror = Material::mirror("mirror", Vec3::ONE);
        let scene = bumpy(mirror, [normal; 4], 1.0, scale, handedness, |direction| direction * 0.5 + 0.5);
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

/// The share of unpolarised light that glass of an index reflects at an angle of incidence (Fresnel, by the angles'
/// sines and tangents).
fn fresnel(incidence: f64, index: f64) -> f64 {
    let refraction = (incidence.sin() / index).asin();
    let (difference, sum) = (incidence - refraction, incidence + refraction);
    0.5 * ((difference.sin() / sum.sin()).powi(2) + (difference.tan() / sum.tan()).powi(2))
}

/// The light of a sky of squared directions that a facet with a unit normal shows, in glass of this index; `None`: a
/// mirror.
fn shown(incoming: Vec3, normal: Vec3, index: Option<f32>) -> Vec3 {
    let cosine = -incoming.dot(normal);
    let reflected = incoming + normal * (2.0 * cosine);
    let Some(index) = index else { return reflected * reflected };
    // The part along the surface shrinks by the index.
    let along = (incoming + normal * cosine) / index;
    let refracted = along - normal * (1.0 - along.length_squared()).sqrt();
    let share = fresnel(f64::from(cosine).acos(), f64::from(index)) as f32;
    reflected * reflected * share + refracted * refracted * (1.0 - share)
}

#[test]
fn bumps_smaller_than_a_pixel_spread_light_as_all_of_them_together_do() {
    let (width, height) = (48, 32);
    for (index, tilt, spread) in [(None, 0.15, 0.04), (Some(1.5), 0.4, 0.03)] {
        let tilted =
            [(tilt, 0.0), (0.0, tilt), (-tilt, 0.0), (0.0, -tilt)].map(|(x, y)| Vec3::new(x, y, 1.0).normalize());
        let material = match index {
            None => Material::mirror("mirror", Vec3::ONE),
            Some(index) => Material::glass("glass", index),
        };
        // Means of squares depend on how far normals spread, and on nothing else.
        let scene = bumpy(material, tilted, 20_000.0, 1.0, 1.0, |direction| direction * direction);
        let view = scene.default_view(width, height);
        let mean = |of_pixel: &dyn Fn(Vec2) -> Vec3| {
            let at = |index: u32| Vec2::new((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            (0..width * height).map(|index| of_pixel(at(index))).sum::<Vec3>() / (width * height) as f32
        };
        let seen_in = |normal: Vec3, at: Vec2| shown(view.ray(at.x, at.y).direction, normal, index);
        let bumpy = mean(&|at| {
            tilted.iter().map(|normal| seen_in(Vec3::new(normal.x, normal.z, -normal.y), at)).sum::<Vec3>() * 0.25
        });
        let flat = mean(&|at| seen_in(Vec3::Y, at));
        assert!((bumpy - flat).abs().max_element() > spread, "{bumpy} {flat}");
        for method in ["reference", "multiperspective", "auto"] {
            let drawn = picture(method, "", &scene, &view, Quality { samples: 4, order: 1 });
            let found = mean(&|at| {
                let pixel = drawn.pixels[(at.y as u32 * width + at.x as u32) as usize];
                Vec3::new(pixel[0], pixel[1], pixel[2])
            });
            assert!((found - bumpy).abs().max_element() < 0.005, "{method}: {found} for {bumpy}, {flat} if flat");
        }
    }
}
