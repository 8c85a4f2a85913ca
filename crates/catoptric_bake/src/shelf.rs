//! Open bakes, and the choice of the one that fits a scene.

use crate::container::BakedFile;
use crate::error::BakeError;
use crate::methods::MethodBake;
use catoptric::error::RenderError;
use catoptric::methods::bake::Baked;
use catoptric::methods::{MethodInfo, Quality};
use catoptric::scene::Scene;
use std::path::Path;
use std::sync::Arc;
use toml::Table;

/// Open baked files of any methods, in the order in which they are tried.
#[derive(Default)]
pub struct Shelf {
    files: Vec<(String, Arc<BakedFile>)>,
}

/// The settings and the bake that a method is to be prepared with.
pub struct BakeChoice {
    /// The settings given, over those of the chosen bake.
    pub settings: Table,
    /// The open bake; `None` where none fits, or there is none of the method.
    pub bake: Option<Arc<dyn Baked>>,
    /// Where there are bakes of the method and none fits: why the first one does not.
    pub problem: Option<Unfit>,
}

/// The reason why a bake cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum Unfit {
    /// With its settings nothing can be baked for the scene.
    #[error("{file}: {source}")]
    Nothing {
        /// The file.
        file: String,
        /// The method's message.
        source: RenderError,
    },
    /// The bake is of another scene, or of other settings.
    #[error(transparent)]
    Other(BakeError),
}

impl Shelf {
    /// Opens a file, which is checked whole, before all others. One that was opened already is read again.
    ///
    /// # Errors
    /// As [`BakedFile::open`].
    pub fn open(&mut self, path: &Path) -> Result<&BakedFile, BakeError> {
        let (name, file) = (path.display().to_string(), BakedFile::open(path)?);
        self.files.retain(|(known, _)| *known != name);
        self.files.insert(0, (name, Arc::new(file)));
        Ok(&self.files[0].1)
    }

    /// The files' names and contents.
    pub fn files(&self) -> impl Iterator<Item = (&str, &BakedFile)> {
        self.files.iter().map(|(name, file)| (name.as_str(), &**file))
    }

    /// True if there are bakes of the method with this id: whether one fits is another question for each scene.
    pub fn has(&self, method: &str) -> bool {
        self.files().any(|(_, file)| file.identity().method == method)
    }

    /// The first bake of a method that fits a scene with the settings given, those that are not being its own.
    ///
    /// # Errors
    /// [`RenderError::Setting`] for given settings that are not allowed.
    pub fn choose(
        &self,
        method: &MethodInfo,
        given: &Table,
        scene: &Scene,
        quality: Quality,
    ) -> Result<BakeChoice, RenderError> {
        let mut first_problem = None;
        for (name, file) in self.files.iter().filter(|(_, file)| file.identity().method == method.id) {
            let settings = file.settings_for(method, given)?;
            let problem = match MethodBake::new(method, &settings, scene, quality) {
                Ok(asked) => match asked.check(file, name) {
                    Ok(()) => return Ok(BakeChoice { settings, bake: Some(file.clone()), problem: None }),
                    Err(other) => Unfit::Other(other),
                },
                Err(source) => Unfit::Nothing { file: name.clone(), source },
            };
            first_problem.get_or_insert(problem);
        }
        Ok(BakeChoice { settings: given.clone(), bake: None, problem: first_problem })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LocalStore, RunOptions, merge, run};
    use catoptric::methods;
    use catoptric_scenes::builtin;

    #[test]
    fn the_first_that_fits_is_chosen() {
        let scene = builtin::parse("sphere_room?tess=8").unwrap().pose(&Default::default()).unwrap();
        let (method, quality) = (methods::find("light_field").unwrap(), Quality { samples: 1, order: 1 });
        let table = |text: &str| -> Table { toml::from_str(text).unwrap() };
        let folder = tempfile::tempdir().unwrap();
        let mut shelf = Shelf::default();
        for [st, uv] in [[2, 8], [3, 8], [3, 4]] {
            let settings = table(&format!("st = {st}\nuv = {uv}"));
            let bake = MethodBake::new(method, &settings, &scene, quality).unwrap();
            let (plan, units) = bake.plan(serde_json::Value::Null).unwrap();
            let store = LocalStore::create_folder(folder.path().join(format!("{st}_{uv}"))).unwrap();
            run(&plan, &store, &units, &RunOptions::default()).unwrap();
            let file = folder.path().join(format!("{st}_{uv}.bake"));
            merge(&plan, &store, &file).unwrap();
            shelf.open(&file).unwrap();
        }
        assert!(shelf.has("light_field") && !shelf.has("auto"));
        let chosen = |given: &str, scene: &Scene| {
            let choice = shelf.choose(method, &table(given), scene, quality).unwrap();
            assert_eq!(choice.bake.is_some(), choice.problem.is_none());
            let problem = choice.problem.map(|problem| problem.to_string()).unwrap_or_default();
            (["st", "uv"].map(|key| choice.settings.get(key).and_then(toml::Value::as_integer)), problem)
        };
        // The last one opened counts first; what is given leads to another.
        assert_eq!(chosen("", &scene).0, [Some(3), Some(4)]);
        assert_eq!(chosen("uv = 8", &scene).0, [Some(3), Some(8)]);
        assert_eq!(chosen("st = 2", &scene).0, [Some(2), Some(8)]);
        let (settings, problem) = chosen("st = 4", &scene);
        assert!(
            settings == [Some(4), None] && problem.contains("3_4.bake") && problem.contains("st is 3"),
            "{problem}"
        );
        let (_, problem) = chosen("", &Scene::default());
        assert!(problem.contains("3_4.bake") && problem.contains("nothing to bake"), "{problem}");
        assert!(shelf.choose(method, &table("sd = 3"), &scene, quality).is_err());
        assert_eq!(
            shelf.choose(methods::find("auto").unwrap(), &Table::new(), &scene, quality).unwrap().settings.len(),
            0
        );
    }
}
