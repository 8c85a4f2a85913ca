//! Blended mirrors: the reference against closed forms, and the other methods against the reference.

use catoptric::light::path_tracer::{PathModel, PathTracer};
use catoptric::light::tracer::Tracer;
use catoptric::methods::Quality;
use catoptric::scene::{Attenuation, Blend, Environment, Material, Ray, Role, Scene};
use catoptric_testkit::drawing::{error, picture, scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;
use std::sync::Arc;

const RAMP: Blend = Blend { fresnel: Some([0.15, 0.85]), attenuation: None, diffuse: None, highlight_roughness: None };
const FADE: Attenuation = Attenuation { distance: 8.0, specularity: [0.2, 0.95] };

fn radiance(scene: &Scene, order: u32, origin: Vec3, direction: Vec3) -> Vec3 {
    let tracer = Tracer::build(scene, |_| true);
    let ray = Ray { origin, direction: direction.normalize() };
    PathTracer::new(scene, &tracer, PathModel::Tree, order).radiance_along(ray, None, 0.0)
}

/// The weight of a reflection by the formulas of the paper, written down once more.
fn weight(blend: &Blend, cosine: f32, distance: f32) -> f32 {
    let by_angle = blend.fresnel.map_or(1.0, |[least, greatest]| least + (greatest - least) * cosine.powi(2));
    let by_distance =
        blend.attenuation.map_or(1.0, |Attenuation { distance: full, specularity: [least, greatest] }| {
            if distance >= full { least } else { greatest - (greatest - least) * distance.powi(2) / full.powi(2) }
        });
    by_angle * by_distance
}

#[track_caller]
fn assert_near(found: Vec3, expected: Vec3) {
    assert!((found - expected).abs().max_element() < 2e-6, "{found} where {expected} is due");
}

const TINT: Vec3 = Vec3::new(0.9, 0.8, 0.7);
const OWN: Vec3 = Vec3::new(0.1, 0.2, 0.6);
const WALL: Vec3 = Vec3::new(0.8, 0.5, 0.3);

/// An unlit mirror at z = 0 that looks at an unlit wall at z = 5.
fn before_a_wall(blend: Blend, unlit: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material {
        unlit,
        blend: Some(Blend { diffuse: Some(OWN), ..blend }),
        ..Material::mirror("mirror", TINT)
    });
    builder.quad("mirror", Vec3::new(-4.0, -4.0, 0.0), Vec3::X * 8.0, Vec3::Y * 8.0, mirror);
    let wall = builder.flat("wall", WALL);
    builder.quad("wall", Vec3::new(-90.0, -90.0, 5.0), Vec3::X * 180.0, Vec3::Y * 180.0, wall);
    builder.build()
}

#[test]
fn a_flat_mirror_before_a_wall_is_what_the_formulas_say() {
    let eye = Vec3::new(0.3, -0.2, 3.0);
    let directions = [Vec3::NEG_Z, Vec3::new(0.4, 0.2, -1.0), Vec3::new(-1.0, 0.3, -1.0), Vec3::new(1.1, 0.9, -1.0)];
    for blend in [RAMP, Blend { fresnel: None, ..RAMP }, Blend { attenuation: Some(FADE), ..RAMP }] {
        for fading in [blend.attenuation, Some(FADE), Some(Attenuation { distance: 5.5, ..FADE })] {
            let blend = Blend { attenuation: fading, ..blend };
            let (scene, lit) = (before_a_wall(blend, true), before_a_wall(blend, false));
            for direction in directions {
                let cosine = -direction.normalize().z;
                let share = weight(&blend, cosine, 5.0 / cosine);
                let reflection = TINT * WALL * share;
                assert_near(radiance(&scene, 1, eye, direction), reflection + OWN * (1.0 - share));
                // The headlight shines on the mirror from the eye.
                assert_near(radiance(&lit, 1, eye, direction), reflection + OWN * cosine * (1.0 - share));
                // At the end of paths the reflection is black, as if it showed something infinitely far away.
                let share = weight(&blend, cosine, f32::INFINITY);
                assert_near(radiance(&scene, 0, eye, direction), OWN * (1.0 - share));
            }
        }
    }
}

#[test]
fn the_sky_is_infinitely_far() {
    let blend = Blend { attenuation: Some(FADE), ..RAMP };
    let mut scene = before_a_wall(blend, true);
    scene.objects.retain(|object| object.name != "wall");
    scene.environment = Some(Arc::new(Environment::new("sky", 8, 4, vec![[2.0, 3.0, 4.0]; 32])));
    let direction = Vec3::new(0.3, -0.4, -1.0);
    let share = weight(&blend, -direction.normalize().z, f32::INFINITY);
    let sky = Vec3::new(2.0, 3.0, 4.0);
    assert_near(radiance(&scene, 1, Vec3::Z * 3.0, direction) / 4.0, (TINT * sky * share + OWN * (1.0 - share)) / 4.0);
}

#[test]
fn every_mirror_of_a_path_weighs_the_segment_that_leaves_it() {
    let first = Blend { attenuation: Some(FADE), diffuse: Some(OWN), ..RAMP };
    let fading = Attenuation { distance: 4.0, specularity: [0.3, 0.8] };
    let second = Blend { fresnel: Some([0.0, 0.9]), attenuation: Some(fading), ..Blend::default() };
    let mut builder = SceneBuilder::new();
    let lower = builder.material(Material { unlit: true, blend: Some(first), ..Material::mirror("lower", TINT) });
    // Without a colour of its own it has that of its material.
    let upper = builder.material(Material { unlit: true, blend: Some(second), ..Material::mirror("upper", WALL) });
    builder.quad("lower", Vec3::new(-2.0, -2.0, 0.0), Vec3::X * 4.0, Vec3::Y * 4.0, lower);
    builder.quad("upper", Vec3::new(2.5, -2.0, 4.0), Vec3::Y * 4.0, Vec3::X * 2.0, upper);
    let wall = builder.flat("wall", Vec3::ONE);
    builder.quad("wall", Vec3::new(4.0, -2.0, 1.0), Vec3::X * 3.0, Vec3::Y * 4.0, wall);
    let scene = builder.build();
    // Down to (1.5, 0), up to (3.5, 4), down to (5, 1).
    let direction = Vec3::new(0.5, 0.0, -1.0);
    let cosine = -direction.normalize().z;
    let (one, two) = (weight(&first, cosine, 4.0 / cosine), weight(&second, cosine, 3.0 / cosine));
    let seen = WALL * two + WALL * (1.0 - two);
    assert_near(radiance(&scene, 2, Vec3::Z * 3.0, direction), TINT * seen * one + OWN * (1.0 - one));
    // At order 1 the upper mirror shows its own colour alone.
    let seen = WALL * (1.0 - weight(&second, cosine, f32::INFINITY));
    assert_near(radiance(&scene, 1, Vec3::Z * 3.0, direction), TINT * seen * one + OWN * (1.0 - one));
}

/// The scene with all its mirrors blended.
fn blended(scene: &Scene, blend: Option<Blend>) -> Scene {
    let mut scene = scene.clone();
    scene.materials.iter_mut().filter(|material| material.role == Role::Reflector).for_each(|m| m.blend = blend);
    scene
}

/// Blended mirrors are drawn no worse than plain ones, but for `more` of the pixels: at edges the weights differ, too,
/// and where a plain mirror is black (beyond the order) nothing can be wrong.
#[track_caller]
fn assert_no_worse(what: &str, id: &str, settings: &str, scene: &Scene, order: u32, more: f64) {
    let own = Some(Vec3::new(0.3, 0.45, 0.5));
    let attenuation = Some(Attenuation { distance: 2.0, specularity: [0.1, 1.0] });
    let error = |blend: Option<Blend>| {
        let scene = blended(scene, blend);
        error(id, settings, &scene, &scene.default_view(120, 90), Quality { samples: 1, order })
    };
    let plain = error(None);
    for (fresnel, attenuation) in
        [(Some([0.2, 1.0]), None), (None, attenuation), (Some([0.2, 1.0]), attenuation), (Some([0.5, 0.5]), None)]
    {
        let blend = Blend { fresnel, attenuation, diffuse: own, ..Blend::default() };
        let found = error(Some(blend));
        assert!(found.flip_mean <= plain.flip_mean + more, "{what}, {blend:?}: {found:?} beside {plain:?}");
        assert!(found.over_0_1 <= plain.over_0_1 + more, "{what}, {blend:?}: {found:?} beside {plain:?}");
    }
}

#[test]
fn projection_methods_weigh_as_the_reference_does() {
    let flat = scene("planar_mirror?mirrors=2");
    let ball = scene("sphere_room?surface=analytic&tess=24");
    let pair = scene("two_spheres?surface=analytic&tess=8");
    assert_no_worse("planar mirrors", "planar_mirror", "", &flat, 3, 1e-3);
    assert_no_worse("a ball, path perturbation", "path_perturbation", "", &ball, 1, 1e-3);
    assert_no_worse("a ball, sample-based cameras", "sample_based_camera", "", &ball, 1, 1e-3);
    assert_no_worse("two balls, path perturbation", "path_perturbation", "", &pair, 2, 1e-3);
}

#[test]
fn mirrors_behind_glass_scatter_once() {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 8, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::splat(-3.0), Vec3::splat(3.0), true, walls);
    let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.95)));
    builder.quad("mirror", Vec3::new(-1.0, -1.0, -1.5), Vec3::X * 2.0, Vec3::Y * 2.0, mirror);
    let glass = builder.material(Material::glass("glass", 1.5));
    builder.cuboid("slab", Vec3::new(-2.9, -2.9, 0.0), Vec3::new(2.9, 2.9, 0.2), false, glass);
    // Seen in the mirror, before the path passes the glass again.
    let red = builder.flat("red", Vec3::new(0.8, 0.1, 0.1));
    builder.cuboid("box", Vec3::new(-0.6, -0.5, -0.9), Vec3::new(0.1, 0.3, -0.5), false, red);
    builder.camera(Vec3::new(0.3, 0.2, 2.6), Vec3::new(0.0, 0.0, -1.5), 50.0);
    assert_no_worse("a mirror behind glass", "path_perturbation", "", &builder.build(), 3, 4e-3);
}

#[test]
fn box_parallax_has_the_distance_in_a_box() {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 4, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::splat(-2.0), Vec3::splat(2.0), true, walls);
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    builder.sphere("ball", Vec3::ZERO, 0.7, mirror);
    builder.camera(Vec3::new(0.4, 0.5, 1.8), Vec3::ZERO, 50.0);
    assert_no_worse("a ball in a box", "environment_map", "parallax = 'box'", &builder.build(), 1, 1e-3);
}

#[test]
fn blends_that_change_nothing_change_nothing() {
    let ball = scene("sphere_room?surface=analytic&tess=8");
    let idle = Blend {
        fresnel: Some([1.0, 1.0]),
        attenuation: Some(Attenuation { distance: 1.0, specularity: [1.0, 1.0] }),
        ..Blend::default()
    };
    let view = ball.default_view(60, 45);
    let quality = Quality { samples: 1, order: 1 };
    for id in ["reference", "path_perturbation", "environment_map"] {
        let [plain, idle] = [None, Some(idle)].map(|blend| picture(id, "", &blended(&ball, blend), &view, quality));
        let differ = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-5);
        assert!(!plain.pixels.iter().zip(&idle.pixels).any(differ), "{id}");
    }
}
