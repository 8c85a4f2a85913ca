//! The light field's figures and tables (Yu, Yang, McMillan 2005), for docs/figures-light-field.md.

mod library;

use crate::commands::{self, Line};
use crate::panels::{below, beside, cut, save_small};
use crate::program::{self, catoptric, compare};
use crate::repository::{root, run};
use crate::stage::print;
use anyhow::{Context, Result};
use image::RgbImage;
use library::{coordinates, scenes, slab_choice};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The room of the pictures: a mirror ball among near things.
const ROOM: &str = "builtin:sphere_room";

/// The paper's sizes.
const FULL: [&str; 4] = ["--set", "st=32", "--set", "uv=128"];

/// The part of figure 8 that is enlarged.
const PART: [f32; 4] = [0.3, 0.25, 0.4, 0.5];

/// Eyes of figure 9, about the ball.
const EYES: [&str; 3] = ["-1.2,1.3,2.6", "0.3,1.3,2.9", "1.7,1.3,2.4"];
const TARGET: &str = "0,1,0";

/// The view from one.
fn view(eye: &str) -> [&str; 6] {
    ["--eye", eye, "--target", TARGET, "--fov", "32"]
}

/// The method of this page.
const LIGHT_FIELD: &str = "light_field";

/// The disparities of figure 8, and the methods of figure 9.
const DISPARITIES: [&str; 3] = ["disparity=none", "disparity=plane", "disparity=depth"];
const WAYS: [&str; 3] = [LIGHT_FIELD, "environment_map", "reference"];

/// How comparisons are made, and that of the table of models.
const MEASURED: [&str; 8] = ["--order", "1", "--size", "480x360", "--samples", "4", "--projection-every", "64"];
const OF_MODELS: &str = "light_field:st=16,uv=64";

/// Methods of table 1.
const METHODS: [&str; 9] = [
    "environment_map",
    "environment_map:parallax=box",
    "light_field:preset=full",
    "light_field:preset=faithful",
    "light_field:preset=faithful,transfer=stored",
    "path_perturbation",
    "sample_based_camera",
    "explosion_map",
    "reflector_search",
];

/// Reflectors of the table of models, from few triangles to many.
const TESSELLATIONS: [u32; 4] = [16, 64, 128, 256];

/// Makes the figures of `name`: `light_field-5`, `-7`, `-8`, `-9`, `-table`, `-models`, `-scenes`, or all.
pub(crate) fn draw(name: &str) -> Result<()> {
    let wanted = name.strip_prefix("light_field").unwrap_or_default().trim_start_matches('-');
    let scratch = tempfile::tempdir().context("cannot make a temporary folder")?;
    let is_wanted = |part: &str| wanted.is_empty() || wanted == part;
    let baked = scratch.path().join("room.bake");
    if is_wanted("8") || is_wanted("9") {
        let mut bake = catoptric(&["bake", ROOM, "--method", "light_field", "--order", "1", "--quiet"]);
        run(bake.args(FULL).arg("-o").arg(&baked))?;
    }
    if is_wanted("8") {
        disparities(scratch.path(), &baked)?;
    }
    if is_wanted("9") {
        eyes(scratch.path(), &baked)?;
    }
    if is_wanted("5") {
        coordinates()?;
    }
    if is_wanted("7") {
        slab_choice()?;
    }
    if is_wanted("scenes") {
        scenes()?;
    }
    if is_wanted("table") {
        methods(scratch.path())?;
    }
    if is_wanted("models") {
        models(scratch.path())?;
    }
    Ok(())
}

/// The line of a picture; light fields have the paper's sizes.
fn line(method: &str, more: &[&str]) -> Line {
    let mut line = commands::Shot { scene: ROOM, size: [480, 360], samples: 4, order: 1 }.drawn(method, &[]);
    if method == LIGHT_FIELD {
        line.add(&FULL);
    }
    line.add(more);
    line
}

/// The lines of the pictures and tables that the program makes.
pub(crate) fn commands() -> Vec<commands::Figure> {
    let page = "figures-light-field.md";
    let figure = |name: &str, lines| commands::Figure { page, name: format!("light_field-{name}"), lines };
    let disparities = DISPARITIES.iter().map(|disparity| line(LIGHT_FIELD, &["--set", disparity]));
    let eyes = WAYS.iter().flat_map(|way| EYES.map(|eye| line(way, &view(eye))));
    let comparison = |scene: &str, methods: &[&str]| {
        let mut line = Line::of(&["compare", scene, "--method", "reference"]);
        line.add(&MEASURED);
        methods.iter().for_each(|method| line.add(&["--method", method]));
        line
    };
    let model = |tessellation| comparison(&format!("{ROOM}?tess={tessellation}"), &[OF_MODELS]);
    vec![
        figure("8", disparities.chain([line("reference", &[])]).collect()),
        figure("9", eyes.collect()),
        figure("table", vec![comparison(ROOM, &METHODS)]),
        figure("models", TESSELLATIONS.map(model).into()),
    ]
}

fn picture(scratch: &Path, line: &Line, baked: Option<&PathBuf>) -> Result<RgbImage> {
    let mut command = program::command(line);
    command.arg("--quiet");
    if let Some(file) = baked {
        command.arg("--baked").arg(file);
    }
    program::picture(&mut command, &scratch.join("picture.png"))
}

/// Figure 8: no disparity, that of a plane, and that of every ray's depth.
fn disparities(scratch: &Path, baked: &PathBuf) -> Result<()> {
    let mut panels = Vec::new();
    for disparity in DISPARITIES {
        panels.push(picture(scratch, &line(LIGHT_FIELD, &["--set", disparity]), Some(baked))?);
    }
    panels.push(picture(scratch, &line("reference", &[]), None)?);
    let parts: Vec<RgbImage> = panels.iter().map(|panel| cut(panel, PART)).collect();
    save_small(&below(&[beside(&panels), beside(&parts)]), &root().join("docs/pictures/light_field-8.png"))
}

/// Figures 9 and 10: what the ball shows while the eye goes about it, by slabs, by an environment map and in truth.
fn eyes(scratch: &Path, baked: &PathBuf) -> Result<()> {
    let mut rows = Vec::new();
    for method in WAYS {
        let mut panels = Vec::new();
        for eye in EYES {
            panels.push(picture(scratch, &line(method, &view(eye)), (method == LIGHT_FIELD).then_some(baked))?);
        }
        rows.push(beside(&panels));
    }
    save_small(&below(&rows), &root().join("docs/pictures/light_field-9.png"))
}

fn measured(scratch: &Path, scene: &str, methods: &[&str]) -> Result<Vec<Value>> {
    compare(scene, &MEASURED, methods, &scratch.join("report"))
}

/// The sum of all numbers of an object.
fn sum(object: &Value) -> f64 {
    object.as_object().map_or(0.0, |object| object.values().filter_map(Value::as_f64).sum())
}

/// Times before the first frame that are the method's own.
fn preparation_ms(row: &Value) -> f64 {
    let shared = ["load", "pose"].iter().filter_map(|name| row["setup_ms"][name].as_f64()).sum::<f64>();
    sum(&row["setup_ms"]) - shared
}

/// Table 1: every method on the room, with numbers in place of low, moderate and high.
fn methods(scratch: &Path) -> Result<()> {
    print(
        "| method | before the first frame | first frame | frame | MB | FLIP on the ball |\n|---|---|---|---|---|---|",
    )?;
    let labels = ["reference"].iter().chain(&METHODS);
    for (label, row) in labels.zip(measured(scratch, ROOM, &METHODS)?) {
        let flip = row["error"]["reflector"]["flip_mean"].as_f64().unwrap_or_default();
        let (before, first) = (preparation_ms(&row), sum(&row["first_stages_ms"]));
        let frame = row["frame_ms"]["median"].as_f64().unwrap_or_default();
        let megabytes = sum(&row["bytes"]) / 1e6;
        let times = format!("{before:.0} ms | {first:.0} ms | {frame:.0} ms");
        print(&format!("| `{label}` | {times} | {megabytes:.1} | {flip:.3} |"))?;
    }
    Ok(())
}

/// The table of models: frames by the reflector's triangles.
fn models(scratch: &Path) -> Result<()> {
    print("| triangles of the ball | frame | FLIP on the ball |\n|---|---|---|")?;
    for tessellation in TESSELLATIONS {
        let scene = format!("{ROOM}?tess={tessellation}");
        let rows = measured(scratch, &scene, &[OF_MODELS])?;
        let Some(row) = rows.get(1) else { continue };
        let triangles = row["counts"]["reflector_triangles"].as_u64().unwrap_or_default();
        let frame = row["frame_ms"]["median"].as_f64().unwrap_or_default();
        let flip = row["error"]["reflector"]["flip_mean"].as_f64().unwrap_or_default();
        print(&format!("| {triangles} | {frame:.0} ms | {flip:.3} |"))?;
    }
    Ok(())
}
