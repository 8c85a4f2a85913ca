//! The growth of frame times of `auto`, beside those of the reference and of two other methods.

use super::plot::{self, Curve, Plot};
use crate::repository::root;
use crate::stage::{Stage, count, flip, print};
use anyhow::{Context, Result, anyhow};
use catoptric::scene::Model;
use catoptric::scene::model::LocalTransform;
use catoptric_scenes::builtin;
use glam::{Quat, Vec3};

/// The size of all pictures.
const SIZE: [u32; 2] = [720, 480];
/// Samples a pixel.
const SAMPLES: u32 = 16;
/// The methods of the curves, with their settings.
const METHODS: [(&str, &str); 4] =
    [("reference", ""), ("auto", ""), ("path_perturbation", ""), ("environment_map", "size = 256")];

/// Measures all series, prints their tables and draws their plots.
pub(crate) fn draw() -> Result<()> {
    let stage = |specification: &str, order| Ok(Stage::new(specification, SIZE, order)?.with_samples(SAMPLES));
    let triangles = [10_000u32, 100_000, 1_000_000, 5_000_000]
        .map(|count| (count, move || stage(&format!("large_room?surface=mesh&triangles={count}"), 1)));
    let reflector = [16u32, 48, 160, 350]
        .map(|tess| (4 * tess * (tess - 1), move || stage(&format!("sphere_room?surface=mesh&tess={tess}"), 1)));
    let reflectors = [1u32, 4, 16, 64, 200]
        .map(|balls| (balls, move || Ok(Stage::of_model(&room_of_balls(balls)?, SIZE, 1)?.with_samples(SAMPLES))));
    let orders = [1u32, 2, 3, 4, 6].map(|order| (order, move || stage("two_spheres?surface=mesh", order)));
    let plots = [
        series("triangles of the scene", triangles)?,
        series("triangles of the reflector", reflector)?,
        series("reflectors", reflectors)?,
        series("order", orders)?,
    ];
    let path = root().join("docs/pictures/auto-growth.svg");
    std::fs::write(&path, plot::draw(&plots)?).with_context(|| format!("cannot write {}", path.display()))
}

/// Measures a series of stages, each with the number that varies.
fn series<const N: usize>(what: &'static str, stages: [(u32, impl Fn() -> Result<Stage>); N]) -> Result<Plot> {
    let titles: String = METHODS.iter().map(|(method, _)| format!(" `{method}` ms |")).collect();
    print(&format!("\n| {what} |{titles} reference / `auto` | FLIP of `auto` | pixels traced |"))?;
    print(&format!("|---|{}---|---|---|", "---|".repeat(METHODS.len())))?;
    let mut curves = METHODS.map(|(label, _)| Curve { label, points: Vec::new() });
    for (at, stage) in stages {
        let stage = stage()?;
        let mut frames = Vec::new();
        for (method, settings) in METHODS {
            frames.push(stage.draw(method, settings, 2)?);
        }
        let times: Vec<f64> = frames.iter().map(|frames| frames.first_ms.min(frames.later_ms)).collect();
        for (curve, time) in curves.iter_mut().zip(&times) {
            curve.points.push((f64::from(at), *time));
        }
        let cells: String = times.iter().map(|time| format!(" {time:.0} |")).collect();
        let error = flip(&frames[1].picture, &frames[0].picture, &stage.mask())?;
        let traced = frames[1].report.fallbacks.get("traced_pixels").copied().unwrap_or_default()
            + count(&frames[1].report, "rim_pixels");
        print(&format!("| {at} |{cells} {:.1} | {error:.4} | {traced} |", times[0] / times[1]))?;
    }
    Ok(Plot { what, curves: curves.into() })
}

/// The room of the mirror sphere with smaller ones in its place, all meshes.
fn room_of_balls(count: u32) -> Result<Model> {
    let mut model = builtin::load("sphere_room", &[("surface", "mesh"), ("tess", "32")])?;
    let at = model.nodes.iter().position(|node| node.name == "sphere");
    let node = at.map(|at| model.nodes.remove(at)).ok_or_else(|| anyhow!("sphere_room has no sphere"))?;
    let LocalTransform::Parts { translation: center, scale, .. } = node.local else {
        return Err(anyhow!("the sphere of sphere_room has another transform"));
    };
    let columns = f64::from(count).sqrt().ceil() as u32;
    for index in 0..count {
        let place = |index: u32| (index as f32 + 0.5) / columns as f32 - 0.5;
        let translation = center + Vec3::new(2.0 * place(index % columns), 1.4 * place(index / columns), 0.0);
        let mut ball = node.clone();
        ball.name = format!("ball_{index}");
        let scale = scale / columns as f32;
        ball.local = LocalTransform::Parts { translation, rotation: Quat::IDENTITY, scale };
        model.nodes.push(ball);
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rooms_have_the_given_number_of_balls() {
        let stage = Stage::of_model(&room_of_balls(9).unwrap(), [30, 20], 1).unwrap();
        assert_eq!(stage.scene.specular_objects().len(), 9);
    }
}
