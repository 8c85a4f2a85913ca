//! Bakes that were opened, for the methods that they were made for.

use super::order::Drawn;
use catoptric::error::RenderError;
use catoptric::methods::bake::Baked;
use catoptric::methods::{self, Quality};
use catoptric::scene::Scene;
use catoptric_bake::{BakeError, BakedFile, MethodBake};
use std::path::Path;
use std::sync::Arc;
use toml::Table;

/// Open bakes, the newest first.
#[derive(Default)]
pub(super) struct Bakes {
    files: Vec<(String, Arc<BakedFile>)>,
}

/// What a method is prepared with.
pub(super) struct Recipe {
    /// The settings given, over those of the bake.
    pub(super) settings: Table,
    /// What was precomputed.
    pub(super) bake: Option<Arc<dyn Baked>>,
    /// Why an open bake is not used.
    pub(super) remark: Option<String>,
}

impl Bakes {
    /// Opens a bake, which is checked whole, and returns its method's id.
    ///
    /// # Errors
    /// As [`BakedFile::open`].
    pub(super) fn open(&mut self, path: &Path) -> Result<String, BakeError> {
        let (name, file) = (path.display().to_string(), BakedFile::open(path)?);
        let method = file.identity().method.clone();
        self.files.retain(|(known, _)| *known != name);
        self.files.insert(0, (name, Arc::new(file)));
        Ok(method)
    }

    /// True if there are bakes of a method: whether one fits is to be seen for each scene.
    pub(super) fn has(&self, method: &str) -> bool {
        self.files.iter().any(|(_, file)| file.identity().method == method)
    }

    /// What a method is prepared with for a scene: the newest bake that fits, if there is one.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for settings that are not allowed.
    pub(super) fn recipe(&self, drawn: &Drawn, scene: &Scene, quality: Quality) -> Result<Recipe, RenderError> {
        let info = methods::find(&drawn.method)?;
        let mut remark = None;
        for (name, file) in self.files.iter().filter(|(_, file)| file.identity().method == info.id) {
            let settings = file.settings_for(info, &drawn.settings)?;
            let problem = match MethodBake::new(info, &settings, scene, quality) {
                Ok(asked) => match asked.check(file, name) {
                    Ok(()) => return Ok(Recipe { settings, bake: Some(file.clone()), remark: None }),
                    Err(problem) => problem.to_string(),
                },
                Err(problem) => format!("{name}: {problem}"),
            };
            remark.get_or_insert(problem);
        }
        Ok(Recipe { settings: drawn.settings.clone(), bake: None, remark })
    }
}
