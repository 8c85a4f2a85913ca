//! The animation that plays, and its time.

use crate::args::ChoiceArgs;
use crate::failure::Failure;
use catoptric::error::SceneError;
use catoptric::scene::Model;

/// Leaves the animation of `--animation` alone in the model and returns the index that it had, if one is named.
pub(crate) fn choose_animation(choice: &ChoiceArgs, model: &mut Model) -> Result<Option<usize>, Failure> {
    let Some(wanted) = choice.animation.as_deref() else { return Ok(None) };
    let index = find(model, wanted).map_err(|error| Failure::input(format!("{}: --animation: {error}", model.name)))?;
    let chosen = model.animations.swap_remove(index);
    model.animations = vec![chosen];
    Ok(Some(index))
}

/// The animation of this name, else of this index.
fn find(model: &Model, wanted: &str) -> Result<usize, SceneError> {
    let names = || model.animations.iter().map(|animation| animation.name.as_str());
    let named = names().position(|name| name == wanted && !name.is_empty());
    let by_index = || wanted.parse().ok().filter(|index| *index < model.animations.len());
    named.or_else(by_index).ok_or_else(|| {
        let listed: Vec<String> = names().enumerate().map(|(index, name)| format!("{index} `{name}`")).collect();
        let listed = if listed.is_empty() { "none in this scene".into() } else { listed.join(", ") };
        SceneError::unknown("animation", wanted, names(), listed)
    })
}

/// A remark on a time at which no animation moves.
pub(crate) fn remark_on_time(model: &Model, time: f32) -> Option<String> {
    let duration = model.duration();
    let name = &model.name;
    if model.animations.is_empty() {
        return (time != 0.0).then(|| format!("{name}: --time {time}: the scene has no animation"));
    }
    let held = if time < 0.0 { "first" } else { "last" };
    (time < 0.0 || time > duration).then(|| {
        format!(
            "{name}: --time {time}: the animation ends at {duration} s and does not repeat; it holds its {held} pose"
        )
    })
}
