//! Where highlights lie (Popescu, Sacks, Mei 2006, figure 13), against the light's shortest paths: on a ball, on the
//! ball's reflection and on the mirror.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::Quality;
use catoptric::scene::{Camera, Projection, Scene};
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

/// The places on balls where light from a point is mirrored towards another, by one after the other: on each its
/// normal halves the angle between the ways to its neighbours. Found by putting each in turn where its own normal does
/// so, which shortens the way every time.
fn mirrored(eye: DVec3, balls: &[Ball], light: DVec3) -> Vec<DVec3> {
    let mut places: Vec<DVec3> =
        balls.iter().map(|ball| ball.center + DVec3::new(0.3, 0.6, 0.7) * ball.radius).collect();
    for _ in 0..2000 {
        for (index, ball) in balls.iter().enumerate() {
            let before = if index == 0 { eye } else { places[index - 1] };
            let after = if index + 1 == balls.len() { light } else { places[index + 1] };
            for _ in 0..4 {
                let at = places[index];
                let half = (before - at).normalize() + (after - at).normalize();
                places[index] = ball.center + half.normalize() * ball.radius;
            }
        }
    }
    places
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
    let first = |balls: &[Ball], light: DVec3| mirrored(eye, balls, light)[0];
    let pixel_of = |place: DVec3| view.pixel_of_exact(place).expect("the place is before the eye");
    let on_ball = pixel_of(first(&[PAINTED], LAMP));
    let on_mirror = pixel_of(first(&[MIRROR], LAMP));
    let on_reflection = pixel_of(first(&[MIRROR, PAINTED], LAMP));
    // With the eye's own vector the reflection's highlight would be the reflection of the ball's.
    let wrong = pixel_of(first(&[MIRROR], first(&[PAINTED], LAMP)));
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
