//! Frames with everything moving: their times, their errors, and what changes from frame to frame in them alone.

use crate::stage::{Stage, print, rgb, timed};
use anyhow::{Result, ensure};
use catoptric::framebuffer::Framebuffer;
use catoptric::scene::model::LocalTransform;
use catoptric::scene::{Model, PoseOptions, View};
use catoptric_scenes::builtin;
use glam::{Affine3A, Mat3A, Quat, Vec3};
use image::RgbImage;

/// The size of all pictures.
const SIZE: [u32; 2] = [480, 320];
/// Samples a pixel.
const SAMPLES: u32 = 16;
const ORDER: u32 = 2;
const FRAMES: u32 = 120;
/// The eye's turn about the scene's middle from frame to frame, in degrees.
const EYE_STEP_DEG: f32 = 0.5;
/// A difference of colours that counts, of 255: as in the errors of single pictures.
const VISIBLE: i32 = 25;

/// A motion: nodes whose names begin so move by an angle a frame about a vertical axis through the node's origin, or
/// the world's, and by a step.
struct Motion {
    name: &'static str,
    specification: &'static str,
    nodes: &'static [&'static str],
    turn_deg: f32,
    about_world: bool,
    step: Vec3,
}

const MOTIONS: [Motion; 3] = [
    Motion {
        name: "a turning car, an orbiting eye",
        specification: "car",
        nodes: &[
            "hood", "fender", "door", "trunk", "roof", "wind", "rear", "nose", "tail", "under", "inter", "wheel", "hub",
        ],
        turn_deg: 0.7,
        about_world: true,
        step: Vec3::ZERO,
    },
    Motion {
        name: "a rolling ball, an orbiting eye",
        specification: "sphere_room?surface=mesh",
        nodes: &["sphere"],
        turn_deg: 1.0,
        about_world: false,
        step: Vec3::new(0.004, 0.0, 0.002),
    },
    Motion {
        name: "a turning teapot, an orbiting eye",
        specification: "teapot",
        nodes: &["pot_"],
        turn_deg: 0.7,
        about_world: false,
        step: Vec3::ZERO,
    },
];

/// Draws all motions and prints their table.
pub(crate) fn draw() -> Result<()> {
    print("| motion | `auto` ms, p50 | p99 | `reference` ms, p50 | off, % p50 | largest | popping, % p50 | largest |")?;
    print("|---|---|---|---|---|---|---|---|")?;
    MOTIONS.iter().try_for_each(row)
}

fn row(motion: &Motion) -> Result<()> {
    let model = builtin::parse(motion.specification)?;
    let stage = Stage::of_model(&model, SIZE, ORDER)?.with_samples(SAMPLES);
    let mut sessions = [stage.session("auto", "")?, stage.session("reference", "")?];
    let mut times = [Vec::new(), Vec::new()];
    let mut before: Option<[RgbImage; 2]> = None;
    let (mut off, mut popping) = (Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        let mut moved = model.clone();
        ensure!(turn(&mut moved, motion, frame) > 0, "{} has none of the nodes to move", motion.specification);
        let scene = moved.pose(&PoseOptions::default())?;
        let mut view = stage.view.clone();
        orbit(&mut view, frame);
        let mut pictures = Vec::new();
        for (session, times) in sessions.iter_mut().zip(&mut times) {
            let mut picture = Framebuffer::new(view.width, view.height);
            let start = std::time::Instant::now();
            session.update(&scene)?;
            let update_ms = start.elapsed().as_secs_f64() * 1e3;
            times.push(update_ms + timed(session, &view, &mut picture)?.1);
            pictures.push(rgb(&picture)?);
        }
        let [test, truth] = <[RgbImage; 2]>::try_from(pictures).unwrap_or_default();
        off.push(share(&test, |at| i32::from(test.as_raw()[at]) - i32::from(truth.as_raw()[at])));
        if let Some([test_before, truth_before]) = &before {
            let change =
                |now: &RgbImage, then: &RgbImage, at: usize| i32::from(now.as_raw()[at]) - i32::from(then.as_raw()[at]);
            popping.push(share(&test, |at| change(&test, test_before, at) - change(&truth, truth_before, at)));
        }
        before = Some([test, truth]);
    }
    let at = |values: &mut Vec<f64>, share: f64| {
        values.sort_by(f64::total_cmp);
        values[((values.len() - 1) as f64 * share).round() as usize]
    };
    let [mut auto, mut reference] = times;
    print(&format!(
        "| {} | {:.0} | {:.0} | {:.0} | {:.3} | {:.3} | {:.3} | {:.3} |",
        motion.name,
        at(&mut auto, 0.5),
        at(&mut auto, 0.99),
        at(&mut reference, 0.5),
        at(&mut off, 0.5),
        at(&mut off, 1.0),
        at(&mut popping, 0.5),
        at(&mut popping, 1.0),
    ))
}

/// The share of pixels with a visible difference in any channel, in percent.
fn share(picture: &RgbImage, difference: impl Fn(usize) -> i32) -> f64 {
    let pixels = (picture.width() * picture.height()) as usize;
    let is_visible = |pixel: &usize| (0..3).any(|channel| difference(pixel * 3 + channel).abs() > VISIBLE);
    100.0 * (0..pixels).filter(is_visible).count() as f64 / pixels as f64
}

/// Moves the nodes of a motion to their places in a frame; returns how many there are.
fn turn(model: &mut Model, motion: &Motion, frame: u32) -> usize {
    let turn = Quat::from_rotation_y((motion.turn_deg * frame as f32).to_radians());
    let step = motion.step * frame as f32;
    let mut count = 0;
    for node in model.nodes.iter_mut().filter(|node| node.parent.is_none()) {
        if !motion.nodes.iter().any(|name| node.name.starts_with(name)) {
            continue;
        }
        count += 1;
        if let LocalTransform::Parts { translation, rotation, .. } = &mut node.local {
            *rotation = turn * *rotation;
            *translation = if motion.about_world { turn * *translation } else { *translation } + step;
        }
    }
    count
}

/// Turns the eye about the vertical axis through the point before it that is as far as the world's middle.
fn orbit(view: &mut View, frame: u32) {
    let eye = Vec3::from(view.world_from_view.translation);
    let forward = -Vec3::from(view.world_from_view.matrix3.z_axis);
    let target = eye + forward * eye.length();
    let turn = Quat::from_rotation_y((EYE_STEP_DEG * frame as f32).to_radians());
    let about = Affine3A::from_translation(target)
        * Affine3A::from_mat3(Mat3A::from_quat(turn).into())
        * Affine3A::from_translation(-target);
    view.world_from_view = about * view.world_from_view;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_motions_move_what_they_name_and_the_eye_keeps_its_distance() {
        for motion in &MOTIONS {
            let model = builtin::parse(motion.specification).unwrap();
            let mut moved = model.clone();
            assert!(turn(&mut moved, motion, 3) > 0, "{}", motion.specification);
            let stage = Stage::of_model(&model, [30, 20], 1).unwrap();
            let mut view = stage.view.clone();
            orbit(&mut view, 10);
            let eyes = [&stage.view, &view].map(|view| Vec3::from(view.world_from_view.translation));
            assert!(eyes[0].distance(eyes[1]) > 0.01 && (eyes[0].y - eyes[1].y).abs() < 1e-4);
        }
    }
}
