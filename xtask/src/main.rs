//! Chores of the project's developers: `cargo run -p xtask -- COMMAND`.

mod cameras;
mod layered;
mod light_field;
mod new_method;
mod panels;
mod perturbation;
mod program;
mod scaling;
mod stage;
mod surfaces;
mod virtual_objects;
mod web;

use anyhow::{Context, Result, bail};
use catoptric_testkit::readme::readmes;
use std::path::{Path, PathBuf};
use std::process::Command;

const HELP: &str = "\
Usage: cargo run -p xtask -- COMMAND

Commands:
  figures [NAME]   draw pictures into docs/pictures: those of the README, or, with a part of the name of a figure
                   (`figure-08`; `figure` for all), those of docs/figures-path-perturbation.md, with their times;
                   with `cameras-14` and the like (`cameras` for all) and with `scaling` those of
                   docs/figures-sample-based-camera.md; with `virtual_objects-table`, `virtual_objects-blend` and
                   the like (`virtual_objects` for all) those of docs/figures-virtual-objects.md; with
                   `light_field-8` and the like (`light_field` for all) those of docs/figures-light-field.md; with
                   `layered-table` and the like (`layered` for all) those of docs/figures-layered-environment-map.md;
                   with `surfaces-rough` and the like (`surfaces` for all) those of docs/figures-surfaces.md;
                   with `first_frames [FILE...]`, `growth` and `motion` the tables of docs/performance.md
  new-method NAME --family lookup|projection [--bake] [--layout]
                   make the folder of a method with all roles, its lines in the registry, a test and a bench that
                   fail until it draws
  settings         write the tables of settings into the methods' READMEs
  web [--serve [PORT] | --test [FOLDER]]
                   build the viewer for browsers into dist; serve it on this machine; test it, or a folder that was
                   built before, in Chromium
  ci               run what continuous integration runs";

fn main() -> Result<()> {
    match std::env::args().nth(1).as_deref() {
        Some("figures") => match std::env::args().nth(2).as_deref() {
            Some("first_frames") => scaling::first_frames::draw(&std::env::args().skip(3).collect::<Vec<_>>()),
            Some(name) if name.starts_with("cameras") => cameras::draw(name),
            Some("growth") => scaling::growth::draw(),
            Some("motion") => scaling::motion::draw(),
            Some("scaling") => scaling::draw(),
            Some(name) if name.starts_with("layered") => layered::draw(name),
            Some(name) if name.starts_with("light_field") => light_field::draw(name),
            Some(name) if name.starts_with("surfaces") => surfaces::draw(name),
            Some(name) if name.starts_with("virtual_objects") => virtual_objects::draw(name),
            Some(name) => perturbation::draw(name),
            None => figures(),
        },
        Some("new-method") => new_method::make(&std::env::args().skip(2).collect::<Vec<_>>()),
        Some("settings") => settings(),
        Some("web") => web::run(&std::env::args().skip(2).collect::<Vec<_>>()),
        Some("ci") => run(Command::new("bash").arg(".ci/run")),
        Some(other) => bail!("there is no command `{other}`\n\n{HELP}"),
        None => bail!("{HELP}"),
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}

fn run(command: &mut Command) -> Result<()> {
    let status = command.current_dir(root()).status().with_context(|| format!("cannot start {command:?}"))?;
    if !status.success() {
        bail!("{command:?} failed: {status}");
    }
    Ok(())
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
fn figures() -> Result<()> {
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
