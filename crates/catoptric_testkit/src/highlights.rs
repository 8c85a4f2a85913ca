//! Where highlights lie in the scene `highlights` (Popescu, Sacks, Mei 2006, figure 13), by the light's shortest paths:
//! on a ball, on the ball's reflection and on the mirror.

use catoptric::framebuffer::Framebuffer;
use catoptric::light::visibility::cast_shadows;
use catoptric::methods::Quality;
use catoptric::scene::{Camera, Projection, Scene, View};
use glam::{DVec2, DVec3, Vec3};

use crate::drawing::{picture, scene};

/// The scene's lamp.
const LAMP: DVec3 = DVec3::new(0.6, 4.2, 3.0);

/// How far from where a highlight should be it is looked for, in pixels.
const REACH_PX: f64 = 14.0;

/// A ball of the scene.
#[derive(Clone, Copy)]
struct Ball {
    center: DVec3,
    radius: f64,
}

const MIRROR: Ball = Ball { center: DVec3::new(-0.75, 1.1, -0.4), radius: 1.0 };
const PAINTED: Ball = Ball { center: DVec3::new(1.1, 0.75, 0.6), radius: 0.55 };

/// The figure's scene with highlights and without, and a view of it.
pub struct Figure13 {
    /// With highlights.
    pub lit: Scene,
    /// Without.
    plain: Scene,
    /// The first camera's view, with another field of view.
    pub view: View,
}

/// Positions in the picture, in pixels: the paper's h_D, h_R and h_RD.
#[derive(Clone, Copy, Debug, Default)]
pub struct Highlights {
    /// On the painted ball.
    pub on_ball: DVec2,
    /// On the mirror.
    pub on_mirror: DVec2,
    /// On the ball's reflection in the mirror.
    pub on_reflection: DVec2,
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

impl Figure13 {
    /// The scene, its curved meshes of a tessellation, and the view of its first camera with a vertical field of view.
    pub fn new(tess: u32, [width, height]: [u32; 2], fov_deg: f32) -> Self {
        let figure = |has_highlights: bool| {
            let mut scene = scene(&format!("highlights?tess={tess}"));
            for material in scene.materials.iter_mut().filter(|_| !has_highlights) {
                (material.microfacets, material.blend) = (None, None);
            }
            cast_shadows(&mut scene);
            scene
        };
        let [lit, plain] = [true, false].map(figure);
        let projection = Projection::Perspective { fov_y: fov_deg.to_radians() };
        let view = lit.view(&Camera { projection, ..lit.cameras[0].clone() }, width, height);
        Self { lit, plain, view }
    }

    /// The pixel of a point.
    fn pixel_of(&self, place: DVec3) -> DVec2 {
        self.view.pixel_of_exact(place).expect("the place is before the eye")
    }

    /// Where highlights lie by the law of reflection.
    pub fn expected(&self) -> Highlights {
        let eye = self.view.eye().as_dvec3();
        let pixel_of = |balls: &[Ball]| self.pixel_of(mirrored(eye, balls, LAMP)[0]);
        Highlights {
            on_ball: pixel_of(&[PAINTED]),
            on_mirror: pixel_of(&[MIRROR]),
            on_reflection: pixel_of(&[MIRROR, PAINTED]),
        }
    }

    /// Where the reflection's highlight would lie if the ball were lit as the eye sees it: the reflection of the ball's
    /// own.
    pub fn with_wrong_eye_vector(&self) -> DVec2 {
        let eye = self.view.eye().as_dvec3();
        self.pixel_of(mirrored(eye, &[MIRROR], mirrored(eye, &[PAINTED], LAMP)[0])[0])
    }

    /// A method's picture, and where highlights are in it near where they are expected. `settings` are lines of TOML.
    pub fn drawn(&self, method: &str, settings: &str, samples: u32) -> (Framebuffer, Highlights) {
        let quality = Quality { samples, order: 1 };
        let [lit, plain] = [&self.lit, &self.plain].map(|scene| picture(method, settings, scene, &self.view, quality));
        let pairs = lit.pixels.iter().zip(&plain.pixels);
        let added: Vec<f32> =
            pairs.map(|(a, b)| Vec3::new(a[0] - b[0], a[1] - b[1], a[2] - b[2]).element_sum()).collect();
        let expected = self.expected();
        let [on_ball, on_mirror, on_reflection] =
            [expected.on_ball, expected.on_mirror, expected.on_reflection].map(|around| self.brightest(&added, around));
        (lit, Highlights { on_ball, on_mirror, on_reflection })
    }

    /// The middle of the brightest place near a position.
    fn brightest(&self, values: &[f32], around: DVec2) -> DVec2 {
        let width = self.view.width as usize;
        let places = || {
            let at = |index: usize| DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let all = values.iter().enumerate().map(move |(index, value)| (at(index), *value));
            all.filter(move |(at, _)| at.distance(around) <= REACH_PX)
        };
        let peak = places().map(|(_, value)| value).fold(0.0, f32::max);
        let bright = places().filter(|(_, value)| *value > 0.6 * peak);
        let (sum, weight) = bright.fold((DVec2::ZERO, 0.0), |(sum, weight), (at, value)| {
            (sum + at * f64::from(value), weight + f64::from(value))
        });
        sum / weight
    }
}
