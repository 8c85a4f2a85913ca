//! The growth of the times of sample-based cameras, beside those of the reference.

pub(crate) mod first_frames;
pub(crate) mod growth;
pub(crate) mod motion;
mod plot;

use crate::repository::root;
use crate::stage::{CAMERAS, Stage, count, print, stage_ms};
use anyhow::{Context, Result, anyhow};
use catoptric::methods::Report;
use catoptric::scene::model::{AnalyticAsset, LocalTransform, Model};
use catoptric::surface::AnalyticSurface;
use catoptric_scenes::builtin;
use glam::{Quat, Vec3};
use plot::{Curve, Plot};

/// The size of all pictures.
const SIZE: [u32; 2] = [360, 240];
/// Samples a pixel.
const SAMPLES: u32 = 16;
/// The settings that are not varied.
const SETTINGS: &str = "preset = 'fast'\ndownsampling = 2";

/// One measured point of all curves of a plot.
struct Measured {
    at: f64,
    build_ms: f64,
    first_ms: f64,
    later_ms: f64,
    reference_ms: f64,
}

/// Measures all series, prints their tables and draws their plots.
pub(crate) fn draw() -> Result<()> {
    let mut plots = Vec::new();
    let stage = |specification: &str, order| Ok(Stage::new(specification, SIZE, order)?.with_samples(SAMPLES));
    let triangles = [10_000u32, 100_000, 1_000_000, 5_000_000].map(|triangles| {
        let specification = format!("large_room?triangles={triangles}");
        (f64::from(triangles), move || stage(&specification, 1), SETTINGS.to_owned())
    });
    plots.push(series("triangles", triangles)?);
    let rays = [8u32, 4, 2, 1].map(|spacing| {
        let settings = format!("preset = 'fast'\ndownsampling = {spacing}");
        (f64::from(SIZE[0] * SIZE[1] / (spacing * spacing)), move || stage("sphere_room", 1), settings)
    });
    plots.push(series("view rays", rays)?);
    let orders = [1u32, 2, 3].map(|order| (f64::from(order), move || stage("two_spheres", order), SETTINGS.to_owned()));
    plots.push(series("order", orders)?);
    let balls = [1u32, 2, 3, 4, 5, 6].map(|balls| {
        let stage = move || Ok(Stage::of_model(&room_of_balls(balls)?, SIZE, 1)?.with_samples(SAMPLES));
        (f64::from(balls), stage, SETTINGS.to_owned())
    });
    plots.push(series("reflectors", balls)?);
    let path = root().join("docs/pictures/sample_based_camera-scaling.svg");
    std::fs::write(&path, plot::draw(&plots)?).with_context(|| format!("cannot write {}", path.display()))
}

/// Measures a series of stages, each with the number that varies and with settings.
fn series<const N: usize>(what: &'static str, stages: [(f64, impl Fn() -> Result<Stage>, String); N]) -> Result<Plot> {
    print(&format!(
        "\n| {what} | rays kept | ray map and cameras ms | first frame ms | later frames ms | reference ms \
         | reference / first | reference / later |\n\
         |---|---|---|---|---|---|---|---|"
    ))?;
    let mut points = Vec::new();
    for (at, stage, settings) in stages {
        let stage = stage()?;
        // Twice: the shortest times are those that nothing else on the machine has lengthened.
        let drawn = stage.draw(CAMERAS, &settings, 3)?;
        let again = stage.draw(CAMERAS, &settings, 3)?;
        let reference = stage.draw("reference", "", 3)?;
        let point = Measured {
            at,
            build_ms: build_ms(&drawn.report).min(build_ms(&again.report)),
            first_ms: drawn.first_ms.min(again.first_ms),
            later_ms: drawn.later_ms.min(again.later_ms),
            reference_ms: reference.first_ms.min(reference.later_ms),
        };
        print(&format!(
            "| {at} | {} | {:.1} | {:.0} | {:.0} | {:.0} | {:.2} | {:.1} |",
            count(&drawn.report, "ray_map_rays"),
            point.build_ms,
            point.first_ms,
            point.later_ms,
            point.reference_ms,
            point.reference_ms / point.first_ms,
            point.reference_ms / point.later_ms,
        ))?;
        points.push(point);
    }
    for (label, time) in
        [("first frames", (|point| point.first_ms) as fn(&Measured) -> f64), ("later frames", |point| point.later_ms)]
    {
        match points.windows(2).find_map(|pair| crossing(pair, time)) {
            Some(at) => print(&format!("\n{label} take as long as the reference's at {at:.3e} ({what})"))?,
            None => print(&format!("\n{label}: no crossing with the reference in this range ({what})"))?,
        }
    }
    let curve = |label, time: fn(&Measured) -> f64| Curve {
        label,
        points: points.iter().map(|point| (point.at, time(point))).collect(),
    };
    let curves = vec![
        curve("reference", |point| point.reference_ms),
        curve("first frame", |point| point.first_ms),
        curve("later frames", |point| point.later_ms),
        curve("ray map and cameras", |point| point.build_ms),
    ];
    Ok(Plot { what, curves })
}

fn build_ms(report: &Report) -> f64 {
    stage_ms(report, "ray_map") + stage_ms(report, "build")
}

/// The place between two points at which a time becomes as long as the reference's (or shorter), on logarithmic axes.
fn crossing(pair: &[Measured], time: fn(&Measured) -> f64) -> Option<f64> {
    let [before, after] = pair else { return None };
    let ahead = |point: &Measured| (point.reference_ms / time(point)).ln();
    let (start, end) = (ahead(before), ahead(after));
    let share = start / (start - end);
    ((start > 0.0) != (end > 0.0)).then(|| before.at * (after.at / before.at).powf(share))
}

/// The room of the mirror sphere with smaller balls in its place, around where it was.
fn room_of_balls(count: u32) -> Result<Model> {
    let mut model = builtin::load("sphere_room", &[("surface", "analytic")])?;
    let at = model.nodes.iter().position(|node| node.analytic.is_some());
    let node = at.map(|at| model.nodes.remove(at)).ok_or_else(|| anyhow!("sphere_room has no exact surface"))?;
    let material = node.analytic.as_ref().map_or(0, |analytic| analytic.material);
    for index in 0..count {
        let angle = std::f32::consts::TAU * index as f32 / 6.0;
        let translation = Vec3::new(0.75 * angle.cos(), 1.3 + 0.75 * angle.sin(), 0.0);
        let mut ball = node.clone();
        ball.name = format!("ball_{index}");
        ball.local = LocalTransform::Parts { translation, rotation: Quat::IDENTITY, scale: Vec3::ONE };
        ball.analytic =
            Some(AnalyticAsset { surface: AnalyticSurface::Sphere { radius: 0.25 }, material, inside: false });
        model.nodes.push(ball);
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_lie_between_points() {
        let point = |at, first_ms| Measured { at, build_ms: 1.0, first_ms, later_ms: 1.0, reference_ms: 100.0 };
        let at = crossing(&[point(10.0, 10.0), point(1000.0, 1000.0)], |point| point.first_ms).unwrap();
        assert!((at - 100.0).abs() < 1e-6, "{at}");
        assert!(crossing(&[point(1.0, 10.0), point(2.0, 20.0)], |point| point.first_ms).is_none());
    }

    #[test]
    fn rooms_have_the_given_number_of_balls() {
        let stage = Stage::of_model(&room_of_balls(6).unwrap(), [30, 20], 1).unwrap();
        assert_eq!(stage.scene.specular_objects().len(), 6);
    }
}
