//! Figure 13: highlights on a ball, on its reflection and on the mirror; and figure 14 in that figure's light.

use super::weights::weighed;
use crate::panels::{below, beside_of_width, cut};
use crate::stage::{CAMERAS, print, rgb};
use anyhow::Result;
use catoptric_testkit::highlights::{Figure13, Highlights};
use glam::DVec2;
use image::{Rgb, RgbImage};

/// The size of figure 13's pictures.
const SIZE: [u32; 2] = [1080, 720];

/// The vertical field of view, in degrees.
const FOV_DEG: f32 = 34.0;

/// The part of the pictures that shows both balls.
const BALLS: [f32; 4] = [0.14, 0.16, 0.72, 0.72];

/// The part that shows the mirror.
const MIRROR: [f32; 4] = [0.16, 0.14, 0.42, 0.7];

/// Sample-based cameras and the reference, below them an environment map and the reference with the places of the law
/// of reflection marked.
pub(crate) fn draw() -> Result<RgbImage> {
    let figure = Figure13::new(64, SIZE, FOV_DEG);
    let (expected, wrong) = (figure.expected(), figure.with_wrong_eye_vector());
    print("| picture | h_D off px | h_RD off px | h_R off px |\n|---|---|---|---|")?;
    let mut panels = Vec::new();
    for (label, method) in [
        ("sample-based camera", CAMERAS),
        ("reference", "reference"),
        ("environment map", "environment_map"),
        ("multiperspective rasterisation", "multiperspective"),
        ("path perturbation", "path_perturbation"),
    ] {
        let (picture, found) = figure.drawn(method, "", 16);
        let off = |of: fn(&Highlights) -> DVec2| of(&found).distance(of(&expected));
        let in_reflection = match method {
            "environment_map" => "elsewhere".into(),
            _ => format!("{:.2}", off(|at| at.on_reflection)),
        };
        print(&format!("| {label} | {:.2} | {in_reflection} | {:.2} |", off(|at| at.on_ball), off(|at| at.on_mirror)))?;
        panels.push(rgb(&picture)?);
    }
    print(&format!("| with the eye's own vector | | {:.2} | |", wrong.distance(expected.on_reflection)))?;
    let mut marked = panels[1].clone();
    for (place, color) in [
        (expected.on_ball, [255, 255, 255]),
        (expected.on_mirror, [255, 255, 255]),
        (expected.on_reflection, [255, 255, 255]),
        (wrong, [255, 80, 40]),
    ] {
        mark(&mut marked, place, Rgb(color));
    }
    let row = |two: [&RgbImage; 2]| beside_of_width(&two.map(|picture| cut(picture, BALLS)), 480);
    Ok(below(&[row([&panels[0], &panels[1]]), row([&panels[2], &marked])]))
}

/// Figure 14's weights in the light of figure 13.
pub(crate) fn draw_weighed() -> Result<RgbImage> {
    weighed("highlights", MIRROR)
}

/// Draws a cross around a position.
fn mark(picture: &mut RgbImage, at: DVec2, color: Rgb<u8>) {
    for step in 5..=11 {
        for (dx, dy) in [(step, 0), (-step, 0), (0, step), (0, -step)] {
            let (x, y) = (at.x as i64 + dx, at.y as i64 + dy);
            if let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y))
                && let Some(pixel) = picture.get_pixel_mut_checked(x, y)
            {
                *pixel = color;
            }
        }
    }
}
