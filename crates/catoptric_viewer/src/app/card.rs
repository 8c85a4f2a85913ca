//! A card in the middle of the picture: why a file was not opened, and what else can be.

use super::state::Viewer;
use super::state::shortcuts::OPEN;
use super::state::shown::Failed;
use super::take_away;
use super::words::cut_middle;
use crate::studio::order::Source;
use catoptric_scenes::builtin;
use eframe::egui::{Align2, Context, Window};

/// Built-in scenes that are offered.
const OFFERED: usize = 8;

/// Letters of a name that are shown.
const LETTERS: usize = 48;

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
            opens = ui.button("Open...").on_hover_text(ctx.format_shortcut(&OPEN)).clicked();
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
