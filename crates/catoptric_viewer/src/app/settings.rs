//! A method's settings: widgets, made from its schema, and texts.

use catoptric::methods::{Limits, MethodInfo, SettingInfo, setting_value};
use eframe::egui::{ComboBox, DragValue, Grid, Id, Response, RichText, Ui};
use toml::{Table, Value};

/// The settings that a text gives: `KEY=VALUE, KEY=VALUE`. Commas in brackets and quotes belong to values.
///
/// # Errors
/// Words about parts that are no settings, and about names and values that the method does not take.
pub fn read_settings(info: &MethodInfo, text: &str) -> Result<Table, String> {
    let mut settings = Table::new();
    for pair in pairs(text) {
        match pair.split_once('=') {
            Some((key, value)) if !key.trim().is_empty() => {
                settings.insert(key.trim().into(), setting_value(value.trim()));
            }
            _ => return Err(format!("`{pair}` is no setting: write it as KEY=VALUE")),
        }
    }
    (info.effective)(&settings).map_err(|error| error.to_string())?;
    Ok(settings)
}

/// The parts between commas that are in no brackets and quotes.
fn pairs(text: &str) -> impl Iterator<Item = &str> {
    let (mut depth, mut quote) = (0_i32, None);
    let between = move |letter: char| {
        match (letter, quote) {
            (_, Some(open)) => quote = Some(open).filter(|open| letter != *open),
            ('"' | '\'', None) => quote = Some(letter),
            ('[', None) => depth += 1,
            (']', None) => depth -= 1,
            _ => {}
        }
        letter == ',' && depth <= 0 && quote.is_none()
    };
    text.split(between).map(str::trim).filter(|pair| !pair.is_empty())
}

/// Shows all settings of a method with the values in force; `scene` are those of the scene, `own` the user's over
/// them, which are changed.
pub(super) fn show(ui: &mut Ui, info: &MethodInfo, scene: &Table, own: &mut Table) {
    let settings = (info.settings)();
    if settings.is_empty() {
        ui.weak("it has no settings");
        return;
    }
    let mut given = scene.clone();
    given.extend(own.clone());
    // Settings that the method cannot take are shown as they were given; a message says why.
    let in_force = (info.effective)(&given).unwrap_or(given);
    Grid::new(("settings", info.id)).num_columns(3).show(ui, |ui| {
        for setting in &settings {
            let name = ui.label(setting.name).on_hover_text(help(setting)).id;
            let default = setting.default.parse::<Value>().ok();
            let mut value = in_force.get(setting.name).cloned().or(default);
            if let Some(value) = &mut value
                && edit(ui, setting, name, value)
            {
                own.insert(setting.name.into(), value.clone());
            }
            let is_own = own.contains_key(setting.name);
            if is_own && ui.small_button("reset").on_hover_text(format!("back to {}", setting.default)).clicked() {
                own.remove(setting.name);
            }
            ui.end_row();
        }
    });
}

fn help(setting: &SettingInfo) -> String {
    let values = setting.values();
    let values = if values.is_empty() { String::new() } else { format!("\n{values}") };
    format!("{}{values}\nDefault: {}", setting.help, setting.default)
}

/// A widget for a value of a setting. Returns true if the user has changed it.
fn edit(ui: &mut Ui, setting: &SettingInfo, name: Id, value: &mut Value) -> bool {
    let before = value.clone();
    let response = match &mut *value {
        Value::Boolean(set) => ui.checkbox(set, ""),
        Value::Integer(number) => edit_whole(ui, setting, number),
        Value::Float(number) => ui.add(limited(DragValue::new(number).suffix(unit(setting)), setting.limits)),
        Value::String(text) if !setting.choices.is_empty() => choose(ui, setting, text),
        Value::String(text) => ui.text_edit_singleline(text),
        Value::Array(numbers) => {
            let edit = |ui: &mut Ui| numbers.iter_mut().for_each(|number| edit_component(ui, number, name));
            ui.horizontal(edit).response
        }
        other => ui.label(other.to_string()),
    };
    response.labelled_by(name);
    *value != before
}

fn unit(setting: &SettingInfo) -> String {
    if setting.unit.is_empty() { String::new() } else { format!(" {}", setting.unit) }
}

/// A widget of a number of any kind, within limits.
fn limited(widget: DragValue<'_>, limits: Limits) -> DragValue<'_> {
    match limits {
        Limits::Range(least, most) => widget.range(least..=most).speed((most - least).min(100.0) * 2e-3),
        Limits::AtLeast(least) => widget.range(least..=f64::from(f32::MAX)).speed(0.01),
        _ => widget.speed(0.05),
    }
}

fn edit_whole(ui: &mut Ui, setting: &SettingInfo, number: &mut i64) -> Response {
    let choices: Vec<i64> = match setting.limits {
        Limits::OneOf(values) => values.iter().map(|value| *value as i64).collect(),
        Limits::PowerOfTwo(least, most) => {
            (0..63).map(|bit| 1i64 << bit).filter(|value| (least as i64..=most as i64).contains(value)).collect()
        }
        limits => {
            let widget = DragValue::new(number).suffix(unit(setting));
            let widget = match limits {
                Limits::Range(least, most) => widget.range(least as i64..=most as i64),
                Limits::AtLeast(least) => widget.range(least as i64..=i64::from(u32::MAX)),
                _ => widget.range(0..=i64::from(u32::MAX)),
            };
            return ui.add(widget.speed(0.1));
        }
    };
    let shown = format!("{number}{}", unit(setting));
    let list = ComboBox::from_id_salt(setting.name).selected_text(shown).show_ui(ui, |ui| {
        for choice in choices {
            ui.selectable_value(number, choice, choice.to_string());
        }
    });
    list.response
}

fn choose(ui: &mut Ui, setting: &SettingInfo, text: &mut String) -> Response {
    let list = ComboBox::from_id_salt(setting.name).selected_text(text.as_str()).show_ui(ui, |ui| {
        for choice in setting.choices {
            ui.selectable_value(text, choice.name.to_owned(), choice.name).on_hover_text(choice.help);
        }
    });
    list.response
}

fn edit_component(ui: &mut Ui, number: &mut Value, name: Id) {
    let mut value = number.as_float().or_else(|| number.as_integer().map(|whole| whole as f64)).unwrap_or_default();
    if ui.add(DragValue::new(&mut value).speed(0.01)).labelled_by(name).changed() {
        *number = Value::Float(value);
    }
}

/// A list of methods to choose from, with what they are as hints.
pub(super) fn choose_method(ui: &mut Ui, name: &str, method: &mut String) {
    ui.horizontal(|ui| {
        let name = ui.label(name).id;
        let list = ComboBox::from_id_salt(name).selected_text(method.as_str()).width(180.0).show_ui(ui, |ui| {
            for info in catoptric::methods::all() {
                let hint = format!("{}\n{}\nRight where: {}", info.summary, info.paper, info.assumptions);
                ui.selectable_value(method, info.id.to_owned(), RichText::new(info.id)).on_hover_text(hint);
            }
        });
        list.response.labelled_by(name);
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric::methods::find;

    #[test]
    fn settings_are_read_from_texts() {
        let info = find("environment_map").unwrap();
        let read = read_settings(info, "parallax=box, size = 64,box_min=[-1, 0, 2.5], ").unwrap();
        let expected = toml::from_str("parallax = 'box'\nsize = 64\nbox_min = [-1, 0, 2.5]").unwrap();
        assert_eq!(read, expected);
        assert_eq!(read_settings(info, " ").unwrap(), Table::new());
        let light_field = find("light_field").unwrap();
        assert_eq!(read_settings(light_field, "views = \"a,b.toml\"").unwrap()["views"].as_str(), Some("a,b.toml"));
    }

    #[test]
    fn what_is_no_setting_is_told_in_words() {
        let info = find("environment_map").unwrap();
        let problem = |text: &str| read_settings(info, text).unwrap_err();
        assert!(problem("paralax=box").contains("there is no setting `paralax`"));
        assert!(problem("parallax=cone").contains("`sphere`"));
        assert!(problem("size=64, parallax").contains("KEY=VALUE"));
        assert!(problem("size=1e9").contains("whole number"));
    }
}
