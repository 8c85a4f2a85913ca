//! Words on the screen: captions over pictures, and long names that are cut.

use super::theme::BEHIND_CAPTIONS;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Ui};

/// Letters of a path that fit into a list.
pub(super) const LETTERS: usize = 26;

/// Letters over the picture.
const CAPTIONS: FontId = FontId::proportional(14.0);

/// Text that can be read on any picture. Returns where it is.
pub(super) fn caption(ui: &Ui, at: Pos2, align: Align2, text: &str) -> Rect {
    let galley = ui.painter().layout_no_wrap(text.into(), CAPTIONS, Color32::WHITE);
    let place = align.anchor_size(at, galley.size());
    ui.painter().rect_filled(place.expand(3.0), 3.0, BEHIND_CAPTIONS);
    ui.painter().galley(place.min, galley, Color32::WHITE);
    place
}

/// The width of a caption.
pub(super) fn width_of(ui: &Ui, text: &str) -> f32 {
    ui.painter().layout_no_wrap(text.into(), CAPTIONS, Color32::WHITE).size().x
}

/// A text of at most so many letters: of longer ones the middle is left out.
pub(super) fn cut_middle(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.into();
    }
    // The end has the file's name.
    let end = (most - 1) * 2 / 3;
    let start = most - 1 - end;
    let (first, last): (String, String) =
        (text.chars().take(start).collect(), text.chars().skip(count - end).collect());
    format!("{first}\u{2026}{last}")
}

#[cfg(test)]
mod tests {
    use super::cut_middle;

    #[test]
    fn long_texts_lose_their_middle() {
        assert_eq!(cut_middle("vase.glb", 8), "vase.glb");
        assert_eq!(cut_middle("/home/somebody/scenes/äöü/vase.glb", 16), "/home\u{2026}ü/vase.glb");
        for most in 1..40 {
            assert!(cut_middle("/home/somebody/scenes/äöü/vase.glb", most).chars().count() <= most);
        }
    }
}
