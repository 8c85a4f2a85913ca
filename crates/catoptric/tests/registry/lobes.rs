//! A ball of every lobe between coloured walls, drawn without tracing first rays, against the reference.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::surface_mask;
use catoptric::light::visibility::shadow_sky;
use catoptric::methods::Quality;
use catoptric::metrics::Comparison;
use catoptric::progress::Silent;
use catoptric::scene::{AlphaMode, Environment, Film, Lobes, Material, Microfacets, Scene};
use catoptric_scenes::studio;
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// The surfaces, each with the share of its picture that may differ by more than 0.1.
fn surfaces() -> Vec<(&'static str, Material, f64)> {
    let of = |metallic: f32, roughness: f32, lobes: Lobes| Material {
        microfacets: Some(Microfacets { metallic, roughness, ..Microfacets::default() }),
        lobes: Some(Box::new(lobes)),
        ior: 1.5,
        ..Material::diffuse("lobes", Vec3::new(0.8, 0.7, 0.6))
    };
    let film = Film { share: 1.0, ior: 1.4, thickness_nm: [0.0, 420.0] };
    let clear = Lobes { transmission: 1.0, ..Lobes::default() };
    let coat = |roughness: f32| {
        let paint = of(0.3, 0.6, Lobes::default());
        let facets = paint.microfacets.clone().map(|facets| Microfacets { coat_roughness: roughness, ..facets });
        Material { coat: 1.0, microfacets: facets, ..paint }
    };
    let veil = of(0.0, 1.0, Lobes::default());
    let sheen = Lobes { sheen: Vec3::new(0.9, 0.5, 0.3), sheen_roughness: 0.4, ..Lobes::default() };
    let leaf = Lobes { diffuse_transmission: 0.6, diffuse_transmission_color: Vec3::Y, ..Lobes::default() };
    vec![
        ("smooth metal", of(1.0, 0.0, Lobes::default()), 0.017),
        ("satin metal", of(1.0, 0.3, Lobes::default()), 0.01),
        ("cast metal", of(1.0, 0.9, Lobes::default()), 0.004),
        ("brushed metal", of(1.0, 0.3, Lobes { anisotropy: 0.7, ..Lobes::default() }), 0.01),
        ("half metal", of(0.5, 0.2, Lobes::default()), 0.003),
        ("varnish", of(0.0, 0.1, Lobes::default()), 0.004),
        ("satin paint", of(0.0, 0.6, Lobes::default()), 0.001),
        ("a coat", coat(0.0), 0.005),
        ("a rough coat", coat(0.4), 0.001),
        ("a film", of(0.0, 0.1, Lobes { film: Some(film), ..Lobes::default() }), 0.002),
        ("a film on metal", of(1.0, 0.2, Lobes { film: Some(film), ..Lobes::default() }), 0.008),
        ("cloth", of(0.0, 0.9, sheen), 0.001),
        ("a leaf", of(0.0, 0.9, leaf), 0.001),
        ("clear glass", of(0.0, 0.0, clear.clone()), 0.004),
        ("frosted glass", of(0.0, 0.4, clear.clone()), 0.012),
        ("dispersing glass", of(0.0, 0.0, Lobes { dispersion: 5.0, ..clear.clone() }), 0.004),
        ("a thin bulb", of(0.0, 0.0, Lobes { is_thin: true, ..clear.clone() }), 0.002),
        ("a frosted bulb", of(0.0, 0.4, Lobes { is_thin: true, ..clear }), 0.006),
        ("a veil", Material { base_color: Vec4::splat(0.5), alpha_mode: AlphaMode::Blend, ..veil }, 0.001),
    ]
}

fn between_walls(material: Material, sky: &Arc<Environment>) -> Scene {
    let mut builder = SceneBuilder::new();
    let ball = builder.material(material);
    builder.sphere_mesh("ball", Vec3::ZERO, 1.0, 24, ball);
    let [red, blue, grey] =
        [(0.9, 0.15, 0.1), (0.1, 0.2, 0.9), (0.4, 0.4, 0.4)].map(|(r, g, b)| builder.flat("wall", Vec3::new(r, g, b)));
    builder.quad("left", Vec3::new(-2.0, -1.0, 2.0), Vec3::Z * -4.0, Vec3::Y * 2.5, red);
    builder.quad("right", Vec3::new(2.0, -1.0, -2.0), Vec3::Z * 4.0, Vec3::Y * 2.5, blue);
    builder.quad("floor", Vec3::new(-2.0, -1.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0, grey);
    builder.camera(Vec3::new(0.0, 0.6, 5.0), Vec3::ZERO, 36.0);
    let mut scene = builder.build();
    scene.tangents = scene.normals.iter().map(|n| Vec3::Y.cross(*n).normalize_or(Vec3::X).extend(1.0)).collect();
    scene.environment = Some(sky.clone());
    scene
}

#[test]
fn every_lobe_is_drawn_as_the_reference_draws_it() {
    let sky = Arc::new(studio());
    for (name, material, limit) in surfaces() {
        let scene = between_walls(material, &sky);
        let view = scene.default_view(48, 36);
        let truth = picture("reference", "", &scene, &view, Quality { samples: 36, order: 4 });
        let drawn = picture("auto", "", &scene, &view, Quality { samples: 4, order: 4 });
        let mask = surface_mask(&scene, &view);
        let error = Comparison::new(&drawn, &truth).and_then(|comparison| comparison.masked(&mask));
        let error = error.expect("pictures of one size").expect("the scene is seen");
        assert!(error.over_0_1 <= limit, "{name}: {:.4} over {limit}", error.over_0_1);
    }
}

/// A box that glows as brightly as the sky around it hides nothing: a white rough floor under it looks like both. What
/// neighbours' rays find, and what they miss, add up to all light wherever they start.
#[test]
fn rays_that_neighbours_share_lose_and_add_no_light() {
    for roughness in [0.3, 0.6, 1.0] {
        let mut builder = SceneBuilder::new();
        let facets = Microfacets { metallic: 1.0, roughness, ..Microfacets::default() };
        let white = builder.material(Material {
            microfacets: Some(facets),
            lobes: Some(Box::default()),
            ..Material::diffuse("floor", Vec3::ONE)
        });
        builder.quad("floor", Vec3::new(-9.0, 0.0, 9.0), Vec3::X * 18.0, Vec3::Z * -18.0, white);
        let glowing = builder.flat("box", Vec3::ONE);
        builder.quad("wall", Vec3::new(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Y * 1.5, glowing);
        builder.quad("roof", Vec3::new(-1.0, 1.5, -1.0), Vec3::X * 2.0, Vec3::Z * -2.0, glowing);
        builder.camera(Vec3::new(0.5, 2.0, 4.0), Vec3::new(0.0, 0.2, 0.0), 40.0);
        let mut scene = builder.build();
        scene.environment = Some(Arc::new(Environment::new("even", 64, 32, vec![[1.0; 3]; 64 * 32])));
        let view = scene.default_view(60, 40);
        let drawn = picture("auto", "", &scene, &view, Quality { samples: 4, order: 4 });
        for (index, pixel) in drawn.pixels.iter().enumerate() {
            let off = (Vec4::from(*pixel).truncate() - 1.0).abs().max_element();
            assert!(off < 0.03, "roughness {roughness}, pixel {index}: {pixel:?}");
        }
    }
}

/// A small lamp, ten thousand times as bright as what is around it, above a rough plate: pixels do not sparkle, and the
/// light of the plate is that of the reference.
#[test]
fn small_emitters_are_sought_by_rays_of_their_own() {
    let mut builder = SceneBuilder::new();
    let facets = Microfacets { metallic: 1.0, roughness: 0.5, ..Microfacets::default() };
    let plate = builder.material(Material {
        microfacets: Some(facets),
        lobes: Some(Box::default()),
        ..Material::diffuse("plate", Vec3::splat(0.8))
    });
    builder.quad("plate", Vec3::new(-2.0, 0.0, 2.0), Vec3::X * 4.0, Vec3::Z * -4.0, plate);
    let lamp = Material { emissive: Vec3::splat(100.0), ..Material::diffuse("lamp", Vec3::ZERO) };
    let lamp = builder.material(lamp);
    builder.quad("lamp", Vec3::new(-0.05, 1.0, -0.05), Vec3::X * 0.1, Vec3::Z * 0.1, lamp);
    builder.camera(Vec3::new(0.0, 1.6, 4.0), Vec3::ZERO, 40.0);
    let mut scene = builder.build();
    scene.environment = Some(Arc::new(Environment::new("dark", 64, 32, vec![[0.01; 3]; 64 * 32])));
    shadow_sky(&mut scene, 0, &Silent).expect("nobody cancels it");
    let view = scene.default_view(48, 32);
    let quality = Quality { samples: 4, order: 2 };
    let drawn = picture("auto", "", &scene, &view, quality);
    let truth = picture("reference", "", &scene, &view, Quality { samples: 576, ..quality });
    let lit = |picture: &Framebuffer| -> Vec<f32> { picture.pixels.iter().map(|pixel| pixel[0]).collect() };
    let (drawn, truth) = (lit(&drawn), lit(&truth));
    // Below the lamp.
    let plates: Vec<usize> = (truth.len() / 2..truth.len()).filter(|index| truth[*index] > 0.05).collect();
    let sum = |light: &[f32]| plates.iter().map(|index| light[*index]).sum::<f32>();
    let ratio = sum(&drawn) / sum(&truth);
    assert!((ratio - 1.0).abs() < 0.05, "light: {ratio}");
    let far_off = plates.iter().filter(|index| (drawn[**index] / truth[**index]).ln().abs() > 0.5).count();
    assert!(far_off * 50 < plates.len(), "{far_off} of {} pixels", plates.len());
}
