//! The times of frames.

use super::super::state::Viewer;
use super::super::state::shown::{FrameTimes, HISTORY};
use super::super::theme::swatch;
use eframe::egui::{Align2, CollapsingHeader, Color32, FontId, Grid, Rect, Sense, Ui, ecolor::Hsva, pos2, vec2};

/// The times of the last frames as stacked bars, and a table of the last one.
pub(super) fn show(viewer: &Viewer, ui: &mut Ui) {
    CollapsingHeader::new("Times").show(ui, |ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 70.0), Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let most = viewer.shown.frames.iter().map(|frame| frame.frame_ms).fold(1.0, f64::max);
        let width = rect.width() / HISTORY as f32;
        for (index, frame) in viewer.shown.frames.iter().enumerate() {
            let left = rect.right() - (viewer.shown.frames.len() - index) as f32 * width;
            bar(frame, most, |low, high, color| {
                let y = |share: f64| rect.bottom() - rect.height() * share as f32;
                painter.rect_filled(Rect::from_min_max(pos2(left, y(high)), pos2(left + width, y(low))), 0.0, color);
            });
        }
        let text = format!("{most:.0} ms");
        painter.text(
            rect.left_top() + vec2(3.0, 2.0),
            Align2::LEFT_TOP,
            text,
            FontId::proportional(11.0),
            ui.visuals().weak_text_color(),
        );
        let Some(picture) = &viewer.shown.pictures[0] else { return };
        Grid::new("stages").num_columns(2).show(ui, |ui| {
            for (name, ms) in &picture.report.stages_ms {
                ui.horizontal(|ui| {
                    swatch(ui, color_of(name));
                    ui.label(*name);
                });
                ui.label(format!("{ms:.2} ms"));
                ui.end_row();
            }
            let counts = picture.report.counts.iter().chain(&picture.report.fallbacks);
            for (name, count) in counts {
                ui.weak(*name);
                ui.weak(count.to_string());
                ui.end_row();
            }
        });
    });
}

/// The parts of a frame's bar, from the bottom: what no stage has is grey.
fn bar(frame: &FrameTimes, most: f64, mut draw: impl FnMut(f64, f64, Color32)) {
    let mut low = 0.0;
    for (name, ms) in &frame.stages_ms {
        let high = low + ms / most;
        draw(low, high.min(1.0), color_of(name));
        low = high.min(1.0);
    }
    draw(low, (frame.frame_ms / most).max(low), Color32::DARK_GRAY);
}

/// The same colour for the same stage, always.
fn color_of(stage: &str) -> Color32 {
    let hash = stage.bytes().fold(5381u32, |hash, byte| hash.wrapping_mul(33) ^ u32::from(byte));
    Hsva::new((hash % 360) as f32 / 360.0, 0.6, 0.85, 1.0).into()
}
