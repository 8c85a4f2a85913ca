//! Light from infinity on surfaces, by closed forms.

use catoptric::light::visibility::{cast_shadows, shadow_sky};
use catoptric::progress::{Cancelled, Progress, Silent};
use catoptric::scene::shade::Barycentrics;
use catoptric::scene::{Environment, Light, LightKind, Material, Scene};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

const FLOOR_SIZE: f32 = 40.0;

/// A white floor of two triangles in the plane y = 0 under what a builder is given, and a sky.
fn on_a_floor(sky: Environment, add: impl Fn(&mut SceneBuilder)) -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.material(Material::diffuse("white", Vec3::ONE));
    let corner = Vec3::new(-0.5, 0.0, 0.5) * FLOOR_SIZE;
    builder.quad("floor", corner, Vec3::X * FLOOR_SIZE, Vec3::Z * -FLOOR_SIZE, white);
    add(&mut builder);
    let mut scene = builder.build();
    scene.environment = Some(Arc::new(sky));
    shadow_sky(&mut scene, 0, &Silent).expect("nobody cancels it");
    scene
}

fn even_sky() -> Environment {
    Environment::new("even", 64, 32, vec![[1.0; 3]; 64 * 32])
}

/// The radiance of the floor at a place of it, seen from above.
fn floor_at(scene: &Scene, x: f32, z: f32) -> f32 {
    for triangle in scene.objects[0].triangles.clone() {
        let [a, b, c] = scene.triangles[triangle as usize].map(|vertex| scene.positions[vertex as usize]);
        let (ab, ac, ap) = (b - a, c - a, Vec3::new(x, 0.0, z) - a);
        let area = ab.cross(ac).y;
        let at = Vec2::new(ap.cross(ac).y, ab.cross(ap).y) / area;
        if at.min_element() >= 0.0 && at.element_sum() <= 1.0 {
            let barycentrics = Barycentrics { value: at, ..Default::default() };
            return scene.radiance(&scene.surface_point(triangle, &barycentrics), Vec3::Y).x;
        }
    }
    panic!("({x}, {z}) is beside the floor");
}

/// A ball hides the square of the sine of its half angle of an even sky from what is right below it; beside it, that
/// times the cosine of its direction, where it is above the horizon as a whole.
#[test]
fn a_ball_takes_its_share_of_an_even_sky() {
    let (radius, height) = (1.0, 2.0);
    let scene = on_a_floor(even_sky(), |builder| {
        let grey = builder.material(Material::diffuse("grey", Vec3::splat(0.5)));
        builder.sphere_mesh("ball", Vec3::Y * height, radius, 48, grey);
    });
    for (x, z) in [(0.0, 0.0), (0.3, -0.2), (0.7, 0.7), (-1.5, 0.4), (2.0, 2.0), (-4.0, 1.0), (0.0, 9.0)] {
        let distance2 = x * x + z * z + height * height;
        let expected = 1.0 - radius * radius / distance2 * (height / distance2.sqrt());
        let found = floor_at(&scene, x, z);
        assert!((found - expected).abs() < 0.025, "({x}, {z}): {found}, {expected}");
    }
}

/// The parts of a large floor beside a very small ball would be smaller than they may be.
#[test]
fn a_tiny_ball_on_a_large_floor_is_no_endless_work() {
    let scene = on_a_floor(even_sky(), |builder| {
        let grey = builder.material(Material::diffuse("grey", Vec3::splat(0.5)));
        builder.sphere_mesh("ball", Vec3::Y * 1e-3, 1e-3, 12, grey);
    });
    for (x, z) in [(0.3, -0.2), (5.0, 9.0), (-19.0, 0.5)] {
        assert!((floor_at(&scene, x, z) - 1.0).abs() < 0.01, "({x}, {z})");
    }
}

/// Before a long wall the part of an even sky that is seen is half of one plus the cosine of the wall's elevation.
#[test]
fn a_wall_takes_its_share_of_an_even_sky() {
    let height = 3.0;
    let scene = on_a_floor(even_sky(), |builder| {
        let grey = builder.material(Material::diffuse("grey", Vec3::splat(0.5)));
        builder.quad("wall", Vec3::new(-1000.0, 0.0, 0.0), Vec3::X * 2000.0, Vec3::Y * height, grey);
    });
    for distance in [0.3, 1.0, 2.0, 4.0, 8.0] {
        for z in [distance, -distance] {
            let expected = 0.5 * (1.0 + distance / f32::hypot(distance, height));
            let found = floor_at(&scene, 0.4, z);
            assert!((found - expected).abs() < 0.035, "{z}: {found}, {expected}");
        }
    }
}

/// The irradiance of a surface by a polygon of radiance 1 that it sees as a whole (Lambert 1760).
fn lambert(corners: [Vec3; 4], position: Vec3, normal: Vec3) -> f32 {
    let towards = corners.map(|corner| (corner - position).normalize());
    let of_edge = |edge: usize| {
        let (one, other) = (towards[edge], towards[(edge + 1) % 4]);
        one.angle_between(other) * one.cross(other).normalize().dot(normal)
    };
    0.5 * (0..4).map(of_edge).sum::<f32>().abs()
}

/// Light of a glowing panel is Lambert's of a polygon, and a screen below it takes it away.
#[test]
fn a_panel_lights_as_a_polygon_does() {
    let radiance = 3.0;
    let corner = Vec3::new(-1.0, 2.0, -0.5);
    let (along, across) = (Vec3::X * 2.0, Vec3::Z * 1.0);
    let dark = Environment::new("dark", 64, 32, vec![[0.0; 3]; 64 * 32]);
    let scene = on_a_floor(dark, |builder| {
        let glowing = Material { emissive: Vec3::splat(radiance), ..Material::diffuse("panel", Vec3::ZERO) };
        let glowing = builder.material(glowing);
        builder.quad("panel", corner, along, across, glowing);
        let black = builder.material(Material::diffuse("screen", Vec3::ZERO));
        builder.quad("screen", Vec3::new(-20.0, 1.0, -14.0), Vec3::X * 40.0, Vec3::Z * 8.0, black);
    });
    let panel = [corner, corner + along, corner + along + across, corner + across];
    for (x, z) in [(0.0, 0.0), (0.9, 0.4), (2.0, -1.0), (-3.0, 2.0), (0.0, 6.0)] {
        let expected = radiance * lambert(panel, Vec3::new(x, 0.0, z), Vec3::Y) / PI;
        let found = floor_at(&scene, x, z);
        assert!((found / expected - 1.0).abs() < 0.06, "({x}, {z}): {found}, {expected}");
    }
    assert_eq!(floor_at(&scene, 0.3, -14.0), 0.0);
}

/// A small bright part of a sky lights as a lamp at infinity does, with shadows as sharp; the sky is a turned one.
#[test]
fn suns_cast_sharp_shadows() {
    let (width, height) = (256u32, 128u32);
    let (towards, turn) = (Vec3::new(0.6, 0.64, 0.48), 0.8f32);
    let about_y = glam::Quat::from_rotation_y(turn);
    let mut light = Vec3::ZERO;
    let texels: Vec<[f32; 3]> = (0..width * height)
        .map(|index| {
            let [u, v] = [(index % width) as f32 + 0.5, (index / width) as f32 + 0.5];
            let (u, v) = (u / width as f32, v / height as f32);
            let direction = about_y * Environment::direction(u, v);
            let is_sun = direction.dot(towards) > 2.5f32.to_radians().cos();
            let radiance = if is_sun { Vec3::new(900.0, 700.0, 400.0) } else { Vec3::splat(0.2) };
            let solid_angle = 2.0 * PI * PI / (width * height) as f32 * (v * PI).sin();
            if is_sun {
                light += radiance * solid_angle * direction.y;
            }
            radiance.to_array()
        })
        .collect();
    let sunny = Environment::new("sunny", width, height, texels).turned(turn.into());
    let scene = on_a_floor(sunny, |builder| {
        let grey = builder.material(Material::diffuse("grey", Vec3::splat(0.5)));
        builder.cuboid("box", Vec3::new(-0.5, 1.0, -0.5), Vec3::new(0.5, 2.0, 0.5), false, grey);
    });
    // The middle of the shadow, and one of its edges.
    let shadow = Vec3::Y * 1.5 - towards * (1.5 / towards.y);
    let edge = shadow.z - 0.5 - 0.5 * towards.z / towards.y;
    let sunny = light.x / PI + 0.2;
    for (x, z, has_sun) in
        [(shadow.x, shadow.z, false), (shadow.x, edge + 0.05, false), (shadow.x, edge - 0.05, true), (8.0, 8.0, true)]
    {
        let found = floor_at(&scene, x, z);
        let expected = if has_sun { sunny } else { 0.2 };
        assert!((found - expected).abs() < 0.02 * sunny, "({x}, {z}): {found}, {expected}");
    }
}

/// White things under an even sky are as bright as it, wherever they hide it from each other: what one takes from
/// another it gives back.
#[test]
fn white_things_under_an_even_sky_are_as_bright_as_it() {
    let mut scene = on_a_floor(even_sky(), |builder| {
        let white = builder.material(Material::diffuse("white", Vec3::ONE));
        builder.sphere_mesh("ball", Vec3::Y * 1.5, 1.0, 48, white);
    });
    let places = [(0.0, 0.0), (0.4, 0.1), (-1.2, 0.7), (0.0, -3.0)];
    let hidden = |scene: &Scene| places.map(|(x, z)| 1.0 - floor_at(scene, x, z));
    assert!(hidden(&scene)[0] > 0.4, "{:?}", hidden(&scene));
    shadow_sky(&mut scene, 32, &Silent).expect("nobody cancels it");
    // As much again as the light of the sky itself may be off.
    assert!(hidden(&scene).iter().all(|hidden| hidden.abs() < 0.05), "{:?}", hidden(&scene));
}

/// Inside a ball each bounce adds the same light everywhere: a share of the one before (the integrating sphere).
#[test]
fn light_in_a_ball_is_a_geometric_series() {
    let (radius, share, intensity) = (2.0, 0.6, Vec3::new(3.0, 2.0, 1.0));
    let mut builder = SceneBuilder::new();
    let grey = builder.material(Material { double_sided: true, ..Material::diffuse("grey", Vec3::splat(share)) });
    builder.sphere_mesh("ball", Vec3::ZERO, radius, 48, grey);
    let mut scene = builder.build();
    let kind = LightKind::Point { range: f32::INFINITY };
    scene.lights = vec![Light { kind, intensity, position: Vec3::ZERO, direction: Vec3::NEG_Z }];
    cast_shadows(&mut scene);
    for bounces in [0, 1, 4] {
        shadow_sky(&mut scene, bounces, &Silent).expect("nobody cancels it");
        let series: f32 = (0..=bounces).map(|bounce| share.powi(bounce as i32)).sum();
        let expected = intensity / (radius * radius) * (share / PI * series);
        // Triangles at the poles have no extent.
        for triangle in (200..scene.triangles.len() as u32 - 200).step_by(97) {
            let barycentrics = Barycentrics { value: Vec2::splat(0.3), ..Default::default() };
            let point = scene.surface_point(triangle, &barycentrics);
            let found = scene.radiance(&point, -point.normal);
            assert!((found / expected - 1.0).abs().max_element() < 0.03, "{bounces}: {found}, {expected}");
        }
    }
}

/// Work that is called off leaves the sky as it is without shadows.
#[test]
fn shadows_of_the_sky_can_be_called_off() {
    struct CalledOff;
    impl Progress for CalledOff {
        fn at(&self, _stage: &str, done: u64, of: u64) -> Result<(), Cancelled> {
            assert!(done <= of, "{done} of {of}");
            if done > 0 { Err(Cancelled) } else { Ok(()) }
        }
    }
    let mut scene = on_a_floor(even_sky(), |_| ());
    assert!(scene.sky.is_some());
    assert_eq!(shadow_sky(&mut scene, 1, &CalledOff), Err(Cancelled));
    assert!(scene.sky.is_none());
}
