//! The table of first frames of docs/performance.md: every method with its default settings, on every built-in scene
//! and on files, from the program's start to the picture.

use crate::program::{catoptric, json};
use crate::repository::{root, run};
use crate::stage::print;
use anyhow::{Context, Result};
use catoptric::methods;
use catoptric_scenes::{builtin, import};
use std::path::Path;
use std::time::Instant;

/// The time in seconds beyond which a first frame is marked in the table.
const GOAL_S: f64 = 10.0;

/// The options with which each scene is drawn.
const QUESTION: [&str; 7] = ["--size", "640x480", "--samples", "4", "--order", "2", "--quiet"];

/// A scene of the table.
struct Row {
    /// As the program takes it.
    scene: String,
    /// As the table shows it.
    title: String,
    /// True if it has neither mirror nor glass of its own, so that all of it becomes a mirror.
    is_made_mirror: bool,
}

/// Prints the table of the built-in scenes, or that of files.
pub(crate) fn draw(files: &[String]) -> Result<()> {
    // Built before anything is timed.
    run(catoptric(&["--version"]).stdout(std::process::Stdio::null()))?;
    let rows = if files.is_empty() { builtin_rows() } else { files.iter().map(|file| file_row(file)).collect() };
    let ids: Vec<&str> = methods::all().iter().map(|method| method.id).collect();
    let titles: String = ids.iter().map(|id| format!(" `{id}` |")).collect();
    print(&format!("| scene |{titles}\n|---|{}", "---|".repeat(ids.len())))?;
    let scratch = tempfile::tempdir().context("cannot make a temporary folder")?;
    for row in rows {
        let mut cells = String::new();
        for id in &ids {
            cells += &format!(" {} |", cell(&row, id, scratch.path())?);
        }
        print(&format!("| {} |{cells}", row.title))?;
    }
    Ok(())
}

/// All built-in scenes; those whose mirror may be a formula or a mesh, as both.
fn builtin_rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for scene in builtin::all() {
        let has_both = scene.parameters.iter().any(|parameter| parameter.name == "surface");
        for surface in if has_both { &["?surface=analytic", "?surface=mesh"][..] } else { &[""] } {
            let title = format!("{}{surface}", scene.name);
            rows.push(Row { scene: format!("builtin:{title}"), title, is_made_mirror: false });
        }
    }
    rows
}

fn file_row(file: &str) -> Row {
    let path = Path::new(file);
    let title = path.file_name().map_or(file.into(), |name| name.to_string_lossy().into_owned());
    let posed = import::load(path).ok().and_then(|model| model.pose(&Default::default()).ok());
    let is_made_mirror = posed.is_some_and(|scene| scene.specular_objects().is_empty());
    let title = if is_made_mirror { format!("{title}, as a mirror") } else { title };
    Row { scene: file.into(), title, is_made_mirror }
}

/// Seconds, in bold above the goal; with a star if the method reports something that is drawn in a coarser way.
fn cell(row: &Row, id: &str, scratch: &Path) -> Result<String> {
    let stats = scratch.join("stats.json");
    let mut command = catoptric(&["render", &row.scene, "--method", id]);
    command.args(QUESTION).arg("-o").arg(scratch.join("picture.png")).arg("--stats").arg(&stats);
    if row.is_made_mirror {
        command.args(["--reflector", "*"]);
    }
    let start = Instant::now();
    let ended = command.current_dir(root()).output().context("cannot start the program")?;
    let seconds = start.elapsed().as_secs_f64();
    if !ended.status.success() {
        eprintln!("{} with {id}: {}", row.title, String::from_utf8_lossy(&ended.stderr).trim());
        return Ok("–".into());
    }
    let is_coarser = json(&stats)?["counts"]["fallbacks"].as_object().is_some_and(|kinds| !kinds.is_empty());
    let time = if seconds > GOAL_S { format!("**{seconds:.1}**") } else { format!("{seconds:.1}") };
    Ok(time + if is_coarser { "\\*" } else { "" })
}
