//! The recipe of a plan: how its work is made again, on this machine or another.

use crate::args::{BakeWhatArgs, ChoiceArgs, EnvironmentArgs, Shadows};
use crate::drawing::Moment;
use crate::failure::{self, Failure};
use crate::scene_source::{self, RoleWord};
use crate::settings;
use catoptric::methods::lookup::light_field::{LightFieldSettings, views_manifest};
use catoptric::methods::{self, Quality, Settings};
use catoptric::progress::Progress;
use catoptric::scene::{Model, Scene};
use catoptric_bake::{MethodBake, Plan};
use catoptric_scenes::ENVIRONMENT_NAMES;
use clap::ArgMatches;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Table;
use toml::de::DeTable;

/// A scene, a method and its settings, as the command line gave them.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Recipe {
    /// Files by their whole paths: machines that share a bake's folder need them there, too.
    scene: String,
    environment: Option<PathBuf>,
    /// Plans of before environments could be turned and scaled have neither.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    environment_rotation: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    environment_strength: Option<f64>,
    roles: Vec<RoleWord>,
    time: f32,
    /// Older plans have none.
    #[serde(default)]
    choice: ChoiceArgs,
    /// Plans of before there were shadows have none.
    #[serde(default)]
    shadows: bool,
    /// Surfaces scatter light onto each other.
    #[serde(default)]
    bounces: bool,
    method: String,
    /// The settings given, over the scene's own.
    settings: Table,
    order: u32,
}

/// The scene and work of a recipe.
pub(super) struct Ingredients {
    pub(super) scene: Scene,
    settings: Table,
    method: &'static methods::MethodInfo,
    quality: Quality,
}

impl Recipe {
    pub(super) fn new(args: &BakeWhatArgs, options: &ArgMatches) -> Result<Self, Failure> {
        let info = methods::find(&args.method).map_err(Failure::usage)?;
        let mut settings = match &args.config {
            Some(path) => read_settings(path, info)?,
            None => Table::new(),
        };
        settings.extend(args.set.iter().map(|(key, text)| (key.clone(), settings::value(text))));
        let scene = match scene_source::built_in(&args.scene.scene) {
            Some(_) => args.scene.scene.clone(),
            None => whole(&args.scene.scene),
        };
        let Ok(scene) = scene.into_os_string().into_string() else {
            let problem = "the plan of a bake holds names of Unicode letters alone; rename the file";
            return Err(Failure::input(format!("{}: {problem}", args.scene.scene.display())));
        };
        let light = &args.scene.environment;
        let is_built_in = |path: &Path| ENVIRONMENT_NAMES.iter().any(|name| path.as_os_str() == *name);
        Ok(Self {
            scene,
            environment: light.environment.as_deref().map(|path| match is_built_in(path) {
                true => path.into(),
                false => whole(path),
            }),
            environment_rotation: light.environment_rotation,
            environment_strength: light.environment_strength,
            roles: scene_source::role_words(&args.scene, options),
            time: args.scene.pose.time,
            choice: args.scene.pose.choice.clone(),
            shadows: args.scene.shadows != Shadows::Off,
            bounces: args.scene.shadows == Shadows::On,
            method: args.method.clone(),
            settings,
            order: args.order,
        })
    }

    /// Loads the model, with what it is posed by.
    pub(super) fn model(&self) -> Result<(Model, Moment), Failure> {
        let roles = scene_source::rules(&self.roles)?;
        let environment = EnvironmentArgs {
            environment: self.environment.clone(),
            environment_rotation: self.environment_rotation,
            environment_strength: self.environment_strength,
        };
        let mut model = scene_source::load(Path::new(&self.scene), &self.choice, &environment, !roles.is_empty())?;
        scene_source::choose_animation(&self.choice, &mut model)?;
        let shadows = match (self.shadows, self.bounces) {
            (true, true) => Shadows::On,
            (true, false) => Shadows::Direct,
            (false, _) => Shadows::Off,
        };
        Ok((model, (roles, shadows, self.time)))
    }

    /// The method, the settings that were given, and the highest order of paths.
    pub(super) fn method(&self) -> (&str, &Table, u32) {
        (&self.method, &self.settings, self.order)
    }

    /// Loads the scene.
    pub(super) fn ingredients(&self, progress: &dyn Progress) -> Result<Ingredients, Failure> {
        let (model, (roles, shadows, time)) = self.model()?;
        let scene = scene_source::pose(&model, time, &roles, shadows, None, progress)?;
        let chosen = settings::choose(&self.method, &model, &self.settings)?;
        let quality = Quality { samples: 1, order: self.order };
        Ok(Ingredients { scene, settings: chosen.settings, method: chosen.info, quality })
    }
}

impl Ingredients {
    pub(super) fn bake(&self) -> Result<MethodBake<'_>, Failure> {
        MethodBake::new(self.method, &self.settings, &self.scene, self.quality)
            .map_err(|error| Failure::input(format!("{}: {error}", self.scene.name)))
    }

    /// The manifest of views that another renderer is to make.
    pub(super) fn views_manifest(&self) -> Result<String, Failure> {
        if self.method.id != LightFieldSettings::METHOD {
            return Err(Failure::usage(format!("--method {}: only light_field takes views", self.method.id)));
        }
        let settings = LightFieldSettings::from_table(&self.settings)?;
        views_manifest(&settings, &self.scene).map_err(|error| Failure::input(format!("{}: {error}", self.scene.name)))
    }
}

fn read_settings(path: &Path, info: &methods::MethodInfo) -> Result<Table, Failure> {
    let fail = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
    let text = failure::read_text(path)?;
    let line = |byte: usize| text.as_bytes()[..byte].iter().filter(|byte| **byte == b'\n').count() + 1;
    let document = DeTable::parse(&text).map_err(|error| {
        let begin = error.span().map_or(0, |span| span.start.min(text.len()));
        fail(format!("line {}: {}", line(begin), error.message()))
    })?;
    let table: Table = toml::from_str(&text).map_err(|error| fail(error.message().into()))?;
    let Some((key, problem)) = settings::fault(info, &table) else { return Ok(table) };
    let place = key.and_then(|key| document.get_ref().keys().find(|found| *found.get_ref() == *key));
    Err(fail(
        place.map_or(problem.clone(), |key| format!("line {}: {}: {problem}", line(key.span().start), key.get_ref())),
    ))
}

/// The whole path of a file.
pub(super) fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

/// The recipe of a plan, which was read from `file`: that of a bake or of frames.
pub(super) fn read_recipe<R: DeserializeOwned>(plan: &Plan, file: &str) -> Result<R, Failure> {
    let problem = "its recipe is damaged, or of another version of this program; plan again in another folder";
    serde_json::from_value(plan.recipe.clone()).map_err(|_| Failure::input(format!("{file}: {problem}")))
}
