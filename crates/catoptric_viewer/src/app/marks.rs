//! Marks in the picture where methods show the picked point, with a legend.

use super::state::Viewer;
use super::words::caption;
use crate::studio::places::Places;
use eframe::egui::ecolor::Hsva;
use eframe::egui::{Align2, Color32, Pos2, Rect, Stroke, Ui, pos2, vec2};

/// The half size of a mark, in points.
const MARK: f32 = 6.0;

/// The height of a line of the legend, in points.
const LINE: f32 = 20.0;

/// The colour of the truth.
pub(super) const OF_TRUTH: Color32 = Color32::WHITE;

/// The colour of a method, by its place in the list.
pub(super) fn color_of(index: usize) -> Color32 {
    Hsva::new((0.02 + 0.618_034 * index as f32).fract(), 0.8, 1.0, 1.0).into()
}

/// An offset in words.
pub(super) fn offset(px: f32) -> String {
    if px < 0.01 { "< 0.01 px".into() } else { format!("{px:.2} px") }
}

/// Paints the marks and their legend.
pub(super) fn paint(viewer: &Viewer, ui: &Ui, rect: Rect) {
    let Some(places) = viewer.places() else { return };
    let scale = ui.ctx().pixels_per_point();
    let at = |[x, y]: [f32; 2]| rect.min + vec2(x, y) / scale;
    let painter = ui.painter_at(rect);
    // The truth is a ring, so that it can be seen around all others.
    for (width, color) in [(4.0, Color32::BLACK), (2.0, OF_TRUTH)] {
        painter.circle_stroke(at(places.truth_px), MARK + 3.0, Stroke::new(width, color));
    }
    for (index, place) in places.list.iter().enumerate() {
        cross(&painter, at(place.position_px), color_of(index));
    }
    legend(ui, rect, places);
}

/// A cross that stands on one leg.
fn cross(painter: &eframe::egui::Painter, at: Pos2, color: Color32) {
    for (width, color) in [(4.0, Color32::BLACK), (2.0, color)] {
        let stroke = Stroke::new(width, color);
        painter.line_segment([at - vec2(MARK, MARK), at + vec2(MARK, MARK)], stroke);
        painter.line_segment([at - vec2(MARK, -MARK), at + vec2(MARK, -MARK)], stroke);
    }
}

fn legend(ui: &Ui, rect: Rect, places: &Places) {
    let truth = if places.is_solved { "truth" } else { "truth (of the ray alone)" };
    let lines = [(OF_TRUTH, truth.to_owned())].into_iter();
    let lines = lines.chain(places.list.iter().enumerate().map(|(index, place)| {
        let hint = if place.remark.is_empty() { "" } else { " *" };
        (color_of(index), format!("{}  {}{hint}", place.method, offset(place.offset_px)))
    }));
    let painter = ui.painter_at(rect);
    let top = rect.bottom() - 32.0 - LINE * (places.list.len() + 1) as f32;
    for (index, (color, text)) in lines.enumerate() {
        let y = top + LINE * index as f32;
        caption(ui, pos2(rect.left() + 26.0, y), Align2::LEFT_TOP, &text);
        painter.circle(pos2(rect.left() + 14.0, y + 9.0), 5.0, color, Stroke::new(1.5, Color32::BLACK));
    }
}
