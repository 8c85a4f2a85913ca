//! Pictures, plots and tables of the documents: `cargo figures [NAME]`.

mod cameras;
mod commands;
mod layered;
mod light_field;
mod panels;
mod perturbation;
mod program;
mod repository;
mod scaling;
mod stage;
mod surfaces;
mod virtual_objects;

use anyhow::{Context, Result, bail};
use catoptric_testkit::readme::readmes;
use commands::Figure;
use repository::{root, run};

const HELP: &str = "\
Usage: cargo figures [NAME]

Without a name the pictures of README.md are drawn. A part of a figure's name draws what it begins; all pictures go
into docs/pictures, tables are printed. The program that draws is built, unless CATOPTRIC_PROGRAM names one.

  figure           `figure-08` and the like: docs/figures-path-perturbation.md
  cameras          `cameras-14`, `cameras-walk` and the like: docs/figures-sample-based-camera.md
  scaling          the curves of the same
  virtual_objects  `virtual_objects-table` and the like: docs/figures-virtual-objects.md
  light_field      `light_field-8` and the like: docs/figures-light-field.md
  layered          `layered-table` and the like: docs/figures-layered-environment-map.md
  surfaces         `surfaces-rough` and the like: docs/figures-surfaces.md
  first_frames [FILE...], growth, motion
                   the tables of docs/performance.md
  commands         the command lines of the figures, which are written into their pages
  settings         the tables of settings in the methods' READMEs, which are written into them";

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.first().map(String::as_str) {
        None => pictures_of_readme(),
        Some("first_frames") => scaling::first_frames::draw(&words[1..]),
        Some("growth") => scaling::growth::draw(),
        Some("motion") => scaling::motion::draw(),
        Some("scaling") => scaling::draw(),
        Some("settings") => settings(),
        Some("commands") => commands::write(&root().join("docs"), &figures()?),
        Some(name) if name.starts_with("cameras") => cameras::draw(name),
        Some(name) if name.starts_with("figure") => perturbation::draw(name),
        Some(name) if name.starts_with("layered") => layered::draw(name),
        Some(name) if name.starts_with("light_field") => light_field::draw(name),
        Some(name) if name.starts_with("surfaces") => surfaces::draw(name),
        Some(name) if name.starts_with("virtual_objects") => virtual_objects::draw(name),
        Some("--help" | "-h") => stage::print(HELP),
        Some(other) => bail!("there is no figure `{other}`\n\n{HELP}"),
    }
}

/// All figures whose lines are written into pages.
fn figures() -> Result<Vec<Figure>> {
    let mut all = perturbation::commands();
    all.extend(virtual_objects::commands());
    all.extend(light_field::commands());
    all.extend(cameras::commands());
    all.extend(layered::commands()?);
    Ok(all)
}

/// Writes the tables of settings into the methods' READMEs.
fn settings() -> Result<()> {
    for readme in readmes()?.into_iter().filter(|readme| readme.text != readme.current) {
        std::fs::write(&readme.path, readme.current)
            .with_context(|| format!("cannot write {}", readme.path.display()))?;
    }
    Ok(())
}

/// The pictures that README.md shows.
fn pictures_of_readme() -> Result<()> {
    let folder = root().join("docs/pictures");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let pictures = [
        ("sphere_room-reference", "builtin:sphere_room", "reference"),
        ("sphere_room-auto", "builtin:sphere_room", "auto"),
        ("sphere_room-environment_map", "builtin:sphere_room", "environment_map"),
        ("vase", "builtin:vase", "reference"),
        ("lens", "builtin:lens", "reference"),
        ("dish", "builtin:dish", "reference"),
        ("car", "builtin:car", "reference"),
    ];
    for (name, scene, method) in pictures {
        let output = folder.join(format!("{name}.png"));
        let words = ["render", scene, "--method", method, "--size", "480x320", "--samples", "16", "--order", "4", "-o"];
        run(program::catoptric(&words).arg(output))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric::methods::{Quality, Report, setting_value};
    use catoptric_testkit::Session;
    use catoptric_testkit::drawing::scene;

    #[test]
    fn pages_have_the_lines_that_their_figures_are_made_with() {
        let figures = figures().expect("all scenes are there");
        for page in commands::pages(&root().join("docs"), &figures).expect("all pages have their marks") {
            assert!(page.text == page.current, "{}: run `cargo figures commands`", page.path.display());
        }
    }

    /// Lines of a page by their words, the broken ones joined.
    fn lines_of(page: &str) -> Vec<Vec<String>> {
        let text = std::fs::read_to_string(root().join("docs").join(page)).expect("the page is there");
        let text = text.replace("\\\n", " ");
        let lines = text.lines().filter(|line| line.starts_with("catoptric render"));
        lines.map(|line| line.split_whitespace().skip(1).map(|word| word.replace('\'', "")).collect()).collect()
    }

    /// The value of an option of a line.
    fn option<'a>(line: &'a [String], name: &str) -> Option<&'a str> {
        Some(line.get(line.iter().position(|word| word == name)? + 1)?)
    }

    /// The report of a small picture that is drawn as a printed line says.
    fn drawn(line: &[String]) -> Report {
        let scene = scene(line[1].strip_prefix("builtin:").expect("a built-in scene"));
        let method = option(line, "--method").expect("a method");
        let order = option(line, "--order").and_then(|order| order.parse().ok()).expect("an order");
        let settings = line.windows(2).filter(|words| words[0] == "--set").map(|words| {
            let (name, given) = words[1].split_once('=').expect("name=value");
            format!("{name} = {}", setting_value(given))
        });
        let settings = settings.collect::<Vec<_>>().join("\n");
        let mut session = Session::new(method, &settings, &scene, Quality { samples: 1, order }).expect("valid");
        session.draw(&scene.default_view(96, 72)).expect("valid").report
    }

    /// The lines that pages print are enough to have the methods draw for themselves.
    #[test]
    fn printed_lines_are_drawn_by_the_method_itself() {
        for (page, method) in [
            ("figures-path-perturbation.md", "path_perturbation"),
            ("figures-virtual-objects.md", "reflector_search"),
            ("figures-sample-based-camera.md", "sample_based_camera"),
        ] {
            let lines = lines_of(page);
            let line =
                lines.iter().find(|line| option(line, "--method") == Some(method)).expect("a line of the method");
            let report = drawn(line);
            assert!(!report.counts.contains_key("tiles") && report.counts["paths"] > 0, "{line:?}: {report:?}");
        }
    }
}
