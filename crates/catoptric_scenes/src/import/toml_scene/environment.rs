//! The environment of a scene file, and how it is turned and scaled.

use super::super::environment::{EnvironmentEdit, extensions, is_name};
use super::keys::{Keys, Lines, Located, Text};
use crate::studio::ENVIRONMENT_NAMES;
use catoptric_core::error::SceneError;

/// The name of the environment: of a file, or a built-in one.
pub(super) fn read(source: Text<'_>, keys: &mut Keys<'_, '_>, lines: &mut Lines) -> Result<Option<String>, SceneError> {
    let Some(Located { begin, value }) = keys.string("environment")? else { return Ok(None) };
    if !is_name(&value) && !ENVIRONMENT_NAMES.contains(&value.as_str()) {
        let names = ENVIRONMENT_NAMES.join(", ");
        let problem = format!("`{value}`; must be a picture ({}), or one of: {names}", extensions());
        return Err(source.invalid(begin, "environment", problem));
    }
    lines.insert("environment".into(), source.line(begin));
    Ok(Some(value))
}

/// How it is turned and scaled.
pub(super) fn read_edit(
    source: Text<'_>,
    keys: &mut Keys<'_, '_>,
    lines: &mut Lines,
) -> Result<EnvironmentEdit, SceneError> {
    let mut within = |key: &'static str, allowed: std::ops::RangeInclusive<f64>| {
        let Some(Located { begin, value }) = keys.number(key)? else { return Ok(None) };
        if !allowed.contains(&value) {
            let problem = format!("{value}; allowed is {} to {}", allowed.start(), allowed.end());
            return Err(source.invalid(begin, key, problem));
        }
        lines.insert(key.into(), source.line(begin));
        Ok(Some(value))
    };
    let most_deg = EnvironmentEdit::MOST_ROTATION_DEG;
    Ok(EnvironmentEdit {
        rotation_deg: within("environment_rotation_deg", -most_deg..=most_deg)?,
        strength: within("environment_strength", 0.0..=EnvironmentEdit::MOST_STRENGTH)?,
    })
}
