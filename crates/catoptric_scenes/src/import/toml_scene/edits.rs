//! Changes that a file makes by name: the tables `[move]` and `[material."NAME or glob"]`.

use super::keys::{Keys, Lines, Located, Text};
use super::places::point;
use catoptric_core::error::SceneError;
use catoptric_core::scene::edits::{Look, LookRule, MoveRule};
use glam::Vec3;

/// The table `[move]`: ways in the world by names of nodes.
pub(super) fn read_moves(
    source: Text<'_>,
    keys: &mut Keys<'_, '_>,
    lines: &mut Lines,
) -> Result<Vec<MoveRule>, SceneError> {
    let Some(table) = keys.table("move")? else { return Ok(Vec::new()) };
    let mut rules = Vec::new();
    for (pattern, begin, value) in table.rest() {
        let field = format!("move.{pattern}");
        lines.insert(field.clone(), source.line(begin));
        let wrong = || source.invalid(begin, &field, "must be a way, such as [0, 0.5, 0]");
        let value = Keys::numbers_of(value).ok_or_else(wrong)?;
        let by = point(source, &field, Located { begin, value })?;
        rules.push(MoveRule::new(&pattern, by).map_err(|error| source.invalid(begin, &field, error.to_string()))?);
    }
    Ok(rules)
}

/// The tables `[material."NAME or glob"]`: looks by names of nodes or materials.
pub(super) fn read_looks(
    source: Text<'_>,
    keys: &mut Keys<'_, '_>,
    lines: &mut Lines,
) -> Result<Vec<LookRule>, SceneError> {
    let Some(tables) = keys.table("material")? else { return Ok(Vec::new()) };
    let mut rules = Vec::new();
    for (pattern, begin, value) in tables.rest() {
        let field = format!("material.{pattern}");
        lines.insert(field.clone(), source.line(begin));
        let mut table = Keys::of_value(source, &field, value)?;
        let color = table.numbers("color")?.map(|at| Vec3::from(at.value.map(|number: f64| number as f32)));
        let number = |at: Option<Located<f64>>| at.map(|at| at.value as f32);
        let (roughness, ior) = (number(table.number("roughness")?), number(table.number("ior")?));
        let priority = match table.number("priority")? {
            Some(at) if at.value.fract() == 0.0 && at.value.abs() <= 1000.0 => Some(at.value as i32),
            Some(_) => return Err(source.invalid(begin, &field, "`priority` must be a whole number up to 1000")),
            None => None,
        };
        table.finish()?;
        let look = Look { color, roughness, ior, priority };
        if look == Look::default() {
            return Err(source.invalid(
                begin,
                &field,
                "says nothing; needed is `color`, `roughness`, `ior` or `priority`",
            ));
        }
        rules.push(LookRule::new(&pattern, look).map_err(|error| source.invalid(begin, &field, error.to_string()))?);
    }
    Ok(rules)
}
