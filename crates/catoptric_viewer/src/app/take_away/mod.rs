//! What is taken out of the window: pictures, commands, scenes.

mod command;
pub(super) mod files;
mod scene_file;

use super::Viewer;
use eframe::egui::{CollapsingHeader, Ui};
use std::io::Write;

/// Buttons that save and copy.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Take away").show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let is_sharp = viewer.shown.pictures[0].as_ref().is_some_and(|picture| picture.is_whole);
            let save = |ui: &mut Ui, name: &str| {
                let button = ui.add_enabled(is_sharp, eframe::egui::Button::new(format!("Save {name}")));
                button.on_disabled_hover_text("once the picture is sharp").clicked()
            };
            for kind in ["png", "exr"] {
                if save(ui, &kind.to_uppercase()) {
                    save_picture(viewer, kind);
                }
            }
            if ui.button("Save scene").on_hover_text("A .toml file: the scene with all changes and this view").clicked()
            {
                save_scene(viewer);
            }
            if ui.button("Copy command").on_hover_text("The command line that makes the same picture").clicked() {
                match command::of(viewer) {
                    Ok(line) => ui.ctx().copy_text(line),
                    Err(problem) => viewer.shown.say(problem),
                }
            }
        });
    });
}

fn save_picture(viewer: &mut Viewer, kind: &'static str) {
    let Some(picture) = &viewer.shown.pictures[0] else { return };
    let linear = picture.linear.clone();
    let write =
        move |path: &std::path::Path| catoptric::picture::write(path, &linear).map_err(|error| error.to_string());
    viewer.saves.push(files::save(&format!("picture.{kind}"), kind, Box::new(write)));
}

fn save_scene(viewer: &mut Viewer) {
    let (Some(wish), source) = (viewer.sent.clone(), viewer.source.clone()) else { return };
    let write = move |path: &std::path::Path| {
        let text = scene_file::text(&wish, &source, path)?;
        catoptric::output::write_file(path, |writer| writer.write_all(text.as_bytes()))
            .map_err(|error| error.to_string())
    };
    viewer.saves.push(files::save("scene.toml", "toml", Box::new(write)));
}
