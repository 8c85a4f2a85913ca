//! Virtual objects measured and shown: the table of round trips and the pictures of docs/figures-virtual-objects.md.

use crate::commands::{self, ALONE, Line};
use crate::panels::{below, beside, cut, save_small};
use crate::program::{command, compare, picture};
use crate::repository::root;
use crate::stage::print;
use anyhow::{Context, Result};
use image::RgbImage;
use serde_json::Value;
use std::path::Path;

/// Built-in scenes with the highest order of their paths.
const SCENES: [(&str, u32); 13] = [
    ("sphere_room", 1),
    ("ellipsoid", 1),
    ("two_spheres", 2),
    ("planar_mirror", 2),
    ("large_room", 1),
    ("dish", 1),
    ("car", 1),
    ("vase", 1),
    ("teapot", 1),
    ("torus", 1),
    ("lens", 2),
    ("glass_slab", 2),
    ("glass_sphere", 2),
];

/// Methods of the table, as `catoptric compare --method` takes them.
const METHODS: [&str; 6] = [
    "path_perturbation",
    "sample_based_camera",
    "explosion_map",
    "explosion_map:preset=exact",
    "reflector_search",
    "reflector_search:polish=8",
];

/// Pictures that show what the methods do badly: a name, a scene, the order, the part that is enlarged (x, y, width and
/// height as shares), and the methods; the reference comes last.
type Artefact = (&'static str, &'static str, u32, [f32; 4], &'static [&'static str]);

const ARTEFACTS: [Artefact; 3] = [
    (
        "blend",
        "builtin:sphere_room",
        1,
        [0.3, 0.3, 0.35, 0.35],
        &["explosion_map:preset=faithful", "explosion_map:preset=fast,spheres=2", "explosion_map:preset=fast"],
    ),
    ("ways", "builtin:glass_sphere", 2, [0.25, 0.12, 0.35, 0.35], &["explosion_map", "reflector_search"]),
    (
        "pictures",
        "builtin:vase",
        1,
        [0.35, 0.2, 0.3, 0.3],
        &["reflector_search", "reflector_search:images=cube", "reflector_search:map_size=100"],
    ),
];

/// Makes the figures of `name`: `virtual_objects-table`, `virtual_objects-blend` and the like, or all.
pub(crate) fn draw(name: &str) -> Result<()> {
    let wanted = name.strip_prefix("virtual_objects").unwrap_or_default().trim_start_matches('-');
    let scratch = tempfile::tempdir().context("cannot make a temporary folder")?;
    if wanted.is_empty() || wanted == "table" {
        table(scratch.path())?;
    }
    for artefact in ARTEFACTS.iter().filter(|artefact| wanted.is_empty() || wanted == artefact.0) {
        panels(artefact, scratch.path())?;
    }
    Ok(())
}

/// The lines of the pictures, and one for each method of the table.
pub(crate) fn commands() -> Vec<commands::Figure> {
    let page = "figures-virtual-objects.md";
    let mut line = Line::of(&["compare", "builtin:vase", "--method", "reference"]);
    line.add(&["--order", "1"]);
    line.add(&TABLE_WORDS);
    METHODS.iter().for_each(|method| line.add(&["--method", &alone(method)]));
    let table = commands::Figure { page, name: "virtual_objects-table".into(), lines: vec![line] };
    let pictures = ARTEFACTS.iter().map(|artefact| commands::Figure {
        page,
        name: format!("virtual_objects-{}", artefact.0),
        lines: artefact.4.iter().chain(&["reference"]).map(|method| line_of(artefact, method)).collect(),
    });
    std::iter::once(table).chain(pictures).collect()
}

/// The line of a picture by a method.
fn line_of((_, scene, order, ..): &Artefact, method: &str) -> Line {
    let method = if method == "reference" { method.into() } else { alone(method) };
    let (id, settings) = method.split_once(':').unwrap_or((&method, ""));
    let settings: Vec<&str> = settings.split(',').filter(|setting| !setting.is_empty()).collect();
    commands::Shot { scene, size: [480, 360], samples: 4, order: *order }.drawn(id, &settings)
}

/// How the table's comparisons are made.
const TABLE_WORDS: [&str; 8] = ["--size", "240x180", "--samples", "1", "--frames", "1", "--projection-every", "2"];

/// Prints the table of round trips, as Markdown.
fn table(scratch: &Path) -> Result<()> {
    let titles = METHODS.map(|method| format!(" `{method}` |")).concat();
    print(&format!("| scene | order |{titles}\n|---|---|{}", "---|".repeat(METHODS.len())))?;
    for (scene, order) in SCENES {
        let order = order.to_string();
        let words: Vec<&str> = ["--order", &order].into_iter().chain(TABLE_WORDS).collect();
        let methods = METHODS.map(alone);
        let methods: Vec<&str> = methods.iter().map(String::as_str).collect();
        let rows = compare(&format!("builtin:{scene}"), &words, &methods, &scratch.join(scene))?;
        let cells = rows.iter().skip(1).map(|row| format!(" {} |", cell(row)));
        print(&format!("| {scene} | {order} |{}", cells.collect::<String>()))?;
    }
    Ok(())
}

/// A method, as `catoptric compare --method` takes it, that draws all paths itself: the papers' own settings do.
fn alone(method: &str) -> String {
    if method.contains("preset=faithful") {
        return method.into();
    }
    let separator = if method.contains(':') { ',' } else { ':' };
    format!("{method}{separator}{}", ALONE.join(","))
}

/// Median, 99th percentile, share missing, FLIP.
fn cell(row: &Value) -> String {
    let trips = &row["error"]["projection_px"];
    let number = |value: &Value| value.as_f64().map_or("-".into(), |value| format!("{value:.2}"));
    let small = |value: &Value| match value.as_f64() {
        Some(value) if value < 0.001 => "<0.001".into(),
        Some(value) if value < 0.1 => format!("{value:.3}"),
        _ => number(value),
    };
    let missing = trips["missing"].as_f64().map_or("-".into(), |share| format!("{:.1} %", share * 100.0));
    let flip = number(&row["error"]["reflector"]["flip_mean"]);
    format!("{} / {} / {missing} / {flip}", small(&trips["p50"]), small(&trips["p99"]))
}

/// Draws the methods beside the reference, with a part enlarged below.
fn panels(artefact: &Artefact, scratch: &Path) -> Result<()> {
    let (name, _, _, part, methods) = artefact;
    let mut panels: Vec<RgbImage> = Vec::new();
    for method in methods.iter().chain(&["reference"]) {
        let mut command = command(&line_of(artefact, method));
        panels.push(picture(command.arg("--quiet"), &scratch.join("picture.png"))?);
    }
    let parts: Vec<RgbImage> = panels.iter().map(|panel| cut(panel, *part)).collect();
    let path = root().join(format!("docs/pictures/virtual_objects-{name}.png"));
    save_small(&below(&[beside(&panels), beside(&parts)]), &path)
}
