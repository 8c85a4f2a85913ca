//! Objects: what was picked, with its role and look, and the list of all.

use super::super::state::{Viewer, shortcuts};
use crate::studio::news::ObjectSummary;
use crate::studio::order::{Changes, RoleChange};
use catoptric::optics::path::bundle::BounceKind;
use catoptric::scene::Role;
use eframe::egui::{Button, CollapsingHeader, Grid, ScrollArea, Slider, TextStyle, Ui};
use glam::Vec3;

/// Shows the picked point: a table of its ray's path, and the role of the object that is seen there.
pub(super) fn picked(viewer: &mut Viewer, ui: &mut Ui) {
    let Some(picked) = &viewer.shown.picked else { return };
    let Some(scene) = &viewer.scene else { return };
    let (path, [x, y]) = (picked.path.clone(), picked.position_px);
    let names: Vec<[String; 2]> =
        scene.objects.iter().map(|object| [object.name.clone(), object.material.clone()]).collect();
    CollapsingHeader::new("Picked").default_open(true).show(ui, |ui| {
        ui.label(format!("pixel {x:.0}, {y:.0}"));
        Grid::new("path").num_columns(4).striped(true).show(ui, |ui| {
            for title in ["", "object", "after", "angle"] {
                ui.strong(title);
            }
            ui.end_row();
            for bounce in &path {
                ui.label(match bounce.kind {
                    Some(BounceKind::Reflect) => "R",
                    Some(BounceKind::Transmit) => "T",
                    None => "end",
                });
                let name = names.get(bounce.object as usize).map_or("", |[name, _]| name.as_str());
                ui.label(name).on_hover_text(format!("{:.4}", bounce.position));
                ui.label(format!("{:.4}", bounce.distance));
                ui.label(format!("{:.1}°", bounce.incidence_deg));
                ui.end_row();
            }
        });
        if let Some([name, material]) = path.first().and_then(|first| names.get(first.object as usize)) {
            role(viewer, ui, name, material, path[0].object);
        }
    });
}

/// The roles of an object, by its name or else its material's.
fn role(viewer: &mut Viewer, ui: &mut Ui, name: &str, material: &str, object: u32) {
    let key = if name.is_empty() { material } else { name };
    if key.is_empty() {
        ui.weak("it has no name by which it could be given another role");
        return;
    }
    let summary = viewer.scene.as_ref().and_then(|scene| scene.objects.get(object as usize)).cloned();
    let Some(summary) = summary else { return };
    let changed = viewer.changes.roles.iter().rfind(|change| change.name == key);
    let (mut role, mut ior) =
        changed.map_or((summary.role, summary.ior), |change| (change.role, change.ior.unwrap_or(summary.ior)));
    let before = (role, ior);
    ui.horizontal_wrapped(|ui| {
        for (choice, text) in [(Role::Diffuse, "plain"), (Role::Reflector, "mirror"), (Role::Lens, "glass")] {
            ui.selectable_value(&mut role, choice, text).on_hover_text(format!("Make `{key}` {text}"));
        }
        if role == Role::Lens {
            ui.add(Slider::new(&mut ior, 1.0..=2.5).text("index"));
        }
    });
    look(viewer, ui, key, &summary, role);
    if (role, ior) != before {
        viewer.changes.roles.retain(|change| change.name != key);
        let is_own = (role, ior) == (summary.role, summary.ior);
        if !is_own {
            let ior = (role == Role::Lens).then_some(ior);
            viewer.changes.roles.push(RoleChange { name: key.into(), role, ior });
        }
    }
}

/// Sliders for what of an object's look can be changed.
fn look(viewer: &mut Viewer, ui: &mut Ui, key: &str, summary: &ObjectSummary, role: Role) {
    let own = summary.look;
    let known = viewer.changes.looks.get(key).copied().unwrap_or_default();
    let mut color = known.color.or(own.color).unwrap_or(Vec3::ONE).to_array();
    let mut roughness = known.roughness.or(own.roughness).unwrap_or(0.0);
    let before = (color, roughness);
    ui.horizontal_wrapped(|ui| {
        let name = ui.label("colour").id;
        ui.color_edit_button_rgb(&mut color).labelled_by(name);
        if viewer.changes.looks.contains_key(key) && ui.small_button("reset").clicked() {
            viewer.changes.looks.remove(key);
        }
        ui.end_row();
        if matches!(role, Role::Reflector | Role::Coated) || own.roughness.is_some() {
            let most = if role == Role::Diffuse { 1.0 } else { 0.5 };
            ui.add(Slider::new(&mut roughness, 0.0..=most).text("roughness"));
        }
    });
    let mut changed = known;
    if color != before.0 {
        changed.color = Some(Vec3::from(color).clamp(Vec3::ZERO, Vec3::ONE));
    }
    if roughness != before.1 {
        changed.roughness = Some(roughness);
    }
    if changed != known {
        viewer.changes.looks.insert(key.into(), changed);
    }
}

/// Buttons that take changes back.
fn undo(viewer: &mut Viewer, ui: &mut Ui) {
    let has_changes = !viewer.changes.is_empty();
    let undo = ui.add_enabled(viewer.history.can_undo(), Button::new("Undo"));
    if undo.on_hover_text(ui.ctx().format_shortcut(&shortcuts::UNDO)).clicked() {
        viewer.undo();
    }
    let redo = ui.add_enabled(viewer.history.can_redo(), Button::new("Redo"));
    if redo.on_hover_text(ui.ctx().format_shortcut(&shortcuts::REDO)).clicked() {
        viewer.redo();
    }
    if ui.add_enabled(has_changes, Button::new("Undo all changes")).clicked() {
        viewer.changes = Changes::default();
    }
}

/// All objects with their roles.
pub(super) fn list(viewer: &mut Viewer, ui: &mut Ui) {
    let Some(scene) = &viewer.scene else { return };
    let rows: Vec<(u32, String, String, Role)> = (0..)
        .zip(&scene.objects)
        .map(|(index, object)| (index, object.name.clone(), object.material.clone(), object.role))
        .collect();
    CollapsingHeader::new("Objects").default_open(true).show(ui, |ui| {
        let height = ui.text_style_height(&TextStyle::Body);
        ScrollArea::vertical().id_salt("objects").max_height(110.0).show_rows(ui, height, rows.len(), |ui, range| {
            for (_, name, material, role) in &rows[range] {
                let changed =
                    viewer.changes.roles.iter().rfind(|change| change.name == *name || change.name == *material);
                let role = changed.map_or(*role, |change| change.role);
                ui.label(format!("{name} ({material}): {}", role.name()));
            }
        });
        ui.horizontal(|ui| undo(viewer, ui));
    });
}
