//! Settings of methods: plain structs read from `key = value` tables, with errors that list what is allowed.

use crate::error::RenderError;
use serde::{Serialize, de::DeserializeOwned};

/// A setting as it is shown to users.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingInfo {
    /// Its name.
    pub name: String,
    /// Its default value, as it is written in a scene file.
    pub default: String,
    /// What it does and which values are allowed.
    pub help: &'static str,
}

/// Whether a setting lies in its range; else what is wrong.
pub(crate) fn within(name: &str, value: f32, least: f32, most: f32) -> Result<(), String> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(format!("{name} = {value} is outside {least} to {most}")) }
}

/// The settings from a table that may name a preset: what it does not name has the value of `preset`.
pub(crate) fn from_table_with_presets<S: Settings>(
    table: &toml::Table,
    preset: impl Fn(&S) -> S,
) -> Result<S, RenderError> {
    let fail = |problem: String| RenderError::Setting { method: S::METHOD, problem };
    let read = |table: toml::Table| -> Result<S, RenderError> {
        let read = toml::Value::Table(table).try_into();
        read.map_err(|error: toml::de::Error| fail(error.to_string().trim().replace('\n', " ")))
    };
    let start = preset(&read(table.clone())?);
    let start = toml::Table::try_from(start).map_err(|error| fail(error.to_string()))?;
    let settings = read(start.into_iter().chain(table.clone()).collect())?;
    settings.check().map_err(fail)?;
    Ok(settings)
}

/// A method's settings struct: all fields have defaults, unknown fields are refused
/// (`#[serde(default, deny_unknown_fields)]`).
pub trait Settings: Default + Serialize + DeserializeOwned {
    /// The method's id, for messages.
    const METHOD: &'static str;
    /// One line for every field: its name and what it does.
    const HELP: &'static [(&'static str, &'static str)];

    /// Whether the values are allowed, else what is wrong.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The settings from a table; what the table does not name has its default.
    fn from_table(table: &toml::Table) -> Result<Self, RenderError> {
        let fail = |problem: String| RenderError::Setting { method: Self::METHOD, problem };
        let settings: Self = toml::Value::Table(table.clone())
            .try_into()
            .map_err(|error: toml::de::Error| fail(error.to_string().trim().replace('\n', " ")))?;
        settings.check().map_err(fail)?;
        Ok(settings)
    }

    /// All settings with the values that a table of some of them leads to; those without a value are left out.
    fn in_force(table: &toml::Table) -> Result<toml::Table, RenderError> {
        let fail = |error: toml::ser::Error| RenderError::Setting { method: Self::METHOD, problem: error.to_string() };
        toml::Table::try_from(Self::from_table(table)?).map_err(fail)
    }

    /// All settings with their defaults and explanations.
    fn describe() -> Vec<SettingInfo> {
        let defaults = toml::Table::try_from(Self::default()).unwrap_or_default();
        Self::HELP
            .iter()
            .map(|(name, help)| SettingInfo {
                name: (*name).into(),
                default: defaults.get(*name).map_or_else(|| "none".into(), ToString::to_string),
                help,
            })
            .collect()
    }
}
