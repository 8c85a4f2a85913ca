//! Figures 8 to 13 of Chen and Arvo 2000, made again: path perturbation beside the reference.

use crate::commands::{self, ALONE, Line};
use crate::panels::{below, beside, cut};
use crate::program::{command, json, picture};
use crate::repository::root;
use crate::stage::print;
use anyhow::{Context, Result};
use image::RgbImage;
use serde_json::Value;
use std::path::Path;

/// A picture to draw.
struct Shot {
    /// The picture's name in the table of times.
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

/// The method of this page.
const METHOD: &str = "path_perturbation";

/// The paper's own settings.
const FAITHFUL: &str = "preset=faithful";

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
    let (large, small, square) = ([640, 480], [320, 240], [512, 512]);
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
                shot("8x8", vase, "preset=faithful spacing_px=64 finest_px=64", square),
                shot("16x16", vase, "preset=faithful spacing_px=32 finest_px=32", square),
                shot("32x32", vase, "preset=faithful", square),
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
                shot("nearest", vase, "preset=faithful expansion=nearest", large),
                shot("linear", vase, "preset=faithful expansion=linear", large),
                shot("quadratic", vase, "preset=faithful", large),
                truth(vase, large),
            ],
        ),
    ]
}

/// The lines of the figures.
pub(crate) fn commands() -> Vec<commands::Figure> {
    let figure = |figure: Figure| commands::Figure {
        page: "figures-path-perturbation.md",
        name: figure.name.into(),
        lines: figure.shots.iter().map(Shot::line).collect(),
    };
    figures().into_iter().map(figure).collect()
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
    /// The line that draws the picture.
    fn line(&self) -> Line {
        let shot = commands::Shot { scene: self.scene, size: self.size, samples: 4, order: self.order };
        let own = self.settings.iter().flat_map(|settings| settings.split_whitespace());
        // The paper's own settings draw everything themselves.
        let is_alone = self.settings.is_none_or(|settings| settings.starts_with(FAITHFUL));
        let settings: Vec<&str> = own.chain(ALONE.into_iter().filter(|_| !is_alone)).collect();
        let mut line = shot.drawn(if self.settings.is_some() { METHOD } else { "reference" }, &settings);
        line.add(&["--frames", FRAMES]);
        if self.motion != "none" {
            line.add(&["--motion", self.motion]);
        }
        if self.time_s != 0.0 {
            line.add(&["--time", &self.time_s.to_string()]);
        }
        line
    }

    /// Draws the picture and prints a row of the table.
    fn draw(&self, figure: &str, scratch: &Path) -> Result<RgbImage> {
        let stats = scratch.join("stats.json");
        let [width, height] = self.size;
        let mut command = command(&self.line());
        command.arg("--quiet");
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
