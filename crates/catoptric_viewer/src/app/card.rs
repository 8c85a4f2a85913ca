//! A card in the middle of the picture: why a file was not opened, and what else can be.

use super::{Viewer, keys, take_away};
use crate::studio::order::Source;
use catoptric_scenes::builtin;
use eframe::egui::{Align2, Context, Window};

/// Built-in scenes that are offered.
const OFFERED: usize = 8;

/// Letters of a name that are shown.
const LETTERS: usize = 48;

/// A scene that could not be opened.
pub(super) struct Failed {
    /// The word that stands for it.
    pub(super) name: String,
    /// Why, and what to do about it.
    pub(super) reason: String,
}

/// Shows the card, if there is one.
pub(super) fn show(viewer: &mut Viewer, ctx: &Context) {
    let Some(Failed { name, reason }) = &viewer.failed else { return };
    let width = (viewer.rect.width() - 48.0).clamp(160.0, 420.0);
    let window = Window::new("This was not opened").collapsible(false).resizable(false).max_width(width);
    let window = window.pivot(Align2::CENTER_CENTER).fixed_pos(viewer.rect.center());
    let (mut chosen, mut opens, mut closes) = (None, false, false);
    window.show(ctx, |ui| {
        ui.set_max_width(width);
        let short = cut_middle(name, LETTERS);
        ui.label(reason.replace(name, &short)).on_hover_text(name);
        ui.horizontal(|ui| {
            opens = ui.button("Open...").on_hover_text(ctx.format_shortcut(&keys::OPEN)).clicked();
            closes = viewer.scene.is_some() && ui.button("Close").clicked();
        });
        ui.weak("or a built-in scene:");
        ui.horizontal_wrapped(|ui| {
            for info in builtin::all().iter().take(OFFERED) {
                if ui.button(info.name).on_hover_text(info.summary).clicked() {
                    chosen = Some(Source::Builtin(info.name.into()));
                }
            }
        });
    });
    if opens {
        take_away::open(viewer);
    }
    if let Some(source) = chosen {
        viewer.open(source);
    } else if closes {
        viewer.failed = None;
    }
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
