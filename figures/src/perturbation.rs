//! Figures 8 to 13 of Chen and Arvo 2000, made again: path perturbation beside the reference.

use crate::panels::{below, beside, cut};
use crate::program::{ALONE, catoptric, json, picture};
use crate::root;
use crate::stage::print;
use anyhow::{Context, Result};
use image::RgbImage;
use serde_json::Value;
use std::path::Path;

/// A picture to draw.
struct Shot {
    /// Its name in the table of times.
    label: &'static str,
    scene: &'static str,
    /// Settings of path perturbation, separated by blanks; without them the reference draws.
    settings: Option<&'static str>,
    size: [u32; 2],
    order: u32,
    /// The scene's time, in seconds.
    time_s: f32,
    motion: &'static str,
}

/// Shots side by side in one picture.
struct Figure {
    name: &'static str,
    shots: Vec<Shot>,
    /// The part that is shown enlarged in a second row: x, y, width, height, as shares of the picture.
    close_up: Option<[f32; 4]>,
}

/// Frames of a run: the first makes what the others keep.
const FRAMES: &str = "3";

fn figures() -> Vec<Figure> {
    let shot = |label, scene, settings, size| Shot {
        label,
        scene,
        settings: Some(settings),
        size,
        order: 1,
        time_s: 0.0,
        motion: "none",
    };
    let truth = |scene, size| Shot { settings: None, ..shot("reference", scene, "", size) };
    let second = |shot: Shot| Shot { order: 2, ..shot };
    let vase = "builtin:vase";
    let both = "builtin:vase?sphere=mirror";
    let sparse = "spacing_px=16 finest_px=16";
    let fine = "edge_error_px=1 piece_px=2";
    let (large, small, square) = ([640, 480], [320, 240], [256, 256]);
    let moving = Shot { motion: "animation", ..shot("perturbation, icosahedron moving", vase, sparse, large) };
    let animation = [("0 s", 0.0), ("1.5 s", 1.5), ("5 s", 5.0), ("7.2 s", 7.2)]
        .map(|(label, time_s)| Shot { time_s, ..shot(label, vase, fine, [480, 320]) });
    let figure = |name, shots| Figure { name, shots, close_up: None };
    let enlarged = |name, part, shots| Figure { name, shots, close_up: Some(part) };
    vec![
        enlarged(
            "figure-08",
            [0.25, 0.5, 0.5, 0.5],
            vec![shot("perturbation", vase, sparse, large), truth(vase, large)],
        ),
        figure("figure-08-moving", vec![moving]),
        enlarged(
            "figure-09",
            [0.5, 0.2, 0.4, 0.4],
            vec![
                second(shot("perturbation", both, "spacing_px=8 finest_px=8 edge_error_px=1 piece_px=2", large)),
                second(truth(both, large)),
            ],
        ),
        figure("figure-10", animation.into()),
        figure(
            "figure-11",
            vec![
                shot("8x8", vase, "spacing_px=32 finest_px=32 edge_error_px=1 piece_px=2", square),
                shot("16x16", vase, "spacing_px=16 finest_px=16 edge_error_px=1 piece_px=2", square),
                shot("32x32", vase, "spacing_px=8 finest_px=8 edge_error_px=1 piece_px=2", square),
                truth(vase, square),
            ],
        ),
        figure(
            "figure-12",
            vec![
                shot("coarse", vase, "edge_error_px=100 piece_px=8", small),
                shot("middle", vase, "edge_error_px=4 piece_px=4", small),
                shot("fine", vase, "edge_error_px=1 piece_px=2", small),
                truth(vase, small),
            ],
        ),
        enlarged(
            "figure-13",
            [0.3, 0.44, 0.2, 0.24],
            vec![
                shot("nearest", vase, "polish=0 expansion=nearest spacing_px=16 finest_px=16", large),
                shot("linear", vase, "polish=0 expansion=linear spacing_px=16 finest_px=16", large),
                shot("quadratic", vase, "polish=0 expansion=quadratic spacing_px=16 finest_px=16", large),
                truth(vase, large),
            ],
        ),
    ]
}

/// Draws all figures (or those whose names contain `wanted`) and prints the table of their times as Markdown.
pub(crate) fn draw(wanted: &str) -> Result<()> {
    let folder = root().join("docs/pictures");
    let scratch = tempfile::tempdir().context("cannot make a temporary folder")?;
    print("| figure | picture | size | `build` ms | first frame ms | later frames ms | virtual triangles |")?;
    print("|---|---|---|---|---|---|---|")?;
    for figure in figures().iter().filter(|figure| figure.name.contains(wanted)) {
        let mut panels = Vec::new();
        for shot in &figure.shots {
            panels.push(shot.draw(figure.name, scratch.path())?);
        }
        let mut rows = vec![beside(&panels)];
        if let Some(part) = figure.close_up {
            let parts: Vec<RgbImage> = panels.iter().map(|panel| cut(panel, part)).collect();
            rows.push(beside(&parts));
        }
        let path = folder.join(format!("path_perturbation-{}.png", figure.name));
        below(&rows).save(&path).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

impl Shot {
    /// Draws the picture and prints a row of the table.
    fn draw(&self, figure: &str, scratch: &Path) -> Result<RgbImage> {
        let stats = scratch.join("stats.json");
        let [width, height] = self.size;
        let mut command = catoptric(&["render", self.scene, "--samples", "4", "--quiet", "--frames", FRAMES]);
        command.args(["--size", &format!("{width}x{height}")]);
        command.args(["--order", &self.order.to_string(), "--time", &self.time_s.to_string()]);
        command.args(["--motion", self.motion, "--method"]);
        command.arg(if self.settings.is_some() { "path_perturbation" } else { "reference" });
        if let Some(settings) = self.settings {
            for setting in settings.split_whitespace().chain(ALONE) {
                command.args(["--set", setting]);
            }
        }
        let panel = picture(command.arg("--stats").arg(&stats), &scratch.join("picture.png"))?;
        let stats = json(&stats)?;
        let milliseconds = |value: &Value| value.as_f64().map_or("".into(), |time| format!("{time:.0}"));
        print(&format!(
            "| {figure} | {} | {width}x{height} | {} | {} | {} | {} |",
            self.label,
            milliseconds(&stats["first_stages_ms"]["build"]),
            milliseconds(&stats["frame_ms"]["max"]),
            milliseconds(&stats["frame_ms"]["median"]),
            stats["counts"]["virtual_triangles"].as_u64().map_or(String::new(), |count| count.to_string()),
        ))?;
        Ok(panel)
    }
}
