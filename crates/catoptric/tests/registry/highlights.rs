//! Where highlights lie (Popescu, Sacks, Mei 2006, figure 13), against the light's shortest paths: on a ball, on the
//! ball's reflection and on the mirror.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::Quality;
use catoptric::scene::{Camera, Projection, Scene, View};
use catoptric_testkit::drawing::{picture, scene};
use glam::{DVec2, DVec3, Vec3};

const LAMP: DVec3 = DVec3::new(0.6, 4.2, 3.0);

/// A ball of the scene.
#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius: f64,
}

const MIRROR: Ball = Ball { center: DVec3::new(-0.75, 1.1, -0.4), radius: 1.0 };
const PAINTED: Ball = Ball { center: DVec3::new(1.1, 0.75, 0.6), radius: 0.55 };

const SIZE: (u32, u32) = (480, 320);
const FOV_DEG: f32 = 16.0;

/// The scene with highlights or without.
fn figure(has_highlights: bool) -> Scene {
    let mut scene = scene("highlights?tess=48");
    for material in scene.materials.iter_mut().filter(|_| !has_highlights) {
        (material.microfacets, material.blend) = (None, None);
    }
    cast_shadows(&mut scene);
    scene
}

/// The places on balls where light from the lamp is mirrored towards a point, by one after the other: on each its
/// normal halves the angle between the ways to its neighbours. Found by putting each in turn where its own normal does
/// so, which shortens the way every time.
fn mirrored(eye: DVec3, balls: &[Ball]) -> Vec<DVec3> {
    let mut places: Vec<DVec3> =
        balls.iter().map(|ball| ball.center + DVec3::new(0.3, 0.6, 0.7) * ball.radius).collect();
    for _ in 0..2000 {
        for (index, ball) in balls.iter().enumerate() {
            let before = if index == 0 { eye } else { places[index - 1] };
            let after = if index + 1 == balls.len() { LAMP } else { places[index + 1] };
            for _ in 0..4 {
                let at = places[index];
                let half = (before - at).normalize() + (after - at).normalize();
                places[index] = ball.center + half.normalize() * ball.radius;
            }
        }
    }
    places
}

/// The place on the mirror at which a point is seen, as [`mirrored`].
fn seen_in_mirror(eye: DVec3, point: DVec3) -> DVec3 {
    let mut at = MIRROR.center + DVec3::Z;
    for _ in 0..5000 {
        let half = (eye - at).normalize() + (point - at).normalize();
        at = MIRROR.center + half.normalize() * MIRROR.radius;
    }
    at
}

fn pixel_of(view: &View, point: DVec3) -> DVec2 {
    let (width, height) = (SIZE.0 as f32, SIZE.1 as f32);
    // By the rays of the picture's middle and of pixels beside it.
    let through = |x: f32, y: f32| view.ray(x, y).direction.as_dvec3();
    let forward = through(0.5 * width, 0.5 * height);
    let on_plane = |direction: DVec3| direction / direction.dot(forward);
    let right = on_plane(through(0.5 * width + 1.0, 0.5 * height)) - forward;
    let down = on_plane(through(0.5 * width, 0.5 * height + 1.0)) - forward;
    let seen = on_plane(point - view.eye().as_dvec3()) - forward;
    let middle = DVec2::new(0.5 * f64::from(width), 0.5 * f64::from(height));
    middle + DVec2::new(seen.dot(right) / right.length_squared(), seen.dot(down) / down.length_squared())
}

/// The middle of the brightest place within so many pixels.
fn brightest(picture: &[f32], around: DVec2, reach: f64) -> DVec2 {
    let places = || {
        let at = |index: usize| DVec2::new((index as u32 % SIZE.0) as f64 + 0.5, (index as u32 / SIZE.0) as f64 + 0.5);
        picture
            .iter()
            .enumerate()
            .map(move |(index, value)| (at(index), *value))
            .filter(move |(at, _)| at.distance(around) <= reach)
    };
    let peak = places().map(|(_, value)| value).fold(0.0, f32::max);
    let bright = places().filter(|(_, value)| *value > 0.6 * peak);
    let (sum, weight) = bright.fold((DVec2::ZERO, 0.0), |(sum, weight), (at, value)| {
        (sum + at * f64::from(value), weight + f64::from(value))
    });
    sum / weight
}

#[test]
fn highlights_lie_where_each_surfaces_own_eye_vector_puts_them() {
    let [with, without] = [true, false].map(figure);
    // A pixel is as large as in a picture of 680 rows: of the middle a part is seen.
    let projection = Projection::Perspective { fov_y: FOV_DEG.to_radians() };
    let view = with.view(&Camera { projection, ..with.cameras[0].clone() }, SIZE.0, SIZE.1);
    let eye = view.eye().as_dvec3();
    let on_ball = pixel_of(&view, mirrored(eye, &[PAINTED])[0]);
    let on_mirror = pixel_of(&view, mirrored(eye, &[MIRROR])[0]);
    let on_reflection = pixel_of(&view, mirrored(eye, &[MIRROR, PAINTED])[0]);
    // With the eye's own vector the reflection's highlight would be the reflection of the ball's.
    let wrong = pixel_of(&view, seen_in_mirror(eye, mirrored(eye, &[PAINTED])[0]));
    assert!(wrong.distance(on_reflection) > 10.0, "{wrong} and {on_reflection}");
    let all = [("ball", on_ball), ("mirror", on_mirror), ("reflection", on_reflection)];
    let quality = Quality { samples: 4, order: 1 };
    for method in [
        "reference",
        "auto",
        "multiperspective",
        "path_perturbation",
        "sample_based_camera",
        "explosion_map",
        "reflector_search",
        "environment_map",
        "light_field",
        "layered_environment_map",
    ] {
        let [lit, plain]: [Framebuffer; 2] = [&with, &without].map(|scene| picture(method, "", scene, &view, quality));
        let added: Vec<f32> = lit
            .pixels
            .iter()
            .zip(&plain.pixels)
            .map(|(a, b)| Vec3::new(a[0] - b[0], a[1] - b[1], a[2] - b[2]).element_sum())
            .collect();
        // Look-ups show the ball, and its highlight, elsewhere in the mirror.
        let is_look_up = ["environment_map", "light_field", "layered_environment_map"].contains(&method);
        for (name, expected) in all.iter().take(if is_look_up { 2 } else { 3 }) {
            let found = brightest(&added, *expected, 14.0);
            assert!(found.distance(*expected) < 1.0, "{method}, on the {name}: {found} for {expected}");
        }
    }
}
