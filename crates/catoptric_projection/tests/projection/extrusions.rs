//! Reflectors that are drawn along one axis: columns, hollow half-pipes and wavy walls, looked up in their profile.

use catoptric::methods::Quality;
use catoptric::methods::projection::explosion_map::{ExplosionMapSettings, ReflectorMap};
use catoptric::methods::projection::measure::round_trip::RoundTripOptions;
use catoptric::methods::projector::{Projections, VertexProjector};
use catoptric::scene::model::Primitive;
use catoptric::scene::{Material, Scene};
use catoptric_testkit::drawing::{round_trips_in, with_projector};
use catoptric_testkit::scenes::SceneBuilder;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Turns the y axis to that of the sheets.
fn leaning() -> Quat {
    Quat::from_rotation_x(0.2) * Quat::from_rotation_z(-0.1)
}

const HEIGHT: f32 = 1.5;

/// A sheet over `curve`, which gives place and normal for shares 0 to 1, drawn along an axis that leans.
fn drawn_along(curve: impl Fn(f32) -> [Vec2; 2], steps: u32, rows: u32, material: usize) -> Primitive {
    let leaning = leaning();
    let mut mesh = Primitive { material, ..Primitive::default() };
    for row in 0..=rows {
        for step in 0..=steps {
            let [place, normal] = curve(step as f32 / steps as f32);
            let along = HEIGHT * (row as f32 / rows as f32 - 0.5);
            mesh.positions.push(leaning * Vec3::new(place.x, along, place.y));
            mesh.normals.push(leaning * Vec3::new(normal.x, 0.0, normal.y));
            if row < rows && step < steps {
                let low = row * (steps + 1) + step;
                let high = low + steps + 1;
                mesh.triangles.extend([[low, high, low + 1], [low + 1, high, high + 1]]);
            }
        }
    }
    mesh
}

fn column(share: f32) -> [Vec2; 2] {
    let out = Vec2::from_angle(-TAU * share);
    [out * 0.5, out]
}

/// Open towards +z.
fn half_pipe(share: f32) -> [Vec2; 2] {
    let out = Vec2::from_angle(PI + PI * share);
    [out * 0.9, -out]
}

fn wavy(share: f32) -> [Vec2; 2] {
    let (x, turn) = (1.6 * (share - 0.5), TAU * 1.5 * share);
    let slope = 0.12 * turn.cos() * TAU * 1.5 / 1.6;
    [Vec2::new(x, 0.12 * turn.sin()), Vec2::new(-slope, 1.0).normalize()]
}

fn scene(curve: Curve) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.checker("walls", 8, [60, 70, 120], [200, 205, 215]);
    builder.cuboid("room", Vec3::new(-3.0, -2.0, -2.5), Vec3::new(3.0, 2.0, 4.0), true, walls);
    let red = builder.checker("red", 4, [200, 30, 20], [240, 190, 60]);
    builder.cuboid("box", Vec3::new(0.7, -0.6, 0.9), Vec3::new(1.2, 0.2, 1.4), false, red);
    builder.cuboid("near box", Vec3::new(-0.5, -0.4, 0.75), Vec3::new(-0.2, 0.1, 0.95), false, red);
    let mirror = builder.material(Material::mirror("mirror", Vec3::splat(0.95)));
    builder.primitive("mirror", drawn_along(curve, 96, 7, mirror));
    builder.camera(Vec3::new(0.4, 0.5, 3.0), Vec3::ZERO, 45.0);
    builder.build()
}

/// Place and normal at a share of a profile's length.
type Curve = fn(f32) -> [Vec2; 2];

const SHAPES: [(&str, Curve); 3] = [("column", column), ("half pipe", half_pipe), ("wavy wall", wavy)];

#[test]
fn what_profiles_say_goes_back_to_where_it_came_from() {
    for (name, curve) in SHAPES {
        let scene = scene(curve);
        let options = RoundTripOptions { order: 1, every: 3 };
        let trips = round_trips_in("explosion_map", &scene, "", &scene.default_view(480, 360), options).all;

        assert!(trips.count > 1000, "{name}: {trips:?}");
        assert!(trips.p99.is_some_and(|p99| p99 < 0.05), "{name}: {trips:?}");
        assert!(trips.missing < 3e-3, "{name}: {trips:?}");
    }
}

/// Images of a point in the picture, sorted, with their reflection points.
fn images(projector: &dyn VertexProjector, point: Vec3) -> Vec<(Vec2, Vec3)> {
    let mut found = Projections::default();
    projector.project_on(0, &[point], &mut found);
    let mut images: Vec<(Vec2, Vec3)> = found.all().iter().map(|one| (one.image_px, one.reflection_point)).collect();
    images.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
    images
}

/// True if a reflection point is well within its sheet; beyond its ends appearances go on differently.
fn is_within(curve: Curve, reflection_point: Vec3) -> bool {
    let local = leaning().inverse() * reflection_point;
    let from_end = |share: f32| curve(share)[0].distance(Vec2::new(local.x, local.z));
    let closed = curve(0.0)[0].distance(curve(1.0)[0]) < 1e-3;
    local.y.abs() < 0.49 * HEIGHT && (closed || from_end(0.0).min(from_end(1.0)) > 0.02)
}

/// Path perturbation does not use profiles.
#[test]
fn all_of_several_images_are_found() {
    let quality = Quality { samples: 1, order: 1 };
    for (name, curve) in SHAPES {
        let scene = scene(curve);
        let view = scene.default_view(640, 480);
        let points: Vec<Vec3> = (0..400)
            .map(|k| {
                let [x, y, z] = [7, 11, 13].map(|prime| (k * prime % 101) as f32 / 101.0);
                Vec3::new(-1.5 + 3.0 * x, -1.0 + 2.0 * y, 1.0 + 1.5 * z)
            })
            .collect();
        let [by_profile, by_rays] =
            [("explosion_map", "polish = 8"), ("path_perturbation", "polish = 8\nspacing_px = 2")].map(
                |(id, settings)| {
                    with_projector(id, settings, &scene, &view, quality, |projector| {
                        points.iter().map(|point| images(projector, *point)).collect::<Vec<_>>()
                    })
                },
            );
        let (mut compared, mut several) = (0, 0);
        for ((point, found), expected) in points.iter().zip(&by_profile).zip(&by_rays) {
            let within: Vec<_> = expected.iter().filter(|(_, foot)| is_within(curve, *foot)).collect();
            for (image, _) in &within {
                let nearest = found.iter().map(|one| one.0.distance(*image)).fold(f32::INFINITY, f32::min);
                assert!(nearest < 0.1, "{name}: {point} appears at {expected:?}, not {found:?}");
            }
            compared += within.len();
            several += usize::from(within.len() > 1);
        }

        assert!(compared > 100 && (name != "wavy wall" || several > 30), "{name}: {compared}, {several}");
    }
}

/// Mirror images in the planes of a column of many sides lie where the law of reflection for a cylinder has them.
#[test]
fn vertices_are_mirrored_by_the_profile() {
    let scene = scene(column);
    let view = scene.default_view(640, 480);
    let mirror = scene.specular_objects()[0];
    let mut map = ReflectorMap::new(&scene, mirror, &ExplosionMapSettings::default());
    map.look(&view);
    let points: Vec<Vec3> = (0..200).map(|k| Vec3::new(-1.5 + 0.015 * k as f32, 0.3, 1.5)).collect();
    let mut images = vec![Vec3::NAN; points.len()];
    map.virtual_vertices(&points, &mut images);
    let back = leaning().inverse();
    let mut tested = 0;
    for (point, image) in points.iter().zip(&images).filter(|(_, image)| image.is_finite()) {
        // Half-way between a point and its image is the tangent plane, and the line between them its normal.
        let (eye, point, image) = (view.eye(), *point, *image);
        let normal = (point - image).normalize();
        let middle = (point + image) * 0.5;
        let [eye, image, normal, middle] = [eye, image, normal, middle].map(|vector| back * vector);
        assert!(normal.y.abs() < 1e-3, "{normal}");
        // The tangent plane touches the cylinder at the point where the view ray meets it.
        let normal = Vec2::new(normal.x, normal.z).normalize();
        let offset = normal.dot(Vec2::new(middle.x, middle.z));
        assert!((offset - 0.5).abs() < 2e-3, "{offset}");
        let flat = |vector: Vec3| normal.dot(Vec2::new(vector.x, vector.z));
        let share = (flat(eye) - 0.5) / (flat(eye) - flat(image));
        let foot = eye + (image - eye) * share;
        assert!(Vec2::new(foot.x, foot.z).distance(normal * 0.5) < 0.01, "{foot}, {normal}");
        tested += 1;
    }
    assert!(tested > 50, "{tested}");
}
