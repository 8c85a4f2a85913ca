//! `--baked FILE`: what was precomputed, for the method that it was precomputed for.

use crate::failure::Failure;
use catoptric::methods::bake::Baked;
use catoptric::methods::{MethodInfo, Quality};
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
    /// The time of opening them, in milliseconds.
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

    /// Checks that each is of one of these methods.
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

    /// The bake of a method that fits the scene and its settings. Where there are bakes of the method, one must.
    pub(crate) fn fitting(
        &self,
        method: &MethodInfo,
        settings: &Table,
        scene: &Scene,
        quality: Quality,
    ) -> Result<Option<Arc<dyn Baked>>, Failure> {
        if self.of(method).next().is_none() {
            return Ok(None);
        }
        let bake = MethodBake::new(method, settings, scene, quality)?;
        let mut problem = None;
        for (name, file) in self.of(method) {
            match bake.check(file, name) {
                Ok(()) => return Ok(Some(file.clone())),
                Err(error) => problem = problem.or(Some(error)),
            }
        }
        problem.map_or(Ok(None), |error| Err(error.into()))
    }
}
