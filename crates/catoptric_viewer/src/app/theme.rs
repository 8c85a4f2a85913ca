//! Colours of the panels, in the dark and in the light: all text stands out from what is behind it by 4.5 to 1, as
//! WCAG 2 asks for (level AA).

use eframe::egui::{Color32, Context, Sense, Theme, Ui, Visuals, vec2};

/// The ground of text over a picture: opaque enough for the text to be read on white.
pub(super) const BEHIND_CAPTIONS: Color32 = Color32::from_black_alpha(165);

/// Sets both themes; pictures look best in the dark one.
pub(super) fn set(ctx: &Context) {
    ctx.set_visuals_of(Theme::Dark, visuals(Theme::Dark));
    ctx.set_visuals_of(Theme::Light, visuals(Theme::Light));
    ctx.set_theme(Theme::Dark);
}

/// The colours of a theme.
pub(super) fn visuals(theme: Theme) -> Visuals {
    let (mut visuals, text, weak, warning) = match theme {
        Theme::Dark => {
            let warning = Color32::from_rgb(240, 170, 60);
            (Visuals::dark(), Color32::from_gray(205), Color32::from_gray(165), warning)
        }
        Theme::Light => {
            let warning = Color32::from_rgb(150, 75, 0);
            (Visuals::light(), Color32::from_gray(40), Color32::from_gray(85), warning)
        }
    };
    visuals.widgets.noninteractive.fg_stroke.color = text;
    visuals.weak_text_color = Some(weak);
    visuals.warn_fg_color = warning;
    visuals
}

/// A box that chooses the theme.
pub(super) fn choice(ui: &mut Ui) {
    let mut is_light = ui.ctx().theme() == Theme::Light;
    if ui.checkbox(&mut is_light, "light panels").changed() {
        ui.ctx().set_theme(if is_light { Theme::Light } else { Theme::Dark });
    }
}

/// A square of a colour, for legends.
pub(super) fn swatch(ui: &mut Ui, color: Color32) {
    let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, color);
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::style::WidgetVisuals;

    /// Relative luminance, as WCAG 2 defines it.
    fn luminance(color: Color32) -> f64 {
        let linear = |value: u8| match f64::from(value) / 255.0 {
            low if low <= 0.04045 => low / 12.92,
            high => ((high + 0.055) / 1.055).powf(2.4),
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    /// The contrast of two colours, 1 to 21, as WCAG 2 defines it.
    fn contrast(one: Color32, other: Color32) -> f64 {
        let (one, other) = (luminance(one), luminance(other));
        (one.max(other) + 0.05) / (one.min(other) + 0.05)
    }

    #[test]
    fn all_text_stands_out_from_what_is_behind_it() {
        // The numbers of WCAG's own examples.
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
        assert!((contrast(Color32::from_gray(0x77), Color32::WHITE) - 4.48).abs() < 5e-3);
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = visuals(theme);
            let mut pairs = vec![
                ("text", visuals.text_color(), visuals.panel_fill),
                ("a hint", visuals.weak_text_color(), visuals.panel_fill),
                ("a hint in a window", visuals.weak_text_color(), visuals.window_fill),
                ("a hint in a field", visuals.weak_text_color(), visuals.extreme_bg_color),
                ("a warning", visuals.warn_fg_color, visuals.panel_fill),
                ("a warning in a window", visuals.warn_fg_color, visuals.window_fill),
                ("a title", visuals.strong_text_color(), visuals.panel_fill),
                ("what is chosen", visuals.selection.stroke.color, visuals.selection.bg_fill),
            ];
            let widgets = &visuals.widgets;
            let buttons = |of: &WidgetVisuals| (of.text_color(), of.weak_bg_fill);
            for (name, of) in [
                ("a button", &widgets.inactive),
                ("a button under the pointer", &widgets.hovered),
                ("a button that is pressed", &widgets.active),
                ("a list that is open", &widgets.open),
            ] {
                let (text, behind) = buttons(of);
                pairs.push((name, text, behind));
            }
            for (name, text, behind) in pairs {
                let found = contrast(text, behind);
                assert!(found >= 4.5, "{theme:?}: {name} has {found:.2}: {text:?} on {behind:?}");
            }
        }
        // Over white pictures the caption's ground is a grey.
        let over_white = Color32::WHITE.blend(BEHIND_CAPTIONS);
        assert!(contrast(Color32::WHITE, over_white) >= 4.5, "{over_white:?}");
    }
}
