//! What is taken out of the window: pictures, commands, scenes.

mod command;
#[cfg(not(target_family = "wasm"))]
mod errand;
pub(super) mod files;
mod scene_file;

use super::Viewer;
use catoptric::picture::{PictureFormat, encode, encode_rgb8};
use eframe::egui::{CollapsingHeader, Ui};
#[cfg(not(target_family = "wasm"))]
pub(super) use errand::{Errand, Place, Task};
use glam::DVec3;

/// Buttons that save and copy.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Take away").show(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            let is_sharp = viewer.shown.pictures[0].as_ref().is_some_and(|picture| picture.is_whole);
            let save = |ui: &mut Ui, name: &str| {
                let button = ui.add_enabled(is_sharp, eframe::egui::Button::new(format!("Save {name}")));
                button.on_disabled_hover_text("once the picture is sharp").clicked()
            };
            let has_linear = viewer.shown.pictures[0].as_ref().is_some_and(|picture| picture.linear.is_some());
            for kind in if has_linear { &["png", "exr"][..] } else { &["png"] } {
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
                    Err(problem) => viewer.say(problem),
                }
            }
            #[cfg(not(target_family = "wasm"))]
            errands(viewer, ui);
        });
        #[cfg(not(target_family = "wasm"))]
        errand::show(viewer, ui);
    });
}

/// Buttons for what the program makes beside the window.
#[cfg(not(target_family = "wasm"))]
fn errands(viewer: &mut Viewer, ui: &mut Ui) {
    for (task, name, about) in [
        (Task::Report, "Report...", "A page with the methods that are shown beside the reference, and their errors"),
        (Task::Bake, "Bake...", "What the left method precomputes, in a file for any time"),
    ] {
        let hindrance = viewer.hindrance(task);
        let button = ui.add_enabled(hindrance.is_none(), eframe::egui::Button::new(name)).on_hover_text(about);
        if button.on_disabled_hover_text(hindrance.unwrap_or_default()).clicked() {
            viewer.ask_for_errand(task);
        }
    }
}

/// Saves the left side's picture.
fn save_picture(viewer: &mut Viewer, kind: &'static str) {
    let Some(picture) = &viewer.shown.pictures[0] else { return };
    let (linear, rgba, [width, height]) = (picture.linear.clone(), picture.rgba.clone(), picture.size);
    let make = move |path: &std::path::Path| {
        let content = match (PictureFormat::from_path(path), linear) {
            (Some(PictureFormat::Png), _) => {
                let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
                encode_rgb8(width, height, &rgb)
            }
            (Some(format), Some(linear)) if format.is_linear() => encode(format, &linear),
            _ => return Err(format!("{}: use a name that ends in .png or .exr", path.display())),
        };
        content.map_err(|error| format!("{}: {error}", path.display()))
    };
    viewer.saves.push(files::save(&format!("picture.{kind}"), kind, Box::new(make)));
}

fn save_scene(viewer: &mut Viewer) {
    let (Some(wish), source, opened) = (viewer.sent.clone(), viewer.source.clone(), viewer.opened.clone()) else {
        return;
    };
    let origin = viewer.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.origin);
    let make = move |path: &std::path::Path| {
        scene_file::text((&wish, origin), (&source, &opened), path).map(String::into_bytes)
    };
    viewer.saves.push(files::save("scene.toml", "toml", Box::new(make)));
}
