//! Blends of mirrors: keys of `[[reflector]]`, and of the tables `[blend."NAME or glob"]`.

use super::super::blend::{AttenuationKeys, BlendKeys};
use super::super::key_error::KeyError;
use super::keys::{Keys, Lines, Text};
use catoptric_core::error::SceneError;
use catoptric_core::scene::roles::BlendRule;

/// The spans of keys in the text, if they were given.
pub(super) type Begins = Vec<(&'static str, Option<usize>)>;

/// Takes the keys from a table.
pub(super) fn take(table: &mut Keys<'_, '_>) -> Result<(BlendKeys, Begins), SceneError> {
    let fresnel = table.numbers("fresnel")?;
    let attenuation = table.table("attenuation")?;
    let diffuse = table.numbers("diffuse")?;
    let highlight_roughness = table.number("highlight_roughness")?;
    let mut begins = vec![
        ("fresnel", fresnel.map(|at| at.begin)),
        ("diffuse", diffuse.map(|at| at.begin)),
        ("highlight_roughness", highlight_roughness.map(|at| at.begin)),
    ];
    let attenuation = match attenuation {
        Some(mut inner) => {
            let (begin, distance, specularity) =
                (inner.begin(), inner.number("distance")?, inner.numbers("specularity")?);
            inner.finish()?;
            // Missing keys are missing in the inner table.
            let within = |at: Option<usize>| Some(at.unwrap_or(begin));
            begins.extend([
                ("attenuation", Some(begin)),
                ("attenuation.distance", within(distance.map(|at| at.begin))),
                ("attenuation.specularity", within(specularity.map(|at| at.begin))),
            ]);
            let (distance, specularity) = (distance.map(|at| at.value), specularity.map(|at| at.value));
            Some(AttenuationKeys { distance, specularity })
        }
        None => None,
    };
    let (fresnel, diffuse) = (fresnel.map(|at| at.value), diffuse.map(|at| at.value));
    let highlight_roughness = highlight_roughness.map(|at| at.value);
    Ok((BlendKeys { fresnel, attenuation, diffuse, highlight_roughness }, begins))
}

/// The error about a key, at its place in the text; at the table's, where it was not given.
pub(super) fn explain(text: Text<'_>, table: &Keys<'_, '_>, begins: &Begins, error: KeyError) -> SceneError {
    match begins.iter().find(|(key, _)| *key == error.key) {
        Some((_, Some(begin))) => text.invalid(*begin, &table.field(error.key), error.problem),
        _ => table.missing(error.key, error.problem),
    }
}

/// The tables `[blend."NAME or glob"]`.
pub(super) fn read_rules(
    source: Text<'_>,
    keys: &mut Keys<'_, '_>,
    lines: &mut Lines,
) -> Result<Vec<BlendRule>, SceneError> {
    let Some(tables) = keys.table("blend")? else { return Ok(Vec::new()) };
    let mut rules = Vec::new();
    for (pattern, begin, value) in tables.rest() {
        let field = format!("blend.{pattern}");
        lines.insert(field.clone(), source.line(begin));
        let mut table = Keys::of_value(source, &field, value)?;
        let (given, begins) = take(&mut table)?;
        let blend = given.blend().map_err(|error| explain(source, &table, &begins, error))?;
        table.finish()?;
        let missing = || {
            source.invalid(begin, &field, "says nothing; needed is `fresnel`, `attenuation` or `highlight_roughness`")
        };
        let rule = BlendRule::new(&pattern, blend.ok_or_else(missing)?);
        rules.push(rule.map_err(|error| source.invalid(begin, &field, error.to_string()))?);
    }
    Ok(rules)
}
