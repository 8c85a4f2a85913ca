//! The panels beside the picture.

mod light;
mod objects;
mod overlays;
mod places;
mod times;

use super::state::Viewer;
use super::state::grip::Tool;
use super::state::shortcuts;
use super::words::{LETTERS, cut_middle};
use super::{settings, take_away, theme};
use crate::studio::news::ClipSummary;
use crate::studio::order::Source;
use catoptric_scenes::builtin;
use eframe::egui::{
    Button, CollapsingHeader, ComboBox, DragValue, Grid, Label, Panel, ProgressBar, Rect, RichText, ScrollArea, Slider,
    Spinner, Ui, UiBuilder, vec2,
};

/// The least width of the panels, in points.
const NARROWEST: f32 = 220.0;

/// Windows narrower than this have no room for panels beside the picture.
const ROOM_FOR_BOTH: f32 = 560.0;

/// The height of the line below the picture, in points; where fingers press its button, and elsewhere.
const STATUS_HEIGHT: [f32; 2] = [40.0, 26.0];

/// The share of a narrow window that unfolded panels take.
const SHARE_UNFOLDED: f32 = 0.5;

/// Shows the panels: beside the picture, or below it in narrow windows, where they are folded at first. Nothing that
/// comes and goes in them changes the picture's size.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    let size = ui.available_size();
    viewer.is_narrow = size.x < ROOM_FOR_BOTH;
    let status_height = STATUS_HEIGHT[usize::from(!viewer.is_narrow)];
    Panel::bottom("status").exact_size(status_height).show(ui, |ui| status(viewer, ui));
    if !viewer.is_narrow {
        // Whoever pulls at its edge still sees something of the picture.
        let widest = (size.x * 0.7).max(NARROWEST);
        let panel = Panel::left("controls").default_size(300.0).min_size(NARROWEST).max_size(widest);
        panel.show(ui, |ui| sections(viewer, ui));
    } else if viewer.is_unfolded {
        Panel::bottom("controls below").exact_size(size.y * SHARE_UNFOLDED).show(ui, |ui| sections(viewer, ui));
    }
}

fn sections(viewer: &mut Viewer, ui: &mut Ui) {
    // Too wide contents are scrolled, and do not push the picture aside.
    ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().slider_width = 90.0;
        let width = ui.available_width();
        let all: [fn(&mut Viewer, &mut Ui); 12] = [
            scene,
            objects::picked,
            |viewer, ui| places::show(viewer, ui),
            view,
            light::show,
            method,
            split,
            take_away::show,
            objects::list,
            overlays::show,
            |viewer, ui| times::show(viewer, ui),
            |_, ui| theme::choice(ui),
        ];
        for section in all {
            // Texts are broken where the panel ends, however wide the section before was.
            let place = Rect::from_min_size(ui.cursor().min, vec2(width, f32::INFINITY));
            ui.scope_builder(UiBuilder::new().max_rect(place), |ui| section(viewer, ui));
        }
    });
}

fn scene(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Scene").default_open(true).show(ui, |ui| {
        let mut chosen = None;
        let shown = viewer.source.word();
        ui.horizontal(|ui| {
            let name = ui.label("scene").id;
            let list = ComboBox::from_id_salt(name).selected_text(cut_middle(&shown, LETTERS)).width(180.0);
            let list = list.truncate().show_ui(ui, |ui| {
                for info in builtin::all() {
                    if ui.selectable_label(false, info.name).on_hover_text(info.summary).clicked() {
                        chosen = Some(Source::Builtin(info.name.into()));
                    }
                }
            });
            list.response.labelled_by(name).on_hover_text(&shown);
        });
        if let Some(source) = chosen {
            viewer.open(source);
        }
        opener(viewer, ui);
        if let Some(scene) = &viewer.scene {
            ui.label(format!("{} objects, {} triangles", scene.objects.len(), scene.triangles));
        }
        for message in viewer.shown.messages.iter().rev().take(4) {
            match message.is_done {
                true => ui.label(message.text.as_str()),
                false => ui.colored_label(ui.visuals().warn_fg_color, message.text.as_str()),
            };
        }
    });
}

/// The button that opens files.
fn opener(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let about = format!(
            "A scene (.glb, .gltf, .obj, .ply, .stl, .toml) or a bake ({})",
            ui.ctx().format_shortcut(&shortcuts::OPEN)
        );
        if ui.button("Open...").on_hover_text(about).clicked() {
            take_away::open(viewer);
        }
        #[cfg(not(target_family = "wasm"))]
        if viewer.has_dialogue() {
            let about = "A dialogue was asked for; if none is to be seen, type the path here";
            if ui.button("Type the path").on_hover_text(about).clicked() {
                viewer.give_dialogues_up();
            }
        }
        let about = "A .glb, .gltf, .obj, .ply, .stl or .toml file, with the files that it names";
        ui.weak("or drop files here").on_hover_text(about);
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
        let dragging = match viewer.tool {
            Tool::Turn => "drag: turn; double click: turn about that point; Shift+drag: pan",
            Tool::Move => "drag an object: move it across the view; Shift+drag: pan",
        };
        ui.weak(format!("{dragging}; right button: look around; wheel: nearer; W A S D Q E: fly"));
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

fn status(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal_centered(|ui| {
        if viewer.is_narrow {
            let text = if viewer.is_unfolded { "Close" } else { "Controls" };
            if ui.add(Button::new(text).min_size(vec2(88.0, 32.0))).clicked() {
                viewer.toggle_panels();
            }
        }
        let now = ui.ctx().input(|input| input.time);
        if let Some((stage, share)) = &viewer.shown.busy {
            match share {
                Some(share) => drop(ui.add(ProgressBar::new(*share).desired_width(80.0).desired_height(12.0))),
                None => drop(ui.add(Spinner::new().size(14.0))),
            }
            let words = RichText::new(cut_middle(stage, 2 * LETTERS)).weak();
            ui.add(Label::new(words).truncate()).on_hover_text(stage);
        }
        let mut words = Vec::new();
        if let Some(picture) = &viewer.shown.pictures[0] {
            let frames = viewer.shown.frames_a_second(now);
            words.extend((frames > 2.0).then(|| format!("{frames} frames a second")));
            words.push(format!("{:.0} ms, {}", picture.frame_ms, picture.processor));
        }
        words.extend(viewer.scene.is_none().then(|| "no scene yet".into()));
        words.extend((!viewer.remark.is_empty()).then(|| viewer.remark.clone()));
        ui.add(Label::new(RichText::new(words.join("; ")).weak()).truncate());
    });
}
