//! Where the picked point appears by other methods, as a table.

use super::super::marks::{OF_TRUTH, color_of, offset};
use super::super::state::Viewer;
use super::super::theme::swatch;
use eframe::egui::{CollapsingHeader, Grid, Ui};

/// The table, if something was picked in the picture that is shown.
pub(super) fn show(viewer: &Viewer, ui: &mut Ui) {
    let Some(places) = viewer.places() else { return };
    let help = "Where the end of the picked path appears in the same reflectors by methods that map points to places \
                in the picture, and how far that is from the truth, the exact specular path";
    let header = CollapsingHeader::new("By other methods").default_open(true).show(ui, |ui| {
        Grid::new("places").num_columns(3).min_col_width(16.0).striped(true).show(ui, |ui| {
            swatch(ui, OF_TRUTH);
            ui.label("truth").on_hover_text(match places.is_solved {
                true => "The specular path, solved exactly",
                false => "The ray that was followed: no exact path was found beside it",
            });
            let [x, y] = places.truth_px;
            ui.label(format!("at {x:.1}, {y:.1}"));
            ui.end_row();
            for (index, place) in places.list.iter().enumerate() {
                swatch(ui, color_of(index));
                let [x, y] = place.position_px;
                let hint = if place.remark.is_empty() { "" } else { " *" };
                ui.label(format!("{}{hint}", place.method)).on_hover_text(format!("at {x:.2}, {y:.2}"));
                ui.label(offset(place.offset_px));
                ui.end_row();
            }
        });
        for place in places.list.iter().filter(|place| !place.remark.is_empty()) {
            ui.weak(format!("* {}: {}", place.method, place.remark));
        }
        for (method, why) in &places.silent {
            ui.weak(format!("{method}: {why}"));
        }
        if !places.is_done {
            ui.spinner();
        }
    });
    header.header_response.on_hover_text(help);
}
