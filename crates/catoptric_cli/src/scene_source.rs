//! From the word SCENE and the options about it to a model.

use crate::args::{ChoiceArgs, DrawArgs, EnvironmentArgs, PoseArgs, SceneArgs, Shadows, ThinGlass};
use crate::failure::Failure;
use crate::settings;
use catoptric::error::{RenderError, SceneError};
use catoptric::light::bodies::{bodies_meet, remarks_on_bodies};
use catoptric::light::visibility::{cast_shadows, cast_shadows_as, shadow_sky};
use catoptric::progress::Progress;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Model, PoseMemory, PoseOptions, Scene};
pub(crate) use catoptric_options::RoleWord;
use catoptric_scenes::import::LoadOptions;
use catoptric_scenes::{Lighting, builtin, hint_on_missing, import, thin_glass};
use clap::ArgMatches;
use std::path::Path;

/// The model that SCENE names, with the variant that is chosen and the environment that the options want. Files from
/// other programs that bring no light are lit by a studio if they have mirrors or glass, or roles are given.
pub(crate) fn load(
    scene: &Path,
    choice: &ChoiceArgs,
    options: &EnvironmentArgs,
    has_roles: bool,
) -> Result<Model, Failure> {
    let variant = choice.variant.as_deref();
    let loading = LoadOptions { variant, allow_outside: choice.allow_outside };
    if let Some(hint) = hint_on_missing(scene) {
        return Err(Failure::input(format!("{}: there is no such file; {hint}", scene.display())));
    }
    let mut model = match built_in(scene) {
        Some(_) if variant.is_some() => {
            return Err(Failure::input(format!("{}: --variant: built-in scenes have no variants", scene.display())));
        }
        Some(spec) => builtin::parse(spec)?,
        None => import::load_with(scene, loading).map_err(|error| match error {
            SceneError::Unknown { kind: "variant", .. } => {
                Failure::input(format!("{}: --variant: {error}", scene.display()))
            }
            error => error.into(),
        })?,
    };
    let is_own = built_in(scene).is_some() || scene.extension().is_some_and(|kind| kind == "toml");
    let (environment, edit) = (options.environment.as_deref(), options.edit());
    Lighting { environment, edit, is_own, has_roles }.apply(&mut model)?;
    settings::check(&model)?;
    Ok(model)
}

/// The built-in scene that a word names, with its parameters.
pub(crate) fn built_in(scene: &Path) -> Option<&str> {
    scene.to_str()?.strip_prefix("builtin:")
}

/// Makes what lets light pass without a volume solid, if that is wanted.
pub(crate) fn choose_glass(args: &DrawArgs, model: &mut Model) {
    if args.glass.thin_glass == Some(ThinGlass::Solid) {
        thin_glass(model).for_each(|lobes| lobes.is_thin = false);
    }
}

/// How glass without a volume is drawn, if there is any and the user has not chosen.
pub(crate) fn remark_on_glass(args: &DrawArgs, model: &mut Model) -> Option<String> {
    let count = thin_glass(model).count();
    (count > 0 && args.glass.thin_glass.is_none()).then(|| {
        let (materials, are) = if count == 1 { ("material has", "is") } else { ("materials have", "are") };
        format!(
            "{}: {count} transmitting {materials} no volume and {are} drawn as thin walls (--thin-glass solid draws \
             solid bodies, --thin-glass thin leaves this out)",
            model.name
        )
    })
}

/// Adds what is odd about bodies of glass and liquid to a model's warnings.
pub(crate) fn remark_on_bodies(model: &mut Model, scene: &Scene) {
    let name = model.name.clone();
    model.warnings.extend(remarks_on_bodies(scene).into_iter().map(|remark| format!("{name}: {remark}")));
}

/// A warning that bodies of glass or liquid meet and the method does not follow what lies on both sides of each.
pub(crate) fn remark_on_media(method: &str, scene: &Scene) -> Option<String> {
    (!["auto", "reference"].contains(&method) && bodies_meet(scene)).then(|| {
        format!(
            "`{method}`: bodies of glass or liquid touch, or one may lie within another; it refracts light at each as \
             if air were on the other side (only `render --method auto` and `reference` know better)"
        )
    })
}

/// Refuses a model of which something would not be drawn as its file says, if that is wanted.
pub(crate) fn check_strictly(args: &DrawArgs, model: &Model) -> Result<(), Failure> {
    match model.warnings.as_slice() {
        [first, rest @ ..] if args.strict => {
            let more = if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
            Err(Failure::input(format!("{}: {first}{more}; --strict refuses such files", model.name)))
        }
        _ => Ok(()),
    }
}

/// The scene at one moment, with shadows of its lights if wanted. Of another moment, if that is given with what its
/// pose was made of, all is used that holds.
pub(crate) fn pose(
    model: &Model,
    time: f32,
    roles: &[RoleRule],
    shadows: Shadows,
    before: Option<(&Scene, &mut PoseMemory)>,
    progress: &dyn Progress,
) -> Result<Scene, Failure> {
    let options = PoseOptions { time, roles: roles.to_vec(), ..PoseOptions::default() };
    let (before, posed) = match before {
        Some((before, memory)) => (Some(before), model.pose_again(&options, memory)),
        None => (None, model.pose(&options)),
    };
    let posed = posed.map_err(|error| match error {
        // The one message that does not name its scene.
        SceneError::Unknown { ref name, .. } => {
            let remedy = match () {
                () if name.contains(',') => "; for several give the option several times",
                () if name.contains(':') => "; an index of refraction after a colon is a number, such as 1.5",
                () => "",
            };
            Failure::input(format!("{}: {error}{remedy}", model.name))
        }
        error => error.into(),
    });
    let mut scene = posed?;
    if let Some(bounces) = shadows.bounces() {
        match before {
            Some(before) => cast_shadows_as(before, &mut scene),
            None => cast_shadows(&mut scene),
        }
        shadow_sky(&mut scene, bounces, progress).map_err(RenderError::from)?;
    }
    Ok(scene)
}

/// The roles given on the command line.
pub(crate) fn roles(args: &SceneArgs, options: &ArgMatches) -> Result<Vec<RoleRule>, Failure> {
    rules(&role_words(args, options))
}

/// The roles given on the command line, in the order in which they stand there: later ones win.
pub(crate) fn role_words(args: &SceneArgs, options: &ArgMatches) -> Vec<RoleWord> {
    catoptric_options::role_words(&args.reflector, &args.pose, options)
}

/// The parameters that the words stand for.
pub(crate) fn rules(words: &[RoleWord]) -> Result<Vec<RoleRule>, Failure> {
    catoptric_options::rules(words).map_err(Failure::usage)
}

/// The same without `--reflector`, for commands in which it names no role.
pub(crate) fn pose_roles(args: &PoseArgs, options: &ArgMatches) -> Result<Vec<RoleRule>, Failure> {
    rules(&catoptric_options::role_words(&[], args, options))
}

/// Leaves the animation of `--animation` alone in the model and returns the index that it had, if one is named.
pub(crate) fn choose_animation(choice: &ChoiceArgs, model: &mut Model) -> Result<Option<usize>, Failure> {
    let Some(wanted) = choice.animation.as_deref() else { return Ok(None) };
    let index = model
        .animation_index(wanted)
        .map_err(|error| Failure::input(format!("{}: --animation: {error}", model.name)))?;
    let chosen = model.animations.swap_remove(index);
    model.animations = vec![chosen];
    Ok(Some(index))
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
