//! `--baked FILE`: what was precomputed, for the method that it was precomputed for.

use crate::failure::Failure;
use catoptric::methods::{MethodInfo, Quality, ReflectionMethod};
use catoptric::scene::Scene;
use catoptric_bake::{BakedFile, MethodBake};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use toml::Table;

/// Open bakes.
#[derive(Default)]
pub(crate) struct Bakes {
    files: Vec<(String, Arc<BakedFile>)>,
    /// How long opening them took.
    pub(crate) open_ms: f64,
}

impl Bakes {
    /// Opens files, and checks them whole.
    pub(crate) fn open(paths: &[PathBuf]) -> Result<Self, Failure> {
        let start = Instant::now();
        let open = |path: &PathBuf| Ok((path.display().to_string(), Arc::new(BakedFile::open(path)?)));
        let files = paths.iter().map(open).collect::<Result<_, Failure>>()?;
        let open_ms = if paths.is_empty() { 0.0 } else { start.elapsed().as_secs_f64() * 1e3 };
        Ok(Self { files, open_ms })
    }

    /// Whether each is of one of these methods.
    pub(crate) fn check_methods(&self, methods: &[&str]) -> Result<(), Failure> {
        for (name, file) in &self.files {
            let method = file.identity().method.as_str();
            if !methods.contains(&method) {
                let asked = methods.join(", ");
                return Err(Failure::input(format!("--baked {name}: is a bake of {method}, not of {asked}")));
            }
        }
        Ok(())
    }

    fn of(&self, method: &MethodInfo) -> impl Iterator<Item = &(String, Arc<BakedFile>)> {
        self.files.iter().filter(|(_, file)| file.identity().method == method.id)
    }

    /// The settings given, and those of the method's first bake that are not.
    pub(crate) fn settings(&self, method: &MethodInfo, given: Table) -> Result<Table, Failure> {
        match self.of(method).next() {
            Some((_, file)) => file.settings_for(method, &given).map_err(Failure::usage),
            None => Ok(given),
        }
    }

    /// Gives a method the bake that fits the scene and its settings. Where there are bakes of the method, one must.
    pub(crate) fn give(
        &self,
        method: &mut dyn ReflectionMethod,
        settings: &Table,
        scene: &Scene,
        quality: Quality,
    ) -> Result<(), Failure> {
        let info = method.info();
        let mut problem = None;
        if self.of(info).next().is_some() {
            let bake = MethodBake::new(info, settings, scene, quality)?;
            for (name, file) in self.of(info) {
                match bake.check(file, name) {
                    Ok(()) => return Ok(method.take_bake(file.clone())?),
                    Err(error) => problem = problem.or(Some(error)),
                }
            }
        }
        problem.map_or(Ok(()), |error| Err(error.into()))
    }
}
