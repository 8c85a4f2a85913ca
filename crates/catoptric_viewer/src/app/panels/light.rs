//! Light: the environment, for which the scene is opened again, and the exposure and tone in which all is shown.

use super::super::state::Viewer;
use super::super::words::{LETTERS, cut_middle};
use crate::studio::order::Opening;
use catoptric::tone::ToneCurve;
use catoptric_scenes::ENVIRONMENT_NAMES;
use catoptric_scenes::import::EnvironmentEdit;
use eframe::egui::{CollapsingHeader, ComboBox, DragValue, Ui};
use std::path::PathBuf;

/// The environment, how it is turned and scaled, and the exposure.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    let Some(scene) = &viewer.scene else { return };
    let has_environment = scene.has_environment;
    CollapsingHeader::new("Light").default_open(true).show(ui, |ui| {
        let mut wanted = viewer.opened.clone();
        ui.horizontal(|ui| choose(viewer, &mut wanted, ui));
        match has_environment {
            true => drop(ui.horizontal(|ui| edit(viewer, &mut wanted, ui))),
            false => drop(ui.weak("there is none: mirrors show black where they see out of the scene")),
        }
        display(viewer, ui);
        if wanted != viewer.opened && viewer.reopening.is_none() {
            viewer.light(wanted);
        }
    });
}

/// The exposure and the tone curve.
fn display(viewer: &mut Viewer, ui: &mut Ui) {
    let automatic = viewer.scene.as_ref().map(|scene| scene.automatic_stops);
    let display = &mut viewer.display;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let name = ui.label("exposure").id;
        let stops = DragValue::new(&mut display.exposure_stops).range(-16.0..=16.0).speed(0.05).suffix(" EV");
        ui.add(stops.max_decimals(2)).labelled_by(name);
        let about = "the exposure that makes the first view of middle brightness";
        if let (true, Some(stops)) = (ui.button("fit").on_hover_text(about).clicked(), automatic) {
            display.exposure_stops = stops;
        }
        let name = ui.label("tone").id;
        let shown = |curve: ToneCurve| if curve == ToneCurve::None { "linear" } else { curve.name() };
        let list = ComboBox::from_id_salt(name).selected_text(shown(display.curve)).width(60.0).show_ui(ui, |ui| {
            for (curve, _) in ToneCurve::NAMES {
                ui.selectable_value(&mut display.curve, curve, shown(curve));
            }
        });
        list.response.labelled_by(name);
    });
}

/// A list of environments.
fn choose(viewer: &mut Viewer, wanted: &mut Opening, ui: &mut Ui) {
    let name = ui.label("environment").id;
    let shown = wanted.environment.as_ref().map_or("the scene's own".into(), |path| path.display().to_string());
    let list = ComboBox::from_id_salt(name).selected_text(cut_middle(&shown, LETTERS)).truncate();
    let list = list.show_ui(ui, |ui| {
        let about = "As the file says; glTF and OBJ files without light get a studio where they have mirrors or glass";
        ui.selectable_value(&mut wanted.environment, None, "the scene's own").on_hover_text(about);
        for name in ENVIRONMENT_NAMES {
            ui.selectable_value(&mut wanted.environment, Some(PathBuf::from(name)), name);
        }
        #[cfg(not(target_family = "wasm"))]
        if ui.selectable_label(false, "a picture...").on_hover_text("An equirectangular .hdr, .exr or .png").clicked() {
            viewer.ask(super::super::state::question::Purpose::Environment);
        }
    });
    list.response.labelled_by(name).on_hover_text(shown);
    #[cfg(target_family = "wasm")]
    let _ = viewer;
    // Turn and strength of a light that is gone have nothing to do.
    if wanted.environment.is_none() && viewer.opened.environment.is_some() {
        wanted.environment_edit = EnvironmentEdit::default();
    }
}

/// The angle and the factor. They are taken once the hand is off them, as the scene is opened again then.
fn edit(viewer: &mut Viewer, wanted: &mut Opening, ui: &mut Ui) {
    let EnvironmentEdit { rotation_deg, strength } = viewer.light_in_hand.unwrap_or(wanted.environment_edit);
    let (mut degrees, mut factor) = (rotation_deg.unwrap_or(0.0), strength.unwrap_or(1.0));
    let before = (degrees, factor);
    let name = ui.label("turned").id;
    let angle = DragValue::new(&mut degrees).range(-360.0..=360.0).speed(1.0).suffix(" deg").max_decimals(1);
    let angle = ui.add(angle).labelled_by(name);
    let name = ui.label("times").id;
    let times = DragValue::new(&mut factor).range(0.0..=1000.0).speed(0.01).max_decimals(3);
    let times = ui.add(times).labelled_by(name);
    if (degrees, factor) != before {
        let (rotation_deg, strength) = ((degrees != 0.0).then_some(degrees), (factor != 1.0).then_some(factor));
        viewer.light_in_hand = Some(EnvironmentEdit { rotation_deg, strength });
    }
    let is_in_hand = [&angle, &times].into_iter().any(|widget| widget.dragged() || widget.has_focus());
    if !is_in_hand && let Some(edit) = viewer.light_in_hand.take() {
        wanted.environment_edit = edit;
    }
}
