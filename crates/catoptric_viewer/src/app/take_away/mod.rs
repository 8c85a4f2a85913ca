//! Things that users take out of the window: pictures, commands, scenes.

#[cfg(not(target_family = "wasm"))]
mod ask;
mod command;
#[cfg(not(target_family = "wasm"))]
mod errand;
pub(super) mod files;
mod scene_file;

#[cfg(not(target_family = "wasm"))]
use super::state::errand::Task;
use super::state::file::Make;
#[cfg(not(target_family = "wasm"))]
use super::state::question::Purpose;
use super::state::{Viewer, shortcuts};
use catoptric::picture::{PictureFormat, encode, encode_rgb8};
use eframe::egui::{CollapsingHeader, Ui};
use glam::DVec3;

/// Buttons that save and copy.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Export").default_open(true).show(ui, |ui| {
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
            let about = format!(
                "A .toml file: the scene with all changes and this view ({})",
                ui.ctx().format_shortcut(&shortcuts::SAVE)
            );
            if ui.button("Save scene").on_hover_text(about).clicked() {
                save_scene(viewer);
            }
            if ui.button("Copy command").on_hover_text("The command line that makes the same picture").clicked() {
                match command::of(viewer) {
                    Ok(line) => {
                        viewer.note(format!("copied: {line}"));
                        ui.ctx().copy_text(line);
                    }
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
            viewer.ask(Purpose::Task(task));
        }
    }
}

/// Saves the left side's picture.
pub(super) fn save_picture(viewer: &mut Viewer, kind: &'static str) {
    let Some(picture) = viewer.shown.pictures[0].as_ref().filter(|picture| picture.is_whole) else {
        return viewer.say("the picture can be saved once it is sharp: wait a moment");
    };
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
    save(viewer, format!("picture.{kind}"), kind, Box::new(make));
}

/// Saves the scene with all changes.
pub(super) fn save_scene(viewer: &mut Viewer) {
    let (Some(wish), source, opened) = (viewer.sent.clone(), viewer.source.clone(), viewer.opened.clone()) else {
        return;
    };
    let origin = viewer.scene.as_ref().map_or(DVec3::ZERO, |scene| scene.origin);
    let make = move |path: &std::path::Path| {
        scene_file::text((&wish, origin), (&source, &opened), path).map(String::into_bytes)
    };
    save(viewer, "scene.toml".into(), "toml", Box::new(make));
}

/// Asks where to save a file, and saves it.
#[cfg(not(target_family = "wasm"))]
fn save(viewer: &mut Viewer, name: String, extension: &'static str, make: Make) {
    viewer.ask(Purpose::Save { name, extension, make });
}

/// Saves a file where the browser does.
#[cfg(target_family = "wasm")]
fn save(viewer: &mut Viewer, name: String, _extension: &'static str, make: Make) {
    viewer.saves.push(files::save(&name, make));
}

/// Asks for a scene, and opens it.
pub(super) fn open(viewer: &mut Viewer) {
    #[cfg(not(target_family = "wasm"))]
    viewer.ask(Purpose::Open);
    #[cfg(target_family = "wasm")]
    {
        viewer.opening = Some(files::open());
    }
}
