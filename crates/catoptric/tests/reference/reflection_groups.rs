//! The reference's overlay of reflection groups, against rays that are followed in closed form.

use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric::methods::{self, Quality};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Material, Scene, View};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{DVec3, Vec3};
use std::sync::Arc;

const VALID: &str = "the test's input is valid";

fn groups(scene: &Arc<Scene>, view: &View, settings: &str, order: u32) -> Overlay {
    let method = methods::create("reference", &toml::from_str(settings).expect(VALID)).expect(VALID);
    let mut prepared = method.prepare(scene, Quality { samples: 1, order }, None, &Silent).expect(VALID);
    let frame = prepared.frame(view, &Silent).expect(VALID);
    frame.overlay(OverlayKind::Paths, &Silent).expect(VALID).expect("the reference has reflection groups")
}

fn name_at(overlay: &Overlay, pixel: usize) -> &str {
    overlay.pixels[pixel].checked_sub(1).map_or("", |group| &overlay.groups[group as usize])
}

/// The centre of a pixel's ray: origin and unit direction.
fn ray_of(view: &View, pixel: usize) -> (DVec3, DVec3) {
    let (x, y) = (pixel as u32 % view.width, pixel as u32 / view.width);
    let ray = view.ray(x as f32 + 0.5, y as f32 + 0.5);
    (ray.origin.as_dvec3(), ray.direction.as_dvec3().normalize())
}

/// The nearest of some unit balls' points in front of a ray, and how near to a silhouette any of them is passed.
fn meet(balls: &[DVec3], origin: DVec3, direction: DVec3) -> (Option<(usize, DVec3)>, f64) {
    let (mut nearest, mut found, mut margin) = (f64::INFINITY, None, f64::INFINITY);
    for (number, center) in balls.iter().enumerate() {
        let offset = origin - *center;
        let along = offset.dot(direction);
        let inside = along * along - offset.length_squared() + 1.0;
        let is_ahead = along < 0.0 && offset.length_squared() > 1.0 + 1e-9;
        if is_ahead {
            margin = margin.min(inside.abs());
        }
        if is_ahead && inside > 0.0 && -along - inside.sqrt() < nearest {
            nearest = -along - inside.sqrt();
            found = Some((number, origin + direction * nearest));
        }
    }
    (found, margin)
}

#[test]
fn two_balls_reflect_each_other_by_the_law_of_reflection() {
    let mut builder = SceneBuilder::new();
    let mirror = builder.material(Material::mirror("mirror", Vec3::ONE));
    let names = ["left", "right"];
    let balls = [DVec3::new(-1.125, 0.0, 0.0), DVec3::new(1.125, 0.0, 0.25)];
    for (name, center) in names.iter().zip(balls) {
        builder.sphere(name, center.as_vec3(), 1.0, mirror);
    }
    let scene = Arc::new(builder.build());
    let camera = Camera::look_at("", Vec3::new(0.0, 0.5, 5.0), Vec3::ZERO, Vec3::Y, 45.0);
    let view = View::new(&camera, 240, 160, 1e-3);
    for order in [0, 1, 2, 5] {
        let found = groups(&scene, &view, "", order);
        let (mut deepest, mut at_silhouettes) = (0, 0);
        for pixel in 0..found.pixels.len() {
            let (mut origin, mut direction) = ray_of(&view, pixel);
            let (mut path, mut margin) = (Vec::new(), f64::INFINITY);
            loop {
                let (met, beside) = meet(&balls, origin, direction);
                margin = margin.min(beside);
                let Some((ball, point)) = met.filter(|_| path.len() < order as usize) else { break };
                path.push(format!("R {}", names[ball]));
                let normal = point - balls[ball];
                (origin, direction) = (point, direction - normal * 2.0 * direction.dot(normal));
            }
            // Errors of single precision grow with each bounce.
            if margin < 1e-3 {
                at_silhouettes += 1;
                continue;
            }
            assert_eq!(name_at(&found, pixel), path.join(" > "), "{pixel}, order {order}");
            deepest = deepest.max(path.len());
        }
        assert_eq!(deepest, order as usize);
        assert!(at_silhouettes * 50 < found.pixels.len(), "{at_silhouettes}");
        // Short paths come first.
        let lengths = found.groups.iter().map(|name| name.split(" > ").count());
        assert!(lengths.is_sorted(), "{:?}", found.groups);
    }
}

#[test]
fn light_goes_through_glass_but_where_it_is_totally_reflected() {
    // Seen from within a ball light arrives through its surface within the critical angle; beyond that it is reflected
    // at the same angle again and again.
    const IOR: f64 = 1.5;
    let mut builder = SceneBuilder::new();
    let glass = builder.material(Material::glass("glass", IOR as f32));
    builder.sphere("ball", Vec3::ZERO, 1.0, glass);
    let scene = Arc::new(builder.build());
    let camera = Camera::look_at("", Vec3::new(0.9, 0.0, 0.0), Vec3::new(0.9, 0.0, -1.0), Vec3::Y, 100.0);
    let view = View::new(&camera, 120, 80, 1e-3);
    for settings in ["", "paths = \"two_path\""] {
        let found = groups(&scene, &view, settings, 3);
        let (mut through, mut reflected, mut critical) = (0, 0, 0);
        for pixel in 0..found.pixels.len() {
            let (origin, direction) = ray_of(&view, pixel);
            // The sine of incidence: how far from the middle the ray passes.
            let sine = origin.cross(direction).length();
            let expected = match sine * IOR {
                ratio if (ratio - 1.0).abs() < 1e-3 => {
                    critical += 1;
                    continue;
                }
                ratio if ratio < 1.0 => "T ball",
                _ => "R ball > R ball > R ball",
            };
            assert_eq!(name_at(&found, pixel), expected, "{pixel} {settings}");
            *if expected == "T ball" { &mut through } else { &mut reflected } += 1;
        }
        assert!(through > 500 && reflected > 500 && critical < 100, "{through} {reflected} {critical}");
    }
    // From outside it goes in and out.
    let camera = Camera::look_at("", Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, Vec3::Y, 40.0);
    let outside = View::new(&camera, 90, 60, 1e-3);
    for (order, expected) in [(1, "T ball"), (4, "T ball > T ball")] {
        let found = groups(&scene, &outside, "", order);
        assert_eq!(found.groups, [expected]);
        let seen = |pixel: &usize| {
            let (origin, direction) = ray_of(&outside, *pixel);
            origin.cross(direction).length() < 1.0
        };
        let count = (0..found.pixels.len()).filter(seen).count();
        assert!(count.abs_diff(found.pixels.iter().filter(|group| **group == 1).count()) < 3);
    }
}
