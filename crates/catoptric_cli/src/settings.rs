//! Settings of methods, from scenes and from the command line.

use crate::failure::Failure;
use crate::parse;
use catoptric::error::RenderError;
use catoptric::methods::bake::Baked;
pub(crate) use catoptric::methods::setting_value as value;
use catoptric::methods::{self, Method, MethodInfo};
use catoptric::scene::Model;
use catoptric_bake::{BakeChoice, Unfit};
use std::sync::Arc;
use toml::{Table, Value};

/// A method that is ready to be prepared, and the settings it was made from.
pub(crate) struct Chosen {
    pub(crate) method: Box<dyn Method>,
    pub(crate) info: &'static MethodInfo,
    pub(crate) settings: Table,
    pub(crate) bake: Option<Arc<dyn Baked>>,
    /// Why no bake of the method can be used, where there are some: it is not drawn then.
    pub(crate) unfit: Option<Unfit>,
}

/// The method with this id, with the scene's settings and `given` over them.
pub(crate) fn choose(id: &str, model: &Model, given: &Table) -> Result<Chosen, Failure> {
    let info = methods::find(id).map_err(Failure::usage)?;
    made_of(info, BakeChoice { settings: merged(info, model, given), bake: None, problem: None })
}

/// A method's settings in a scene, with `given` over them.
pub(crate) fn merged(info: &MethodInfo, model: &Model, given: &Table) -> Table {
    let mut settings = model.method_settings.get(info.id).cloned().unwrap_or_default();
    settings.extend(given.clone());
    settings
}

/// A method made from settings, with the bake that was chosen for it.
pub(crate) fn made_of(info: &'static MethodInfo, choice: BakeChoice) -> Result<Chosen, Failure> {
    let BakeChoice { settings, bake, problem: unfit } = choice;
    let method = methods::create(info.id, &settings).map_err(Failure::usage)?;
    Ok(Chosen { method, info, settings, bake, unfit })
}

/// All settings of a method with the values in force, as JSON.
pub(crate) fn effective(info: &MethodInfo, settings: &Table) -> serde_json::Map<String, serde_json::Value> {
    let values = (info.effective)(settings).unwrap_or_else(|_| settings.clone());
    let value = |name: &str| values.get(name).map_or(serde_json::Value::Null, json);
    (info.settings)().iter().map(|setting| (setting.name.into(), value(setting.name))).collect()
}

fn json(value: &Value) -> serde_json::Value {
    serde_json::to_value(value).unwrap_or_default()
}

/// Checks the settings that a scene has for methods.
pub(crate) fn check(model: &Model) -> Result<(), Failure> {
    for (id, settings) in &model.method_settings {
        let table = format!("method.{id}");
        let info = methods::find(id).map_err(|error| model.invalid(&table, error.to_string()))?;
        if let Some((key, problem)) = fault(info, settings) {
            let field = key.map_or(table.clone(), |key| format!("{table}.{key}"));
            return Err(model.invalid(&field, problem).into());
        }
    }
    Ok(())
}

/// The reason why a method cannot take settings, and the key at fault; `None` for keys that do not go together.
pub(crate) fn fault(info: &MethodInfo, settings: &Table) -> Option<(Option<String>, String)> {
    let refusal = |settings: &Table| match (info.create)(settings).err()? {
        RenderError::Setting { problem, .. } => Some(problem),
        error => Some(error.to_string()),
    };
    let problem = refusal(settings)?;
    let is_wrong = |(key, value): &(&String, &Value)| {
        refusal(&Table::from_iter([((*key).clone(), (*value).clone())])).as_ref() == Some(&problem)
    };
    let key = settings.iter().find(is_wrong).map(|(key, _)| key.clone());
    Some((key, problem))
}

/// The settings after the colon of `--method ID:KEY=VALUE,...`, if there is one.
pub(crate) fn of_variant(label: &str, variant: Option<&str>) -> Result<Table, Failure> {
    let pairs = variant.into_iter().flat_map(|variant| variant.split(','));
    let setting = |pair: &str| match parse::key_value(pair) {
        Ok((key, text)) => Ok((key, value(&text))),
        Err(problem) => Err(Failure::usage(format!("--method {label}: {problem}"))),
    };
    pairs.map(setting).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_show_in_the_settings_in_force() {
        let info = methods::find("sample_based_camera").unwrap();
        let given: Table = toml::from_str("preset = 'faithful'\ndownsampling = 3").unwrap();
        let all = effective(info, &given);
        assert_eq!((all["camera"].as_str(), all["downsampling"].as_u64()), (Some("pinhole"), Some(3)));
        assert_eq!(all.len(), (info.settings)().len());
    }

    #[test]
    fn values_are_toml_or_text() {
        assert_eq!(value("3"), Value::Integer(3));
        assert_eq!(value("-0.5"), Value::Float(-0.5));
        assert_eq!(value("true"), Value::Boolean(true));
        assert_eq!(value("box"), Value::String("box".into()));
        assert_eq!(value("\"3\""), Value::String("3".into()));
        assert_eq!(value("[1, 2]"), Value::Array(vec![Value::Integer(1), Value::Integer(2)]));
        assert_eq!(value("1\nother = 2"), Value::String("1\nother = 2".into()));
        assert_eq!(value(""), Value::String(String::new()));
    }
}
