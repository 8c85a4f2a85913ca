//! Surfaces whose lobes rays follow, of each kind, under a sky and a light.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::{DIFFUSE_BOUNCES, cast_shadows, shadow_sky};
use catoptric::methods::{self, Method, Quality};
use catoptric::progress::Silent;
use catoptric::scene::{AlphaMode, Environment, Light, LightKind, LobeTexture, Lobes, Material, Microfacets};
use catoptric::scene::{Sampler, Scene, Texture, TextureBinding};
use catoptric_gpu::Context;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Affine2, Vec3, Vec4};
use libtest_mimic::{Failed, Trial};
use std::sync::Arc;

const SIZE: [u32; 2] = [160, 96];

/// The mean light of what has lobes is the processor's to this share: a few wide cones stand for the lobes of frosted
/// glass, on both.
const LARGEST_ERROR: f32 = 0.03;

/// No more pixels of it than the other share are off by more than this: processor and device choose other rays, and the
/// light of each of 24 is off by as much as the scene's, about 0.3, of which a fifth is left.
const WRONG: f32 = 0.15;
const MOST_WRONG: f32 = 0.02;

/// Changes a material; textures are there to be bound.
type Change = fn(&mut Material, &TextureBinding);

/// Kinds of surfaces that are drawn together, as drivers take seconds for the shader of each scene.
const KINDS: [[(&str, Change); 4]; 2] = [OPAQUE, CLEAR];

const OPAQUE: [(&str, Change); 4] = [
    ("metal, rough by a texture", |material, texture| {
        material.microfacets = facets(1.0, 0.7, Some(texture));
    }),
    ("sharp metal in parts", |material, texture| {
        material.microfacets = facets(1.0, 0.0, Some(texture));
    }),
    ("a glossy dielectric", |material, _| {
        material.microfacets = facets(0.0, 0.3, None);
    }),
    ("a coat over metallic paint", |material, texture| {
        let coat = Some(Microfacets { coat: 1.0, coat_roughness: 0.1, ..facets(0.5, 0.6, None).unwrap_or_default() });
        (material.microfacets, material.coat, material.coat_texture) = (coat, 1.0, Some(texture.clone()));
    }),
];

const CLEAR: [(&str, Change); 4] = [
    ("thin glass", |material, texture| {
        material.microfacets = facets(0.0, 0.0, None);
        let lobes = material.lobes.get_or_insert_default();
        (lobes.transmission, lobes.is_thin, lobes.is_plate) = (0.9, true, true);
        lobes.textures[LobeTexture::Transmission as usize] = Some(texture.clone());
    }),
    ("thin frosted glass", |material, _| {
        material.microfacets = facets(0.0, 0.4, None);
        let lobes = material.lobes.get_or_insert_default();
        (lobes.transmission, lobes.is_thin) = (1.0, true);
    }),
    ("a frosted body", |material, _| {
        material.microfacets = facets(0.0, 0.3, None);
        material.absorption = Vec3::new(0.2, 0.9, 0.5);
        material.lobes.get_or_insert_default().transmission = 1.0;
    }),
    ("a veil", |material, _| {
        material.microfacets = facets(0.0, 0.4, None);
        (material.base_color.w, material.alpha_mode) = (0.6, AlphaMode::Blend);
    }),
];

pub(crate) fn trials(context: &Arc<Context>) -> impl Iterator<Item = Trial> {
    let qualities = [Quality { samples: 4, order: 2 }, Quality { samples: 1, order: 3 }];
    KINDS.into_iter().zip(qualities).map(|(kinds, quality)| {
        let (context, names) = (context.clone(), kinds.map(|(name, _)| name).join(", "));
        Trial::test(format!("lobes: {names}"), move || compare(&context, kinds, quality))
    })
}

fn facets(metallic: f32, roughness: f32, texture: Option<&TextureBinding>) -> Option<Microfacets> {
    Some(Microfacets { metallic, roughness, texture: texture.cloned(), ..Microfacets::default() })
}

/// A ball and a box with each material, by its number, on a floor before a wall.
fn scene(material: impl Fn(usize, &TextureBinding) -> Material) -> Result<Scene, Failed> {
    let mut builder = SceneBuilder::new();
    // Darker squares are smoother, less metallic and less clear.
    let texel = |index: u32| match (index % 32 / 8 + index / 32 / 8) % 2 {
        0 => [140, 110, 160, 255],
        _ => [255; 4],
    };
    let texels: Vec<[u8; 4]> = (0..32 * 32).map(texel).collect();
    let texture = Texture::from_linear8("squares", 32, 32, &texels, Sampler::default());
    builder.model_mut().textures.push(Arc::new(texture));
    let binding = TextureBinding { texture: 0, uv_channel: 0, texture_from_uv: Affine2::IDENTITY };
    let tested = [0, 1, 2, 3].map(|number| builder.material(material(number, &binding)));
    let squares = Material { base_texture: Some(binding), ..Material::diffuse("floor", Vec3::splat(0.6)) };
    let squares = builder.material(squares);
    let wall = builder.material(Material::diffuse("wall", Vec3::new(0.7, 0.3, 0.2)));
    builder.quad("floor", Vec3::new(-3.0, 0.0, 2.0), Vec3::X * 6.0, Vec3::Z * -4.0, squares);
    builder.quad("wall", Vec3::new(-3.0, 0.0, -2.0), Vec3::X * 6.0, Vec3::Y * 1.5, wall);
    for (number, material) in tested.into_iter().enumerate() {
        let x = number as f32 * 0.9 - 1.35;
        builder.sphere_mesh("ball", Vec3::new(x, 0.9, -0.4), 0.42, 24, material);
        let (low, high) = (Vec3::new(x - 0.36, 0.04, 0.2), Vec3::new(x + 0.36, 0.5, 0.9));
        builder.cuboid("box", low, high, false, material);
    }
    builder.camera(Vec3::new(0.6, 1.7, 4.5), Vec3::new(0.0, 0.55, 0.0), 34.0);
    let mut scene = builder.build();
    let texel = |index: usize| {
        let [across, down] = [(index % 64) as f32 / 64.0, (index / 64) as f32 / 32.0];
        let bright = if (0.3..0.4).contains(&across) && (0.2..0.5).contains(&down) { 1.5 } else { 0.0 };
        [0.3 + 0.4 * across + bright, 0.5 + bright, 0.9 - 0.6 * down + bright]
    };
    scene.environment = Some(Arc::new(Environment::new("sky", 64, 32, (0..64 * 32).map(texel).collect())));
    let direction = Vec3::new(-0.4, -0.8, -0.45).normalize();
    let (kind, intensity) = (LightKind::Directional, Vec3::splat(0.5));
    scene.lights.push(Light { kind, intensity, position: Vec3::ZERO, direction });
    cast_shadows(&mut scene);
    shadow_sky(&mut scene, DIFFUSE_BOUNCES, &Silent)?;
    Ok(scene)
}

fn compare(context: &Arc<Context>, kinds: [(&str, Change); 4], quality: Quality) -> Result<(), Failed> {
    let tested = |number: usize, texture: &TextureBinding| {
        let base = Material::diffuse("tested", Vec3::new(0.9, 0.7, 0.4));
        let mut material = Material { lobes: Some(Box::<Lobes>::default()), ..base };
        kinds[number].1(&mut material, texture);
        material
    };
    let mark = |number: usize| 100.0 * (number + 1) as f32;
    let marked = |number: usize, _: &TextureBinding| Material {
        unlit: true,
        ..Material::diffuse("marked", Vec3::splat(mark(number)))
    };
    let [tested, marked] = [Arc::new(scene(tested)?), Arc::new(scene(marked)?)];
    let processor = methods::create("auto", &Default::default())?;
    let device = catoptric_gpu::create(context, "auto", &Default::default())?.ok_or("drawn on the CPU")?;
    let marked = draw(&*processor, &marked, quality)?;
    let pictures = [draw(&device, &tested, quality)?, draw(&*processor, &tested, quality)?];
    let mut problems = Vec::new();
    for (number, (name, _)) in kinds.into_iter().enumerate() {
        let pixels: Vec<usize> = (0..marked.pixels.len()).filter(|at| marked.pixels[*at][0] == mark(number)).collect();
        if pixels.len() < 500 {
            problems.push(format!("{name}: {} pixels", pixels.len()));
        }
        let light = |picture: usize, pixel: usize| Vec4::from(pictures[picture].pixels[pixel]).truncate();
        let [ours, theirs] = [0, 1].map(|picture| pixels.iter().map(|at| light(picture, *at)).sum::<Vec3>());
        // Not a number: wrong.
        let is_wrong = |at: &&usize| !(light(0, **at) - light(1, **at)).abs().cmple(Vec3::splat(WRONG)).all();
        let wrong = pixels.iter().filter(is_wrong).count() as f32 / pixels.len() as f32;
        let ratio = ours / theirs;
        if !((ratio - 1.0).abs().cmple(Vec3::splat(LARGEST_ERROR)).all() && wrong <= MOST_WRONG) {
            let wrong = wrong * 100.0;
            problems.push(format!("{name}: {ratio:.3} of the processor's light, {wrong:.2} % of pixels are off"));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems.join("; ").into()) }
}

fn draw(method: &dyn Method, scene: &Arc<Scene>, quality: Quality) -> Result<Framebuffer, Failed> {
    let mut prepared = method.prepare(scene, quality, None, &Silent)?;
    let mut picture = Framebuffer::new(SIZE[0], SIZE[1]);
    let _ = prepared.frame(&scene.default_view(SIZE[0], SIZE[1]), &Silent)?.draw(&mut picture, &Silent)?;
    Ok(picture)
}
