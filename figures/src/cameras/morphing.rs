//! Figure 15: ambiguous vertices of reflection morphing, discarded and cured; and a walk through the grid of nodes.

use super::rows::Row;
use super::sizes::FULL;
use crate::commands::Line;
use crate::panels::{below, beside_of_width};
use crate::stage::{CAMERAS, Stage, flip, print, rgb};
use anyhow::{Context, Result};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::math::Aabb;
use catoptric::methods::projection::measure::round_trip::{RoundTripOptions, round_trip};
use catoptric::methods::projection::sample_based_camera::nodes_around;
use catoptric::methods::projector::VertexProjector;
use catoptric::progress::Silent;
use catoptric::scene::{Camera, Scene, View};
use catoptric_testkit::Session;
use glam::{Quat, Vec3};
use image::RgbImage;
use std::collections::BTreeSet;

/// A grid of fewer nodes than usual: what they see differs more.
const GRID: &str = "7x7x5";
const REACH: f32 = 1.0;

/// The scene of the figure: a bowl with an open border.
const SCENE: &str = "vase";

/// The width of a panel.
const WIDTH: u32 = 360;

/// Scenes of the walk, with the order.
const WALKS: [(&str, u32); 3] = [("sphere_room", 1), ("two_spheres", 2), ("vase", 1)];

/// The size of its pictures.
const WALK_SIZE: [u32; 2] = [240, 160];

/// Frames of the walk.
const FRAMES: u32 = 120;

/// The settings of the walks.
const MODES: [(&str, &str); 2] = [("morph", "mode = 'morph'"), ("runtime", "mode = 'runtime'")];

/// The lines of the walks' first frames.
pub(super) fn commands(line: impl Fn(Row<'_>) -> Line) -> Vec<Line> {
    let of_scene = |(scene, order)| MODES.map(|(_, settings)| line((scene, WALK_SIZE, 4, order, CAMERAS, settings)));
    WALKS.into_iter().flat_map(of_scene).collect()
}

/// The largest reflector's box.
fn largest_reflector(scene: &Scene) -> Result<Aabb> {
    let boxes = scene.specular_objects().into_iter().map(|object| scene.objects[object as usize].bounds);
    boxes.max_by(|a, b| a.diagonal().total_cmp(&b.diagonal())).context("there is a reflector")
}

fn view_from(stage: &Stage, eye: Vec3, target: Vec3) -> View {
    let View { width, height, .. } = stage.view;
    stage.scene.view(&Camera::look_at("", eye, target, Vec3::Y, 40.0), width, height)
}

fn settings(ambiguous: &str) -> String {
    format!("mode = 'morph'\nwork = 1000\ngrid = '{GRID}'\ngrid_reach = {REACH:?}\nambiguous = '{ambiguous}'")
}

/// Above what shows from four nodes; below blended without what some of them do not see, blended with that, and traced.
pub(crate) fn draw() -> Result<RgbImage> {
    let mut stage = Stage::new(SCENE, FULL, 1)?.with_samples(16);
    let bounds = largest_reflector(&stage.scene)?;
    let center = bounds.center();
    // Somewhat aside: from the scene's own camera, in the plane of two nodes, there would be three.
    let eye = stage.view.eye() + Vec3::X * 0.15;
    let nodes =
        nodes_around(&bounds, GRID, REACH, eye).map_err(anyhow::Error::msg)?.context("the eye is in the grid")?;
    let mut above = Vec::new();
    for (place, _) in &nodes {
        stage.view = view_from(&stage, *place, center);
        above.push(rgb(&stage.truth()?)?);
    }
    stage.view = view_from(&stage, eye, center);
    let (truth, mask) = (stage.truth()?, stage.mask());
    let mut under = Vec::new();
    print("| ambiguous points | FLIP on the reflector | p99 px | missing % |\n|---|---|---|---|")?;
    for ambiguous in ["discarded", "cured"] {
        let mut session = Session::new(CAMERAS, &settings(ambiguous), &stage.scene, stage.quality)?;
        let drawn = session.draw(&stage.view)?.picture;
        let options = RoundTripOptions { order: 1, every: 1 };
        let trips =
            |projector: &dyn VertexProjector| round_trip(&stage.scene, &stage.view, projector, options, &Silent);
        let error = session.with_projector(&stage.view, trips)??.all;
        let p99 = error.p99.map_or(String::new(), |p99| format!("{p99:.3}"));
        let missing = error.missing * 100.0;
        print(&format!("| {ambiguous} | {:.4} | {p99} | {missing:.3} |", flip(&drawn, &truth, &mask)?))?;
        under.push(rgb(&drawn)?);
    }
    under.push(rgb(&truth)?);
    Ok(below(&[beside_of_width(&above, WIDTH * 3 / 4), beside_of_width(&under, WIDTH)]))
}

/// The share of a mask's pixels that change from the frame before to this one otherwise than the truth, by more than a
/// tenth.
fn popping(drawn: &[Framebuffer], truth: &[Framebuffer], frame: usize, mask: &[bool]) -> f64 {
    let luminance = |picture: &Framebuffer, pixel: usize| {
        let [red, green, blue, ..] = picture.pixels[pixel];
        (0.2126 * red + 0.7152 * green + 0.0722 * blue).min(1.0)
    };
    let change = |pictures: &[Framebuffer], pixel: usize| {
        luminance(&pictures[frame], pixel) - luminance(&pictures[frame - 1], pixel)
    };
    let shown = || mask.iter().enumerate().filter(|(_, shown)| **shown).map(|(pixel, _)| pixel);
    let pops = shown().filter(|&pixel| (change(drawn, pixel) - change(truth, pixel)).abs() > 0.1).count();
    pops as f64 / shown().count().max(1) as f64
}

/// The walk: half a degree a frame about the reflector, up and down and nearer meanwhile.
fn walk(stage: &Stage, center: Vec3) -> Vec<View> {
    let start = stage.view.eye();
    let at = |frame: u32| {
        let angle = frame as f32 * 0.5f32.to_radians();
        let way = Quat::from_rotation_y(angle) * (start - center);
        let nearer = 1.0 - 0.15 * (angle * 3.0).sin().abs();
        view_from(stage, center + way * nearer + Vec3::Y * 0.1 * (angle * 5.0).sin(), center)
    };
    (0..FRAMES).map(at).collect()
}

/// How many tetrahedra of the default grid some eyes are in.
fn tetrahedra(bounds: &Aabb, views: &[View]) -> Result<usize> {
    let mut passed = BTreeSet::new();
    for view in views {
        let nodes = nodes_around(bounds, "17x17x8", 2.0, view.eye()).map_err(anyhow::Error::msg)?;
        let places = nodes.into_iter().flatten().map(|(place, _)| place.to_array().map(f32::to_bits));
        passed.insert(places.collect::<BTreeSet<_>>());
    }
    Ok(passed.len())
}

/// A walk of 120 frames through the grid, with its errors and what jumps from frame to frame.
pub(crate) fn print_walk() -> Result<()> {
    print("| scene | mode | FLIP: median | FLIP: worst frame | pops %: median | pops %: worst frame | tetrahedra |")?;
    print("|---|---|---|---|---|---|---|")?;
    let middle_and_worst = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        [values.len() / 2, values.len() - 1].map(|rank| values.get(rank).copied().unwrap_or_default())
    };
    for (specification, order) in WALKS {
        let stage = Stage::new(specification, WALK_SIZE, order)?;
        let bounds = largest_reflector(&stage.scene)?;
        let views = walk(&stage, bounds.center());
        let passed = tetrahedra(&bounds, &views)?;
        let frames = |mut session: Session| -> Result<Vec<Framebuffer>> {
            views.iter().map(|view| Ok(session.draw(view)?.picture)).collect()
        };
        let truths = frames(Session::new("reference", "", &stage.scene, stage.quality)?)?;
        let masks: Vec<Vec<bool>> = views.iter().map(|view| specular_mask(&stage.scene, view)).collect();
        for (mode, settings) in MODES {
            let drawn = frames(Session::new(CAMERAS, settings, &stage.scene, stage.quality)?)?;
            let error = |frame: usize| flip(&drawn[frame], &truths[frame], &masks[frame]);
            let errors = (0..drawn.len()).map(error).collect::<Result<Vec<f64>>>()?;
            let pops = (1..drawn.len()).map(|frame| 100.0 * popping(&drawn, &truths, frame, &masks[frame]));
            let ([error, worst], [pop, most]) = (middle_and_worst(errors), middle_and_worst(pops.collect()));
            print(&format!(
                "| {specification} | {mode} | {error:.4} | {worst:.4} | {pop:.3} | {most:.3} | {passed} |"
            ))?;
        }
    }
    Ok(())
}
