//! A user's wishes over a scene's files, its light and glass, and what may be meant by a name without a file.

use crate::import::{EnvironmentEdit, load_environment};
use crate::{builtin, light_if_dark};
use catoptric_core::error::SceneError;
use catoptric_core::scene::{Lobes, Model};
use std::path::Path;
use std::sync::Arc;

/// The light from infinity that is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Lighting<'a> {
    /// In place of the scene's own: a name or a picture, as `--environment` takes them.
    pub environment: Option<&'a Path>,
    /// How it is turned and scaled.
    pub edit: EnvironmentEdit,
    /// The scene is of this project (`.toml`, built-in): where such are dark they are meant to be. Others are lit by
    /// a studio if they have mirrors or glass.
    pub is_own: bool,
    /// Something is given a role, so that there will be mirrors or glass.
    pub has_roles: bool,
}

impl Lighting<'_> {
    /// Lights a model.
    ///
    /// # Errors
    /// [`SceneError`] for environments that cannot be read, and when there is none to be turned or scaled.
    pub fn apply(&self, model: &mut Model) -> Result<(), SceneError> {
        if let Some(path) = self.environment {
            model.environment = Some(Arc::new(load_environment(path, &mut model.warnings)?));
        }
        if !self.is_own {
            light_if_dark(model, self.has_roles);
        }
        if self.edit.apply(model) {
            return Ok(());
        }
        let option = if self.edit.rotation_deg.is_some() { "rotation" } else { "strength" };
        let problem = "the scene has no environment; give one by --environment";
        Err(SceneError::invalid(&model.name, format!("--environment-{option}"), problem))
    }
}

/// The lobes of what lets light pass and has no volume: drawn as walls without thickness while `is_thin` is set.
pub fn thin_glass(model: &mut Model) -> impl Iterator<Item = &mut Lobes> {
    let lobes = model.materials.iter_mut().filter_map(|material| material.lobes.as_deref_mut());
    lobes.filter(|lobes| lobes.is_thin && lobes.transmission > 0.0)
}

/// A hint at the meaning of a word that names no file; `None` for files that are there, and where there is none.
pub fn hint_on_missing(scene: &Path) -> Option<String> {
    let word = scene.to_str().filter(|_| !scene.exists())?;
    if ["http://", "https://", "ftp://"].iter().any(|scheme| word.starts_with(scheme)) {
        return Some("addresses are not opened: download the file first".into());
    }
    let name = word.split('?').next().unwrap_or(word);
    builtin::all().iter().any(|info| info.name == name).then(|| format!("did you mean builtin:{word}?"))
}
