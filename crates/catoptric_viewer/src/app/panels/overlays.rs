//! Overlays to choose from.

use super::super::state::Viewer;
use super::super::state::overlay::color_of;
use super::super::theme::swatch;
use catoptric::methods;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use eframe::egui::{CollapsingHeader, Ui};

/// Groups of an overlay that are named.
const NAMED: usize = 10;

/// The overlays that the left side's method has, as check boxes, with what their colours mean.
pub(super) fn show(viewer: &mut Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Overlays").show(ui, |ui| {
        let offered = offered(viewer);
        if offered.is_empty() {
            ui.weak(format!("`{}` has none", viewer.choices[0].method));
        }
        for kind in offered {
            let mut is_wanted = viewer.overlays.contains(&kind);
            if ui.checkbox(&mut is_wanted, kind.name()).on_hover_text(kind.help()).changed() {
                match is_wanted {
                    true => drop(viewer.overlays.insert(kind)),
                    false => drop(viewer.overlays.remove(&kind)),
                }
            }
            if let Some(overlay) = viewer.overlay(kind) {
                legend(overlay, ui);
            }
        }
    });
}

/// The overlays of the left side's method.
fn offered(viewer: &Viewer) -> Vec<OverlayKind> {
    let Some(scene) = &viewer.scene else { return Vec::new() };
    let drawn = viewer.drawn(0, scene);
    methods::create(&drawn.method, &drawn.settings).map_or_else(|_| Vec::new(), |method| method.overlays().to_vec())
}

fn legend(overlay: &Overlay, ui: &mut Ui) {
    if overlay.pixels.is_empty() && overlay.segments.is_empty() {
        ui.weak("nothing of it is seen here");
    }
    for (group, name) in overlay.groups.iter().enumerate().take(NAMED) {
        ui.horizontal(|ui| {
            swatch(ui, color_of(overlay.kind, group));
            ui.label(name);
        });
    }
    if let Some(more) = overlay.groups.len().checked_sub(NAMED).filter(|more| *more > 0) {
        ui.weak(format!("and {more} more"));
    }
    if overlay.segments_left_out > 0 {
        ui.label(format!("{} lines; {} more are left out", overlay.segments.len(), overlay.segments_left_out));
    }
}
