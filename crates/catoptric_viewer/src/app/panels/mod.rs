//! The panels beside the picture.

mod objects;
mod overlays;
mod places;
mod times;

use super::hand::Tool;
use super::take_away::{self, files};
use super::{Viewer, settings};
use crate::studio::news::ClipSummary;
use crate::studio::order::Source;
use catoptric::tone::ToneCurve;
use catoptric_scenes::builtin;
use eframe::egui::{
    CollapsingHeader, Color32, ComboBox, DragValue, Grid, Panel, ProgressBar, RichText, ScrollArea, Sense, Slider, Ui,
    vec2,
};

/// The least width of the panels, in points.
const NARROWEST: f32 = 220.0;

/// Shows the panels.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    Panel::bottom("status").show(ui, |ui| status(viewer, ui));
    // Whoever pulls at its edge still sees something of the picture.
    let widest = (ui.available_width() * 0.7).max(NARROWEST);
    Panel::left("controls").default_size(300.0).min_size(NARROWEST).max_size(widest).show(ui, |ui| {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().slider_width = 90.0;
            scene(viewer, ui);
            view(viewer, ui);
            method(viewer, ui);
            split(viewer, ui);
            overlays::show(viewer, ui);
            objects::picked(viewer, ui);
            places::show(viewer, ui);
            objects::list(viewer, ui);
            take_away::show(viewer, ui);
            times::show(viewer, ui);
        });
    });
}

/// A square of a colour, for legends.
fn swatch(ui: &mut Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, color);
}

fn scene(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Scene").default_open(true).show(ui, |ui| {
        let mut chosen = None;
        let shown = viewer.source.word();
        ui.horizontal(|ui| {
            let name = ui.label("scene").id;
            let list = ComboBox::from_id_salt(name).selected_text(shown).width(180.0).show_ui(ui, |ui| {
                for info in builtin::all() {
                    if ui.selectable_label(false, info.name).on_hover_text(info.summary).clicked() {
                        chosen = Some(Source::Builtin(info.name.into()));
                    }
                }
            });
            list.response.labelled_by(name);
        });
        if let Some(source) = chosen {
            viewer.open(source);
        }
        if ui.button("Open...").clicked() && viewer.opening.is_none() {
            viewer.opening = Some(files::open());
        }
        ui.weak("or drop .glb, .gltf, .obj, .ply, .stl or .toml here, with the files that it names");
        if let Some(scene) = &viewer.scene {
            ui.label(format!("{} objects, {} triangles", scene.objects.len(), scene.triangles));
        }
        for message in viewer.shown.messages.iter().rev().take(4) {
            ui.label(RichText::new(message).color(Color32::from_rgb(240, 170, 60)));
        }
    });
}

fn view(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("View").default_open(true).show(ui, |ui| {
        let names: Vec<String> =
            viewer.scene.iter().flat_map(|scene| &scene.cameras).enumerate().map(camera_name).collect();
        let shown = viewer.camera.and_then(|index| names.get(index)).map_or("moved by hand", String::as_str).to_owned();
        let mut chosen = None;
        ui.horizontal(|ui| {
            let name = ui.label("camera").id;
            let list = ComboBox::from_id_salt(name).selected_text(shown).show_ui(ui, |ui| {
                for (index, name) in names.iter().enumerate() {
                    if ui.selectable_label(viewer.camera == Some(index), name).clicked() {
                        chosen = Some(index);
                    }
                }
            });
            list.response.labelled_by(name);
            if ui.button("Frame all").on_hover_text("F").clicked() {
                viewer.frame_all();
            }
        });
        if let Some(index) = chosen {
            viewer.take_camera(index);
        }
        clips(viewer, ui);
        if viewer.clock.duration() > 0.0 {
            ui.horizontal(|ui| {
                let button = if viewer.clock.plays() { "Pause" } else { "Play" };
                if ui.button(button).on_hover_text("Space").clicked() {
                    viewer.clock.toggle();
                }
                let mut time = viewer.clock.time();
                let bar = Slider::new(&mut time, 0.0..=viewer.clock.duration()).suffix(" s").text("time");
                if ui.add(bar).changed() {
                    viewer.clock.set(time);
                }
            });
        }
        ui.horizontal(|ui| {
            ui.selectable_value(&mut viewer.tool, Tool::Turn, "turn the view").on_hover_text("M changes");
            ui.selectable_value(&mut viewer.tool, Tool::Move, "move objects").on_hover_text("M changes");
        });
        display(viewer, ui);
        let help =
            "drag: turn; shift or middle button: shift; right button: look around; wheel: nearer; W A S D Q E: fly";
        ui.weak(help);
    });
}

/// The animations, of which one may play alone.
fn clips(viewer: &mut Viewer, ui: &mut Ui) {
    let Some(scene) = viewer.scene.as_ref().filter(|scene| !scene.clips.is_empty()) else { return };
    let named = |(index, clip): (usize, &ClipSummary)| match clip.name.as_str() {
        "" => format!("{index} ({:.1} s)", clip.duration),
        name => format!("{name} ({:.1} s)", clip.duration),
    };
    let names: Vec<String> = scene.clips.iter().enumerate().map(named).collect();
    let all = format!("as the file plays ({:.1} s)", scene.duration(None));
    let shown = viewer.clip.and_then(|index| names.get(index)).unwrap_or(&all);
    let mut chosen = viewer.clip;
    ui.horizontal(|ui| {
        let name = ui.label("animation").id;
        let list = ComboBox::from_id_salt(name).selected_text(shown).width(180.0).truncate().show_ui(ui, |ui| {
            let about = "All at once, but for those that move what an earlier one moves";
            ui.selectable_value(&mut chosen, None, &all).on_hover_text(about);
            for (index, name) in names.iter().enumerate() {
                ui.selectable_value(&mut chosen, Some(index), name);
            }
        });
        list.response.labelled_by(name);
    });
    if chosen != viewer.clip {
        viewer.choose_clip(chosen);
    }
}

/// The exposure and the tone curve.
fn display(viewer: &mut Viewer, ui: &mut Ui) {
    let automatic = viewer.scene.as_ref().map(|scene| scene.automatic_stops);
    let display = &mut viewer.display;
    ui.horizontal(|ui| {
        let name = ui.label("exposure").id;
        let stops = DragValue::new(&mut display.exposure_stops).range(-16.0..=16.0).speed(0.05).suffix(" EV");
        ui.add(stops.max_decimals(2)).labelled_by(name);
        let about = "the exposure that makes the first view of middle brightness";
        if let (true, Some(stops)) = (ui.button("fit").on_hover_text(about).clicked(), automatic) {
            display.exposure_stops = stops;
        }
        let name = ui.label("tone").id;
        let shown = |curve: ToneCurve| if curve == ToneCurve::None { "linear" } else { curve.name() };
        let list = ComboBox::from_id_salt(name).selected_text(shown(display.curve)).width(70.0).show_ui(ui, |ui| {
            for (curve, _) in ToneCurve::NAMES {
                ui.selectable_value(&mut display.curve, curve, shown(curve));
            }
        });
        list.response.labelled_by(name);
    });
}

fn camera_name((index, camera): (usize, &catoptric::scene::Camera)) -> String {
    match camera.name.as_str() {
        "" => format!("camera {index}"),
        name => format!("{index} {name}"),
    }
}

fn method(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Method").default_open(true).show(ui, |ui| {
        choice(viewer, ui, 0);
        Grid::new("quality").num_columns(2).show(ui, |ui| {
            let name = ui.label("order").on_hover_text("Highest number of reflections and refractions on a path").id;
            ui.horizontal(|ui| {
                let needed = viewer.scene.as_ref().map_or(2, |scene| scene.order_needed);
                let mut order = viewer.order.unwrap_or(needed);
                if ui.add(DragValue::new(&mut order).range(0..=16).speed(0.05)).labelled_by(name).changed() {
                    viewer.order = Some(order);
                }
                let about = "what the scene needs; light from infinity where paths end";
                if ui.selectable_label(viewer.order.is_none(), "as needed").on_hover_text(about).clicked() {
                    viewer.order = if viewer.order.is_some() { None } else { Some(needed) };
                }
            });
            ui.end_row();
            let name = ui.label("samples").on_hover_text("Antialiasing samples a pixel").id;
            let shown = viewer.samples.to_string();
            let list = ComboBox::from_id_salt(name).selected_text(shown).show_ui(ui, |ui| {
                for samples in catoptric::raster::SAMPLE_COUNTS {
                    ui.selectable_value(&mut viewer.samples, samples, samples.to_string());
                }
            });
            list.response.labelled_by(name);
            ui.end_row();
        });
    });
}

/// A side's method and its settings.
fn choice(viewer: &mut Viewer, ui: &mut Ui, side: usize) {
    let choice = &mut viewer.choices[side];
    settings::choose_method(ui, ["left", "right"][side], &mut choice.method);
    let Ok(info) = catoptric::methods::find(&choice.method) else { return };
    ui.weak(info.summary);
    let of_scene = viewer.scene.as_ref().and_then(|scene| scene.settings.get(info.id)).cloned().unwrap_or_default();
    CollapsingHeader::new("Settings").id_salt(("settings", side)).show(ui, |ui| {
        settings::show(ui, info, &of_scene, choice.settings.entry(info.id.into()).or_default());
    });
}

fn split(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Against").default_open(true).show(ui, |ui| {
        ui.horizontal(|ui| {
            let mut is_split = viewer.divider.is_some();
            if ui.checkbox(&mut is_split, "split view").on_hover_text("X").changed() {
                viewer.toggle_split();
            }
            let mut shows_heat = viewer.shows_heat;
            if ui
                .checkbox(&mut shows_heat, "error")
                .on_hover_text("H: a heat map of LDR-FLIP, left against right")
                .changed()
            {
                viewer.toggle_heat();
            }
        });
        if viewer.divider.is_some() {
            choice(viewer, ui, 1);
        }
        if let Some(compared) = viewer.shown.compared.as_ref().filter(|_| viewer.divider.is_some()) {
            ui.label(format!("FLIP {:.4}, off by > 0.1: {:.3} %", compared.flip_mean, compared.over_0_1 * 100.0));
        }
    });
}

fn status(viewer: &Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let now = ui.ctx().input(|input| input.time);
        if let Some(picture) = &viewer.shown.pictures[0] {
            let frames = viewer.shown.frames_a_second(now);
            let moving = if frames > 2.0 { format!("{frames} frames a second, ") } else { String::new() };
            ui.label(format!("{moving}{:.0} ms, {}", picture.frame_ms, picture.processor));
        }
        if let Some((stage, share)) = &viewer.shown.busy {
            match share {
                Some(share) => drop(ui.add(ProgressBar::new(*share).desired_width(120.0))),
                None => drop(ui.spinner()),
            }
            ui.weak(stage);
        }
        if viewer.scene.is_none() {
            ui.weak("no scene yet");
        }
        ui.weak(viewer.remark.as_str());
    });
}
