//! Shadows of lights against closed forms: where they lie, what casts them, and that smooth meshes cast none on
//! themselves.

use catoptric::light::visibility::{cast_shadows, cast_shadows_as};
use catoptric::methods::Quality;
use catoptric::scene::model::{LightAsset, LocalTransform, Node};
use catoptric::scene::{AlphaMode, Camera, LightKind, Material, Scene};
use catoptric_testkit::drawing::picture;
use catoptric_testkit::scenes::SceneBuilder;
use glam::Vec3;

const LAMP: Vec3 = Vec3::new(0.5, 3.0, 0.0);
const CENTER: Vec3 = Vec3::new(0.0, 1.0, 0.0);
const RADIUS: f32 = 0.4;

/// A floor under a ball and a lamp.
fn floor_and_ball(ball: Material, is_mesh: bool) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let floor = builder.material(Material::diffuse("floor", Vec3::ONE));
    builder.quad("floor", Vec3::new(-3.0, 0.0, 3.0), Vec3::X * 6.0, Vec3::NEG_Z * 6.0, floor);
    let ball = builder.material(ball);
    match is_mesh {
        true => builder.sphere_mesh("ball", CENTER, RADIUS, 40, ball),
        false => builder.sphere("ball", CENTER, RADIUS, ball),
    }
    let light = LightAsset { kind: LightKind::Point { range: f32::INFINITY }, intensity: Vec3::splat(20.0) };
    let node = Node { local: LocalTransform::at(LAMP), light: Some(light), ..Node::default() };
    builder.model_mut().nodes.push(node);
    // From above, a pixel is a place of the floor.
    builder.camera(Vec3::new(0.0, 8.0, 0.01), Vec3::ZERO, 40.0);
    builder
}

fn with_shadows(mut scene: Scene) -> Scene {
    cast_shadows(&mut scene);
    scene
}

/// The places of the floor that are seen, whether a ball hides the lamp from each, and their brightness.
fn floor(scene: &Scene) -> Vec<(bool, f32)> {
    let (width, height) = (120, 120);
    let view = scene.default_view(width, height);
    let seen = picture("reference", "", scene, &view, Quality { samples: 1, order: 0 });
    let mut places = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let ray = view.ray(x as f32 + 0.5, y as f32 + 0.5);
            let at = ray.origin + ray.direction * (-ray.origin.y / ray.direction.y);
            let nearest = |from: Vec3, towards: Vec3| {
                let step = towards - from;
                let share = (CENTER - from).dot(step) / step.length_squared();
                (from + step * share.clamp(0.0, 1.0) - CENTER).length()
            };
            // Neither the ball itself nor its very rim.
            if nearest(ray.origin, at) < RADIUS * 1.05 || (nearest(at, LAMP) / RADIUS - 1.0).abs() < 0.03 {
                continue;
            }
            places.push((nearest(at, LAMP) < RADIUS, seen.pixels[(y * width + x) as usize][0]));
        }
    }
    places
}

#[test]
fn shadows_move_with_what_casts_them() {
    for is_mesh in [false, true] {
        let mut builder = floor_and_ball(Material::diffuse("ball", Vec3::ONE), is_mesh);
        let before = with_shadows(builder.model_mut().pose(&Default::default()).unwrap());
        let ball = builder.model_mut().nodes.iter_mut().find(|node| node.name == "ball").expect("it is there");
        let step = Vec3::new(0.3, 0.2, -0.4);
        ball.local = LocalTransform::at(if is_mesh { step } else { CENTER + step });
        let mut moved = builder.model_mut().pose(&Default::default()).unwrap();
        cast_shadows_as(&before, &mut moved);
        let means = |scene: &Scene| scene.light_visibility.clone().expect("there is a lamp");
        assert!(means(&before).moved_to(&moved).is_some(), "the means can move");
        let anew = with_shadows(builder.model_mut().pose(&Default::default()).unwrap());
        let picture = |scene: &Scene| {
            let camera = Camera::look_at("above", Vec3::new(0.0, 8.0, 0.01), Vec3::ZERO, Vec3::Y, 40.0);
            picture("reference", "", scene, &scene.view(&camera, 120, 120), Quality { samples: 1, order: 0 }).pixels
        };
        assert_eq!(picture(&moved), picture(&anew));
        assert_ne!(picture(&moved), picture(&before));
        // A scene that is no other moment of this one has means of its own.
        let mut other = floor_and_ball(Material::diffuse("ball", Vec3::ONE), !is_mesh).build();
        cast_shadows_as(&moved, &mut other);
        assert_eq!(picture(&other), picture(&with_shadows(other.clone())));
    }
}

#[test]
fn a_ball_hides_the_lamp_from_a_cone_behind_it() {
    for is_mesh in [false, true] {
        for ball in [Material::diffuse("ball", Vec3::ONE), Material::mirror("ball", Vec3::ONE)] {
            let scene = floor_and_ball(ball, is_mesh).build();
            assert!(floor(&scene).iter().all(|(_, light)| *light > 0.0), "without shadows all is lit");
            let places = floor(&with_shadows(scene));
            let hidden = places.iter().filter(|(is_hidden, _)| *is_hidden).count();
            assert!(hidden > 100, "{hidden}");
            for (is_hidden, light) in places {
                assert_eq!(is_hidden, light == 0.0);
            }
        }
    }
}

#[test]
fn unlit_surfaces_cast_no_shadows() {
    let unlit = Material { unlit: true, ..Material::diffuse("sky", Vec3::ONE) };
    let places = floor(&with_shadows(floor_and_ball(unlit, false).build()));
    assert!(places.iter().all(|(_, light)| *light > 0.0));
}

/// The share of light that enters glass, by Fresnel's equations.
fn entering(cosine: f32, ior: f32) -> f32 {
    let within = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
    let across = (cosine - ior * within) / (cosine + ior * within);
    let along = (within - ior * cosine) / (within + ior * cosine);
    1.0 - 0.5 * (across * across + along * along)
}

/// The light of the lamp on the floor beneath a ball, beside that without it, and how near its middle light passes, in
/// radii: where that is not at the rim.
fn light_through(ball: Material, is_mesh: bool) -> Vec<(f32, [f32; 3])> {
    let builder = || floor_and_ball(ball.clone(), is_mesh);
    let [without, with] = [builder().build(), with_shadows(builder().build())]
        .map(|scene| picture("reference", "", &scene, &scene.default_view(120, 120), Quality { samples: 1, order: 0 }));
    let view = builder().build().default_view(120, 120);
    let mut all = Vec::new();
    for (pixel, (without, with)) in without.pixels.iter().zip(&with.pixels).enumerate() {
        let ray = view.ray((pixel % 120) as f32 + 0.5, (pixel / 120) as f32 + 0.5);
        let at = ray.origin + ray.direction * (-ray.origin.y / ray.direction.y);
        let towards = (LAMP - at).normalize();
        let aside = (CENTER - at).reject_from_normalized(towards).length() / RADIUS;
        let is_floor_seen = (CENTER - ray.origin).reject_from_normalized(ray.direction).length() > RADIUS * 1.05;
        if is_floor_seen && aside < 0.85 && without[0] > 0.0 {
            all.push((aside, [0, 1, 2].map(|channel| with[channel] / without[channel])));
        }
    }
    assert!(all.len() > 50, "{}", all.len());
    all
}

#[test]
fn glass_weakens_and_tints_light() {
    let absorption = Vec3::new(0.2, 1.5, 0.0);
    for is_mesh in [false, true] {
        let ball = Material { absorption, ..Material::glass("ball", 1.5) };
        for (aside, light) in light_through(ball, is_mesh) {
            let cosine = (1.0 - aside * aside).sqrt();
            for channel in 0..3 {
                let through = (-absorption[channel] * 2.0 * RADIUS * cosine).exp();
                let expected = entering(cosine, 1.5).powi(2) * through;
                assert!((light[channel] - expected).abs() < 0.02, "{aside} {channel}: {} {expected}", light[channel]);
            }
        }
    }
}

#[test]
fn veils_let_pass_what_they_do_not_cover() {
    let veil = Material::diffuse("veil", Vec3::new(0.9, 0.1, 0.1));
    let veil = Material { base_color: veil.base_color.with_w(0.3), alpha_mode: AlphaMode::Blend, ..veil };
    for (_, light) in light_through(veil, true) {
        // The front and the back of the ball.
        assert!(light.iter().all(|light| (light - 0.49).abs() < 1e-4), "{light:?}");
    }
}

#[test]
fn coarse_balls_are_as_bright_as_their_normals_say() {
    // Seen from the lamp's side, up to where light grazes: flat neighbours would hide the lamp in steps there.
    let mut builder = floor_and_ball(Material::diffuse("ball", Vec3::ONE), true);
    let mesh = &mut builder.model_mut().meshes[1].primitives[0];
    let mut coarse = SceneBuilder::new();
    coarse.sphere_mesh("ball", CENTER, RADIUS, 8, mesh.material);
    *mesh = coarse.model_mut().meshes[0].primitives[0].clone();
    builder.camera(Vec3::new(1.5, 1.6, 1.2), CENTER, 30.0);
    let lit = builder.build();
    let view = lit.default_view(160, 120);
    let shadowed = with_shadows(lit.clone());
    let [without, with] =
        [&lit, &shadowed].map(|scene| picture("reference", "", scene, &view, Quality { samples: 1, order: 0 }));
    let mut on_ball = 0;
    for (pixel, (without, with)) in without.pixels.iter().zip(&with.pixels).enumerate() {
        let ray = view.ray((pixel % 160) as f32 + 0.5, (pixel / 160) as f32 + 0.5);
        let off = ray.origin + ray.direction * (CENTER - ray.origin).dot(ray.direction) - CENTER;
        if off.length() < RADIUS * 0.9 && without[0] > 0.0 {
            on_ball += 1;
            assert_eq!(without, with, "pixel {} {}", pixel % 160, pixel / 160);
        }
    }
    assert!(on_ball > 1000, "{on_ball}");
}
