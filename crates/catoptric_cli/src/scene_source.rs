//! From the word SCENE and the options about it to a model.

use crate::args::SceneArgs;
use crate::failure::Failure;
use catoptric::error::SceneError;
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Model, PoseOptions, Role, Scene, builtin, import};
use clap::ArgMatches;
use std::path::Path;
use std::sync::Arc;

/// The model that SCENE names, with the environment asked for.
pub(crate) fn load(args: &SceneArgs) -> Result<Model, SceneError> {
    let mut model = match args.scene.strip_prefix("builtin:") {
        Some(spec) => builtin::parse(spec)?,
        None => import::load(Path::new(&args.scene))?,
    };
    if let Some(path) = &args.environment {
        model.environment = Some(Arc::new(import::load_environment(path)?));
    }
    Ok(model)
}

/// The scene at one moment.
pub(crate) fn pose(model: &Model, time: f32, roles: &[RoleRule]) -> Result<Scene, Failure> {
    model.pose(&PoseOptions { time, roles: roles.to_vec() }).map_err(|error| match error {
        // The one message that does not say which scene it is about.
        SceneError::Unknown { .. } => Failure::input(format!("{}: {error}", model.name)),
        error => error.into(),
    })
}

/// The roles given on the command line, in the order in which they stand there: later ones win.
pub(crate) fn roles(args: &SceneArgs, options: &ArgMatches) -> Result<Vec<RoleRule>, Failure> {
    let mut rules: Vec<(usize, RoleRule)> = Vec::new();
    for (name, patterns) in [("reflector", &args.reflector), ("lens", &args.lens), ("diffuse", &args.diffuse)] {
        let places = options.indices_of(name).into_iter().flatten();
        for (place, pattern) in places.zip(patterns) {
            let rule = match name {
                "reflector" => RoleRule::new(pattern, Role::Reflector, None),
                "lens" => RoleRule::parse_lens(pattern),
                _ => RoleRule::new(pattern, Role::Diffuse, None),
            };
            rules.push((place, rule.map_err(|error| Failure::usage(format!("--{name}: {error}")))?));
        }
    }
    rules.sort_by_key(|(place, _)| *place);
    Ok(rules.into_iter().map(|(_, rule)| rule).collect())
}
